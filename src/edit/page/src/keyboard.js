// The keys, and the help that tells of them.

import { byId } from '../../../view/page/src/dom.js';
import { fillHelp, listen } from '../../../view/page/src/keys.js';
import { COLOURINGS } from './colours.js';
import { LAYERS } from './layers.js';
import { planeActions } from './select.js';
import { TOOLS } from './toolbox.js';

const HELP = [
  ['drag', 'turn'],
  ['right drag, two fingers', 'move; with Shift turn'],
  ['wheel, pinch', 'come nearer, towards the pointer'],
  ['J N   K', 'next, previous building of the list'],
  ['/', 'find an id or a reason'],
  ['A   R   ⇧A', 'accept, reject, open again'],
  ['Ctrl+Z   Ctrl+⇧Z', 'undo, redo'],
  ['Ctrl+⇧Backspace', 'undo all'],
  ['Ctrl+S', 'write the model with what was accepted'],
  ['Enter   Del   Esc', 'do it; take away; drop it, leave the tool'],
  ...TOOLS.map(({ press, name, title }) => [
    press.replace('Shift+', '⇧'),
    `${name}: ${title[0].toLowerCase()}${title.slice(1)}`,
  ]),
  ['X', 'chosen plane: off or on'],
  ['H   V', 'chosen plane, or the one through the points that are picked: level, vertical'],
  ...LAYERS.map(({ press, name }) => [press.replace('Shift+', '⇧'), `show: ${name.toLowerCase()}`]),
  ['1 – 5', `points by ${COLOURINGS.map(({ name }) => name).join(', ')}`],
  ['6 7 8 9 0', 'straight from above, north, east, south, west'],
  ['.   O   F', 'without perspective; from above; show all'],
  ['[ ]   { }', 'less, more of the result; of the cells'],
  ['PgUp   PgDn', 'move the section'],
  ['arrow keys', 'move; with Shift turn'],
  ['+  −', 'nearer, farther'],
  ['D   M', 'dark or light; panel'],
];

const NOTES = [
  'Fingers look; edits are made by mouse or pen and keys. All decisions are saved at once and never leave this machine.',
];

export const fillKeys = (dialog) => fillHelp(dialog, HELP, NOTES);

/** The name of a key as `listen` calls it. */
const named = (press) =>
  press.length === 1 ? press.toLowerCase() : press.replace(/.$/, (letter) => letter.toLowerCase());

/** Listens to the keys; gives what they do by their names. */
export function listenToKeys({
  app,
  session,
  toolbox,
  messages,
  beside,
  choose,
  view,
  parallel,
  toggle,
  closeSide,
  theme,
}) {
  const { state, station } = app;
  const shine = (name, by) => state.set({ [name]: Math.round(Math.min(Math.max(state[name] + by, 0), 1) * 100) / 100 });
  const actions = {
    j: () => beside(1),
    n: () => beside(1),
    k: () => beside(-1),
    a: () => session.decide('accepted'),
    r: () => session.decide('rejected'),
    'Shift+a': () => session.decide('open'),
    x: () => planeActions.switch(app),
    h: () => (toolbox.tool.align ? toolbox.tool.align('level') : planeActions.align(app, 'level')),
    v: () => (toolbox.tool.align ? toolbox.tool.align('vertical') : planeActions.align(app, 'vertical')),
    Enter: () => toolbox.tool.confirm(),
    Delete: () => toolbox.tool.erase(),
    Backspace: () => toolbox.tool.erase(),
    Escape: () => messages.dismiss() || toolbox.tool.cancel() || choose('select'),
    'Shift+Delete': () => toolbox.tool.anew?.(),
    PageUp: () => toolbox.tool.step?.(0.25),
    PageDown: () => toolbox.tool.step?.(-0.25),
    '[': () => shine('opacity', -0.1),
    ']': () => shine('opacity', 0.1),
    '{': () => shine('least', -0.1),
    '}': () => shine('least', 0.1),
    f: () => station.fit(false, 550),
    o: () => station.fit(true, 550),
    d: theme.toggle,
    m: closeSide,
    '/': () => byId('text').focus(),
    '?': () => byId('keys').showModal(),
    '.': parallel,
    '+': () => station.zoom(0.8),
    '=': () => station.zoom(0.8),
    '-': () => station.zoom(1.25),
    ArrowLeft: () => station.pan(-0.06, 0),
    ArrowRight: () => station.pan(0.06, 0),
    ArrowUp: () => station.pan(0, 0.06),
    ArrowDown: () => station.pan(0, -0.06),
    'Shift+ArrowLeft': () => station.turn(-0.12, 0),
    'Shift+ArrowRight': () => station.turn(0.12, 0),
    'Shift+ArrowUp': () => station.turn(0, -0.1),
    'Shift+ArrowDown': () => station.turn(0, 0.1),
  };
  ['top', 'north', 'east', 'south', 'west'].forEach((name, i) => (actions[String((6 + i) % 10)] = () => view(name)));
  TOOLS.forEach(({ key, press }) => (actions[named(press)] = () => choose(key)));
  actions.y = () => (toolbox.tool.align ? toolbox.tool.align('parallel') : choose('parallel'));

  LAYERS.forEach(({ key, press }) => (actions[named(press)] = () => toggle(key)));
  COLOURINGS.forEach(({ key }, i) => (actions[String(i + 1)] = () => state.set({ colouring: key })));
  listen(actions);
  // Together with Ctrl, or with ⌘ where that is the key.
  const withControl = {
    'Ctrl+z': () => session.undo(),
    'Ctrl+Shift+z': () => session.redo(),
    'Ctrl+y': () => session.redo(),
    'Ctrl+Shift+Backspace': () => session.clear(),
    'Ctrl+s': () => session.export(),
  };
  window.addEventListener('keydown', (event) => {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const action = withControl[`Ctrl+${event.shiftKey ? 'Shift+' : ''}${key}`];
    const isText = event.target.closest?.('input[type=search], input[type=number], dialog[open]');
    if ((event.ctrlKey || event.metaKey) && !event.altKey && action && !isText) {
      event.preventDefault();
      action();
    }
  });
  // In a number Enter does what the tool does.
  byId('options').addEventListener('keydown', (event) => {
    if (event.target.type === 'number' && ['Enter', 'Escape'].includes(event.key)) {
      event.preventDefault();
      if (event.key === 'Enter') {
        toolbox.tool.confirm();
      }
      byId('canvas').focus({ preventScroll: true });
    }
  });
  return { ...actions, ...withControl };
}
