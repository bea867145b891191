// Thirty-one clients at once: a teacher and thirty members, who all watch a race at 10 Hz as the page does. What they see, how soon, and
// how much is sent; and the documents: each answer and message of a class by openapi.yaml and asyncapi.yaml.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import Ajv from 'ajv/dist/2020.js';
import YAML from 'yaml';
import { client, openStream, pause, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const C = '/api/v1/classes',
  MEMBERS = 30,
  HZ = 10,
  WATCH = { session: HZ, scene: HZ, lanes: HZ };

let daemon, c, ajv;
before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
  ajv = new Ajv({ strict: false, allErrors: true });
  ajv.addSchema(YAML.parse((await c.get('/api/v1/asyncapi.yaml')).text), 'asyncapi');
});
after(async () => {
  c.close();
  await daemon.stop();
});

/** Holds a message of a class's stream against its schema. */
function check(message) {
  const name = { hello: 'classHello', reply: 'classReply' }[message.type] ?? message.type;
  const validate = ajv.getSchema(`asyncapi#/components/messages/${name}/payload`);
  assert.ok(validate(message), `${name}: ${ajv.errorsText(validate.errors)} in ${JSON.stringify(message)}`);
}

/** Bytes received, frames of WebSocket included. */
const received = (streams) => streams.reduce((sum, s) => sum + s.socket._socket.bytesRead, 0);

test('thirty members and a teacher at once: each of them sees every change, 2 Mbit/s at most', async (t) => {
  const opened = (await c.call('POST', C)).json,
    key = opened.teacher_key,
    at = `${C}/${opened.id}`;
  const set = async (patch) => assert.equal((await c.call('PATCH', at, { key, body: patch })).status, 200);
  const board = (await c.call('PUT', `${at}/board`, { key, body: { scenario: 'race', set: { duration_s: 600 } } })).json;
  const teacher = await openStream(daemon.url, `classes/${opened.id}`);
  const members = await Promise.all(
    Array.from({ length: MEMBERS }, async (_, i) => {
      const joined = await c.call('POST', `${C}/${opened.code}/members`, { body: { role: i < 2 ? 'play' : 'watch' } });
      assert.equal(joined.status, 201, joined.text);
      const own = await openStream(daemon.url, `classes/${opened.id}`),
        view = await openStream(daemon.url, `sessions/${board.id}`, 'bin', { ack: true, subscribe: WATCH });
      own.say({ auth: joined.json.token });
      if (joined.json.player !== null) view.say({ auth: joined.json.token });
      return { ...joined.json, own, view };
    }).map((p) => p.catch((error) => error)),
  );
  for (const m of members) if (m instanceof Error) throw m;
  const all = [teacher, ...members.map((m) => m.own)];
  const newest = (s) => s.messages.filter((m) => m.serial !== undefined).at(-1);
  /** Until every one of the 31 has seen it; how long that takes: bench/classroom.mjs. */
  const everybody = (test_, what) => waitFor(() => all.every((s) => test_(newest(s))), `${what} at all ${all.length}`);
  await everybody((s) => s.n === MEMBERS && s.seats.every((seat) => seat.state === 'held'), 'members and seats');
  assert.deepEqual(
    members
      .map((m) => m.player)
      .filter((p) => p !== null)
      .sort(),
    [0, 1],
  );

  await set({ phase: 'predict', lesson: 'late_answer', step: 1, choices: 4 });
  await everybody((s) => s.phase === 'predict', 'a phase');
  const votes = await Promise.all(members.map((m, i) => c.call('PUT', `${at}/vote`, { key: m.token, body: { step: 1, choice: i % 4 } })));
  assert.ok(votes.every(({ status }) => status === 204));
  await everybody((s) => s.votes === MEMBERS && s.tally === null, 'the count of votes');
  await set({ phase: 'locked' });
  await everybody((s) => s.tally?.join() === '8,8,7,7', 'the tally');

  await set({ phase: 'run' });
  await everybody((s) => s.status === 'playing', 'the run');
  let driving = true;
  t.after(() => {
    driving = false;
  });
  const drive = (async () => {
    for (let i = 0; driving; i++) {
      for (const m of members.slice(0, 2)) m.view.say({ input: { player: m.player, axes: [i % 3 ? 1 : 0, (i % 5) / 4 - 0.5] } });
      await pause(100);
    }
  })();
  const more = (/** @type {number} */ count) => {
    const had = members.map((m) => m.view.frames.length);
    return waitFor(() => members.every((m, i) => m.view.frames.length >= had[i] + count), `${count} frames of each`);
  };
  const streams = [...all, ...members.map((m) => m.view)],
    /* by the session's clock, which goes on however busy the machine is */
    now = async () => ({ bytes: received(streams), time_s: (await c.get(`/api/v1/sessions/${board.id}`)).json.time_s });
  await more(10); /* the first are whole */
  const before = await now();
  await more(40);
  const after = await now(),
    mbit_s = ((after.bytes - before.bytes) * 8) / (after.time_s - before.time_s) / 1e6;
  t.diagnostic(`${MEMBERS} viewers of a race at ${HZ} Hz: ${mbit_s.toFixed(3)} Mbit/s`);
  assert.ok(mbit_s <= 2, `${mbit_s} Mbit/s`);
  driving = false;
  await drive;

  await set({ frozen: true });
  await everybody((x) => x.frozen && x.status === 'paused', 'the freeze');
  await set({ together: true });
  await everybody((x) => x.together, 'bringing all to the board');
  await set({ frozen: false, together: false });
  await everybody((x) => x.status === 'playing' && !x.together, 'letting go');
  for (const stream of all) stream.messages.forEach(check);
  await Promise.all(streams.map((stream) => stream.close()));
});

test('a freeze stops thirty copies', async () => {
  const opened = (await c.call('POST', C)).json,
    key = opened.teacher_key,
    at = `${C}/${opened.id}`;
  await c.call('PUT', `${at}/board`, { key, body: { scenario: 'race', set: { duration_s: 600 } } });
  await c.call('PATCH', at, { key, body: { phase: 'run' } });
  await waitFor(async () => (await c.get(at)).json.state.status === 'playing', 'the run');
  const copies = [];
  for (let i = 0; i < MEMBERS; i++) {
    const { json } = await c.call('POST', `${at}/members`, { body: { role: 'copy' } });
    const view = await openStream(daemon.url, `sessions/${json.copy}`, 'bin', { ack: true, subscribe: WATCH });
    copies.push({ ...json, view });
  }
  await c.call('PATCH', at, { key, body: { frozen: true } });
  const isPaused = async (id) => (await c.get(`/api/v1/sessions/${id}`)).json.status === 'paused';
  await Promise.all(copies.map(({ copy }) => waitFor(() => isPaused(copy), `the freeze of ${copy}`)));
  await Promise.all(copies.map(({ view }) => view.close()));
});
