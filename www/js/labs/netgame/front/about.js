// What the page knows of its first page before that is read.
import { need } from '../../../base/words.js';
import { START } from './start.js';

/** @type {import('../../../session/lab.js').About} */
export const about = {
  kind: 'front',
  sessionless: true,
  group: '',
  tabs: [],
  rates: {},
  start: START,
  load: async () => {
    const [{ lab }] = await Promise.all([import('./lab.js'), need('lesson')]);
    return lab;
  },
};
