// When the page is drawn again although no frame came, and how often what is read, not watched, is shown: texts, tables, curves.

/** wake: has the page drawn at the next display refresh; the loop sets it. opening: the first frame is drawn, with nothing but what is
 * watched; the rest follows in the next. */
export const redraw = { wanted: true, opening: false, wake: () => {} };

const BEAT_MS = 100,
  /** What a text costs the browser, its layout above all, is as much as a frame; a slow page has fewer frames to pay it from. */
  BEAT_FRAMES = 6,
  LONGEST_MS = 500;
let beats = 0,
  hurries = 0,
  begun = -Infinity,
  frames = 0;

const SCRIPT_MS = 4 /* of a frame, which the browser paints for about as long: a third of a slow machine's frame is left to it */,
  IDLE_MS = 0.5,
  APART = 3; /* frames */
let from = 0 /* of this frame, ms */,
  taken = false /* whether a panel has had its turn in it */,
  count = 0 /* of frames */,
  behind = false /* whether something has not been shown as it is now */,
  later = 0; /* a timer */
/** Of the panels without a turn in a frame, the one that has waited longest: the next turn is its.
 * @type {{shown: number} | null} */
let waiting = null,
  /** @type {{shown: number} | null} */
  next = null;

/** A frame is about to be drawn. @param {number} now ms */
export function beat(now) {
  from = now;
  taken = false;
  next = waiting;
  waiting = null;
  count++;
  frames++;
  const since = now - begun;
  if (since < BEAT_MS || (frames < BEAT_FRAMES && since < LONGEST_MS)) return;
  beats++;
  begun = now;
  frames = 0;
}

/** A frame has been drawn. If none follows, what is behind is shown without one: the connection may be lost. */
export function rest() {
  clearTimeout(later);
  if (behind) later = setTimeout(hurry, LONGEST_MS);
  behind = false;
}

/** For what is read, not watched: whether it is shown in this frame. All such things change in the same frames, so that the browser lays
 * the page out once. @param {number} ms about; a slow page has fewer such frames, but then the next one shows it
 * @returns {(settled: boolean) => boolean} */
export function paced(ms) {
  let last = -1,
    hurried = -1,
    shown = -Infinity;
  return (settled) => {
    if (redraw.opening) return false;
    if (!settled && hurries === hurried && (beats === last || begun - shown < ms - BEAT_MS / 2)) {
      behind = true;
      return false;
    }
    last = beats;
    hurried = hurries;
    shown = begun;
    return true;
  };
}

/** A panel next to what is watched. It is drawn in each frame in which the script has time left for it, as fast machines have; else only
 * when it has waited long, and then one such panel a frame, that which has waited longest, and each in one of three frames, so that what is
 * watched keeps its rate.
 * @param {number} least ms between two drawings @param {number} most ms that it waits where there is no time
 * @returns {(settled: boolean, draw: () => void) => boolean} whether it was drawn */
export function panel(least, most) {
  const turn = { shown: -Infinity };
  let cost = 0,
    hurried = -1,
    last = -Infinity;
  /** Whether it is drawn in a frame without time for it. @param {number} since */
  function hasTurn(since) {
    if (since < most || count - last < APART) return false;
    if (!taken && (next === null || next === turn)) return true;
    if (waiting === null || turn.shown < waiting.shown) waiting = turn;
    return false;
  }
  /** @param {number} now */
  function isDue(now) {
    const since = now - turn.shown;
    if (since < least) return false;
    if (now - from <= IDLE_MS || now - from + cost <= SCRIPT_MS) return true;
    if (!hasTurn(since)) return false;
    taken = true;
    return true;
  }
  return (settled, draw) => {
    if (redraw.opening) return false;
    const now = performance.now();
    if (!settled && hurries === hurried && !isDue(now)) {
      behind = true;
      return false;
    }
    draw();
    cost = performance.now() - now;
    hurried = hurries;
    turn.shown = now;
    last = count;
    return true;
  };
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
