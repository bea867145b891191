// A viewer of a paused session gets its first frame, and all of every channel that it subscribes to later, however busy the machine is.
// Nothing else would send it: a wake that is lost is never repeated. SUBSCRIPTIONS=100000 is a longer run.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { cpus } from 'node:os';
import { test } from 'node:test';
import { client, pause, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const SUBSCRIPTIONS = Number(process.env.SUBSCRIPTIONS ?? 600);
const SESSIONS = 30,
  VISITORS = 12,
  LOST_MS = 120000; // far more than a busy machine takes

/** Programs that only compute, one for each core. @param {import('node:test').TestContext} t */
function load(t) {
  const each = Array.from({ length: cpus().length }, () => spawn(process.execPath, ['-e', 'for (;;);'], { stdio: 'ignore' }));
  t.after(() => each.forEach((child) => child.kill('SIGKILL')));
}

const whole = (below) => Math.floor(Math.random() * below);

test(`${SUBSCRIPTIONS} subscriptions to paused sessions under load: none is left without its frame`, { timeout: 3600000 }, async (t) => {
  const daemon = await startDaemon({ args: ['--max-new-sessions-per-min', '1000', '--park-after-s', '1'] });
  t.after(() => daemon.stop());
  const c = client(daemon.url);
  t.after(() => c.close());
  const sessions = [];
  for (let i = 0; i < SESSIONS; i++) sessions.push(await c.make({ paused: true }));
  // Their workers are visited at any time for one that plays.
  const playing = await c.make({ set: { duration_s: 600 } });
  await c.stream(playing, 'bin', { ack: true });
  load(t);
  let made = 0,
    slowest = 0;
  const lost = [];
  /** Until a frame has all channels of `names`, since frame `from`. */
  async function all(stream, from, names, what) {
    const begun = performance.now(),
      seen = () => names.every((name) => stream.frames.slice(from).some((frame) => frame[name]));
    await waitFor(seen, what, LOST_MS).catch((error) => lost.push(error.message));
    slowest = Math.max(slowest, performance.now() - begun);
    made++;
  }
  async function visit() {
    const session = sessions[whole(sessions.length)],
      stream = await c.stream(session, 'json', { subscribe: {} });
    await pause(whole(20));
    if (whole(3) === 0) {
      stream.say({ subscribe: { scene: 60 } }); // which it takes back, or leaves, before it was answered
      if (whole(2) === 0) return stream.socket.terminate();
      stream.say({ subscribe: {} });
    }
    const from = stream.frames.length;
    stream.say({ subscribe: { session: 60 } });
    await all(stream, from, ['session'], 'the first frame');
    stream.say({ subscribe: { session: 60, scene: 20, gauges: 1 } });
    await all(stream, from, ['session', 'views', 'buffers'], 'channels that were added');
    await (whole(2) === 0 ? stream.close() : stream.socket.terminate());
  }
  const visitor = async () => {
    while (made < SUBSCRIPTIONS && lost.length < 10) await visit();
  };
  await Promise.all(Array.from({ length: VISITORS }, visitor));
  t.diagnostic(`${made} subscriptions, ${lost.length} without a frame, the slowest after ${slowest.toFixed(0)} ms`);
  assert.deepEqual(lost, []);
});
