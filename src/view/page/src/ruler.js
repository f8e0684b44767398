// The scale bar.

import { refill } from './dom.js';
import { decimal } from './format.js';

/** A round number of metres at what is looked at; `node` has the bar and its text. */
export function showRuler(view, camera, node) {
  const [bar, text] = node.children;
  let last = '';
  view.beforeFrame.push(() => {
    const away = view.camera.position.distanceTo(camera.controls.target);
    const perPixel = (2 * away * Math.tan((view.camera.fov * Math.PI) / 360)) / Math.max(view.height, 1);
    const most = perPixel * 140;
    const scale = 10 ** Math.floor(Math.log10(most));
    const metres = [5, 2, 1].map((step) => step * scale).find((step) => step <= most) ?? scale;
    const label = metres >= 1000 ? `${decimal(metres / 1000)} km` : `${decimal(metres)} m`;
    const width = `${Math.round(metres / perPixel)}px`;
    if (label + width !== last) {
      last = label + width;
      bar.style.width = width;
      refill(text, label);
    }
  });
}
