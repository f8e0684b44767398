// What the model can be coloured by.
//
// A colouring says of each face, or of the feature it belongs to, which category it is of or which number it has:
//   { key, name, reason (why it is not to be had, or null), lacks (the attribute that it needs), scope: 'face' | 'feature',
//     kind: 'categories', categories: [{ name, colour }], of(item) → index or -1
//     kind: 'ramp', ramp, range: [low, high], unit, of(item) → number or NaN }

import { decimal, words } from './format.js';
import { CATEGORIES, KINDS, LABELS, LADDER, NOTHING, RAMPS } from './palette.js';

const STEPS = ['lod22', 'lod22-coarse', 'lod22-coarsest', 'lod12', 'footprint'];
const STEP_NAMES = ['LoD 2.2', 'LoD 2.2, tolerances × 2', 'LoD 2.2, tolerances × 4', 'LoD 1.2', 'footprint only'];

/** Names of an attribute: gable's first, then those of the 3DBAG and of its tool. */
const RMSE = (lod) => ['gable', 'b3', 'rf'].map((maker) => `${maker}_rmse_lod${lod.replace('.', '')}`);
const ROOF_TYPE = ['gable_roof_type', 'b3_dak_type', 'rf_roof_type'];

const numberOf = (value) => (typeof value === 'number' && Number.isFinite(value) ? value : Number.NaN);

/** The first of these attributes that a feature, or one of its parts, has. */
function attribute(model, feature, names) {
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
const quantile = (sorted, share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];

/** A number of one or two digits that is not below. */
function roundUp(value) {
  if (!(value > 0)) {
    return 1;
  }
  const scale = 10 ** Math.floor(Math.log10(value));
  return [1, 1.5, 2, 3, 4, 5, 6, 8, 10].map((step) => step * scale).find((step) => step >= value * 0.999) ?? value;
}

function semantics(model) {
  const known = { ...LABELS, ...KINDS };
  const order = Object.keys(known);
  // What has no label is of the type of its object, unless that is a building: there the label is what is asked for.
  const ofObject = model.objects.map((object) => (/^Building/.test(object.type) ? null : object.type));
  const found = new Set(model.surfaces.map((surface) => surface.type));
  model.faceSurface.forEach(
    (surface, face) => surface < 0 && ofObject[model.faceObject[face]] && found.add(ofObject[model.faceObject[face]]),
  );
  const rank = (name) => (order.includes(name) ? order.indexOf(name) : order.length);
  const names = [...found].sort((a, b) => rank(a) - rank(b) || a.localeCompare(b));
  const free = CATEGORIES.values();
  const categories = names.map((name) => ({
    name: name || 'no type',
    colour: known[name] ?? free.next().value ?? NOTHING,
  }));
  const index = new Map(names.map((name, i) => [name, i]));
  const [bySurface, byObject] = [
    model.surfaces.map((surface) => index.get(surface.type)),
    ofObject.map((kind) => index.get(kind) ?? -1),
  ];
  return {
    key: 'semantics',
    name: 'Semantics',
    reason: names.length > 0 ? null : 'the faces of this file have no semantics',
    scope: 'face',
    kind: 'categories',
    categories,
    nothing: 'no label',
    of: (face) => (model.faceSurface[face] < 0 ? byObject[model.faceObject[face]] : bySurface[model.faceSurface[face]]),
  };
}

function rmse(model) {
  const names = model.lods.map(RMSE);
  const of = (feature, lod) => (lod < 0 ? Number.NaN : numberOf(attribute(model, feature, names[lod])));
  const all = model.features.flatMap((feature) => model.lods.map((_, lod) => of(feature, lod))).filter(Number.isFinite);
  const best = model.features
    .map((feature) => of(feature, feature.best))
    .filter(Number.isFinite)
    .sort((a, b) => a - b);
  return {
    key: 'rmse',
    lacks: 'gable_rmse_lod22',
    name: 'RMSE',
    title: 'Root mean square distance of the points to the model',
    reason: all.length > 0 ? null : 'no building has gable_rmse_lod22 or a like attribute',
    scope: 'feature',
    kind: 'ramp',
    ramp: RAMPS.error,
    range: [0, Math.max(0.2, roundUp(quantile(best, 0.95) ?? 0.2))],
    unit: 'm',
    of,
  };
}

function confidence(model) {
  const ofSurface = model.surfaces.map((surface) => numberOf(surface.attributes.confidence));
  const ofFeature = model.features.map((feature) => numberOf(attribute(model, feature, ['gable_confidence'])));
  const isThere = ofSurface.some(Number.isFinite) || ofFeature.some(Number.isFinite);
  const finest = model.lods.length - 1;
  return {
    key: 'confidence',
    lacks: 'gable_confidence',
    name: 'Confidence',
    title: 'How sure the field is: of each roof surface, else of the building',
    reason: isThere ? null : 'no building has gable_confidence',
    scope: 'face',
    kind: 'ramp',
    ramp: RAMPS.trust,
    range: [0.5, 1],
    unit: '',
    of: (face) => {
      const own = model.faceSurface[face] < 0 ? Number.NaN : ofSurface[model.faceSurface[face]];
      if (Number.isFinite(own)) {
        return own;
      }
      return model.faceLod[face] === finest ? ofFeature[model.faceFeature[face]] : Number.NaN;
    },
    ofFeature: (feature, _, f) => ofFeature[f],
  };
}

const FAULTS = ['gable_missing_largest', 'gable_excess_largest', 'gable_roofed_ground_largest'];

function completeness(model) {
  const largest = model.features.map((feature) =>
    Math.max(...FAULTS.map((name) => numberOf(attribute(model, feature, [name])))),
  );
  return {
    key: 'completeness',
    lacks: 'gable_missing_largest',
    name: 'Completeness',
    title: 'Largest area that was scanned and is missing, that was not scanned and is modelled, or that is roofed ground',
    reason: largest.some(Number.isFinite) ? null : 'no building has gable_missing_largest',
    scope: 'feature',
    kind: 'ramp',
    ramp: RAMPS.error,
    range: [0, 10],
    unit: 'm²',
    of: (feature, lod, f) => largest[f],
  };
}

/** Values of an attribute as categories, the most frequent first; beyond ten the rest is one. */
function categorical(values, preferred = []) {
  const counts = new Map();
  values.filter((value) => value !== undefined).forEach((value) => counts.set(value, (counts.get(value) ?? 0) + 1));
  const rank = (value) => (preferred.includes(value) ? preferred.indexOf(value) : preferred.length);
  const order = [...counts.keys()].sort(
    (a, b) => rank(a) - rank(b) || counts.get(b) - counts.get(a) || a.localeCompare(b),
  );
  const named = order.slice(0, order.length > CATEGORIES.length ? CATEGORIES.length - 1 : order.length);
  const categories = named.map((value, i) => ({ name: words(value), colour: CATEGORIES[i] }));
  if (named.length < order.length) {
    categories.push({ name: `${order.length - named.length} other values`, colour: CATEGORIES[CATEGORIES.length - 1] });
  }
  const index = new Map(named.map((value, i) => [value, i]));
  return {
    categories,
    indices: values.map((value) => (value === undefined ? -1 : (index.get(value) ?? named.length))),
  };
}

function roofType(model) {
  const values = model.features.map((feature) => attribute(model, feature, ROOF_TYPE));
  const texts = values.map((value) => (typeof value === 'string' ? value : undefined));
  const { categories, indices } = categorical(texts, [
    'flat',
    'multiple-flat',
    'slanted',
    'horizontal',
    'multiple horizontal',
  ]);
  return {
    key: 'roof-type',
    lacks: 'gable_roof_type',
    name: 'Roof type',
    reason: categories.length > 0 ? null : 'no building has gable_roof_type',
    scope: 'feature',
    kind: 'categories',
    categories,
    nothing: 'not known',
    of: (feature, lod, f) => indices[f],
  };
}

function ladder(model) {
  const steps = model.features.map((feature) => STEPS.indexOf(attribute(model, feature, ['gable_ladder_step'])));
  return {
    key: 'ladder',
    lacks: 'gable_ladder_step',
    name: 'Ladder step',
    title: 'How many tolerances had to be widened before the model held',
    reason: steps.some((step) => step >= 0) ? null : 'no building has gable_ladder_step',
    scope: 'feature',
    kind: 'categories',
    categories: STEP_NAMES.map((name, i) => ({ name, colour: LADDER[i] })),
    nothing: 'not known',
    of: (feature, lod, f) => steps[f],
  };
}

function validity(model) {
  return {
    key: 'validity',
    name: 'Validity',
    title: 'As gable validate finds it',
    reason: null,
    scope: 'face',
    kind: 'categories',
    categories: [
      { name: 'valid', colour: '#7fb2dc' },
      { name: 'valid, labels or attributes wrong', colour: '#efc14e' },
      { name: 'invalid', colour: '#ee8a7c' },
      { name: 'the face at fault', colour: '#b3121d' },
    ],
    nothing: 'not checked',
    of: (face) => {
      const feature = model.features[model.faceFeature[face]];
      return model.faceFaulty[face] ? 3 : categoryOfValidity(feature);
    },
    ofFeature: categoryOfValidity,
  };
}

const categoryOfValidity = (feature) => (feature.isInvalid ? 2 : feature.isMislabelled ? 1 : 0);

/** A colouring by any attribute of the features. */
export function byAttribute(model, name) {
  const values = model.features.map((feature) => attribute(model, feature, [name]));
  const base = { key: `attribute:${name}`, name, reason: null, scope: 'feature', nothing: 'none' };
  const numbers = values.filter((value) => typeof value === 'number' && Number.isFinite(value));
  if (numbers.length > 0 && new Set(numbers).size > 2) {
    const sorted = numbers.sort((a, b) => a - b);
    const [low, high] = [quantile(sorted, 0.02), quantile(sorted, 0.98)];
    const unit = model.head.attributes.find((known) => known.name === name)?.unit ?? '';
    const range =
      low < high
        ? [low, high]
        : [sorted[0], sorted[sorted.length - 1] + (sorted[0] === sorted[sorted.length - 1] ? 1 : 0)];
    return { ...base, kind: 'ramp', ramp: RAMPS.plain, range, unit, of: (feature, lod, f) => numberOf(values[f]) };
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

/** The colourings of a model, in the order of their number keys. */
export const colourings = (model) =>
  [semantics, rmse, confidence, roofType, ladder, validity, completeness].map((make) => make(model));

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
