// A patch of ground under the buildings, for the eye and for shadows: it follows their lower edges and is no part of the model.

import {
  BufferAttribute,
  BufferGeometry,
  Color,
  CustomBlending,
  Mesh,
  OneFactor,
  OneMinusSrcAlphaFactor,
  ShadowMaterial,
  SrcAlphaFactor,
} from 'three';

/** Squares along the longer side. */
const SQUARES = 96;
/** How far below the buildings it lies, metres: walls shall cast their shadows from where they stand. */
const BELOW = 0.06;

/** So many buildings are all looked at for every place. */
const FEW = 600;

/** The ground of a model, or null where it has its own or nothing stands on it. */
export function groundMesh(model) {
  const hasOwn = model.features.some((feature) => /Relief|LandUse|PlantCover/.test(feature.kind) && feature.hasShape);
  const bases = [];
  model.features.forEach((feature, f) => {
    if (feature.hasShape) {
      const box = model.boxes.subarray(f * 6, f * 6 + 6);
      bases.push([
        (box[0] + box[3]) / 2,
        (box[1] + box[4]) / 2,
        box[2],
        Math.hypot(box[3] - box[0], box[4] - box[1]) / 2,
      ]);
    }
  });
  if (hasOwn || bases.length === 0) {
    return null;
  }
  const low = [0, 1].map((axis) => bases.reduce((least, base) => Math.min(least, base[axis] - base[3]), Infinity));
  const high = [0, 1].map((axis) => bases.reduce((most, base) => Math.max(most, base[axis] + base[3]), -Infinity));
  const size = Math.max(high[0] - low[0], high[1] - low[1]);
  const fade = Math.max(size * 0.3, 25);
  const step = (size + 2 * fade) / SQUARES;
  const [columns, rows] = [0, 1].map((axis) => Math.ceil((high[axis] - low[axis] + 2 * fade) / step));
  const grid = new Grid(bases, step);
  const places = new Float32Array((columns + 1) * (rows + 1) * 3);
  const fades = new Float32Array((columns + 1) * (rows + 1));
  for (let row = 0, at = 0; row <= rows; row += 1) {
    for (let column = 0; column <= columns; column += 1, at += 1) {
      const [x, y] = [low[0] - fade + column * step, low[1] - fade + row * step];
      const [height, away] = grid.at(x, y);
      places.set([x, y, height - BELOW], at * 3);
      // Even among the buildings, and gone far from them.
      const shade = Math.min(Math.max(0, 1.25 - (1.25 * away) / fade), 1);
      fades[at] = shade * shade * (3 - 2 * shade);
    }
  }
  const index = [];
  for (let row = 0; row < rows; row += 1) {
    for (let column = 0; column < columns; column += 1) {
      const a = row * (columns + 1) + column;
      index.push(a, a + 1, a + columns + 2, a, a + columns + 2, a + columns + 1);
    }
  }
  return new Ground(places, fades, index);
}

class Ground {
  constructor(places, fades, index) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(places, 3));
    geometry.setAttribute('fade', new BufferAttribute(fades, 1));
    geometry.setIndex(index);
    geometry.computeVertexNormals();
    // Drawn first and without depth: wherever it lies, it never covers what is of the model. What is transparent would be drawn
    // last, hence blending of its own.
    this.material = new ShadowMaterial({ depthWrite: false, depthTest: false });
    Object.assign(this.material, {
      transparent: false,
      blending: CustomBlending,
      blendSrc: SrcAlphaFactor,
      blendDst: OneMinusSrcAlphaFactor,
      blendSrcAlpha: OneFactor,
      blendDstAlpha: OneMinusSrcAlphaFactor,
    });
    this.colour = { value: new Color() };
    // Ground and shadow in one pass: each pixel of it costs twice on a slow machine otherwise.
    this.material.onBeforeCompile = (shader) => {
      shader.uniforms.ground = this.colour;
      shader.vertexShader = `attribute float fade;\nvarying float vFade;\n${shader.vertexShader}`.replace(
        '#include <begin_vertex>',
        '#include <begin_vertex>\nvFade = fade;',
      );
      shader.fragmentShader = `uniform vec3 ground;\nvarying float vFade;\n${shader.fragmentShader}`.replace(
        /gl_FragColor = vec4\([^;]*getShadowMask[^;]*;/,
        'gl_FragColor = vec4( mix( ground, color, opacity * ( 1.0 - getShadowMask() ) ), vFade );',
      );
    };
    this.mesh = new Mesh(geometry, this.material);
    this.mesh.receiveShadow = true;
    // Before all that lies on it.
    this.mesh.renderOrder = -1;
  }

  setTheme(theme) {
    this.colour.value.set(theme.ground);
    this.material.opacity = theme.shadow;
  }
}

/** Bases in squares, for the nearest of a place. */
class Grid {
  constructor(bases, step) {
    this.bases = bases;
    // Of few all are taken, of many those around.
    this.size = bases.length <= FEW ? Infinity : Math.max(step * 4, 20);
    this.cells = new Map();
    bases.forEach((base) => {
      const key = this.key(Math.floor(base[0] / this.size), Math.floor(base[1] / this.size));
      if (!this.cells.has(key)) {
        this.cells.set(key, []);
      }
      this.cells.get(key).push(base);
    });
    this.mean = bases.reduce((sum, base) => sum + base[2], 0) / bases.length;
  }

  key(column, row) {
    return `${column}/${row}`;
  }

  /** The height of the ground, from the bases around by inverse squared distance, and how far the nearest is. */
  at(x, y) {
    const [column, row] = [Math.floor(x / this.size), Math.floor(y / this.size)];
    let [weights, sum, nearest] = [0, 0, Infinity];
    for (let reach = 0; reach <= 6 && (reach < 2 || weights === 0); reach += 1) {
      for (let i = -reach; i <= reach; i += 1) {
        for (let j = -reach; j <= reach; j += 1) {
          if (Math.max(Math.abs(i), Math.abs(j)) !== reach) {
            continue;
          }
          for (const base of this.cells.get(this.key(column + i, row + j)) ?? []) {
            const away = Math.hypot(base[0] - x, base[1] - y);
            const weight = 1 / (away * away + 1);
            weights += weight;
            sum += weight * base[2];
            nearest = Math.min(nearest, Math.max(0, away - base[3]));
          }
        }
      }
    }
    return weights > 0 ? [sum / weights, nearest] : [this.mean, Infinity];
  }
}
