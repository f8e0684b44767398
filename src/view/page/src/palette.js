// Colours, as sRGB hex.

/** Semantic surfaces. */
export const LABELS = {
  RoofSurface: '#c4533a',
  WallSurface: '#eadfcb',
  GroundSurface: '#8a9a78',
  OuterCeilingSurface: '#8f74bd',
  OuterFloorSurface: '#d08f3c',
  ClosureSurface: '#9aa7b5',
  Window: '#6db3dd',
  Door: '#8a5a33',
  InteriorWallSurface: '#d9cdb8',
  CeilingSurface: '#c9b6e0',
  FloorSurface: '#b79f7d',
  WaterSurface: '#4f93c9',
  WaterGroundSurface: '#3c6f98',
  TrafficArea: '#8d8f94',
  AuxiliaryTrafficArea: '#a8aaa2',
};

/** Objects other than buildings, where their faces have no label. */
export const KINDS = {
  TINRelief: '#b4c29c',
  LandUse: '#c9cfa5',
  PlantCover: '#7fa86a',
  SolitaryVegetationObject: '#6f9a5b',
  WaterBody: '#6fa8d0',
  Waterway: '#5f97c0',
  Road: '#9a9ca1',
  TransportSquare: '#a9a6a0',
  Railway: '#7d7f86',
  Bridge: '#b5a48d',
  BridgePart: '#b5a48d',
  Tunnel: '#8f8677',
};

/** What has no value, or no label. */
export const NOTHING = '#aab0b8';

/** What a filter leaves out. */
export const GHOST = { light: '#dcdfe3', dark: '#33383f' };

/** Values without an order. Distinct for people with any colour vision (after Okabe and Ito 2008). */
export const CATEGORIES = [
  '#0072b2',
  '#e69f00',
  '#009e73',
  '#cc79a7',
  '#56b4e9',
  '#d55e00',
  '#7f6fc4',
  '#9b8b00',
  '#7a4a2a',
  '#4d5a66',
];

/** Types of roofs: each of the same colour in every model. */
export const ROOF_TYPES = {
  flat: '#56b4e9',
  'multiple-flat': '#0072b2',
  slanted: '#e69f00',
  'no points': '#8c8794',
  'could not detect': '#5b5563',
};

/** Steps of the ladder, from the best to the last. */
export const LADDER = ['#2c7fb8', '#7fc5c2', '#f4dc7a', '#b79ad6', '#ee8a3d', '#c2332c'];

/** Valid, labels wrong, invalid, the face at fault. */
export const VALIDITY = ['#7fb2dc', '#efc14e', '#ee8a7c', '#b3121d'];

/** From good to bad, through pale: blue, yellow, red. */
const GOOD_TO_BAD = ['#2f6fb3', '#73b3d8', '#d6e8d0', '#fbe58f', '#f39b4d', '#c92f26'];

/** From low to high, neither being better (after viridis). */
const LOW_TO_HIGH = ['#5b3fa0', '#4b62b3', '#3d86bd', '#35a6a6', '#5cc287', '#b8dd4a', '#fde725'];

/**
 * Values of an attribute as categories, those of known colours first, then the most frequent; beyond ten the rest is one. Gives
 * the categories, and of each value the index of its own, or -1.
 */
export function categorical(values, preferred = {}) {
  const counts = new Map();
  values.filter((value) => value !== undefined).forEach((value) => counts.set(value, (counts.get(value) ?? 0) + 1));
  const ranks = Object.keys(preferred);
  const rank = (value) => (ranks.includes(value) ? ranks.indexOf(value) : ranks.length);
  const order = [...counts.keys()].sort(
    (a, b) => rank(a) - rank(b) || counts.get(b) - counts.get(a) || a.localeCompare(b),
  );
  const named = order.slice(0, order.length > CATEGORIES.length ? CATEGORIES.length - 1 : order.length);
  const free = CATEGORIES.filter((colour) => !Object.values(preferred).includes(colour)).values();
  const categories = named.map((value) => ({ name: value, colour: preferred[value] ?? free.next().value ?? NOTHING }));
  if (named.length < order.length) {
    categories.push({ name: `${order.length - named.length} other values`, colour: CATEGORIES[CATEGORIES.length - 1] });
  }
  const index = new Map(named.map((value, i) => [value, i]));
  return {
    categories,
    indices: values.map((value) => (value === undefined ? -1 : (index.get(value) ?? named.length))),
  };
}

const parse = (hex) => [1, 3, 5].map((at) => Number.parseInt(hex.slice(at, at + 2), 16));

function ramp(stops) {
  const parsed = stops.map(parse);
  return (share) => {
    const at = Math.min(Math.max(share, 0), 1) * (parsed.length - 1);
    const low = Math.min(Math.floor(at), parsed.length - 2);
    const mixed = parsed[low].map((value, i) => Math.round(value + (parsed[low + 1][i] - value) * (at - low)));
    return `#${mixed.map((value) => value.toString(16).padStart(2, '0')).join('')}`;
  };
}

/** Ramps: a share from 0 to 1 as a colour. */
export const RAMPS = {
  error: ramp(GOOD_TO_BAD),
  trust: ramp([...GOOD_TO_BAD].reverse()),
  plain: ramp(LOW_TO_HIGH),
};

/** ASPRS classes of points: name and colour. */
export const CLASSES = {
  0: ['never classified', '#8e949b'],
  1: ['unclassified', '#a3a9b0'],
  2: ['ground', '#a5814f'],
  3: ['low vegetation', '#9ccc7a'],
  4: ['medium vegetation', '#5ea84a'],
  5: ['high vegetation', '#2f7d32'],
  6: ['building', '#1f78d1'],
  8: ['key point', '#c08f5a'],
  9: ['water', '#39a9c9'],
  17: ['bridge', '#8e63b5'],
};

const linear = (value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);

/** A colour as three linear shares, as the renderer takes them. */
export const toLinear = (hex) => parse(hex).map((value) => linear(value / 255));
