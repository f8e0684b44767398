// What lies under the pointer: boxes of features first, then the triangles of those that are shown.

/** The nearest face that a ray meets, as { feature, face, distance }, or null. */
export function pick(model, lod, isIn, origin, direction) {
  const candidates = [];
  for (let f = 0; f < model.features.length; f += 1) {
    const enters = entersBox(model.boxes, f * 6, origin, direction);
    if (enters < Infinity && isIn(f)) {
      candidates.push([enters, f]);
    }
  }
  candidates.sort((a, b) => a[0] - b[0]);
  let best = null;
  for (const [enters, f] of candidates) {
    if (best && enters > best.distance) {
      break;
    }
    const feature = model.features[f];
    for (let r = feature.firstRun; r < feature.endRun; r += 1) {
      const run = model.runs[r];
      if (!model.isShown(run, lod)) {
        continue;
      }
      for (let face = run.start; face < run.end; face += 1) {
        for (let i = model.faceTriangle[face]; i < model.faceTriangle[face + 1]; i += 3) {
          const distance = meets(model, i, origin, direction);
          if (distance < (best ? best.distance : Infinity)) {
            best = { feature: f, face, distance };
          }
        }
      }
    }
  }
  return best;
}

/** Where a ray enters a box (0 from inside); infinity where it misses it. */
function entersBox(boxes, at, origin, direction) {
  let [near, far] = [0, Infinity];
  for (let axis = 0; axis < 3; axis += 1) {
    const inverse = 1 / direction[axis];
    // A little wider than it is: a footprint has no height at all.
    let low = (boxes[at + axis] - 0.01 - origin[axis]) * inverse;
    let high = (boxes[at + axis + 3] + 0.01 - origin[axis]) * inverse;
    if (low > high) {
      [low, high] = [high, low];
    }
    near = Math.max(near, low);
    far = Math.min(far, high);
  }
  return near <= far ? near : Infinity;
}

/** Where a ray meets a triangle (Möller and Trumbore 1997); infinity where it misses it. */
function meets(model, i, [ox, oy, oz], [dx, dy, dz]) {
  const p = model.positions;
  const [a, b, c] = [model.triangles[i] * 3, model.triangles[i + 1] * 3, model.triangles[i + 2] * 3];
  const [ux, uy, uz] = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]];
  const [vx, vy, vz] = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
  const [hx, hy, hz] = [dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx];
  const determinant = ux * hx + uy * hy + uz * hz;
  if (Math.abs(determinant) < 1e-12) {
    return Infinity;
  }
  const [sx, sy, sz] = [ox - p[a], oy - p[a + 1], oz - p[a + 2]];
  const s = (sx * hx + sy * hy + sz * hz) / determinant;
  if (s < 0 || s > 1) {
    return Infinity;
  }
  const [qx, qy, qz] = [sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux];
  const t = (dx * qx + dy * qy + dz * qz) / determinant;
  if (t < 0 || s + t > 1) {
    return Infinity;
  }
  const distance = (vx * qx + vy * qy + vz * qz) / determinant;
  return distance > 0 ? distance : Infinity;
}
