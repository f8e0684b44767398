// Clicks and hovering on the canvas.

import { Raycaster, Vector2 } from 'three';
import { pick } from './pick.js';

/** A click that moved farther is a drag, pixels. */
const STILL = 5;

export class Pointer {
  constructor(canvas, view, model, state) {
    Object.assign(this, { canvas, view, model, state });
    this.raycaster = new Raycaster();
  }

  /** What lies under a place of the window. */
  at(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    const place = new Vector2(((clientX - box.left) / box.width) * 2 - 1, 1 - ((clientY - box.top) / box.height) * 2);
    this.view.camera.updateMatrixWorld();
    this.raycaster.setFromCamera(place, this.view.camera);
    const { origin, direction } = this.raycaster.ray;
    return pick(this.model, this.state.lod, (f) => this.state.isIn(f), origin.toArray(), direction.toArray());
  }

  listen({ click, doubleClick, hover }) {
    let [down, asked] = [null, false];
    this.canvas.addEventListener('pointerdown', (event) => {
      down = event.isPrimary && event.button === 0 ? [event.clientX, event.clientY] : null;
      hover(null);
    });
    this.canvas.addEventListener('pointerup', (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < STILL) {
        const { left } = this.canvas.getBoundingClientRect();
        click(this.at(event.clientX, event.clientY), event.clientX - left);
      }
      down = null;
    });
    this.canvas.addEventListener('dblclick', (event) => doubleClick(this.at(event.clientX, event.clientY)));
    this.canvas.addEventListener('pointerleave', () => hover(null));
    this.canvas.addEventListener('pointermove', (event) => {
      if (event.pointerType !== 'mouse' || event.buttons !== 0 || asked) {
        return;
      }
      asked = true;
      requestAnimationFrame(() => {
        asked = false;
        hover(this.at(event.clientX, event.clientY), event);
      });
    });
  }
}
