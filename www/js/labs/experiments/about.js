// What the page knows of the Experiments view before it is read.

/** @type {import('../../session/lab.js').About} */
export const about = {
  kind: 'experiments',
  sessionless: true,
  group: '',
  tabs: [],
  rates: {},
  load: async () => {
    const { begin, lab, ready } = await import('./view.js');
    await ready;
    begin();
    return lab;
  },
};
