// The list of faults and failures; each flies to its building.

import { element, refill } from './dom.js';
import { shown, whole, words } from './format.js';

/** How many entries are shown at once. */
const MOST = 300;

/** Faults of a feature by their code: { fault, count, face }, the first of each that is on a face before others. */
export function byCode(feature) {
  const found = new Map();
  for (const fault of feature.faults) {
    const known = found.get(fault.code) ?? { fault, count: 0 };
    const isBetter = known.fault.face === undefined && fault.face !== undefined;
    found.set(fault.code, { fault: isBetter ? fault : known.fault, count: known.count + 1 });
  }
  return [...found.values()];
}

/** All that is wrong or failed, as { kind, f, title, what, code, face }. */
export function collect(model) {
  const entries = [];
  model.head.faults.forEach((fault) => {
    entries.push({ kind: 'invalid', f: -1, title: 'not readable', code: codeOf(fault), what: fault.info, face: -1 });
  });
  model.features.forEach((feature, f) => {
    byCode(feature).forEach(({ fault, count }) => {
      const face = fault.face === undefined ? -1 : feature.firstFace + fault.face;
      const kind = fault.about_labels ? 'labels' : 'invalid';
      const what = count > 1 ? `${fault.info}; and ${whole(count - 1)} more` : fault.info;
      entries.push({ kind, f, title: feature.id, code: codeOf(fault), what, face });
    });
    const own = feature.attributes;
    if (own.gable_success === false) {
      const reached =
        own.gable_lod === undefined
          ? 'no geometry'
          : own.gable_lod === '0'
            ? 'footprint only'
            : `LoD ${own.gable_lod} only`;
      const why = [words(own.gable_fallback_reason ?? ''), own.gable_fallback_detail].filter(Boolean).join(': ');
      entries.push({ kind: 'failed', f, title: feature.id, code: reached, what: why, face: -1 });
    }
    if (own.gable_field_fallback) {
      entries.push({
        kind: 'notes',
        f,
        title: feature.id,
        code: 'the vote decided',
        what: shown(own.gable_field_fallback),
        face: -1,
      });
    }
    (Array.isArray(own.gable_notes) ? own.gable_notes : []).forEach((note) => {
      entries.push({ kind: 'notes', f, title: feature.id, code: 'note', what: shown(note), face: -1 });
    });
  });
  // What is worst comes first.
  const rank = (entry) => KINDS.findIndex(([kind]) => kind === entry.kind);
  return entries.sort((a, b) => rank(a) - rank(b));
}

const codeOf = (fault) => `${fault.code} ${String(fault.name).toLowerCase().replace(/_/g, ' ')}`;

const KINDS = [
  ['invalid', 'Invalid', 'bad'],
  ['failed', 'LoD 2.2 not reached', 'bad'],
  ['labels', 'Labels', 'warn'],
  ['notes', 'Notes', ''],
];

export class FaultList {
  constructor(model, node, go) {
    this.entries = collect(model);
    this.node = node;
    this.go = go;
    this.current = -1;
    const present = KINDS.map(([kind]) => kind).filter((kind) => this.entries.some((entry) => entry.kind === kind));
    // Notes are many and rarely what one looks for first.
    this.chosen = new Set(present.filter((kind) => kind !== 'notes' || present.length === 1));
    this.fill();
  }

  /** Whether something is invalid, or failed: what one should see first. */
  get isUrgent() {
    return this.entries.some(({ kind }) => kind === 'invalid' || kind === 'failed');
  }

  get visible() {
    return this.entries.filter((entry) => this.chosen.has(entry.kind));
  }

  fill() {
    const kinds = KINDS.map(([kind, name]) => {
      const count = this.entries.filter((entry) => entry.kind === kind).length;
      const act = () => {
        this.chosen = new Set(this.chosen);
        if (!this.chosen.delete(kind)) {
          this.chosen.add(kind);
        }
        this.current = -1;
        this.fill();
      };
      return (
        count > 0 &&
        element(
          'button',
          { class: 'kind', type: 'button', 'aria-pressed': String(this.chosen.has(kind)), onclick: act },
          `${name} ${whole(count)}`,
        )
      );
    }).filter(Boolean);
    if (kinds.length === 0) {
      refill(
        this.node,
        element('p', { class: 'good' }, 'None: every object is valid, and every building got as far as was asked.'),
      );
      return;
    }
    const entries = this.visible;
    this.items = entries.slice(0, MOST).map((entry, i) => this.item(entry, i));
    const rest = entries.length - this.items.length;
    const more =
      rest > 0 ? element('p', { class: 'note' }, `${whole(rest)} more; gable validate --list has all`) : null;
    refill(this.node, element('div', { class: 'kinds' }, kinds), element('ul', { class: 'list' }, this.items), more);
  }

  item(entry, i) {
    const tone = KINDS.find(([kind]) => kind === entry.kind)[2];
    const what = element(
      'span',
      { class: 'what' },
      element('span', { class: 'code' }, entry.code),
      entry.what ? ` – ${entry.what}` : '',
    );
    const button = element(
      'button',
      { type: 'button', class: tone, onclick: () => this.choose(i) },
      element('div', { class: 'id' }, entry.title),
      what,
    );
    return element('li', {}, button);
  }

  choose(i) {
    const entry = this.visible[i];
    if (!entry) {
      return;
    }
    this.current = i;
    this.items.forEach((item, at) => item.firstChild.setAttribute('aria-current', String(at === i)));
    this.items[i]?.scrollIntoView({ block: 'nearest' });
    if (entry.f >= 0) {
      this.go(entry.f, entry.face);
    }
  }

  /** The first entry of the next building, or of the one before: what else it has stands in its panel. */
  step(by) {
    const entries = this.visible.slice(0, MOST);
    const isFirst = (i) => entries[i].f < 0 || entries.findIndex(({ f }) => f === entries[i].f) === i;
    const stops = entries.map((_, i) => i).filter(isFirst);
    if (stops.length === 0) {
      return;
    }
    const here = this.current < 0 ? null : entries[this.current].f;
    const at = stops.findIndex((i) => i === this.current || (here >= 0 && entries[i].f === here));
    const next = here === null ? (by > 0 ? 0 : stops.length - 1) : (at + by + stops.length) % stops.length;
    this.choose(stops[next]);
  }
}
