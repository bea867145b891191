// The packet view: one input followed through both loops. Read when it is opened.
import { html, nothing } from '../../../../vendor/lit-html.js';
import { signal } from '../../../../vendor/signals-core.js';
import { letter } from '../../../base/format.js';
import { palette } from '../../../draw/palette.js';
import { touch } from '../../../draw/redraw.js';
import { speak } from '../../../session/announce.js';
import { frame, params, status } from '../../../session/state.js';
import { onto, surfaceOf } from '../../../workbench/canvas.js';
import { layout } from '../core/layout.js';
import { followed, memory } from '../core/state.js';
import { drawLoops, inputAt } from './loops.js';
import { language, number, ready, word } from './words.js';
import { numbersOf, partsOf, wayOf } from './way.js';

/** @typedef {import('./way.js').Way} Way */
/** @typedef {import('../core/frame.js').Frame} Frame */
/** @typedef {import('lit-html').TemplateResult} Template */

const REST = 0.25; /* of the way, that an arrived one stays while the next are followed */

/** The way as the text has it: another object only where a station or the fate is another.
 * @type {import('@preact/signals-core').Signal<Way | null>} */
const told = signal(null);
/** The way in the drawing, which may have left the memory of events. @type {Way | null} */
let kept = null;
/** Of which stretch of time. */
let generation = -1;

/** @param {number} player */
const nameOf = (player) => layout.value?.players[player]?.name ?? letter(player);

/** @param {number} player @param {number} n @param {number} now @returns {Way | null} */
function read(player, n, now) {
  const p = params.value?.players?.[player];
  const apart = p?.display_hz > 0 || /^(lockstep|bucket)/.test(params.value?.server?.sync);
  return wayOf(memory, { player, number: n, now, predicts: p?.prediction === true, apart });
}

/** @param {Frame} now @param {number} player */
function expectedOf(now, player) {
  const lag = now.views[1 + player]?.lag_ms ?? 0,
    hz = Number(params.value?.server?.update_hz ?? 30);
  return (2 * lag) / 1000 + 1.5 / hz + 0.03;
}

/** Without a choice by a person: while it plays, the newest, and the next when that has arrived; else, of those that the last snapshot
 * answers, the middle one, which has waited for it as long as most.
 * @param {Frame} now @param {number} player @returns {Way | null} */
function choose(now, player) {
  const list = numbersOf(memory, player, now.time_s);
  if (status.value === 'playing' || list.length === 0) return read(player, list.at(-1) ?? 0, now.time_s);
  /** @type {Way[]} */
  const answered = [];
  for (const n of [...list].reverse()) {
    const way = read(player, n, now.time_s);
    if (way?.fate === 'shown' && way.snapshot === (answered[0]?.snapshot ?? way.snapshot)) answered.push(way);
    else if (answered.length > 0) break;
  }
  return answered[Math.floor(answered.length / 2)] ?? read(player, list.at(-1) ?? 0, now.time_s);
}

/** The way to show. @param {Frame} now @returns {Way | null} */
function current(now) {
  const asked = followed.value;
  if (asked === null) return null;
  if (generation !== memory.generation) {
    generation = memory.generation;
    if (asked.auto) kept = null;
  }
  const n = asked.auto ? (kept?.player === asked.player ? kept.number : 0) : asked.number;
  const way = n > 0 ? read(asked.player, n, now.time_s) : null;
  const old = kept?.player === asked.player && kept.number === n && kept.stations[0] && kept.stations[0].t <= now.time_s ? kept : null;
  let next = way !== null && (old === null || way.stations[0]?.t === old.stations[0]?.t) ? way : old;
  if (asked.auto && next !== null && next.fate !== 'open' && status.value === 'playing') {
    const last = next.stations.at(-1)?.t ?? 0;
    if (now.time_s > last + REST * expectedOf(now, asked.player)) next = null;
  }
  if (asked.auto && next !== null && (way === null || status.value !== 'playing')) {
    /* time has jumped on */
    if (now.time_s > (next.stations[0]?.t ?? 0) + 2 * expectedOf(now, asked.player)) next = null;
  }
  if (next === null) next = choose(now, asked.player);
  kept = next;
  return next;
}

/** What differs in the text. @param {Way | null} way */
const keyOf = (way) =>
  way === null
    ? ''
    : JSON.stringify([way.player, way.number, way.fate, way.stations, way.dropped, way.predicted, way.snapshotsLost, way.repeats]);

/** @param {Way} way @returns {string} */
function says(way) {
  const { total } = partsOf(way),
    begin = way.stations[0]?.t ?? 0;
  const values = { n: way.number, total: number(total, 1), where: word(`where.${way.stations.at(-1)?.id}`) };
  if (way.fate === 'shown' && way.predicted !== null)
    return word('says.predicted', { ...values, first: number(Math.round((way.predicted - begin) * 1e4) / 10, 1) });
  if (way.fate === 'open' && way.dropped) return word('says.dropped', values);
  return word(`says.${way.fate}`, values);
}

/** @param {number} step */
function move(step) {
  const now = frame.value,
    asked = followed.value;
  if (now === null || asked === null) return;
  const list = numbersOf(memory, asked.player, now.time_s);
  const place = list.indexOf(kept?.number ?? 0);
  const next = list[place < 0 ? list.length - 1 : Math.max(0, Math.min(list.length - 1, place + step))];
  if (next !== undefined) follow(next);
}

/** @param {number} n */
function follow(n) {
  const asked = followed.value;
  if (asked === null) return;
  followed.value = { ...asked, number: n, auto: false };
  touch();
  const way = frame.value === null ? null : read(asked.player, n, frame.value.time_s);
  if (way !== null) speak('packet', says(way));
}

/** @param {boolean} auto */
function setAuto(auto) {
  const asked = followed.value;
  if (asked === null) return;
  followed.value = { ...asked, number: kept?.number ?? 0, auto };
  touch();
}

function newest() {
  const now = frame.value,
    asked = followed.value;
  const last = now && asked ? numbersOf(memory, asked.player, now.time_s).at(-1) : undefined;
  if (last !== undefined) follow(last);
}

/** Arrow keys in the view; Escape goes back. @param {KeyboardEvent} event */
function press(event) {
  if (event.altKey || event.ctrlKey || event.metaKey || event.shiftKey) return;
  if (event.code === 'Escape') close();
  else if (event.code === 'ArrowLeft' || event.code === 'ArrowRight') move(event.code === 'ArrowRight' ? 1 : -1);
  else return;
  event.preventDefault();
  event.stopPropagation();
}

function close() {
  followed.value = null;
  requestAnimationFrame(() => document.getElementById('follow')?.focus());
}

/** @param {MouseEvent} event */
function point(event) {
  const canvas = document.getElementById('loops');
  if (!(canvas instanceof HTMLCanvasElement) || frame.value === null || kept === null) return;
  const found = inputAt(loopsOf(canvas, frame.value, kept), event.offsetX, event.offsetY);
  if (found !== null) follow(found);
}

/** @param {HTMLCanvasElement} canvas @param {Frame} now @param {Way} way @returns {import('./loops.js').Loops} */
function loopsOf(canvas, now, way) {
  const { pen, width, height } = surfaceOf(canvas);
  const short = width < 520 ? '.short' : '';
  const rows = /** @type {[string, string, string, string]} */ (
    ['row.game', 'row.buffer', 'row.net', 'row.link'].map((row) => word(row + short))
  );
  const expected = expectedOf(now, way.player);
  return {
    pen,
    width,
    height,
    colours: palette(),
    memory,
    way,
    now: now.time_s,
    expected,
    name: nameOf(way.player),
    serverName: word('server'),
    ms: (ms) => `${number(ms, 1)} ms`,
    shared: word(`shared${short}`),
    rows,
  };
}

/** @param {Frame} now */
export function draw(now) {
  const canvas = document.getElementById('loops');
  const way = now.peers.length > 0 ? null : current(now);
  if (keyOf(way) !== keyOf(told.value)) told.value = way;
  if (!(canvas instanceof HTMLCanvasElement) || way === null || !ready.value) return;
  onto('loops', () => drawLoops(loopsOf(canvas, now, way), partsOf(way).parts));
}

/** One station: what happens there, at which time, and how long it took from the one before.
 * @param {Way} way @param {number} i @param {number | undefined} ms @returns {Template} */
function stationRow(way, i, ms) {
  const station = /** @type {import('./way.js').Station} */ (way.stations[i]);
  const key = station.id === 'shown' && way.predicted !== null ? 'shown.predicted' : station.id;
  const does = word(key, { name: nameOf(way.player), n: way.number, tick: way.tick, snapshot: way.snapshot });
  const why = word(`for.${station.id}`);
  const detail =
    ms === undefined || ms < 0.05 || why === ''
      ? ''
      : station.id === 'arrived' || station.id === 'came'
        ? word('link', { name: why, lag: number(station.lag_ms ?? 0, 1), rest: number(ms - (station.lag_ms ?? 0), 1) })
        : why;
  return html`<tr data-station=${station.id}><th scope="row">${does}${detail === '' ? nothing : html` <small>${detail}</small>`}</th>
    <td>${number(station.t, 4)} s</td><td data-ms=${ms ?? nothing}>${ms === undefined ? '' : `${number(ms, 1)} ms`}</td></tr>`;
}

/** @param {Way} way @returns {Template} */
function table(way) {
  const { parts, total } = partsOf(way);
  return html`<table class="data stations"><caption class="unseen">${word('table')}</caption>
    <thead><tr><th scope="col">${word('station')}</th><th scope="col">${word('at')}</th><th scope="col">${word('wait')}</th></tr></thead>
    <tbody>${way.stations.map((_, i) => stationRow(way, i, parts[i - 1]?.ms))}</tbody>
    <tfoot><tr><th scope="row">${word(way.fate === 'shown' ? 'total' : 'sofar')}</th><td></td><td
      data-total=${total}>${number(total, 1)} ms</td></tr></tfoot></table>
    ${way.repeats > 0 ? html`<p class="facts">${word('note.repeats', { count: way.repeats })}</p>` : nothing}
    ${way.snapshotsLost > 0 ? html`<p class="facts">${word('note.snapshots', { count: way.snapshotsLost })}</p>` : nothing}`;
}

/** @returns {Template} */
export function template() {
  const asked = followed.value,
    way = told.value;
  const player = asked?.player ?? 0,
    names = layout.value?.players ?? [];
  if (!ready.value) return html`<section class="packetview" aria-busy="true"></section>`;
  const text =
    way === null ? word((frame.peek()?.peers.length ?? 0) > 0 ? 'says.peers' : 'says.none', { name: nameOf(player) }) : says(way);
  return html`<section class="packetview" aria-labelledby="packet-title" lang=${language.value} @keydown=${press}>
    <div class="head"><h2 id="packet-title" tabindex="-1">${word('title')}</h2>
      <button type="button" class="small" id="unfollow" @click=${close}>${word('close')}</button></div>
    <p class="says" id="packet-says">${text}</p>
    <div class="packetbar"><button type="button" @click=${() => move(-1)} aria-label=${word('previous')}>‹</button>
      <button type="button" @click=${() => move(1)} aria-label=${word('next')}>›</button>
      <button type="button" @click=${newest}>${word('newest')}</button>
      ${
        names.length > 1
          ? html`<label class="field choice"><span>${word('player')}</span><select id="packet-player" @change=${(
              /** @type {Event} */ event,
            ) => {
              followed.value = { player: Number(/** @type {HTMLSelectElement} */ (event.target).value), number: 0, auto: true };
              touch();
            }}>${names.map((one, p) => html`<option value=${p} .selected=${p === player}>${one.name}</option>`)}</select></label>`
          : nothing
      }
      <label class="toggle"><input type="checkbox" .checked=${asked?.auto ?? false} @change=${(/** @type {Event} */ event) =>
        setAuto(/** @type {HTMLInputElement} */ (event.target).checked)}><span>${word('auto')}</span></label></div>
    <div class="view" role="group" tabindex="0" data-arrows="yes" aria-label=${`${word('title')}. ${word('keys')}`} @click=${point}>
      <canvas id="loops" role="img" aria-label=${word('drawing', { name: nameOf(player), text })}></canvas></div>
    ${way === null ? nothing : table(way)}
    <p class="facts">${word('lead', { name: nameOf(player) })}</p></section>`;
}
