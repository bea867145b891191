// Who may do what: every kind of key by every operation, from access_matrix.csv. A line has an operation, what it is tried on, who may
// create meanwhile (open, class, operator), and the keys that permit it (`everybody -removed`: any or none but this); without a key all
// others get 401 (none=403: 403), with another key 403.
// A new operation needs a line, and, if it has a body, one in BODIES.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import YAML from 'yaml';
import { client, openStream, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const V1 = '/api/v1',
  HERE = path.dirname(fileURLToPath(import.meta.url));
const OPERATOR = 'operator-of-this-lab-71',
  NORTH = 'class-north-autumn',
  SOUTH = 'class-south-autumn';
const RACE = { scenario: 'race', set: { 'players.0.control': 'person' }, paused: true };
const SMALL = {
  scenario: 'race',
  set: { duration_s: 1, warmup_s: 0 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 100] }],
  metrics: ['players.0.own_lead_m.mean', 'players.0.bandwidth.down_bytes_per_s'],
};
const LONG = { ...SMALL, repeats: 50000 };
const ADVICE = { experiment: SMALL, max_error: 1 };
const MEASUREMENT = { family: 'contact_solvers', methods: ['xpbd'], duration_s: 0.1 };

/** @type {Record<string, (creation: string) => any>} */
const BODIES = {
  'PUT /api/v1/creation': (creation) => ({ creation }),
  'POST /api/v1/sessions': () => RACE,
  'POST /api/v1/sessions/{id}/fork': () => ({}),
  'PATCH /api/v1/sessions/{id}/params': () => ({ 'players.1.lag_ms': 31 }),
  'POST /api/v1/sessions/{id}/control': () => ({ op: 'pause' }),
  'POST /api/v1/sessions/{id}/input': () => ({ player: 0, axes: [1] }),
  'POST /api/v1/experiments': () => SMALL,
  'POST /api/v1/experiments/{id}/control': () => ({ op: 'resume' }),
  'POST /api/v1/advise': () => ADVICE,
  'POST /api/v1/tradeoffs': () => MEASUREMENT,
  'POST /api/v1/classes': () => ({}),
  'PATCH /api/v1/classes/{id}': () => ({ phase: 'lobby' }),
  'PUT /api/v1/classes/{id}/board': () => ({ scenario: 'race' }),
  'POST /api/v1/classes/{id}/members': () => ({}),
  'PATCH /api/v1/classes/{id}/member': () => ({ role: 'watch' }),
  'PUT /api/v1/classes/{id}/vote': () => ({ step: 0, choice: 1 }),
};

const ROWS = readFileSync(path.join(HERE, 'access_matrix.csv'), 'utf8')
  .trim()
  .split('\n')
  .slice(1)
  .map((line) => {
    const [operation, target, creation, may] = line.split(',');
    return { line, operation, target, creation, may: may.split(' ') };
  });

const folder = mkdtempSync(path.join(tmpdir(), 'laglab-matrix-'));
let daemon, c;
before(async () => {
  const file = (/** @type {string} */ name, /** @type {string} */ text) => {
    writeFileSync(path.join(folder, name), text);
    return path.join(folder, name);
  };
  const args = ['--operator-key-file', file('operator', OPERATOR), '--class-key-file', file('class', `north ${NORTH}\nsouth ${SOUTH}\n`)];
  for (const limit of ['new-sessions-per-min', 'code-lookups-per-min', 'sessions', 'experiments', 'client-experiments'])
    args.push(`--max-${limit}`, '100000');
  for (const limit of ['classes', 'client-classes']) args.push(`--max-${limit}`, '10000');
  daemon = await startDaemon({ args: [...args, '--data', 'memory'] });
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
  rmSync(folder, { recursive: true, force: true });
});

async function made(method, place, body, key = NORTH) {
  const answer = await c.call(method, `${V1}/${place}`, { body, key });
  assert.ok(answer.status < 300, `${method} ${place}: ${answer.text}`);
  return answer.json;
}

/** The connection of the member with a seat. @type {any} */
let held;

// ---- what the operations are tried on; each part is made again after it was changed ----

const PARTS = {
  session: async () => {
    const session = await made('POST', 'sessions', RACE),
      stranger = await made('POST', 'sessions', RACE);
    return {
      session: { id: session.id },
      code: { code: session.code },
      keys: {
        owner: session.owner_key,
        player0: session.player_keys[0],
        player1: session.player_keys[1],
        stranger: stranger.owner_key,
        stranger_player: stranger.player_keys[0],
      },
    };
  },
  class: async () => {
    const [lesson, other] = [await made('POST', 'classes', {}), await made('POST', 'classes', {})];
    const at = `classes/${lesson.id}`;
    const board = await made('PUT', `${at}/board`, { scenario: 'race' }, lesson.teacher_key);
    await waitFor(async () => (await c.get(`${V1}/${at}`)).json.state.seats.length === 2, 'the players');
    const [watcher, seat0, copier, left, removed] = [
      await made('POST', `${at}/members`, {}),
      await made('POST', `${at}/members`, { role: 'play', player: 0 }),
      await made('POST', `${at}/members`, { role: 'copy' }),
      await made('POST', `${at}/members`, {}),
      await made('POST', `${at}/members`, {}),
    ];
    // Who is not heard loses its seat to the script, however long the operations take.
    held?.socket.terminate();
    held = await openStream(daemon.url, at);
    held.say({ auth: seat0.token, id: 1 });
    await held.wait((/** @type {any} */ m) => m.id === 1, 'the seat to be held');
    await made('DELETE', `${at}/member`, undefined, left.token);
    await made('DELETE', `${at}/members/${removed.number}`, undefined, lesson.teacher_key);
    await waitFor(async () => (await c.get(`${V1}/sessions/${board.id}`)).json.params.players[0].control === 'person', 'the seat');
    return {
      class: { id: lesson.id },
      member: { id: lesson.id, number: watcher.number },
      seat: { id: lesson.id, player: 0 },
      board: { id: board.id },
      copy: { id: copier.copy },
      keys: {
        board_owner: board.owner_key,
        teacher: lesson.teacher_key,
        other_teacher: other.teacher_key,
        watcher: watcher.token,
        seat0: seat0.token,
        copier: copier.token,
        copy_owner: copier.copy_key,
        left: left.token,
        removed: removed.token,
        other_member: (await made('POST', `classes/${other.id}/members`, {})).token,
      },
    };
  },
  experiment: async () => {
    const [experiment, other] = [await made('POST', 'experiments', LONG), await made('POST', 'experiments', LONG)];
    for (const { id, owner_key } of [experiment, other]) await made('POST', `experiments/${id}/control`, { op: 'pause' }, owner_key);
    return { experiment: { id: experiment.id, run: 1 }, keys: { experiment: experiment.owner_key, other_experiment: other.owner_key } };
  },
  advice: async () => {
    const { id, owner_key: advice } = await made('POST', 'advise', ADVICE);
    return { advice: { id }, keys: { advice } };
  },
  tradeoff: async () => {
    const { id, owner_key: tradeoff } = await made('POST', 'tradeoffs', MEASUREMENT);
    return { tradeoff: { id }, keys: { tradeoff } };
  },
};

/** Targets that are a part after a change by the teacher. @type {Record<string, [string, (lesson: any) => Promise<any>]>} */
const CHANGED = {
  closed: ['class', ({ at, teacher }) => made('PATCH', at, { door: 'closed' }, teacher)],
  voting: ['class', ({ at, teacher }) => made('PATCH', at, { phase: 'predict', step: 0, choices: 2 }, teacher)],
  frozen_copy: ['copy', ({ at, teacher }) => made('PATCH', at, { frozen: true }, teacher)],
  ended_copy: ['copy', ({ at, teacher }) => made('DELETE', at, undefined, teacher)],
  ended_board: ['board', ({ at, teacher }) => made('DELETE', at, undefined, teacher)],
  old_board: ['board', ({ at, teacher }) => made('PUT', `${at}/board`, { scenario: 'race' }, teacher)],
};

/** @type {Record<string, any>} */
const world = {};
/** Makes what is not there; the values for {names} of a path, and all keys. */
async function prepare(target) {
  const [base, change] = CHANGED[target] ?? [target];
  for (const [name, make] of Object.entries(PARTS)) world[name] ??= await make();
  const part = Object.keys(PARTS).find((name) => world[name][base]);
  if (change && world[part].changed !== target) {
    world[part] = { ...(await PARTS[part]()), changed: target };
    await change({ at: `classes/${world[part].class.id}`, teacher: world[part].keys.teacher });
  }
  if (part && !change && world[part].changed) world[part] = await PARTS[part]();
  const keys = { none: undefined, wrong: 'a-key-of-nobody-here', operator: OPERATOR, north: NORTH, south: SOUTH };
  for (const name of Object.keys(PARTS)) Object.assign(keys, world[name].keys);
  return { part, keys, values: part ? world[part][base] : { id: 'race' } };
}

const inPath = (/** @type {string} */ template, /** @type {any} */ values) => template.replace(/{(\w+)}/g, (_, name) => values[name]);

/** The role that a key gives on a stream, or the status of the refusal. */
async function authenticate(place, key) {
  const stream = await openStream(daemon.url, place.replace(`${V1}/`, '').replace(/\/stream$/, ''), 'json', { subscribe: {} });
  stream.say({ auth: key });
  const { role, status } = await stream.wait((/** @type {any} */ m) => m.role || m.type === 'error', 'the answer');
  await stream.close();
  return role ?? status;
}

/** @returns {Promise<any>} the status, or of AUTH the role */
async function attempt({ operation, target, creation }, values, key) {
  const [method, ...rest] = operation.split(' '),
    place = inPath(rest.at(-1), values);
  if (method === 'AUTH') return { status: await authenticate(place, key ?? '') };
  if (place.endsWith('/stream')) {
    const stream = await openStream(daemon.url, place.replace(`${V1}/`, '').replace(/\/stream$/, ''), 'json', {
      headers: key === undefined ? {} : { authorization: `Bearer ${key}` },
    });
    await stream.close();
    return { status: 200 };
  }
  const headers = target === 'repeat' ? { 'idempotency-key': `repeat-${creation}` } : undefined;
  return c.call(method, place, { key, body: BODIES[operation]?.(creation), headers });
}

const operations = () => {
  const source = readFileSync(path.join(HERE, '../../src/daemon/api/table.c'), 'utf8'),
    found = new Set();
  for (const [, method, prefix, pattern] of source.matchAll(/ROUTE\("(\w+)", (V1 )?"([^"]+)"/g))
    found.add(`${method} ${prefix ? V1 : ''}${pattern.replace('*}', '}')}`);
  assert.equal(found.size, source.match(/\{ROUTE\(|\.handler = ll_/g).length, 'a route of table.c was not read');
  return found;
};

test('each operation of openapi.yaml and each route of table.c has a line in access_matrix.csv', async () => {
  const api = YAML.parse((await c.get(`${V1}/openapi.yaml`)).text);
  const wanted = operations();
  for (const [template, item] of Object.entries(api.paths))
    for (const method of ['get', 'put', 'post', 'delete', 'patch']) if (item[method]) wanted.add(`${method.toUpperCase()} ${template}`);
  const lines = new Set(ROWS.map(({ operation }) => operation));
  for (const operation of wanted)
    assert.ok(lines.has(operation), `access_matrix.csv lacks "${operation},TARGET,class,KEYS": who may call it? Others get 401 or 403.`);
  for (const operation of lines) assert.ok(operation.startsWith('AUTH ') || wanted.has(operation), `${operation} does not exist`);
});

for (const row of ROWS) {
  test(row.line, async () => {
    await made('PUT', 'creation', { creation: row.creation }, OPERATOR);
    const faults = [],
      repeats = {};
    const { keys } = await prepare(row.target);
    for (const name of row.may)
      assert.ok(name.replace('-', '') in keys || ['everybody', 'nobody', 'none=403'].includes(name), `no key is called ${name}`);
    for (const name of Object.keys(keys)) {
      await made('PUT', 'creation', { creation: row.creation === 'open' ? 'open' : 'class' }, OPERATOR); // for what is made again
      const { part, keys: present, values } = await prepare(row.target);
      await made('PUT', 'creation', { creation: row.creation }, OPERATOR);
      const may = (row.may.includes('everybody') && !row.may.includes(`-${name}`)) || row.may.includes(name);
      const answer = await attempt(row, values, present[name]);
      const { status } = answer;
      if (row.operation.startsWith('AUTH ')) {
        const role = row.operation.split(' ')[1];
        if (may !== (status === role)) faults.push(`${name} became ${status}`);
      } else if (may ? status >= 300 : status !== (name === 'none' && !row.may.includes('none=403') ? 401 : 403)) {
        faults.push(`${name} got ${status}: ${answer.text.slice(0, 200)}`);
      } else if (
        status >= 400 &&
        (answer.json.status !== status || (status === 401 && !/^Bearer/.test(answer.headers['www-authenticate'])))
      ) {
        faults.push(`${name}: no problem document or no challenge: ${answer.text.slice(0, 200)}`);
      }
      if (row.target === 'repeat' && may) repeats[name] = answer.json;
      else if (answer.headers?.location) await c.call('DELETE', answer.headers.location, { key: OPERATOR });
      if (status < 300 && part && !/^(GET|AUTH) /.test(row.operation)) delete world[part];
    }
    assert.deepEqual(faults, [], row.line);
    if (row.target === 'repeat') {
      const names = Object.keys(repeats);
      assert.equal(new Set(names.map((name) => repeats[name].owner_key)).size, names.length, 'each key has an answer of its own');
    }
  });
}
