// Colours of the page beside those of the viewer and of the steps.

import { CLASSES, NOTHING, RAMPS } from '../../../view/page/src/palette.js';
import { MARK, many } from '../../../explain/page/src/colours.js';

/** What is chosen or being made, and what is taken away. */
export const CHOSEN = MARK;
export const GONE = '#c2332c';
/** Marks inside and outside. */
export const MARKS = { inside: '#1f78d1', outside: '#e0701f' };
/** The model before any edit. */
export const BEFORE = { light: '#6a5acd', dark: '#b3a6ff' };
/** Faces where the colours of points tell: what is red is to be seen. */
export const QUIET = {
  light: { RoofSurface: '#a9b0b8', WallSurface: '#d9dcdf', GroundSurface: '#b3bba8', OuterCeilingSurface: '#b9b2cc' },
  dark: { RoofSurface: '#707a86', WallSurface: '#9aa2ab', GroundSurface: '#7c8475', OuterCeilingSurface: '#878099' },
};
/** A distance of so many metres has the last colour. */
export const FAR = 0.5;

const parse = (hex) => [1, 3, 5].map((at) => Number.parseInt(hex.slice(at, at + 2), 16));
const STOPS = ['#1f5fe0', '#5aa2f2', '#cfdbe3', '#dedacf', '#f5a352', '#e2381f'].map(parse);

/** From inside the model through on it to outside: blue, pale, red; `share` is from -1 to 1. */
export function signed(share) {
  const at = ((Math.min(Math.max(share, -1), 1) + 1) / 2) * (STOPS.length - 1);
  const low = Math.min(Math.floor(at), STOPS.length - 2);
  const mixed = STOPS[low].map((value, i) => Math.round(value + (STOPS[low + 1][i] - value) * (at - low)));
  return `#${mixed.map((value) => value.toString(16).padStart(2, '0')).join('')}`;
}

/** In steps: a colour of its own for every point would only cost time. */
const stepped = (share) => Math.round(share * 100) / 100;

/** From the 1st to the 99th of 100 values. */
function rangeOf(values) {
  const all = [...values].sort((a, b) => a - b);
  return [0.01, 0.99].map((share) => all[Math.floor(share * (all.length - 1))] ?? 0);
}

const heightsOf = ({ positions }) => Array.from({ length: positions.length / 3 }, (_, i) => positions[i * 3 + 2]);

function ramped(of, [low, high]) {
  return (set) => {
    const values = of(set);
    return (i) => RAMPS.plain(stepped(Math.min(Math.max((values[i] - low) / Math.max(high - low, 1e-3), 0), 1)));
  };
}

/** How points are coloured: `of(building)(points)(i)` is a colour; `legend` a ramp with its ends, or entries. */
export const COLOURINGS = [
  {
    key: 'residual',
    name: 'residual',
    title: 'How far points are from the model: red above or outside it, blue inside it',
    of: ({ points }) => {
      const { distances } = points;
      return (set) =>
        set === points && distances.length > 0 ? (i) => signed(stepped(distances[i] / FAR)) : () => NOTHING;
    },
    legend: () => ({ ramp: (share) => signed(share * 2 - 1), low: `${FAR} m inside`, high: `${FAR} m outside` }),
  },
  {
    key: 'height',
    name: 'height',
    title: 'Points by their height',
    of: (building) =>
      ramped(heightsOf, rangeOf(heightsOf(building.points.count > 0 ? building.points : building.cloud))),
    legend: ({ head, frame, points, cloud }) => {
      const ends = rangeOf(heightsOf(points.count > 0 ? points : cloud)).map((z) => frame.heightToCrs(z).toFixed(1));
      return { ramp: RAMPS.plain, low: ends[0], high: `${ends[1]} (${head.crs})` };
    },
  },
  {
    key: 'class',
    name: 'class',
    title: 'Points by their class',
    of: () => (set) => (i) => CLASSES[set.classes[i]]?.[1] ?? NOTHING,
    legend: ({ points, cloud }) => {
      const codes = [...new Set([...points.classes, ...cloud.classes])].sort((a, b) => a - b);
      return codes.map((code) => [CLASSES[code]?.[1] ?? NOTHING, CLASSES[code]?.[0] ?? 'class', String(code)]);
    },
  },
  {
    key: 'intensity',
    name: 'intensity',
    title: 'Points by the intensity of their echo',
    of: ({ points, cloud }) =>
      ramped(({ intensities }) => intensities, rangeOf([...points.intensities, ...cloud.intensities])),
    legend: ({ points, cloud }) => {
      const [low, high] = rangeOf([...points.intensities, ...cloud.intensities]);
      return { ramp: RAMPS.plain, low: String(low), high: String(high) };
    },
  },
  {
    key: 'plane',
    name: 'plane',
    title: 'Points by the plane that they are on',
    of:
      ({ points }) =>
      (set) =>
      (i) =>
        set === points && points.on[i] > 0 ? many(points.on[i] - 1) : NOTHING,
    legend: ({ points }) => [
      [many(0), 'planes, each of its own colour', ''],
      [NOTHING, 'points on no plane', String(points.on.filter((label) => label === 0).length)],
    ],
  },
];
