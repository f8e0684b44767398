// A colouring says of each face, or of the feature it belongs to, which category it is of or which number it has:
//   { key, name, reason (why it is not to be had, or null), lacks (the attribute that it needs), scope: 'face' | 'feature',
//     kind: 'categories', categories: [{ name, colour }], of(item) → index or -1
//     kind: 'ramp', ramp, range: [low, high], isFixed, unit, care, of(item) → number or NaN }
// `range` is the scale that a ramp has unless another is chosen (State.range); `isFixed` says that it is the same in every
// model. `care` is the end that needs attention: 'high', 'low', or null where neither does.

import { decimal } from './format.js';
import { NOTHING, RAMPS, categorical } from './palette.js';

export const numberOf = (value) => (typeof value === 'number' && Number.isFinite(value) ? value : Number.NaN);

/** The first of these attributes that a feature, or one of its parts, has. */
export function attribute(model, feature, names) {
  for (let o = feature.firstObject; o < feature.endObject; o += 1) {
    for (const name of names) {
      const value = model.objects[o].attributes[name];
      if (value !== undefined && value !== null) {
        return value;
      }
    }
  }
  return undefined;
}

/** A share of sorted numbers. */
export const quantile = (sorted, share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];

/** The scale of numbers, the outermost left out: from and to a round number. */
export function rangeOfValues(values) {
  const sorted = values.filter(Number.isFinite).sort((a, b) => a - b);
  if (sorted.length === 0) {
    return [0, 1];
  }
  let [low, high] = [quantile(sorted, 0.02), quantile(sorted, 0.98)];
  if (low === high) {
    [low, high] = [sorted[0], sorted[sorted.length - 1]];
  }
  const step = 10 ** Math.floor(Math.log10(high > low ? (high - low) / 4 : Math.max(Math.abs(high), 1)));
  const [from, to] = [Math.floor(low / step) * step, Math.ceil(high / step) * step];
  const digits = Math.max(0, -Math.floor(Math.log10(step)));
  return [from, to > from ? to : from + step].map((value) => Number(value.toFixed(digits)));
}

/** The scale that a ramp has at the moment. */
export const rangeOf = ({ colouring, range }) => range ?? colouring.range ?? [0, 1];

/** The values of a ramp, of each feature. */
export const valuesOf = (model, { colouring, lod }) =>
  model.features.map((feature, f) => valueOf(colouring, model, f, lod));

/** A colouring by any attribute of the features. */
export function byAttribute(model, name) {
  const values = model.features.map((feature) => attribute(model, feature, [name]));
  const known = model.vocabulary.known(name);
  const base = {
    key: `attribute:${name}`,
    name: known?.title ?? name,
    title: known ? known.meaning.charAt(0).toUpperCase() + known.meaning.slice(1) : undefined,
    attribute: name,
    reason: null,
    scope: 'feature',
    nothing: 'none',
  };
  const numbers = values.filter((value) => Number.isFinite(numberOf(value)));
  if (numbers.length > 0 && new Set(numbers).size > 2) {
    const range = known?.range ?? rangeOfValues(numbers);
    const of = (feature, lod, f) => numberOf(values[f]);
    return {
      ...base,
      ...{
        kind: 'ramp',
        ramp: RAMPS.plain,
        range,
        isFixed: Boolean(known?.range),
        unit: known?.unit ?? '',
        care: null,
      },
      of,
    };
  }
  const texts = values.map((value) => {
    if (value === undefined) {
      return undefined;
    }
    return typeof value === 'string' ? value : JSON.stringify(value);
  });
  const { categories, indices } = categorical(texts);
  return { ...base, kind: 'categories', categories, of: (feature, lod, f) => indices[f] };
}

/** Attributes of features that can be coloured by: those with at least two values, objects and long texts aside. */
export function attributeNames(model) {
  const found = new Map();
  for (const object of model.objects) {
    for (const [name, value] of Object.entries(object.attributes)) {
      const isPlain = ['number', 'boolean'].includes(typeof value) || (typeof value === 'string' && value.length <= 60);
      if (!isPlain) {
        continue;
      }
      const values = found.get(name) ?? new Set();
      if (values.size < 1000) {
        values.add(value);
      }
      found.set(name, values);
    }
  }
  const isUseful = ([, values]) => {
    const isText = [...values].some((value) => typeof value === 'string');
    return values.size > 1 && !(isText && values.size > 200);
  };
  return [...found]
    .filter(isUseful)
    .map(([name]) => name)
    .sort((a, b) => a.localeCompare(b));
}

/** The category or number of a feature at the level of detail `lod` (see Model.lodOf); NaN or -1 without one. */
export function valueOf(colouring, model, f, lod) {
  const feature = model.features[f];
  if (colouring.scope === 'feature') {
    return colouring.of(feature, model.lodOf(feature, lod), f);
  }
  return colouring.ofFeature ? colouring.ofFeature(feature, lod, f) : Number.NaN;
}

/** The value of a feature in words, or an empty text. */
export function valueText(colouring, model, f, lod) {
  const value = valueOf(colouring, model, f, lod);
  if (Number.isNaN(value)) {
    return '';
  }
  if (colouring.kind === 'ramp') {
    return `${decimal(value, 3)} ${colouring.unit}`.trim();
  }
  return colouring.categories[value]?.name ?? colouring.nothing;
}
