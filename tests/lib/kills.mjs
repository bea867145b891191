// kill -9 at random moments under load, again and again on the same data. What is known of a session comes from acknowledgements only;
// after each restart it is compared with the daemon's: commands in the log, clocks, states by their hashes, and what was deleted.
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client, pause } from './client.mjs';
import { startDaemon } from './daemon.mjs';

const ARGS = ['--max-commands-per-s', '10000', '--max-new-sessions-per-min', '10000'];

/** Acknowledged state of a session. */
class Known {
  commands = []; // {tick, match}: lines that the log must hold
  hashes = []; // {tick, hash}
  tick = 0; // last acknowledged tick
  status = 'playing';
  pending = null; // what was asked and not answered: it may have happened or not
  gone = false; // its deletion was acknowledged

  constructor(session) {
    this.session = session;
  }

  /** A change at `tick` was acknowledged: it dropped all later ones. */
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

/** An unexpected answer that is not due to a crash ends the chain. */
class Surprise extends Error {}

const expect = (answer, status) => {
  if (answer.status !== status) throw new Surprise(`${answer.status} instead of ${status}: ${answer.text.slice(0, 300)}`);
  return answer;
};

/**
 * A chain of kills on one folder of data. `told` is added to: kills, sessions, acknowledged answers, commands and hashes found again,
 * deleted sessions that stayed away; and of what must not be: lost, resurrected, differ, each with a sentence in `findings`.
 * @param {{kills: number, sessions?: number, seed: number, told: ReturnType<typeof nothing>, before?: string[]}} wish
 */
export async function chain({ kills, sessions = 6, seed, told, before }) {
  let state = seed;
  const random = () => {
    state = (state * 1103515245 + 12345) % 2147483648;
    return state / 2147483648;
  };
  const pick = (list) => list[Math.floor(random() * list.length)];
  const whole = (low, high) => low + Math.floor(random() * (high - low + 1));
  const data = mkdtempSync(path.join(tmpdir(), 'laglab-kills-'));
  const found = (/** @type {'lost' | 'resurrected' | 'differ'} */ kind, text) => {
    told[kind]++;
    told.findings.push(`seed ${seed}: ${text}`);
  };

  const acts = {
    async patch(c, known) {
      const name = `players.${whole(0, 1)}.lag_ms`,
        value = whole(0, 500);
      const answer = expect(await c.patch(known.session, { [name]: value }), 200);
      known.changed(answer.json.tick, (line) => line.op === 'set' && line.values[name] === value);
    },
    async control(c, known) {
      const forth = [
        { op: 'pause' },
        { op: 'play' },
        { op: 'play' },
        { op: 'step', ticks: whole(1, 40) },
        { op: 'speed', speed: pick([0.5, 1, 4]) },
      ];
      const back = [
        { op: 'step', ticks: -whole(1, 20) },
        { op: 'seek', tick: Math.max(0, known.tick - whole(0, 100)) },
      ];
      const op = random() < 0.1 ? pick(back) : pick(forth); // a change after going back undoes what was later
      const { json } = expect(await c.control(known.session, op), 200);
      known.saw(json.tick, json.hash);
      known.status = json.status;
    },
    async input(c, known) {
      const body = { player: 0, axes: [whole(-8, 8) / 8, 0], buttons: 0 };
      const answer = expect(
        await c.call('POST', known.session.links.input, { key: pick([known.session.owner_key, known.session.player_keys[0]]), body }),
        200,
      );
      known.changed(answer.json.tick); // a repeated input needs no line
    },
    async read(c, known) {
      const { json } = expect(await c.get(known.session.links.state), 200);
      known.saw(json.tick, json.hash);
    },
    async remove(c, known) {
      expect(await c.call('DELETE', known.session.links.self, { key: known.session.owner_key }), 204);
      known.gone = true;
    },
  };

  async function load(c, known) {
    const calm = random() < 0.5,
      leaves = random() < 0.1 ? whole(1, 60) : Infinity; // the others send as fast as they are answered
    for (let i = 0; !known.gone; i++) {
      if (calm) await pause(whole(0, 20));
      const name =
        i >= leaves
          ? 'remove'
          : pick(calm ? ['patch', 'control', 'input', 'read', 'read'] : ['patch', 'patch', 'control', 'input', 'input', 'read']);
      known.pending = name;
      try {
        await acts[name](c, known);
      } catch (error) {
        if (error instanceof Surprise) throw error;
        return; // the daemon was killed
      }
      known.pending = null;
      told.acknowledged++;
    }
  }

  /** @returns {Promise<boolean>} whether the session goes on */
  async function verify(c, known) {
    const { session } = known,
      self = await c.get(session.links.self);
    if (known.gone) {
      if (self.status !== 404) found('resurrected', `session ${session.id} was deleted and answers ${self.status}`);
      told.stayed_away++;
      return true; // is looked for again after the next kill
    }
    if (self.status === 404 && known.pending === 'remove') {
      // it was deleted, without an acknowledgement
      known.gone = true;
      known.pending = null;
      return true;
    }
    if (self.status !== 200) {
      found('lost', `session ${session.id} was acknowledged and answers ${self.status}`);
      return false;
    }
    const now = self.json,
      uncertain = known.pending === 'patch' || known.pending === 'input';
    if (known.pending !== 'control' && now.status !== 'ended' && now.status !== (known.status === 'ended' ? 'paused' : known.status))
      found('lost', `session ${session.id} is ${now.status}, not ${known.status}`);
    if (!known.pending && known.status === 'paused' && now.tick !== known.tick)
      found('lost', `session ${session.id} paused at tick ${known.tick} is at ${now.tick}`);
    if (uncertain) {
      // the last change may have happened at its tick or later: what it may have undone is no longer known
      known.commands = known.commands.filter((each) => each.tick <= known.tick);
      known.hashes = known.hashes.filter((each) => each.tick < known.tick);
    }
    const lines = (await c.get(session.links.log)).text
      .trimEnd()
      .split('\n')
      .map((line) => JSON.parse(line));
    for (const { tick, match } of known.commands) {
      if (!lines.some((line) => line.tick === tick && match(line))) found('lost', `session ${session.id}: the command of tick ${tick}`);
      told.commands++;
    }
    await c.control(session, { op: 'pause' });
    let head = now.head_tick;
    const by_tick = new Map(known.hashes.map((each) => [each.tick, each.hash]));
    for (const [tick, hash] of [...by_tick].sort(([a], [b]) => a - b)) {
      const beyond = tick > head;
      const got = beyond
        ? (await c.control(session, { op: 'seek', tick })).json.hash
        : (await c.get(`${session.links.state}?tick=${tick}`)).json.hash;
      if (beyond) head = tick;
      if (got !== hash) found('differ', `session ${session.id}: tick ${tick} has ${got}, not ${hash}`);
      told.hashes++;
    }
    known.hashes = [...by_tick].slice(-20).map(([tick, hash]) => ({ tick, hash })); // the newest are looked for again
    const { json } = await c.control(session, { op: 'seek', tick: Math.max(head, now.head_tick) });
    known.pending = null;
    known.status = json.status;
    known.tick = json.tick;
    return true;
  }

  let all = [];
  /** @type {Awaited<ReturnType<typeof startDaemon>> | undefined} */
  let daemon;
  try {
    for (let round = 0; round <= kills; round++) {
      daemon = await startDaemon({ data, args: ARGS, before });
      const c = client(daemon.url),
        kept = [];
      for (const known of all) if (await verify(c, known)) kept.push(known);
      all = kept;
      if (round === kills) {
        c.close();
        const how = await daemon.stop();
        if (how.code !== 0) throw new Surprise(`the daemon ended with ${how.code ?? how.signal}`);
        break;
      }
      const living = () => all.filter((known) => !known.gone);
      for (let i = living().length < sessions ? Math.min(2, sessions - living().length) : 0; i > 0; i--) {
        all.push(new Known(await c.make({ set: { 'players.0.control': 'person', duration_s: 600 }, seed: whole(1, 1000) })));
        told.sessions++;
      }
      const viewers = await Promise.all(
        living()
          .slice(-3)
          .map((known) => c.stream(known.session, 'bin', { ack: true })),
      );
      const loads = living().map((known) => load(c, known));
      await pause(whole(20, 600));
      await daemon.kill();
      told.kills++;
      await Promise.all(loads);
      c.close();
      for (const viewer of viewers) viewer.socket.terminate();
    }
  } finally {
    await daemon?.kill();
    rmSync(data, { recursive: true, force: true });
  }
}

export const nothing = () => ({
  kills: 0,
  sessions: 0,
  acknowledged: 0,
  commands: 0,
  hashes: 0,
  stayed_away: 0,
  lost: 0,
  resurrected: 0,
  differ: 0,
  findings: /** @type {string[]} */ ([]),
});
