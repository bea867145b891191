// Disks that fail while a daemon writes: full, read-only, standing still, and well again, at random moments, with kill -9 or SIGTERM at
// another. What is known comes from answers only: what was acknowledged must be there after the restart, what was refused with 507 must
// not, and what was not answered may be.
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client, pause, waitFor } from './client.mjs';
import { startDaemon } from './daemon.mjs';

const C = '/api/v1/classes',
  S = '/api/v1/sessions',
  X = '/api/v1/experiments',
  MIB = 1 << 20,
  DISK_MIB = 24,
  CHOICES = 8;
const ARGS = [
  ...['--max-commands-per-s', '10000', '--max-new-sessions-per-min', '100000', '--max-classes', '5000', '--max-client-classes', '5000'],
  ...['--max-experiments', '5000', '--max-client-experiments', '5000', '--max-class-members', '500'],
];
const ORDER = { scenario: 'race', set: { duration_s: 0.1 }, repeats: 4, metrics: ['players.0.own_lead_m.mean'] };

const run = (/** @type {string} */ command, /** @type {string[]} */ ...args) => execFileSync(command, args, { stdio: 'pipe' });

/** A file system of its own, in a file. Throws where none can be mounted. */
export function makeDisk() {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-disk-')),
    image = path.join(folder, 'image'),
    at = path.join(folder, 'at'),
    data = path.join(at, 'data'),
    filler = path.join(at, 'filler');
  mkdirSync(at);
  run('truncate', '-s', `${DISK_MIB * MIB}`, image);
  run('mkfs.ext4', '-q', '-m', '0', image);
  run('mount', '-o', 'loop', image, at);
  mkdirSync(data);
  /* Not the memory that SQLite shares: a mapped page that may not be written ends a process with SIGBUS. */
  const files = () =>
      readdirSync(data)
        .filter((name) => !name.endsWith('-shm'))
        .map((name) => path.join(data, name)),
    frozen = (/** @type {string} */ how) => run('fsfreeze', how, at);
  /** How a disk fails, and is well again. */
  const faults = {
    full: {
      spoil() {
        try {
          writeFileSync(filler, Buffer.alloc(DISK_MIB * MIB));
        } catch (error) {
          if (error.code !== 'ENOSPC') throw error;
        }
      },
      mend: () => rmSync(filler, { force: true }),
    },
    'read-only': { spoil: () => run('chattr', '+i', ...files()), mend: () => run('chattr', '-i', ...files()) },
    /* As long as no file is open. */
    sealed: { spoil: () => run('mount', '-o', 'remount,ro', at), mend: () => run('mount', '-o', 'remount,rw', at) },
    slow: { spoil: () => frozen('-f'), mend: () => frozen('-u') },
  };
  return {
    data,
    faults,
    remove() {
      run('umount', '-l', at);
      rmSync(folder, { recursive: true, force: true });
    },
  };
}

/** A value that one writer sets, as far as the answers say. */
class Known {
  sure;
  open = /** @type {any[]} */ ([]); // asked and not answered: either may be
  constructor(value) {
    this.sure = value;
  }
  may(value) {
    return [this.sure, ...this.open].some((each) => JSON.stringify(each) === JSON.stringify(value));
  }
  /** Asks for a change to `value`. @returns {Promise<any>} the answer; undefined: there was none */
  async set(value, told, ask) {
    this.open.push(value);
    let answer;
    try {
      answer = await ask();
    } catch {
      return undefined;
    }
    if (answer.status < 300) {
      told.acknowledged++;
      this.sure = value;
      this.open = [];
    } else {
      // A command that was on its way when the store began to fail is stored later if the daemon goes on: docs/api.md.
      const on_its_way = answer.status === 507 && /^(Command|Session) not stored/.test(answer.json.detail);
      told.refused += answer.status === 507 ? 1 : 0;
      if (!on_its_way) this.open.pop();
      if (answer.status >= 500 && answer.status !== 507 && answer.status !== 503)
        told.findings.push(`${answer.status} ${answer.text.slice(0, 200)}`);
    }
    return answer;
  }
}

/**
 * `trials` of them on one disk. `told` is added to.
 * @param {{trials: number, seed: number, told: ReturnType<typeof nothing>}} wish
 */
export async function failingDisk({ trials, seed, told }) {
  let state = seed * 7919 + 1;
  const random = () => {
    state = (state * 1103515245 + 12345) % 2147483648;
    return state / 2147483648;
  };
  const pick = (list) => list[Math.floor(random() * list.length)];
  const whole = (low, high) => low + Math.floor(random() * (high - low + 1));
  const disk = makeDisk();
  let unique = 0,
    daemon = /** @type {any} */ (null),
    c = /** @type {any} */ (null),
    over = false;
  const begin = async () => {
    daemon = await startDaemon({ data: disk.data, args: ARGS });
    c = client(daemon.url);
  };
  /** What may be read again: a path, a key, how the answer is a value, and what it is. */
  const all = /** @type {{name: string, known: Known, read: () => Promise<any>}[]} */ ([]);
  const watch = (name, value, read) => {
    const known = new Known(value);
    all.push({ name, known, read });
    return known;
  };
  const there = (address) => async () => (await c.get(address)).status === 200;

  // ---- the things that writers change ----

  async function makeSession() {
    const session = await c.make({ paused: true });
    const self = session.links.self;
    return {
      key: session.owner_key,
      self,
      lag: watch('session', 150, async () => (await c.get(self)).json.params?.players[0].lag_ms),
      lines: /** @type {number[]} */ ([]),
    };
  }
  async function makeClass() {
    const made = (await c.call('POST', C)).json,
      at = `${C}/${made.id}`,
      key = made.teacher_key;
    for (const body of [{ phase: 'predict', lesson: 'late_answer', step: 0, choices: CHOICES }])
      if ((await c.call('PATCH', at, { key, body })).status !== 200) throw new Error('no class');
    await c.call('PUT', `${at}/board`, { key, body: { scenario: 'race' } });
    const { state: first } = (await c.get(at)).json;
    return {
      at,
      key,
      stop: watch('class', 0, async () => (await c.get(at)).json.state?.stop_tick),
      board: watch('board', first.board, async () => (await c.get(at)).json.state?.board),
    };
  }
  const noMember = 'none';
  async function makeMember(room) {
    const { status: joined, json: answer } = await c.call('POST', `${room.at}/members`, { body: { role: 'watch' } });
    if (joined !== 201) throw new Error(`no member: ${joined}`);
    const { token } = answer;
    const read = async () => {
      const { status, json } = await c.call('GET', `${room.at}/member`, { key: token });
      return status === 200 ? [json.role, json.choice] : noMember;
    };
    return { room, token, known: watch('member', ['watch', null], read) };
  }

  // ---- writers: each asks for one change after the other, until the daemon has gone ----

  const writers = {
    async commands(it) {
      const value = (unique = (unique + 1) % 90000) / 100;
      const wish = { key: it.key, body: { 'players.0.lag_ms': value } };
      const answer = await it.lag.set(value, told, () => c.call('PATCH', `${it.self}/params`, wish));
      if (answer?.status === 200) it.lines.push(value);
      return answer;
    },
    async teacher(room) {
      if (random() < 0.2) {
        const wish = { key: room.key, body: { scenario: 'race', set: { duration_s: whole(1, 90) } } };
        room.board.open.push('another');
        const answer = await c.call('PUT', `${room.at}/board`, wish).catch(() => undefined);
        if (!answer) {
          room.board.any = true; // its id is not known
          return undefined;
        }
        room.board.open.pop();
        told[answer.status === 200 ? 'acknowledged' : 'refused']++;
        if (answer.status === 200) room.board.sure = answer.json.id;
        return answer;
      }
      const value = ++unique;
      return room.stop.set(value, told, () => c.call('PATCH', room.at, { key: room.key, body: { stop_tick: value } }));
    },
    async pupil(member) {
      const wish = (body) => ({ key: member.token, body }),
        [role] = member.known.sure;
      if (random() < 0.8) {
        const choice = whole(0, CHOICES - 1);
        return member.known.set([role, choice], told, () => c.call('PUT', `${member.room.at}/vote`, wish({ step: 0, choice })));
      }
      const answer = await member.known.set(noMember, told, () => c.call('DELETE', `${member.room.at}/member`, wish()));
      if (answer?.status === 204) Object.assign(member, await makeMember(member.room).catch(() => ({ gone: true })));
      return member.gone ? undefined : answer;
    },
    /** Makes one of a kind and deletes the one before. */
    async churn(it) {
      if (it.last) {
        const { known, self, key } = it.last;
        it.last = null;
        return known.set(false, told, () => c.call('DELETE', self, { key }));
      }
      const [where, body, name] = pick([
        [S, { scenario: 'race', paused: true }, 'owner_key'],
        [C, {}, 'teacher_key'],
        [X, ORDER, 'owner_key'],
      ]);
      const answer = await c.call('POST', where, { body }).catch(() => undefined);
      if (!answer) return undefined;
      told[answer.status < 300 ? 'acknowledged' : 'refused']++;
      if (answer.status < 300) {
        const self = answer.json.links.self;
        it.last = { self, key: answer.json[name], known: watch(`made ${where}`, true, there(self)) };
      }
      return answer;
    },
  };
  async function work(writer, it) {
    while (!over) {
      const answer = await writer(it).catch(() => undefined);
      if (!answer) return;
      await pause(answer.status === 507 || answer.status === 429 ? whole(5, 30) : whole(0, 8));
    }
  }

  async function verify(session, where) {
    for (const one of [...all]) {
      const value = await one.read().catch((error) => String(error));
      told.looked_for++;
      const known = /** @type {any} */ (one.known);
      if (!known.may(value) && !(known.any && one.name === 'board')) {
        told.lost++;
        const could_be = [known.sure, ...known.open].map((each) => JSON.stringify(each));
        told.findings.push(`seed ${seed}, ${where}: ${one.name} is ${JSON.stringify(value)}, not ${could_be.join(' or ')}`);
      }
      known.sure = value;
      known.open = [];
      known.any = false;
      if (value === false || value === noMember) all.splice(all.indexOf(one), 1);
    }
    const log = (await c.get(`${session.self}/log`)).text;
    for (const value of session.lines.splice(0)) {
      told.looked_for++;
      if (log.includes(`"players.0.lag_ms":${value}`)) continue;
      told.lost++;
      told.findings.push(`seed ${seed}, ${where}: the log has no ${value}`);
    }
  }

  try {
    await begin();
    const session = await makeSession(),
      room = await makeClass(),
      pupils = [await makeMember(room), await makeMember(room), await makeMember(room)],
      makers = [{ last: null }, { last: null }];
    for (let trial = 0; trial < trials; trial++) {
      const kind = /** @type {'full' | 'read-only' | 'slow'} */ (pick(['full', 'read-only', 'slow'])),
        fault = disk.faults[kind],
        end = pick(['kill', 'stop']),
        where = `trial ${trial} (${kind}, ${end})`;
      over = false;
      for (const pupil of pupils)
        if (pupil.gone || pupil.known.sure === noMember || !all.some((one) => one.known === pupil.known))
          Object.assign(pupil, { gone: false }, await makeMember(room));
      const writing = [
        work(writers.commands, session),
        work(writers.teacher, room),
        ...pupils.map((pupil) => work(writers.pupil, pupil)),
        ...makers.map((maker) => work(writers.churn, maker)),
      ];
      await pause(whole(10, 150));
      fault.spoil();
      await pause(whole(0, 300));
      const first = kind === 'slow' || random() < 0.3; // mended before the end, perhaps so long that the store works again
      if (first && random() < 0.7) {
        fault.mend();
        await pause(pick([0, 50, 1200]));
      }
      const ending = daemon[end]();
      if (kind === 'slow') {
        await pause(whole(0, 60));
        try {
          fault.mend();
        } catch {
          // it stood still no longer
        }
      }
      const how = await ending;
      over = true;
      await Promise.all(writing);
      c.close();
      told.trials++;
      told[kind === 'full' ? 'full' : kind === 'slow' ? 'slow' : 'read_only']++;
      told[end === 'kill' ? 'kills' : 'stops']++;
      if (end === 'stop' && how.code !== 0 && !(how.code === 1 && kind !== 'slow'))
        told.findings.push(`seed ${seed}, ${where}: it ended with ${how.code ?? how.signal}: ${daemon.errors().slice(-700)}`);
      const late = kind !== 'slow' && random() < 0.5; // it starts on the disk that fails
      if ((!late && kind !== 'slow') || kind === 'read-only') fault.mend();
      const second = kind === 'read-only' ? disk.faults.sealed : fault;
      if (late && kind === 'read-only') second.spoil();
      await begin();
      await verify(session, `${where}${late ? ', started on it' : ''}`);
      if (late) {
        second.mend();
        const again = async () => (await writers.commands(session))?.status === 200;
        await waitFor(again, 'the store to work again');
      }
    }
    c.close();
    const { code } = await daemon.stop();
    if (code !== 0) told.findings.push(`seed ${seed}: the last end was with ${code}`);
  } finally {
    await daemon?.kill();
    for (const each of ['full', 'slow', 'sealed', 'read-only']) {
      try {
        disk.faults[each].mend();
      } catch {
        // it was well
      }
    }
    disk.remove();
  }
}

export const nothing = () => ({
  trials: 0,
  full: 0,
  read_only: 0,
  slow: 0,
  kills: 0,
  stops: 0,
  acknowledged: 0,
  refused: 0,
  looked_for: 0,
  lost: 0,
  findings: /** @type {string[]} */ ([]),
});
