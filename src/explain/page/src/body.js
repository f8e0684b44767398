// A building as something to look at: where it is, and how far it reaches.

/** What has the least and greatest coordinates `low` and `high`, metres of the scene, and the polygons of its `outline`. */
export class Body {
  /** What the camera looks at, as the model of the viewer: the building, and room around it. */
  get model() {
    const room = Math.max(...this.high.map((value, axis) => value - this.low[axis])) * 0.8;
    const around = [
      ...this.low.map((value, axis) => (axis === 2 ? value : value - room)),
      ...this.high.map((value) => value + room),
    ];
    return {
      features: [
        { hasShape: true, isBuilding: true, kind: 'Building' },
        { hasShape: true, isBuilding: false, kind: 'Building' },
      ],
      boxes: new Float32Array([...this.low, ...this.high, ...around]),
    };
  }

  /** The corners of the building, at its floor and at its top, with its cells so far apart. */
  cornersOf(apart) {
    const [low, high] = [this.low, this.high];
    const ofBox = [
      [low[0], low[1]],
      [high[0], low[1]],
      [high[0], high[1]],
      [low[0], high[1]],
    ];
    const corners = this.outline.count > 0 ? chunksOf(this.outline.positions) : ofBox;
    const heights = [this.low[2], this.low[2] + (this.high[2] - this.low[2]) * (1 + apart)];
    return corners.flatMap(([x, y]) => heights.map((z) => [x * (1 + apart), y * (1 + apart), z]));
  }
}

/** Numbers three by three. */
const chunksOf = (numbers) =>
  Array.from({ length: numbers.length / 3 }, (_, i) => [...numbers.subarray(i * 3, i * 3 + 3)]);
