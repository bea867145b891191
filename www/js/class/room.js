// A class on the page: the teacher opens one, a student joins one. Read when it is wanted.
import { effect } from '../../vendor/signals-core.js';
import { html, nothing, render } from '../../vendor/lit-html.js';
import { Problem, call, make, styleSheet } from '../base/api.js';
import { touch } from '../draw/redraw.js';
import { keep as keepKey, keyOf } from '../session/opening.js';
import { showAddress } from '../session/params.js';
import { again, show, showBoard } from '../session/session.js';
import { camera, connection, frame, notify, picked, place, session } from '../session/state.js';
import { patience } from '../stream/connection.js';
import { mostChosen } from './ask.js';
import { joinView, tidy } from './join.js';
import { forgetClass, kept } from './kept.js';
import { lessonOf, lessons, point, readLesson, readLessons } from './lesson.js';
import { Line } from './line.js';
import { begin as attend, isRemoved, plant, take } from './member.js';
import { draw as drawMenu } from './menu.js';
import { phone } from './phone.js';
import { pick, release } from './picture.js';
import { aboveWorkbench, stage as stageView } from './stage.js';
import { keep, stage } from './staged.js';
import { attempt, devices, driving, me, now, out, part, reason, room, say, secret, shows, staged, told } from './state.js';
import { boardOf, begin as lead, prepare, putBoard, questionOf } from './teacher.js';
import { need, t } from '../base/words.js';

const root = document.createElement('div');
root.id = 'class';

/** @type {Line | null} */
let line = null;

/** Which of the views is shown; empty: no class. */
function view() {
  if (part.value === 'teacher') return shows.value === 'stage' ? 'stage' : 'teach';
  if (part.value === 'member' && shows.value !== 'choose') return 'member';
  return place.value.at === '' ? '' : 'join';
}

function template() {
  const name = view();
  if (name === 'stage') return stageView();
  if (name === 'teach') return aboveWorkbench();
  if (name === 'member') return phone();
  return name === 'join' ? joinView(find) : nothing;
}

/** What the style sheet has to know. */
function mark() {
  const { dataset } = document.documentElement,
    name = view(),
    mine = me.value;
  const put = (/** @type {string} */ key, /** @type {string | false} */ value) => {
    if (value === false) delete dataset[key];
    else dataset[key] = value;
  };
  const views = staged.value;
  put('class', name !== '' && name);
  put('phase', views && (now.value?.phase ?? 'lobby'));
  put('seat', name === 'member' && shows.value === 'board' && driving.value && mine?.role === 'play' && String(mine.player));
  put('copy', name === 'member' && shows.value === 'copy' && 'yes');
  touch(); /* other rows may be shown now */
  put('lost', part.value !== '' && (attempt.value > 0 || connection.value.state === 'lost') && 'yes');
}

/** Another tab of this browser has joined: this one is the same member. @param {StorageEvent} event */
function follow({ key }) {
  const at = room.peek();
  if (key === 'laglab.members' && at !== null && part.peek() === '' && !out.peek()) resume(at.id, '').catch(() => {});
}

/** Who drives, or watches who does, sees the cars and not the whole track. */
const CLOSE = { m: 45, narrow_m: 24 };

let begun = false;
async function begin() {
  if (begun) return;
  begun = true;
  await Promise.all([need('class'), need('lesson'), styleSheet('class')]);
  document.body.prepend(root);
  addEventListener('storage', follow);
  new ResizeObserver(touch).observe(root); /* what stands below has another height then */
  effect(() => {
    render(html`${template()}`, root);
  });
  effect(mark);
  effect(() => drawMenu(root));
  effect(() => {
    const views = staged.value,
      { lesson = '', phase = '' } = now.value ?? {},
      of = part.value === '' ? null : lessonOf(lesson);
    place.value = { ...place.peek(), staged: views };
    point(views ? of : null, phase);
    stage(views ? of : null, phase, part.value === 'teacher', part.value === 'teacher' ? mostChosen() : (me.value?.choice ?? -1), plant);
    if (views && driving.value && part.value === 'member') camera.value = CLOSE;
    picked.value = views ? pick(of, phase, driving.value ? (me.value?.player ?? null) : null) : release;
  });
  effect(() => {
    const at = frame.value,
      { lesson = '', phase = '' } = now.value ?? {};
    if (staged.value) keep(at, lessonOf(lesson), phase);
  });
  effect(() => {
    const key = secret.value;
    line?.auth(key);
  });
}

/** The class has ended. @param {string} why */
function gone(why) {
  const taught = part.peek() === 'teacher';
  forgetClass(room.peek()?.id ?? '');
  line = null;
  part.value = '';
  secret.value = '';
  me.value = room.value = now.value = null;
  attempt.value = 0;
  shows.value = 'choose';
  place.value = { at: taught ? '' : '#class', hz: 0, seat: null, reason: '', frozen: false };
  const text = why === '' ? t('class.ended') : why.charAt(0).toUpperCase() + why.slice(1);
  if (taught) {
    const shown = session.peek(),
      own = keyOf(shown?.id ?? '');
    if (shown !== null && own !== '' && own !== shown.key) show(shown.id, own, false); /* the class's key opens nothing any more */
    notify(text);
    told.value = '';
    showAddress();
  } else {
    say(t('class.ended_code', { why: text }));
  }
}

/** This device is no member any more: the teacher has removed it, or its place is another's. @param {boolean} byTeacher */
function removed(byTeacher) {
  if (part.peek() !== 'member') return;
  if (!byTeacher) forgetClass(room.peek()?.id ?? ''); /* else the token stays, by which the class knows this device */
  part.value = '';
  secret.value = '';
  me.value = null;
  shows.value = 'choose';
  out.value = byTeacher;
  place.value = { at: `#class=${room.peek()?.code}`, hz: 0, seat: null, reason: '', frozen: false };
  if (!byTeacher) say(t('class.place_gone'));
}

/** @param {any} found a class as the daemon describes it @param {string} key */
function listen({ id, code, join, state }, key) {
  room.value = { id, code, urls: join.urls, local: join.local };
  now.value = state;
  line?.close();
  line = new Line(id, key, {
    state(next, first) {
      if (first || next.serial >= (now.peek()?.serial ?? 0)) now.value = next;
    },
    member: take,
    members({ most, members }) {
      devices.value = { most, members: members.sort((/** @type {any} */ a, /** @type {any} */ b) => a.number - b.number) };
    },
    removed,
    lost(tries) {
      attempt.value = tries;
    },
    gone,
    refused: (detail) => say(detail),
  });
}

/** Whether a class is being opened: the button stays there meanwhile. */
let opening = false;

/** The board of a new class: the session that is shown, or the scene of a lesson, whose question is prepared.
 * @param {{id: string, teacher_key: string}} made @param {import('./lesson.js').Lesson | null} lesson @returns {Promise<string>} its id */
async function firstBoard({ id, teacher_key: key }, lesson) {
  if (lesson === null) {
    const shown = /** @type {import('../session/state.js').Session} */ (session.peek());
    await putBoard(id, key, shown);
    await call('POST', `sessions/${shown.id}/control`, { body: { op: 'pause' }, key: shown.key }).catch(
      () => {},
    ); /* it waits for the class */
    return shown.id;
  }
  const board = await call('PUT', `classes/${id}/board`, { body: boardOf(lesson), key });
  keepKey(board.id, board.owner_key, false);
  await prepare(lesson, board.id, board.owner_key);
  await call('PATCH', `classes/${id}`, { body: questionOf(lesson), key });
  return board.id;
}

/** Opens a class. @param {string | null} wish the lesson that it is asked, empty for the first; null: its board is the session that is
 * shown */
export async function teach(wish) {
  if (opening) return;
  opening = true;
  let made = null;
  try {
    await Promise.all([need('class'), readLessons()]); /* before a word is said */
    const lesson = wish === null ? null : await readLesson(wish || (lessons.value[0]?.id ?? '')),
      shown = session.peek();
    if (lesson === null && (shown === null || shown.key === '')) {
      notify(t('class.needs_own'));
      return;
    }
    made = await make('classes', {});
    const board = await firstBoard(made, lesson);
    await begin();
    if (lesson !== null) showBoard(board, made.teacher_key);
    listen(made, made.teacher_key);
    lead(made.teacher_key, 'stage', board);
    showAddress();
  } catch (error) {
    if (made !== null) call('DELETE', `classes/${made.id}`, { key: made.teacher_key }).catch(() => {}); /* its key was not kept */
    notify(t('class.none', { why: reason(error) }));
  } finally {
    opening = false;
  }
}

/** Whether the next attempt may do: no daemon has answered, or a daemon or a proxy that cannot at this moment, as while a shard
 * starts. @param {unknown} error */
const passes = (error) => !(error instanceof Problem) || [502, 503, 504].includes(error.status);

/** Goes on as what this tab was, if it was in that class. @param {string} id @param {string} key the teacher's, of the address */
async function resume(id, key) {
  const old = kept(id);
  if (key !== '' || old?.teacher) {
    lead(key || (old?.secret ?? ''), old?.shows === 'workbench' ? 'workbench' : 'stage');
    if (now.peek()?.board === null) again(); /* what was shown is gone: another one, from the address */
    return;
  }
  if (!old) return;
  try {
    const member = await call('GET', `classes/${id}/member`, { key: old.secret });
    attend(old.secret, member, old.shows === 'copy' ? 'copy' : 'board');
  } catch (error) {
    out.value = isRemoved(error);
    if (passes(error)) throw error; /* else the class does not know it any more: join again */
  }
}

/** @param {string} code @param {string} [key] @param {number} [tries] */
async function find(code, key = '', tries = 1) {
  place.value = { ...place.peek(), at: `#class=${code}` };
  say('');
  try {
    const found = await call('GET', `classes/${encodeURIComponent(code)}`);
    history.replaceState(null, '', `${location.pathname}${location.search}#class=${found.code}`);
    place.value = { ...place.peek(), at: `#class=${found.code}` };
    listen(found, '');
    await resume(found.id, key);
  } catch (error) {
    if (error instanceof Problem && !passes(error)) {
      room.value = null;
      say(error.status === 404 ? t('class.no_code', { code }) : error.message);
      return;
    }
    say(t('class.no_answer', { tries }));
    setTimeout(() => find(code, key, tries + 1), patience(tries));
  }
}

/** Joins by the address. @param {string} code empty where it is to be typed @param {string} key the teacher's, if the address has it */
export async function enter(code, key) {
  place.value = { ...place.peek(), at: '#class' };
  await begin();
  if (tidy(code) !== '') await find(tidy(code), key);
}
