// The first thing that runs: a session is asked for while the rest of the page is read.
import { begin } from '../session/opening.js';
import { LABS } from './labs.js';

export const begun = begin(LABS.flatMap(({ tabs }) => tabs));
