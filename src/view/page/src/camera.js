// Where the viewer stands: orbit, pan, zoom to the pointer, and flights.

import { Box3, MOUSE, TOUCH, Vector3 } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

/** How long a flight takes, milliseconds. */
const FLIGHT = 550;

/** Between a building and what would cover it, pixels. */
const GAP = 16;

export class Camera {
  constructor(view, canvas) {
    this.view = view;
    this.controls = new OrbitControls(view.camera, canvas);
    Object.assign(this.controls, {
      zoomToCursor: true,
      screenSpacePanning: false,
      zoomSpeed: 1.6,
      maxPolarAngle: Math.PI * 0.98,
    });
    this.controls.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.DOLLY, RIGHT: MOUSE.PAN };
    this.controls.touches = { ONE: TOUCH.ROTATE, TWO: TOUCH.DOLLY_PAN };
    this.controls.addEventListener('change', () => {
      this.hasMoved = true;
      view.invalidate();
    });
    this.controls.addEventListener('start', () => this.leave());
    view.beforeFrame.push((now) => this.beforeFrame(now));
    this.measure();
    this.controls.minDistance = 0.5;
    view.camera.position.set(10, -10, 10);
    // By how many pixels the picture is moved to the left, and shall be: what a flight goes to is not behind the panel.
    [this.shift, this.wantedShift] = [0, 0];
    this.isCalm = window.matchMedia('(prefers-reduced-motion: reduce)').matches;
  }

  /** Takes in what there is to look at: again after the view got another model. */
  measure() {
    const { model } = this.view;
    // Terrain reaches farther than what one looks for.
    const shaped = model.features.flatMap((feature, f) => (feature.hasShape ? [f] : []));
    this.buildings = shaped.filter((f) => model.features[f].isBuilding);
    this.buildings = this.buildings.length > 0 ? this.buildings : shaped;
    this.whole = boxOf(
      model,
      model.features.map((_, f) => f),
    );
    this.controls.maxDistance = this.radius(this.whole) * 12;
    this.cast = null;
  }

  radius(box) {
    return Math.max(box.getSize(new Vector3()).length() / 2, 2);
  }

  /** From now on the viewer goes where they want: a flight ends, and a change of the window leaves the view as it is. */
  leave() {
    this.flight = null;
    this.fitted = null;
  }

  /** By how much the needle of a compass is turned from the top of the picture, radians. */
  get azimuth() {
    const { x, y } = new Vector3(1, 0, 0).applyQuaternion(this.view.camera.quaternion);
    return Math.atan2(y, x);
  }

  /** Turns to the north, around what is looked at. */
  faceNorth() {
    this.leave();
    const target = this.controls.target.clone();
    const offset = this.view.camera.position.clone().sub(target);
    const across = Math.max(Math.hypot(offset.x, offset.y), offset.length() * 1e-3);
    this.go({ target, position: target.clone().add(new Vector3(0, -across, offset.z)) }, FLIGHT);
  }

  /**
   * Moves the picture, and no more than is needed, so that a feature is not behind what covers so many pixels at its right;
   * what was pointed at, `x` pixels from the left, is in any case not.
   */
  reveal(f, covered, x) {
    const { clientWidth: width } = this.view.renderer.domElement;
    const [left, right] = this.reachOnScreen(f).map((edge) => edge + this.shift);
    const free = width - covered - 2 * GAP;
    const wanted = Math.min(right - free, left - GAP);
    this.wantedShift = Math.max(wanted, x + this.shift - free, 0);
    this.view.invalidate();
  }

  /** The corners of a feature that are to be in the picture: those that the model names, else those of its box. */
  cornersOf(f) {
    const { model } = this.view;
    const axis = (i, bit, at) => model.boxes[f * 6 + at + (i & bit ? 3 : 0)];
    const ofBox = () => [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [axis(i, 1, 0), axis(i, 2, 1), axis(i, 4, 2)]);
    return (model.cornersOf?.(f) ?? ofBox()).map((corner) => new Vector3(...corner));
  }

  /** From where to where the box of a feature reaches in the picture, pixels from the left. */
  reachOnScreen(f) {
    const { camera, renderer } = this.view;
    camera.updateMatrixWorld();
    const all = this.cornersOf(f).map(
      (corner) => ((corner.project(camera).x + 1) / 2) * renderer.domElement.clientWidth,
    );
    return [Math.min(...all), Math.max(...all)];
  }

  /** Keeps so many pixels at the right free of what is flown to. */
  keepFree(pixels) {
    this.wantedShift = pixels / 2;
    this.view.invalidate();
  }

  /** Fits anew what still is as it was fitted, after a change of the window. */
  refit() {
    if (this.fitted) {
      this.fit(this.fitted.fromAbove);
    }
  }

  /** Looks at all of the model from the south-east, or from straight above. */
  fit(fromAbove = false, milliseconds = 0) {
    this.fitted = { fromAbove };
    const direction = fromAbove ? new Vector3(0, -0.001, 1) : new Vector3(0.42, -0.78, 0.62);
    this.fly(this.buildings, direction.normalize(), milliseconds);
  }

  /** Looks at features from where the viewer stands, or steeply enough to see their roofs. */
  lookAt(features, milliseconds = FLIGHT) {
    this.leave();
    const direction = this.view.camera.position.clone().sub(this.controls.target).normalize();
    direction.z = Math.max(direction.z, 0.45);
    this.fly(features, direction.normalize(), milliseconds, 1.9);
  }

  fly(features, direction, milliseconds = FLIGHT, room = 1) {
    const to = this.standFor(features, direction, room);
    if (to !== null) {
      this.go(to, milliseconds);
    }
  }

  /** Goes to where one stands and looks at, in so many milliseconds. */
  go(to, milliseconds) {
    const { camera } = this.view;
    if (milliseconds === 0 || this.isCalm) {
      this.flight = null;
      this.controls.target.copy(to.target);
      camera.position.copy(to.position);
      this.controls.update();
    } else {
      this.flight = {
        to,
        from: { target: this.controls.target.clone(), position: camera.position.clone() },
        milliseconds,
      };
    }
    this.view.invalidate();
  }

  /** Where to stand in a direction so that the boxes of features just fill the picture; null without a box. */
  standFor(features, direction, room) {
    const { camera, model } = this.view;
    const centre = boxOf(model, features).getCenter(new Vector3());
    const right = new Vector3().crossVectors(camera.up, direction).normalize();
    const up = new Vector3().crossVectors(direction, right);
    const slopes = [camera.aspect, 1].map((aspect) => aspect * Math.tan((camera.fov * Math.PI) / 360));
    // A point that lies x to the right and z towards the viewer is in the picture from distance d where |x - shift| is at most
    // (d - z) · slope: the largest of x + z · slope and of z · slope - x tell the least d and its shift.
    const reach = [
      [-Infinity, -Infinity],
      [-Infinity, -Infinity],
    ];
    for (const f of features.filter((f) => model.features[f].hasShape)) {
      for (const corner of this.cornersOf(f)) {
        corner.sub(centre);
        const towards = corner.dot(direction);
        [corner.dot(right), corner.dot(up)].forEach((aside, way) => {
          reach[way][0] = Math.max(reach[way][0], towards * slopes[way] + aside);
          reach[way][1] = Math.max(reach[way][1], towards * slopes[way] - aside);
        });
      }
    }
    if (reach[0][0] === -Infinity) {
      return null;
    }
    const [[x, y], least] = [
      reach.map(([more, less]) => (more - less) / 2),
      reach.map(([more, less], way) => (more + less) / 2 / slopes[way]),
    ];
    const distance = Math.max(...least, 3) * 1.06 * room;
    const target = centre.addScaledVector(right, x).addScaledVector(up, y);
    return { target, position: target.clone().addScaledVector(direction, distance) };
  }

  /** Moves along the ground by shares of the distance, or turns by radians. */
  pan(right, ahead) {
    const { camera } = this.view;
    const away = camera.position.distanceTo(this.controls.target);
    const across = new Vector3().setFromMatrixColumn(camera.matrix, 0);
    const forward = new Vector3().crossVectors(camera.up, across);
    const step = across.multiplyScalar(right * away).addScaledVector(forward, ahead * away);
    camera.position.add(step);
    this.controls.target.add(step);
    this.moved();
  }

  turn(around, over) {
    const { camera } = this.view;
    const offset = camera.position.clone().sub(this.controls.target);
    const away = offset.length();
    const azimuth = Math.atan2(offset.y, offset.x) + around;
    const polar = Math.min(Math.max(Math.acos(offset.z / away) + over, 0.01), Math.PI * 0.95);
    offset.set(Math.cos(azimuth) * Math.sin(polar), Math.sin(azimuth) * Math.sin(polar), Math.cos(polar));
    camera.position.copy(this.controls.target).addScaledVector(offset, away);
    this.moved();
  }

  zoom(factor) {
    const { camera } = this.view;
    const offset = camera.position.clone().sub(this.controls.target).multiplyScalar(factor);
    camera.position.copy(this.controls.target).add(offset);
    this.moved();
  }

  moved() {
    this.leave();
    this.controls.update();
    this.view.invalidate();
  }

  beforeFrame(now) {
    const { camera } = this.view;
    if (this.flight) {
      this.flight.started ??= now;
      const share = Math.min((now - this.flight.started) / this.flight.milliseconds, 1);
      const eased = share < 0.5 ? 4 * share ** 3 : 1 - (2 - 2 * share) ** 3 / 2;
      const { from, to } = this.flight;
      this.controls.target.lerpVectors(from.target, to.target, eased);
      // Around what is looked at, and not through it.
      const [before, after] = [from, to].map(({ position, target }) => position.clone().sub(target));
      const away = before.length() + (after.length() - before.length()) * eased;
      camera.position.lerpVectors(before, after, eased).setLength(away).add(this.controls.target);
      this.flight = share < 1 ? this.flight : null;
      this.controls.update();
      this.view.invalidate();
    }
    this.slide();
    if (this.hasMoved) {
      this.hasMoved = false;
      this.view.keepUp(now);
    }
    const away = camera.position.distanceTo(this.controls.target);
    const reach = this.radius(this.whole);
    const middle = camera.position.distanceTo(this.whole.getCenter(new Vector3()));
    camera.near = Math.max(away / 400, middle - reach * 1.6, 0.05);
    camera.far = middle + reach * 2.5;
    camera.updateProjectionMatrix();
    this.view.setScale((2 * away * Math.tan((camera.fov * Math.PI) / 360)) / Math.max(this.view.height ?? 1, 1));
    this.castAround(away);
  }

  /** Brings the picture nearer to where it shall be. */
  slide() {
    const left = this.wantedShift - this.shift;
    if (left !== 0) {
      this.shift = this.isCalm || Math.abs(left) < 1 ? this.wantedShift : this.shift + left * 0.2;
      this.view.invalidate();
    }
    const { clientWidth: width, clientHeight: height } = this.view.renderer.domElement;
    if (this.shift === 0) {
      this.view.camera.clearViewOffset();
    } else {
      this.view.camera.setViewOffset(width, height, this.shift, 0, width, height);
    }
  }

  /** The shadow map covers what is looked at; where that is all, it is cast once. */
  castAround(away) {
    const all = this.radius(this.whole);
    const wanted = Math.min(all, Math.max(away * 0.9, 40));
    const centre = wanted === all ? this.whole.getCenter(new Vector3()) : this.controls.target;
    const last = this.cast;
    const isGood =
      last &&
      last.radius / wanted < 1.8 &&
      wanted <= last.radius &&
      centre.distanceTo(last.centre) <= last.radius - wanted + 1e-6;
    if (!isGood) {
      const radius = wanted === all ? all : Math.min(wanted * 1.3, all);
      this.cast = { radius, centre: radius === all ? this.whole.getCenter(new Vector3()) : centre.clone() };
      this.view.fitShadow(this.cast.centre, this.cast.radius);
    }
  }
}

/** The box of features. */
function boxOf(model, features) {
  const box = new Box3();
  for (const f of features) {
    if (model.features[f].hasShape) {
      const own = model.boxes.subarray(f * 6, f * 6 + 6);
      box.expandByPoint(new Vector3(own[0], own[1], own[2]));
      box.expandByPoint(new Vector3(own[3], own[4], own[5]));
    }
  }
  return box;
}
