// Data outside of the stream, requested once a second: the cost of steps, and profiles that are compared with known ones.
import { signal } from '../../vendor/signals-core.js';
import { call } from '../base/api.js';
import { session } from '../session/state.js';

/** @typedef {Record<string, number>} Part  ms of the daemon's processor per step by phase; `all`: of the whole step */

const PACE_MS = 1000;

/** Of each world or fluid side by side. @type {import('@preact/signals-core').Signal<Part[]>} */
export const costs = signal([]);
/** Of each: pairs (coordinate, value) by name; a known curve has the name with `_reference`.
 * @type {import('@preact/signals-core').Signal<Record<string, number[][]>[] | null>} */
export const profiles = signal(null);

let asked = -Infinity,
  askedTick = -1;
/** The last answer: total ns. @type {{id: string, metered: number, parts: Part[]}} */
let last = { id: '', metered: 0, parts: [] };

/** The mean since the last answer: settings change while it runs. @param {any} now @param {string} id */
function takeCosts(now, id) {
  const metered = Number(now.cost?.metered_s ?? 0),
    { parts = [] } = now.cost ?? {};
  const totals = parts.map((/** @type {any} */ part) =>
    Object.fromEntries(Object.entries(part).map(([name, { ns_per_sim_s: ns }]) => [name, ns * metered])),
  );
  const from = last.id === id && metered > last.metered ? last : { metered: 0, parts: [] },
    steps = (metered - from.metered) * now.tick_hz;
  if (last.id === id && metered === last.metered) return;
  last = { id, metered, parts: totals };
  costs.value = totals.map((/** @type {Part} */ part, /** @type {number} */ i) =>
    /* a total that has not grown can differ by rounding */
    Object.fromEntries(Object.entries(part).map(([name, ns]) => [name, Math.max(0, (ns - (from.parts[i]?.[name] ?? 0)) / steps / 1e6)])),
  );
}

/** @param {import('../stream/frame.js').Frame} frame @param {boolean} curves whether there may be some */
export async function measure(frame, curves) {
  const id = session.value?.id ?? '',
    time = performance.now();
  if (id === '' || time - asked < PACE_MS || frame.tick === askedTick) return;
  asked = time;
  askedTick = frame.tick;
  try {
    const now = await call('GET', `sessions/${id}`);
    if (session.value?.id !== id) return;
    takeCosts(now, id);
    if (curves && (profiles.value === null || profiles.value.some((one) => Object.keys(one).length > 0))) {
      const { metrics } = await call('GET', `sessions/${id}/metrics`);
      if (session.value?.id === id) profiles.value = [metrics, ...(metrics.side_by_side ?? [])].map((one) => one.profiles ?? {});
    }
  } catch {
    /* the stream says when the daemon is away */
  }
}

/** Another session. */
export function forget() {
  asked = -Infinity;
  askedTick = -1;
  costs.value = [];
  profiles.value = null;
}
