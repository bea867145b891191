// What the stream does not carry: what a step costs, and curves that are held against known ones. Asked for once a second.
import { signal } from '../../vendor/signals-core.js';
import { call } from '../api.js';
import { session } from '../state.js';

const PACE_MS = 1000;

/** ms of the daemon's processor per step, and per second of time. @type {import('@preact/signals-core').Signal<{step: number, second: number} | null>} */
export const cost = signal(null);
/** Pairs (coordinate, value) by name; a known curve has the name with `_reference`.
 * @type {import('@preact/signals-core').Signal<Record<string, number[][]> | null>} */
export const profiles = signal(null);

let asked = -Infinity, askedTick = -1;
/** Where cost was last told. @type {{id: string, generation: number, time: number, total: number} | null} */
let last = null;

/** The mean since the last answer: settings change while it runs. @param {any} now @param {string} id */
function takeCost(now, id) {
  const mean = Number(now.cost?.ns_per_sim_s ?? 0), time = Number(now.time_s ?? 0), total = mean * time;
  const since = last && last.id === id && last.generation === now.generation && time > last.time ? (total - last.total) / (time - last.time) : mean;
  if (!last || last.id !== id || last.generation !== now.generation || time > last.time) last = { id, generation: now.generation, time, total };
  if (since > 0) cost.value = { step: since / 1e6 / now.tick_hz, second: since / 1e6 };
}

/** @param {import('../frame.js').Frame} frame */
export async function measure(frame) {
  const id = session.value?.id ?? '', time = performance.now();
  if (id === '' || time - asked < PACE_MS || frame.tick === askedTick) return;
  asked = time;
  askedTick = frame.tick;
  try {
    takeCost(await call('GET', `sessions/${id}`), id);
    if (profiles.value === null || Object.keys(profiles.value).length > 0) {
      const { metrics } = await call('GET', `sessions/${id}/metrics`);
      if (session.value?.id === id) profiles.value = metrics?.profiles ?? {};
    }
  } catch { /* the stream says when the daemon is away */ }
}

/** Another session. */
export function forget() {
  asked = -Infinity;
  askedTick = -1;
  cost.value = null;
  profiles.value = null;
}
