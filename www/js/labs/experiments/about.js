// What the page knows of the Experiments view before it is read.
import { need } from '../../base/words.js';

/** @type {import('../../session/lab.js').About} */
export const about = {
  kind: 'experiments',
  sessionless: true,
  group: '',
  tabs: [],
  rates: {},
  load: async () => {
    const [{ begin, lab, ready }] = await Promise.all([import('./view.js'), need('experiments')]);
    await ready;
    begin();
    return lab;
  },
};
