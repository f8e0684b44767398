// What the building was and what it is now.

import { element } from '../../../view/page/src/dom.js';
import { decimal, lodName, whole } from '../../../view/page/src/format.js';

/** The figures: how many digits, and whether less is better (-1), more (1), or neither (0). */
const ROWS = [
  ['rmse', 'RMSE', 'm', 3, -1, 'Root mean square of the distances of the points to the model'],
  ['missing', 'missing', 'm²', 1, -1, 'What is scanned and not modelled'],
  ['excess', 'excess', 'm²', 1, -1, 'What is modelled and not scanned'],
  ['confidence', 'confidence', '', 2, 1, 'How far the model can be trusted, 0 to 1'],
  ['faces', 'faces', '', 0, 0, 'Faces at LoD 2.2'],
  ['roof_planes', 'roof planes', '', 0, 0, 'Planes of the roof'],
  ['volume', 'volume', 'm³', 1, 0, 'Volume at LoD 2.2'],
  ['floor', 'floor', '', 2, 0, 'Height of the floor in the CRS'],
];

const shown = (value, digits) =>
  value === null || value === undefined ? '–' : digits === 0 ? whole(value) : decimal(value, digits);

export function figures({ before, now, valid }) {
  const rows = ROWS.map(([key, name, unit, digits, better, title]) => {
    const [was, is] = [shown(before[key], digits), shown(now[key], digits)];
    const known = Number.isFinite(before[key]) && Number.isFinite(now[key]) && was !== is;
    const gain = known ? Math.sign(now[key] - before[key]) * better : 0;
    return element(
      'tr',
      { 'data-figure': key, title },
      element('th', { scope: 'row' }, name),
      element('td', {}, was),
      element('td', { class: gain > 0 ? 'better' : gain < 0 ? 'worse' : was === is ? 'same' : '' }, is),
      element('td', { class: 'unit' }, unit),
    );
  });
  const lod = ({ lod: reached }) => (reached === '' ? 'none' : lodName(reached));
  const level = element(
    'tr',
    { 'data-figure': 'lod', title: 'The level of detail that was reached; a solid that is written is valid' },
    element('th', { scope: 'row' }, valid ? 'valid' : 'level'),
    element('td', {}, lod(before)),
    element('td', { class: lod(before) === lod(now) ? 'same' : valid ? 'better' : 'worse' }, lod(now)),
    element('td', { class: 'unit' }, valid ? '✓' : ''),
  );
  const head = element(
    'tr',
    {},
    element('td'),
    element('th', { scope: 'col' }, 'before'),
    element('th', { scope: 'col' }, 'now'),
    element('td'),
  );
  return element('table', { id: 'figures' }, element('thead', {}, head), element('tbody', {}, level, rows));
}
