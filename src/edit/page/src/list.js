// The list of buildings: filters, order, and a line for each with what it needs a person for.

import { element, refill } from '../../../view/page/src/dom.js';
import { counted, decimal, whole } from '../../../view/page/src/format.js';
import { ORDERS, STATES, reasonsOf, shownRows } from './rows.js';

/** So many lines at a time. */
const PAGE = 200;

const about = (row) =>
  [
    ...row.why,
    row.failure && row.why.every((why) => !why.includes(row.failure)) ? row.failure : null,
    row.why.length === 0 && row.rmse !== null ? `RMSE ${decimal(row.rmse, 2)} m` : null,
    row.edits > 0 ? `${row.edits} ${row.edits === 1 ? 'edit' : 'edits'}` : null,
  ]
    .filter(Boolean)
    .join(' · ');

export class List {
  /** `nodes` are those of the page; `open(id)` is called by a click. */
  constructor(state, nodes, open) {
    Object.assign(this, { state, nodes, open });
    this.most = PAGE;
    nodes.text.addEventListener('input', () => state.set({ text: nodes.text.value }));
    nodes.text.addEventListener('keydown', (event) => {
      if (event.key === 'Escape') {
        nodes.text.value = '';
        state.set({ text: '' });
        nodes.text.blur();
      } else if (event.key === 'Enter' && this.shown[0]) {
        nodes.text.blur();
        open(this.shown[0].id);
      }
    });
    refill(
      nodes.order,
      Object.entries(ORDERS).map(([key, { name }]) => element('option', { value: key }, name)),
    );
    nodes.order.addEventListener('change', () => state.set({ order: nodes.order.value }));
    nodes.reason.addEventListener('change', () => state.set({ reason: nodes.reason.value }));
    state.listen((changed) => {
      const hasMoved = ['text', 'order', 'reason', 'states'].some((name) => changed.has(name));
      this.most = hasMoved ? PAGE : this.most;
      if (hasMoved || this.shown === undefined) {
        this.show();
      } else if (changed.has('rows')) {
        // Nothing moves or goes while one works on it: next is what was next.
        const known = new Map(state.rows.map((row) => [row.id, row]));
        this.fill(this.shown.flatMap(({ id }) => known.get(id) ?? []));
      } else if (changed.has('id')) {
        this.mark();
      }
    });
  }

  show() {
    this.fill(shownRows(this.state.rows, this.state));
    this.nodes.list.scrollTop = 0;
  }

  /** Fills the list with rows. */
  fill(rows) {
    const { nodes } = this;
    this.shown = rows;
    this.showFilters();
    const lines = this.shown.slice(0, this.most).map((row) => this.line(row));
    const left = this.shown.length - lines.length;
    const more = element(
      'button',
      { type: 'button', class: 'more', onclick: () => ((this.most += PAGE), this.show()) },
      `${whole(left)} more`,
    );
    refill(
      nodes.list,
      lines,
      left > 0 ? element('li', {}, more) : null,
      lines.length === 0 ? element('li', { class: 'none' }, 'No building passes the filters.') : null,
    );
    this.mark(false);
  }

  showFilters() {
    const { state, nodes } = this;
    const count = (name) => state.rows.filter((row) => row.state === name).length;
    const toggle = (name) => {
      const states = new Set(state.states);
      states.has(name) ? states.delete(name) : states.add(name);
      state.set({ states });
    };
    const chips = STATES.map((name) =>
      element(
        'button',
        {
          type: 'button',
          class: 'kind',
          'data-state': name,
          'aria-pressed': String(state.states.has(name)),
          title: `Only buildings that are ${name}; click again to take the filter away`,
          onclick: () => toggle(name),
        },
        element('i', { class: `dot ${name}`, 'aria-hidden': 'true' }),
        `${name} ${whole(count(name))}`,
      ),
    );
    refill(nodes.states, chips);
    const reasons = reasonsOf(state.rows);
    refill(
      nodes.reason,
      element('option', { value: '' }, 'all reasons and none'),
      reasons.map(([reason, number]) => element('option', { value: reason }, `${reason} (${whole(number)})`)),
    );
    nodes.reason.value = state.reason;
    nodes.order.value = state.order;
    const needing = state.rows.filter(({ urgency }) => urgency > 0).length;
    refill(
      nodes.count,
      this.shown.length === state.rows.length
        ? `${counted(state.rows.length, 'building')}, ${whole(needing)} for a person to look at`
        : `${whole(this.shown.length)} of ${counted(state.rows.length, 'building')}`,
    );
  }

  line(row) {
    return element(
      'li',
      {},
      element(
        'button',
        { type: 'button', 'data-id': row.id, title: row.id, onclick: () => this.open(row.id) },
        element('i', { class: `dot ${row.state}`, title: row.state }),
        element('span', { class: 'id' }, element('bdi', { dir: 'ltr' }, row.id)),
        element('span', { class: row.urgency > 0 ? 'what needs' : 'what' }, about(row)),
      ),
    );
  }

  /** Shows which building is open. */
  mark(isScrolled = true) {
    for (const node of this.nodes.list.querySelectorAll('[data-id]')) {
      const isOpen = node.dataset.id === this.state.id;
      node.setAttribute('aria-current', String(isOpen));
      if (isOpen && isScrolled) {
        // Only the list, and not what is around it.
        const { list } = this.nodes;
        const [from, to] = [list, node].map((own) => own.getBoundingClientRect());
        list.scrollTop += Math.min(to.top - from.top - 4, 0) + Math.max(to.bottom - from.bottom + 4, 0);
      }
    }
  }

  /** The building so many places further in the list; null where it ends. */
  beside(by) {
    const at = this.shown.findIndex(({ id }) => id === this.state.id);
    const next = at < 0 ? (by > 0 ? 0 : -1) : at + by;
    this.most = Math.max(this.most, next + 1);
    return this.shown[next]?.id ?? null;
  }
}
