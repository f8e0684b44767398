// Tools that change nothing: measuring, and the section.

import { element } from '../../../view/page/src/dom.js';
import { decimal } from '../../../view/page/src/format.js';
import { CHOSEN } from './colours.js';
import { dot } from './planes.js';
import { Tool, button, numberField, says } from './tool.js';

export class Measure extends Tool {
  constructor(app) {
    super(app);
    this.places = [];
  }

  leave() {
    this.places = [];
    this.draw();
  }

  draw(next) {
    const [a, b] = [this.places[0], this.places[1] ?? next];
    const corner = a && b ? [b[0], b[1], a[2]] : null;
    this.app.picture.drawLines('measured', corner ? [a, b] : [], CHOSEN, { width: 3, isHidden: true });
    this.app.picture.drawLines('measured-by', corner ? [a, corner, corner, b] : [], CHOSEN, {
      width: 1.5,
      isHidden: true,
      opacity: 0.7,
    });
    this.app.picture.drawPoints('measured-at', this.places, () => CHOSEN, 8, { isHidden: true });
  }

  click(event) {
    const place = this.app.places.placeAt(this.building, event.clientX, event.clientY);
    if (place) {
      this.places = this.places.length > 1 ? [place] : [...this.places, place];
      this.draw();
      this.app.showOptions();
    }
  }

  told(a, b) {
    const [flat, up] = [Math.hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2]];
    return [
      ['distance', `${decimal(Math.hypot(flat, up), 3)} m`],
      ['level', `${decimal(flat, 3)} m`],
      ['height', `${up > 0 ? '+' : ''}${decimal(up, 3)} m`],
      ['slope', `${decimal((Math.atan2(Math.abs(up), flat) * 180) / Math.PI, 1)}°`],
    ];
  }

  hover(event) {
    if (this.places.length !== 1) {
      return ['click a place', 'points are snapped to'];
    }
    const next = this.app.places.placeAt(this.building, event.clientX, event.clientY);
    this.draw(next);
    return next ? [this.told(this.places[0], next)[0][1], 'click the other end'] : null;
  }

  cancel() {
    const isAny = this.places.length > 0;
    this.leave();
    this.app.showOptions();
    return isAny;
  }

  options() {
    const [a, b] = this.places;
    if (!b) {
      return [says('Click two places: points, faces, or the floor.')];
    }
    const { frame } = this.building;
    const rows = [
      ...this.told(a, b),
      ['heights', [a, b].map((place) => decimal(frame.heightToCrs(place[2]), 2)).join(', ')],
    ];
    return [
      element(
        'dl',
        { id: 'measured' },
        rows.flatMap(([name, value]) => [element('dt', {}, name), element('dd', {}, value)]),
      ),
    ];
  }
}

/** Where the triangles of some faces meet a plane: pairs of places. */
export function profileOf({ positions, triangles }, { normal, offset }) {
  const pairs = [];
  const at = (corner) => [...positions.subarray(corner * 3, corner * 3 + 3)];
  for (let t = 0; t < triangles.length; t += 3) {
    const corners = [0, 1, 2].map((i) => at(triangles[t + i]));
    const far = corners.map((place) => dot(normal, place) + offset);
    const meets = [0, 1, 2].flatMap((i) => {
      const j = (i + 1) % 3;
      if (far[i] < 0 === far[j] < 0) {
        return [];
      }
      const share = far[i] / (far[i] - far[j]);
      return [corners[i].map((value, axis) => value + share * (corners[j][axis] - value))];
    });
    if (meets.length === 2) {
      pairs.push(...meets);
    }
  }
  return pairs;
}

/** Cuts away what lies before a plane, or all but a slab; it stays when another tool is chosen. */
export class Section extends Tool {
  enter() {
    if (this.building && !this.app.state.section) {
      this.along('across');
    }
  }

  leave() {
    this.from = null;
    this.app.picture.erase('section-line');
  }

  set(changes) {
    const { state } = this.app;
    const section = changes === null ? null : { normal: [0, 1, 0], at: 0, depth: 0, ...state.section, ...changes };
    state.set({ section });
  }

  /** Stands the section across the view, or along it, or lays it. */
  along(how) {
    const { camera } = this.app.picture;
    const ahead = camera.getWorldDirection(camera.position.clone());
    const length = Math.hypot(ahead.x, ahead.y) || 1;
    const flat = Math.hypot(ahead.x, ahead.y) < 0.02 ? [0, 1, 0] : [ahead.x / length, ahead.y / length, 0];
    const normal = { across: flat, along: [-flat[1], flat[0], 0], level: [0, 0, -1] }[how];
    const middle = how === 'level' ? -(this.building.low[2] + this.building.high[2]) / 2 : 0;
    this.set({ normal, at: middle });
    this.app.showOptions();
  }

  /** The keys H, V and Y: level, across the view, along it. */
  align(lie) {
    this.along({ level: 'level', vertical: 'across', parallel: 'along' }[lie]);
  }

  /** Moves the section by so many metres. */
  step(by) {
    const { section } = this.app.state;
    if (section) {
      this.set({ at: section.at + by });
      this.app.showOptions();
    }
  }

  click(event) {
    const place = this.app.places.placeAt(this.building, event.clientX, event.clientY);
    if (!place) {
      return;
    }
    if (!this.from) {
      this.from = place;
      return;
    }
    const [u, v] = [place[0] - this.from[0], place[1] - this.from[1]];
    const length = Math.hypot(u, v);
    if (length > 0.05) {
      // What stands before it, as it is looked at, is cut away.
      const { camera } = this.app.picture;
      const ahead = camera.getWorldDirection(camera.position.clone());
      const side = -v * ahead.x + u * ahead.y < 0 ? -1 : 1;
      const normal = [(-v * side) / length, (u * side) / length, 0];
      this.set({ normal, at: dot(normal, this.from) });
    }
    this.leave();
    this.app.showOptions();
  }

  hover(event) {
    if (this.from) {
      const next = this.app.places.placeAt(this.building, event.clientX, event.clientY);
      this.app.picture.drawLines('section-line', next ? [this.from, next] : [], CHOSEN, { width: 3, isHidden: true });
      return ['the other end of the section'];
    }
    return ['click two places', 'for a section through them'];
  }

  /** Looks straight at the section. */
  confirm() {
    const { section } = this.app.state;
    if (section) {
      this.app.station.face(section.normal.map((value) => -value));
    }
  }

  erase() {
    this.set(null);
    this.app.choose('select');
  }

  cancel() {
    const isAny = Boolean(this.from);
    this.leave();
    return isAny;
  }

  options() {
    const { section } = this.app.state;
    const { building } = this;
    if (!building || !section) {
      return [
        says('No section.'),
        element(
          'div',
          { class: 'does' },
          button('Section', 'C', 'A section across the view', () => this.along('across')),
        ),
      ];
    }
    const reach = Math.max(...building.high.map((value, axis) => value - building.low[axis])) * 0.75;
    const slider = (name, value, low, high, change, id) => {
      const input = element('input', {
        type: 'range',
        id,
        min: low,
        max: high,
        step: 0.05,
        value,
        oninput: () => this.set({ [change]: input.valueAsNumber }),
      });
      return element('label', { class: 'row slider' }, element('span', {}, name), input);
    };
    const { normal, at, depth } = section;
    return [
      element(
        'div',
        { class: 'does' },
        button('Across', 'V', 'Across the view', () => this.along('across')),
        button('Along', 'Y', 'Along the view', () => this.along('along')),
        button('Level', 'H', 'At one height', () => this.along('level')),
      ),
      slider('place', at, -reach, reach, 'at', 'section-at'),
      numberField('only a slab of', depth, 'm', (value) => this.set({ depth: Math.max(value, 0) }), {
        step: 0.5,
        min: 0,
        id: 'section-depth',
        title: '0: all that lies behind',
      }),
      element(
        'div',
        { class: 'does' },
        button('Look at it', 'Enter', 'Straight at the section', () => this.confirm()),
        button('Away', 'Del', 'Nothing is cut away any more', () => this.erase()),
      ),
    ];
  }
}

/** What a section cuts away: planes whose lower side is not shown. */
export function cutsOf(section) {
  if (!section) {
    return [];
  }
  const { normal, at, depth } = section;
  const front = { normal, offset: -at };
  return depth > 0 ? [front, { normal: normal.map((value) => -value), offset: at + depth }] : [front];
}
