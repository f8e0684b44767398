// The model as flat arrays: features, faces, triangles and edges, all levels of detail in one.

import { unfold } from './payload.js';
import { Vocabulary } from './vocabulary.js';

const byDetail = (a, b) => (Number.parseFloat(a) || 0) - (Number.parseFloat(b) || 0) || a.localeCompare(b);

/** Whether a level of detail is that of footprints. */
const isFlat = (lod) => /^0/.test(lod);

/** The model of an unpacked payload. */
export class Model {
  constructor({ head, columns }) {
    this.head = head;
    this.objects = head.objects;
    this.surfaces = head.surfaces;
    this.vocabulary = new Vocabulary(head, head.objects);
    // Levels of detail from coarse to fine; `order[l]` is the rank of level `l` of the payload.
    this.lods = [...head.lods].sort(byDetail);
    const rank = head.lods.map((lod) => this.lods.indexOf(lod));
    this.features = [];
    this.readFaces(columns, rank);
    this.readRuns();
    this.readPoints(columns);
    this.byId = new Map();
    this.features.forEach((feature, f) => {
      for (let o = feature.firstObject; o < feature.endObject; o += 1) {
        if (!this.byId.has(this.objects[o].id)) {
          this.byId.set(this.objects[o].id, f);
        }
      }
    });
  }

  readFaces(columns, rank) {
    const { head } = this;
    const faces = head.features.reduce((sum, feature) => sum + feature.faces, 0);
    const corners = columns.corners.count();
    const triangles = (columns.triangles.count() - faces) / 3;
    const places = readPlaces(
      columns.vertices,
      head.features.reduce((sum, feature) => sum + feature.vertices, 0),
    );
    this.centre = middle(places);
    this.positions = new Float32Array(corners * 3);
    this.triangles = new Uint32Array(triangles * 3);
    this.edges = new Uint32Array(corners * 2);
    this.faceFeature = new Uint32Array(faces);
    this.faceObject = new Uint32Array(faces);
    this.faceLod = new Uint8Array(faces);
    this.faceSurface = new Int32Array(faces);
    this.faceFaulty = new Uint8Array(faces);
    // Where the corners, triangle indices and edge indices of each face begin; one more entry for the end.
    this.faceCorner = new Uint32Array(faces + 1);
    this.faceTriangle = new Uint32Array(faces + 1);
    this.faceEdge = new Uint32Array(faces + 1);
    this.boxes = new Float32Array(head.features.length * 6);
    let [face, corner, triangle, edge, firstObject, firstVertex] = [0, 0, 0, 0, 0, 0];
    head.features.forEach((packed, f) => {
      const feature = this.addFeature(packed, firstObject, face);
      for (let last = face + packed.faces; face < last; face += 1) {
        this.faceFeature[face] = f;
        this.faceObject[face] = firstObject + columns.objects.next();
        this.faceLod[face] = rank[columns.lods.next()];
        this.faceSurface[face] = columns.surfaces.next() - 1;
        const first = corner;
        let vertex = 0;
        for (let rings = columns.rings.next(); rings > 0; rings -= 1) {
          const start = corner;
          const end = corner + columns.rings.next();
          for (; corner < end; corner += 1) {
            const packedCorner = columns.corners.next();
            vertex += unfold(Math.floor(packedCorner / 2));
            const place = (firstVertex + vertex) * 3;
            for (let axis = 0; axis < 3; axis += 1) {
              this.positions[corner * 3 + axis] = (places[place + axis] - this.centre[axis]) / head.steps_per_metre;
            }
            if (packedCorner % 2 === 1) {
              this.edges[edge++] = corner;
              this.edges[edge++] = corner + 1 < end ? corner + 1 : start;
            }
          }
        }
        for (let left = columns.triangles.next() * 3; left > 0; left -= 1) {
          this.triangles[triangle++] = first + columns.triangles.next();
        }
        this.faceCorner[face + 1] = corner;
        this.faceTriangle[face + 1] = triangle;
        this.faceEdge[face + 1] = edge;
      }
      feature.endFace = face;
      this.measure(f, feature);
      firstObject += packed.objects;
      firstVertex += packed.vertices;
    });
    this.edges = this.edges.slice(0, edge);
  }

  addFeature(packed, firstObject, firstFace) {
    const top = this.objects[firstObject];
    const feature = {
      id: top.id,
      kind: top.type,
      isBuilding: top.type === 'Building' || top.type === 'BuildingPart',
      isTerrain: top.type === 'TINRelief',
      attributes: top.attributes,
      firstObject,
      endObject: firstObject + packed.objects,
      firstFace,
      endFace: firstFace,
      faults: packed.faults,
      run: packed.run ?? null,
      best: -1,
    };
    for (const fault of packed.faults) {
      if (fault.face !== undefined) {
        this.faceFaulty[firstFace + fault.face] = 1;
      }
    }
    feature.isInvalid = packed.faults.some((fault) => !fault.about_labels);
    feature.isMislabelled = packed.faults.some((fault) => fault.about_labels);
    this.features.push(feature);
    return feature;
  }

  /** The box of a feature and its best level of detail. */
  measure(f, feature) {
    const box = this.boxes.subarray(f * 6, f * 6 + 6);
    box.set([Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity]);
    for (let i = this.faceCorner[feature.firstFace]; i < this.faceCorner[feature.endFace]; i += 1) {
      for (let axis = 0; axis < 3; axis += 1) {
        const value = this.positions[i * 3 + axis];
        box[axis] = Math.min(box[axis], value);
        box[axis + 3] = Math.max(box[axis + 3], value);
      }
    }
    for (let face = feature.firstFace; face < feature.endFace; face += 1) {
      feature.best = Math.max(feature.best, this.faceLod[face]);
    }
    feature.hasShape = feature.endFace > feature.firstFace;
  }

  /** Runs of faces of one object and one level of detail, in the order of the features. */
  readRuns() {
    const best = new Int16Array(this.objects.length).fill(-1);
    for (let face = 0; face < this.faceLod.length; face += 1) {
      best[this.faceObject[face]] = Math.max(best[this.faceObject[face]], this.faceLod[face]);
    }
    this.runs = [];
    this.features.forEach((feature) => {
      feature.firstRun = this.runs.length;
      for (let face = feature.firstFace; face < feature.endFace;) {
        const [object, lod, start] = [this.faceObject[face], this.faceLod[face], face];
        while (face < feature.endFace && this.faceObject[face] === object && this.faceLod[face] === lod) {
          face += 1;
        }
        // A footprint is no more to be seen where there is a solid on it.
        const isBest = lod === best[object] && !(isFlat(this.lods[lod]) && !isFlat(this.lods[feature.best]));
        // Buildings stand in the terrain at any level of detail.
        this.runs.push({ lod, isBest, isAlways: feature.isTerrain && isBest, start, end: face });
      }
      feature.endRun = this.runs.length;
    });
  }

  readPoints(columns) {
    const count = this.head.points?.shown ?? 0;
    const places = readPlaces(columns.points, count);
    this.points = new Float32Array(count * 3);
    this.classes = new Uint8Array(count);
    for (let i = 0; i < count; i += 1) {
      for (let axis = 0; axis < 3; axis += 1) {
        this.points[i * 3 + axis] = (places[i * 3 + axis] - this.centre[axis]) / this.head.steps_per_metre;
      }
      this.classes[i] = columns.classes.next();
    }
  }

  /** Whether a run is shown at a level of detail; -1 is the best of each object. */
  isShown(run, lod) {
    return lod === -1 || run.isAlways ? run.isBest : run.lod === lod;
  }

  /** The levels of detail between which there is a choice: those that more than the terrain has. */
  choices() {
    const has = (lod) => this.features.some((feature) => !feature.isTerrain && this.lodOf(feature, lod) === lod);
    const all = this.lods.map((_, lod) => lod);
    const some = all.filter(has);
    return some.length > 0 ? some : all;
  }

  /** The level of detail that a feature is shown at, -1 when it has none there. */
  lodOf(feature, lod) {
    return lod === -1
      ? feature.best
      : this.runs.slice(feature.firstRun, feature.endRun).some((run) => run.lod === lod)
        ? lod
        : -1;
  }

  /** The semantic surface of a face. */
  surfaceOf(face) {
    return this.faceSurface[face] < 0 ? null : this.surfaces[this.faceSurface[face]];
  }

  /** The outline of a face: pairs of corners. Edges that are drawn with the face on their other side are in it, too. */
  outline(face) {
    const sides = new Map();
    for (let i = this.faceTriangle[face]; i < this.faceTriangle[face + 1]; i += 3) {
      const corners = [0, 1, 2].map((k) => this.triangles[i + k]);
      corners.forEach((a, k) => {
        const side = [a, corners[(k + 1) % 3]].sort((x, y) => x - y);
        const key = side.join();
        sides.set(key, sides.has(key) ? null : side);
      });
    }
    // A side of two triangles is inside.
    return [...sides.values()].filter(Boolean).flat();
  }

  /** Area of a face in square metres. */
  area(face) {
    let area = 0;
    const p = this.positions;
    for (let i = this.faceTriangle[face]; i < this.faceTriangle[face + 1]; i += 3) {
      const [a, b, c] = [0, 1, 2].map((k) => this.triangles[i + k] * 3);
      const [ux, uy, uz] = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]];
      const [vx, vy, vz] = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
      area += Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx) / 2;
    }
    return area;
  }

  /** A place of the scene in coordinates of the CRS. */
  toCrs(place) {
    const { origin, metres_per_unit: unit, steps_per_metre: steps } = this.head;
    return place.map((metres, axis) => origin[axis] + (metres + this.centre[axis] / steps) / unit[axis]);
  }
}

/** Places as differences, in steps. */
function readPlaces(reader, count) {
  const places = new Float64Array(count * 3);
  const last = [0, 0, 0];
  for (let i = 0; i < places.length; i += 1) {
    last[i % 3] += reader.signed();
    places[i] = last[i % 3];
  }
  return places;
}

/** The middle of the box of places, in whole steps. */
function middle(places) {
  const [low, high] = [
    [Infinity, Infinity, Infinity],
    [-Infinity, -Infinity, -Infinity],
  ];
  for (let i = 0; i < places.length; i += 1) {
    low[i % 3] = Math.min(low[i % 3], places[i]);
    high[i % 3] = Math.max(high[i % 3], places[i]);
  }
  return low.map((value, axis) => (places.length > 0 ? Math.round((value + high[axis]) / 2) : 0));
}
