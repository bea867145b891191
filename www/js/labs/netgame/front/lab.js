// The first page: a race that one drives, above the questions. It shows a session like a lab, which rests while no person drives.
import { html } from '../../../../vendor/lit-html.js';
import { effect, untracked } from '../../../../vendor/signals-core.js';
import { fixed } from '../../../base/format.js';
import { language, t } from '../../../base/words.js';
import { shows } from '../../../draw/shown.js';
import { PLAYING } from '../../../stream/frame.js';
import { frame, lesson, status } from '../../../session/state.js';
import { control } from '../../../session/time.js';
import { door } from '../../../lessons/lessons.js';
import { entitiesOf } from '../core/frame.js';
import { meter, modeOf, read } from './felt.js';
import * as opponent from './opponent.js';
import { changes, driven, keyDown, keyUp, letGo } from './pedals.js';
import { age, line, measured, race, settings } from './race.js';
import { cameraOf, drawScene, forget, remember } from './scene.js';

/** @typedef {import('../../../stream/frame.js').Frame} Frame */

const REST_S = 20; /* without a key, at rest: then it pauses */
const MEAN_S = 0.5; /* that the age of the other car is the mean of */
const NARROW_PX = 560;

const meters = { of: meter(), width: 1000, age: 0, time: 0 };

/** @param {boolean} fresh */
function begin(fresh) {
  if (!fresh) return;
  Object.assign(meters, { of: meter(), age: 0, time: 0 });
  measured.value = { felt: {}, last: null };
  Object.assign(driven, { at: 0, resting: false });
  changes.length = 0;
  opponent.forget();
  forget();
}

/** @param {Frame} now */
function take(now) {
  remember(now);
  const sums = now.measures[0],
    view = now.views[1];
  if (sums && read(meters.of, sums, settings(), changes, now.time_s)) measured.value = { felt: meters.of.reading, last: meters.of.last };
  if (!view) return;
  const span = now.time_s - meters.time;
  meters.age += (view.view_age_ms / 1000 - meters.age) * (span > 0 && span < 1 ? 1 - Math.exp(-span / MEAN_S) : 1);
  meters.time = now.time_s;
  if (Math.abs(meters.age - age.peek()) >= 0.01) age.value = Math.round(meters.age * 100) / 100;
  opponent.drive(now);
  rest(now);
}

/** A race without a driver costs nothing. @param {Frame} now */
function rest(now) {
  const still = entitiesOf(now, 0).every(({ vx }) => Math.abs(vx) < 0.3);
  if (driven.resting || (now.flags & PLAYING) === 0 || !still || now.time_s < driven.at + REST_S) return;
  driven.resting = true;
  control({ op: 'pause' });
}

const SEEN_PX = 40; /* a gap that is smaller has no number yet: it would not be seen */

/** What the line is about, as it is drawn: the own car and where it truly is; at last the other. @param {Frame} now
 * @param {import('./scene.js').Camera} camera */
function point(now, camera) {
  const { key } = line(),
    other = key.startsWith('stays') ? 1 : 0,
    drawn = entitiesOf(now, 1)[other],
    truth = entitiesOf(now, 0)[other];
  const gap = drawn && truth ? truth.x - drawn.x : 0,
    px = (gap * meters.width) / camera.wide,
    m = fixed(gap, 1);
  const narrow = meters.width < NARROW_PX ? '.short' : '';
  const label = other === 1 ? t('front.gap.age', { m, s: fixed(age.value, 2) }) : t(`front.gap.behind${narrow}`, { m });
  const seen = px >= SEEN_PX && (other === 1 || modeOf(settings()) !== 'both');
  if (!seen) shows.value = null;
  else if (shows.peek()?.label !== label || shows.peek()?.from !== `nose_${other}`)
    shows.value = { view: 'player_0', from: `nose_${other}`, to: `true_nose_${other}`, along: 'x', label };
}

/** @param {Frame} now */
function draw(now) {
  const canvases = /** @type {NodeListOf<HTMLCanvasElement>} */ (document.querySelectorAll('.drive canvas'));
  const camera = cameraOf(now, meters.width, settings().lag, modeOf(settings()) === 'both');
  point(now, camera);
  for (const canvas of canvases) drawScene(canvas, now, camera, (width) => (meters.width = width));
}

let here = false;
effect(() => {
  const left = here && lesson.value?.id !== '';
  here = lesson.value?.id === '';
  if (!left) return;
  untracked(() => {
    if (shows.value?.from.startsWith('nose_')) shows.value = null; /* else it is the lesson's already */
    letGo();
  });
});
document.addEventListener('visibilitychange', () => {
  if (!document.hidden || lesson.value?.id !== '' || frame.value === null || status.value !== 'playing') return;
  letGo();
  control({ op: 'pause' });
});

/** @type {import('../../../session/lab.js').Lab} */
export const lab = {
  template: () => html`<main class="door" id="views" tabindex="-1" lang=${language.value}>${race()}${door()}</main>`,
  begin,
  take,
  draw,
  rates: () => ({ gauges: 20, lanes: 0, shots: 0 }),
  press: keyDown,
  release: keyUp,
  facts: () => ({
    felt: { get: () => structuredClone(measured.value) },
    line: { get: line },
  }),
};
