// When the page is drawn again although no frame came, and how often what is read, not watched, is shown: texts, tables, curves.

export const redraw = { wanted: true };

const BEAT_MS = 100,
  /** What a text costs the browser, its layout above all, is as much as a frame; a slow page has fewer frames to pay it from. */
  BEAT_FRAMES = 6,
  LONGEST_MS = 500;
let beats = 0,
  hurries = 0,
  begun = -Infinity,
  frames = 0;

/** A frame is about to be drawn. @param {number} now ms */
export function beat(now) {
  frames++;
  const since = now - begun;
  if (since < BEAT_MS || (frames < BEAT_FRAMES && since < LONGEST_MS)) return;
  beats++;
  begun = now;
  frames = 0;
}

/** For what is read, not watched: whether it is shown in this frame. All such things change in the same frames, so that the browser lays
 * the page out once. @param {number} ms about; a slow page has fewer such frames, but then the next one shows it
 * @returns {(settled: boolean) => boolean} */
export function paced(ms) {
  let last = -1,
    hurried = -1,
    shown = -Infinity;
  return (settled) => {
    if (!settled && hurries === hurried && (beats === last || begun - shown < ms - BEAT_MS / 2)) return false;
    last = beats;
    hurried = hurries;
    shown = begun;
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
}
