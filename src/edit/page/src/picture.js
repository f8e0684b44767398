// What is drawn of a building: layers, made anew after each edit; above them what the tools draw; and what the section cuts off.

import { BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshBasicMaterial, Plane, Points, Vector3 } from 'three';
import { coloursOf, Picture as Layers } from '../../../explain/page/src/picture.js';
import { wideLines } from '../../../view/page/src/marks.js';
import { pointMaterial } from '../../../view/page/src/stage.js';
import { nothing } from './building.js';

/** What tools draw is drawn after the layers. */
const ABOVE = 8;

export class Picture extends Layers {
  constructor(canvas) {
    super(canvas, nothing());
    this.drawn = new Map();
    this.cuts = [];
  }

  /** Shows another building, or the same one after an edit. */
  setBuilding(building) {
    this.building = building;
    this.setModel(building.model);
    this.model.cornersOf = (f) => (f === 0 ? building.cornersOf(0) : null);
  }

  clear() {
    super.clear();
    this.drawn.forEach(({ object }) => object.isPoints && this.pointMaterials.push(object.material));
  }

  /** Meshes of layers whose items can be picked: those of `kinds`. */
  pickable(kinds) {
    const objects = this.layers.flatMap((layer) => layer.objects.map((object) => [layer, object]));
    return objects.flatMap(([layer, object]) => (object.isMesh && kinds.includes(layer.kind) ? [object] : []));
  }

  /** Takes away what a tool drew under a name. */
  erase(name) {
    const known = this.drawn.get(name);
    if (known) {
      this.scene.remove(known.object);
      known.object.geometry.dispose();
      known.object.material.dispose();
      this.pointMaterials = this.pointMaterials.filter((material) => material !== known.object.material);
      this.drawn.delete(name);
      this.invalidate();
    }
  }

  put(name, object, order = ABOVE) {
    this.erase(name);
    Object.assign(object, { frustumCulled: false, renderOrder: order });
    this.drawn.set(name, { object });
    this.scene.add(object);
    this.invalidate();
    return object;
  }

  /** Lines between pairs of places: `pairs` is a flat list of places, two by two. */
  drawLines(name, pairs, colour, { width = 2.5, isHidden = false, opacity = 1 } = {}) {
    if (pairs.length < 2) {
      this.erase(name);
      return;
    }
    // Over all that is in front, where a tool needs it.
    const lines = wideLines(width, isHidden ? { depthTest: false } : {});
    lines.geometry.setPositions(new Float32Array(pairs.flat()));
    lines.material.color.set(colour);
    lines.material.opacity = opacity;
    this.put(name, lines);
  }

  /** Places as points, `of(i)` their colours. */
  drawPoints(name, places, of, size = 6, { isHidden = false } = {}) {
    if (places.length === 0) {
      this.erase(name);
      return;
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(places.flat()), 3));
    geometry.setAttribute(
      'color',
      coloursOf(
        places.map((_, i) => i),
        of,
      ),
    );
    const points = new Points(geometry, pointMaterial());
    points.material.userData.size = size;
    // After what shines through, and over all that is in front.
    Object.assign(points.material, isHidden ? { depthTest: false, transparent: true } : {});
    this.put(name, points);
    this.pointMaterials.push(points.material);
    this.resize(this.width, this.height);
  }

  /** A convex ring as a translucent face with an outline. */
  drawRing(name, ring, colour, { opacity = 0.3, width = 2.5, isHidden = false } = {}) {
    if (ring.length < 3) {
      this.erase(name);
      this.erase(`${name}-edge`);
      return;
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(ring.flat()), 3));
    geometry.setIndex(ring.slice(2).flatMap((_, i) => [0, i + 1, i + 2]));
    const material = new MeshBasicMaterial({
      color: colour,
      transparent: true,
      opacity,
      side: DoubleSide,
      depthWrite: false,
      depthTest: !isHidden,
    });
    this.put(name, new Mesh(geometry, material), ABOVE - 1);
    this.drawLines(`${name}-edge`, pairsOf(ring), colour, { width, isHidden });
  }

  eraseRing(name) {
    this.erase(name);
    this.erase(`${name}-edge`);
  }

  /** Cuts away what lies below any of these planes, `{ normal, offset }`. */
  setCuts(cuts) {
    this.cuts = cuts;
    this.renderer.clippingPlanes = cuts.map(({ normal, offset }) => new Plane(new Vector3(...normal), offset));
    this.invalidate();
  }

  /** Whether a place is cut away. */
  isCut(place) {
    return this.cuts.some(
      ({ normal, offset }) => normal[0] * place[0] + normal[1] * place[1] + normal[2] * place[2] + offset < -1e-6,
    );
  }
}

/** The edges of a ring, as pairs of places. */
export const pairsOf = (ring) => ring.flatMap((place, i) => [place, ring[(i + 1) % ring.length]]);

/** A line through places, as pairs of them. */
export const chainOf = (places) => places.slice(1).flatMap((place, i) => [places[i], place]);
