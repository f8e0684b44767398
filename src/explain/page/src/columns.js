// Columns of numbers as places, polygons and cells: see src/explain/drawn.rs.

/** Polygons as triangles and edges; `owner` is the polygon of each triangle, `normals` three numbers a polygon. */
export function readPolygons(reader, toScene) {
  const all = { count: 0, positions: [], triangles: [], owner: [], edges: [], edgeOwner: [], normals: [] };
  const last = [0, 0, 0];
  while (reader.at < reader.bytes.length) {
    const first = all.positions.length / 3;
    for (let rings = reader.next(); rings > 0; rings -= 1) {
      const start = all.positions.length / 3;
      const corners = reader.next();
      for (let i = 0; i < corners; i += 1) {
        for (let axis = 0; axis < 3; axis += 1) {
          last[axis] += reader.signed();
        }
        all.positions.push(...toScene(last));
        all.edges.push(start + i, start + ((i + 1) % corners));
        all.edgeOwner.push(all.count);
      }
    }
    const triangles = reader.next();
    for (let i = 0; i < triangles; i += 1) {
      all.triangles.push(first + reader.next(), first + reader.next(), first + reader.next());
      all.owner.push(all.count);
    }
    all.normals.push(...normalOf(all.positions, all.triangles.slice(-3)));
    all.count += 1;
  }
  return { ...all, positions: new Float32Array(all.positions), triangles: new Uint32Array(all.triangles) };
}

/** The normal of a triangle, or up. */
function normalOf(positions, corners) {
  if (corners.length < 3) {
    return [0, 0, 1];
  }
  const [a, b, c] = corners.map((corner) => positions.slice(corner * 3, corner * 3 + 3));
  const [u, v] = [b, c].map((p) => p.map((value, axis) => value - a[axis]));
  const cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const length = Math.hypot(...cross) || 1;
  return cross.map((value) => value / length);
}

/** The corners of all polygons of a column, in steps; the column can be read again. */
export function cornersOf(reader) {
  const all = [];
  const last = [0, 0, 0];
  while (reader.at < reader.bytes.length) {
    for (let rings = reader.next(); rings > 0; rings -= 1) {
      for (let corners = reader.next(); corners > 0; corners -= 1) {
        last.forEach((_, axis) => (last[axis] += reader.signed()));
        all.push([...last]);
      }
    }
    for (let left = reader.next() * 3; left > 0; left -= 1) {
      reader.next();
    }
  }
  reader.at = 0;
  return all;
}

/** All numbers of a column. */
export function readAll(reader) {
  const all = [];
  while (reader.at < reader.bytes.length) {
    all.push(reader.next());
  }
  return all;
}

/** All places of a column, in steps. */
export function readPlaces(reader) {
  const last = [0, 0, 0];
  const all = [];
  while (reader.at < reader.bytes.length) {
    last.forEach((_, axis) => (last[axis] += reader.signed()));
    all.push([...last]);
  }
  return all;
}

/** The cells of the columns that a complex is packed into; `positions` are its vertices. */
export function readCells(columns, positions) {
  const fixed = readAll(columns.fixed);
  const cells = {
    count: fixed.length,
    positions,
    fixed,
    volumes: readAll(columns.volumes).map((litres) => litres / 1000),
    occupancy: readAll(columns.occupancy).map((thousandths) => thousandths / 1000),
    cut: readAll(columns.cut),
    cleaned: readAll(columns.cleaned),
    // Of each cell its facets, as corners.
    facets: fixed.map(() => []),
  };
  while (columns.facets.at < columns.facets.bytes.length) {
    const corners = Array.from({ length: columns.facets.next() }, () => columns.facets.next());
    [columns.sides.next(), columns.sides.next()].forEach((side) => side > 0 && cells.facets[side - 1].push(corners));
  }
  return cells;
}

/** The least and the greatest coordinates of places; those of a metre without any. */
export function boundsOf(places) {
  const [low, high] = [
    [Infinity, Infinity, Infinity],
    [-Infinity, -Infinity, -Infinity],
  ];
  places.forEach((place) =>
    place.forEach((value, axis) => {
      low[axis] = Math.min(low[axis], value);
      high[axis] = Math.max(high[axis], value);
    }),
  );
  return places.length > 0 ? { low, high } : { low: [0, 0, 0], high: [1000, 1000, 1000] };
}
