// The scale of a ramp: the same in every model unless another is chosen, so that models can be compared.

import { rangeOf, rangeOfValues, valuesOf } from './colouring.js';
import { element } from './dom.js';
import { decimal } from './format.js';

/** A chosen scale as it stands in the address, `from,to`, and back; null where it is none. */
export const rangeText = (range) => (range === null ? null : range.map((value) => String(value)).join(','));

export function rangeFrom(text) {
  const [low, high, ...rest] = (text ?? '').split(',').map((part) => (part.trim() === '' ? Number.NaN : Number(part)));
  return Number.isFinite(low) && Number.isFinite(high) && low < high && rest.length === 0 ? [low, high] : null;
}

/** From, to, and the two scales that need no typing. */
export function scaleControls(model, state) {
  const { colouring } = state;
  const [low, high] = rangeOf(state);
  const set = (range) => {
    const isOwn = range[0] === colouring.range[0] && range[1] === colouring.range[1];
    state.set({ range: isOwn ? null : range });
  };
  const field = (value, label) =>
    element('input', {
      type: 'number',
      step: 'any',
      value: decimal(value, 6).replace('−', '-'),
      'aria-label': label,
      onchange: () => {
        const [from, to] = fields.map((input) => (input.value === '' ? Number.NaN : Number(input.value)));
        const isRange = from < to;
        fields.forEach((input) => input.setAttribute('aria-invalid', String(!isRange)));
        if (isRange) {
          set([from, to]);
        }
      },
    });
  const fields = [field(low, 'Scale from'), field(high, 'Scale to')];
  const ofModel = rangeOfValues(valuesOf(model, state));
  const choice = (name, title, range) =>
    element(
      'button',
      {
        type: 'button',
        title,
        'aria-pressed': String(
          low === range[0] && high === range[1] && (range === colouring.range || state.range !== null),
        ),
        onclick: () => set(range),
      },
      name,
    );
  const choices = [
    colouring.isFixed ? choice('Fixed', 'The same scale in every model', colouring.range) : null,
    choice('This model', 'The scale of the values of this model, the outermost 2 % left out', ofModel),
  ];
  return element(
    'div',
    { class: 'scale', role: 'group', 'aria-label': 'Scale of the colours' },
    element('span', {}, 'Scale'),
    fields[0],
    element('span', {}, '–'),
    fields[1],
    ...choices,
  );
}
