// The first thing that runs: a session, or what lessons need, is asked for while the rest of the page is read.
import { file } from '../base/place.js';
import { begin, link } from '../session/opening.js';
import { FRONT, LABS } from './labs.js';

const ahead = (/** @type {Promise<unknown>} */ read) => read.catch(() => {}); /* again where it is wanted */
if (link.lesson !== null) {
  ahead(import('../lessons/lessons.js'));
  ahead(file(`lessons/${link.lesson.id || 'index'}.json`));
}

export const begun = begin(
  LABS.flatMap(({ tabs }) => tabs),
  Object.assign({}, ...LABS.map(({ slow }) => slow)),
  FRONT.start,
);

/** The lab that is read before the session's kind is known: that of the scenario's folder, else the first. */
export const likely = LABS.find(({ kind, sessionless }) => !sessionless && link.scenario.startsWith(`${kind}/`)) ?? LABS[0];
if (begun) ahead((link.lesson === null ? likely : FRONT).load());
