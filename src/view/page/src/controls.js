// The controls of the side panel: colourings, levels of detail, points.

import { attributeNames, byAttribute } from './colouring.js';
import { element, refill } from './dom.js';
import { counted, lodName, whole } from './format.js';
import { CLASSES, NOTHING, RAMPS } from './palette.js';

/** Radio buttons: arrow keys move between them. */
function radio(node) {
  node.addEventListener('keydown', (event) => {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    const buttons = [...node.querySelectorAll('[role=radio]:not(:disabled)')];
    const at = buttons.indexOf(document.activeElement);
    if (by && at >= 0) {
      event.preventDefault();
      event.stopPropagation();
      const next = buttons[(at + by + buttons.length) % buttons.length];
      next.focus();
      next.click();
    }
  });
}

/** Makes the buttons of the colourings; `all` are those of the number keys. */
export function makeColourings(model, state, all, { node, select, row, reason }) {
  const buttons = all.map((colouring, i) =>
    element(
      'button',
      {
        class: 'option',
        type: 'button',
        role: 'radio',
        disabled: colouring.reason !== null,
        title: colouring.reason === null ? colouring.title : `Not to be had: ${colouring.reason}`,
        'data-key': colouring.key,
        onclick: () => state.set({ colouring }),
      },
      colouring.name,
      element('kbd', { 'aria-hidden': 'true' }, String(i + 1)),
    ),
  );
  refill(node, buttons);
  radio(node);
  const missing = all.filter((colouring) => colouring.reason !== null);
  reason.hidden = missing.length === 0;
  const lacking = missing.flatMap(({ lacks }) => lacks ?? []);
  const others = missing.filter(({ lacks }) => lacks === undefined).map(({ name, reason: why }) => `${name}: ${why}.`);
  refill(reason, [lacking.length > 0 ? `Greyed out: no building has ${lacking.join(', ')}.` : '', ...others].join(' '));
  const names = attributeNames(model);
  row.hidden = names.length === 0;
  const titleOf = (name) => model.vocabulary.known(name)?.title ?? name;
  const isTwice = (title) => names.filter((name) => titleOf(name) === title).length > 1;
  const title = (name) => (isTwice(titleOf(name)) ? `${titleOf(name)} (${name})` : titleOf(name));
  select.append(...names.map((name) => element('option', { value: name, title: name }, title(name))));
  select.addEventListener('change', () => {
    state.set({ colouring: select.value ? byAttribute(model, select.value) : all.find((one) => one.reason === null) });
  });
  const mark = () => {
    buttons.forEach((button) => {
      const isChosen = button.dataset.key === state.colouring.key;
      button.setAttribute('aria-checked', String(isChosen));
      button.tabIndex = isChosen || (!all.includes(state.colouring) && button === buttons[0]) ? 0 : -1;
    });
    select.value = state.colouring.attribute ?? '';
  };
  state.listen((changed) => changed.has('colouring') && mark());
  mark();
}

/** Makes the switch of the levels of detail. */
export function makeLods(model, state, node, note) {
  const choices = [-1, ...model.choices()];
  const name = (lod) => (lod === -1 ? 'Best' : model.lods[lod] || 'no LoD');
  const title = (lod) => (lod === -1 ? 'The best level of detail of each building' : lodName(model.lods[lod]));
  const buttons = choices.map((lod) =>
    element(
      'button',
      {
        type: 'button',
        role: 'radio',
        title: title(lod),
        'data-lod': lod === -1 ? 'best' : model.lods[lod],
        onclick: () => state.set({ lod }),
      },
      name(lod),
    ),
  );
  refill(node, buttons);
  radio(node);
  const mark = () => {
    buttons.forEach((button, i) => {
      button.setAttribute('aria-checked', String(choices[i] === state.lod));
      button.tabIndex = choices[i] === state.lod ? 0 : -1;
    });
    const lacking = model.features.filter(
      (feature) => feature.isBuilding && model.lodOf(feature, state.lod) < 0,
    ).length;
    note.hidden = lacking === 0;
    refill(
      note,
      state.lod === -1
        ? `${counted(lacking, 'building')} without geometry.`
        : `${counted(lacking, 'building')} without ${lodName(model.lods[state.lod])}.`,
    );
  };
  state.listen((changed) => changed.has('lod') && mark());
  mark();
  return choices;
}

/** Makes the controls of the points, if there are any. */
export function makePoints(model, state, node) {
  const { points } = model.head;
  if (!points || points.shown === 0) {
    refill(
      node,
      element(
        'p',
        { class: 'note' },
        points ? 'The tiles have no point around the buildings.' : 'No points: gable view --points TILES shows them.',
      ),
    );
    return;
  }
  const count =
    points.shown < points.of ? `${whole(points.shown)} of ${whole(points.of)}, an even sample` : whole(points.shown);
  const box = element('input', {
    type: 'checkbox',
    id: 'points',
    onchange: () => state.set({ arePointsShown: box.checked }),
  });
  const select = element(
    'select',
    { 'aria-label': 'Colour of the points', onchange: () => state.set({ pointColouring: select.value }) },
    element('option', { value: 'class' }, 'by class'),
    element('option', { value: 'height' }, 'by height'),
  );
  const legend = element('div', {});
  refill(
    node,
    element(
      'div',
      { class: 'row' },
      element('label', {}, box, 'Points ', element('kbd', { 'aria-hidden': 'true' }, 'P')),
      select,
    ),
    element('p', { class: 'note' }, `${count} within 3 m of the buildings.`),
    legend,
  );
  const classes = [...new Set(model.classes)].sort((a, b) => a - b);
  const update = () => {
    box.checked = state.arePointsShown;
    select.value = state.pointColouring;
    const isByClass = state.arePointsShown && state.pointColouring === 'class';
    const entry = (code) =>
      element(
        'div',
        { class: 'entry' },
        element('i', { style: { background: CLASSES[code]?.[1] ?? NOTHING } }),
        element('span', {}, CLASSES[code]?.[0] ?? 'class'),
        element('b', {}, String(code)),
      );
    refill(legend, isByClass ? element('div', { class: 'entries' }, classes.map(entry)) : null);
  };
  state.listen((changed) => (changed.has('arePointsShown') || changed.has('pointColouring')) && update());
  update();
}

/** The colour of a point. */
export function pointColours(model, how) {
  if (how === 'class') {
    return (i) => CLASSES[model.classes[i]]?.[1] ?? NOTHING;
  }
  const heights = Array.from({ length: model.classes.length }, (_, i) => model.points[i * 3 + 2]).sort((a, b) => a - b);
  const [low, high] = [0.01, 0.99].map((share) => heights[Math.floor(share * (heights.length - 1))] ?? 0);
  // In steps: a colour of its own for every point would only cost time.
  return (i) => RAMPS.plain(Math.round((255 * (model.points[i * 3 + 2] - low)) / Math.max(high - low, 0.1)) / 255);
}
