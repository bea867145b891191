// Wires the page together.
import { effect } from '../../vendor/signals-core.js';
import * as announce from '../session/announce.js';
import { call, insist, part } from '../base/api.js';
import * as controls from '../workbench/controls.js';
import { line, link, opened } from '../session/opening.js';
import * as keys from './keys.js';
import { failed, hook, openExperiments, show } from '../session/session.js';
import { readExperiment } from '../base/link.js';
import * as loop from '../labs/netgame/lab/drawing.js';
import * as page from './page.js';
import { experiment, frame, layout, locked, params, scenarios, schemas, session, notify } from '../session/state.js';

/* Read-only, for tests and for the curious: frame, params, connection, counts, messages. */
Object.defineProperty(window, 'laglab', { value: Object.assign(() => hook(), { costs: loop.costs }) });

opened
  ?.then(async (made) => {
    show(made.id, made.key, made.own, await line);
    const notes = [made.note, ...link.problems].filter((text) => text !== '');
    if (notes.length > 0) notify(notes.join('. '), link.problems.length > 0);
  })
  .catch(failed);

const WAIT_MS = 400;
if (opened) {
  /* the page is laid out once, not twice, when the session's layout arrives soon */
  await new Promise((done) => {
    setTimeout(done, WAIT_MS);
    effect(() => {
      if (layout.value !== null) done(null);
    });
  });
}

page.listen(loop.touch);
controls.listen();
keys.listen();
announce.listen();
loop.listen();

/** @type {Set<string>} */
const asked = new Set();
function readMore() {
  part(() => import('./later.js'));
  effect(() => {
    const kind = params.value?.kind;
    if (!kind || asked.has(kind)) return;
    asked.add(kind);
    insist(() => call('GET', `schema?kind=${kind}`)).then((answer) => {
      schemas.value = new Map(schemas.value).set(kind, answer);
    });
  });
  insist(() => call('GET', 'scenarios?brief=true')).then((answer) => {
    scenarios.value = answer.scenarios ?? [];
  });
}
const waiting = effect(() => {
  /* a request before the first frame delays that frame */
  if (frame.value === null && experiment.value === null) return;
  setTimeout(() => {
    waiting();
    readMore();
  });
});

if (matchMedia('(prefers-reduced-motion: reduce)').matches) {
  /* then the session waits: Play is what comes next */
  const stop = effect(() => {
    if (locked.value !== '') return;
    queueMicrotask(() => {
      document.getElementById('play')?.focus();
      stop();
    });
  });
}

addEventListener('hashchange', () => {
  /* Back from a point that was opened, or an address that was typed */
  const wanted = readExperiment(location.hash);
  if (wanted !== null) openExperiments(wanted);
  else if (location.hash.startsWith('#s=') && !location.hash.startsWith(`#s=${session.value?.id}`)) location.reload();
});
addEventListener('popstate', () => {
  if (experiment.value !== null && readExperiment(location.hash) === null) location.reload();
});
