// What a member of a class does: takes a part, votes, and shows the board or a copy of it.
import { effect, untracked } from '../../vendor/signals-core.js';
import { Problem, call } from '../base/api.js';
import { speak } from '../session/announce.js';
import { keep } from '../session/opening.js';
import { send, show } from '../session/session.js';
import { place, session } from '../session/state.js';
import { isOpen } from './ask.js';
import { keepClass, kept } from './kept.js';
import { me, now, out, part, reason, room, say, secret, shows, staged } from './state.js';
import { t } from '../base/words.js';

const VIEWER_HZ = 10 /* thirty of them are to fit in 2 Mbit/s */,
  PLAYER_HZ = 30;

/** As the member that this browser is already, if the class knows it still. @param {unknown} wish @returns {Promise<any>} */
async function ask(wish) {
  const { id = '' } = room.peek() ?? {};
  return call('POST', `classes/${id}/members`, { body: wish, key: kept(id)?.secret ?? secret.peek() });
}

/** Whether the teacher has removed this device. @param {unknown} error */
export const isRemoved = (error) => error instanceof Problem && error.errors.some(({ field }) => field === 'device');

/** @param {'watch' | 'play' | 'copy'} role @param {number} [player] whose seat */
export async function join(role, player) {
  try {
    const answer = await ask(role === 'play' ? { role, player } : { role });
    say('');
    if (answer.copy_key) keep(answer.copy, answer.copy_key, false);
    begin(answer.token ?? kept(answer.class)?.secret ?? secret.peek(), answer, role === 'copy' ? 'copy' : 'board');
  } catch (error) {
    if (isRemoved(error)) out.value = true;
    else say(reason(error));
  }
}

/** From now on this page is a member's. @param {string} token @param {import('./state.js').Member} member
 * @param {'board' | 'copy'} first */
export function begin(token, { number, role, player, choice, copy }, first) {
  secret.value = token;
  me.value = { number, role, player, choice, copy };
  shows.value = first;
  part.value = 'member';
}

/** What the class says of this member. @param {import('./state.js').Member} member */
export function take({ number, role, player, choice, copy }) {
  const before = me.peek();
  me.value = { number, role, player, choice, copy };
  if (role === 'play') send({ auth: secret.peek(), id: 0 }); /* the board may have refused it while the class did not know it */
  else if (before?.role === 'play' && role === 'watch') say(t('class.seat_free'));
}

/** @param {number} choice from 0 */
export async function vote(choice) {
  const question = now.peek()?.question,
    mine = me.peek();
  if (!question || mine === null) return;
  try {
    await call('PUT', `classes/${room.peek()?.id}/vote`, { body: { step: question.step, choice }, key: secret.peek() });
    me.value = { .../** @type {import('./state.js').Member} */ (me.peek()), choice };
  } catch (error) {
    say(t('class.no_vote', { why: reason(error) }));
    me.value = { ...mine }; /* the buttons go back to what holds */
  }
}

/** A flag on the road is an answer. @param {number} choice */
export function plant(choice) {
  if (part.peek() === 'member' && isOpen()) vote(choice);
}

/** The keys 1 to 8 vote. */
document.addEventListener(
  'keydown',
  (event) => {
    if (part.peek() !== 'member' || shows.peek() === 'choose' || !isOpen()) return;
    if (event.altKey || event.ctrlKey || event.metaKey || event.repeat) return;
    const choice = Number(/^(?:Digit|Numpad)([1-8])$/.exec(event.code)?.[1] ?? 0) - 1;
    if (choice < 0 || choice >= (now.peek()?.question?.choices ?? 0)) return;
    if (event.target instanceof HTMLElement && event.target.matches('select, textarea, input:not([type="radio"])')) return;
    event.preventDefault();
    event.stopPropagation();
    vote(choice);
  },
  true,
);

/** Which session this member sees, and what it may do there.
 * @returns {{id: string, key: string, seat: number | null, hz: number} | null} */
function wanted() {
  const state = now.value,
    mine = me.value;
  if (part.value !== 'member' || state === null || mine === null) return null;
  if (shows.value === 'copy' && mine.copy !== null) return { id: mine.copy, key: secret.value, seat: null, hz: VIEWER_HZ };
  if (state.board === null) return null;
  if (mine.role === 'play' && mine.player !== null) return { id: state.board, key: secret.value, seat: mine.player, hz: PLAYER_HZ };
  return { id: state.board, key: '', seat: -1, hz: VIEWER_HZ };
}

effect(() => {
  const want = wanted();
  if (want === null) return;
  const frozen = now.value?.frozen === true;
  const why = frozen ? t('class.frozen') : want.seat === null ? '' : t('class.board_tip');
  untracked(() => {
    const next = { at: `#class=${room.peek()?.code}`, hz: want.hz, seat: want.seat, reason: why, frozen, staged: staged.value };
    if (JSON.stringify(next) !== JSON.stringify(place.peek())) place.value = next; /* the state comes twice a second */
    const shown = session.peek();
    if (shown?.id !== want.id || shown.key !== want.key) show(want.id, want.key, false, undefined, () => {});
  });
});
effect(() => {
  if (now.value?.together && part.value === 'member' && shows.value === 'copy') shows.value = 'board';
});
effect(() => {
  const at = room.value,
    token = secret.value;
  if (part.value === 'member' && at !== null && shows.value !== 'choose')
    keepClass({ id: at.id, secret: token, teacher: false, shows: shows.value });
});
let frozenBefore = false;
effect(() => {
  const frozen = now.value?.frozen === true;
  if (part.value === 'member' && frozen !== frozenBefore) speak('class', frozen ? t('class.frozen') : t('class.unfrozen'));
  frozenBefore = frozen;
});
