// Whether the page has to be drawn again although no frame came.

export const redraw = { wanted: true };

/** Draw again. */
export function touch() {
  redraw.wanted = true;
}
