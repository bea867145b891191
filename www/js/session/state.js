// What the page knows, as signals. Modules read and write these; nothing else is shared.
import { computed, signal } from '../../vendor/signals-core.js';
import { BEHIND, ENDED, FAILED, PLAYING } from '../labs/netgame/core/frame.js';
import { link } from './opening.js';

/** @typedef {import('../labs/netgame/core/frame.js').Frame} Frame */
/** @typedef {{x_min: number, x_max: number, y_min: number, y_max: number, wraps: boolean, finish_m: number,
 *   target_x: number, target_y: number, target_radius: number, entity_length_m: number}} Scene */
/** @typedef {{problem: string, help: string, mechanical: boolean, energy: boolean, components: string[],
 *   methods: {method: string, order: number, adaptive: boolean}[]}} MotionLayout */
/** @typedef {{scene: string, title: string, help: string, worlds: number, hz: number, view: number[], solvers: {name: string, help: string}[]}} RigidLayout
 *   view: left, right, bottom, top in m */
/** @typedef {{name: string, help: string, shape: 'field' | 'points', columns: string[]}} FluidLayer */
/** @typedef {{scene: string, title: string, help: string, source: string, method: string, hz: number, layers: FluidLayer[], view: number[],
 *   numbers: string[], notices?: string[], side_by_side?: FluidLayout[]}} FluidLayout  view: as of rigid bodies */
/** @typedef {{kind: string, width_m: number, height_m: number, round: boolean}} Shape */
/** @typedef {{game: string, players: {name: string}[], game_values: string[], scene: Scene, entities: Shape[],
 *   fixed: (Shape & {x: number, y: number})[], notices: string[], motion: MotionLayout | null, rigid: RigidLayout | null, fluid: FluidLayout | null}} Layout
 *   entities: how each is drawn, none in a game that has a drawing of its own; motion, rigid, fluid: of a scenario of that kind, which has no players */
/** @typedef {{id: string, key: string, own: boolean}} Session  key is empty for a reader; own: made from the query */
/** @typedef {{id: string, title: string, paper: string, kind: string}} ScenarioRow */
/** @typedef {'connecting' | 'open' | 'lost'} LinkState */
/** @typedef {'all' | 'charts' | 'messages' | `view${number}`} Tab */

/** @type {import('@preact/signals-core').Signal<Session | null>} */
export const session = signal(null);
/** The whole scenario with its present values. @type {import('@preact/signals-core').Signal<any>} */
export const params = signal(null);
/** @type {import('@preact/signals-core').Signal<Layout | null>} */
export const layout = signal(null);
/** As the daemon gives it, by kind: of those that were asked for. @type {import('@preact/signals-core').Signal<Map<string, any>>} */
export const schemas = signal(new Map());

/** The schema of a scenario's kind, with the parameters of its game, problem or scene.
 * @param {any} all @param {any} scenario @returns {any} null until it is there */
export function schemaOf(all, scenario) {
  const kind = all?.oneOf[0];
  if (!kind) return null;
  const own = (/** @type {string} */ name, /** @type {string} */ row) =>
    all.$defs[name] ? { ...kind.properties[row], anyOf: undefined, $ref: `#/$defs/${name}` } : kind.properties[row];
  const scene = (/** @type {string} */ name) => ({ params: own(name, 'params'), solver: own(`${name}_solver`, 'solver') });
  const beside = (/** @type {any} */ one) => ({ properties: { ...all.$defs.fluid_side_by_side.properties, ...scene(one.scene) } });
  const varied =
    scenario.kind === 'fluid'
      ? {
          ...scene(scenario.scene),
          side_by_side: { ...kind.properties.side_by_side, prefixItems: (scenario.side_by_side ?? []).map(beside) },
        }
      : { params: own(scenario.game ?? scenario.problem, 'params') };
  return { ...kind, properties: { ...kind.properties, ...varied }, $defs: all.$defs };
}
/** Of the session's scenario. */
export const schema = computed(() => (params.value ? schemaOf(schemas.value.get(params.value.kind), params.value) : null));
/** @type {import('@preact/signals-core').Signal<ScenarioRow[]>} */
export const scenarios = signal([]);
/** @type {import('@preact/signals-core').Signal<{state: LinkState, attempt: number}>} */
export const connection = signal({ state: 'connecting', attempt: 0 });
export const FRAME_HZ = 60; /* requested rate of frames */
/** By which the daemon divides that, since frames are not drawn in time. */
export const divisor = signal(1);
/** Whether the points where bodies touch are drawn: they are most of what bodies are streamed with. */
export const contactsDrawn = signal(true);
/** The newest drawn frame. @type {import('@preact/signals-core').Signal<Frame | null>} */
export const frame = signal(null);
/** Why the session stopped by itself. */
export const failure = signal('');
/** What a person must read now; empty when there is nothing. */
export const notice = signal('');
/** The experiment that the Experiments view shows: empty for none; null while a lab is shown. @type {import('@preact/signals-core').Signal<string | null>} */
export const experiment = signal(link.experiment);
/** A scenario of which speed against error is wanted there; null: none. @type {import('@preact/signals-core').Signal<any>} */
export const workPrecisionOf = signal(null);
export const theme = signal(link.theme);
/** @type {import('@preact/signals-core').Signal<Tab>} of a phone */
export const tab = signal('all');
/** @type {import('@preact/signals-core').Signal<'px' | 'm' | 'ms'>} */
export const unit = signal('px');

/** Players above and below the server's line among the messages. @type {import('@preact/signals-core').Signal<[number, number]>} */
export const lanes = signal([0, 1]);

/** Content of the lower panel: `messages`, or the id of an inspector. */
export const inspector = signal('messages');

/** The inspectors that can be chosen, once they are loaded. @type {import('@preact/signals-core').Signal<import('../labs/netgame/inspectors/inspectors.js').Inspector[]>} */
export const inspectors = signal([]);

/** Ids of those that have something to show, joined: it changes seldom, though it is read with every frame. */
export const offered = computed(() => {
  const now = frame.value;
  return now === null
    ? ''
    : inspectors.value
        .filter((one) => one.fits(now, params.value))
        .map((one) => one.id)
        .join(' ');
});

/** @typedef {{kind: 'help'} | {kind: 'player', player: number} | {kind: 'server'} | {kind: 'share'} | {kind: 'table', which: 'error' | 'buffer'}} Dialog */
/** The dialog that is open. @type {import('@preact/signals-core').Signal<Dialog | null>} */
export const dialog = signal(null);

/** @param {Dialog} next */
export function open(next) {
  dialog.value = next;
}

export const scale = { pxPerMetre: 1 }; /* of the views, kept by the drawing loop */

/** What became of connections in this stretch of time, oldest first. @type {import('@preact/signals-core').Signal<import('../labs/netgame/core/memory.js').Happening[]>} */
export const connectionEvents = signal([]);

/** What is drawn over the views. */
export const overlays = signal({ ghosts: true, dots: false, labels: true, messages: true, pings: false });

/** Kept in the browser, not in the address: a person's habit. */
export const singleKeys = signal(readSingleKeys());

function readSingleKeys() {
  try {
    return localStorage.getItem('laglab.keys') !== 'off';
  } catch {
    return true;
  }
}

/** @param {boolean} on */
export function setSingleKeys(on) {
  singleKeys.value = on;
  try {
    localStorage.setItem('laglab.keys', on ? 'on' : 'off');
  } catch {
    /* the choice then lasts as long as the page */
  }
}

/** @typedef {'waiting' | 'playing' | 'paused' | 'ended' | 'failed'} Status */

export const status = computed(() => {
  /** @type {Status} */
  let now = 'waiting';
  const flags = frame.value?.flags;
  if (flags !== undefined) {
    now = flags & FAILED ? 'failed' : flags & ENDED ? 'ended' : flags & PLAYING ? 'playing' : 'paused';
  }
  return now;
});
export const behind = computed(() => frame.value !== null && (frame.value.flags & BEHIND) !== 0);
/** To seven digits, as the stream has it: 0.1, not its nearest float. */
export const speed = computed(() => Number((frame.value?.session?.speed ?? 1).toPrecision(7)));
export const readOnly = computed(() => session.value !== null && session.value.key === '');

/** Why nothing can be changed now; empty when it can. */
export const locked = computed(() => {
  if (session.value === null) return 'No session yet';
  if (connection.value.state === 'lost') return 'Connection lost: controls are off until it is back';
  return readOnly.value ? 'Read-only: only the owner of this session can change it' : '';
});

const NOTICE_MS = 15000;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let fading;

/** Shows a message, and announces it. News disappears by itself; a rejected change stays until it is closed.
 * @param {string} text @param {boolean} [stays] */
export function notify(text, stays = false) {
  clearTimeout(fading);
  notice.value = text;
  if (!stays)
    fading = setTimeout(() => {
      notice.value = '';
    }, NOTICE_MS);
}
