// What gable packed into the page, as flat arrays: see src/explain/drawn.rs.

/** Polygons as triangles and edges; `owner` is the polygon of each triangle, `normals` three numbers a polygon. */
function readPolygons(reader, toScene) {
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
function cornersOf(reader) {
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
function readAll(reader) {
  const all = [];
  while (reader.at < reader.bytes.length) {
    all.push(reader.next());
  }
  return all;
}

/** The building of an unpacked payload. */
export class Building {
  constructor({ head, columns }) {
    this.head = head;
    const places = (reader) => {
      const last = [0, 0, 0];
      const all = [];
      while (reader.at < reader.bytes.length) {
        last.forEach((_, axis) => (last[axis] += reader.signed()));
        all.push([...last]);
      }
      return all;
    };
    const [vertices, points, cloud] = [columns.vertices, columns.points, columns.cloud].map(places);
    // Of a building without points what is around it is looked at.
    const bounds = boundsOf(points.length > 0 ? [...points, ...cornersOf(columns.outline)] : cloud);
    // The scene is in metres from the middle of the building: whole steps, or its corners would part.
    this.centre = bounds.low.map((value, axis) => Math.round((value + bounds.high[axis]) / 2));
    const toScene = (place) => place.map((value, axis) => (value - this.centre[axis]) / head.steps_per_metre);
    this.low = toScene(bounds.low);
    this.high = toScene(bounds.high);
    const flat = (all) => new Float32Array(all.flatMap(toScene));
    this.cloud = { positions: flat(cloud), classes: readAll(columns.classes) };
    this.points = {
      positions: flat(points),
      found: readAll(columns.found),
      refined: readAll(columns.refined),
      distances: readAll(columns.distances).map((steps) => steps / head.steps_per_metre),
    };
    const polygons = (reader) => readPolygons(reader, toScene);
    this.outline = polygons(columns.outline);
    this.found = polygons(columns.found_hulls);
    this.refined = polygons(columns.refined_hulls);
    this.planes = { ...polygons(columns.planes), kinds: readAll(columns.plane_kinds) };
    this.faces = { ...polygons(columns.faces), kinds: readAll(columns.face_kinds) };
    this.cells = this.readCells(columns, flat(vertices));
  }

  readCells(columns, positions) {
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

  /** What the camera looks at, as the model of the viewer: the building, and room around it. */
  get model() {
    const room = Math.max(...this.high.map((value, axis) => value - this.low[axis])) * 0.8;
    const around = [
      ...this.low.map((value, axis) => (axis === 2 ? value : value - room)),
      ...this.high.map((value) => value + room),
    ];
    return {
      features: [
        { hasShape: true, isBuilding: true, kind: 'Building' },
        { hasShape: true, isBuilding: false, kind: 'Building' },
      ],
      boxes: new Float32Array([...this.low, ...this.high, ...around]),
    };
  }

  /** The corners of the building, at its floor and at its top, with its cells so far apart. */
  cornersOf(apart) {
    const [low, high] = [this.low, this.high];
    const ofBox = [
      [low[0], low[1]],
      [high[0], low[1]],
      [high[0], high[1]],
      [low[0], high[1]],
    ];
    const corners = this.outline.count > 0 ? chunksOf(this.outline.positions) : ofBox;
    const heights = [this.low[2], this.low[2] + (this.high[2] - this.low[2]) * (1 + apart)];
    return corners.flatMap(([x, y]) => heights.map((z) => [x * (1 + apart), y * (1 + apart), z]));
  }

  /** How many points are on each plane: `labels` are those of the points, from 1. */
  countsOf(labels) {
    const counts = [];
    labels.forEach((label) => label > 0 && (counts[label - 1] = (counts[label - 1] ?? 0) + 1));
    return counts;
  }
}

/** Numbers three by three. */
const chunksOf = (numbers) =>
  Array.from({ length: numbers.length / 3 }, (_, i) => [...numbers.subarray(i * 3, i * 3 + 3)]);

function boundsOf(places) {
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
