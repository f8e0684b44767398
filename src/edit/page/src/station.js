// Where one stands: as in the viewer, and far away with a long lens, where lines that are parallel stay so.

import { Vector3 } from 'three';
import { Camera } from '../../../view/page/src/camera.js';

/** Fields of view, degrees: as in the viewer, and so narrow that nothing is seen from the side. */
const [WIDE, NARROW] = [36, 0.5];

/** From where the views look, by their names. */
export const SIDES = {
  top: [0, -0.0001, 1],
  north: [0, 1, 0],
  east: [1, 0, 0],
  south: [0, -1, 0],
  west: [-1, 0, 0],
};

export class Station extends Camera {
  /** Takes in another building, and looks at it as at the one before. */
  take() {
    this.measure();
    this.fit();
  }

  measure() {
    super.measure();
    this.controls.maxDistance *= this.lens;
  }

  /** By how much farther one stands away than with the lens of the viewer. */
  get lens() {
    const slope = (degrees) => Math.tan((degrees * Math.PI) / 360);
    return slope(WIDE) / slope(this.view.camera.fov);
  }

  get isParallel() {
    return this.view.camera.fov < 1;
  }

  /** Changes the lens; what is looked at keeps its size. */
  setParallel(isParallel) {
    if (isParallel === this.isParallel) {
      return;
    }
    const before = this.lens;
    this.view.camera.fov = isParallel ? NARROW : WIDE;
    this.view.camera.updateProjectionMatrix();
    const by = this.lens / before;
    this.controls.maxDistance *= by;
    const { camera } = this.view;
    camera.position.sub(this.controls.target).multiplyScalar(by).add(this.controls.target);
    this.flight = null;
    this.controls.update();
    this.view.invalidate();
  }

  /** As in the viewer, with its lens. */
  fit(fromAbove = false, milliseconds = 0) {
    this.setParallel(false);
    super.fit(fromAbove, milliseconds);
  }

  /** Looks from a side, straight, with everything in the picture. */
  lookFrom(direction) {
    this.setParallel(true);
    this.leave();
    this.fly(this.buildings, new Vector3(...direction).normalize(), 0);
  }

  /** Looks at a direction, as near as it was. */
  face(direction) {
    this.setParallel(true);
    this.leave();
    const { camera } = this.view;
    const away = camera.position.distanceTo(this.controls.target);
    camera.position.copy(this.controls.target).addScaledVector(new Vector3(...direction).normalize(), away);
    this.controls.update();
    this.view.invalidate();
  }
}
