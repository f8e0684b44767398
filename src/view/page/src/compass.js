// Where north is: the needle turns with the view, a click turns the view to it.

/** `node` is a button whose first child turns. */
export function showCompass(view, camera, node) {
  let last = '';
  view.beforeFrame.push(() => {
    const turn = `rotate(${((camera.azimuth * 180) / Math.PI).toFixed(1)}deg)`;
    if (turn !== last) {
      last = turn;
      node.firstElementChild.style.setProperty('transform', turn);
    }
  });
  node.addEventListener('click', () => camera.faceNorth());
}
