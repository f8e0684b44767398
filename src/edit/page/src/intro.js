// What is said when nobody has edited anything yet.

import { element, refill } from '../../../view/page/src/dom.js';

const STEPS = [
  'The list begins with what needs a person. J and K go to the next and the previous building.',
  'Points are red where they lie outside the model, blue where they lie inside: there something is wrong.',
  'Choose a tool at the right, or press its key: B paints over points for a plane that is missing, U marks what is not there, Z sets the floor.',
  'Enter does it. The building is solved again, and stays valid; Ctrl+Z takes it back.',
  'A accepts the building, R rejects it. All is saved at once, beside the model.',
];

/** Shows it until it is closed; `done` is called then. */
export function showIntro(node, done) {
  const close = () => {
    node.hidden = true;
    done();
  };
  refill(
    node,
    element('h2', { id: 'intro-title' }, 'Mend a building'),
    element(
      'ol',
      {},
      STEPS.map((text) => element('li', {}, text)),
    ),
    element(
      'div',
      { class: 'does' },
      element('span', { class: 'note' }, '? shows all keys'),
      element('button', { type: 'button', class: 'do main', id: 'intro-close', onclick: close }, 'Begin'),
    ),
  );
  node.addEventListener('keydown', (event) => event.key === 'Escape' && (event.stopPropagation(), close()));
  node.hidden = false;
  node.querySelector('button').focus({ preventScroll: true });
}
