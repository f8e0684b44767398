// From the scene, which is in metres around the middle of the building, to the CRS of the model, and back.

export class Frame {
  /** `centre` is the middle of the building in steps of the local frame of the head. */
  constructor({ origin, metres_per_unit: unit, steps_per_metre: steps }, centre) {
    this.origin = origin;
    this.unit = unit;
    this.middle = centre.map((value) => value / steps);
  }

  /** A place of the scene in the CRS. */
  toCrs(place) {
    return place.map((value, axis) => this.origin[axis] + (value + this.middle[axis]) / this.unit[axis]);
  }

  /** A place of the CRS in the scene. */
  toScene(place) {
    return place.map((value, axis) => (value - this.origin[axis]) * this.unit[axis] - this.middle[axis]);
  }

  /** A place of the plan of the CRS, at a height of the scene. */
  planToScene([x, y], z) {
    return [...this.toScene([x, y]), z];
  }

  /** A height of the scene in the CRS. */
  heightToCrs(z) {
    return this.origin[2] + (z + this.middle[2]) / this.unit[2];
  }

  heightToScene(height) {
    return (height - this.origin[2]) * this.unit[2] - this.middle[2];
  }

  /** A plane `{ normal, offset }` of the scene, normal · p + offset = 0, as the equation of the CRS. */
  planeToCrs({ normal, offset }) {
    const scaled = normal.map((value, axis) => value * this.unit[axis]);
    const moved = normal.reduce((sum, value, axis) => sum + value * this.middle[axis], 0);
    const shift = scaled.reduce((sum, value, axis) => sum + value * this.origin[axis], 0);
    return [...scaled, offset - moved - shift];
  }

  /** The plane of the scene of an equation of the CRS; its normal is a unit. */
  planeToScene([a, b, c, d]) {
    const normal = [a, b, c].map((value, axis) => value / this.unit[axis]);
    const moved = normal.reduce((sum, value, axis) => sum + value * this.middle[axis], 0);
    const shift = [a, b, c].reduce((sum, value, axis) => sum + value * this.origin[axis], 0);
    const length = Math.hypot(...normal) || 1;
    return { normal: normal.map((value) => value / length), offset: (d + moved + shift) / length };
  }
}
