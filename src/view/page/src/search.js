// Finding a building by its id.

import { element, refill } from './dom.js';

const MOST = 12;

export function makeSearch(model, input, list, choose) {
  // Of each building its own id first, then those of its parts: whichever is looked for, the building is found once.
  const idsOf = ({ firstObject, endObject }) => model.objects.slice(firstObject, endObject).map(({ id }) => id);
  const lower = model.features.map((feature) => idsOf(feature).map((id) => id.toLowerCase()));
  let [found, active] = [[], 0];

  const show = () => {
    const open = input.value.trim() !== '' && document.activeElement === input;
    input.setAttribute('aria-expanded', String(open));
    list.hidden = !open;
    const items = found.map(({ f, part }, i) =>
      element(
        'li',
        {
          id: `found-${i}`,
          role: 'option',
          'aria-selected': String(i === active),
          onmousedown: (event) => (event.preventDefault(), take(i)),
        },
        model.features[f].id,
        part ? element('span', { class: 'part' }, `part ${part}`) : null,
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
      for (let f = 0; f < lower.length && found.length < MOST; f += 1) {
        const at = lower[f].findIndex(fits);
        if (at >= 0 && !found.some((known) => known.f === f)) {
          found.push({ f, part: at > 0 ? model.objects[model.features[f].firstObject + at].id : null });
        }
      }
    }
    show();
  };

  const take = (i) => {
    if (found[i] !== undefined) {
      const { f } = found[i];
      input.value = model.features[f].id;
      input.blur();
      choose(f);
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
