// Whether the page has to be drawn again although no frame came.

export const redraw = { wanted: true };

/** For what is read, not watched: whether `ms` have passed since it was last shown, or nothing follows soon. @param {number} ms
 * @returns {(settled: boolean) => boolean} */
export function paced(ms) {
  let last = -Infinity;
  return (settled) => {
    const now = performance.now();
    if (!settled && now - last < ms) return false;
    last = now;
    return true;
  };
}

/** Draw again. */
export function touch() {
  redraw.wanted = true;
}
