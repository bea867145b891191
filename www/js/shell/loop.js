// The drawing: at the display refresh after a frame came, it is drawn and acknowledged. While none comes the page asks for no refresh,
// which costs the browser time although nothing changes.
import { PLAYING } from '../stream/frame.js';
import { lab } from '../session/labs.js';
import { reread } from '../session/params.js';
import { counts, drawn, takeNewest, whenFrame } from '../session/session.js';
import { frame } from '../session/state.js';
import { beginFrame, endFrame, redraw, textTurn, touch } from '../draw/redraw.js';
import { showTime } from './bar.js';
import { showReplay } from './header.js';

const LABEL_MS = 2000; /* names of the drawings are updated at this rate */

const labels = textTurn(LABEL_MS);
const clock = textTurn(100);

let asked = false;
/** Script time of the last drawings, ms. */
export const costs = /** @type {number[]} */ ([]);

function draw() {
  asked = false;
  const next = takeNewest();
  const now = next ?? frame.value;
  if (now === null || (next === null && !redraw.wanted)) return;
  const from = performance.now();
  redraw.wanted = false;
  redraw.opening = next !== null && counts.drawn === 0;
  beginFrame(from);
  if (next) frame.value = next;
  const settled = (now.flags & PLAYING) === 0 || counts.drawn < 3;
  const name = labels(settled);
  lab.value?.draw?.(now, settled, name);
  if (clock(settled)) showTime(now);
  showReplay(now);
  if (next) {
    if (redraw.opening) performance.mark('laglab-first-frame');
    drawn(next.seq);
    reread(next.session.params_version);
  }
  if (redraw.opening) {
    redraw.opening = false;
    touch();
  }
  endFrame();
  costs.push(performance.now() - from);
  if (costs.length > 600) costs.splice(0, 300);
}

function ask() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(draw);
}

export function listen() {
  redraw.wake = ask;
  whenFrame(ask);
  addEventListener('resize', touch);
  new ResizeObserver(touch).observe(document.documentElement);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', touch);
  ask();
}
