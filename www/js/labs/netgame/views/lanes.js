// The swim-lane of messages: time to the right, a line for each end, a slope for each message.
import { ACCEPT, APPLIED, BLOCKED, CONNECT, INPUT, PING, PONG, REFUSAL, SEGMENT, STATE, STEP, INPUT_RESULT } from '../core/frame.js';
import { fixed, letter } from '../../../base/format.js';
import { paintOf } from '../../../draw/palette.js';
import { cross, drawText } from '../../../draw/marks.js';
import { drawShown, place } from '../../../draw/shown.js';
import { t } from '../../../base/words.js';

/** @typedef {import('../core/frame.js').Event & {index: number}} Message */
/** @typedef {import('../core/memory.js').Memory} Memory */
/** @typedef {import('../../../draw/palette.js').Palette} Palette */

/**
 * @typedef {object} Lanes
 * @property {CanvasRenderingContext2D} pen
 * @property {number} width
 * @property {number} height
 * @property {Palette} colours
 * @property {import('../core/frame.js').Frame} frame
 * @property {Memory} memory
 * @property {string[]} names
 * @property {[number, number]} shown   players above and below the server's line
 * @property {boolean} labels
 * @property {boolean} pings    pings and their answers are drawn
 * @property {number | null} selected   id of an input whose whole life is drawn bold
 */

const LEFT = 54,
  RIGHT = 12;
const CROWD = 6; /* messages of one kind in a lane: twelve with both directions */
const SERVER = 0; /* player of the events of the server's steps */
const LOST_AT = 0.6; /* of its way */
const UP = new Set(/** @type {number[]} */ ([INPUT, CONNECT, PING]));

/** Seconds that the lane shows. @param {import('../core/frame.js').Frame} frame @returns {number} */
export function windowOf(frame) {
  const lags = frame.views.slice(1).map((view) => view.lag_ms / 1000);
  return Math.max(0.4, 3 * Math.max(0, ...lags));
}

/** Messages of one kind within the window. @param {Lanes} at @param {number} type @param {number} player @returns {Message[]} */
function messages(at, type, player) {
  const from = at.frame.time_s - windowOf(at.frame);
  const endOf = (/** @type {Message} */ event) => (event.fate === 0 ? event.end_s : event.begin_s + lagOf(at, player));
  return at.memory.of(type, player).filter((event) => event.begin_s <= at.frame.time_s && endOf(event) >= from);
}

/** @param {Lanes} at @param {number} player @returns {number} s */
function lagOf(at, player) {
  return Math.max(0.02, (at.frame.views[1 + player]?.lag_ms ?? 0) / 1000);
}

/** Draw every k-th of n messages. A little slack keeps k steady. @param {number} n @returns {number} */
export function thinning(n) {
  return n <= CROWD + 1 ? 1 : Math.ceil((n - 1) / CROWD);
}

/** One input from press to effect: its message, its result at the server, the next snapshot that includes it, and its application.
 * @param {Memory} memory @param {Message} input @returns {{result?: Message, state?: Message, applied?: Message}} */
export function lifeOf(memory, input) {
  /** @type {{result?: Message, state?: Message, applied?: Message}} */
  const life = {};
  for (const event of memory.events.values()) {
    if (event.player !== input.player) continue;
    if (event.type === INPUT_RESULT && event.number === input.number) life.result ??= event;
    else if (event.type === STATE && event.fate === 0 && life.result && event.begin_s >= life.result.begin_s) life.state ??= event;
    else if (event.type === APPLIED && life.state && event.number === life.state.number) life.applied ??= event;
  }
  return life;
}

/** @param {Lanes} at */
function places(at) {
  const span = windowOf(at.frame),
    now = at.frame.time_s;
  const inner = at.width - LEFT - RIGHT;
  const top = at.colours.text * 1.2,
    bottom = at.height - at.colours.text * 1.4;
  return {
    span,
    now,
    top,
    bottom,
    middle: (top + bottom) / 2,
    x: (/** @type {number} */ t) => LEFT + ((t - now) / span + 1) * inner,
  };
}

/** Position of a message on its way. @param {Lanes} at @param {Message} message @param {number} yOwn @param {number} yServer */
function wayOf(at, message, yOwn, yServer) {
  const { x, now } = places(at);
  const up = UP.has(message.type),
    from = up ? yOwn : yServer,
    to = up ? yServer : yOwn;
  const lost = message.fate !== 0;
  const end = lost ? message.begin_s + lagOf(at, message.player) : message.end_s;
  const part = Math.min(lost ? LOST_AT : 1, end > message.begin_s ? (now - message.begin_s) / (end - message.begin_s) : 1);
  return { x, up, from, to, lost, end, part, hx: x(message.begin_s + part * (end - message.begin_s)), hy: from + part * (to - from) };
}

/** Messages of the connection: thin, with a dot. @param {Lanes} at @param {Message} message @param {number} yOwn @param {number} yServer */
function drawQuiet(at, message, yOwn, yServer) {
  const { pen, colours } = at;
  const { x, from, lost, part, hx, hy } = wayOf(at, message, yOwn, yServer);
  pen.strokeStyle = pen.fillStyle = colours.faint;
  pen.setLineDash([]);
  pen.lineWidth = 0.7;
  pen.beginPath();
  pen.moveTo(x(message.begin_s), from);
  pen.lineTo(hx, hy);
  pen.stroke();
  if (lost && part >= LOST_AT) {
    pen.strokeStyle = colours.snap;
    cross(pen, hx, hy, 3);
    return;
  }
  pen.beginPath();
  pen.arc(hx, hy, 2, 0, 2 * Math.PI);
  pen.fill();
  const word = message.type === CONNECT ? t('netgame.lane.connect') : message.type === ACCEPT ? t('netgame.lane.accept') : '';
  if (word !== '' && at.labels) drawText(pen, colours, word, (x(message.begin_s) + hx) / 2 + 5, (from + hy) / 2, { colour: colours.faint });
}

/** @param {Lanes} at @param {Message} message @param {number} yOwn @param {number} yServer @param {boolean} bold */
function drawMessage(at, message, yOwn, yServer, bold) {
  const { pen, colours } = at;
  const { x, up, from, to, lost, end, part, hx, hy } = wayOf(at, message, yOwn, yServer);
  const paint = paintOf(colours, message.player);
  pen.strokeStyle = message.type === REFUSAL ? colours.snap : paint.text;
  pen.fillStyle = pen.strokeStyle;
  pen.lineWidth = bold ? colours.line + 1.5 : Math.max(1.2, colours.line - 0.6);
  pen.setLineDash(paint.dash);
  pen.beginPath();
  pen.moveTo(x(message.begin_s), from);
  pen.lineTo(hx, hy);
  pen.stroke();
  pen.setLineDash([]);
  if (lost && part >= LOST_AT) {
    pen.lineWidth = colours.line;
    pen.strokeStyle = colours.snap;
    cross(pen, hx, hy, 4.5);
  } else if (up) {
    const angle = Math.atan2(to - from, x(end) - x(message.begin_s));
    pen.beginPath();
    for (const turn of [0, 2.5, -2.5]) pen.lineTo(hx + 6 * Math.cos(angle + turn), hy + 6 * Math.sin(angle + turn));
    pen.closePath();
    pen.fill();
  } else {
    pen.fillRect(hx - 3.2, hy - 3.2, 6.4, 6.4);
  }
}

const SEGMENT_UP = 2; /* bit of the outcome of a segment or a blocked message: to the server */

/** A packet of a stream that was lost or sent again: dashed, so that the message it carries stands apart.
 * @param {Lanes} at @param {Message} packet @param {number} yOwn @param {number} yServer */
function drawSegment(at, packet, yOwn, yServer) {
  const { pen, colours } = at;
  const { x, now } = places(at);
  const up = (packet.outcome & SEGMENT_UP) !== 0,
    from = up ? yOwn : yServer,
    to = up ? yServer : yOwn;
  const lost = packet.fate !== 0;
  const end = lost ? packet.begin_s + lagOf(at, packet.player) : packet.end_s;
  const part = Math.min(lost ? LOST_AT : 1, end > packet.begin_s ? (now - packet.begin_s) / (end - packet.begin_s) : 1);
  const hx = x(packet.begin_s + part * (end - packet.begin_s)),
    hy = from + part * (to - from);
  pen.strokeStyle = colours.snap;
  pen.lineWidth = colours.line;
  pen.setLineDash([5, 3]);
  pen.beginPath();
  pen.moveTo(x(packet.begin_s), from);
  pen.lineTo(hx, hy);
  pen.stroke();
  pen.setLineDash([]);
  if (lost && part >= LOST_AT) cross(pen, hx, hy, 4.5);
}

/** A message of a stream that has arrived and waits for an earlier one: a bar at its receiver.
 * @param {Lanes} at @param {Message} message @param {number} yOwn @param {number} yServer */
function drawBlocked(at, message, yOwn, yServer) {
  const { pen, colours } = at;
  const { x } = places(at);
  const y = (message.outcome & SEGMENT_UP) !== 0 ? yServer + Math.sign(yOwn - yServer) * 4 : yOwn + Math.sign(yServer - yOwn) * 4;
  pen.strokeStyle = colours.buffer;
  pen.lineWidth = colours.line + 1;
  pen.beginPath();
  pen.moveTo(x(message.begin_s), y);
  pen.lineTo(x(message.end_s), y);
  pen.stroke();
}

/** @param {Lanes} at @param {Message} input @param {number} yOwn @param {number} yServer @returns {string} */
function drawLife(at, input, yOwn, yServer) {
  const { result, state, applied } = lifeOf(at.memory, input);
  drawMessage(at, input, yOwn, yServer, true);
  if (state) drawMessage(at, state, yOwn, yServer, true);
  const { pen, colours } = at;
  const { x } = places(at);
  const ms = (/** @type {number} */ s) => `${fixed(s * 1000, 0)} ms`;
  if (result && state && state.begin_s > result.begin_s) {
    pen.lineWidth = colours.line + 2;
    pen.strokeStyle = colours.buffer;
    pen.beginPath();
    pen.moveTo(x(result.begin_s), yServer);
    pen.lineTo(x(state.begin_s), yServer);
    pen.stroke();
  }
  const half = (/** @type {number} */ t0, /** @type {number} */ t1, /** @type {number} */ y, /** @type {string} */ text) =>
    drawText(pen, colours, text, (x(t0) + x(t1)) / 2, y, { align: 'center', bold: true });
  const between = (yOwn + yServer) / 2;
  if (input.fate === 0) half(input.begin_s, input.end_s, between, ms(input.end_s - input.begin_s));
  if (result && state && state.begin_s > result.begin_s)
    half(result.begin_s, state.begin_s, yServer - colours.text * 0.9, ms(state.begin_s - result.begin_s));
  if (state) half(state.begin_s, state.end_s, between, ms(state.end_s - state.begin_s));
  const parts = [t('netgame.life', { n: String(input.number), name: letter(input.player) })];
  if (input.fate !== 0) parts.push(t('netgame.life.lost'));
  else if (result) parts.push(t('netgame.life.tick', { ms: ms(result.begin_s - input.begin_s) }));
  if (result && state) parts.push(t('netgame.life.snapshot', { ms: ms(state.begin_s - result.begin_s) }));
  if (state && applied) {
    parts.push(t('netgame.life.use', { ms: ms(applied.begin_s - state.begin_s) }));
    parts.push(t('netgame.life.total', { ms: ms(applied.begin_s - input.begin_s) }));
  }
  return parts.join(' · ');
}

const TORN = 5; /* px, of a tooth */

/** Where events are missing the lanes are torn: without a mark it would look as if nothing had been sent.
 * @param {Lanes} at @returns {boolean} whether they are, in the last seconds, before the window too */
function tear(at) {
  const { pen, colours } = at,
    { x, now, span, top, bottom } = places(at);
  pen.strokeStyle = colours.faint;
  pen.lineWidth = 1;
  pen.setLineDash([]);
  for (const edge of at.memory.gaps.flatMap(({ from, to }) => [from, to])) {
    if (edge < now - span || edge > now) continue;
    pen.beginPath();
    for (let y = top - TORN, k = 0; y <= bottom + TORN; y += TORN, k++) pen.lineTo(x(edge) + (k % 2) * TORN, y);
    pen.stroke();
  }
  return at.memory.gaps.length > 0;
}

/** Reports when the upper player sent the input whose answer is its newest, and when that came. @param {Lanes} at */
function reportAnswer(at) {
  const { x, now, span, top } = places(at);
  const answered = messages(at, INPUT, at.shown[0])
    .map((input) => ({ from: input.begin_s, to: lifeOf(at.memory, input).state?.end_s ?? Infinity }))
    .filter(({ from, to }) => from >= now - span && to <= now)
    .at(-1);
  if (!answered) return;
  place(at.pen.canvas, 'sent', x(answered.from), top, answered.from * 1000);
  place(at.pen.canvas, 'answer', x(answered.to), top, answered.to * 1000);
}

/** @param {Lanes} at @returns {{inputs: number, states: number, torn: boolean, text: string}} one of how many inputs and snapshots is
 * drawn; whether events are missing; the caption of the drawing */
export function drawLanes(at) {
  const { pen, colours, frame } = at;
  const { x, now, span, top, middle, bottom } = places(at);
  const [upper, lower] = at.shown;
  const lines =
    upper === lower
      ? [{ p: upper, y: top }]
      : [
          { p: upper, y: top },
          { p: lower, y: bottom },
        ];

  pen.setLineDash([]);
  pen.fillStyle = colours.grid; /* the server's ticks */
  const steps = at.memory.of(STEP, SERVER).filter((e) => e.begin_s >= now - span && e.begin_s <= now);
  for (const [name, one] of /** @type {[string, Message | undefined][]} */ ([
    ['step', steps.at(-1)],
    ['step.before', steps.at(-2)],
  ]))
    if (one) place(at.pen.canvas, name, x(one.begin_s), middle, one.begin_s * 1000);
  reportAnswer(at);
  const every = Math.max(1, Math.ceil(steps.length / 80));
  for (const step of steps) if (step.number % every === 0) pen.fillRect(Math.round(x(step.begin_s)), top, 1, bottom - top);
  pen.save();
  pen.beginPath();
  pen.rect(LEFT, 0, at.width - LEFT, at.height);
  pen.clip();
  const picked = at.selected === null ? undefined : at.memory.events.get(at.selected);
  let text = '';
  const thinned = { inputs: 1, states: 1, torn: false };
  for (const { p, y } of lines) {
    pen.globalAlpha = picked ? 0.25 : 1;
    for (const type of at.pings ? [PING, PONG, CONNECT, ACCEPT] : [CONNECT, ACCEPT]) {
      for (const message of messages(at, type, p)) drawQuiet(at, message, y, middle);
    }
    for (const message of messages(at, BLOCKED, p)) drawBlocked(at, message, y, middle);
    for (const packet of messages(at, SEGMENT, p)) drawSegment(at, packet, y, middle);
    for (const type of [INPUT, STATE, REFUSAL]) {
      const list = messages(at, type, p);
      const k = type === REFUSAL ? 1 : thinning(list.length);
      if (type === INPUT) thinned.inputs = Math.max(thinned.inputs, k);
      if (type === STATE) thinned.states = Math.max(thinned.states, k);
      for (const message of list) {
        if (message.index % k === 0 || (message.fate !== 0 && type !== REFUSAL)) drawMessage(at, message, y, middle, false);
      }
    }
    pen.globalAlpha = 1;
    if (picked && picked.player === p) text = drawLife(at, picked, y, middle);
  }
  pen.restore();

  for (const { y, name, colour } of [
    ...lines.map((line) => ({ y: line.y, name: at.names[line.p] ?? letter(line.p), colour: paintOf(colours, line.p).text })),
    { y: middle, name: t('netgame.server'), colour: colours.truth },
  ]) {
    pen.strokeStyle = colour;
    pen.lineWidth = colours.line;
    pen.beginPath();
    pen.moveTo(LEFT, y);
    pen.lineTo(at.width, y);
    pen.stroke();
    drawText(pen, colours, name.slice(0, 6), 4, y, { colour, bold: true });
  }
  thinned.torn = tear(at);
  pen.strokeStyle = colours.accent; /* now */
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(x(now), 0);
  pen.lineTo(x(now), at.height - colours.text * 1.1);
  pen.stroke();

  if (at.labels) {
    const y = at.height - colours.text * 0.5;
    const step = span > 1.5 ? 0.5 : span > 0.6 ? 0.2 : 0.1;
    for (let back = step; back < span - step / 3; back += step) {
      drawText(pen, colours, `−${Math.round(back * 1000)} ms`, x(now - back), y, { align: 'center', colour: colours.faint });
    }
    drawText(pen, colours, t('netgame.now'), at.width - 2, y, { align: 'right', colour: colours.accent });
    for (const { p, y: line } of lines) {
      const lag = frame.views[1 + p]?.lag_ms ?? 0;
      drawText(pen, colours, `${fixed(lag, 0)} ms`, LEFT + 4, (line + middle) / 2, { colour: paintOf(colours, p).text });
    }
  }
  drawShown(pen, colours);
  return { ...thinned, text };
}

/** The input nearest to a point; null when there is none. @param {Lanes} at @param {number} px @param {number} py
 * @returns {number | null} */
export function nearestInput(at, px, py) {
  const { x, top, middle, bottom } = places(at);
  const player = py < middle ? at.shown[0] : at.shown[1];
  const own = py < middle ? top : bottom;
  let best = null,
    least = 24;
  for (const message of messages(at, INPUT, player)) {
    const end = message.fate === 0 ? message.end_s : message.begin_s + lagOf(at, player);
    const part = (py - own) / (middle - own);
    const distance = Math.abs(x(message.begin_s + part * (end - message.begin_s)) - px);
    if (distance < least) {
      least = distance;
      best = message.id;
    }
  }
  return best;
}

/** The next or former input in the window, for the keyboard. @param {Lanes} at @param {number} step @returns {number | null} */
export function inputNextTo(at, step) {
  const picked = at.selected === null ? undefined : at.memory.events.get(at.selected);
  const list = messages(at, INPUT, picked?.player ?? at.shown[0]);
  const k = thinning(list.length);
  const shown = list.filter((message) => message.index % k === 0 || message.id === at.selected);
  const place = shown.findIndex((message) => message.id === at.selected);
  const next = shown[place < 0 ? shown.length - 1 : Math.max(0, Math.min(shown.length - 1, place + step))];
  return next?.id ?? null;
}
