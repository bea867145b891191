// A run of a lesson tick by tick, as the server and each screen have it: what is drawn of a moment that is over, and the first run next
// to the second. A session of its own is asked for it, and deleted.
import { address, call, make } from '../base/api.js';
import { link } from '../session/opening.js';

/** @typedef {import('../session/state.js').Recorded} Recorded */
/** Of a lesson, what a session is made from.
 * @typedef {{id: string, scenario: string, seed: number, workload?: unknown}} Lesson */

/** @param {string} text CSV of the record entities @returns {Recorded} */
function parsed(text) {
  const [head = '', ...lines] = text.trim().split(/\r?\n/),
    columns = head.split(',');
  const [tick = 0, view = 0, entity = 0, x = 0, y = 0, vx = 0, age = 0] = [
    'session_tick',
    'view',
    'entity',
    'x_m',
    'y_m',
    'vx_m_per_s',
    'age_ms',
  ].map((name) => columns.indexOf(name));
  /** @type {Recorded} */
  const run = new Map();
  for (const line of lines) {
    const cells = line.split(','),
      at = (/** @type {number} */ i) => Number(cells[i]);
    const views = run.get(at(tick)) ?? [];
    run.set(at(tick), views);
    (views[at(view)] ??= [])[at(entity)] = { x: at(x), y: at(y), vx: at(vx), age_ms: at(age), flags: 0 };
  }
  return run;
}

/** @param {Lesson} of @param {Record<string, unknown>} set @param {number} from tick @param {number} to @returns {Promise<Recorded>} */
async function read(of, set, from, to) {
  const { scenario, seed, workload } = of;
  const made = await make('sessions', { scenario, set, seed, paused: true, ...(workload ? { workload } : {}) }),
    key = made.owner_key;
  try {
    await call('POST', `sessions/${made.id}/control`, { body: { op: 'seek', tick: to }, key });
    const { time_s: end } = await call('GET', `sessions/${made.id}`),
      hz = to / end;
    const answer = await fetch(address(`sessions/${made.id}/trace?of=entities&format=csv&from_s=${from / hz}&to_s=${end}`));
    if (!answer.ok) throw new Error(`${link.scenario}: ${answer.status}`);
    return parsed(await answer.text());
  } finally {
    call('DELETE', `sessions/${made.id}`, { key }).catch(() => {});
  }
}

/** @type {Map<string, Promise<Recorded>>} */
const known = new Map();

/** Each run once. @param {Lesson} of @param {Record<string, unknown>} set @param {number} from tick @param {number} to */
export function record(of, set, from, to) {
  const key = JSON.stringify([of.id, set, from, to]);
  const run = known.get(key) ?? read(of, set, from, to);
  known.set(key, run);
  run.catch(() => known.delete(key));
  return run;
}
