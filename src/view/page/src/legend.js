// The legend of a colouring: its categories with counts, or a histogram of its numbers. Each entry and each bar filters.

import { element, refill, svg } from './dom.js';
import { decimal, whole } from './format.js';
import { NOTHING } from './palette.js';
import { rangeOf, valueOf, valuesOf } from './colouring.js';
import { scaleControls } from './scale.js';

/** Fingers want wider bars. */
const BARS = window.matchMedia('(pointer: coarse)').matches ? 6 : 20;
const [WIDTH, HEIGHT, FOOT] = [286, 64, 16];

/** Which figures are told of numbers: the end that needs attention, or both. */
const FIGURES = {
  high: [
    ['median', 0.5],
    ['90 %', 0.9],
    ['max', 1],
  ],
  low: [
    ['min', 0],
    ['10 %', 0.1],
    ['median', 0.5],
  ],
  none: [
    ['min', 0],
    ['median', 0.5],
    ['max', 1],
  ],
};

/** Fills the legend of the colouring that is chosen. */
export function showLegend(model, state, node) {
  const { colouring } = state;
  const isOfFaces = colouring.kind === 'categories' && colouring.scope === 'face' && !colouring.ofFeature;
  const make = isOfFaces ? faceLegend : colouring.kind === 'categories' ? featureLegend : histogram;
  const meaning = colouring.title ? element('p', { class: 'note meaning' }, `${colouring.title}.`) : null;
  refill(node, meaning, make(model, state));
}

const entryOf = (colour, name, count) => [
  element('i', { style: { background: colour } }),
  element('span', { title: name }, name),
  element('b', {}, count),
];

/** Faces have no filter: a building is shown as a whole. */
function faceLegend(model, { colouring, lod }) {
  const counts = new Map();
  for (const run of model.runs.filter((run) => model.isShown(run, lod))) {
    for (let face = run.start; face < run.end; face += 1) {
      const category = colouring.of(face);
      counts.set(category, (counts.get(category) ?? 0) + 1);
    }
  }
  const entries = colouring.categories.map(({ name, colour }, i) => [colour, name, counts.get(i)]);
  entries.push([NOTHING, colouring.nothing, counts.get(-1)]);
  const shownEntries = entries.filter(([, , count]) => count > 0);
  const rows = shownEntries.map(([colour, name, count]) =>
    element('div', { class: 'entry' }, entryOf(colour, name, whole(count))),
  );
  return [element('div', { class: 'entries' }, rows), element('p', { class: 'note' }, 'Numbers of faces.')];
}

function featureLegend(model, state) {
  const { colouring, lod } = state;
  const of = model.features.map((feature, f) => valueOf(colouring, model, f, lod));
  const count = (value) => of.filter((own) => own === value).length;
  const entries = colouring.categories.map(({ name, colour }, i) => [colour, name, i]);
  entries.push([NOTHING, colouring.nothing, -1]);
  const rows = entries
    .filter(([, , value]) => count(value) > 0 || (colouring.key === 'validity' && value === 3 && count(2) > 0))
    .map(([colour, name, value]) => {
      if (colouring.key === 'validity' && value === 3) {
        return element('div', { class: 'entry' }, entryOf(colour, name, ''));
      }
      const filter = `${colouring.key}: ${name}`;
      const act = () => state.toggleFilter(filter, (f) => of[f] === value);
      return pressed(
        state,
        filter,
        element('button', { class: 'entry', type: 'button', onclick: act }, entryOf(colour, name, whole(count(value)))),
      );
    });
  return element('div', { class: 'entries' }, rows);
}

function pressed(state, filter, node) {
  node.setAttribute('aria-pressed', String(state.filter?.name === filter));
  return node;
}

function histogram(model, state) {
  const { colouring } = state;
  const values = valuesOf(model, state);
  const known = values.filter(Number.isFinite).sort((a, b) => a - b);
  const missing = values.length - known.length;
  if (known.length === 0) {
    return element('p', { class: 'note' }, 'No building has a value at this level of detail.');
  }
  const [low, high] = rangeOf(state);
  const width = (high - low) / BARS;
  // The last bar takes all that is above, the first all that is below.
  const barOf = (value) => Math.min(Math.max(Math.floor((value - low) / width), 0), BARS - 1);
  const bars = Array.from({ length: BARS }, () => 0);
  known.forEach((value) => (bars[barOf(value)] += 1));
  const most = Math.max(...bars);
  const unit = colouring.unit ? ` ${colouring.unit}` : '';
  const digits = Math.max(0, Math.min(3, 2 - Math.floor(Math.log10(Math.max(high - low, 1e-9)))));
  const text = (value) => decimal(value, digits);
  const step = WIDTH / BARS;
  const drawn = bars.map((count, i) => {
    const [from, to] = [low + i * width, low + (i + 1) * width];
    const beyond = i === BARS - 1 && known[known.length - 1] > high;
    const below = i === 0 && known[0] < low;
    const range = beyond
      ? `${text(from)}${unit} and more`
      : below
        ? `${text(to)}${unit} and less`
        : `${text(from)} to ${text(to)}${unit}`;
    const filter = `${colouring.key}: ${range}`;
    const height = count === 0 ? 0 : Math.max(2, (count / most) * HEIGHT);
    const act = () =>
      count > 0 && state.toggleFilter(filter, (f) => Number.isFinite(values[f]) && barOf(values[f]) === i);
    const onkeydown = (event) => {
      if (event.key === 'Enter' || event.key === ' ') {
        event.preventDefault();
        act();
      }
    };
    const bar = svg(
      'g',
      {
        class: 'bar',
        role: 'button',
        tabindex: count > 0 ? 0 : -1,
        'aria-label': `${range}: ${count}`,
        'data-count': count,
        onclick: act,
        onkeydown,
      },
      svg('title', {}, `${range}: ${count}`),
      svg('rect', { class: 'hit', x: i * step, y: 0, width: step, height: HEIGHT }),
      svg('rect', {
        class: 'fill',
        x: i * step + 0.75,
        y: HEIGHT - height,
        width: step - 1.5,
        height,
        rx: 1.5,
        fill: colouring.ramp((i + 0.5) / BARS),
      }),
    );
    return pressed(state, filter, bar);
  });
  const label = (x, anchor, value) => svg('text', { x, y: HEIGHT + 13, 'text-anchor': anchor }, value);
  const above = known[known.length - 1] > high ? `≥ ${text(high)}${unit}` : `${text(high)}${unit}`;
  const below = known[0] < low ? `≤ ${text(low)}` : text(low);
  const picture = svg(
    'svg',
    {
      class: 'histogram',
      viewBox: `0 0 ${WIDTH} ${HEIGHT + FOOT}`,
      role: 'group',
      'aria-label': `Histogram of ${colouring.name}`,
    },
    drawn,
    svg('path', { class: 'axis', d: `M0 ${HEIGHT + 0.5}H${WIDTH}` }),
    [label(0, 'start', below), label(WIDTH / 2, 'middle', text((low + high) / 2)), label(WIDTH, 'end', above)],
  );
  const at = (share) => `${decimal(known[Math.min(known.length - 1, Math.floor(share * known.length))], 3)}${unit}`;
  const figures = FIGURES[colouring.care ?? 'none'].map(([name, share]) =>
    element('span', {}, `${name} `, element('b', {}, at(share))),
  );
  const note =
    missing > 0
      ? element('p', { class: 'note' }, element('i', {}), `${whole(missing)} without a value, in grey.`)
      : null;
  return [picture, element('div', { class: 'figures' }, figures), scaleControls(model, state), note];
}
