// Time since a key was pressed, as a line from the screen to the server and back: takes numbers alone, so that a class shows it without a
// lab.
import { html, nothing, svg } from '../../vendor/lit-html.js';
import { digits, t } from '../base/words.js';

/** ms: to the server, its wait for the next update, the way back, the wait for the next frame on the screen. now: since the key, of what
 * has happened so far; asked: the answer is not shown yet
 * @typedef {{parts: number[], now: number, asked: boolean}} Line */

const LEFT = 3,
  RIGHT = 97; /* hundredths of the width */
const BESIDE = 0.3; /* of its way, a message is as low as the lower edge of the text next to it */
const STEPS = [50, 100, 200, 500];
const LEAST_STEPS = 5;

/** @param {Line} at @returns {import('lit-html').TemplateResult} */
export function since({ parts, now, asked }) {
  const [there = 0, wait = 0, back = 0, frame = 0] = parts,
    total = there + wait + back + frame;
  const span = total * 1.15,
    step = STEPS.find((one) => span / one < LEAST_STEPS * 2) ?? span;
  const x = (/** @type {number} */ ms) => `${(LEFT + ((RIGHT - LEFT) * ms) / span).toFixed(2)}%`;
  const ms = (/** @type {number} */ value) => `${digits(Math.round(value), 0, 0)} ms`;
  const most = asked ? there * 0.35 : Math.min(now, total);
  const ticks = Array.from({ length: Math.floor(span / step) + 1 }, (_, i) => i * step);
  /** A way, as far as it has been gone. @param {number} from @param {number} long @param {[number, number]} ys @param {string} text */
  const way = (from, long, [y0, y1], text) => {
    const part = Math.max(0, Math.min(1, (most - from) / long)),
      y = y0 + (y1 - y0) * part;
    const dashed = asked
      ? svg`<line class="to" x1=${x(from)} y1=${y0} x2=${x(from + long)} y2=${y1}></line>`
      : svg`<line class="way" x1=${x(from)} y1=${y0} x2=${x(from + long * part)} y2=${y}></line>`;
    if (part <= 0) return nothing;
    const at = part < 1 ? part : 0.5;
    return svg`${dashed}<svg x=${x(from + long * at)} y=${y0 + (y1 - y0) * at} class="letter"><rect x="-13" y="-9" width="26" height="18"
      rx="2"></rect><path d="M-13,-8L0,3L13,-8"></path></svg>
      <text class="says" data-down=${y1 > y0} x=${asked ? x(from + long / 2) : x(from + long * (y1 > y0 ? BESIDE : 1 - BESIDE))}
      y=${asked ? 40 : 42} dx=${asked ? '1.4em' : y1 > y0 ? 10 : -10} text-anchor=${asked || y1 > y0 ? 'start' : 'end'}>${text}</text>`;
  };
  /** @param {number} from @param {number} long @param {number} y @param {number} label */
  const waiting = (from, long, y, label) =>
    most > from
      ? svg`<svg x=${x(from)} y=${y - 8} width=${`${(((RIGHT - LEFT) * Math.min(long, most - from)) / span).toFixed(2)}%`} height="16"
        class="waits"><rect width="100%" height="100%"></rect></svg>${
          most >= from + long
            ? svg`<text class="waited" data-last=${y < label}
              x=${x(y < label ? from + long : from + long / 2)} dx=${y < label ? -8 : 0} y=${label}
              text-anchor=${y < label ? 'end' : 'middle'}>${t('workbench.since.waits', { ms: short(long) })}</text>`
            : nothing
        }`
      : nothing;
  const over = most >= total;
  const short = (/** @type {number} */ value) => digits(Math.round(value), 0, 0); /* the axis says of what */
  const said = { there: ms(there), wait: ms(wait), back: ms(back), frame: ms(frame), total: ms(total) };
  return html`<div class="since" role="img" aria-label=${asked ? t('workbench.since.asks', said) : t('workbench.since.is', said)}>
    <p aria-hidden="true"><b>${t('workbench.since.screen')}</b><b>${t('workbench.since.server')}</b></p><svg aria-hidden="true">
      ${ticks.map(
        (tick) => svg`<line class="tick" x1=${x(tick)} y1="22" x2=${x(tick)} y2="112"></line>
          <text class="axis" x=${x(tick)} y="132"
          text-anchor="middle">${tick === 0 ? '0 ms' : digits(tick, 0, 0)}</text>`,
      )}
      <line class="screen" x1=${x(0)} y1="22" x2=${x(span)} y2="22"></line>
      <line class="server" x1=${x(0)} y1="108" x2=${x(span)} y2="108"></line>
      ${way(0, there, [22, 108], asked ? t('workbench.since.on_way', { ms: ms(there) }) : t('workbench.since.there', { ms: short(there) }))}
      ${
        asked
          ? svg`<text class="ask" x=${x(there + wait + back / 2)} y="78"
        text-anchor="middle">${t('workbench.since.then')}</text>`
          : nothing
      }
      ${asked ? nothing : waiting(there, wait, 108, 94)}
      ${asked ? nothing : way(there + wait, back, [108, 22], t('workbench.since.back', { ms: short(back) }))}
      ${asked ? nothing : waiting(there + wait + back, frame, 22, 98)}
      <svg x=${x(0)} y="22" class="dot"><circle r="7"></circle></svg>
      ${
        over && !asked
          ? svg`<line class="upright" x1=${x(total)} y1="22" x2=${x(total)} y2="112"></line>
        <svg x=${x(total)} y="22" class="dot lit"><circle r="8"></circle></svg>
        <text class="total" x=${x(total)} dx="10" y="11"
        text-anchor="end">${ms(total)}</text>`
          : nothing
      }
    </svg></div>`;
}
