// What is seen, behind the # of the address: `colour` (a colouring or an attribute), `range`, `lod`, `theme`, `id`, `points`,
// `side`. The address follows what is chosen, and what is chosen follows the address.

import { attributeNames, byAttribute } from './colouring.js';
import { rangeFrom, rangeText } from './scale.js';

/** What the address asks for, as changes of the state; `unknown` is an id that the model has not. */
export function read(model, all) {
  const asked = new URLSearchParams(window.location.hash.slice(1));
  const id = asked.get('id');
  const feature = model.byId.get(id) ?? -1;
  const lod = asked.get('lod') === null ? -1 : model.lods.indexOf(asked.get('lod'));
  const colouring = colouringOf(model, all, asked.get('colour'));
  return {
    changes: {
      lod,
      arePointsShown: asked.get('points') === 'on' && model.classes.length > 0,
      colouring,
      range: colouring.kind === 'ramp' ? rangeFrom(asked.get('range')) : null,
    },
    theme: ['dark', 'light'].includes(asked.get('theme')) ? asked.get('theme') : null,
    feature,
    unknown: id !== null && feature < 0 ? id : null,
    isSideClosed: asked.get('side') === 'closed',
  };
}

const first = (all) => all.find(({ reason }) => reason === null) ?? all[all.length - 1];

function colouringOf(model, all, name) {
  const known = all.find(({ key, reason }) => key === name && reason === null);
  if (known) {
    return known;
  }
  const attribute = name?.replace(/^attribute:/, '');
  return attributeNames(model).includes(attribute) ? byAttribute(model, attribute) : first(all);
}

/** The address of what is seen; what is as it is anyway is left out. */
function write(model, state, all, theme) {
  const { colouring, range, lod, selection } = state;
  const parts = new URLSearchParams();
  const put = (name, value) => value !== null && parts.set(name, value);
  put('colour', colouring === first(all) ? null : colouring.key);
  put('range', rangeText(range));
  put('lod', lod < 0 ? null : model.lods[lod]);
  put('points', state.arePointsShown ? 'on' : null);
  put('theme', theme.chosen());
  put('side', document.body.classList.contains('closed') ? 'closed' : null);
  put('id', selection ? model.features[selection.feature].id : null);
  return parts.toString();
}

/**
 * Keeps address and state in step. `apply(asked)` shows what an address asks for that was typed, or gone back to. Gives what to
 * call when something changed that the state does not know of.
 */
export function keepInStep(model, state, all, theme, apply) {
  let isApplying = false;
  const follow = () => {
    const wanted = write(model, state, all, theme);
    if (isApplying || wanted === new URLSearchParams(window.location.hash.slice(1)).toString()) {
      return;
    }
    const place = window.location.href.replace(/#.*$/s, '');
    try {
      // Replaced and not added: going back leaves the page, as it does elsewhere.
      window.history.replaceState(null, '', wanted === '' ? place : `${place}#${wanted}`);
    } catch {
      // The page of a notebook's cell has no address.
    }
  };
  state.listen(follow);
  window.addEventListener('hashchange', () => {
    isApplying = true;
    apply(read(model, all));
    isApplying = false;
    follow();
  });
  return follow;
}
