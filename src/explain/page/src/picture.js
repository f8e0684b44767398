// What the steps draw, in three.js: each layer of points, polygons or cells is made when it is first shown.

import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  Points,
  Raycaster,
  Vector2,
} from 'three';
import { place, wideLines } from '../../../view/page/src/marks.js';
import { toLinear } from '../../../view/page/src/palette.js';
import { Stage, pointMaterial } from '../../../view/page/src/stage.js';
import { explode, solidOf } from './cells.js';

/** Colours of items as a buffer: `owner` is the item of each entry. */
export function coloursOf(owner, of) {
  const known = new Map();
  const all = new Uint16Array(owner.length * 3);
  owner.forEach((item, i) => {
    const hex = of(item);
    if (!known.has(hex)) {
      known.set(
        hex,
        toLinear(hex).map((share) => Math.round(share * 65535)),
      );
    }
    all.set(known.get(hex), i * 3);
  });
  return new BufferAttribute(all, 3, true);
}

export class Picture extends Stage {
  constructor(canvas, building) {
    super(canvas, building.model);
    this.building = building;
    this.apart = 0;
    // Of its surroundings nothing need be in the picture.
    this.model.cornersOf = (f) => (f === 0 ? building.cornersOf(this.apart) : null);
    this.layers = [];
    this.raycaster = new Raycaster();
  }

  setTheme(name) {
    const theme = super.setTheme(name);
    this.layers.forEach(({ lines }) => lines?.material.color.set(theme.edge));
  }

  /** Takes everything away. */
  clear() {
    this.apart = 0;
    for (const { objects } of this.layers) {
      objects.forEach((object) => {
        this.scene.remove(object);
        object.geometry.dispose();
        object.material.dispose();
      });
    }
    this.layers = [];
    this.pointMaterials = [];
    this.castAnew();
    this.invalidate();
  }

  add(layer) {
    layer.objects.forEach((object) => {
      object.frustumCulled = false;
      this.scene.add(object);
    });
    this.layers.push(layer);
    this.castAnew();
    this.invalidate();
    return layer;
  }

  /** Points: `of(i)` is their colour, or null for those that are not shown; `size` is in pixels. */
  addPoints(positions, of, size = 2.2) {
    const shown = Array.from({ length: positions.length / 3 }, (_, i) => i).filter((i) => of(i) !== null);
    const geometry = new BufferGeometry();
    const places = new Float32Array(shown.length * 3);
    shown.forEach((i, at) => places.set(positions.subarray(i * 3, i * 3 + 3), at * 3));
    geometry.setAttribute('position', new BufferAttribute(places, 3));
    geometry.setAttribute('color', coloursOf(shown, of));
    const points = new Points(geometry, pointMaterial());
    points.material.userData.size = size;
    this.pointMaterials.push(points.material);
    const layer = this.add({ objects: [points] });
    this.resize(this.width, this.height);
    return layer;
  }

  resize(width, height) {
    super.resize(width, height);
    this.pointMaterials.forEach((material) => (material.size = material.userData.size ?? this.pointSize));
  }

  /**
   * Polygons: `of(polygon)` is their colour, or null for those that are not shown; `tell(polygon)` what is said of one.
   * `opacity` below 1 lets through what is behind.
   */
  addPolygons(polygons, of, { opacity = 1, tell = null, edges = 0.6, casts = opacity === 1 } = {}) {
    const isShown = Array.from({ length: polygons.count }, (_, i) => of(i) !== null);
    const position = new BufferAttribute(polygons.positions, 3);
    const kept = polygons.owner.flatMap((owner, t) => (isShown[owner] ? [t] : []));
    const index = new Uint32Array(kept.flatMap((t) => [...polygons.triangles.subarray(t * 3, t * 3 + 3)]));
    const cornerOwner = new Array(polygons.positions.length / 3).fill(0);
    polygons.edges.forEach((corner, i) => (cornerOwner[corner] = polygons.edgeOwner[i >> 1]));
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', position);
    geometry.setAttribute(
      'color',
      coloursOf(cornerOwner, (item) => of(item) ?? '#000000'),
    );
    geometry.setIndex(new BufferAttribute(index, 1));
    const mesh = this.mesh(geometry, opacity, casts);
    const owners = kept.map((t) => polygons.owner[t]);
    mesh.userData.item = (triangle) => owners[triangle];
    mesh.userData.tell = tell;
    const lines = this.lines(
      position,
      polygons.edges.filter((_, i) => isShown[polygons.edgeOwner[i >> 1]]),
      edges,
    );
    return this.add({ objects: [mesh, lines], lines });
  }

  mesh(geometry, opacity, casts) {
    const material = new MeshLambertMaterial({ vertexColors: true, flatShading: true, side: DoubleSide });
    Object.assign(material, { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    Object.assign(material, { shadowSide: DoubleSide, transparent: opacity < 1, opacity, depthWrite: opacity === 1 });
    const mesh = new Mesh(geometry, material);
    Object.assign(mesh, { castShadow: casts, receiveShadow: casts });
    return mesh;
  }

  lines(position, pairs, opacity) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', position);
    geometry.setIndex(new BufferAttribute(new Uint32Array(pairs), 1));
    const material = new LineBasicMaterial({ transparent: true, opacity });
    material.color.set(this.theme.edge);
    return new LineSegments(geometry, material);
  }

  /** The outline of the footprint, as a line of this colour. */
  addOutline(colour) {
    const { outline } = this.building;
    const lines = wideLines(2.5);
    place(lines, outline.positions, outline.edges);
    lines.material.color.set(colour);
    return this.add({ objects: [lines] });
  }

  /** Cells: `of(cell)` is their colour, or null for those that are not shown; `apart` moves them from each other. */
  addCells(of, apart, { opacity = 1, tell = null, edges = 0.6 } = {}) {
    const { cells, low } = this.building;
    const shown = cells.fixed.flatMap((_, cell) => (of(cell) === null ? [] : [cell]));
    const solid = solidOf(cells, shown);
    const position = new BufferAttribute(new Float32Array(solid.positions.length), 3);
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', position);
    geometry.setAttribute('color', coloursOf(solid.owner, of));
    geometry.setIndex(new BufferAttribute(solid.triangles, 1));
    const mesh = this.mesh(geometry, opacity, opacity === 1);
    mesh.userData.item = (triangle) => solid.owner[solid.triangles[triangle * 3]];
    mesh.userData.tell = tell;
    const lines = this.lines(position, solid.edges, edges);
    const layer = { objects: [mesh, lines], lines, solid, position, low };
    this.add(layer);
    this.moveApart(apart);
    return layer;
  }

  /** Moves the cells apart: 0 leaves them where they are, 1 doubles their distances. */
  moveApart(apart) {
    this.apart = apart;
    for (const { solid, position, low } of this.layers.filter((layer) => layer.solid)) {
      explode(solid, position.array, apart, low[2]);
      position.needsUpdate = true;
    }
    this.castAnew();
    this.invalidate();
  }

  /** What of `meshes` lies under a place of the window, the nearest first. */
  under(clientX, clientY, meshes) {
    const box = this.renderer.domElement.getBoundingClientRect();
    const place = new Vector2(((clientX - box.left) / box.width) * 2 - 1, 1 - ((clientY - box.top) / box.height) * 2);
    this.camera.updateMatrixWorld();
    this.raycaster.setFromCamera(place, this.camera);
    return this.raycaster.intersectObjects(meshes, false);
  }

  /** What is said of what lies under a place of the window; null where nothing is. */
  at(clientX, clientY) {
    const meshes = this.layers.flatMap(({ objects }) => objects.filter(({ userData }) => userData.tell));
    const [hit] = this.under(clientX, clientY, meshes);
    return hit ? hit.object.userData.tell(hit.object.userData.item(hit.faceIndex)) : null;
  }
}
