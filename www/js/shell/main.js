// Wires the page together.
import { effect } from '../../vendor/signals-core.js';
import { constant, insist, part } from '../base/api.js';
import { readExperiment, readLesson, readTradeoff, writeQuery } from '../base/link.js';
import { ready, t } from '../base/words.js';
import * as announce from '../session/announce.js';
import { bring } from '../labs/netgame/lab/about.js';
import { lab as netgame } from '../labs/netgame/lab/lab.js';
import { load, register } from '../session/labs.js';
import { link, problems } from '../session/opening.js';
import { readScenarios } from '../session/scenario_words.js';
import { choose, failed, hook, openExperiments, openLesson, openTradeoff, reopen, show, showFirst } from '../session/session.js';
import { experiment, frame, layout, lesson, locked, notify, params, place, schemas, session, tradeoff } from '../session/state.js';
import { palette } from '../draw/palette.js';
import * as controls from '../workbench/controls.js';
import { shown } from '../draw/shown.js';
import { slowing } from '../session/time.js';
import { begun, likely } from './early.js';
import * as keys from './keys.js';
import { FRONT, LABS } from './labs.js';
import { lessons } from './lessons.js';
import * as loop from './loop.js';
import * as page from './page.js';

/* Read-only, for tests and for the curious: frame, params, connection, counts, messages. */
Object.defineProperty(window, 'laglab', { value: Object.assign(() => hook(), { costs: loop.costs, palette, shown }) });

bring(netgame);
register(LABS, likely);

/** The lab follows a session from its first frame. @param {NonNullable<typeof begun>} from */
async function showBegun({ opened, line }) {
  if (lesson.value?.id === '') {
    await load(FRONT);
    return showFirst(opened, line);
  }
  const made = await opened;
  const [open] = await Promise.all([line, load(likely)]);
  show(made.id, made.key, made.own, open);
  await ready;
  const notes = [made.note === '' ? '' : t(made.note), problems()].filter((text) => text !== '');
  if (notes.length > 0) notify(notes.join('. '), link.problems.length > 0);
}
if (begun) showBegun(begun).catch(failed);
else if (lesson.value !== null && link.problems.length > 0) ready.then(() => notify(problems(), true));

const WAIT_MS = 400,
  FIRST_MS = 150 /* the first frames have the machine and the line to themselves */,
  IDLE_MS = 500;
/** The page is laid out once, not twice, when the session's layout arrives soon. */
const laidOut = () =>
  new Promise((done) => {
    setTimeout(done, WAIT_MS);
    effect(() => {
      if (layout.value !== null) done(null);
    });
  });

/** With reduced motion the session waits: Play is what comes next. */
function awaitPlay() {
  const stop = effect(() => {
    if (locked.value !== '' || lesson.value !== null) return;
    queueMicrotask(() => {
      document.getElementById('play')?.focus();
      stop();
    });
  });
}

/** Not by awaiting in the module itself, which the files of other parts import. */
async function begin() {
  await ready; /* asked for before anything else */
  if (begun) await laidOut();
  if (link.room !== null) part(() => import('../class/room.js')).then((room) => room.enter(link.room ?? '', link.roomKey));
  page.listen();
  controls.listen();
  keys.listen();
  announce.listen();
  const slowed = effect(() => {
    if (session.value === null || !slowing()) return;
    queueMicrotask(() => slowed());
    part(() => import('./slow.js')).then((slow) => slow.listen());
  });
  loop.listen();
  if (matchMedia('(prefers-reduced-motion: reduce)').matches) awaitPlay(); /* once there is a page */
  const waiting = effect(() => {
    /* a request before the first frame delays that frame */
    if (frame.value === null && experiment.value === null && (lesson.value?.id !== '' || lessons.value === null)) return;
    queueMicrotask(() => waiting());
    setTimeout(readSchemas);
    setTimeout(() => (globalThis.requestIdleCallback ?? setTimeout)(readMore, { timeout: IDLE_MS }), FIRST_MS);
  });
  addEventListener('hashchange', moved);
  addEventListener('popstate', back);
}
begin();

/** @type {Set<string>} */
const asked = new Set();
/** What the controls are made from. */
function readSchemas() {
  effect(() => {
    const kind = params.value?.kind;
    if (!kind || asked.has(kind) || lesson.value?.id === '') return;
    asked.add(kind);
    insist(() => constant(`schema?kind=${kind}&brief=true`)).then((answer) => {
      if (!schemas.value.has(kind)) schemas.value = new Map(schemas.value).set(kind, answer); // the whole one may be there by now
    });
  });
}
function readMore() {
  part(() => import('./later.js'));
  effect(() => {
    if (lesson.value?.id !== '') readScenarios(); /* the first page reads it when it is asked for */
  });
}
/** A place among the lessons that Back, a link or a typed address wants. @returns {boolean} whether it is one */
function follow() {
  const wanted = readLesson(location.search, location.hash),
    now = lesson.value;
  if (wanted === null) return false;
  if (place.value.at !== '') location.reload(); /* Back from a class */
  if (now === null || wanted.id !== now.id || wanted.step !== now.step || (wanted.lang || now.lang) !== now.lang)
    openLesson({ ...wanted, lang: wanted.lang || (now?.lang ?? '') });
  return true;
}
/** The same of a family of methods. @returns {boolean} */
function followTradeoff() {
  const at = readTradeoff(location.hash);
  if (at !== null && at !== tradeoff.value) openTradeoff(at);
  return at !== null;
}
function moved() {
  if (follow() || followTradeoff()) return;
  /* Back from a point that was opened, or an address that was typed */
  const wanted = readExperiment(location.hash),
    tab = LABS.flatMap(({ tabs }) => tabs).find(({ id }) => `#${id}` === location.hash);
  if (wanted !== null) openExperiments(wanted);
  else if (tab) choose(tab.scenario, undefined, false);
  else if (location.hash.startsWith('#class') && location.hash !== place.value.at) location.reload();
  else if (location.hash.startsWith('#s=') && !location.hash.startsWith(`#s=${session.value?.id}`)) location.reload();
}
function back() {
  if (follow() || followTradeoff()) return;
  if ((experiment.value !== null || lesson.value !== null) && readExperiment(location.hash) === null) location.reload();
  else if (session.value?.own && location.search.includes('scenario=') && location.search !== writeQuery(link)) reopen();
}
