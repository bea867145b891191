// Draws the plot and the runs, and puts what is pressed where it is drawn.
import { t } from '../../base/words.js';
import { paintOf, palette } from '../../draw/palette.js';
import { place as shown } from '../../draw/shown.js';
import { onto } from '../../workbench/canvas.js';
import { runs } from './live.js';
import * as name from './names.js';
import { place } from './place.js';
import { SMALL_PX, TOUCH_PX, drawTradeoff, formOf, frameOf } from './plot.js';
import { drawRun } from './scenes.js';
import { handleWords, methodOf } from './sentence.js';
import { dark, lines, now, selected } from './state.js';

/** @typedef {import('./state.js').Now} Now */

/** As it was drawn last. plot: null until it is; runs: of each side
 * @type {{plot: {at: Now, frame: import('./plot.js').Frame, of: ReturnType<typeof drawTradeoff>} | null,
 *   runs: import('./scenes.js').Seen[]}} */
export const drawn = {
  plot: null,
  runs: [
    { px: 0, factor: 1 },
    { px: 0, factor: 1 },
  ],
};

/** @param {string} id of an element over the plot @param {{x: number, y: number, width: number, height: number}} box */
function put(id, { x, y, width, height }) {
  const element = /** @type {HTMLElement | null} */ (document.querySelector(`.plot ${id}`));
  if (element) Object.assign(element.style, { left: `${x}px`, top: `${y}px`, width: `${width}px`, height: `${height}px` });
}

function drawPlot() {
  const at = now.value;
  if (!at) return;
  onto('tradeoff', (surface) => {
    const colours = palette(),
      frame = frameOf([...at.shown, ...at.former], surface, colours.axis);
    const of = drawTradeoff(surface, colours, frame, {
      points: at.shown,
      former: at.former,
      named: at.named,
      place: (method) => at.order.indexOf(method),
      nameOf: (method) => methodOf(at, method),
      dark: dark.value,
      lines: lines.value,
      words: { budget: handleWords(at, 'budget'), enough: handleWords(at, 'enough') },
      x: surface.width < SMALL_PX ? name.briefCostOf(at.cost) : name.costOf(at.cost),
      y: name.errorOf(at.error),
      winner: at.best,
      ring: t(at.winner ? 'tradeoff.ring' : 'tradeoff.ring_nearest'),
      rival: at.winner ? (at.wants ?? at.triesAt ?? at.ever) : undefined,
      hidden: at.hidden ? t('tradeoff.hides', { still: name.brief(at.hidden.still), of: name.brief(at.hidden.of) }) : '',
      selected: selected.value,
    });
    drawn.plot = { at, frame, of };
    if (of.ring) shown(surface.canvas, 'cheapest', of.ring.x, of.ring.y);
    if (of.rival) shown(surface.canvas, 'rival', of.rival.x, of.rival.y);
    const { handles } = of,
      grown = (/** @type {{x: number, y: number, width: number, height: number}} */ one) => {
        const height = Math.max(TOUCH_PX, one.height),
          width = Math.max(TOUCH_PX, one.width);
        return { x: one.x - width / 2, y: one.y - height / 2, width, height };
      };
    put('.handle[data-handle="budget"]', grown(handles.budget));
    put('.handle[data-handle="enough"]', grown(handles.enough));
    put('.strip[data-handle="budget"]', { x: handles.x - 12, y: frame.top, width: 24, height: frame.bottom - frame.top });
    put('.strip[data-handle="enough"]', { x: frame.left, y: handles.y - 12, width: frame.right - frame.left, height: 24 });
    for (const { method, x, y, width } of of.labels)
      put(`.end[data-method="${method}"]`, { x: x - 6, y: y - 13, width: width + 12, height: 26 });
  });
}

function drawRuns() {
  const at = now.value;
  if (!at) return;
  runs.value.forEach((run, side) => {
    if (!run || run.scenario !== at.error.scenario) return; /* one that is left has yet to go */
    onto(`live-${side}`, (surface) => {
      const colours = palette(),
        { colour } = formOf(at.order.indexOf(run.row.method)),
        paint = paintOf(colours, colour);
      drawn.runs[side] = drawRun(surface, colours, run, {
        fill: paint.fill,
        line: paint.text,
        peer: runs.value[1 - side] ?? null,
        lead: side === 0,
        error: at.error.error,
      });
    });
  });
}

const due = { plot: false, runs: false };
let asked = false;
/** @param {Partial<typeof due>} what */
export function redraw(what) {
  Object.assign(due, what);
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    const { plot: plotDue, runs: runsDue } = due;
    due.plot = due.runs = false;
    if (place.peek() === null) return;
    if (plotDue) drawPlot();
    if (runsDue) drawRuns();
    if (runs.peek().some((run) => run?.history && run.state === 'running')) redraw({ runs: true });
  });
}
