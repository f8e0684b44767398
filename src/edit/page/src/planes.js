// Planes of the scene, `{ normal, offset }` with normal · p + offset = 0: fitted, turned, and as far as their points reach.

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
/** `a` and so much of `b`. */
export const along = (a, b, by) => [a[0] + b[0] * by, a[1] + b[1] * by, a[2] + b[2] * by];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

export function unit(v) {
  const length = Math.hypot(...v);
  return length > 1e-12 ? v.map((value) => value / length) : [0, 0, 1];
}

export const distance = (plane, place) => dot(plane.normal, place) + plane.offset;
export const through = (place, normal) => ({ normal, offset: -dot(normal, place) });

export const middleOf = (places) =>
  [0, 1, 2].map((axis) => places.reduce((sum, place) => sum + place[axis], 0) / Math.max(places.length, 1));

/** The root mean square of the distances of places to a plane. */
export const rmsOf = (plane, places) =>
  Math.sqrt(places.reduce((sum, place) => sum + distance(plane, place) ** 2, 0) / Math.max(places.length, 1));

/** Degrees from the level, and degrees clockwise from north to where it falls. */
export function lieOf({ normal }) {
  const up = normal[2] < 0 ? normal.map((value) => -value) : normal;
  const azimuth = (Math.atan2(up[0], up[1]) * 180) / Math.PI;
  return { slope: (Math.acos(Math.min(up[2], 1)) * 180) / Math.PI, azimuth: (azimuth + 360) % 360 };
}

/** The normal, upwards, of a slope and an azimuth in degrees. */
export function normalOf(slope, azimuth) {
  const [tilt, turn] = [slope, azimuth].map((degrees) => (degrees * Math.PI) / 180);
  return [Math.sin(tilt) * Math.sin(turn), Math.sin(tilt) * Math.cos(turn), Math.cos(tilt)];
}

/** The eigenvectors of a symmetric matrix, the one of the least eigenvalue first (Jacobi 1846). */
function eigenvectors(matrix) {
  const m = matrix.map((row) => [...row]);
  const vectors = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ];
  for (let sweep = 0; sweep < 40; sweep += 1) {
    for (const [p, q] of [
      [0, 1],
      [0, 2],
      [1, 2],
    ]) {
      if (Math.abs(m[p][q]) < 1e-14) {
        continue;
      }
      const angle = 0.5 * Math.atan2(2 * m[p][q], m[q][q] - m[p][p]);
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      for (let k = 0; k < 3; k += 1) {
        [m[k][p], m[k][q]] = [c * m[k][p] - s * m[k][q], s * m[k][p] + c * m[k][q]];
      }
      for (let k = 0; k < 3; k += 1) {
        [m[p][k], m[q][k]] = [c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]];
        [vectors[k][p], vectors[k][q]] = [c * vectors[k][p] - s * vectors[k][q], s * vectors[k][p] + c * vectors[k][q]];
      }
    }
  }
  const order = [0, 1, 2].sort((a, b) => m[a][a] - m[b][b]);
  return order.map((k) => unit(vectors.map((row) => row[k])));
}

function spreadOf(places, middle, axes) {
  const spread = [
    [0, 0, 0],
    [0, 0, 0],
    [0, 0, 0],
  ];
  for (const place of places) {
    const from = minus(place, middle);
    for (let i = 0; i < axes; i += 1) {
      for (let j = 0; j < axes; j += 1) {
        spread[i][j] += (from[i] * from[j]) / places.length;
      }
    }
  }
  return spread;
}

/**
 * The plane that lies as near to places as it can, in squares; `lie` is how it is to lie: nothing, `level`, `vertical`, or
 * `{ parallel: normal }`. Null where places are too few or in one line.
 */
export function fitted(places, lie = null) {
  if (places.length < 3) {
    return null;
  }
  const middle = middleOf(places);
  if (lie === 'level') {
    return through(middle, [0, 0, 1]);
  }
  if (lie?.parallel) {
    return through(middle, unit(lie.parallel));
  }
  const spread = spreadOf(places, middle, lie === 'vertical' ? 2 : 3);
  if (lie === 'vertical') {
    // What has no height spreads least upwards.
    spread[2][2] = 1e9;
  }
  const [least, next] = eigenvectors(spread);
  // How far places spread in the direction of the next: in one line they do not.
  const reach = spreadOf(places, middle, 3);
  const width = [0, 1, 2].reduce((sum, i) => sum + next[i] * dot(reach[i], next), 0);
  if (lie !== 'vertical' && width < 1e-4) {
    return null;
  }
  return through(middle, least[2] < 0 ? least.map((value) => -value) : least);
}

/** Two directions in a plane, at right angles. */
export function axesOf(normal) {
  const across = Math.hypot(normal[0], normal[1]) > 1e-6 ? unit(cross([0, 0, 1], normal)) : [1, 0, 0];
  return [across, unit(cross(normal, across))];
}

export const onto = (plane, place) => along(place, plane.normal, -distance(plane, place));

/** The convex hull of places in a plane, as a ring of it (Andrew 1979). */
export function hullOf(plane, places) {
  const [u, v] = axesOf(plane.normal);
  const flat = places.map((place) => [dot(u, place), dot(v, place)]).sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const turns = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  const half = (all) => {
    const chain = [];
    for (const place of all) {
      while (chain.length > 1 && turns(chain.at(-2), chain.at(-1), place) <= 0) {
        chain.pop();
      }
      chain.push(place);
    }
    return chain.slice(0, -1);
  };
  const ring = flat.length < 3 ? flat : [...half(flat), ...half([...flat].reverse())];
  return ring.map(([a, b]) => along(along(along([0, 0, 0], plane.normal, -plane.offset), u, a), v, b));
}
