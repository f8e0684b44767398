// What is told of a step: text, legend, controls, figures, parameters.

import { element, refill } from '../../../view/page/src/dom.js';
import { decimal, shown } from '../../../view/page/src/format.js';
import { CHOICES } from './steps.js';

const STOPS = 24;

/** Fills the panel of the step that is shown; `choose(name, value)` is called by its controls. */
export function showStep(node, building, state, choose) {
  const { step, choices } = state;
  const told = building.head.steps.find(({ key }) => key === step.key);
  const isLast = step.key === 'result';
  const notes = isLast ? building.head.notes : [];
  refill(
    node,
    element('h2', {}, step.title),
    step.text.map((text) => element('p', { class: 'text' }, text)),
    legend(step.legend(building, choices)),
    step.controls.map((name) => control(name, choices[name], choose)),
    told.figures.length > 0 ? [element('h3', {}, 'Figures'), figures(told.figures)] : [],
    notes.length > 0 ? [element('h3', {}, 'Notes'), ...notes.map((note) => element('p', { class: 'note' }, note))] : [],
    told.parameters.length > 0 ? parameters(told.parameters) : [],
  );
}

/** The legend of colours: entries, or a ramp. */
export function legend(found) {
  if (!Array.isArray(found)) {
    const stops = Array.from({ length: STOPS }, (_, i) =>
      element('i', { style: { background: found.ramp(i / (STOPS - 1)) } }),
    );
    const ends = element('div', { class: 'ends' }, element('span', {}, found.low), element('span', {}, found.high));
    return element('div', { class: 'legend' }, element('div', { class: 'ramp', 'aria-hidden': 'true' }, stops), ends);
  }
  const entry = ([colour, name, count]) =>
    element(
      'div',
      { class: 'entry' },
      element('i', { style: { background: colour } }),
      element('span', { title: name }, name),
      element('b', {}, count),
    );
  return element('div', { class: 'entries' }, found.map(entry));
}

function control(name, value, choose) {
  const { name: title, isShare } = CHOICES[name];
  if (!isShare) {
    const box = element('input', {
      type: 'checkbox',
      'data-choice': name,
      checked: value,
      onchange: () => choose(name, box.checked),
    });
    return element('label', { class: 'row' }, box, title);
  }
  const percent = (share) => `${decimal(100 * share, 0)} %`;
  const output = element('output', {}, percent(value));
  const slider = element('input', {
    type: 'range',
    min: 0,
    max: 1,
    step: 0.01,
    value,
    'data-choice': name,
    oninput: () => {
      refill(output, percent(slider.valueAsNumber));
      choose(name, slider.valueAsNumber);
    },
  });
  return element('label', { class: 'row' }, element('span', {}, title), slider, output);
}

const figures = (all) =>
  element(
    'dl',
    {},
    all.flatMap(({ name, value, unit }) => [
      element('dt', {}, name),
      element('dd', {}, `${shown(value)}${unit ? ` ${unit}` : ''}`),
    ]),
  );

const parameters = (all) =>
  element(
    'details',
    {},
    element('summary', {}, 'Parameters'),
    element(
      'dl',
      {},
      all.flatMap(({ option, value }) => [
        element('dt', {}, element('code', {}, option)),
        element('dd', {}, shown(value)),
      ]),
    ),
  );
