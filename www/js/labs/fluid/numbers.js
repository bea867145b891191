// The metrics of a fluid as text: errors first, then conserved quantities, then the rest.
import { localized } from '../../base/format.js';
import { nameOf } from '../../base/words.js';

const UNITS = /** @type {[RegExp, string][]} */ ([
  [/_m2ps$/, 'm²/s'],
  [/_mps2$/, 'm/s²'],
  [/_mps$/, 'm/s'],
  [/_per_s$|_hz$/, '1/s'],
  [/_pct$/, '%'],
  [/_ms$/, 'ms'],
  [/_m2$/, 'm²'],
  [/_m$/, 'm'],
  [/_s$/, 's'],
  [/_rad$/, 'rad'],
  [/_j$/, 'J'],
  [/_kg$/, 'kg'],
  [/_pa$/, 'Pa'],
]);

/** @param {string} name @returns {{label: string, unit: string}} */
export function wordsOf(name) {
  const known = nameOf('fluid', 'metrics', name);
  const found = UNITS.find(([end]) => end.test(name));
  const label = (found ? name.replace(found[0], '') : name).replaceAll('_', ' ');
  return { label: known?.label ?? label, unit: found?.[1] ?? (/^divergence/.test(name) ? '1/s' : '') };
}

const WRONG = /error|numerical|divergence|density|residual|overshoot|beyond/,
  KEPT = /mass|energy|momentum|volume|front|height|cfl/;

/** @param {string} name @returns {0 | 1 | 2} */
export const rankOf = (name) => (WRONG.test(name) ? 0 : KEPT.test(name) ? 1 : 2);

/** Whether only its size matters, over powers of ten. @param {string} name */
export const isSize = (name) => WRONG.test(name);

/** @param {string} name @param {number} value @returns {string} */
export function formatNumber(name, value) {
  if (!Number.isFinite(value)) return '–';
  if (name === 'bytes') return localized(`${(value / 1e6).toPrecision(3)} MB`);
  const size = Math.abs(value);
  const text = value === 0 ? '0' : size < 1e-3 || size >= 1e6 ? value.toExponential(1) : String(Number(value.toPrecision(4)));
  return localized(text);
}

/** Index of the metric that a plot shows first. @param {string[]} names @param {RegExp[]} wanted in order */
export function pick(names, wanted) {
  for (const pattern of wanted) {
    const place = names.findIndex((name) => pattern.test(name));
    if (place >= 0) return place;
  }
  return 0;
}
