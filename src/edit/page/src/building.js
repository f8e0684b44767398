// A building as the server sends it: see src/edit/payload.rs and src/edit/drawn.rs.

import { Body } from '../../../explain/page/src/body.js';
import {
  boundsOf,
  cornersOf,
  readAll,
  readCells,
  readPlaces,
  readPolygons,
} from '../../../explain/page/src/columns.js';
import { unfold } from '../../../view/page/src/payload.js';
import { Frame } from './frame.js';
import { distance } from './planes.js';

export class Building extends Body {
  /** `last` is what the building was before an edit: it stays where it is. */
  constructor({ head, columns }, last = null) {
    super();
    this.head = head;
    const steps = head.steps_per_metre;
    const [vertices, points, cloud] = [columns.vertices, columns.points, columns.cloud].map(readPlaces);
    const bounds = boundsOf(points.length > 0 ? [...points, ...cornersOf(columns.outline)] : cloud);
    // Whole steps, or its corners would part.
    this.centre = last?.centre ?? bounds.low.map((value, axis) => Math.round((value + bounds.high[axis]) / 2));
    this.frame = new Frame(head, this.centre);
    const toScene = (place) => place.map((value, axis) => (value - this.centre[axis]) / steps);
    this.low = toScene(bounds.low);
    this.high = toScene(bounds.high);
    const flat = (all) => new Float32Array(all.flatMap(toScene));
    this.cloud = {
      positions: flat(cloud),
      classes: readAll(columns.classes),
      intensities: readAll(columns.cloud_intensity),
    };
    this.points = {
      count: points.length,
      positions: flat(points),
      classes: readAll(columns.point_classes),
      intensities: readAll(columns.intensity),
      on: readAll(columns.on),
      distances: readAll(columns.distances).map((folded) => unfold(folded) / steps),
      excluded: readAll(columns.excluded),
    };
    const polygons = (reader) => readPolygons(reader, toScene);
    this.outline = polygons(columns.outline);
    this.hulls = polygons(columns.hulls);
    this.walls = { ...polygons(columns.planes), kinds: readAll(columns.plane_kinds) };
    this.faces = { ...polygons(columns.faces), kinds: readAll(columns.face_kinds) };
    this.before = { ...polygons(columns.before_faces), kinds: readAll(columns.before_face_kinds) };
    this.cells = readCells(columns, flat(vertices));
    // The planes that edits can address, in the scene.
    this.planes = head.planes.map((plane) => ({ ...plane, ...upwards(this.frame.planeToScene(plane.at.equation)) }));
    this.floor = this.frame.heightToScene(head.floor ?? head.now.floor ?? this.frame.heightToCrs(this.low[2]));
  }

  /** The place of a point. */
  pointAt(i) {
    const { positions } = this.points;
    return [positions[i * 3], positions[i * 3 + 1], positions[i * 3 + 2]];
  }

  /** The points on a plane. */
  pointsOn(plane) {
    return this.points.on.flatMap((label, i) => (label === plane + 1 && !this.points.excluded[i] ? [i] : []));
  }

  /** The corners of what was seen of a plane. */
  extentOf(plane) {
    return this.planes[plane].at.extent.map((place) => this.frame.toScene(place));
  }

  /** The plane that a face of the result lies on, near a place; -1 where it is none that an edit can address. */
  planeNear(place, normal) {
    let [best, least] = [-1, 0.3];
    this.planes.forEach((plane, i) => {
      const turned = Math.abs(plane.normal.reduce((sum, value, axis) => sum + value * normal[axis], 0));
      const away = Math.abs(distance(plane, place)) + 3 * (1 - turned);
      if (plane.on && turned > 0.95 && away < least && this.reaches(i, place)) {
        [best, least] = [i, away];
      }
    });
    return best;
  }

  /** Whether a place is where a plane was seen, or near it. */
  reaches(plane, place) {
    const corners = this.extentOf(plane);
    return [0, 1].every((axis) => {
      const all = corners.map((corner) => corner[axis]);
      return place[axis] > Math.min(...all) - 1.5 && place[axis] < Math.max(...all) + 1.5;
    });
  }

  /** The middle of a cell. */
  middleOf(cell) {
    const { facets, positions } = this.cells;
    const corners = [...new Set(facets[cell].flat())];
    return [0, 1, 2].map(
      (axis) => corners.reduce((sum, v) => sum + positions[v * 3 + axis], 0) / Math.max(corners.length, 1),
    );
  }

  /** The footprint of the head as rings of places of the scene, at the floor; polygon by polygon. */
  footprint() {
    const ring = (all) => all.slice(0, -1).map((place) => this.frame.planToScene(place, this.floor));
    return this.head.footprint.map((polygon) => polygon.map(ring));
  }
}

/** The same plane, seen from above. */
const upwards = ({ normal, offset }) =>
  normal[2] < 0 ? { normal: normal.map((value) => -value), offset: -offset } : { normal, offset };

/** What is looked at before there is a building. */
export function nothing() {
  const body = new Body();
  return Object.assign(body, { low: [-8, -8, 0], high: [8, 8, 6], outline: { count: 0 }, cells: { fixed: [] } });
}
