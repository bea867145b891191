// The first thing that runs: a session, or what lessons need, is asked for while the rest of the page is read.
import { need } from '../base/words.js';
import { begin, link } from '../session/opening.js';
import { LABS } from './labs.js';

if (link.lesson !== null) {
  import('../lessons/lessons.js').catch(() => {}); /* read again where it is wanted */
}

export const begun = begin(
  LABS.flatMap(({ tabs }) => tabs),
  Object.assign({}, ...LABS.map(({ slow }) => slow)),
);

/** The lab that is read before the session's kind is known: that of the scenario's folder, else the first. */
export const likely = LABS.find(({ kind, sessionless }) => !sessionless && link.scenario.startsWith(`${kind}/`)) ?? LABS[0];
if (begun) need(likely.kind);
