// The model in three.js: one buffer for all faces, whose index says which of them are shown.

import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  DoubleSide,
  HemisphereLight,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  PCFShadowMap,
  PerspectiveCamera,
  Points,
  PointsMaterial,
  Scene,
  Vector3,
  WebGLRenderer,
} from 'three';
import { groundMesh } from './ground.js';
import { Marks } from './marks.js';
import { toLinear } from './palette.js';

const THEMES = {
  light: {
    back: '#eef1f4',
    ground: '#ffffff',
    edge: '#20242a',
    shadow: 0.34,
    sky: 2.2,
    sun: 1.9,
    mark: '#d4178f',
    around: '#ffffff',
  },
  dark: {
    back: '#15181c',
    ground: '#262b31',
    edge: '#07090b',
    shadow: 0.6,
    sky: 1.75,
    sun: 1.8,
    mark: '#ff5cc0',
    around: '#0b0d10',
  },
};

/** From the model to the sun, which stands in the south-west. */
const SUN = new Vector3(-0.55, -0.72, 0.95).normalize();

/** Points are drawn this much nearer than they are, metres: those just below their roof are the ones to look at. */
const POINT_LIFT = 0.3;

/** A frame of a movement that takes longer is slow, milliseconds. */
const SLOW = 70;

/** The share of pixels across and down that slow machines draw while the view moves. */
const COARSE = 0.5;

export class View {
  constructor(canvas, model) {
    this.model = model;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(36, 1, 0.1, 1000);
    this.camera.up.set(0, 0, 1);
    this.beforeFrame = [];
    this.makeModel();
    this.makePoints();
    this.makeLights();
    this.ground = groundMesh(model);
    if (this.ground) {
      this.scene.add(this.ground.mesh);
    }
    this.frames = { count: 0, milliseconds: 0 };
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
    const material = new PointsMaterial({ vertexColors: true, sizeAttenuation: false, size: 2 });
    material.onBeforeCompile = (shader) => {
      const lifted = `#include <project_vertex>
        float away = max(length(mvPosition.xyz), 1.0);
        vec4 lifted = projectionMatrix * vec4(mvPosition.xyz * (1.0 - ${POINT_LIFT.toFixed(2)} / away), 1.0);
        gl_Position.z = lifted.z / lifted.w * gl_Position.w;`;
      shader.vertexShader = shader.vertexShader.replace('#include <project_vertex>', lifted);
    };
    this.points = new Points(geometry, material);
    this.points.frustumCulled = false;
    this.points.visible = false;
    this.scene.add(this.points);
  }

  makeLights() {
    this.sky = new HemisphereLight('#ffffff', '#cdbfae', 1);
    this.sky.position.set(0, 0, 1);
    this.sun = new DirectionalLight('#fff4e2', 1);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(4096, 4096);
    this.sun.shadow.radius = 2;
    this.scene.add(this.sky, this.sun, this.sun.target);
  }

  /** The colours of everything that is not the model. */
  setTheme(name) {
    const theme = THEMES[name];
    this.theme = theme;
    this.scene.background = new Color(theme.back);
    this.sky.intensity = theme.sky;
    this.sun.intensity = theme.sun;
    this.lines.material.color.set(theme.edge);
    this.marks.setTheme(theme);
    this.ground?.setTheme(theme);
    this.invalidate();
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

  resize(width, height) {
    const ratio = Math.min(window.devicePixelRatio || 1, 2) * (this.isCoarse ? COARSE : 1);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.width = width;
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.points.material.size = 2.2 * ratio;
    this.height = height;
    this.invalidate();
  }

  /** Lays the shadow map over the whole model, or over what is looked at where that is smaller. */
  fitShadow(centre, radius) {
    const { camera, mapSize } = this.sun.shadow;
    // In whole texels, or shadows would creep when the view moves.
    const texel = (2 * radius) / mapSize.x;
    const snapped = centre.clone().divideScalar(texel).round().multiplyScalar(texel);
    this.sun.target.position.copy(snapped);
    this.sun.position.copy(snapped).addScaledVector(SUN, radius * 2);
    Object.assign(camera, { left: -radius, right: radius, top: radius, bottom: -radius, near: 0.1, far: radius * 4.5 });
    camera.updateProjectionMatrix();
    // A face must not shade itself for the width of a texel; in shares of the depth of the map.
    this.sun.shadow.bias = -(2.5 * texel) / (radius * 4.5);
    this.castAnew();
  }

  castAnew() {
    this.renderer.shadowMap.needsUpdate = true;
  }

  /** Asks for a frame; nothing is drawn while nothing changes. */
  invalidate() {
    if (this.asked) {
      return;
    }
    this.asked = true;
    requestAnimationFrame((now) => {
      this.asked = false;
      this.draw(now);
    });
  }

  draw(now) {
    this.beforeFrame.forEach((act) => act(now));
    const started = performance.now();
    this.renderer.render(this.scene, this.camera);
    this.frames.count += 1;
    this.frames.milliseconds += performance.now() - started;
  }

  /**
   * While the view moves, slow machines draw fewer pixels, and all of them again when it rests: `now` is the time of a frame
   * of a movement.
   */
  keepUp(now) {
    const since = now - (this.movedAt ?? 0);
    this.movedAt = now;
    // Longer is no movement that goes on, but another one.
    const isSlow = since > SLOW && since < 5000;
    this.slowFrames = isSlow ? (this.slowFrames ?? 0) + 1 : 0;
    if (this.slowFrames >= 3 && !this.isCoarse) {
      this.setCoarse(true);
    }
    clearTimeout(this.resting);
    const patience = isSlow ? Math.max(400, since * 2) : 400;
    this.resting = setTimeout(() => this.isCoarse && this.setCoarse(false), patience);
  }

  setCoarse(isCoarse) {
    this.isCoarse = isCoarse;
    this.resize(this.width, this.height);
  }

  /** Fades edges out where they would only darken the picture: `perPixel` is metres per pixel at what is looked at. */
  setScale(perPixel) {
    const opacity = Math.min(Math.max(0.75 - perPixel * 0.9, 0), 0.6);
    this.lines.visible = opacity > 0.02;
    this.lines.material.opacity = opacity;
  }
}
