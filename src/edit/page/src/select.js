// Choosing a plane: what it is, switching it, and how it lies.

import { element } from '../../../view/page/src/dom.js';
import { decimal, whole } from '../../../view/page/src/format.js';
import { lieOf } from './planes.js';
import { Tool, button, says } from './tool.js';

/** The plane under the pointer; -1 where none is. */
export function planeUnder({ places, state }, event) {
  const { building } = state;
  const [x, y] = places.inCanvas(event.clientX, event.clientY);
  const hit = places.itemAt(event.clientX, event.clientY, ['plane', 'result']);
  if (hit?.kind === 'plane') {
    return hit.item;
  }
  const point = state.layers.points ? places.pointAt(building, x, y, 5) : -1;
  const on = point >= 0 ? building.points.on[point] - 1 : -1;
  return on >= 0 ? on : hit ? building.planeNear(hit.place, hit.normal) : -1;
}

const tell = (building, i) => {
  const plane = building.planes[i];
  return [`${plane.kind} ${i + 1}`, `${whole(plane.points)} points, ${decimal(plane.tilt, 1)}° from the level`];
};

/** What can be done to the plane that is chosen; null where none is, or it cannot be. */
export function chosenPlane({ state }) {
  const plane = state.building?.planes[state.plane];
  return plane && plane.by !== 'revision' ? plane : null;
}

/** What keys and buttons do to the plane that is chosen. */
export const planeActions = {
  switch: (app) => {
    const plane = chosenPlane(app);
    return plane ? app.act({ 'switch-plane': { plane: plane.at, on: !plane.on } }) : app.tell(CHOOSE);
  },
  align: (app, lie) => {
    const plane = chosenPlane(app);
    return plane?.on ? app.act({ 'align-plane': { plane: plane.at, lie } }) : app.tell(CHOOSE);
  },
};

const CHOOSE = 'Choose a plane first: press S and click one.';

export class Select extends Tool {
  click(event) {
    this.app.state.set({ plane: planeUnder(this.app, event) });
  }

  hover(event) {
    const plane = planeUnder(this.app, event);
    return plane >= 0 ? tell(this.building, plane) : null;
  }

  cancel() {
    const isChosen = this.app.state.plane >= 0;
    this.app.state.set({ plane: -1 });
    return isChosen;
  }

  options() {
    const { app } = this;
    const { building, plane: i } = app.state;
    const plane = building?.planes[i];
    if (!plane) {
      return [says('Click a plane, a face or a point of one.')];
    }
    const { slope, azimuth } = lieOf(plane);
    const lies = slope < 0.05 ? 'level' : `${decimal(slope, 1)}°, falls to ${decimal(azimuth, 0)}°`;
    const rows = [
      ['points', whole(plane.points)],
      ['rms of its points', `${decimal(plane.rms, 3)} m`],
      ['area', `${decimal(plane.area, 1)} m²`],
      ['slope', lies],
    ];
    const title = element('h4', { id: 'plane-title' }, `${plane.kind} ${i + 1}${plane.on ? '' : ', switched off'}`);
    const figures = element(
      'dl',
      {},
      rows.flatMap(([name, value]) => [element('dt', {}, name), element('dd', {}, value)]),
    );
    if (plane.by === 'revision') {
      return [title, figures, says('The method added it to explain points that were left; it has no switch.')];
    }
    const does = [
      button(plane.on ? 'Switch off' : 'Switch on', 'X', 'The plane counts for nothing, or counts again', () =>
        planeActions.switch(app),
      ),
      button(
        'Level',
        'H',
        'Turn it about the middle of its points until it is level',
        () => planeActions.align(app, 'level'),
        { disabled: !plane.on },
      ),
      button('Vertical', 'V', 'Turn it until it stands', () => planeActions.align(app, 'vertical'), {
        disabled: !plane.on,
      }),
      button(
        'Parallel to…',
        'Y',
        'Turn it until it is parallel to another, which you click',
        () => app.choose('parallel'),
        { disabled: !plane.on },
      ),
      button('Move or turn', 'G', 'Move it along its normal, or turn it', () => app.choose('move'), {
        disabled: !plane.on,
      }),
    ];
    return [title, figures, element('div', { class: 'does' }, does)];
  }
}

/** Turns the chosen plane parallel to the one that is clicked. */
export class Parallel extends Tool {
  enter() {
    if (!chosenPlane(this.app)?.on) {
      this.app.tell(CHOOSE);
      this.app.choose('select');
    }
  }

  click(event) {
    const other = this.building.planes[planeUnder(this.app, event)];
    if (other && other !== chosenPlane(this.app)) {
      const [a, b, c] = other.at.equation;
      this.app.choose('select');
      planeActions.align(this.app, { parallel: [a, b, c] });
    }
  }

  hover(event) {
    const plane = planeUnder(this.app, event);
    return plane >= 0 && plane !== this.app.state.plane ? tell(this.building, plane) : null;
  }

  options() {
    return [says('Click the plane that the chosen one is to be parallel to.')];
  }
}
