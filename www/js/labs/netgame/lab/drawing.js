// Draws the views, the messages or the inspector, and the side column; a person can point at what is drawn.
import { render } from '../../../../vendor/lit-html.js';
import { fixed, letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { PLAYING } from '../../../stream/frame.js';
import { speak } from '../../../session/announce.js';
import { bars, camera, frame, look, mayDrive, params, place, presented, staged } from '../../../session/state.js';
import { drawBars } from '../../../draw/bars.js';
import { drawText } from '../../../draw/marks.js';
import { palette } from '../../../draw/palette.js';
import { drawShown } from '../../../draw/shown.js';
import { panelTurn, textTurn, touch } from '../../../draw/redraw.js';
import { surfaceOf } from '../../../workbench/canvas.js';
import { since } from '../../../workbench/since.js';
import { INTERPOLATION, STALLED, entitiesOf } from '../core/frame.js';
import { inspector, inspectors } from '../core/inspector.js';
import { layout } from '../core/layout.js';
import { Memory } from '../core/memory.js';
import { connectionEvents, lanes, memory, overlays, scale, unit } from '../core/state.js';
import { drawCannon, toY as cannonY } from '../views/cannon.js';
import { connectionWords, drawConnection } from '../views/connection.js';
import { drawField, drawStandings, toY as fieldY } from '../views/field.js';
import { drawGauge } from '../views/gauge.js';
import { inputNextTo, drawLanes, nearestInput, windowOf } from '../views/lanes.js';
import { drawRace, onLap, toY as roadY } from '../views/race.js';
import { drawRibbon } from '../views/ribbon.js';
import { scaleX, toX } from '../views/scene.js';
import { flagAt } from '../views/staged.js';
import { mainSentence, tell } from '../views/sentences.js';
import { followed, framed } from '../views/camera.js';
import { drive } from './drive.js';
import { follow, pick, view as packetView } from './follow.js';
import { closeup } from './closeup.js';
import { happened, showSide } from './side.js';

/** @typedef {import('../../../draw/surface.js').Surface} Surface */
/** @typedef {import('../core/frame.js').Frame} Frame */
/** @typedef {import('../views/scene.js').DrawContext} DrawContext */

const FINGER_PX = 22; /* around what is tapped */

/** @type {number | null} */
let selected = null;
/** The dots of each view as drawn last, and the one that is asked about. @type {import('../views/scene.js').Drawn[][]} */
const drawnDots = [];
/** @type {import('../views/scene.js').Picked | null} */
let picked = null;
/** What a lesson highlights of the strip below a view; it has none else. */
const STRIPS = new Set(['inputs', 'buffer']);
/** How each view was drawn last. @type {DrawContext[]} */
const drawnAs = [];
/** What a view shows, in words. @param {Frame} now @param {number} view @returns {string} */
function words(now, view) {
  const v = now.views[view];
  if (!v) return '';
  const shapes = layout.value?.entities ?? [],
    players = layout.value?.players.length ?? 0;
  const where = (/** @type {import('../core/frame.js').Entity} */ e) =>
    shapes.length > 0 ? `${fixed(e.x, 1)}, ${fixed(e.y, 1)} m` : `${fixed(e.x, 1)} m`;
  const things = entitiesOf(now, view).length - players,
    others = things > 0 ? t('netgame.view.things', { n: things }) : '';
  const list =
    entitiesOf(now, view)
      .slice(0, players)
      .map((e, i) => t('netgame.view.at', { name: letter(i), place: where(e) }))
      .join(', ') + others;
  const error = view > 0 ? t('netgame.view.error', { lead: fixed(v.own_lead_m, 2), age: fixed(v.view_age_ms, 0) }) : '';
  const away = view > 0 ? connectionWords(v) : '';
  const state = away === '' ? '' : `${away.charAt(0).toUpperCase()}${away.slice(1)}. `;
  const whose = view === 0 ? t('netgame.view.server') : t('netgame.view.player', { name: letter(view - 1) });
  return `${state}${whose}: ${list}${error}`;
}

/** @param {HTMLCanvasElement} canvas @param {Frame} now @param {boolean} name */
function drawView(canvas, now, name) {
  const view = Number(canvas.dataset.view);
  const surface = surfaceOf(canvas);
  const shape = layout.value;
  if (name) canvas.setAttribute('aria-label', words(now, view));
  if (!shape || entitiesOf(now, view).length === 0 || !surface.begin()) return;
  const colours = palette();
  const shapes = shape.entities.length > 0; /* all views to one scale: the server's has a strip too */
  const plain = presented.value || (camera.value !== null && !STRIPS.has(look.value?.at ?? ''));
  const strip = !plain && (view > 0 || shapes) ? Math.round(colours.text * 1.7) : 0;
  /** @type {DrawContext} */
  const at = {
    pen: surface.pen,
    width: surface.width,
    height: surface.height - strip,
    colours,
    frame: now,
    memory,
    layout: camera.value !== null ? framed(shape, now, camera.value, surface.width) : presented.value ? followed(shape, now) : shape,
    only: camera.value?.only ?? null,
    staged: camera.value === null ? null : staged.value,
    run: staged.value?.now ?? null,
    first: staged.value?.step === 5 ? staged.value.first : null,
    view,
    overlays: place.value.staged ? { ...overlays.value, labels: false } : overlays.value /* a class reads sentences */,
    unit: presented.value && unit.value === 'px' ? 'm' : unit.value /* pixels of a projector mean nothing */,
    picked,
  };
  drawnAs[view] = at;
  drawnDots[view] = shapes ? drawField(at) : shape.controls === 'aim' ? drawCannon(at) : drawRace(at);
  if (shapes || shape.controls === 'aim') drawShown(at.pen, colours);
  scale.pxPerMetre = scaleX(at);
  if (view > 0) drawConnection(at);
  if (strip > 0) {
    surface.pen.fillStyle = colours.grid;
    surface.pen.fillRect(0, at.height, at.width, 1);
  }
  if (view === 0 && shapes && strip > 0) drawStandings(at, at.height + strip / 2);
  if (view > 0 && strip > 0) drawStrip(at, strip);
}

/** Below a player's view. @param {DrawContext} at @param {number} strip its height, px */
function drawStrip(at, strip) {
  const { pen, colours } = at,
    flags = at.frame.views[at.view]?.flags ?? 0;
  const gauge = (flags & INTERPOLATION) !== 0;
  const ribbon = gauge ? at.width * 0.56 : at.width;
  drawRibbon(at, 8, ribbon - 12, at.height + 1, strip - 2);
  if (gauge) drawGauge(at, ribbon + 4, at.width - ribbon - 8, at.height + 1, strip - 2);
  if (flags & STALLED) drawText(pen, colours, t('netgame.waits'), 8, at.height - colours.text * 0.8, { colour: colours.snap, bold: true });
}

/** @param {Surface} surface @param {Frame} now */
function laneOf(surface, now) {
  const players = layout.value?.players ?? [];
  return {
    pen: surface.pen,
    width: surface.width,
    height: surface.height,
    colours: palette(),
    frame: now,
    memory,
    names: players.map((player) => player.name),
    shown: /** @type {[number, number]} */ (lanes.value.map((p) => Math.min(p, players.length - 1))),
    labels: overlays.value.labels,
    pings: overlays.value.pings,
    selected,
  };
}

/** A closer look in place of the messages. @param {Surface} surface @param {Frame} now @param {HTMLCanvasElement} canvas
 * @param {boolean} name
 * @returns {boolean} whether there was one */
function drawInspector(surface, now, canvas, name) {
  const chosen = inspectors.value.find((one) => one.id === inspector.value);
  if (!chosen || !layout.value || !chosen.fits(now, params.value)) return false;
  const at = {
    pen: surface.pen,
    width: surface.width,
    height: surface.height,
    colours: palette(),
    frame: now,
    memory,
    layout: layout.value,
    player: Math.min(lanes.value[0], layout.value.players.length - 1),
  };
  chosen.draw(at);
  const facts = document.getElementById('lane-facts');
  const label = t(`netgame_more.inspector.${chosen.id}`);
  if (facts && facts.textContent !== label) facts.textContent = label;
  if (name) canvas.setAttribute('aria-label', `${label}: ${chosen.words(at)}`);
  return true;
}

/** The messages as drawn last. @type {(ReturnType<typeof drawLanes> & {span: string}) | null} */
let drawnLanes = null;

/** @param {Frame} now @param {boolean} name */
function drawMessages(now, name) {
  drawnLanes = null;
  const canvas = document.getElementById('lane');
  if (!(canvas instanceof HTMLCanvasElement)) return;
  const surface = surfaceOf(canvas);
  if (!surface.begin() || now.views.length < 2) return;
  if (drawInspector(surface, now, canvas, name)) return;
  const span = fixed(windowOf(now), 2);
  drawnLanes = { ...drawLanes(laneOf(surface, now)), span };
  if (name) canvas.setAttribute('aria-label', t('netgame.lane.last', { span, text: drawnLanes.text }));
}

/** Next to the messages. */
function showMessages() {
  const facts = document.getElementById('lane-facts');
  if (!facts || !drawnLanes) return;
  const { inputs, states, torn, text, span } = drawnLanes;
  const caption = (text !== '' ? text : t('netgame.lane.drawn', { span, inputs, states })) + (torn ? t('netgame.lane.torn') : '');
  if (facts.textContent !== caption) facts.textContent = caption;
}

/** @param {Frame} now */
function showFacts(now) {
  const facts = document.getElementById('facts');
  if (!facts) return;
  const caption = t('netgame.watching', { tick: now.tick, n: now.session.viewers });
  if (facts.textContent !== caption) facts.textContent = caption;
}

/** Next to the name of each view: what it shows. @param {Frame} now */
function showMain(now) {
  if (!presented.value) return;
  const views = now.views.slice(1);
  for (const place of document.querySelectorAll('[data-main]')) {
    const view = Number(/** @type {HTMLElement} */ (place).dataset.main),
      row = now.views[view];
    if (!row) continue;
    const one =
      view === 0
        ? {
            before: t('netgame.says.server'),
            value: t('netgame.says.server.updates', { hz: params.value?.server?.update_hz ?? '' }),
            after: '',
          }
        : mainSentence({ view: row, player: view - 1, views }, memory);
    tell(place, one);
  }
}

/** The list of connection events; new ones are announced. @param {Frame} now */
function showConnectionEvents(now) {
  if (connectionEvents.value === memory.connectionEvents) return;
  const newest = memory.connectionEvents.at(-1);
  if (newest && now.flags & PLAYING && !connectionEvents.value.includes(newest)) speak('event', happened(newest));
  connectionEvents.value = memory.connectionEvents;
}

const nothing = new Memory(false, -1);

/** The first run at the same tick, where a lesson has changed something. @param {Frame} now */
function drawFirst(now) {
  const canvas = document.getElementById('first'),
    of = staged.value,
    shape = layout.value,
    once = of?.first?.get(now.tick) ?? (of?.first ? [...of.first.values()].at(now.tick > 0 ? -1 : 0) : undefined);
  if (!(canvas instanceof HTMLCanvasElement) || !of || !shape || once === undefined) return;
  const surface = surfaceOf(canvas);
  if (!surface.begin()) return;
  const kept = /** @type {Frame} */ (
    /** @type {unknown} */ ({
      tick: now.tick,
      time_s: now.time_s,
      views: now.views,
      where: (/** @type {string} */ record, /** @type {string} */ _, /** @type {number} */ view) =>
        record === 'entities' ? (once[view] ?? []) : [],
    })
  );
  drawRace({
    pen: surface.pen,
    width: surface.width,
    height: surface.height,
    colours: palette(),
    frame: kept,
    memory: nothing,
    layout: framed(shape, now, camera.value, surface.width),
    view: 1 + of.player,
    only: camera.value?.only ?? null,
    staged: of,
    run: of.first,
    first: null,
    faded: true,
    overlays: { ghosts: of.press === 0, dots: false, labels: false },
    unit: 'm',
    picked: null,
  });
}

/** Sizes that a lesson compares. */
function drawSizes() {
  const canvas = document.getElementById('bars');
  if (!(canvas instanceof HTMLCanvasElement)) return;
  const surface = surfaceOf(canvas);
  if (surface.begin()) drawBars(surface, palette(), bars.value);
}

/** Time since the key of a lesson. @param {Frame} now */
function showSince(now) {
  const box = document.getElementById('since'),
    of = staged.value;
  if (!box || !of || of.line.length === 0) return;
  const hz = now.time_s > 0 ? now.tick / now.time_s : 60;
  render(since({ parts: of.line, now: Math.round(((now.tick + 1 - of.press) / hz) * 1000), asked: of.step === 1 }), box);
}

const facts = textTurn(100); /* words that change with every frame */
const lower = panelTurn(0, 100),
  packet = panelTurn(0, 100);
/** Of the messages as they are drawn: the views may be newer. @type {Frame | null} */
let laneFrame = null;

/** @param {Frame} now @param {boolean} settled @param {boolean} name */
export function draw(now, settled, name) {
  for (const canvas of document.getElementsByTagName('canvas')) if (canvas.dataset.view !== undefined) drawView(canvas, now, name);
  closeup.value?.draw(now, name);
  const texts = facts(settled);
  lower(settled || name, () => {
    drawMessages(now, name);
    laneFrame = now;
  });
  if (packetView.value) packet(settled, () => packetView.value?.draw(now));
  if (texts) {
    showMessages();
    showFacts(now);
  }
  showMain(now);
  drawFirst(now);
  drawSizes();
  showSince(now);
  showConnectionEvents(now);
  showSide(now, settled);
}

/** @param {number | null} id */
function select(id) {
  selected = id;
  const { player = 0, number = 0 } = memory.events.get(id ?? -1) ?? {};
  pick(player, number);
  touch();
}

/** @param {PointerEvent} event */
function point(event) {
  const canvas = event.target;
  if (!(canvas instanceof HTMLCanvasElement) || canvas.dataset.view === undefined) return;
  const view = Number(canvas.dataset.view);
  let best = null,
    least = 14;
  for (const one of drawnDots[view] ?? []) {
    const distance = Math.hypot(one.x - event.offsetX, one.y - event.offsetY);
    if (distance < least) {
      least = distance;
      best = one;
    }
  }
  if ((best?.dot ?? null) === (picked?.dot ?? null)) return;
  picked = best ? { view, dot: best.dot } : null;
  touch();
}

/** Shift with an arrow key: the dot before or after, in the view that has the focus. @param {KeyboardEvent} event */
function stepDot(event) {
  const view = event.target instanceof HTMLElement ? event.target.querySelector('canvas[data-view]') : null;
  const step = event.code === 'ArrowRight' ? 1 : event.code === 'ArrowLeft' ? -1 : 0;
  if (!(view instanceof HTMLCanvasElement) || !event.shiftKey || step === 0) return;
  const index = Number(view.dataset.view),
    list = drawnDots[index] ?? [];
  const place = list.findIndex(({ dot }) => dot === picked?.dot);
  const next = list[place < 0 ? list.length - 1 : Math.max(0, Math.min(list.length - 1, place + step))];
  if (!next) return;
  event.preventDefault();
  picked = { view: index, dot: next.dot };
  speak('dot', memory.describe(next.dot));
  touch();
}

/** A flag on the road is a choice. @param {MouseEvent} event */
function plant(event) {
  if (!(event.target instanceof HTMLCanvasElement)) return;
  const flag = flagAt(event.target, event.offsetX);
  if (flag >= 0) staged.value?.plant(flag);
}

/** A click or tap on a car, or on a player's mark, takes it. @param {MouseEvent} event */
function take(event) {
  const canvas = event.target,
    at = canvas instanceof HTMLCanvasElement ? drawnAs[Number(canvas.dataset.view ?? NaN)] : undefined;
  if (!at) return;
  const { entities, controls, scene, players } = at.layout,
    shapes = entities.length > 0,
    y = shapes ? fieldY : controls === 'aim' ? cannonY : roadY;
  const reach = shapes ? 0 : (scene.entity_length_m * scaleX(at)) / 2;
  let best = -1,
    least = 1;
  entitiesOf(at.frame, at.view)
    .slice(0, players.length)
    .forEach((e, i) => {
      const shape = entities[i],
        half = shape ? Math.max(shape.width_m, shape.height_m) * scaleX(at) * 0.5 : reach;
      const dx = (event.offsetX - toX(at, shapes ? e.x : onLap(at, e.x))) / Math.max(FINGER_PX, half),
        dy = (event.offsetY - y(at, e.y)) / Math.max(FINGER_PX, shapes ? half : 0);
      if (Math.hypot(dx, dy) < least) {
        least = Math.hypot(dx, dy);
        best = i;
      }
    });
  const { seat } = place.value;
  if (best >= 0 && mayDrive(best) && (seat === null || seat === best)) drive(best, true);
}

export function listen() {
  document.addEventListener('click', take);
  document.addEventListener('click', plant);
  document.addEventListener('pointermove', point);
  document.addEventListener('pointerdown', point);
  document.addEventListener('keydown', stepDot);
  document.addEventListener('click', (event) => {
    const canvas = event.target;
    if (!(canvas instanceof HTMLCanvasElement) || canvas.id !== 'lane' || laneFrame === null) return;
    select(nearestInput(laneOf(surfaceOf(canvas), laneFrame), event.offsetX, event.offsetY));
  });
  document.addEventListener('keydown', (event) => {
    const box = event.target instanceof HTMLElement ? event.target.closest('[data-arrows]') : null;
    const canvas = box?.querySelector('canvas');
    if (canvas?.id !== 'lane' || laneFrame === null) return;
    if (event.code === 'Enter') follow();
    if (event.code === 'Escape') select(null);
    const step = event.code === 'ArrowRight' ? 1 : event.code === 'ArrowLeft' ? -1 : 0;
    if (step === 0) return;
    event.preventDefault();
    select(inputNextTo(laneOf(surfaceOf(canvas), laneFrame), step));
  });
}
