// When the page is drawn again although no frame came, and in which frames what is next to the views is shown: texts, and panels such as
// charts and messages. The views are drawn in each frame. A text or a panel waits some time for its turn, and some frames, so that what
// is watched keeps its rate on a slow machine too. All texts have one turn: the browser lays the page out once. A frame gives one turn,
// to that which has waited longest; panels need none where the script has time left.

/** wake: has the page drawn at the next display refresh; the loop sets it. opening: the first frame is drawn, with nothing but what is
 * watched; the rest follows in the next. */
export const redraw = { wanted: true, opening: false, wake: () => {} };

const SCRIPT_MS = 4 /* of a frame, which the browser paints for about as long: a third of a slow machine's frame is left to it */,
  IDLE_MS = 0.5;
const TEXTS_MS = 100,
  TEXTS_APART = 6 /* frames: what a text costs the browser, its layout above all, is as much as a frame */,
  PANELS_APART = 3,
  LONGEST_MS = 500; /* after which the frames between do not count */

/** What has turns: when it was shown last, in ms and frames. @typedef {{ms: number, frame: number}} Turn */

let from = 0 /* of this frame, ms */,
  count = 0 /* of frames */,
  taken = false /* whether its turn has been given */,
  hurries = 0,
  behind = false /* whether something has not been shown as it is now */,
  later = 0; /* a timer */
/** Without a turn in this frame, the one that has waited longest: it has that of the next. @type {Turn | null} */
let waiting = null,
  /** @type {Turn | null} */
  next = null;
/** @type {Turn} */
const texts = { ms: -Infinity, frame: -Infinity };

/** Whether it has waited long enough, and this frame's turn is its. @param {Turn} turn @param {number} ms @param {number} apart frames */
function takesTurn(turn, ms, apart) {
  const since = from - turn.ms;
  if (since < ms || (count - turn.frame < apart && since < LONGEST_MS)) return false;
  if (taken || (next !== null && next !== turn)) {
    if (waiting === null || turn.ms < waiting.ms) waiting = turn;
    return false;
  }
  taken = true;
  return true;
}

/** A frame is about to be drawn. @param {number} now ms */
export function beginFrame(now) {
  from = now;
  count++;
  taken = false;
  next = waiting;
  waiting = null;
  if (takesTurn(texts, TEXTS_MS, TEXTS_APART)) Object.assign(texts, { ms: from, frame: count });
}

/** A frame has been drawn. If none follows, what is behind is shown without one: the connection may be lost. */
export function endFrame() {
  clearTimeout(later);
  if (behind) later = setTimeout(hurry, LONGEST_MS);
  behind = false;
}

/** @param {(turn: Turn) => boolean} isDue asked in a frame that need not show it
 * @returns {(settled: boolean, draw?: () => void) => boolean} settled: no frame follows soon; whether it is shown in this frame */
function inTurns(isDue) {
  const turn = { ms: -Infinity, frame: -Infinity };
  let hurried = -1;
  return (settled, draw) => {
    if (redraw.opening) return false;
    if (!settled && hurries === hurried && !isDue(turn)) {
      behind = true;
      return false;
    }
    draw?.();
    hurried = hurries;
    Object.assign(turn, { ms: from, frame: count });
    return true;
  };
}

/** A text. @param {number} ms about, between two times it is shown; a slow page has fewer frames that show texts, but then the next does */
export const textTurn = (ms) => inTurns((turn) => texts.frame === count && from - turn.ms >= ms - TEXTS_MS / 2);

/** A panel. @param {number} least ms between two drawings @param {number} most ms that it waits where there is no time
 * @returns {(settled: boolean, draw: () => void) => boolean} */
export function panelTurn(least, most) {
  let cost = 0;
  const shown = inTurns((turn) => {
    const spent = performance.now() - from;
    return from - turn.ms >= least && (spent <= IDLE_MS || spent + cost <= SCRIPT_MS || takesTurn(turn, most, PANELS_APART));
  });
  return (settled, draw) =>
    shown(settled, () => {
      const start = performance.now();
      draw();
      cost = performance.now() - start;
    });
}

/** All of it is shown in the next frame. */
export function hurry() {
  hurries++;
  touch();
}

/** Draw again. */
export function touch() {
  redraw.wanted = true;
  redraw.wake();
}
