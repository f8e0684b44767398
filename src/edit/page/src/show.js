// What is shown: layers, how points are coloured, and how much shines through.

import { element, refill } from '../../../view/page/src/dom.js';
import { decimal } from '../../../view/page/src/format.js';
import { legend } from '../../../explain/page/src/side.js';
import { COLOURINGS } from './colours.js';
import { LAYERS } from './layers.js';

/** Makes the controls of the layers. */
export function makeShow(state, { layers, colourings, legendNode, opacity, least }) {
  const toggle = (key) => state.set({ layers: { ...state.layers, [key]: !state.layers[key] } });
  const boxes = LAYERS.map(({ key, name, press, title }) => {
    const box = element('input', { type: 'checkbox', 'data-layer': key, onchange: () => toggle(key) });
    return element(
      'label',
      { class: 'layer', title: `${title} (${press})` },
      box,
      element('span', {}, name),
      element('kbd', { 'aria-hidden': 'true' }, press.replace('Shift+', '⇧')),
    );
  });
  refill(layers, boxes);
  const buttons = COLOURINGS.map(({ key, name, title }, i) =>
    element(
      'button',
      {
        type: 'button',
        class: 'option',
        role: 'radio',
        title: `${title} (${i + 1})`,
        'data-key': key,
        onclick: () => state.set({ colouring: key }),
      },
      name,
      element('kbd', { 'aria-hidden': 'true' }, String(i + 1)),
    ),
  );
  refill(colourings, buttons);
  const percent = (share) => `${decimal(100 * share, 0)} %`;
  const slider = (name, title, key, node) => {
    const output = element('output', {}, percent(state[key]));
    const input = element('input', {
      type: 'range',
      min: 0,
      max: 1,
      step: 0.05,
      value: state[key],
      title,
      oninput: () => state.set({ [key]: input.valueAsNumber }),
    });
    refill(node, element('label', { class: 'row slider', title }, element('span', {}, name), input, output));
    state.listen((changed) => {
      if (changed.has(key)) {
        input.value = state[key];
        refill(output, percent(state[key]));
      }
    });
  };
  slider('result, opaque by', 'Less lets through what is behind ([ and ])', 'opacity', opacity);
  slider(
    'cells from',
    'Cells less likely inside than this are hidden, unless they are inside ({ and })',
    'least',
    least,
  );
  const update = () => {
    boxes.forEach((label) => (label.firstElementChild.checked = state.layers[label.firstElementChild.dataset.layer]));
    buttons.forEach((node) => node.setAttribute('aria-checked', String(node.dataset.key === state.colouring)));
    opacity.hidden = !state.layers.result;
    least.hidden = !state.layers.cells;
    const colouring = COLOURINGS.find(({ key }) => key === state.colouring);
    refill(legendNode, state.building ? legend(colouring.legend(state.building)) : null);
  };
  state.listen((changed) => ['layers', 'colouring', 'building'].some((name) => changed.has(name)) && update());
  update();
  return toggle;
}
