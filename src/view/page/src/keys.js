// The keyboard, and the help that tells of it.

import { element, refill } from './dom.js';

const HELP = [
  ['drag', 'turn'],
  ['right drag, two fingers', 'move'],
  ['wheel, pinch', 'come nearer, towards the pointer'],
  ['click', 'attributes of a building and of the face; double click flies to it'],
  ['arrow keys', 'move; with Shift turn'],
  ['+  −', 'nearer, farther'],
  ['1 – 9', 'colour by semantics, RMSE, confidence, roof type, ladder step, validity, completeness, height, volume'],
  ['F   O', 'show all; from above'],
  ['L', 'next level of detail'],
  ['P', 'points'],
  ['N   B', 'next, previous building with a fault or failure'],
  ['/', 'find an id'],
  ['D   M', 'dark or light; panel'],
  ['Esc', 'close, select nothing, take the filter away'],
];

const NOTES = [
  'Lines of the summary, entries of the legend and bars of the histogram filter: click again to take the filter away.',
  'Where the model has no terrain, ground is drawn for the eye, from the lower edges of the buildings; it covers none of it.',
];

/** Fills the dialog of the help. */
export function fillHelp(dialog, help = HELP, notes = NOTES) {
  const rows = help.flatMap(([keys, what]) => [element('dt', {}, element('kbd', {}, keys)), element('dd', {}, what)]);
  refill(
    dialog,
    element('h2', { id: 'keys-title' }, 'Mouse, touch and keys'),
    element('dl', {}, rows),
    notes.map((note) => element('p', {}, note)),
    element('form', { method: 'dialog' }, element('button', {}, 'Close')),
  );
}

/** Calls the action of a key, unless it is being typed into something. */
export function listen(actions) {
  window.addEventListener('keydown', (event) => {
    const isTyping = event.target.closest?.('input:not([type=checkbox], [type=range]), select, textarea, dialog[open]');
    if (isTyping || event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    // Enter belongs to a control that has the focus, arrows to a slider.
    const isControl = event.target.closest?.('button, summary, input, [role=button]') !== null;
    if (isControl && ['Enter', ' '].includes(event.key)) {
      return;
    }
    if (event.target.matches?.('[type=range]') && event.key.startsWith('Arrow')) {
      return;
    }
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const withShift = `Shift+${key}`;
    const action = actions[event.shiftKey && (withShift in actions || key.startsWith('Arrow')) ? withShift : key];
    if (action) {
      event.preventDefault();
      action();
    }
  });
}
