// The attributes of what is selected: building, part, surface.

import { element, refill } from './dom.js';
import { byCode } from './faults.js';
import { decimal, duration, lodName, shown, words } from './format.js';
import { LABELS, NOTHING } from './palette.js';

export class Panel {
  constructor(model, state, node, { flyTo, close }) {
    Object.assign(this, { model, state, node, flyTo, close });
  }

  show() {
    const { selection } = this.state;
    this.node.hidden = selection === null;
    if (selection === null) {
      refill(this.node);
      return;
    }
    const feature = this.model.features[selection.feature];
    const sections = [this.faults(feature), this.surface(selection.face), this.part(feature, selection.face)];
    sections.push(this.attributes(feature.kind, feature.attributes), this.run(feature));
    refill(this.node, this.header(feature, selection), sections.flat());
    this.node.scrollTop = 0;
  }

  header(feature, selection) {
    const copy = element('button', { type: 'button', onclick: () => this.copy(feature.id, copy) }, 'Copy id');
    return element(
      'header',
      {},
      element(
        'div',
        { class: 'head' },
        element('h2', { id: 'selected-id' }, feature.id),
        element(
          'button',
          { class: 'close', type: 'button', 'aria-label': 'Close', title: 'Close (Esc)', onclick: this.close },
          '×',
        ),
      ),
      element(
        'p',
        { class: 'kind-of' },
        `${feature.kind}${feature.best >= 0 ? `, up to ${lodName(this.model.lods[feature.best])}` : ', without geometry'}`,
      ),
      element(
        'div',
        { class: 'actions' },
        element('button', { type: 'button', onclick: () => this.flyTo(selection.feature) }, 'Fly to it'),
        copy,
      ),
    );
  }

  async copy(text, button) {
    try {
      await navigator.clipboard.writeText(text);
      refill(button, 'Copied');
    } catch {
      // A page of a file may not use the clipboard: the id is selected instead.
      window.getSelection().selectAllChildren(this.node.querySelector('h2'));
      refill(button, 'Selected: press Ctrl C');
    }
  }

  faults(feature) {
    if (feature.faults.length === 0) {
      return null;
    }
    const rows = byCode(feature).map(({ fault, count }) => {
      const more = count > 1 ? element('span', { class: 'note' }, ` and ${count - 1} more`) : null;
      return element('p', { class: fault.about_labels ? 'fault label' : 'fault' }, [
        element('b', {}, `${fault.code} ${fault.name}`),
        ` ${fault.info}`,
        more,
      ]);
    });
    return section('Faults', null, rows);
  }

  surface(face) {
    if (face < 0) {
      return null;
    }
    const surface = this.model.surfaceOf(face);
    const rows = this.rows({ ...(surface?.attributes ?? {}) });
    rows.push(element('dt', {}, 'area of the face'), element('dd', {}, `${decimal(this.model.area(face), 2)} m²`));
    rows.push(
      element('dt', {}, 'level of detail'),
      element('dd', {}, this.model.lods[this.model.faceLod[face]] || '–'),
    );
    return section(
      surface?.type || 'No label',
      LABELS[surface?.type] ?? NOTHING,
      element('dl', { id: 'surface' }, rows),
    );
  }

  part(feature, face) {
    const part = face < 0 ? null : this.model.objects[this.model.faceObject[face]];
    if (!part || this.model.faceObject[face] === feature.firstObject) {
      return null;
    }
    const rows = [element('dt', {}, 'id'), element('dd', {}, part.id), ...this.rows(part.attributes)];
    return section(part.type, null, element('dl', {}, rows));
  }

  attributes(kind, attributes) {
    const all = Object.entries(attributes);
    if (all.length === 0) {
      return element('section', {}, element('p', { class: 'note' }, `This ${kind} has no attributes.`));
    }
    // What the maker of the model says stands apart from what the footprint brought along.
    const byMaker = new Map();
    all.forEach(([name, value]) => {
      const maker = this.model.vocabulary.makerOf(name);
      byMaker.set(maker, [...(byMaker.get(maker) ?? []), [name, value]]);
    });
    const makers = [...byMaker.keys()].sort((a, b) => Number(a === null) - Number(b === null));
    const title = (maker) =>
      maker !== null ? `${kind}, by ${maker}` : makers.length > 1 ? `${kind}, from the source` : kind;
    return makers.map((maker) =>
      section(title(maker), null, element('dl', {}, this.rows(Object.fromEntries(byMaker.get(maker))))),
    );
  }

  run(feature) {
    if (!feature.run) {
      return null;
    }
    const rows = [];
    const row = (name, value) => rows.push(element('dt', {}, name), element('dd', {}, value));
    if (Number.isFinite(feature.run.wall_ms)) {
      row('time', duration(feature.run.wall_ms / 1000));
    }
    if (Number.isFinite(feature.run.cells)) {
      row('cells', String(feature.run.cells));
    }
    (feature.run.setbacks ?? []).forEach((setback) => {
      row(
        words(setback.step ?? 'setback'),
        [words(setback.reason ?? ''), setback.detail, shown(setback.codes ?? [])]
          .filter((text) => text && text !== 'none')
          .join(': '),
      );
    });
    return rows.length > 0 ? section('The run', null, element('dl', {}, rows)) : null;
  }

  rows(attributes) {
    return Object.entries(attributes).flatMap(([name, value]) => {
      const known = this.model.vocabulary.known(name);
      const unit = typeof value === 'number' && known?.unit ? ` ${known.unit}` : '';
      const title = known ? `${name}: ${known.meaning}` : undefined;
      return [element('dt', { title }, known?.title ?? name), element('dd', {}, `${shown(value)}${unit}`)];
    });
  }
}

function section(title, colour, ...children) {
  const swatch = colour ? element('i', { style: { background: colour } }) : null;
  return element('section', {}, element('h3', {}, [swatch, title].filter(Boolean)), ...children);
}
