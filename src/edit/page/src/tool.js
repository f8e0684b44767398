// What a tool is: what the pointer and some keys mean while it is chosen, and what it asks in the panel.

import { element } from '../../../view/page/src/dom.js';

export class Tool {
  /** `app` has the state, the picture, what lies under the pointer, and `act(action)`, which asks the server. */
  constructor(app) {
    this.app = app;
  }

  get building() {
    return this.app.state.building;
  }

  /** It was chosen; the building may be another one, or have changed, when it is called again. */
  enter() {}

  /** Another is chosen, or another building: what was begun is dropped. */
  leave() {}

  /** Whether a drag that starts here is its own, and not a turn of the view. */
  down() {
    return false;
  }

  drag() {}

  up() {}

  click() {}

  /** The pointer left the picture. */
  out() {}

  /** What is said beside the pointer, [title, more]; null for nothing. */
  hover() {
    return null;
  }

  /** Enter. */
  confirm() {}

  /** Delete. */
  erase() {}

  // A tool that makes a plane has `align(lie)` besides, for the keys H, V and Y.

  /** Esc: whether there was anything to drop. */
  cancel() {
    return false;
  }

  /** What the panel asks. */
  options() {
    return [];
  }
}

/** A button of the panel, with its key. */
export const button = (name, key, title, act, { isMain = false, disabled = false, id } = {}) =>
  element(
    'button',
    {
      type: 'button',
      class: isMain ? 'do main' : 'do',
      title: key ? `${title} (${key})` : title,
      disabled,
      onclick: act,
      id,
      'data-do': name.toLowerCase().replace(/[^a-z]+/g, '-'),
    },
    name,
    key ? element('kbd', { 'aria-hidden': 'true' }, key) : null,
  );

/** A number that is typed, with its unit; `set(value)` is called by every change that is a number. */
export function numberField(name, value, unit, set, { step = 0.05, id, title, min, max } = {}) {
  const input = element('input', {
    type: 'number',
    step,
    min,
    max,
    id,
    value: String(Math.round(value * 1000) / 1000),
    'aria-label': name,
    oninput: () => {
      if (Number.isFinite(input.valueAsNumber)) {
        set(input.valueAsNumber);
      }
    },
  });
  return element('label', { class: 'row number', title }, element('span', {}, name), input, element('i', {}, unit));
}

/** A text of the panel. */
export const says = (...text) => element('p', { class: 'note' }, ...text);
