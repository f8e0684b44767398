// Finding a building by its id.

import { element, refill } from './dom.js';

const MOST = 12;

export function makeSearch(model, input, list, choose) {
  // Ids of buildings and of their parts, each once.
  const ids = [...model.byId.keys()];
  const lower = ids.map((id) => id.toLowerCase());
  let [found, active] = [[], 0];

  const show = () => {
    const open = input.value.trim() !== '' && document.activeElement === input;
    input.setAttribute('aria-expanded', String(open));
    list.hidden = !open;
    const items = found.map((id, i) =>
      element(
        'li',
        {
          id: `found-${i}`,
          role: 'option',
          'aria-selected': String(i === active),
          onmousedown: (event) => (event.preventDefault(), take(i)),
        },
        id,
      ),
    );
    refill(list, items.length > 0 ? items : element('li', { class: 'none' }, 'No building has such an id'));
    input.setAttribute('aria-activedescendant', open && items.length > 0 ? `found-${active}` : '');
  };

  const look = () => {
    const wanted = input.value.trim().toLowerCase();
    [found, active] = [[], 0];
    // What is the same comes first, then what begins so, then what holds it.
    const ranks = [(id) => id === wanted, (id) => id.startsWith(wanted), (id) => id.includes(wanted)];
    for (const fits of wanted === '' ? [] : ranks) {
      for (let i = 0; i < ids.length && found.length < MOST; i += 1) {
        if (fits(lower[i]) && !found.includes(ids[i])) {
          found.push(ids[i]);
        }
      }
    }
    show();
  };

  const take = (i) => {
    if (found[i] !== undefined) {
      input.value = found[i];
      input.blur();
      choose(model.byId.get(found[i]));
    }
  };

  input.addEventListener('input', look);
  input.addEventListener('focus', look);
  input.addEventListener('blur', show);
  input.addEventListener('keydown', (event) => {
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (by && found.length > 0) {
      active = (active + by + found.length) % found.length;
      event.preventDefault();
      show();
    } else if (event.key === 'Enter') {
      take(active);
    } else if (event.key === 'Escape') {
      input.value = '';
      input.blur();
    }
  });
}
