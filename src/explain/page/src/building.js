// What gable packed into the page, as flat arrays: see src/explain/drawn.rs.

import { Body } from './body.js';
import { boundsOf, cornersOf, readAll, readCells, readPlaces, readPolygons } from './columns.js';

/** The building of an unpacked payload. */
export class Building extends Body {
  constructor({ head, columns }) {
    super();
    this.head = head;
    const [vertices, points, cloud] = [columns.vertices, columns.points, columns.cloud].map(readPlaces);
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
    this.cells = readCells(columns, flat(vertices));
  }

  /** How many points are on each plane: `labels` are those of the points, from 1. */
  countsOf(labels) {
    const counts = [];
    labels.forEach((label) => label > 0 && (counts[label - 1] = (counts[label - 1] ?? 0) + 1));
    return counts;
  }
}
