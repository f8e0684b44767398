// The model in three.js: one buffer for all faces, whose index says which of them are shown.

import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  Points,
} from 'three';
import { Marks } from './marks.js';
import { toLinear } from './palette.js';
import { Stage, pointMaterial } from './stage.js';

export class View extends Stage {
  constructor(canvas, model) {
    super(canvas, model);
    this.makeModel();
    this.makePoints();
  }

  makeModel() {
    const { model } = this;
    const corners = model.positions.length / 3;
    this.position = new BufferAttribute(model.positions, 3);
    this.colour = new BufferAttribute(new Uint16Array(corners * 3), 3, true);
    this.solid = new BufferGeometry();
    this.solid.setAttribute('position', this.position);
    this.solid.setAttribute('color', this.colour);
    this.solid.setIndex(new BufferAttribute(new Uint32Array(model.triangles.length), 1));
    const material = new MeshLambertMaterial({ vertexColors: true, flatShading: true, side: DoubleSide });
    Object.assign(material, {
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
      shadowSide: DoubleSide,
    });
    this.faces = new Mesh(this.solid, material);
    Object.assign(this.faces, { frustumCulled: false, castShadow: true, receiveShadow: true });
    this.lines = this.overlayLines(new Uint32Array(model.edges.length), { transparent: true, opacity: 0.6 });
    this.marks = new Marks(model.positions);
    this.scene.add(this.faces, this.lines, this.marks.group);
  }

  overlayLines(index, options) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', this.position);
    geometry.setIndex(new BufferAttribute(index, 1));
    const lines = new LineSegments(geometry, new LineBasicMaterial(options));
    lines.frustumCulled = false;
    return lines;
  }

  makePoints() {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(this.model.points, 3));
    this.pointColour = new BufferAttribute(new Uint16Array(this.model.points.length), 3, true);
    geometry.setAttribute('color', this.pointColour);
    this.points = new Points(geometry, pointMaterial());
    this.pointMaterials.push(this.points.material);
    this.points.frustumCulled = false;
    this.points.visible = false;
    this.scene.add(this.points);
  }

  /** The colours of everything that is not the model. */
  setTheme(name) {
    const theme = super.setTheme(name);
    this.lines.material.color.set(theme.edge);
    this.marks.setTheme(theme);
  }

  /** Shows the faces of a level of detail (-1: the best of each object); of features outside the filter no edges. */
  show(lod, isIn) {
    const { model } = this;
    const triangles = this.solid.index.array;
    const edges = this.lines.geometry.index.array;
    let [t, e] = [0, 0];
    model.features.forEach((feature, f) => {
      for (let r = feature.firstRun; r < feature.endRun; r += 1) {
        const run = model.runs[r];
        if (!model.isShown(run, lod)) {
          continue;
        }
        const some = model.triangles.subarray(model.faceTriangle[run.start], model.faceTriangle[run.end]);
        triangles.set(some, t);
        t += some.length;
        if (isIn(f)) {
          const drawn = model.edges.subarray(model.faceEdge[run.start], model.faceEdge[run.end]);
          edges.set(drawn, e);
          e += drawn.length;
        }
      }
    });
    this.solid.setDrawRange(0, t);
    this.lines.geometry.setDrawRange(0, e);
    this.solid.index.needsUpdate = true;
    this.lines.geometry.index.needsUpdate = true;
    this.castAnew();
    this.invalidate();
  }

  /** Paints every face: `of(face)` is an index into the colours. */
  paint(colours, of) {
    const { model } = this;
    const packed = colours.map((hex) => toLinear(hex).map((share) => Math.round(share * 65535)));
    const out = this.colour.array;
    for (let face = 0; face < model.faceLod.length; face += 1) {
      const [r, g, b] = packed[of(face)];
      for (let at = model.faceCorner[face] * 3, end = model.faceCorner[face + 1] * 3; at < end; at += 3) {
        out[at] = r;
        out[at + 1] = g;
        out[at + 2] = b;
      }
    }
    this.colour.needsUpdate = true;
    this.invalidate();
  }

  /** Paints every point: `of(point)` is a colour. */
  paintPoints(of) {
    const known = new Map();
    for (let i = 0; i < this.model.classes.length; i += 1) {
      const hex = of(i);
      if (!known.has(hex)) {
        known.set(
          hex,
          toLinear(hex).map((share) => Math.round(share * 65535)),
        );
      }
      this.pointColour.array.set(known.get(hex), i * 3);
    }
    this.pointColour.needsUpdate = true;
    this.invalidate();
  }

  /** Marks the edges of faces `[start, end)` runs of a feature, and the outline of one face of them. */
  mark(runs, face) {
    const { model } = this;
    const edges = runs.flatMap(({ start, end }) => [
      ...model.edges.subarray(model.faceEdge[start], model.faceEdge[end]),
    ]);
    this.marks.show(edges, face < 0 ? [] : model.outline(face));
    this.invalidate();
  }

  /** Fades edges out where they would only darken the picture: `perPixel` is metres per pixel at what is looked at. */
  setScale(perPixel) {
    const opacity = Math.min(Math.max(0.75 - perPixel * 0.9, 0), 0.6);
    this.lines.visible = opacity > 0.02;
    this.lines.material.opacity = opacity;
  }
}
