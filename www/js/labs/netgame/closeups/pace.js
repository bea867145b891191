// Half a second of worlds that wait for each other's inputs: blocks are steps, hatched bars are waits, a line is the way of a key.
import { place } from '../../../draw/shown.js';
import { drawMark, drawText, widthOf } from '../../../draw/marks.js';
import { paintOf } from '../../../draw/palette.js';
import { fixed, letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { INPUT, RELAY, STALL } from '../core/frame.js';

/** @typedef {import('../core/memory.js').Memory} Memory */
/** @typedef {import('../core/memory.js').Met} Met */
/** delay: ticks, from a key to the step that it counts for; before: the pace of another run, and what that was
 * @typedef {{pen: CanvasRenderingContext2D, width: number, height: number, colours: import('../../../draw/palette.js').Palette,
 *   frame: import('../core/frame.js').Frame, memory: Memory, player: number, warmup: number, delay: number,
 *   before: {rate: number, text: string} | null}} Drawing */
/** s; bits: of the players whose inputs were waited for @typedef {{from: number, to: number, bits: number, open: boolean}} Wait */
/** A key from the player that was waited for to the one that waited. @typedef {{input: Met, relay: Met}} Way */

const SPAN_S = 0.5,
  AHEAD_S = 0.03,
  TICK_S = 1 / 60; /* a block */
const EPS = 1e-4;

/** Of inputs of a number the first: others repeat it. @param {Met[]} all @returns {Met[]} */
const firsts = (all) => all.filter((one, i) => one.number !== all[i - 1]?.number);

/** @param {Drawing} at @param {number} p @returns {number[]} s, when its world stepped */
const stepsOf = (at, p) => firsts(at.memory.of(INPUT, p)).map((one) => one.begin_s);

/** Those that are in the drawing. @param {Drawing} at @param {number} p @returns {Wait[]} the newest last */
function waitsOf(at, p) {
  const { frame, memory } = at;
  const list = memory.of(STALL, p).map(({ end_s: to, value, number: bits }) => ({ from: to - value / 1000, to, bits, open: false }));
  const peer = frame.peers[p],
    last = stepsOf(at, p).at(-1);
  if (peer?.waiting && last !== undefined && frame.time_s > last + TICK_S)
    list.push({ from: last + TICK_S, to: frame.time_s, bits: peer.waiting, open: true });
  return list.filter(({ to }) => to > frame.time_s + AHEAD_S + 0.1 - SPAN_S);
}

/** Whom a wait was for: of several the farthest. @param {Drawing} at @param {number} bits */
function cause({ frame }, bits) {
  const lag = (/** @type {number} */ p) => frame.views[1 + p]?.lag_ms ?? 0;
  const all = frame.peers.map(({ player }) => player).filter((p) => bits & (1 << p));
  return all.sort((a, b) => lag(b) - lag(a))[0] ?? -1;
}

/** The key that ended a wait, or will. @param {Drawing} at @param {Wait} wait @param {number} player who waits @returns {Way | null} */
function wayOf(at, wait, player) {
  const who = cause(at, wait.bits),
    all = firsts(at.memory.of(RELAY, player)).filter((one) => one.end_s <= wait.to + EPS || wait.open),
    relay = all.at(-1),
    input = relay && firsts(at.memory.of(INPUT, who)).find(({ number }) => number === relay.number);
  return relay && input && relay.end_s > wait.from - EPS ? { input, relay } : null;
}

/** Lines of text below the rows: with another pace and the sum, with one of them, and bare, where there is no room. */
const BARE = 2.2,
  FEET = [9, 5.8, BARE],
  LEAST = 2; /* lines, of a row */

/** @param {Drawing} at */
function places(at) {
  const { colours, width, height, frame } = at,
    rows = frame.views.length - 1,
    left = width < 600 ? colours.text * 4 : colours.text * 9,
    top = colours.text * 1.7,
    feet = at.before ? FEET : FEET.slice(1),
    rest = (/** @type {number} */ lines) => (height - top - colours.text * (lines + 1.6)) / (rows + 0.8),
    lines = feet.find((one) => rest(one) >= colours.text * LEAST) ?? BARE,
    foot = colours.text * lines,
    high = rest(lines);
  const start = frame.time_s + AHEAD_S - SPAN_S,
    scale = (width - left - 18) / SPAN_S;
  /* the last player below the server, the others above it */
  const level = (/** @type {number} */ p) => top + high * (p === rows - 1 ? p + 1.3 : p + 0.5);
  return {
    start,
    left,
    high,
    level,
    server: top + high * (rows - 1 + 0.4),
    axis: height - foot - colours.text * 0.6,
    foot: height - foot,
    ghosts: at.before !== null && lines !== BARE,
    sums: lines === feet[0],
    right: left + SPAN_S * scale,
    x: (/** @type {number} */ time) => left + (time - start) * scale,
    thick: Math.min(34, high * 0.5),
  };
}

/** @typedef {ReturnType<typeof places>} Places */

/** Hatched: it waits. @param {Drawing} at @param {number} x0 @param {number} x1 @param {number} y @param {number} high
 * @param {string} colour @param {string} [fill] */
function hatch({ pen }, x0, x1, y, high, colour, fill = '') {
  pen.save();
  pen.beginPath();
  pen.rect(x0, y - high / 2, x1 - x0, high);
  if (fill !== '') {
    pen.fillStyle = fill;
    pen.fill();
  }
  pen.strokeStyle = colour;
  pen.setLineDash([]);
  pen.lineWidth = fill === '' ? 1 : 2.5;
  pen.stroke();
  pen.clip();
  pen.lineWidth = 2;
  pen.beginPath();
  for (let x = Math.floor((x0 - high) / 8) * 8; x < x1; x += 8) {
    pen.moveTo(x, y + high / 2);
    pen.lineTo(x + high, y - high / 2);
  }
  pen.stroke();
  pen.restore();
}

/** @param {Drawing} at @param {Places} where @param {number} time @param {number} y @param {string} fill @param {number} high */
function block({ pen, colours }, { x, left, right }, time, y, fill, high) {
  const from = Math.max(left, x(time)),
    to = Math.min(right, x(time + TICK_S));
  if (to - from < 2) return;
  pen.fillStyle = fill;
  pen.strokeStyle = colours.truth;
  pen.lineWidth = colours.line;
  pen.setLineDash([]);
  pen.beginPath();
  pen.roundRect(from, y - high / 2, to - from, high, 3);
  pen.fill();
  pen.stroke();
}

/** @param {Drawing} at @param {Places} where */
function axes(at, where) {
  const { pen, colours, frame, width } = at,
    { left, right, axis, server } = where;
  for (let ms = 0; ms <= SPAN_S * 1000; ms += 100) {
    const x = left + ((right - left) * ms) / (SPAN_S * 1000);
    pen.fillStyle = colours.grid;
    pen.fillRect(Math.round(x), colours.text * 1.4, 1, axis - colours.text * 2);
    drawText(pen, colours, ms === 0 ? `${ms} ms` : String(ms), x, axis, { size: colours.axis, colour: colours.faint, align: 'center' });
  }
  pen.fillStyle = colours.truth;
  pen.fillRect(left, server - 2, right - left, 4);
  const name = (/** @type {string} */ text, /** @type {string} */ more, /** @type {number} */ y, /** @type {number} */ x) => {
    drawText(pen, colours, text, x, more === '' ? y : y - colours.text * 0.6, { bold: true });
    if (more !== '') drawText(pen, colours, more, x, y + colours.text * 0.7, { size: colours.axis, colour: colours.faint });
  };
  const wide = width >= 600;
  frame.views.slice(1).forEach((view, p) => {
    const y = where.level(p);
    if (wide) drawMark(pen, colours, p, 16, y, 16);
    name(letter(p), `${fixed(view.lag_ms, 0)} ms`, y, wide ? 32 : 4);
  });
  name(t('netgame.server'), '', server, wide ? 32 : 4);
}

/** @param {Drawing} at @param {Places} where @param {Wait | undefined} marked the one that the sentence is about */
function rows(at, where, marked) {
  const { pen, colours, frame, width } = at,
    { x, left, right, level, thick } = where;
  for (let p = 0; p < frame.views.length - 1; p++) {
    const y = level(p);
    for (const wait of waitsOf(at, p)) {
      const from = Math.max(left, x(wait.from)),
        to = Math.min(right, x(wait.to)),
        mine = marked !== undefined && p === at.player && wait.to === marked.to;
      if (to - from < 2) continue;
      const ms = fixed((wait.to - wait.from) * 1000, 0);
      hatch(at, from, to, y, thick * 0.75, mine ? colours.markLine : colours.edge, mine ? colours.mark : '');
      const text = t(mine && width >= 600 ? 'netgame_more.pace.waits' : 'netgame_more.pace.wait', { name: letter(p), ms });
      if (widthOf(pen, colours, text, mine) < to - from - 6)
        drawText(pen, mine ? { ...colours, paper: colours.mark } : colours, text, (from + to) / 2, y, {
          align: 'center',
          bold: true,
          colour: mine ? colours.markText : colours.ink,
        });
      if (!mine) continue;
      place(pen.canvas, 'wait_from', x(wait.from), y, wait.from * 1000);
      place(pen.canvas, 'wait_to', x(wait.to), y, wait.to * 1000);
    }
    for (const time of stepsOf(at, p)) block(at, where, time, y, paintOf(colours, p).fill, thick);
  }
}

/** @param {CanvasRenderingContext2D} pen @param {number} x @param {number} y @param {number} angle */
function envelope(pen, x, y, angle, colours = { paper: '', truth: '' }) {
  pen.save();
  pen.translate(x, y);
  pen.rotate(angle);
  pen.fillStyle = colours.paper;
  pen.strokeStyle = colours.truth;
  pen.lineWidth = 1.5;
  pen.setLineDash([]);
  pen.beginPath();
  pen.rect(-14, -9, 28, 18);
  pen.fill();
  pen.moveTo(-14, -9);
  pen.lineTo(0, 2);
  pen.lineTo(14, -9);
  pen.stroke();
  pen.restore();
}

/** @param {Drawing} at @param {Places} where @param {Way} way @param {number} from who sends @param {boolean} marked */
function key(at, where, { input, relay }, from, marked) {
  const { pen, colours, frame } = at,
    { x, level, server, thick, left, right } = where;
  const below = level(from) > server,
    start = { x: x(input.begin_s), y: level(from) + (below ? -thick / 2 : thick / 2) },
    met = { x: x(input.end_s), y: server },
    goal = { x: x(relay.end_s), y: level(at.player) + thick / 2 },
    off = { x: x(relay.begin_s), y: server };
  pen.save();
  pen.beginPath();
  pen.rect(left, 0, right - left, at.height);
  pen.clip();
  pen.globalAlpha = marked ? 1 : 0.35;
  pen.strokeStyle = colours.accent;
  pen.lineWidth = marked ? colours.line + 3 : 1.5;
  pen.setLineDash([]);
  pen.beginPath();
  pen.moveTo(start.x, start.y);
  pen.lineTo(met.x, met.y);
  pen.moveTo(off.x, off.y);
  pen.lineTo(goal.x, goal.y);
  pen.stroke();
  if (marked) {
    pen.fillStyle = colours.markLine;
    pen.fillRect(met.x, server - 4, Math.max(2, off.x - met.x), 8);
    pen.fillStyle = colours.accent;
    pen.beginPath();
    pen.arc(goal.x, goal.y, 5, 0, 2 * Math.PI);
    pen.fill();
    const up = Math.min(1, (frame.time_s - input.begin_s) / Math.max(EPS, input.end_s - input.begin_s)),
      part = frame.time_s >= relay.end_s ? 0.45 : up; /* where it has come it lies on its way, to be seen */
    envelope(
      pen,
      start.x + part * (met.x - start.x),
      start.y + part * (met.y - start.y),
      Math.atan2(met.y - start.y, met.x - start.x),
      colours,
    );
  }
  pen.restore();
  if (!marked) return;
  const ms = (/** @type {Met} */ one) => fixed((one.end_s - one.begin_s) * 1000, 0);
  const upText = t('netgame_more.pace.up', { name: letter(from), ms: ms(input) }),
    downText = t('netgame_more.pace.down', { ms: ms(relay) });
  const fit = (/** @type {number} */ wish, /** @type {string} */ text) =>
    Math.max(left + 2, Math.min(wish, right - widthOf(pen, colours, text, true)));
  const style = { bold: true, colour: colours.accent };
  const middle = (start.y + server) / 2;
  drawText(pen, colours, upText, fit((start.x + met.x) / 2 + 24, upText), middle + colours.text * 1.2, style);
  const ends = { x: (off.x + goal.x) / 2, y: server - where.high * 0.4 };
  const besides = ends.x - 14 - widthOf(pen, colours, downText, true);
  drawText(
    pen,
    colours,
    downText,
    fit(ends.x + 14 + widthOf(pen, colours, downText, true) < right ? ends.x + 14 : besides, downText),
    ends.y,
    style,
  );
}

/** From one block to the next. @param {Drawing} at @param {Places} where @param {Wait} marked */
function period(at, where, marked) {
  const { pen, colours } = at,
    { x, level, thick } = where,
    y = level(at.player) - thick / 2 - 8,
    begins = stepsOf(at, at.player)
      .filter((time) => time < marked.from + EPS)
      .at(-1);
  if (begins === undefined || marked.open) return;
  const from = x(begins),
    to = x(marked.to);
  pen.strokeStyle = colours.ink;
  pen.lineWidth = 1.5;
  pen.setLineDash([]);
  pen.beginPath();
  pen.moveTo(from, y + 5);
  pen.lineTo(from, y - 3);
  pen.moveTo(from, y);
  pen.lineTo(to, y);
  pen.moveTo(to, y + 5);
  pen.lineTo(to, y - 3);
  pen.stroke();
  drawText(
    pen,
    colours,
    t('netgame_more.pace.step', { ms: fixed((marked.to - begins) * 1000, 0) }),
    Math.min(to, where.right),
    y - colours.text * 0.8,
    {
      align: 'right',
      bold: true,
    },
  );
}

/** A key, and when it shows: at the end of the step that it counts for. @param {Drawing} at @param {Places} where */
function felt(at, where) {
  const { pen, colours, player, delay } = at,
    { x, level, thick } = where,
    made = stepsOf(at, player).at(-1 - delay),
    counts = stepsOf(at, player).at(-1);
  if (made === undefined || counts === undefined) return;
  const from = x(made),
    to = x(counts + TICK_S),
    y = level(player);
  pen.fillStyle = colours.mark;
  pen.fillRect(from, y - thick, to - from, 2 * thick);
  pen.strokeStyle = colours.markLine;
  pen.lineWidth = 2.5;
  pen.setLineDash([]);
  pen.beginPath();
  for (const end of [from, to]) {
    pen.moveTo(end, y - thick);
    pen.lineTo(end, y + thick);
  }
  pen.moveTo(from, y - thick + 5);
  pen.lineTo(to, y - thick + 5);
  pen.stroke();
  drawText(pen, colours, feltWords(at), to, y - thick - colours.text * 0.8, { align: 'right', bold: true, colour: colours.markText });
  place(pen.canvas, 'key', from, y, made * 1000);
  place(pen.canvas, 'shown', to, y, (counts + TICK_S) * 1000);
}

/** @param {Drawing} at */
function feltWords(at) {
  const steps = stepsOf(at, at.player),
    ms = ((steps.at(-1) ?? 0) + TICK_S - (steps.at(-1 - at.delay) ?? 0)) * 1000;
  return t('netgame_more.pace.felt', { name: letter(at.player), ms: fixed(ms, 0) });
}

/** The pace of another run, on the same axis. @param {Drawing} at @param {Places} where @param {number} y */
function ghost(at, where, y) {
  const { pen, colours, before, width } = at,
    { left, right, start, thick } = where;
  if (before === null) return;
  pen.fillStyle = colours.grid;
  pen.globalAlpha = 0.6;
  pen.fillRect(0, y - colours.text * 1.7, width, colours.text * 3.4);
  pen.globalAlpha = 1;
  const wide = width >= 600,
    row = wide ? y : y + colours.text * 0.7,
    period = 1 / before.rate,
    last = stepsOf(at, at.player).at(-1) ?? start;
  const rate = t('netgame_more.pace.rate', { n: fixed(before.rate, before.rate % 1 === 0 ? 0 : 2) });
  pen.globalAlpha = 0.5;
  if (period > TICK_S * 1.2) hatch(at, left, right, row, thick * 0.5, colours.edge);
  for (let k = Math.ceil((start - TICK_S - last) / period); last + k * period < start + SPAN_S; k++)
    block(at, where, last + k * period, row, paintOf(colours, at.player).fill, thick * 0.75);
  pen.globalAlpha = 1;
  drawText(
    pen,
    colours,
    wide ? rate : `${rate} · ${before.text}`,
    wide ? 6 : left,
    wide ? y - colours.text * 0.6 : y - colours.text * 1.2,
    { bold: true, colour: colours.faint },
  );
  if (wide) drawText(pen, colours, before.text, 6, y + colours.text * 0.7, { size: colours.axis, colour: colours.faint });
}

/** Of the time that is counted so far, what it has waited. @param {Drawing} at @param {number} y */
function sum(at, y) {
  const { pen, colours, frame, player, width, warmup } = at;
  const waited = frame.peers[player]?.stalled_s ?? 0,
    counted = frame.time_s - warmup,
    shown = counted > 0.05;
  drawText(
    pen,
    colours,
    shown
      ? t('netgame_more.pace.sum', { name: letter(player), s: fixed(waited, 1), of: fixed(counted, 1), from: fixed(warmup, 0) })
      : t('netgame_more.pace.later', { from: fixed(warmup, 0) }),
    6,
    y - colours.text * 1.5,
    { bold: shown, colour: shown ? colours.ink : colours.faint },
  );
  if (!shown) return;
  const left = 6,
    right = width - 6,
    high = colours.text * 1.7,
    part = Math.max(0, Math.min(1, 1 - waited / counted)),
    middle = left + (right - left) * part;
  pen.fillStyle = paintOf(colours, player).fill;
  pen.fillRect(left, y - high / 2, middle - left, high);
  if (right - middle > 2) hatch(at, middle, right, y, high, colours.edge);
  pen.strokeStyle = colours.truth;
  pen.lineWidth = colours.line;
  pen.setLineDash([]);
  pen.strokeRect(left, y - high / 2, right - left, high);
  const text = t('netgame_more.pace.waited', { s: fixed(waited, 1) });
  if (right - middle > widthOf(pen, colours, text, true) + 10)
    drawText(pen, colours, text, (middle + right) / 2, y, { align: 'center', bold: true });
}

/** @param {Drawing} at */
export function drawPace(at) {
  const { colours, frame, height, player } = at;
  if (frame.views.length < 2) return;
  const where = places(at);
  axes(at, where);
  const marked = waitsOf(at, player).at(-1);
  if (!marked && at.delay > 0) felt(at, where);
  rows(at, where, marked);
  if (stepsOf(at, player).length === 0)
    drawText(at.pen, colours, t('netgame_more.pace.empty'), (where.left + where.right) / 2, where.level(player), {
      align: 'center',
      colour: colours.faint,
    });
  const who = marked ? cause(at, marked.bits) : -1;
  const sender = who >= 0 ? who : frame.views.length - 2;
  for (const relay of firsts(at.memory.of(RELAY, player))) {
    const input = firsts(at.memory.of(INPUT, sender)).find(({ number }) => number === relay.number);
    if (input && relay.end_s > where.start) key(at, where, { input, relay }, sender, false);
  }
  const way = marked ? wayOf(at, marked, player) : null;
  if (marked && way) key(at, where, way, sender, true);
  if (marked) period(at, where, marked);
  if (where.ghosts) ghost(at, where, where.foot + colours.text * 2);
  if (where.sums) sum(at, height - colours.text * 1.4);
}

/** The same in words. @param {Drawing} at @returns {string} */
export function paceWords(at) {
  const marked = waitsOf(at, at.player).at(-1);
  return marked
    ? t('netgame_more.pace.waits', { name: letter(at.player), ms: fixed((marked.to - marked.from) * 1000, 0) })
    : at.delay > 0
      ? feltWords(at)
      : t('netgame_more.pace.none', { name: letter(at.player) });
}
