// The buildings of the list: which are shown, in which order.

/** What a reason is about: its words before its first number. */
export const reasonOf = (why) => why.replace(/[:\d].*$/s, '').trim() || why;

export const STATES = ['open', 'edited', 'accepted', 'rejected'];

const by = (of, isRising) => (a, b) => {
  const [x, y] = [of(a), of(b)];
  // What is not known comes last.
  if (x === null || y === null || x === undefined || y === undefined) {
    return Number(x === null || x === undefined) - Number(y === null || y === undefined);
  }
  return (isRising ? 1 : -1) * (x < y ? -1 : x > y ? 1 : 0);
};

/** The orders of the list. */
export const ORDERS = {
  urgency: { name: 'what needs a person first', compare: by((row) => row.urgency, false) },
  rmse: { name: 'largest RMSE', compare: by((row) => row.rmse, false) },
  missing: { name: 'largest missing part', compare: by((row) => row.missing, false) },
  excess: { name: 'largest excess', compare: by((row) => row.excess, false) },
  confidence: { name: 'least confidence', compare: by((row) => row.confidence, true) },
  faces: { name: 'most faces', compare: by((row) => row.faces, false) },
  id: { name: 'id', compare: by((row) => row.id, true) },
};

/** The reasons of all rows, the most frequent first, with their counts. */
export function reasonsOf(rows) {
  const counts = new Map();
  rows.forEach(({ why }) =>
    new Set(why.map(reasonOf)).forEach((reason) => counts.set(reason, (counts.get(reason) ?? 0) + 1)),
  );
  return [...counts].sort((a, b) => b[1] - a[1] || a[0].localeCompare(b[0]));
}

/** The rows that pass the filters, in their order. */
export function shownRows(rows, { states, reason, text, order }) {
  const wanted = text.trim().toLowerCase();
  const passes = (row) =>
    (states.size === 0 || states.has(row.state)) &&
    (reason === '' || row.why.some((why) => reasonOf(why) === reason)) &&
    (wanted === '' ||
      row.id.toLowerCase().includes(wanted) ||
      row.why.some((why) => why.toLowerCase().includes(wanted)));
  const { compare } = ORDERS[order];
  return rows
    .map((row, i) => [row, i])
    .filter(([row]) => passes(row))
    .sort(([a, i], [b, j]) => compare(a, b) || i - j)
    .map(([row]) => row);
}
