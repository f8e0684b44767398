// Colours of the steps beside those of the viewer's palette.

import { CATEGORIES } from '../../../view/page/src/palette.js';

/** The building's own points, and its footprint. */
export const MARK = '#d4178f';
export const OUTLINE = '#0a9f7a';

/** Planes that cut: roof, underside, scanned wall, footprint edge, height jump. */
export const PLANES = ['#c4533a', '#8f74bd', '#6f7f90', '#3f8ecb', '#e0a02f'];

/** What the cut decides. */
export const CUT = { inside: '#4f9bd9', overruledIn: '#e0a02f', outside: '#b9c0c8', overruledOut: '#c2332c' };

const parse = (hex) => [1, 3, 5].map((at) => Number.parseInt(hex.slice(at, at + 2), 16));
const hex = (values) => `#${values.map((value) => Math.round(value).toString(16).padStart(2, '0')).join('')}`;

const STOPS = ['#f2efe6', '#cfe0e8', '#8dbfe0', '#3f8ecb', '#12508f'].map(parse);

/** A probability of being inside: pale to blue. */
export function INSIDE(share) {
  const at = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1);
  const low = Math.min(Math.floor(at), STOPS.length - 2);
  return hex(STOPS[low].map((value, i) => value + (STOPS[low + 1][i] - value) * (at - low)));
}

/** A colour for one of many things, neighbours in number far apart in colour. */
export function many(i) {
  const base = parse(CATEGORIES[i % CATEGORIES.length]);
  // Another round of the same colours is paler.
  const pale = Math.min((Math.floor(i / CATEGORIES.length) % 4) * 0.2, 0.6);
  return hex(base.map((value) => value + (255 - value) * pale));
}
