// Numbers as people read them: three significant digits, a true minus sign, always a unit.
import { decimalPoint, t } from './words.js';

/** @param {number} value @param {number} digits after the point @returns {string} */
export function fixed(value, digits) {
  if (!Number.isFinite(value)) return '–';
  const text = Math.abs(value).toFixed(digits),
    shown = decimalPoint.value === '.' ? text : text.replace('.', decimalPoint.value);
  return value < 0 && Number(text) !== 0 ? `−${shown}` : shown;
}

/** A number that is written already: with the language's point and a true minus sign. @param {string} text @returns {string} */
export const localized = (text) => text.replaceAll('-', '−').replace('e+', 'e').replace('.', decimalPoint.value);

/** Three significant digits. @param {number} value @returns {string} */
export function short(value) {
  const size = Math.abs(value);
  return fixed(value, size >= 100 ? 0 : size >= 10 ? 1 : 2);
}

/** With a sign on both sides of zero. @param {number} value @param {number} digits @returns {string} */
export function signed(value, digits) {
  const text = fixed(value, digits);
  return value > 0 && Number(value.toFixed(digits)) !== 0 ? `+${text}` : text;
}

/** A number of a text field, without noise of binary fractions. @param {number} value @returns {string} */
export function plain(value) {
  return String(Number(value.toPrecision(6)));
}

/** A number as a text field has it, in the language's form. @param {number} value @returns {string} */
export const typed = (value) => plain(value).replace('.', decimalPoint.value);

/** What a person typed, with the language's decimal sign or the point. Where a sign may also divide thousands, as in 0,2 in English and
 * 1.234 in German, nothing is guessed. @param {string} text @returns {number | 'ambiguous'} NaN: no number */
export function typedNumber(text) {
  const own = decimalPoint.value,
    given = text.trim().replaceAll('−', '-');
  if (own === '.') return /^[-+]?[\d.]*,[\d.,]*$/.test(given) ? 'ambiguous' : numberOf(given);
  const both = given.includes(own) && given.includes('.');
  if (/^[-+]?[\d.,]+$/.test(given) && (both || given.split(own).length > 2 || /^[-+]?[1-9]\d{0,2}\.\d{3}$/.test(given))) return 'ambiguous';
  return numberOf(given.replace(own, '.'));
}

/** @param {string} text of JavaScript's form @returns {number} NaN: none */
const numberOf = (text) => (/^[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?$/i.test(text) ? Number(text) : NaN);

/** @param {number} player @returns {string} A, B, C, ... */
export function letter(player) {
  return String.fromCharCode(65 + player);
}

/** A speed in words; empty at the normal speed and above it. @param {number} now @returns {string} */
export function slower(now) {
  const times = 1 / now;
  return times > 1.01 ? t('base.slower', { times: Number(times.toPrecision(2)) }) : '';
}
