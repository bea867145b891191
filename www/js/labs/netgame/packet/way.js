// The way of one input: from the hand through both loops and both buffers to the server, and back to the display. Times are of the events.
import { APPLIED, DISPLAY, INPUT, INPUT_RESULT, LATE, REFUSED, STATE, STEP } from '../core/frame.js';

/** @typedef {import('../core/memory.js').Met} Event */
/** @typedef {import('../core/memory.js').Memory} Memory */
/** @typedef {'touched' | 'made' | 'sent' | 'arrived' | 'taken' | 'left' | 'came' | 'released' | 'shown'} StationId */
/** t: s; lag_ms: configured when the packet was sent. @typedef {{id: StationId, t: number, lag_ms?: number}} Station */
/** How it ended, or that it has not: `open`. @typedef {'open' | 'shown' | 'lost' | 'late' | 'refused'} Fate */

/**
 * @typedef {object} Way
 * @property {number} player
 * @property {number} number    of the input
 * @property {Station[]} stations  that it has passed by now, in order
 * @property {Fate} fate
 * @property {number} arrives   s; when the packet that is on a link arrives; where none is, when it last did
 * @property {number} tick      the server's step that takes the input; 0: not known yet
 * @property {number} snapshot  tick of the snapshot that answers; 0: none yet
 * @property {boolean} dropped  by the link, and no other packet has brought the input
 * @property {number} repeats   packets with this input that were lost before one came through
 * @property {number} snapshotsLost  that would have answered earlier
 * @property {number | null} predicted  s; first display of its prediction
 */

/** @param {Memory} memory @param {number} player @param {number} now @returns {number[]} inputs that have been sent, oldest first */
export function numbersOf(memory, player, now) {
  const list = new Set();
  for (const event of memory.events.values())
    if (event.type === INPUT && event.player === player && event.begin_s <= now) list.add(event.number);
  return [...list].sort((a, b) => a - b);
}

/** Events of a player's packets by their type, oldest first. @param {Memory} memory @param {number} player @param {number} now */
function sorted(memory, player, now) {
  /** @type {Map<number, Event[]>} */
  const by = new Map([INPUT, INPUT_RESULT, STATE, APPLIED, DISPLAY, STEP].map((type) => [type, []]));
  for (const event of memory.events.values()) {
    if (event.begin_s <= now && (event.type === STEP || event.player === player)) by.get(event.type)?.push(event);
  }
  return (/** @type {number} */ type) => by.get(type) ?? [];
}

/** The way back, from the step on. @param {(type: number) => Event[]} of @param {Event} step @param {Way} way @param {number} now */
function back(of, step, way, now) {
  const answers = of(STATE).filter((one) => one.begin_s >= step.begin_s && one.number >= step.number);
  const used = of(APPLIED).find((one) => one.outcome === 0 && one.begin_s >= step.begin_s && one.number >= step.number);
  const coming = answers.filter((one) => one.fate === 0).sort((a, b) => a.end_s - b.end_s);
  const answer = used ? coming.find((one) => one.number === used.number && one.end_s <= used.begin_s) : coming[0];
  const until = answer?.begin_s ?? now + 1;
  way.snapshotsLost = answers.filter((one) => one.fate !== 0 && one.begin_s < until).length;
  if (!answer) return;
  way.snapshot = answer.number;
  way.arrives = answer.end_s;
  way.stations.push({ id: 'left', t: answer.begin_s });
  if (answer.end_s > now) return;
  way.stations.push({ id: 'came', t: answer.end_s, lag_ms: answer.lag_ms });
  if (!used) return;
  way.stations.push({ id: 'released', t: used.begin_s });
  const display = of(DISPLAY).find((one) => one.begin_s >= used.begin_s && one.number >= used.number);
  if (!display) return;
  way.stations.push({ id: 'shown', t: display.begin_s });
  way.fate = 'shown';
}

/** Null: the input is not known, or not sent yet. predicts: the player has client-side prediction; apart: its displays have a clock of
 * their own. @param {Memory} memory @param {{player: number, number: number, now: number, predicts: boolean, apart: boolean}} asked
 * @returns {Way | null} */
export function wayOf(memory, { player, number, now, predicts, apart }) {
  const of = sorted(memory, player, now);
  const packets = of(INPUT).filter((one) => one.number === number);
  const input = packets[0];
  if (!input) return null;
  const result = of(INPUT_RESULT).find((one) => one.number === number);
  /* with redundancy, a later packet may bring it */
  const bringer = result ? of(INPUT).find((one) => one.fate === 0 && one.end_s === result.begin_s && one.number >= number) : undefined;
  const carrier = bringer ?? packets.find((one) => one.fate === 0) ?? input;
  const made = input.begin_s - input.held_ms / 1000;
  /** @type {Way} */
  const way = {
    player,
    number,
    stations: [{ id: 'made', t: made }],
    fate: 'open',
    arrives: carrier.end_s,
    tick: 0,
    snapshot: 0,
    dropped: false,
    repeats: of(INPUT).filter((one) => one.number >= number && one.fate !== 0 && one.begin_s < carrier.begin_s).length,
    snapshotsLost: 0,
    predicted: null,
  };
  if (input.device_ms > 0) way.stations.unshift({ id: 'touched', t: made - input.device_ms / 1000 });
  if (predicts) way.predicted = apart ? (of(DISPLAY).find((one) => one.begin_s >= made)?.begin_s ?? null) : made;
  way.stations.push({ id: 'sent', t: carrier.begin_s });
  const meant = input.tick;
  const over = meant > 0 && of(STEP).some((one) => one.number >= meant);
  if (carrier.fate !== 0) {
    way.arrives = carrier.begin_s;
    way.dropped = true;
    if (over || meant === 0) way.fate = 'lost';
    return way;
  }
  if (!result || result.begin_s > now) return way;
  way.stations.push({ id: 'arrived', t: result.begin_s, lag_ms: carrier.lag_ms });
  if (result.outcome === REFUSED) way.fate = 'refused';
  else if (result.outcome === LATE) way.fate = 'late';
  if (way.fate !== 'open') return way;
  const step = of(STEP).find((one) => (meant > 0 ? one.number === meant : one.begin_s >= result.begin_s));
  if (!step) return way;
  way.tick = step.number;
  way.stations.push({ id: 'taken', t: step.begin_s });
  back(of, step, way, now);
  return way;
}

/** The waiting times between the stations, ms to a tenth: differences of rounded times, so that they add up to the rounded total.
 * @param {Way} way @returns {{parts: {from: StationId, to: StationId, ms: number}[], total: number}} */
export function partsOf({ stations }) {
  const begin = stations[0]?.t ?? 0;
  const tenths = stations.map(({ t }) => Math.round((t - begin) * 1e4));
  const parts = stations.slice(1).map((to, i) => ({
    from: /** @type {Station} */ (stations[i]).id,
    to: to.id,
    ms: /** @type {number} */ (tenths[i + 1] - /** @type {number} */ (tenths[i])) / 10,
  }));
  return { parts, total: (tenths.at(-1) ?? 0) / 10 };
}
