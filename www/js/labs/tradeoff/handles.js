// The two handles: dragged, moved by keys, read aloud.
import { html } from '../../../vendor/lit-html.js';
import { t } from '../../base/words.js';
import { drawn } from './drawing.js';
import { handleWords, winnerWords } from './sentence.js';
import { hold, lines } from './state.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./state.js').Now} Now */
/** @typedef {import('./sentence.js').Handle} Handle */

/** @param {Handle} handle */
const axisOf = (handle) => (handle === 'budget' ? drawn.plot?.frame.across : drawn.plot?.frame.up);

/** The ends of a handle's way. @param {Handle} handle @returns {[number, number]} */
function endsOf(handle) {
  const axis = axisOf(handle);
  if (!axis) return [0, 1];
  return axis.log ? [10 ** axis.low, 10 ** axis.high] : [axis.low, axis.high];
}

/** @param {Handle} handle @param {PointerEvent} event */
function drag(handle, event) {
  const target = /** @type {HTMLElement} */ (event.currentTarget),
    view = target.parentElement;
  if (!drawn.plot || !view || event.button !== 0) return;
  event.preventDefault();
  const box = view.getBoundingClientRect(),
    { frame, of } = drawn.plot;
  /* where it was taken stays under the finger */
  const [offX, offY] = [event.clientX - box.left - of.handles.x, event.clientY - box.top - of.handles.y];
  const taken = target.classList.contains('strip') || target.getAttribute('role') !== 'slider' ? [0, 0] : [offX, offY];
  const to = (/** @type {PointerEvent} */ at) =>
    hold(
      handle,
      handle === 'budget' ? frame.ofX(at.clientX - box.left - (taken[0] ?? 0)) : frame.ofY(at.clientY - box.top - (taken[1] ?? 0)),
    );
  const done = () => {
    target.removeEventListener('pointermove', to);
    target.removeEventListener('pointerup', done);
    target.removeEventListener('pointercancel', done);
  };
  target.setPointerCapture(event.pointerId);
  target.addEventListener('pointermove', to);
  target.addEventListener('pointerup', done);
  target.addEventListener('pointercancel', done);
  /** @type {HTMLElement | null} */ (view.querySelector(`[role="slider"][data-handle="${handle}"]`))?.focus();
}

/** @param {Handle} handle @param {KeyboardEvent} event */
function press(handle, event) {
  const axis = axisOf(handle),
    [low, high] = endsOf(handle),
    value = handle === 'budget' ? lines.value.cost : lines.value.error;
  const steps =
    /** @type {Record<string, number>} */ ({ ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 5, PageDown: -5 })[
      event.key
    ] ?? 0;
  const to =
    event.key === 'Home'
      ? low
      : event.key === 'End'
        ? high
        : steps === 0 || !axis
          ? Number.NaN
          : axis.log
            ? value * 10 ** (steps / 12)
            : value + (steps * (high - low)) / 50;
  if (Number.isNaN(to)) return;
  event.preventDefault();
  hold(handle, Math.max(low, Math.min(high, to)));
}

/** @param {Now} at @param {Handle} handle @returns {Template} */
export function slider(at, handle) {
  const value = handle === 'budget' ? lines.value.cost : lines.value.error,
    [low, high] = endsOf(handle),
    log = axisOf(handle)?.log === true;
  /* a log axis is read aloud in decades, whose numbers are short */
  const aloud = (/** @type {number} */ one) => (log ? Math.log10(one).toFixed(2) : String(Number(one.toPrecision(3))));
  const words = `${handleWords(at, handle)}. ${at.winner ? winnerWords(at) : t('tradeoff.nothing_inside')}`;
  const pull = (/** @type {PointerEvent} */ event) => drag(handle, event);
  return html`<div class="strip" data-handle=${handle} aria-hidden="true" @pointerdown=${pull}></div>
    <div class="handle" role="slider" tabindex="0" data-handle=${handle} aria-label=${t(`tradeoff.${handle}_name`)}
      aria-orientation=${handle === 'budget' ? 'horizontal' : 'vertical'} aria-valuemin=${aloud(low)}
      aria-valuemax=${aloud(high)} aria-valuenow=${aloud(value)}
      aria-valuetext=${words} @pointerdown=${pull}
      @keydown=${(/** @type {KeyboardEvent} */ event) => press(handle, event)}></div>`;
}
