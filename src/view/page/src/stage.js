// What every picture of buildings stands on: renderer, camera, light, shadow and ground, in both themes.

import {
  Color,
  DirectionalLight,
  HemisphereLight,
  PCFShadowMap,
  PerspectiveCamera,
  PointsMaterial,
  Scene,
  Vector3,
  WebGLRenderer,
} from 'three';
import { groundMesh } from './ground.js';

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

/** Points of pixels and not of metres, for a `Stage.pointMaterials`. */
export function pointMaterial() {
  const material = new PointsMaterial({ vertexColors: true, sizeAttenuation: false, size: 2 });
  material.onBeforeCompile = (shader) => {
    const lifted = `#include <project_vertex>
        float away = max(length(mvPosition.xyz), 1.0);
        vec4 lifted = projectionMatrix * vec4(mvPosition.xyz * (1.0 - ${POINT_LIFT.toFixed(2)} / away), 1.0);
        gl_Position.z = lifted.z / lifted.w * gl_Position.w;`;
    shader.vertexShader = shader.vertexShader.replace('#include <project_vertex>', lifted);
  };
  return material;
}

/** `model` has `features` with their `boxes`, six numbers each: what the camera looks at and the ground lies under. */
export class Stage {
  constructor(canvas, model) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(36, 1, 0.1, 1000);
    this.camera.up.set(0, 0, 1);
    this.beforeFrame = [];
    // Of a screen of fine pixels three.js takes as many more for each point.
    this.pointMaterials = [];
    this.pointSize = 2.2;
    this.makeLights();
    this.setModel(model);
    this.frames = { count: 0, milliseconds: 0 };
  }

  /** From now on this model is looked at; the ground is laid under it. */
  setModel(model) {
    this.model = model;
    if (this.ground) {
      this.scene.remove(this.ground.mesh);
      this.ground.mesh.geometry.dispose();
      this.ground.material.dispose();
    }
    this.ground = groundMesh(model);
    if (this.ground) {
      this.scene.add(this.ground.mesh);
    }
    if (this.theme) {
      this.ground?.setTheme(this.theme);
    }
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

  /** The colours of everything that is not the model; gives them. */
  setTheme(name) {
    const theme = THEMES[name];
    this.theme = theme;
    this.scene.background = new Color(theme.back);
    this.sky.intensity = theme.sky;
    this.sun.intensity = theme.sun;
    this.ground?.setTheme(theme);
    this.invalidate();
    return theme;
  }

  resize(width, height) {
    const ratio = Math.min(window.devicePixelRatio || 1, 2) * (this.isCoarse ? COARSE : 1);
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.width = width;
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.pointMaterials.forEach((material) => (material.size = this.pointSize));
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

  /** Told of every frame: `perPixel` is metres per pixel at what is looked at. */
  setScale() {}
}
