// Numbers and values for a person.

/** A whole number with thin spaces between its thousands. */
export const whole = (number) => String(Math.round(number)).replace(/\B(?=(\d{3})+$)/g, '\u2009');

/** A number with at most so many decimals, without zeros behind. */
export function decimal(number, digits = 3) {
  if (!Number.isFinite(number)) {
    return '–';
  }
  // Those of a whole number are no decimals.
  const text = digits > 0 ? number.toFixed(digits).replace(/\.?0+$/, '') : number.toFixed(0);
  return text === '-0' ? '0' : text.replace('-', '−');
}

/** `1 building`, `2 buildings`. */
export const counted = (count, noun) => `${whole(count)} ${noun}${count === 1 ? '' : 's'}`;

/** A JSON value as one line of text. */
export function shown(value) {
  if (value === null || value === undefined) {
    return '–';
  }
  if (Array.isArray(value)) {
    return value.length === 0 ? 'none' : value.map(shown).join(', ');
  }
  switch (typeof value) {
    case 'boolean':
      return value ? 'yes' : 'no';
    case 'number':
      return Number.isInteger(value) ? String(value).replace('-', '−') : decimal(value, 4);
    case 'object':
      return JSON.stringify(value);
    default:
      return String(value);
  }
}

/** A keyword or attribute name as words: `too-few-points` and `gable_roof_type` as `too few points` and `roof type`. */
export const words = (name) =>
  String(name)
    .replace(/^gable_/, '')
    .replace(/[_-]+/g, ' ');

/** A duration in seconds. */
export function duration(seconds) {
  if (seconds < 1) {
    return `${Math.round(seconds * 1000)} ms`;
  }
  return seconds < 60 ? `${decimal(seconds, 1)} s` : `${Math.floor(seconds / 60)} min ${Math.round(seconds % 60)} s`;
}

/** The name of a level of detail. */
export const lodName = (lod) => (lod === '' ? 'no LoD' : `LoD ${lod}`);
