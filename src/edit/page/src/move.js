// Moving a plane along its normal, and turning it about the middle of its points: by dragging and by numbers.

import { element, refill } from '../../../view/page/src/dom.js';
import { decimal } from '../../../view/page/src/format.js';
import { CHOSEN, FAR, signed } from './colours.js';
import { along, distance, hullOf, lieOf, middleOf, normalOf, onto, rmsOf, through } from './planes.js';
import { chosenPlane } from './select.js';
import { Tool, button, numberField, says } from './tool.js';

export class Move extends Tool {
  enter() {
    const plane = chosenPlane(this.app);
    if (!plane?.on) {
      this.app.tell('Choose a plane first: press S and click one.');
      this.app.choose('select');
      return;
    }
    const { building } = this;
    this.plane = plane;
    this.extent = building.extentOf(this.app.state.plane);
    this.own = building.pointsOn(this.app.state.plane).map((i) => building.pointAt(i));
    this.middle = onto(plane, middleOf(this.own.length > 0 ? this.own : this.extent));
    this.reset();
    this.draw();
  }

  reset() {
    const { slope, azimuth } = lieOf(this.plane);
    Object.assign(this, { by: 0, slope, azimuth, hasTurned: false });
  }

  leave() {
    this.app.picture.eraseRing('moved');
    this.app.picture.erase('moved-points');
    this.plane = null;
  }

  /** The plane as it would lie. */
  get moved() {
    const normal = this.hasTurned ? normalOf(this.slope, this.azimuth) : this.plane.normal;
    return through(along(this.middle, this.plane.normal, this.by), normal);
  }

  get hasChanged() {
    return this.by !== 0 || this.hasTurned;
  }

  draw() {
    const { moved, own, app } = this;
    const ring = hullOf(
      moved,
      this.extent.map((place) => onto(moved, place)),
    );
    app.picture.drawRing('moved', ring, CHOSEN, { opacity: 0.28 });
    const of = (i) => signed(Math.round((distance(moved, own[i]) / FAR) * 100) / 100);
    app.picture.drawPoints('moved-points', own, of, 5);
    if (this.told) {
      refill(this.told, this.figures());
    }
  }

  figures() {
    const rms = (plane) => `${decimal(rmsOf(plane, this.own), 3)} m`;
    return this.own.length > 0 ? `rms of its points: ${rms(this.plane)} → ${rms(this.moved)}` : 'It has no points.';
  }

  down(event) {
    if (!this.plane) {
      return false;
    }
    const [x, y] = this.app.places.inCanvas(event.clientX, event.clientY);
    this.from = { x, y, by: this.by, slope: this.slope, azimuth: this.azimuth };
    return true;
  }

  drag(event) {
    const [x, y] = this.app.places.inCanvas(event.clientX, event.clientY);
    const [right, down] = [x - this.from.x, y - this.from.y];
    if (event.shiftKey) {
      this.hasTurned = true;
      this.azimuth = (this.from.azimuth + right * 0.3 + 360) % 360;
      this.slope = Math.min(Math.max(this.from.slope + down * 0.15, 0), 90);
    } else {
      // A metre along the normal is so long in the picture.
      const [a, b] = [this.middle, along(this.middle, this.plane.normal, 1)].map((p) => this.app.places.onScreen(p));
      const [u, v] = [b[0] - a[0], b[1] - a[1]];
      const length = Math.max(u * u + v * v, 16);
      this.by = Math.round((this.from.by + (right * u + down * v) / length) * 100) / 100;
    }
    this.draw();
    this.app.showOptions();
  }

  hover() {
    return this.plane ? ['drag: along the normal', 'with Shift: turn'] : null;
  }

  confirm() {
    if (this.plane && this.hasChanged) {
      const { at } = this.plane;
      this.app.act({ 'move-plane': { plane: at, to: this.building.frame.planeToCrs(this.moved) } });
    }
  }

  cancel() {
    if (!this.plane || !this.hasChanged) {
      return false;
    }
    this.reset();
    this.draw();
    this.app.showOptions();
    return true;
  }

  options() {
    if (!this.plane) {
      return [];
    }
    const set = (changes) => {
      Object.assign(this, changes);
      this.draw();
    };
    this.told = element('p', { class: 'note', id: 'moved-told' }, this.figures());
    return [
      says('Drag in the picture to move it along its normal; with Shift to turn it.'),
      numberField('along the normal', this.by, 'm', (by) => set({ by }), { id: 'move-by' }),
      numberField('slope', this.slope, '°', (slope) => set({ slope, hasTurned: true }), {
        step: 0.5,
        id: 'move-slope',
        min: 0,
        max: 90,
      }),
      numberField('falls to', this.azimuth, '°', (azimuth) => set({ azimuth, hasTurned: true }), {
        step: 1,
        id: 'move-azimuth',
      }),
      this.told,
      element(
        'div',
        { class: 'does' },
        button('Move it', 'Enter', 'The plane lies there', () => this.confirm(), { isMain: true }),
      ),
    ];
  }
}
