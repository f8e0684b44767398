// What is selected: its edges as wide lines. Its faces keep their colours, which say what one selected it for.

import { Group } from 'three';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { LineSegments2 } from 'three/addons/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/addons/lines/LineSegmentsGeometry.js';

/** Widths of the lines of a building, of a face, and of what stands out around both, pixels. */
const [EDGE, FACE, AROUND] = [2, 4, 2.5];

/** Drawn a little nearer than they are: the faces that meet in an edge would hide parts of it. */
const NEARER = { polygonOffset: true, polygonOffsetFactor: -4, polygonOffsetUnits: -4 };

/** Lines so many pixels wide between pairs of places, which `place` puts. */
export function wideLines(width, options = {}) {
  const material = new LineMaterial({ linewidth: width, transparent: true, depthWrite: false, ...NEARER, ...options });
  return Object.assign(new LineSegments2(new LineSegmentsGeometry(), material), { frustumCulled: false });
}

/** Puts wide lines between pairs of `positions`: buffers of another length ask for another geometry. */
export function place(lines, positions, pairs) {
  const places = new Float32Array(pairs.length * 3);
  pairs.forEach((corner, i) => places.set(positions.subarray(corner * 3, corner * 3 + 3), i * 3));
  lines.visible = pairs.length > 0;
  lines.geometry.dispose();
  lines.geometry = new LineSegmentsGeometry();
  if (pairs.length > 0) {
    lines.geometry.setPositions(places);
  }
}

export class Marks {
  constructor(positions) {
    this.positions = positions;
    this.group = new Group();
    const add = (width, order, options) => {
      const lines = Object.assign(wideLines(width, options), { renderOrder: order, visible: false });
      this.group.add(lines);
      return lines;
    };
    // Behind other buildings they are faint and still there.
    this.hidden = add(EDGE, 2, { depthTest: false, opacity: 0.35 });
    this.around = add(EDGE + AROUND, 3);
    this.edges = add(EDGE, 4);
    this.faceAround = add(FACE + AROUND, 5);
    this.face = add(FACE, 6);
  }

  setTheme({ mark, around }) {
    [this.hidden, this.edges, this.face].forEach(({ material }) => material.color.set(mark));
    [this.around, this.faceAround].forEach(({ material }) => material.color.set(around));
  }

  /** Shows edges of a building and of one of its faces: pairs of corners. */
  show(edges, face) {
    [this.hidden, this.around, this.edges].forEach((lines) => place(lines, this.positions, edges));
    [this.faceAround, this.face].forEach((lines) => place(lines, this.positions, face));
  }
}
