// How many buildings there are, how far they came, and the run that made them.

import { element, refill } from './dom.js';
import { counted, decimal, duration, lodName, shown, whole, words } from './format.js';

/** Fills the summary; every line is a filter. */
export function showSummary(model, state, nodes) {
  const buildings = model.features.flatMap((feature, f) => (feature.isBuilding ? [f] : []));
  const others = model.features.length - buildings.length;
  const lines = [];
  const line = (name, members, isBad = false) => {
    if (members.length > 0) {
      lines.push({ name, members: new Set(members), isBad });
    }
  };
  for (let lod = model.lods.length - 1; lod >= 0; lod -= 1) {
    const isFootprint = /^0/.test(model.lods[lod]);
    const name = isFootprint ? `footprint only (LoD ${model.lods[lod]})` : lodName(model.lods[lod]);
    line(
      name,
      buildings.filter((f) => model.features[f].best === lod),
    );
  }
  line(
    'without geometry',
    buildings.filter((f) => model.features[f].best < 0),
    true,
  );
  line(
    'invalid',
    model.features.flatMap((feature, f) => (feature.isInvalid ? [f] : [])),
    true,
  );
  line(
    'other objects',
    model.features.flatMap((feature, f) => (feature.isBuilding ? [] : [f])),
  );
  const total = element(
    'p',
    { class: 'total' },
    element('b', { id: 'building-count' }, whole(buildings.length)),
    element('span', {}, buildings.length === 1 ? 'building' : 'buildings'),
  );
  const chips = lines.map(({ name, members, isBad }) => {
    const share = (100 * members.size) / Math.max(model.features.length, 1);
    const bar = element(
      'span',
      { class: 'share', 'aria-hidden': 'true' },
      element('i', { style: { width: `${share}%` } }),
    );
    const label = element('span', { class: isBad ? 'bad' : undefined }, name);
    const act = () => state.toggleFilter(name, (f) => members.has(f));
    return element(
      'button',
      { class: 'chip', type: 'button', 'aria-pressed': 'false', 'data-filter': name, onclick: act },
      label,
      element('span', {}, whole(members.size)),
      bar,
    );
  });
  refill(nodes.summary, total, element('div', { class: 'chips' }, chips));
  state.listen((changed) => {
    if (changed.has('filter')) {
      chips.forEach((chip) => chip.setAttribute('aria-pressed', String(chip.dataset.filter === state.filter?.name)));
    }
  });
  const about = [
    model.head.format,
    model.head.crs ?? 'no CRS: lengths are taken for metres',
    counted(model.triangles.length / 3, 'triangle'),
  ];
  if (others > 0) {
    about.push(counted(others, 'other object'));
  }
  refill(nodes.title, model.head.name);
  refill(nodes.subtitle, about.join(' · '));
  showRun(model.head.run, nodes);
}

/** What the report says of the run. */
function showRun(run, nodes) {
  if (!run) {
    return;
  }
  nodes.runSection.hidden = false;
  const rows = [];
  const row = (name, value) =>
    value !== undefined && value !== null && rows.push(element('dt', {}, name), element('dd', {}, value));
  row('gable', run.gable);
  row(
    'started',
    String(run.started ?? '')
      .replace('T', ' ')
      .replace('Z', ' UTC'),
  );
  row(
    'took',
    Number.isFinite(run.wall_seconds)
      ? `${duration(run.wall_seconds)} on ${counted(run.threads ?? 1, 'thread')}`
      : undefined,
  );
  row('memory', Number.isFinite(run.peak_memory_bytes) ? `${Math.round(run.peak_memory_bytes / 1e6)} MB` : undefined);
  row('field', run.field?.field);
  row('interrupted', run.interrupted ? 'yes' : undefined);
  const rmse = run.quality?.rmse_lod22;
  row(
    'RMSE at LoD 2.2',
    rmse
      ? `${decimal(rmse.p50)} m median, ${decimal(rmse.p90)} m at 90 %: points to the nearest face, per building`
      : undefined,
  );
  for (const [name, count] of Object.entries(run.counts?.fallbacks ?? {})) {
    row(words(name), whole(count));
  }
  const told = [...(run.warnings ?? []), ...(run.tile_problems ?? [])].map((text) =>
    element('p', { class: 'note' }, shown(text)),
  );
  const command = Array.isArray(run.command) ? element('p', { class: 'note' }, run.command.join(' ')) : null;
  refill(nodes.run, element('dl', {}, rows), told, command);
}
