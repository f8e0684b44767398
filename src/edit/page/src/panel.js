// The panel of a building: its state, its figures, the tools, and the edits that were done.

import { element, refill } from '../../../view/page/src/dom.js';
import { counted } from '../../../view/page/src/format.js';
import { figures } from './figures.js';
import { TOOLS } from './toolbox.js';

const STATES = [
  ['accepted', 'Accept', 'A', 'It is as it should be, with its edits: a run follows them'],
  ['rejected', 'Reject', 'R', 'It cannot be mended: what was edited counts for nothing'],
  ['open', 'Open', 'Shift+A', 'Nothing is decided'],
];

export class Panel {
  /** `act` has what it asks for: state(name), choose(tool), and point(action) at where an edit is. */
  constructor(state, nodes, act) {
    Object.assign(this, { state, nodes, act });
    refill(
      nodes.tools,
      TOOLS.map(({ key, name, press, title }) =>
        element(
          'button',
          {
            type: 'button',
            class: 'option',
            role: 'radio',
            'data-tool': key,
            title: `${title} (${press})`,
            onclick: () => act.choose(key),
          },
          name,
          element('kbd', { 'aria-hidden': 'true' }, press.replace('Shift+', '⇧')),
        ),
      ),
    );
  }

  /** Shows the building. */
  show() {
    const { building } = this.state;
    const { nodes } = this;
    nodes.work.classList.toggle('vacant', building === null);
    if (!building) {
      return;
    }
    const { head } = building;
    refill(nodes.id, head.id);
    refill(
      nodes.states,
      STATES.map(([name, label, press, title]) =>
        element(
          'button',
          {
            type: 'button',
            class: `state ${name}`,
            'data-state': name,
            'aria-pressed': String(head.state === name),
            title: `${title} (${press})`,
            onclick: () => this.act.state(name),
          },
          label,
          element('kbd', { 'aria-hidden': 'true' }, press.replace('Shift+', '⇧')),
        ),
      ),
    );
    const why = this.state.rows.find(({ id }) => id === head.id)?.why ?? [];
    refill(
      nodes.why,
      element('i', { class: `dot ${head.state}`, 'aria-hidden': 'true' }),
      element('span', {}, [head.state, ...why].join(' · ')),
    );
    // Once is enough.
    const isTold = why.some((text) => text.includes(head.failure));
    refill(nodes.failure, head.failure && !isTold ? `Not a model in LoD 2.2: ${head.failure}` : '');
    nodes.failure.hidden = !head.failure || isTold;
    refill(nodes.figures, figures(head), this.notes(head));
    this.showEdits(head);
  }

  notes(head) {
    if (head.notes.length === 0) {
      return null;
    }
    const told = head.notes.map((note) => element('p', { class: 'note' }, note));
    return element('details', {}, element('summary', {}, counted(head.notes.length, 'note')), told);
  }

  showEdits({ edits, undone, took_ms: took }) {
    // Its line goes, and with it what it pointed at.
    this.act.point(null);
    const items = edits.map(({ name, text, applied, note, author, action }, i) =>
      element(
        'li',
        {
          class: applied ? '' : 'unapplied',
          'data-edit': name,
          title: author ? `by ${author}` : undefined,
          onmouseenter: () => this.act.point(action),
          onmouseleave: () => this.act.point(null),
        },
        element('b', {}, `${i + 1} `),
        text,
        applied ? null : element('span', { class: 'bad' }, `does not apply: ${note ?? 'no reason is given'}`),
        applied && note ? element('span', {}, note) : null,
      ),
    );
    const { nodes } = this;
    refill(nodes.edits, items.length > 0 ? items : element('li', { class: 'none' }, 'No edits yet.'));
    nodes.edits.scrollTop = nodes.edits.scrollHeight;
    nodes.undo.forEach((node) => (node.disabled = edits.length === 0));
    nodes.redo.forEach((node) => (node.disabled = undone === 0));
    nodes.clear.disabled = edits.length === 0;
    refill(nodes.took, `solved in ${Math.round(took)} ms`);
  }

  /** Shows which tool is chosen, and what it asks. */
  showTool(tool) {
    for (const node of this.nodes.tools.children) {
      node.setAttribute('aria-checked', String(node.dataset.tool === this.state.tool));
    }
    const { name, title } = TOOLS.find(({ key }) => key === this.state.tool);
    // What is being typed into stays.
    const typed = document.activeElement;
    if (
      typed?.type === 'number' &&
      this.nodes.options.contains(typed) &&
      this.shown === this.state.tool &&
      !this.isForced
    ) {
      return;
    }
    this.shown = this.state.tool;
    const id = typed && this.nodes.options.contains(typed) ? typed.id : null;
    refill(this.nodes.options, element('h3', { title }, name), tool.options());
    if (id) {
      document.getElementById(id)?.focus();
    }
  }
}
