// The session of the page: joined, created, copied or created again; and its stream.
import { batch, effect } from '../../vendor/signals-core.js';
import { Problem, call, make } from '../base/api.js';
import { create, keep, link } from './opening.js';
import { FAILED } from '../labs/netgame/core/frame.js';
import { Memory } from '../labs/netgame/core/memory.js';
import { Stream } from '../stream/connection.js';
import { seen, showAddress } from './params.js';
import {
  connection,
  contactsDrawn,
  divisor,
  experiment,
  failure,
  frame,
  layout,
  inspector,
  locked,
  overlays,
  params,
  scenarios,
  session,
  notify,
} from './state.js';

/** @typedef {import('./state.js').Layout} Layout */

/** Counted for tests and for the curious: see window.laglab. */
export const counts = { received: 0, drawn: 0, acked: 0, hellos: 0 };

/** @type {Stream | null} */
let stream = null;
export let memory = new Memory('race', 0);
/** The newest received frame, not yet drawn. @type {import('../labs/netgame/core/frame.js').Frame | null} */
let newest = null;

/** @param {any} hello @returns {Layout} */
function layoutOf(hello) {
  const given = hello.layout ?? {};
  const players = given.players ?? hello.params?.players ?? [];
  const scene = given.scene ?? {};
  return {
    game: given.game ?? hello.params?.game ?? hello.params?.kind ?? 'race',
    players: players.map((/** @type {any} */ player, /** @type {number} */ p) => ({ name: player.name || String.fromCharCode(65 + p) })),
    game_values: given.game_values ?? [],
    scene: {
      x_min: 0,
      x_max: 100,
      y_min: 0,
      y_max: 1,
      wraps: false,
      finish_m: 0,
      target_x: 0,
      target_y: 0,
      target_radius: 0,
      entity_length_m: 1,
      ...scene,
    },
    entities: given.entities ?? [],
    fixed: given.fixed ?? [],
    notices: given.notices ?? [],
    motion: given.problem ? given : null,
    rigid: given.rigid ?? null,
    fluid: given.fluid ?? null,
  };
}

/** What is worth a closer look from the start. @param {string} game @param {string} sync @returns {string} */
function inspectorOf(game, sync) {
  if (game === 'shooter') return 'shots';
  return sync === 'deterministic' || sync === 'rollback' ? 'waits' : 'messages';
}

/** What is subscribed to, Hz by channel: those of other kinds there are none of. @param {string} chosen the inspector @returns {Record<string, number>} */
function wishOf(chosen) {
  const closer = chosen === 'buffers' || chosen === 'waits';
  return {
    session: 60,
    scene: 60,
    lanes: 60,
    gauges: closer ? 60 : 10,
    shots: chosen === 'shots' ? 60 : 5,
    ...(chosen === 'buffers' ? { buffered: 60 } : {}),
    motion: 60,
    bodies: 60,
    ...(contactsDrawn.value ? { contacts: 60 } : {}),
    joints: 60,
    field: 60,
    points: 60,
  };
}
effect(() => {
  const wish = wishOf(inspector.value);
  stream?.subscribe(wish);
});

/** Leaves the lab for the Experiments view. @param {string} id of the experiment; empty for none */
export function openExperiments(id) {
  stream?.close();
  stream = null;
  session.value = null;
  experiment.value = id;
  document.title = 'Experiments – laglab';
  showAddress();
}

/** Shows a session from now on. @param {string} id @param {string} key @param {boolean} own @param {import('./opening.js').Line} [line] its stream,
 * when it is open */
export function show(id, key, own, line) {
  stream?.close();
  newest = null;
  batch(() => {
    experiment.value = null;
    session.value = { id, key, own };
    connection.value = { state: 'connecting', attempt: 0 };
    frame.value = null;
    failure.value = '';
  });
  seen.version = -1;
  let wasLost = false;
  stream = new Stream(
    id,
    key,
    {
      hello(hello) {
        counts.hellos++;
        divisor.value = 1;
        const next = layoutOf(hello);
        memory = new Memory(next.game, -1);
        batch(() => {
          layout.value = next;
          if (hello.params) params.value = hello.params;
          if (frame.value === null) inspector.value = inspectorOf(next.game, hello.params?.server?.sync);
          if (counts.hellos === 1 || frame.value === null) {
            overlays.value = { ...overlays.value, dots: next.game === 'cannon' };
          }
        });
        document.title = `${hello.params?.title || next.game} – laglab`;
      },
      frame(next) {
        counts.received++;
        if (next.session.generation !== memory.generation) memory = new Memory(memory.game, next.session.generation);
        memory.take(next);
        newest = next;
        if (next.flags & FAILED && failure.value === '') why(id);
      },
      state(state, attempt) {
        connection.value = { state, attempt };
        if (state === 'open' && wasLost) notify('Reconnected');
        wasLost = state === 'lost';
      },
      pace(next) {
        divisor.value = next;
      },
      gone() {
        notify('Session expired – created again from the address');
        again();
      },
      refused(detail) {
        notify(`Refused: ${detail}`);
      },
    },
    line,
    wishOf(inspector.value),
  );
  showAddress();
}

/** @param {string} id */
async function why(id) {
  failure.value = 'The simulation stopped';
  try {
    const now = await call('GET', `sessions/${id}`);
    failure.value = String(now.error?.detail ?? now.error?.title ?? failure.value);
  } catch {
    /* the plain sentence stays */
  }
}

/** The next frame to draw: the newest, once. */
export function takeNewest() {
  const next = newest;
  newest = null;
  return next;
}

/** Reports to the daemon which frame was drawn. @param {number} seq */
export function drawn(seq) {
  counts.drawn++;
  counts.acked = seq;
  stream?.send({ ack: seq });
}

/** @param {unknown} message */
export function send(message) {
  stream?.send(message);
}

/** A new session from the address, after the former one was lost or another scenario was chosen. */
export async function again() {
  try {
    link.session = '';
    link.problems = [];
    const made = await create();
    show(made.id, made.key, true);
    if (link.problems.length > 0) notify(link.problems.join('. '), true);
  } catch (error) {
    failed(error);
  }
}

/** A person who has just declined to give the key is not asked again. @param {unknown} error */
export function failed(error) {
  if (error instanceof Problem && error.declined) {
    notify('No session: creating one needs the class key. Reload the page to enter it, or open a shared link.', true);
    return;
  }
  notify(`No session: ${error instanceof Error ? error.message : 'the daemon does not answer'} – retrying`);
  setTimeout(again, 1000 + Math.random() * 1000);
}

/** Another scenario, with nothing changed. @param {string} id */
export async function choose(id) {
  const before = session.value;
  link.scenario = id;
  link.set = {};
  link.seed = null;
  await again();
  if (before?.own && before.key) call('DELETE', `sessions/${before.id}`, { key: before.key }).catch(() => {});
}

/** A copy of the session at this moment, under a key of one's own. */
export async function fork() {
  const now = session.value;
  if (now === null) return;
  try {
    const copy = await make(`sessions/${now.id}/fork`);
    keep(copy.id, copy.owner_key, false);
    show(copy.id, copy.owner_key, false);
    notify('This is now your copy');
  } catch (error) {
    notify(`No copy: ${error instanceof Error ? error.message : 'the daemon does not answer'}`);
  }
}

/** @returns {string} the id of the scenario shown, as far as it is known */
export function shownScenario() {
  const now = session.value;
  if (now?.own) return link.scenario;
  const title = params.value?.title;
  return scenarios.value.find((row) => row.title === title)?.id ?? '';
}

/** Read-only facts for tests and for the curious. */
export function hook() {
  return Object.freeze({
    get frame() {
      return frame.value;
    },
    get session() {
      return session.value && { id: session.value.id, owner: session.value.key !== '' };
    },
    get params() {
      return structuredClone(params.value);
    },
    get connection() {
      return { ...connection.value };
    },
    get locked() {
      return locked.value;
    },
    get counts() {
      return { ...counts, patches: seen.patches };
    },
    get gaps() {
      return structuredClone(memory.gaps);
    },
    get messages() {
      return [...memory.events.values()];
    },
    get corrections() {
      return memory.corrections.map((list) => list.length);
    },
    get dots() {
      return memory.dots.map((list) => list.map((dot) => dot.t));
    },
  });
}
