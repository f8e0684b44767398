// The footprint: an edge that is offset, and a new one that is drawn.

import { element } from '../../../view/page/src/dom.js';
import { decimal } from '../../../view/page/src/format.js';
import { CHOSEN, GONE } from './colours.js';
import { pairsOf } from './picture.js';
import { Tool, button, numberField, says } from './tool.js';

/** What is so near to the pointer is meant, pixels. */
const NEAR = 14;

/** How far a place of the picture is from the line between two others, pixels. */
function fromEdge([x, y], [a, b], [c, d]) {
  const [u, v] = [c - a, d - b];
  const t = Math.min(Math.max(((x - a) * u + (y - b) * v) / Math.max(u * u + v * v, 1e-9), 0), 1);
  return Math.hypot(x - a - t * u, y - b - t * v);
}

/** The edges of the footprint: [a, b, where the exterior is on their right]. */
const edgesOf = (building) =>
  building.footprint().flatMap((polygon) =>
    polygon.flatMap((ring, hole) => {
      const area = ring.reduce((sum, [x, y], i) => {
        const [u, v] = ring[(i + 1) % ring.length];
        return sum + x * v - u * y;
      }, 0);
      // Seen from above the interior of an exterior ring that runs against the clock is on the left of its edges.
      const isLeft = area > 0 === (hole === 0);
      return ring.map((a, i) => ({ a, b: ring[(i + 1) % ring.length], isLeft }));
    }),
  );

export class Edge extends Tool {
  leave() {
    this.app.picture.erase('edge');
    this.app.picture.erase('edge-to');
    Object.assign(this, { edge: null, by: 0 });
  }

  under(event) {
    const { places } = this.app;
    const at = places.inCanvas(event.clientX, event.clientY);
    const far = (edge) => fromEdge(at, places.onScreen(edge.a), places.onScreen(edge.b));
    const best = edgesOf(this.building).reduce(
      (least, edge) => (least && far(least) <= far(edge) ? least : edge),
      null,
    );
    return best && far(best) < NEAR ? best : null;
  }

  outwards({ a, b, isLeft }) {
    const [u, v] = [b[0] - a[0], b[1] - a[1]];
    const length = Math.hypot(u, v) || 1;
    return (isLeft ? [v, -u] : [-v, u]).map((value) => value / length);
  }

  draw(edge = this.edge) {
    const { picture } = this.app;
    picture.drawLines('edge', edge ? [edge.a, edge.b] : [], CHOSEN, { width: 5, isHidden: true });
    const [x, y] = edge ? this.outwards(edge) : [0, 0];
    const to = (place) => [place[0] + x * this.by, place[1] + y * this.by, place[2]];
    const ring = this.edge && this.by !== 0 ? [edge.a, to(edge.a), to(edge.a), to(edge.b), to(edge.b), edge.b] : [];
    picture.drawLines('edge-to', ring, CHOSEN, { width: 3, isHidden: true });
  }

  down(event) {
    const edge = this.under(event);
    if (!edge) {
      return false;
    }
    Object.assign(this, { edge, by: 0 });
    this.from = this.app.places.atHeight(event.clientX, event.clientY, this.building.floor);
    return true;
  }

  drag(event) {
    const to = this.app.places.atHeight(event.clientX, event.clientY, this.building.floor);
    if (to && this.from) {
      const [x, y] = this.outwards(this.edge);
      this.by = Math.round(((to[0] - this.from[0]) * x + (to[1] - this.from[1]) * y) * 100) / 100;
      this.draw();
      this.app.showOptions();
    }
  }

  up() {
    this.draw();
    this.app.showOptions();
  }

  hover(event) {
    if (!this.edge) {
      this.draw(this.under(event));
    }
    return this.edge ? [`${decimal(this.by, 2)} m outwards`, 'Enter does it'] : null;
  }

  confirm() {
    if (this.edge && this.by !== 0) {
      const { frame } = this.building;
      const edge = [this.edge.a, this.edge.b].map((place) => frame.toCrs(place).slice(0, 2));
      this.app.act({ 'offset-edge': { edge, distance: this.by } });
    }
  }

  cancel() {
    const isAny = Boolean(this.edge);
    this.leave();
    this.app.showOptions();
    return isAny;
  }

  options() {
    if (!this.edge) {
      return [says('Drag an edge of the footprint outwards or inwards. 6 looks from straight above.')];
    }
    const set = (by) => {
      this.by = by;
      this.draw();
    };
    return [
      numberField('outwards', this.by, 'm', set, { id: 'edge-by' }),
      element(
        'div',
        { class: 'does' },
        button('Offset the edge', 'Enter', 'The edge stands there; those beside it follow', () => this.confirm(), {
          isMain: true,
        }),
      ),
    ];
  }
}

/** Moves corners of the footprint, puts new ones, or draws another outline. */
export class Redraw extends Tool {
  enter() {
    if (this.building) {
      this.polygons = this.building.footprint();
      Object.assign(this, { hasChanged: false, corner: null, isNew: false });
      this.draw();
    }
  }

  leave() {
    ['ring', 'ring-corners'].forEach((name) => this.app.picture.erase(name));
  }

  get rings() {
    return this.polygons.flat();
  }

  draw() {
    const { picture } = this.app;
    picture.drawLines('ring', this.rings.flatMap(pairsOf), CHOSEN, { width: 3, isHidden: true });
    const corners = this.rings.flat();
    picture.drawPoints('ring-corners', corners, (i) => (corners[i] === this.corner ? GONE : CHOSEN), 10, {
      isHidden: true,
    });
  }

  /** The corner under the pointer, and the middle of an edge, where a new one would be. */
  under(event) {
    const { places } = this.app;
    const [x, y] = places.inCanvas(event.clientX, event.clientY);
    const far = (place) => {
      const [u, v] = places.onScreen(place);
      return Math.hypot(u - x, v - y);
    };
    for (const ring of this.rings) {
      const at = ring.findIndex((corner) => far(corner) < NEAR);
      if (at >= 0) {
        return { ring, at };
      }
    }
    for (const ring of this.rings) {
      const at = ring.findIndex(
        (a, i) => fromEdge([x, y], places.onScreen(a), places.onScreen(ring[(i + 1) % ring.length])) < 7,
      );
      if (at >= 0) {
        return { ring, at, isBetween: true };
      }
    }
    return null;
  }

  down(event) {
    const hit = this.isNew ? null : this.under(event);
    if (!hit) {
      return false;
    }
    if (hit.isBetween) {
      const place = this.app.places.atHeight(event.clientX, event.clientY, this.building.floor);
      hit.at += 1;
      hit.ring.splice(hit.at, 0, place);
      this.hasChanged = true;
    }
    this.corner = hit.ring[hit.at];
    this.draw();
    return true;
  }

  drag(event) {
    const place = this.app.places.atHeight(event.clientX, event.clientY, this.building.floor);
    if (place) {
      this.corner.splice(0, 3, ...place);
      this.hasChanged = true;
      this.draw();
    }
  }

  up() {
    this.app.showOptions();
  }

  click(event) {
    const place = this.app.places.atHeight(event.clientX, event.clientY, this.building.floor);
    if (this.isNew && place) {
      this.polygons[0][0].push(place);
      this.hasChanged = true;
      this.draw();
      this.app.showOptions();
    }
  }

  hover(event) {
    if (this.isNew) {
      return [`corner ${this.rings[0].length + 1}`, 'Enter closes the outline'];
    }
    const hit = this.under(event);
    return hit ? [hit.isBetween ? 'drag: a new corner' : 'drag the corner', 'Del takes the last one away'] : null;
  }

  erase() {
    const ring = this.isNew ? this.rings[0] : this.rings.find((own) => own.includes(this.corner));
    const at = this.isNew ? ring.length - 1 : (ring?.indexOf(this.corner) ?? -1);
    if (ring && at >= 0 && (this.isNew || ring.length > 3)) {
      ring.splice(at, 1);
      this.hasChanged = true;
      this.corner = null;
      this.draw();
      this.app.showOptions();
    }
  }

  anew() {
    this.polygons = [[[]]];
    Object.assign(this, { isNew: true, hasChanged: false, corner: null });
    this.draw();
    this.app.showOptions();
  }

  confirm() {
    if (!this.hasChanged || this.rings.some((ring) => ring.length < 3)) {
      this.app.tell('An outline has at least three corners.');
      return;
    }
    const { frame } = this.building;
    const closed = (ring) => [...ring, ring[0]].map((place) => frame.toCrs(place).slice(0, 2));
    this.app.act({ 'redraw-footprint': { polygons: this.polygons.map((polygon) => polygon.map(closed)) } });
  }

  cancel() {
    const { hasChanged, isNew } = this;
    this.enter();
    this.app.showOptions();
    return hasChanged || isNew;
  }

  options() {
    const how = this.isNew
      ? 'Click the corners of the outline, one after the other.'
      : 'Drag corners; drag an edge for a new corner. 6 looks from straight above.';
    return [
      says(how),
      element(
        'div',
        { class: 'does' },
        button('Redraw it', 'Enter', 'This is the footprint', () => this.confirm(), {
          isMain: true,
          disabled: !this.hasChanged,
        }),
        button('Take corner', 'Del', 'Takes the last corner away', () => this.erase()),
        button('Draw anew', '⇧Del', 'Begins with nothing', () => this.anew()),
      ),
    ];
  }
}
