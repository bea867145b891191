// The lab of netgames: what each player sees, what the server knows, and the messages between them.
import { letter } from '../../../base/format.js';
import { valueAt } from '../../../base/schema.js';
import { t } from '../../../base/words.js';
import { link } from '../../../session/opening.js';
import { lesson, params } from '../../../session/state.js';
import { inspector } from '../core/inspector.js';
import { layout } from '../core/layout.js';
import { forget, memory, overlays, take } from '../core/state.js';
import { draw, listen } from './drawing.js';
import { KEYS, press, release } from './keys.js';
import * as page from './page.js';
import { compare, compared, end } from './side.js';

/** What is worth a closer look from the start. @param {import('../core/layout.js').Layout} of */
function inspectorOf(of) {
  const sync = params.value?.server?.sync;
  if (params.value?.paper === 'Figure 12') return 'inputs'; /* its buffer */
  return of.inspector === 'messages' && ['deterministic', 'rollback'].includes(sync) ? 'waits' : of.inspector;
}

let first = true;

/** @param {boolean} fresh */
function begin(fresh) {
  const now = layout.value;
  if (now === null) return;
  const flights = now.controls === 'aim';
  forget(flights);
  if (fresh) inspector.value = inspectorOf(now);
  if (fresh || first) overlays.value = { ...overlays.value, dots: flights };
  first = false;
  if (link.second !== '' && lesson.value === null) compare();
}

function rates() {
  const chosen = inspector.value,
    closer = chosen === 'buffers' || chosen === 'waits';
  return {
    gauges: closer ? 60 : 10,
    shots: chosen === 'shots' ? 60 : 5,
    buffered: chosen === 'buffers' ? 60 : 0,
    traffic: chosen === 'traffic' ? 10 : 0,
  };
}

/** @param {any} now @param {any} before @param {Record<string, unknown>} asked @returns {string[]} */
function followed(now, before, asked) {
  return now.players.flatMap((/** @type {any} */ player, /** @type {number} */ p) =>
    ['prediction', 'reconciliation'].flatMap((name) => {
      const path = `players.${p}.${name}`;
      if (path in asked || valueAt(before, path) === player[name]) return [];
      return [t(player[name] ? 'netgame.turned_on' : 'netgame.turned_off', { name: t(`netgame.${name}`), player: letter(p) })];
    }),
  );
}

/** @returns {PropertyDescriptorMap} */
const facts = () => ({
  curves: { get: () => structuredClone(memory.curves) },
  gaps: { get: () => structuredClone(memory.gaps) },
  messages: { get: () => [...memory.events.values()] },
  corrections: { get: () => memory.corrections.map((list) => list.length) },
  compare: { get: () => compared()?.facts() ?? null },
  dots: { get: () => memory.dots.map((list) => list.map((dot) => dot.t)) },
});

listen();

/** What can be done, by how a game is driven. */
const HINTS = { pedals: 'pedals', plane: 'plane', aim: 'aim' };

/** @type {import('../../../session/lab.js').Lab} */
export const lab = {
  template: () => (compared() ?? page).template(),
  begin,
  take(frame) {
    take(frame);
    compared()?.take(frame);
  },
  draw(frame, settled, name) {
    const both = compared();
    if (both) both.draw(settled);
    else draw(frame, settled, name);
  },
  rates,
  followed,
  facts,
  end,
  hint: () => (compared() === null && layout.value !== null ? HINTS[layout.value.controls] : ''),
  keys: KEYS,
  press: (event) => compared() === null && press(event),
  release,
  later: () => import('./later.js').then(({ rest }) => rest()),
};
