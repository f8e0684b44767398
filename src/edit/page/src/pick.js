// Picking points with a brush or a lasso: for a plane through them, or to leave them out.

import { element } from '../../../view/page/src/dom.js';
import { counted, decimal } from '../../../view/page/src/format.js';
import { CHOSEN } from './colours.js';
import { fitted, hullOf, lieOf, onto, rmsOf } from './planes.js';
import { chosenPlane } from './select.js';
import { Tool, button, says } from './tool.js';

/** The brush reaches so far, pixels, and picks what is no farther behind its first point than this, metres. */
const [BRUSH, DEPTH] = [16, 1];
/** Points are left out with what lies so near to them, metres, or nearer where another point does. */
const NEAR = 0.1;
/** More places make a plane no better. */
const MOST = 400;

/** Whether a place is in a polygon: crossings of a ray to the right. */
export function isIn(ring, x, y) {
  let inside = false;
  for (let i = 0, j = ring.length - 1; i < ring.length; j = i, i += 1) {
    const [[a, b], [c, d]] = [ring[i], ring[j]];
    if (b > y !== d > y && x < ((c - a) * (y - b)) / (d - b) + a) {
      inside = !inside;
    }
  }
  return inside;
}

/** At most so many of some places, evenly, with those of the hull among them. */
function someOf(places, hull) {
  if (places.length <= MOST) {
    return places;
  }
  const step = places.length / (MOST - hull.length);
  const even = Array.from({ length: MOST - hull.length }, (_, i) => places[Math.floor(i * step)]);
  return [...new Set([...hull, ...even])];
}

export class Pick extends Tool {
  constructor(app, isLasso) {
    super(app);
    this.isLasso = isLasso;
    this.lie = 'free';
  }

  get picked() {
    return this.app.picked;
  }

  enter() {
    this.draw();
  }

  leave(isForGood) {
    this.app.outlineAt(null);
    if (isForGood) {
      this.picked.clear();
      this.draw();
    }
  }

  down(event) {
    this.isOut = event.altKey;
    if (!event.shiftKey && !event.altKey && this.isLasso) {
      this.picked.clear();
    }
    this.path = [this.app.places.inCanvas(event.clientX, event.clientY)];
    this.front = null;
    if (!this.isLasso) {
      this.brush(this.path[0]);
    }
    return true;
  }

  drag(event) {
    const place = this.app.places.inCanvas(event.clientX, event.clientY);
    if (this.isLasso) {
      this.path.push(place);
      this.app.outlineAt(this.path);
    } else {
      // Between two events the brush has been everywhere.
      const [x, y] = this.path[0];
      const steps = Math.ceil(Math.hypot(place[0] - x, place[1] - y) / (BRUSH / 2));
      for (let i = 1; i <= steps; i += 1) {
        this.brush([x + ((place[0] - x) * i) / steps, y + ((place[1] - y) * i) / steps]);
      }
      this.path = [place];
      this.app.outlineAt(circle(place));
    }
  }

  up() {
    if (this.isLasso && this.path.length > 2) {
      const { building, app } = this;
      const places = app.places.projected(building);
      for (let i = 0; i < building.points.count; i += 1) {
        if (isIn(this.path, places[i * 3], places[i * 3 + 1]) && app.places.isShown(building, i)) {
          this.take(i);
        }
      }
    }
    this.app.outlineAt(null);
    this.draw();
    this.app.showOptions();
  }

  take(i) {
    if (this.isOut) {
      this.picked.delete(i);
    } else {
      this.picked.add(i);
    }
  }

  brush([x, y]) {
    const { building, app } = this;
    const places = app.places.projected(building);
    const under = [];
    for (let i = 0; i < building.points.count; i += 1) {
      if (Math.hypot(places[i * 3] - x, places[i * 3 + 1] - y) < BRUSH && app.places.isShown(building, i)) {
        under.push(i);
      }
    }
    if (under.length > 0) {
      // What is behind a roof is not meant.
      const front = under.reduce((least, i) => Math.min(least, places[i * 3 + 2]), Infinity);
      under.filter((i) => places[i * 3 + 2] < front + DEPTH).forEach((i) => this.take(i));
      this.draw(false);
    }
  }

  get places() {
    return [...this.picked].sort((a, b) => a - b).map((i) => this.building.pointAt(i));
  }

  /** How the plane is to lie: as `fitted` takes it. */
  get wanted() {
    const chosen = chosenPlane(this.app);
    return this.lie === 'free'
      ? null
      : this.lie === 'parallel'
        ? chosen
          ? { parallel: chosen.normal }
          : null
        : this.lie;
  }

  /** The plane through the points shall lie so, or as they lie if it was to lie so before. */
  align(lie) {
    if (lie === 'parallel' && !chosenPlane(this.app)) {
      this.app.tell('Choose a plane first that it is to be parallel to: press S and click one.');
      return;
    }
    this.lie = this.lie === lie ? 'free' : lie;
    this.draw();
    this.app.showOptions();
  }

  draw(isDone = true) {
    const { picture } = this.app;
    const places = this.building ? this.places : [];
    picture.drawPoints('picked', places, () => CHOSEN, 6);
    this.plane = isDone ? fitted(places, this.wanted) : null;
    if (isDone) {
      const ring = this.plane
        ? hullOf(
            this.plane,
            places.map((place) => onto(this.plane, place)),
          )
        : [];
      picture.drawRing('fit', ring, CHOSEN, { opacity: 0.25 });
    }
  }

  hover(event) {
    if (!this.isLasso) {
      this.app.outlineAt(circle(this.app.places.inCanvas(event.clientX, event.clientY)));
    }
    return null;
  }

  out() {
    this.app.outlineAt(null);
  }

  confirm() {
    const { building, plane, places } = this;
    if (!plane) {
      this.app.tell('Pick at least three points that are not in one line.');
      return;
    }
    const corners = hullOf(plane, places).map((corner) => nearestOf(places, corner));
    const action = { places: someOf(places, [...new Set(corners)]).map((place) => building.frame.toCrs(place)) };
    const chosen = chosenPlane(this.app);
    if (this.lie === 'parallel' && chosen) {
      action.lie = { parallel: chosen.at.equation.slice(0, 3) };
    } else if (this.lie === 'level' || this.lie === 'vertical') {
      action.lie = this.lie;
    }
    this.app.act({ 'add-plane': action }).then((isDone) => isDone && this.drop());
  }

  erase() {
    const { building, picked } = this;
    if (picked.size === 0) {
      this.app.tell('Pick the points that are none of the building first.');
      return;
    }
    const places = this.places;
    // No nearer than half way to the points that stay.
    const rest = Array.from({ length: building.points.count }, (_, i) => i).filter(
      (i) => !picked.has(i) && !building.points.excluded[i],
    );
    const radius = Math.max(
      Math.min(
        NEAR,
        leastBetween(
          places,
          rest.map((i) => building.pointAt(i)),
        ) / 2,
      ),
      0.01,
    );
    const region = { near: { places: places.map((place) => building.frame.toCrs(place)), radius } };
    this.app.act({ 'exclude-points': { region } }).then((isDone) => isDone && this.drop());
  }

  drop() {
    this.picked.clear();
    this.draw();
    this.app.showOptions();
  }

  cancel() {
    const isAny = this.picked.size > 0;
    this.drop();
    return isAny;
  }

  options() {
    const { picked, plane } = this;
    const how = this.isLasso
      ? 'Draw around points; with Shift more of them, with Alt fewer. It takes what is behind, too.'
      : 'Drag over points; with Alt over those that are not meant. It takes what is in front.';
    const chosen = chosenPlane(this.app);
    const lies = [
      ['free', 'as the points lie'],
      ['level', 'level'],
      ['vertical', 'vertical'],
      ...(chosen ? [['parallel', 'parallel to the chosen plane']] : []),
    ];
    const select = element(
      'select',
      {
        id: 'lie',
        'aria-label': 'How the plane lies',
        onchange: () => ((this.lie = select.value), this.draw(), this.app.showOptions()),
      },
      lies.map(([value, name]) => element('option', { value, selected: value === this.lie }, name)),
    );
    const told = plane
      ? `${counted(picked.size, 'point')}; a plane at ${decimal(lieOf(plane).slope, 1)}° passes them with an rms of ${decimal(rmsOf(plane, this.places), 3)} m.`
      : picked.size > 0
        ? `${counted(picked.size, 'point')}: too few for a plane, or in one line.`
        : how;
    return [
      says(told),
      element(
        'label',
        { class: 'row', title: 'How the plane lies (H level, V vertical, Y parallel to the chosen one)' },
        element('span', {}, 'lies'),
        select,
      ),
      element(
        'div',
        { class: 'does' },
        button('Add plane', 'Enter', 'A plane through the points', () => this.confirm(), {
          isMain: true,
          disabled: !plane,
        }),
        button('Exclude points', 'Del', 'The points are none of the building: a tree, a crane', () => this.erase(), {
          disabled: picked.size === 0,
        }),
      ),
    ];
  }
}

const circle = ([x, y]) =>
  Array.from({ length: 24 }, (_, i) => [
    x + BRUSH * Math.cos((i * Math.PI) / 12),
    y + BRUSH * Math.sin((i * Math.PI) / 12),
  ]);

const gap = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

const nearestOf = (places, place) =>
  places.reduce((best, other) => (gap(other, place) < gap(best, place) ? other : best));

/** The least distance between two sets of places, if it is below a metre: by cubes of a metre. */
function leastBetween(some, others) {
  const key = (p, dx = 0, dy = 0, dz = 0) =>
    `${Math.floor(p[0]) + dx} ${Math.floor(p[1]) + dy} ${Math.floor(p[2]) + dz}`;
  const cubes = new Map();
  others.forEach((place) => {
    const own = key(place);
    cubes.set(own, [...(cubes.get(own) ?? []), place]);
  });
  let least = 1;
  const around = [-1, 0, 1];
  for (const place of some) {
    for (const dx of around) {
      for (const dy of around) {
        for (const dz of around) {
          (cubes.get(key(place, dx, dy, dz)) ?? []).forEach((other) => (least = Math.min(least, gap(place, other))));
        }
      }
    }
  }
  return least;
}
