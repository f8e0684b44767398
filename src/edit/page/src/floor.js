// The height of the floor: dragged, typed, or that of a point.

import { element } from '../../../view/page/src/dom.js';
import { decimal } from '../../../view/page/src/format.js';
import { OUTLINE } from '../../../explain/page/src/colours.js';
import { pairsOf } from './picture.js';
import { Tool, button, numberField, says } from './tool.js';

export class Floor extends Tool {
  enter() {
    if (this.building) {
      this.z = this.building.floor;
      this.draw();
    }
  }

  leave() {
    this.app.picture.erase('floor');
    this.app.picture.erase('floor-up');
  }

  get hasChanged() {
    return Math.abs(this.z - this.building.floor) > 5e-4;
  }

  draw() {
    const rings = this.building.footprint().flat();
    const at = rings.map((ring) => ring.map(([x, y]) => [x, y, this.z]));
    this.app.picture.drawLines('floor', at.flatMap(pairsOf), OUTLINE, { width: 4, isHidden: true });
    const up = at.flat().flatMap(([x, y, z]) => [
      [x, y, z],
      [x, y, this.building.floor],
    ]);
    this.app.picture.drawLines('floor-up', this.hasChanged ? up : [], OUTLINE, { width: 1.5, isHidden: true });
  }

  set(z, isTyped = false) {
    this.z = z;
    this.draw();
    if (!isTyped) {
      this.app.showOptions();
    }
  }

  down(event) {
    this.from = { y: event.clientY, z: this.z };
    // Metres of a pixel at what is looked at.
    const middle = [0, 0, this.z];
    const [a, b] = [middle, [0, 0, this.z + 1]].map((place) => this.app.places.onScreen(place));
    this.perPixel = 1 / Math.max(Math.hypot(b[0] - a[0], b[1] - a[1]), 8);
    return true;
  }

  drag(event) {
    this.set(Math.round((this.from.z + (this.from.y - event.clientY) * this.perPixel) * 100) / 100);
  }

  click(event) {
    const { places, picture } = this.app;
    const hit = this.around(event) ?? places.placeAt(this.building, event.clientX, event.clientY);
    if (hit && !picture.isCut(hit)) {
      this.set(hit[2]);
    }
  }

  /** The nearest point around the building under the pointer, if these are shown. */
  around(event) {
    if (!this.app.state.layers.around) {
      return null;
    }
    const { positions } = this.building.cloud;
    const [x, y] = this.app.places.inCanvas(event.clientX, event.clientY);
    let [best, least] = [null, 7];
    for (let i = 0; i < positions.length; i += 3) {
      const place = [positions[i], positions[i + 1], positions[i + 2]];
      const [u, v] = this.app.places.onScreen(place);
      if (Math.hypot(u - x, v - y) < least) {
        [best, least] = [place, Math.hypot(u - x, v - y)];
      }
    }
    return best;
  }

  hover() {
    return [`floor ${decimal(this.building.frame.heightToCrs(this.z), 2)}`, 'drag it, or click a point at its height'];
  }

  confirm() {
    if (this.hasChanged) {
      const height = Math.round(this.building.frame.heightToCrs(this.z) * 1000) / 1000;
      this.app.act({ 'set-floor': { height } });
    }
  }

  cancel() {
    if (!this.building || !this.hasChanged) {
      return false;
    }
    this.set(this.building.floor);
    return true;
  }

  options() {
    const { building } = this;
    if (!building) {
      return [];
    }
    const { frame } = building;
    const set = (height) => this.set(frame.heightToScene(height), true);
    return [
      says(
        'Drag up or down in the picture, or click a point that lies as high as the floor. Shift+P shows the points around.',
      ),
      numberField('floor at', frame.heightToCrs(this.z), frame.unit[2] === 1 ? 'm' : 'CRS', set, {
        id: 'floor-height',
      }),
      element(
        'div',
        { class: 'does' },
        button('Set the floor', 'Enter', 'The building stands at this height', () => this.confirm(), { isMain: true }),
      ),
    ];
  }
}
