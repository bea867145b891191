// What the page knows of the view of speed against error before it is read.
import { need } from '../../base/words.js';

/** @type {import('../../session/lab.js').About} */
export const about = {
  kind: 'tradeoff',
  sessionless: true,
  group: '',
  tabs: [],
  rates: {},
  load: async () => {
    const [{ lab, ready }] = await Promise.all([import('./view.js'), need('tradeoff')]);
    await ready;
    return lab;
  },
};
