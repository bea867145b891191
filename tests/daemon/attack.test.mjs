// A class that one laptop attacks while thirty devices join and vote: none of them is refused, and the tally is right. Addresses are
// those of a trusted proxy's header, as a school or a room has them.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { Worker } from 'node:worker_threads';
import { client, openStream, pause, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const C = '/api/v1/classes',
  TEACHER = '192.0.2.1',
  PUPILS = 30,
  PLACES = 64;
const from = (/** @type {string} */ address) => ({ 'x-forwarded-for': address });
/** Each pupil's own address, and one for all. */
const room = (/** @type {number} */ i) => `198.51.100.${i + 1}`,
  school = () => TEACHER,
  elsewhere = () => '203.0.113.200';

let daemon, c;
before(async () => {
  daemon = await startDaemon({ args: ['--trusted-proxy', '127.0.0.1'] });
  c = client(daemon.url, 256);
});
after(async () => {
  c.close();
  await daemon.stop();
});

/** A class of a teacher, whose own address is known, with a race on its board and an open question. */
async function open() {
  const made = (await c.call('POST', C, { headers: from(TEACHER), body: {} })).json;
  const at = `${C}/${made.id}`,
    key = made.teacher_key;
  const call = (/** @type {string} */ method, path = '', body = undefined) =>
    c.call(method, `${at}${path}`, { key, headers: from(TEACHER), body });
  assert.equal((await call('PUT', '/board', { scenario: 'race' })).status, 200);
  assert.equal((await call('PATCH', '', { phase: 'predict', choices: 4 })).status, 200);
  return {
    ...made,
    at,
    call,
    state: async () => (await c.get(at)).json.state,
    list: async () => (await call('GET', '/members')).json.members,
  };
}

/** A device as the page is one: it finds the class by the code, connects, joins and authenticates. All that is refused is noted.
 * @param {any} of @param {string} address @param {string[]} refused */
async function device(of, address, refused) {
  const headers = from(address);
  /** @type {number[]} */
  const waits = [];
  const call = async (/** @type {string} */ method, /** @type {string} */ path, /** @type {any} */ wish = {}) => {
    const begun = performance.now();
    const answer = await c.call(method, path, { headers, ...wish });
    waits.push(performance.now() - begun);
    if (answer.status >= 300) refused.push(`${method} ${path.replace(of.id, 'ID')} ${answer.status} ${answer.json?.detail}`);
    return answer;
  };
  const connect = async () => {
    const stream = await openStream(daemon.url, `classes/${of.id}`, 'json', { headers });
    if (me.token) stream.say({ auth: me.token });
    if (me.token) await stream.wait((m) => m.type === 'member', 'its own state');
    return stream;
  };
  const me = {
    token: '',
    number: 0,
    stream: /** @type {any} */ (undefined),
    waits,
    vote: (/** @type {number} */ choice) => call('PUT', `${of.at}/vote`, { key: me.token, body: { step: 0, choice } }),
    join: async () => {
      await call('GET', `${C}/${of.code}`);
      me.stream = await connect();
      const answer = await call('POST', `${of.at}/members`, { body: {} });
      if (answer.status !== 201) return;
      me.token = answer.json.token;
      me.number = answer.json.number;
      me.stream.say({ auth: me.token });
      await me.stream.wait((/** @type {any} */ m) => m.type === 'member', 'its own state');
    },
    back: async () => {
      me.stream.socket.terminate();
      me.stream = await connect();
      return call('GET', `${of.at}/member`, { key: me.token });
    },
    close: () => me.stream?.socket.terminate(),
  };
  await me.join();
  return me;
}

/** @param {any} of @param {(i: number) => string} address @param {string[]} refused */
const pupils = (of, address, refused, count = PUPILS) =>
  Promise.all(Array.from({ length: count }, (_, i) => device(of, address(i), refused)));
/** Takes all places, each with a connection. @param {any} of @param {(i: number) => string} address */
async function flood(of, address, places = PLACES) {
  const all = await pupils(of, address, [], places);
  assert.equal(all.filter(({ token }) => token).length, places);
  return all;
}
const attack = (/** @type {import('node:test').TestContext} */ t, /** @type {any} */ of, /** @type {string} */ address) => {
  const worker = new Worker(new URL('../lib/attacker.mjs', import.meta.url), {
    workerData: { url: daemon.url, id: of.id, code: of.code, address, many: 6 },
  });
  t.after(() => worker.terminate());
  return () =>
    new Promise((resolve, reject) => {
      worker.once('error', reject);
      worker.once('message', resolve);
      worker.postMessage('stop');
    });
};
const close = (/** @type {{close: () => void}[]} */ all) => all.forEach((one) => one.close());

for (const [what, address] of /** @type {[string, (i: number) => string][]} */ ([
  ['thirty addresses of a room', room],
  ['the one of a school, at which the class was opened', school],
  ['another one', elsewhere],
]))
  test(`64 places that one client has taken and holds are there for thirty devices of ${what}`, async () => {
    const of = await open();
    const taken = await flood(of, () => '203.0.113.9');
    /** @type {string[]} */
    const refused = [];
    const here = await pupils(of, address, refused);
    assert.deepEqual(refused, []);
    const more = await c.call('POST', `${of.at}/members`, { headers: from('203.0.113.9') });
    assert.equal(more.status, 429, 'who has the most gets no more');
    await Promise.all(here.map((one) => one.vote(1)));
    assert.deepEqual(refused, []);
    const list = await of.list();
    assert.equal(list.length, PLACES);
    for (const { number } of here) assert.ok(list.some((/** @type {any} */ m) => m.number === number && m.voted && m.connected));
    assert.equal(
      taken.filter(({ stream }) => stream.messages.some((/** @type {any} */ m) => m.type === 'removed' && !m.by_teacher)).length,
      PUPILS,
    );
    close([...taken, ...here]);
  });

test('64 places that were taken by programs without a connection are there for devices of the same address', async () => {
  const of = await open();
  for (let i = 0; i < PLACES; i++) assert.equal((await c.call('POST', `${of.at}/members`, { headers: from(TEACHER) })).status, 201);
  /** @type {string[]} */
  const refused = [];
  const here = await pupils(of, school, refused);
  assert.deepEqual(refused, []);
  close(here);
});

test('many addresses with a device each do not drive out those at the address of the teacher', async () => {
  const of = await open();
  /** @type {string[]} */
  const refused = [];
  const here = await pupils(of, school, refused);
  const others = await flood(of, room, PLACES - PUPILS);
  for (let i = 0; i < 20; i++) assert.equal((await c.call('POST', `${of.at}/members`, { headers: from(`203.0.113.${i}`) })).status, 429);
  for (const one of here) await one.vote(2);
  assert.deepEqual(refused, []);
  close([...here, ...others]);
});

test('thirty devices join, vote, vote again and reconnect while one laptop attacks: none is refused, the tally is right', async (t) => {
  const of = await open();
  const stop = attack(t, of, '203.0.113.9');
  await waitFor(async () => (await of.list()).length === PLACES, 'the class to be full');
  /** @type {string[]} */
  const refused = [];
  const here = await pupils(of, room, refused);
  await Promise.all(here.map((one, i) => one.vote(i % 4)));
  await pause(500);
  await Promise.all(here.map((one) => one.back()));
  await Promise.all(here.map((one, i) => one.vote(i < 17 ? 0 : 2)));
  assert.deepEqual(refused, [], 'honest devices that were refused');

  const attacker = (await of.list()).filter((/** @type {any} */ m) => !here.some(({ number }) => number === m.number));
  const letters = new Set(attacker.map((/** @type {any} */ m) => m.group));
  assert.equal(letters.size, 1, 'all of the laptop are of one group');
  assert.equal((await of.call('DELETE', `/members/${attacker[0].number}?and=address`)).status, 204);
  await pause(500); /* it goes on */
  const list = await of.list();
  assert.deepEqual(
    list.map((/** @type {any} */ m) => m.number).sort((/** @type {number} */ a, /** @type {number} */ b) => a - b),
    here.map(({ number }) => number).sort((a, b) => a - b),
    'the pupils and no other',
  );
  const players = [here[3], here[11]];
  for (const [player, { token }] of players.entries())
    assert.equal(
      (await c.call('PATCH', `${of.at}/member`, { key: token, body: { role: 'play', player } })).status,
      200,
      'the seats are free',
    );
  assert.equal((await of.call('PATCH', '', { phase: 'locked' })).status, 200);
  assert.deepEqual((await of.state()).tally, [17, 0, 13, 0]);
  const counts = await stop();
  assert.equal(Object.keys(counts).filter((name) => / 5\d\d$/.test(name)).length, 0, JSON.stringify(counts));
  const waits = here.flatMap((one) => one.waits).sort((a, b) => a - b);
  const part = (/** @type {number} */ share) => `${waits[Math.floor(share * (waits.length - 1))].toFixed(0)} ms`;
  console.log(`# refused honest requests: ${refused.length} of ${waits.length}; answered in ${part(0.5)} (half), ${part(0.99)} (99 %)`);
  console.log(`# the laptop: ${JSON.stringify(counts)}`);
  assert.ok(counts['join 403'] > 0, 'its address stays out');
  close(here);
});

test('behind one address with the attacker the teacher closes the door and removes who came later', async (t) => {
  const of = await open();
  /** @type {string[]} */
  const refused = [];
  const here = await pupils(of, school, refused);
  const stop = attack(t, of, TEACHER);
  await waitFor(async () => (await of.list()).length === PLACES, 'the class to be full');
  await Promise.all(here.map((one, i) => one.vote(i % 2)));
  const last = Math.max(...here.map(({ number }) => number));
  assert.equal((await of.call('PATCH', '', { door: 'closed' })).status, 200);
  const later = (await of.list()).map((/** @type {any} */ m) => m.number).filter((/** @type {number} */ number) => number > last);
  assert.equal((await of.call('DELETE', `/members/${Math.min(...later)}?and=later`)).status, 204);
  await Promise.all(here.map((one) => one.back()));
  await pause(300);
  assert.deepEqual(refused, []);
  assert.equal((await of.list()).length, PUPILS);
  assert.equal((await of.call('PATCH', '', { phase: 'locked' })).status, 200);
  assert.deepEqual((await of.state()).tally, [15, 15, 0, 0]);
  await stop();
  close(here);
});

test('copies that an address asks for while it stays out are not made, and use up nothing of the class', async () => {
  const of = await open();
  const here = (await c.call('POST', `${of.at}/members`, { headers: from('203.0.113.9') })).json;
  assert.equal((await of.call('DELETE', `/members/${here.number}?and=address`)).status, 204);
  const made = async () => Number(/^laglab_sessions_created_total (\d+)/m.exec((await c.get('/metrics')).text)?.[1]);
  const before = await made();
  assert.ok(before > 0);
  for (let i = 0; i < 150; i++)
    assert.equal((await c.call('POST', `${of.at}/members`, { headers: from('203.0.113.9'), body: { role: 'copy' } })).status, 403);
  assert.equal(await made(), before);
});

const press = async (/** @type {number} */ times, /** @type {() => Promise<any>} */ ask) => {
  /** @type {Record<number, number>} */
  const counts = {};
  for (let i = 0; i < times; i++) {
    const { status } = await ask();
    counts[status] = (counts[status] ?? 0) + 1;
  }
  return counts;
};

test('who uses up the rate of an address keeps no class from its boards and copies', async (t) => {
  const small = await startDaemon({ args: ['--trusted-proxy', '127.0.0.1', '--max-new-sessions-per-min', '30'] });
  t.after(() => small.stop());
  const d = client(small.url);
  t.after(() => d.close());
  const headers = from(TEACHER);
  const { id, teacher_key: key } = (await d.call('POST', C, { headers })).json,
    at = `${C}/${id}`;
  const show = () => d.call('PUT', `${at}/board`, { key, headers, body: { scenario: 'race' } });
  const copy = (address = TEACHER) => d.call('POST', `${at}/members`, { headers: from(address), body: { role: 'copy' } });
  assert.equal((await show()).status, 200);
  const member = (await d.call('POST', `${at}/members`, { headers, body: {} })).json.token;
  assert.ok((await press(50, () => d.call('POST', '/api/v1/sessions', { headers, body: '{bad' })))[429] >= 15);
  const closed = await d.call('POST', C, { headers });
  assert.equal(closed.status, 429, 'another class');
  assert.match(closed.json.detail, /^sessions, classes and experiments: must be at most 30\/min for one address$/);
  for (let i = 0; i < 6; i++) assert.equal((await show()).status, 200, 'the teacher');
  assert.equal((await d.call('PATCH', `${at}/member`, { key: member, headers, body: { role: 'copy' } })).status, 200, 'a pupil');
  const copies = await press(45, copy);
  assert.ok(copies[201] >= 28 && copies[201] < 36 && copies[201] + copies[429] === 45, JSON.stringify(copies));
  assert.match((await copy()).json.detail, /^copies: must be at most 30\/min for one address of a class$/);
  assert.equal((await copy('203.0.113.10')).status, 201, 'another address');
  assert.equal((await show()).status, 200, 'the teacher');
  assert.ok((await press(40, show))[429] >= 10);
  assert.match((await show()).json.detail, /^boards: must be at most 30\/min for one class$/);
});

test('copies, from however many addresses, do not use up the rate of the class key', async (t) => {
  process.env.LAGLAB_CLASS_KEY = 'north a-class-of-thirty new_sessions_per_min=20';
  const small = await startDaemon({ args: ['--trusted-proxy', '127.0.0.1'] }).finally(() => {
    delete process.env.LAGLAB_CLASS_KEY;
  });
  t.after(() => small.stop());
  const d = client(small.url);
  t.after(() => d.close());
  const open = () => d.call('POST', C, { key: 'a-class-of-thirty', headers: from(TEACHER) });
  const { id, teacher_key: key } = (await open()).json,
    at = `${C}/${id}`;
  const show = () => d.call('PUT', `${at}/board`, { key, headers: from(TEACHER), body: { scenario: 'race' } });
  assert.equal((await show()).status, 200);
  for (const address of ['203.0.113.9', '203.0.113.10', '203.0.113.11']) {
    const copies = await press(32, () => d.call('POST', `${at}/members`, { headers: from(address), body: { role: 'copy' } }));
    assert.ok(copies[201] >= 20 && copies[201] < 26 && copies[201] + copies[429] === 32, `${address} ${JSON.stringify(copies)}`);
  }
  assert.equal((await show()).status, 200, 'the teacher');
  assert.equal((await open()).status, 201, 'another class');
});

test('a removed device stays out, over a restart of the daemon too; its vote is gone, and its page learns it', async (t) => {
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-test-'));
  const own = await startDaemon({ args: ['--trusted-proxy', '127.0.0.1'], data });
  let now = own;
  t.after(async () => {
    await now.stop();
    rmSync(data, { recursive: true, force: true });
  });
  const d = client(own.url);
  t.after(() => d.close());
  const { id, teacher_key: key } = (await d.call('POST', C)).json,
    at = `${C}/${id}`;
  await d.call('PATCH', at, { key, body: { phase: 'predict', choices: 2 } });
  const join = (/** @type {any} */ wish = {}, who = d) => who.call('POST', `${at}/members`, { headers: from('203.0.113.7'), ...wish });
  const [one, two] = [(await join()).json, (await join()).json];
  for (const { token } of [one, two])
    assert.equal((await d.call('PUT', `${at}/vote`, { key: token, body: { step: 0, choice: 1 } })).status, 204);
  const again = await join({ key: one.token, body: { role: 'watch' } });
  assert.deepEqual([again.status, again.json.number, again.json.choice, again.json.token], [200, 1, 1, undefined], 'the same device');
  const stream = await openStream(own.url, `classes/${id}`);
  stream.say({ auth: one.token });
  await stream.wait((m) => m.type === 'member');
  assert.equal((await d.call('DELETE', `${at}/members/1`, { key })).status, 204);
  assert.equal((await stream.wait((m) => m.type === 'removed')).by_teacher, true);
  const out = 'device: the teacher has removed it from the class.';
  const check = async (who = d) => {
    for (const answer of [
      await join({ key: one.token }, who),
      await who.get(`${at}/member`, { key: one.token }),
      await who.call('PUT', `${at}/vote`, { key: one.token, body: { step: 0, choice: 0 } }),
    ])
      assert.deepEqual([answer.status, answer.json.detail], [403, out]);
  };
  await check();
  assert.equal((await stream.wait((m) => m.type === 'class' && m.n === 0)).votes, 1, 'who has been removed is not counted');
  stream.say({ auth: one.token, id: 1 });
  assert.match((await stream.wait((m) => m.id === 1)).problem.detail, /device: the teacher has removed it/);
  assert.equal((await d.get(at)).json.state.votes, 1);
  assert.equal((await d.call('DELETE', `${at}/members/2?and=address`, { key })).status, 204);
  assert.equal((await join()).json.detail, 'address: the teacher has removed its devices from the class.');
  await d.call('PATCH', at, { key, body: { door: 'closed' } });
  await own.stop();
  now = await startDaemon({ args: ['--trusted-proxy', '127.0.0.1'], data });
  const e = client(now.url);
  t.after(() => e.close());
  await check(e);
  assert.equal((await join({}, e)).status, 403);
  assert.equal((await e.get(at)).json.state.door, 'closed');
  assert.equal((await join({ headers: from('203.0.113.8') }, e)).json.detail, 'door: closed; the teacher can open it.');
  assert.equal((await e.call('PATCH', at, { key, body: { door: 'open' } })).status, 200);
  const next = await join({ headers: from('203.0.113.8') }, e);
  assert.deepEqual([next.status, next.json.number], [201, 3], 'numbers are not given twice');
});
