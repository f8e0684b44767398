// What the model can be coloured by, key by key. See colouring.js.

import { attribute, numberOf } from './colouring.js';
import { words } from './format.js';
import { CATEGORIES, KINDS, LABELS, LADDER, NOTHING, RAMPS, ROOF_TYPES, VALIDITY, categorical } from './palette.js';

/** The values of a concept of the vocabulary, of each feature. */
const valuesOfConcept = (model, key) => {
  const names = model.vocabulary.namesOf(key);
  return model.features.map((feature) => attribute(model, feature, names));
};

const isPresent = (value) => value !== undefined;

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
    title: 'Roof, wall, ground: what the file says each face is',
    reason: names.length > 0 ? null : 'the faces of this file have no semantics',
    scope: 'face',
    kind: 'categories',
    categories,
    nothing: 'no label',
    of: (face) => (model.faceSurface[face] < 0 ? byObject[model.faceObject[face]] : bySurface[model.faceSurface[face]]),
  };
}

function rmse(model) {
  const names = model.lods.map((lod) => model.vocabulary.namesOf(`rmse_lod${lod.replace('.', '')}`));
  const of = (feature, lod) => (lod < 0 ? Number.NaN : numberOf(attribute(model, feature, names[lod])));
  const isThere = model.features.some((feature) => model.lods.some((_, lod) => Number.isFinite(of(feature, lod))));
  return {
    key: 'rmse',
    lacks: 'gable_rmse_lod22',
    name: 'RMSE',
    title: 'How far the points lie from the nearest face: root mean square of the distances of each building',
    reason: isThere ? null : 'no building has gable_rmse_lod22 or a like attribute',
    scope: 'feature',
    kind: 'ramp',
    ramp: RAMPS.error,
    range: [0, 0.5],
    isFixed: true,
    care: 'high',
    unit: 'm',
    of,
  };
}

function confidence(model) {
  const ofSurface = model.surfaces.map((surface) => numberOf(surface.attributes.confidence));
  const ofFeature = valuesOfConcept(model, 'confidence').map(numberOf);
  const isThere = ofSurface.some(Number.isFinite) || ofFeature.some(Number.isFinite);
  const finest = model.lods.length - 1;
  const quality = isThere ? null : qualityIndicator(model);
  return (
    quality ?? {
      key: 'confidence',
      lacks: 'gable_confidence',
      name: 'Confidence',
      title: 'How sure the field is: of each roof surface, else of the building. What is low needs attention',
      reason: isThere ? null : 'no building has gable_confidence or a like attribute',
      scope: 'face',
      kind: 'ramp',
      ramp: RAMPS.trust,
      range: [0.5, 1],
      isFixed: true,
      care: 'low',
      unit: '',
      of: (face) => {
        const own = model.faceSurface[face] < 0 ? Number.NaN : ofSurface[model.faceSurface[face]];
        if (Number.isFinite(own)) {
          return own;
        }
        return model.faceLod[face] === finest ? ofFeature[model.faceFeature[face]] : Number.NaN;
      },
      ofFeature: (feature, _, f) => ofFeature[f],
    }
  );
}

/** Whether the 3DBAG holds a building for correct: its word for confidence; null in a model that does not say. */
function qualityIndicator(model) {
  const values = valuesOfConcept(model, 'quality').map((value) =>
    /^(true|1)$/i.test(String(value)) ? 0 : /^(false|0)$/i.test(String(value)) ? 1 : -1,
  );
  if (values.every((value) => value < 0)) {
    return null;
  }
  return {
    key: 'confidence',
    name: 'Confidence',
    title: 'The quality indicator of the 3DBAG',
    reason: null,
    scope: 'feature',
    kind: 'categories',
    categories: [
      { name: 'held for correct', colour: VALIDITY[0] },
      { name: 'possibly wrong', colour: VALIDITY[2] },
    ],
    nothing: 'not known',
    of: (feature, lod, f) => values[f],
  };
}

const LARGEST = ['gable_missing_largest', 'gable_excess_largest', 'gable_roofed_ground_largest'];

function completeness(model) {
  const largest = model.features.map((feature) =>
    Math.max(...LARGEST.map((name) => numberOf(attribute(model, feature, [name])))),
  );
  return {
    key: 'completeness',
    lacks: 'gable_missing_largest',
    name: 'Completeness',
    title:
      'Largest area that was scanned and is missing, that was not scanned and is modelled, or that is roofed ground',
    reason: largest.some(Number.isFinite) ? null : 'no building has gable_missing_largest',
    scope: 'feature',
    kind: 'ramp',
    ramp: RAMPS.error,
    range: [0, 10],
    isFixed: true,
    care: 'high',
    unit: 'm²',
    of: (feature, lod, f) => largest[f],
  };
}

/** The words of makers for one type of roof. */
const SAME_ROOF = {
  horizontal: 'flat',
  'single horizontal': 'flat',
  'multiple horizontal': 'multiple-flat',
  'no planes': 'could not detect',
  unknown: 'could not detect',
};

function roofType(model) {
  const texts = valuesOfConcept(model, 'roofType').map((value) =>
    typeof value === 'string' ? (SAME_ROOF[value] ?? value) : undefined,
  );
  const { categories, indices } = categorical(texts, ROOF_TYPES);
  return {
    key: 'roof-type',
    lacks: 'gable_roof_type',
    name: 'Roof type',
    title: 'Flat, several flat roofs, or slanted',
    reason: categories.length > 0 ? null : 'no building has gable_roof_type or a like attribute',
    scope: 'feature',
    kind: 'categories',
    categories: categories.map(({ name, colour }) => ({ name: words(name), colour })),
    nothing: 'not known',
    of: (feature, lod, f) => indices[f],
  };
}

/** How far buildings came, from the best to the last: what makers write, and what the page calls it. */
const STEPS = [
  ['LoD 2.2', /^lod22$|^standard/],
  ['LoD 2.2, tolerances × 2', /^lod22-coarse$/],
  ['LoD 2.2, tolerances × 4', /^lod22-coarsest$/],
  ['LoD 2.2 of what the tiles cover', /^partial$/],
  ['a block', /^lod12$|lod11/],
  ['footprint only', /^footprint$|^skip/],
];

function ladder(model) {
  const texts = valuesOfConcept(model, 'steps');
  const isIncomplete = valuesOfConcept(model, 'incomplete');
  const steps = texts.map((text, f) => {
    const step = isPresent(text) ? STEPS.findIndex(([, pattern]) => pattern.test(String(text))) : -1;
    // Before 2023 the 3DBAG says no more than whether a building was skipped.
    return step >= 0 || !isPresent(isIncomplete[f]) ? step : isIncomplete[f] === true ? STEPS.length - 1 : 0;
  });
  return {
    key: 'ladder',
    lacks: 'gable_ladder_step',
    name: 'Ladder step',
    title:
      'How far the building came: how many tolerances had to be widened before a model held, or what stands for it',
    reason: steps.some((step) => step >= 0) ? null : 'no building has gable_ladder_step or a like attribute',
    scope: 'feature',
    kind: 'categories',
    categories: STEPS.map(([name], i) => ({ name, colour: LADDER[i] })),
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
    categories: ['valid', 'valid, labels or attributes wrong', 'invalid', 'the face at fault'].map((name, i) => ({
      name,
      colour: VALIDITY[i],
    })),
    nothing: 'not checked',
    of: (face) => {
      const feature = model.features[model.faceFeature[face]];
      return model.faceFaulty[face] ? 3 : categoryOfValidity(feature);
    },
    ofFeature: categoryOfValidity,
  };
}

const categoryOfValidity = (feature) => (feature.isInvalid ? 2 : feature.isMislabelled ? 1 : 0);

function height(model) {
  const [top, ground] = [valuesOfConcept(model, 'roof_max'), valuesOfConcept(model, 'ground')];
  const metres = model.head.metres_per_unit[2];
  const heights = top.map((value, f) => (numberOf(value) - numberOf(ground[f])) * metres);
  return {
    key: 'height',
    lacks: 'gable_height_roof_max',
    name: 'Height',
    title: 'Highest point of the roof above the ground',
    reason: heights.some(Number.isFinite) ? null : 'no building has gable_height_roof_max or a like attribute',
    scope: 'feature',
    kind: 'ramp',
    ramp: RAMPS.plain,
    range: [0, 30],
    isFixed: true,
    care: null,
    unit: 'm',
    of: (feature, lod, f) => heights[f],
  };
}

function volume(model) {
  const names = model.lods.map((lod) => model.vocabulary.namesOf(`volume_lod${lod.replace('.', '')}`));
  const of = (feature, lod) => (lod < 0 ? Number.NaN : numberOf(attribute(model, feature, names[lod])));
  const isThere = model.features.some((feature) => model.lods.some((_, lod) => Number.isFinite(of(feature, lod))));
  return {
    key: 'volume',
    lacks: 'gable_volume_lod22',
    name: 'Volume',
    title: 'Volume of the building at the level of detail that is shown',
    reason: isThere ? null : 'no building has gable_volume_lod22 or a like attribute',
    scope: 'feature',
    kind: 'ramp',
    ramp: RAMPS.plain,
    range: [0, 2000],
    isFixed: true,
    care: null,
    unit: 'm³',
    of,
  };
}

/** The colourings of a model, in the order of their number keys. */
export const colourings = (model) =>
  [semantics, rmse, confidence, roofType, ladder, validity, completeness, height, volume].map((make) => make(model));
