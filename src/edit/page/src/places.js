// What lies under the pointer: points, faces, cells, planes, and places of the floor.

import { Vector3 } from 'three';

/** Points so near to the pointer are meant, pixels. */
const NEAR = 9;

export class Places {
  constructor(picture) {
    this.picture = picture;
    this.last = '';
  }

  /** Where the points of the building are in the picture: x, y in pixels of the canvas, and how far away; three numbers each. */
  projected(building) {
    const { camera, width, height } = this.picture;
    camera.updateMatrixWorld();
    const matrix = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).elements;
    const key = `${matrix.join()} ${width} ${height}`;
    if (this.last === key && this.of === building) {
      return this.places;
    }
    const { positions, count } = building.points;
    const places = new Float32Array(count * 3);
    for (let i = 0; i < count * 3; i += 3) {
      const [x, y, z] = [positions[i], positions[i + 1], positions[i + 2]];
      const w = matrix[3] * x + matrix[7] * y + matrix[11] * z + matrix[15];
      places[i] = ((matrix[0] * x + matrix[4] * y + matrix[8] * z + matrix[12]) / w + 1) * 0.5 * width;
      places[i + 1] = (1 - (matrix[1] * x + matrix[5] * y + matrix[9] * z + matrix[13]) / w) * 0.5 * height;
      places[i + 2] = w;
    }
    Object.assign(this, { places, last: key, of: building });
    return places;
  }

  /** Where a place of the scene is in the picture, pixels of the canvas. */
  onScreen(place) {
    const { camera, width, height } = this.picture;
    camera.updateMatrixWorld();
    const { x, y } = new Vector3(...place).project(camera);
    return [((x + 1) / 2) * width, ((1 - y) / 2) * height];
  }

  /** Pixels of the canvas of a place of the window. */
  inCanvas(clientX, clientY) {
    const box = this.picture.renderer.domElement.getBoundingClientRect();
    return [clientX - box.left, clientY - box.top];
  }

  isShown(building, i) {
    return !building.points.excluded[i] && !this.picture.isCut(building.pointAt(i));
  }

  /** The point nearest to the eye of those near the pointer; -1 where none is. */
  pointAt(building, x, y, near = NEAR) {
    const places = this.projected(building);
    let [best, least] = [-1, Infinity];
    for (let i = 0; i < building.points.count; i += 1) {
      const away = Math.hypot(places[i * 3] - x, places[i * 3 + 1] - y);
      // A metre in front weighs as much as some pixels aside.
      if (away < near && places[i * 3 + 2] + away * 0.05 < least && this.isShown(building, i)) {
        [best, least] = [i, places[i * 3 + 2] + away * 0.05];
      }
    }
    return best;
  }

  /** The nearest item of layers of `kinds` under the pointer: { kind, item, place, normal }; null where none is. */
  itemAt(clientX, clientY, kinds) {
    const hits = this.picture.under(clientX, clientY, this.picture.pickable(kinds));
    const hit = hits.find(({ point }) => !this.picture.isCut(point.toArray()));
    if (!hit) {
      return null;
    }
    // The normal looks at the eye.
    const towards = this.picture.camera.position.clone().sub(hit.point);
    const normal = hit.face.normal.dot(towards) < 0 ? hit.face.normal.clone().negate() : hit.face.normal;
    const { kind, item } = hit.object.userData;
    return { kind, item: item(hit.faceIndex), place: hit.point.toArray(), normal: normal.toArray() };
  }

  /** Where the line of sight through a place of the window meets a plane; null where it does not. */
  onPlane(clientX, clientY, { normal, offset }) {
    // With no mesh to look for, this only aims.
    this.picture.under(clientX, clientY, []);
    const { origin, direction } = this.picture.raycaster.ray;
    const [n, o, d] = [new Vector3(...normal), origin, direction];
    const slope = n.dot(d);
    const t = -(n.dot(o) + offset) / slope;
    return Math.abs(slope) > 1e-9 && t > 0 ? o.clone().addScaledVector(d, t).toArray() : null;
  }

  /** Where the line of sight meets a level plane. */
  atHeight(clientX, clientY, z) {
    return this.onPlane(clientX, clientY, { normal: [0, 0, 1], offset: -z });
  }

  /** The place that is meant: a point, else a place of a face, else one of the floor. */
  placeAt(building, clientX, clientY) {
    const [x, y] = this.inCanvas(clientX, clientY);
    const point = this.pointAt(building, x, y, 7);
    if (point >= 0) {
      return building.pointAt(point);
    }
    return this.itemAt(clientX, clientY, ['result'])?.place ?? this.atHeight(clientX, clientY, building.floor);
  }
}
