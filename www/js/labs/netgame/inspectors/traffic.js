// A player's traffic as the net_graph of the engine Source has it: packets, bytes by type of message, losses, choke, and the newest round
// trip.
import { fixed, letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { cross, drawText, widthOf } from '../../../draw/marks.js';
import { paintOf } from '../../../draw/palette.js';
import { TRAFFIC_MESSAGE } from '../../../stream/names.js';

/** @typedef {import('../core/inspector.js').InspectorContext} InspectorContext */
/** @typedef {import('../../../stream/rows.js').TrafficRow} Row */
/** @typedef {import('../../../stream/rows.js').LinksRow} Link */
/** @typedef {{t: number, traffic: Row[], links: Link[]}} Sample  counts so far */
/** Of one direction; null where nothing was counted. sizes: bytes of a message, by its type
 * @typedef {{packets: number, bytes: number, loss: number | null, sizes: {type: number, bytes: number}[]}} Way */
/** @typedef {{up: Way, down: Way, updates: number, choke: number | null, ping: number | null}} Rates */

const SPAN_S = 5, // of the bars
  STEP_S = 0.1, // between two samples
  OVER_S = 1; // that rates are of

const { input: INPUT, state: STATE, relay: RELAY, connect: CONNECT, ping: PING } = TRAFFIC_MESSAGE;
const UP = /** @type {number[]} */ ([INPUT, CONNECT, PING]);
const goesUp = (/** @type {number} */ type) => UP.includes(type);
/** By their numbers: ends of the keys of their words. */
const NAMES = Object.fromEntries(Object.entries(TRAFFIC_MESSAGE).map(([name, type]) => [type, name]));

/** What was counted while the panel was open, of each stretch of time. @type {WeakMap<object, Sample[]>} */
const kept = new WeakMap();

/** @param {InspectorContext} at @returns {Sample[]} */
function samplesOf({ frame, memory }) {
  let list = kept.get(memory);
  if (!list) kept.set(memory, (list = []));
  const newest = list.at(-1);
  if (frame.links.length === 0 || newest?.links === frame.links || frame.time_s - (newest?.t ?? -Infinity) < STEP_S) return list;
  if (newest && frame.links.some((link, i) => link.down_sent < (newest.links[i]?.down_sent ?? 0)))
    list.length = 0; /* a restart of the counts */
  list.push({ t: frame.time_s, traffic: frame.traffic, links: frame.links });
  while ((list[1]?.t ?? Infinity) <= frame.time_s - SPAN_S) list.shift();
  return list;
}

/** @param {Sample} sample @param {number} player */
const messagesOf = (sample, player) => sample.traffic.filter((row) => row.player === player);
const NO_MESSAGE = { messages: 0, packets: 0, bytes: 0, wire_bytes: 0 };

/** What was sent of each type between two samples. @param {Sample} from @param {Sample} to @param {number} player */
const between = (from, to, player) =>
  messagesOf(to, player).map((row) => {
    const before = messagesOf(from, player).find((one) => one.message === row.message) ?? NO_MESSAGE;
    return {
      type: row.message,
      messages: row.messages - before.messages,
      packets: row.packets - before.packets,
      bytes: row.bytes - before.bytes,
      wire: row.wire_bytes - before.wire_bytes,
    };
  });

const share = (/** @type {number} */ part, /** @type {number} */ whole) => (whole > 0 ? (100 * part) / whole : null);

/** Rates of the last second; null before there are two samples. @param {Sample[]} list @param {number} player @returns {Rates | null} */
export function ratesOf(list, player) {
  const to = list.at(-1),
    from = [...list].reverse().find((one) => to !== undefined && one.t <= to.t - OVER_S) ?? list[0];
  const now = to?.links[player],
    before = from?.links[player];
  if (!to || !from || !now || !before || to.t <= from.t) return null;
  const s = to.t - from.t,
    sent = between(from, to, player),
    sum = (/** @type {number[]} */ values) => values.reduce((a, b) => a + b, 0) / s;
  /** @param {boolean} up @param {number} acks @param {number | null} loss @returns {Way} */
  const way = (up, acks, loss) => {
    const own = sent.filter(({ type }) => goesUp(type) === up);
    return {
      packets: sum(own.map(({ packets }) => packets)),
      bytes: sum([acks, ...own.map(({ wire }) => wire)]),
      loss,
      sizes: own.flatMap(({ type, messages, bytes }) => (messages > 0 ? [{ type, bytes: bytes / messages }] : [])),
    };
  };
  return {
    up: way(true, now.up_ack_bytes - before.up_ack_bytes, share(now.up_lost - before.up_lost, now.up_sent - before.up_sent)),
    down: way(false, now.down_ack_bytes - before.down_ack_bytes, share(now.down_lost - before.down_lost, now.down_sent - before.down_sent)),
    updates: sum(sent.filter(({ type }) => type === STATE || type === RELAY).map(({ messages }) => messages)),
    choke: share(now.choked - before.choked, now.snapshots - before.snapshots),
    ping: now.ping_ms,
  };
}

const percent = (/** @type {number | null} */ value) => (value === null ? '–' : fixed(value, 1));

/** @param {'in' | 'out'} name @param {Way} way @returns {string[]} */
const wayWords = (name, way) => [
  `${t(`netgame_more.traffic.${name}`)} ${t('netgame_more.traffic.packets', { n: fixed(way.packets, 0) })}`,
  t('netgame_more.traffic.bytes', { n: fixed(way.bytes, 0) }),
  t('netgame_more.traffic.loss', { n: percent(way.loss) }),
  ...way.sizes.map(({ type, bytes }) =>
    t('netgame_more.traffic.size', { name: t(`netgame_more.event.of.${NAMES[type]}`), n: fixed(bytes, 0) }),
  ),
];

/** Three lines, each in pieces. @param {Rates} rates @param {number} player @returns {string[][]} */
const linesOf = (rates, player) => [
  [
    `${letter(player)}: ${t('netgame_more.traffic.ping', { n: rates.ping === null ? '–' : fixed(rates.ping, 0) })}`,
    t('netgame_more.traffic.updates', { n: fixed(rates.updates, 0) }),
    t('netgame_more.traffic.choke', { n: percent(rates.choke) }),
  ],
  wayWords('in', rates.down),
  wayWords('out', rates.up),
];

/** Pieces next to each other, on as many lines as they need. @param {InspectorContext} at @param {string[][]} lines
 * @returns {number} where they end, px */
function write({ pen, colours, width }, lines) {
  const high = colours.text * 1.3,
    gap = colours.text;
  let y = high * 0.6;
  for (const pieces of lines) {
    let x = 8;
    pieces.forEach((piece, i) => {
      const wide = widthOf(pen, colours, piece, i === 0);
      if (i > 0 && x + wide > width - 8) {
        x = 8 + gap;
        y += high;
      }
      drawText(pen, colours, piece, x, y, { bold: i === 0 });
      x += wide + gap;
    });
    y += high;
  }
  return y - high * 0.4;
}

/** Bytes of each step of time: to the player above the line, from it below; a cross where one was lost.
 * @param {InspectorContext} at @param {Sample[]} list @param {number} top */
function bars({ pen, colours, width, height, frame, memory, player }, list, top) {
  const middle = (top + height) / 2,
    half = (height - top) / 2 - 2,
    left = 8,
    right = width - 8;
  if (half < 8) return;
  const x = (/** @type {number} */ s) => left + ((s - frame.time_s + SPAN_S) / SPAN_S) * (right - left);
  const steps = list.slice(1).map((to, i) => {
    const from = /** @type {Sample} */ (list[i]),
      sent = between(from, to, player),
      rate = (/** @type {boolean} */ up) =>
        sent.filter(({ type }) => goesUp(type) === up).reduce((sum, { wire }) => sum + wire, 0) / (to.t - from.t);
    return { from: from.t, to: to.t, down: rate(false), up: rate(true) };
  });
  const most = Math.max(1, ...steps.map(({ down, up }) => Math.max(down, up)));
  pen.setLineDash([]);
  pen.strokeStyle = colours.edge;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(left, middle);
  pen.lineTo(right, middle);
  pen.stroke();
  pen.fillStyle = paintOf(colours, player).fill;
  for (const { from, to, down, up } of steps) {
    const begin = Math.max(left, x(from)),
      wide = Math.max(1, x(to) - begin - 1);
    pen.fillRect(begin, middle - (down / most) * half, wide, (down / most) * half);
    pen.fillRect(begin, middle + 1, wide, (up / most) * half);
  }
  pen.strokeStyle = colours.snap;
  for (const event of memory.events.values())
    if (event.player === player && event.fate > 0 && NAMES[event.type] !== undefined && event.begin_s > frame.time_s - SPAN_S)
      cross(pen, x(event.begin_s), goesUp(event.type) ? height - 6 : top + 6, 4);
}

/** @type {import('../core/inspector.js').Inspector} */
export const traffic = {
  id: 'traffic',
  players: true,
  fits: () => true,
  draw(at) {
    const list = samplesOf(at),
      rates = ratesOf(list, at.player);
    if (rates === null) drawText(at.pen, at.colours, t('netgame_more.traffic.none'), 8, at.colours.text);
    else bars(at, list, write(at, linesOf(rates, at.player)));
  },
  words(at) {
    const rates = ratesOf(samplesOf(at), at.player);
    return rates === null ? t('netgame_more.traffic.none') : linesOf(rates, at.player).flat().join(' · ');
  },
};
