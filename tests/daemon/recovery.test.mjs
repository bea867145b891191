// kill -9 at twenty random moments under load, on one and the same data. After each restart every acknowledged command is in its session's
// log, the clock stands or runs as it was told, and the states have the hashes that were read before.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { client, pause } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

/** A daemon that ends with the test, however that ends. */
const start = async (t, wish) => {
  const daemon = await startDaemon(wish);
  t.after(() => daemon.stop());
  return daemon;
};

const ROUNDS = 20, SESSIONS = 6;
const ARGS = ['--max-commands-per-s', '10000', '--max-new-sessions-per-min', '10000'];

let seed = Number(process.env.LAGLAB_TEST_SEED ?? Date.now() % 1e6);
const random = () => {
  seed = (seed * 1103515245 + 12345) % 2147483648;
  return seed / 2147483648;
};
const pick = (list) => list[Math.floor(random() * list.length)];
const whole = (low, high) => low + Math.floor(random() * (high - low + 1));

/** What is known of a session, by acknowledgements only. */
class Known {
  commands = []; // {tick, match}: lines that the log must hold
  hashes = []; // {tick, hash}
  tick = 0; // the last that was told
  status = 'paused';
  pending = null; // what was asked and not answered: it may have happened or not

  constructor(session) {
    this.session = session;
  }

  /** A change at `tick` was acknowledged: it undid what was later. */
  changed(tick, match) {
    this.commands = this.commands.filter((each) => each.tick <= tick);
    this.hashes = this.hashes.filter((each) => each.tick < tick);
    if (match) this.commands.push({ tick, match });
    this.tick = tick;
  }

  saw(tick, hash) {
    this.tick = tick;
    this.hashes.push({ tick, hash });
  }
}

const acts = {
  async patch(c, known) {
    const name = `players.${whole(0, 1)}.lag_ms`, value = whole(0, 500);
    const answer = await c.patch(known.session, { [name]: value });
    assert.equal(answer.status, 200, answer.text);
    known.changed(answer.json.tick, (line) => line.op === 'set' && line.values[name] === value);
  },
  async control(c, known) {
    const forth = [{ op: 'pause' }, { op: 'play' }, { op: 'play' }, { op: 'step', ticks: whole(1, 40) }, { op: 'speed', speed: pick([0.5, 1, 4]) }];
    const back = [{ op: 'step', ticks: -whole(1, 20) }, { op: 'seek', tick: Math.max(0, known.tick - whole(0, 100)) }];
    const op = random() < 0.1 ? pick(back) : pick(forth); // a change after going back undoes what was later
    const { status, json, text } = await c.control(known.session, op);
    assert.equal(status, 200, text);
    known.saw(json.tick, json.hash);
    known.status = json.status;
  },
  async input(c, known) {
    const body = { player: 0, axes: [whole(-8, 8) / 8, 0], buttons: 0 };
    const answer = await c.call('POST', known.session.links.input, { key: pick([known.session.owner_key, known.session.player_keys[0]]), body });
    assert.equal(answer.status, 200, answer.text);
    known.changed(answer.json.tick); // a repeated input needs no line
  },
  async read(c, known) {
    const { json } = await c.get(known.session.links.state);
    known.saw(json.tick, json.hash);
  },
};

async function load(c, known, told) {
  const calm = random() < 0.5; // the others send as fast as they are answered
  for (;;) {
    if (calm) await pause(whole(0, 20));
    const name = pick(calm ? ['patch', 'control', 'input', 'read', 'read'] : ['patch', 'patch', 'control', 'input', 'input', 'read']);
    known.pending = name;
    try {
      await acts[name](c, known);
    } catch (error) {
      if (error.code === 'ERR_ASSERTION') throw error;
      return; // the daemon was killed
    }
    known.pending = null;
    told.count++;
  }
}

async function verify(c, known, told) {
  const { session } = known;
  const { json: now, status } = await c.get(session.links.self);
  assert.equal(status, 200, 'an acknowledged session is there');
  const uncertain = known.pending === 'patch' || known.pending === 'input';
  if (known.pending !== 'control' && now.status !== 'ended') assert.equal(now.status, known.status === 'ended' ? 'paused' : known.status);
  if (!known.pending && known.status === 'paused') assert.equal(now.tick, known.tick);
  if (uncertain) { // the last change may have happened at its tick or later: what it may have undone is no longer known
    known.commands = known.commands.filter((each) => each.tick <= known.tick);
    known.hashes = known.hashes.filter((each) => each.tick < known.tick);
  }
  const lines = (await c.get(session.links.log)).text.trimEnd().split('\n').map((line) => JSON.parse(line));
  for (const { tick, match } of known.commands) {
    assert.ok(lines.some((line) => line.tick === tick && match(line)), `the command of tick ${tick} is lost`);
    told.commands++;
  }
  await c.control(session, { op: 'pause' });
  let head = now.head_tick;
  for (const { tick, hash } of known.hashes.sort((a, b) => a.tick - b.tick)) {
    if (tick > head) {
      const { json } = await c.control(session, { op: 'seek', tick });
      head = tick;
      assert.equal(json.hash, hash, `hash of tick ${tick} beyond the stored head`);
    } else {
      assert.equal((await c.get(`${session.links.state}?tick=${tick}`)).json.hash, hash, `hash of tick ${tick}`);
    }
    told.hashes++;
  }
  const { json } = await c.control(session, { op: 'seek', tick: Math.max(head, now.head_tick) });
  known.pending = null;
  known.status = json.status;
  known.tick = json.tick;
}

test(`kill -9 at ${ROUNDS} random moments under load`, { timeout: 300000 }, async (t) => {
  t.diagnostic(`LAGLAB_TEST_SEED=${seed}`);
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-test-'));
  const all = [], told = { count: 0, commands: 0, hashes: 0 };
  try {
    for (let round = 0; round <= ROUNDS; round++) {
      const begun = performance.now();
      const daemon = await start(t, { data, args: ARGS });
      if (round === ROUNDS) t.diagnostic(`restart with ${all.length} sessions in ${Math.round(performance.now() - begun)} ms`);
      const c = client(daemon.url);
      for (const known of all) await verify(c, known, told);
      if (round === ROUNDS) {
        c.close();
        assert.deepEqual(await daemon.stop(), { code: 0, signal: null });
        break;
      }
      for (let i = all.length < SESSIONS ? 2 : 0; i > 0; i--) {
        const known = new Known(await c.make({ set: { 'players.0.control': 'person', duration_s: 600 }, seed: whole(1, 1000) }));
        known.status = 'playing';
        all.push(known);
      }
      const viewers = await Promise.all(all.slice(-3).map((known) => c.stream(known.session, 'bin', { ack: true })));
      const loads = all.map((known) => load(c, known, told));
      await pause(whole(20, 600));
      await daemon.kill();
      await Promise.all(loads);
      c.close();
      for (const viewer of viewers) viewer.socket.terminate();
    }
  } finally {
    rmSync(data, { recursive: true, force: true });
  }
  t.diagnostic(`${told.count} acknowledged, of which after restarts ${told.commands} commands and ${told.hashes} hashes were found again`);
  assert.ok(told.commands > 500 && told.hashes > 200);
});

test('a clean stop keeps the tick of a paused session and the play of a playing one', async (t) => {
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-test-'));
  try {
    let daemon = await start(t, { data }), c = client(daemon.url);
    const paused = await c.make({ paused: true }), playing = await c.make({ speed: 2 });
    const { json: at } = await c.control(paused, { op: 'seek', tick: 123 });
    await c.control(paused, { op: 'seek', tick: 45 });
    await pause(300);
    const { json: before } = await c.get(playing.links.self);
    c.close();
    await daemon.stop();
    daemon = await start(t, { data });
    c = client(daemon.url);
    const { json: one } = await c.get(paused.links.self), { json: two } = await c.get(playing.links.self);
    assert.deepEqual([one.status, one.tick, one.head_tick], ['paused', 45, 123]);
    assert.equal((await c.get(`${paused.links.state}?tick=123`)).json.hash, at.hash);
    assert.deepEqual([two.status, two.speed], ['playing', 2]);
    assert.ok(two.tick >= before.tick, 'it went on');
    assert.equal((await c.get(`/api/v1/codes/${paused.code}`)).json.id, paused.id);
    c.close();
    await daemon.stop();
  } finally {
    rmSync(data, { recursive: true, force: true });
  }
});
