// What strangers send. Each is answered by its problem document, and nothing is changed: parameters and log stay the same bytes, no
// session comes or goes, and others are served meanwhile.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import net from 'node:net';
import { client, HANG_MS, openStream, pause, raw, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

let daemon, c, schema;

before(async () => {
  daemon = await startDaemon({
    args: [
      '--max-commands-per-s',
      '100000',
      '--max-new-sessions-per-min', // refused ones count too
      '100000',
      '--head-timeout-s',
      '1',
      '--body-timeout-s',
      '1',
      '--max-connections',
      '600',
      '--max-connections-per-ip',
      '600',
    ],
  });
  c = client(daemon.url);
  schema = (await c.get('/api/v1/schema')).json;
});
after(async () => {
  c.close();
  await daemon.stop();
});

// ---- every parameter of the schema ----

const follow = (node) => (node.$ref ? { ...schema.$defs[node.$ref.split('/').at(-1)], ...node, $ref: undefined } : node);

/** All leaves of both kinds: path, schema, the scenario and choice that they need, and how a value is set: a list of numbers as a whole.
 * What an array has that may be empty needs an element. */
function* allLeaves() {
  const [netgame, motion] = schema.oneOf;
  for (const leaf of leaves(netgame, [])) {
    const choice = leaf.variant ? `"game":"${leaf.variant}",` : leaf.path.startsWith('profiles.') ? '"profiles":[{}],' : undefined;
    yield { ...leaf, scenario: 'race', choice };
  }
  for (const leaf of leaves(motion, [])) {
    const choice = leaf.variant && `"methods":[{"method":"rk4"}],"problem":"${leaf.variant}",`; // it can do every problem
    yield { ...leaf, scenario: 'motion/orbit', choice };
  }
}

function* leaves(node, path, variant) {
  const full = follow(node);
  if (full.properties) {
    for (const [name, child] of Object.entries(full.properties)) {
      if (name !== 'timeline') yield* leaves(child, [...path, name], variant); // the scenarios here have none
    }
  } else if (full.items && full.minItems === 0 && follow(full.items).type === 'number') {
    const at = path.join('.');
    yield { path: at, field: `${at}.0`, leaf: follow(full.items), variant, whole: (value) => `[${value}]` };
  } else if (full.items) {
    yield* leaves(full.items, [...path, '0'], variant);
  } else if (full.anyOf?.[0].$ref) {
    for (const any of full.anyOf) yield* leaves(any, path, any.$ref.split('/').at(-1));
  } else {
    const at = path.join('.');
    yield { path: at, field: at, leaf: full, variant, whole: (value) => value };
  }
}

/** JSON texts that a parameter must refuse. */
function wrongValues(leaf) {
  const other = ['null', '[]', '{}', '[1]', 'NaN', '-Infinity', '1e999', '-1e999'];
  switch (leaf.type) {
    case 'boolean':
      return [...other, '0', '1', '"true"', '-1e308'];
    case 'string':
      return [
        ...other,
        '0',
        'true',
        '1e308',
        JSON.stringify('x'.repeat(5000)),
        '"\\u0007"',
        '"\\ud800"',
        ...(leaf.enum ? ['""', '"no_such_choice"'] : []),
      ];
    default:
      return [
        ...other,
        '"1"',
        '""',
        'true',
        JSON.stringify(leaf.minimum - 1),
        JSON.stringify(leaf.maximum * 2 + 1),
        '1e308',
        '-1e308',
        ...(leaf.type === 'integer' ? [JSON.stringify(leaf.minimum + 0.5)] : []),
      ];
  }
}

const parses = (text) => {
  try {
    JSON.parse(text);
    return !/1e999|ud800/.test(text);
  } catch {
    return false;
  }
};

/** 400, a problem that names field, range and value. */
function refused(answer, field, leaf, value) {
  const what = `${field} = ${value.slice(0, 40)}: ${answer.status} ${answer.text.slice(0, 300)}`;
  assert.equal(answer.status, 400, what);
  assert.equal(answer.headers['content-type'], 'application/problem+json', what);
  if (!parses(value)) return; // no JSON, or beyond its numbers: there may be no field yet
  assert.equal(answer.json.errors?.[0].field, field, what);
  const { detail } = answer.json;
  if (['number', 'integer'].includes(leaf.type) && /^-?[0-9]/.test(value)) {
    const numbers = (detail.match(/-?\d[\d.]*(e[+-]?\d+)?/g) ?? []).map(Number);
    const shown = (number) => numbers.includes(number);
    assert.ok(shown(leaf.minimum) && shown(leaf.maximum), `the range is not named: ${what}`);
  }
  if (leaf.enum && value !== 'null')
    for (const choice of leaf.enum.slice(0, 6)) assert.ok(detail.includes(choice), `the choices are not named: ${what}`);
}

const count = async (who = c) => /^laglab_sessions (\d+)$/m.exec((await who.get('/metrics')).text)[1];

test('every parameter refuses what it must, on creation', async () => {
  const sessions = await count();
  let tried = 0;
  for (const { path, field, leaf, scenario, choice, whole } of allLeaves()) {
    for (const value of wrongValues(leaf)) {
      const body = `{"scenario":"${scenario}","paused":true,"set":{${choice ?? ''}"${path}":${whole(value)}}}`;
      refused(await c.call('POST', '/api/v1/sessions', { body }), field, leaf, value);
      tried++;
    }
  }
  assert.ok(tried > 400, `${tried} values`);
  assert.equal(await count(), sessions);
});

test('every parameter refuses what it must, while a session runs', async () => {
  const made = new Map();
  for (const { path, field, leaf, scenario, choice, whole } of allLeaves()) {
    const key = `${scenario} ${choice}`;
    if (!made.has(key)) {
      const session = await c.make({ scenario, paused: true, set: JSON.parse(`{${(choice ?? '').replace(/,$/, '')}}`) });
      made.set(key, { session, params: (await c.get(session.links.self)).json.params, log: (await c.get(session.links.log)).text });
    }
    const { session } = made.get(key);
    const values = wrongValues(leaf);
    if (!leaf['x-live'] && leaf.default !== undefined) values.push(JSON.stringify(leaf.default));
    for (const value of values) {
      const nested = path
        .split('.')
        .reverse()
        .reduce((inner, name) => `{"${name}":${inner}}`, whole(value));
      for (const body of [`{"${path}":${whole(value)}}`, nested]) {
        const answer = await c.call('PATCH', session.links.params, { key: session.owner_key, body });
        if (leaf['x-live']) assert.equal(answer.status, 400, `${body} ${answer.text}`);
        else assert.ok([400, 409].includes(answer.status), `${body} ${answer.status} ${answer.text}`); // 409: not while it runs
        if (leaf['x-live'] && value !== '{}') refused(answer, field, leaf, value);
      }
    }
  }
  for (const { session, params, log } of made.values()) {
    assert.deepEqual((await c.get(session.links.self)).json.params, params);
    assert.equal((await c.get(session.links.log)).text, log);
  }
});

// ---- bodies ----

/** Runs `attack` and shows that this session, and the number of all, is as before. */
async function unharmed(attack, who = c) {
  const session = await who.make({ paused: true, set: { 'players.0.control': 'person' } });
  const self = session.links.self;
  const state = async () => {
    const { cost, parked, viewers, ...rest } = (await who.get(self)).json;
    return { ...rest, log: (await who.get(session.links.log)).text, hash: (await who.get(session.links.state)).json.hash };
  };
  const earlier = await state(),
    sessions = await count(who);
  await attack(session);
  assert.deepEqual(await state(), earlier);
  assert.equal(await count(who), sessions);
}

test('malformed, truncated, deeply nested and large JSON', () =>
  unharmed(async (session) => {
    const key = session.owner_key;
    const places = [
      ['POST', '/api/v1/sessions', '{"scenario":"race","set":{"players.1.lag_ms":250}}'],
      ['POST', session.links.fork, '{"paused":true}'],
      ['PATCH', session.links.params, '{"players":{"1":{"lag_ms":300}}}'],
      ['POST', session.links.control, '{"op":"step","ticks":1}'],
      ['POST', session.links.input, '{"player":0,"axes":[1,0],"buttons":0}'],
    ];
    for (const [method, path, good] of places) {
      const bad = [
        '[]',
        '""',
        '0',
        'null',
        '{',
        '}',
        '{"a":}',
        '{"a" 1}',
        "{'a':1}",
        '{"a":1,}',
        '{"a":01}',
        '{"a":.5}',
        '{"a":+1}',
        '{"a":"\\x"}',
        '{"a":"\n"}',
        '{"a":1}{"b":2}',
        '{"a":1} x',
        '\ufeff{"a":1}',
        '{"a":Infinity}',
        '\0',
        '{"a":1}\0',
        '<xml/>',
        'a=1',
        '{"__proto__":1}',
        '{"":1}',
        Buffer.from([0x7b, 0x22, 0xff, 0xfe, 0x22, 0x3a, 0x31, 0x7d]),
        `${'['.repeat(100000)}`,
        `${'{"a":'.repeat(40)}1${'}'.repeat(40)}`,
        `{"a":${'['.repeat(40)}${']'.repeat(40)}}`,
        `{"a":"${'x'.repeat((1 << 20) - 8)}"}`,
        `{${'"a":1,'.repeat(140000)}"b":2}`,
        `{"a":${'9'.repeat(1000000)}}`,
      ];
      for (let i = 0; i < good.length; i++) bad.push(good.slice(0, i)); // truncated everywhere
      if (path === session.links.fork) bad.splice(bad.indexOf(''), 1); // its body may be missing
      for (const body of bad) {
        const answer = await c.call(method, path, { key, body });
        const what = `${method} ${path} ${String(body).slice(0, 60)}: ${answer.status} ${answer.text.slice(0, 200)}`;
        assert.equal(answer.status, 400, what);
        assert.ok(answer.json.detail.length > 5, what);
        if (String(body).endsWith('"a":1,"b":2}') && body.length > 100000) assert.match(answer.json.detail, /at most 100000 values/, what);
      }
    }
  }));

/** Inputs, and the field that is wrong. @type {[any, string][]} */
const wrongActions = [
  [{ player: 'x' }, 'player'],
  [{ player: -1 }, 'player'],
  [{ player: 64 }, 'player'],
  [{ player: 1.5 }, 'player'],
  [{ player: 0, axes: [2] }, 'axes'],
  [{ player: 0, axes: [1, 1, 1] }, 'axes'],
  [{ player: 0, axes: ['1'] }, 'axes'],
  [{ player: 0, axes: 1 }, 'axes'],
  [{ player: 0, buttons: -1 }, 'buttons'],
  [{ player: 0, buttons: 0.5 }, 'buttons'],
  [{ player: 0, buttons: 2 ** 32 }, 'buttons'],
  [{ player: 0, more: 1 }, 'more'],
  [{ axes: [1] }, 'player'],
];

test('a wrong input is refused by its field, by POST and on the stream', () =>
  unharmed(async (session) => {
    const stream = await openStream(daemon.url, `sessions/${session.id}`, 'json');
    stream.say({ auth: session.owner_key, id: 0 });
    await stream.wait((message) => message.id === 0);
    for (const [i, [action, field]] of wrongActions.entries()) {
      const what = JSON.stringify(action),
        posted = await c.call('POST', session.links.input, { key: session.owner_key, body: action });
      assert.deepEqual([posted.status, posted.json.errors?.[0].field], [400, field], what);
      assert.ok(new RegExp(`^${field}:? `).test(posted.json.detail), `${what}: ${posted.json.detail}`);
      if (action.player === 64) assert.match(posted.json.detail, /0 to 63/);
      stream.say({ input: action, id: i + 1 });
      const { problem } = await stream.wait((message) => message.type === 'error' && message.id === i + 1, `the error of ${what}`);
      assert.deepEqual([problem.status, problem.errors?.[0].field], [400, `input.${field}`], what);
      await pause(20); // within the rate of messages
    }
    await stream.close();
  }));

test('unknown and wrong members of each body', () =>
  unharmed(async (session) => {
    const key = session.owner_key;
    const tries = {
      '/api/v1/sessions': [
        {},
        { scenario: 7 },
        { scenario: 'no_such' },
        { scenario: '../race' },
        { scenario: null },
        { scenario: 'race', seed: -1 },
        { scenario: 'race', seed: 0.5 },
        { scenario: 'race', seed: 1e300 },
        { scenario: 'race', seed: '1' },
        { scenario: 'race', paused: 1 },
        { scenario: 'race', speed: 0 },
        { scenario: 'race', speed: 11 },
        { scenario: 'race', speed: 'x' },
        { scenario: 'race', set: [] },
        { scenario: 'race', set: { 'players.9.lag_ms': 1 } },
        { scenario: 'race', set: { nonsense: 1 } },
        { scenario: 'race', more: 1 },
        { scenario: { kind: 'netgame' } },
        { scenario: { kind: 'x' } },
        { scenario: {} },
        { scenario: { kind: 'netgame', players: [] } },
        { scenario: { kind: 'netgame', players: [{ lag_ms: 1, nonsense: 2 }] } },
        { scenario: { kind: 'netgame', players: Array(17).fill({}) } },
      ],
      [session.links.fork]: [{ paused: 'x' }, { speed: 100 }, { seed: 1 }],
      [session.links.control]: [
        {},
        { op: 'x' },
        { op: 7 },
        { op: 'step', ticks: 0.5 },
        { op: 'step', ticks: '1' },
        { op: 'seek' },
        { op: 'seek', tick: -1 },
        { op: 'seek', tick: 1e12 },
        { op: 'seek', time_s: 1e6 },
        { op: 'seek', tick: 1, time_s: 1 },
        { op: 'speed', speed: 0 },
        { op: 'speed', speed: 10.5 },
        { op: 'speed', speed: '1' },
        { op: 'restart', reset: 1 },
        { op: 'play', more: 1 },
      ],
      [session.links.input]: [{}, { player: 8 }, ...wrongActions.map(([action]) => action)],
    };
    for (const [path, bodies] of Object.entries(tries)) {
      for (const body of bodies) {
        const answer = await c.call('POST', path, { key, body });
        assert.equal(answer.status, 400, `${path} ${JSON.stringify(body)}: ${answer.text}`);
      }
    }
    for (const query of ['tick=x', 'tick=-1', 'tick=1.5', 'tick=', 'tick=1e99', 'tick=NaN', 'tick=0x10z', 'tick=99999999'])
      assert.equal((await c.get(`${session.links.state}?${query}`)).status, 400, query);
    for (const query of ['from_s=x', 'from_s=-1', 'to_s=NaN', 'from_s=2&to_s=1', 'to_s=1e99'])
      assert.equal((await c.get(`${session.links.trace}?${query}`)).status, 400, query);
  }));

test('a body over the limit, whole or in chunks', () =>
  unharmed(async (session) => {
    const large = `{"a":"${'x'.repeat(3 << 20)}"}`;
    for (const path of ['/api/v1/sessions', session.links.control]) {
      const answer = await c.call('POST', path, { key: session.owner_key, body: large }).catch((error) => error);
      assert.ok(answer.status === 413 || answer.code === 'ECONNRESET' || answer.code === 'EPIPE', `${path}: ${answer.status ?? answer}`);
    }
    const chunk = `10000\r\n${'x'.repeat(0x10000)}\r\n`;
    const { text } = await raw(
      daemon.port,
      `POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n` +
        `Transfer-Encoding: chunked\r\n\r\n${chunk.repeat(40)}0\r\n\r\n`,
      HANG_MS,
      (said) => said.endsWith('}'),
    );
    assert.match(text, /^HTTP\/1.1 413 /);
  }));

// ---- sockets ----

test('half a request line, then silence', () =>
  unharmed(async () => {
    const waiting = ['GET /api', 'GET / HTTP/1.1\r\nHost: loc', 'POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\n', ''].map((bytes) =>
      raw(daemon.port, bytes, HANG_MS),
    );
    await pause(100);
    assert.equal((await c.get('/healthz')).status, 200, 'others are served');
    for (const { text, closed } of await Promise.all(waiting)) {
      assert.ok(closed, 'it is closed');
      assert.match(text, /^(HTTP\/1.1 408 [\s\S]*"status":408[\s\S]*)?$/);
    }
    const slow = await raw(
      daemon.port,
      'POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 100\r\n\r\n{"sc',
      HANG_MS,
    );
    assert.ok(slow.closed, 'half a body is not waited for');
  }));

test('binary junk', () =>
  unharmed(async (session) => {
    let state = 12345;
    const random = () => (state = (state * 1103515245 + 12345) % 2147483648) >> 8;
    const junk = Array.from({ length: 60 }, (_, i) => {
      const bytes = Buffer.from(Array.from({ length: 1 + (random() % 3000) }, () => random() & 255));
      if (i % 3 === 1) bytes.write('GET /');
      if (i % 3 === 2) bytes.write('\x16\x03\x01');
      return bytes;
    });
    for (const { text, closed } of await Promise.all(junk.map((bytes) => raw(daemon.port, bytes, HANG_MS)))) {
      assert.ok(closed);
      assert.match(text, /^(HTTP\/1.1 (400|405|408|431|505) [\s\S]*)?$/);
    }
    // on a stream: an unmasked frame, a huge one, a reserved code, binary messages, an endless text
    for (const bytes of [
      Buffer.from([0x81, 0x02, 0x7b, 0x7d]),
      Buffer.from([0x82, 0xff, 0x7f, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0]),
      Buffer.from([0x83, 0x80, 0, 0, 0, 0]),
      Buffer.from([0xf1, 0x80, 0, 0, 0, 0]),
      Buffer.alloc(4096, 0xff),
    ]) {
      const stream = await c.stream(session);
      const wire = /** @type {any} */ (stream.socket)._socket;
      wire.write(bytes);
      await pause(60);
      await stream.close();
    }
    const stream = await c.stream(session);
    stream.socket.send(Buffer.from([1, 2, 3]));
    stream.say('x'.repeat(200000));
    await waitFor(() => stream.closed, 'the close');
    assert.ok([1003, 1008, 1009].includes(stream.closed.code), String(stream.closed.code));
  }));

test('a WebSocket from a foreign page', () =>
  unharmed(async (session) => {
    for (const origin of [
      'http://elsewhere.example',
      'null',
      'http://localhost.elsewhere.example',
      `http://127.0.0.1:${daemon.port + 1}`,
      'file://',
    ])
      await assert.rejects(openStream(daemon.url, `sessions/${session.id}`, 'json', { origin }), { status: 403 }, origin);
    const own = await openStream(daemon.url, `sessions/${session.id}`, 'json', { origin: daemon.url.replace(/\/$/, '') });
    await own.close();
    await assert.rejects(openStream(daemon.url, `sessions/${'a'.repeat(26)}`), { status: 404 });
  }));

test('1,000 connections at once', async (t) => {
  // With time for all heads to come, on a machine however busy.
  const patient = await startDaemon({ args: ['--head-timeout-s', '60', '--max-connections', '600', '--max-connections-per-ip', '600'] }),
    p = client(patient.url);
  t.after(() => patient.stop());
  t.after(() => p.close());
  await unharmed(async () => {
    const sockets = Array.from({ length: 1000 }, () => net.connect(patient.port, '127.0.0.1'));
    const answers = Array(1000).fill('');
    sockets.forEach((socket, i) => {
      socket
        .setEncoding('latin1')
        .on('data', (text) => {
          answers[i] += text;
        })
        .on('error', () => {});
      socket.write('GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n');
    });
    try {
      await waitFor(() => answers.every((text, i) => text.length > 0 || sockets[i].destroyed), 'all answers');
    } finally {
      sockets.forEach((socket) => socket.destroy());
    }
    const of = (status) => answers.filter((text) => text.startsWith(`HTTP/1.1 ${status} `)).length;
    assert.ok(of(200) >= 550, `${of(200)} were served`);
    assert.ok(of(429) + of(503) >= 350, `${of(429) + of(503)} were refused with an answer`);
    for (const text of answers.filter((each) => /^HTTP\/1.1 (429|503) /.test(each))) {
      assert.match(text, /Retry-After: \d+/i);
      assert.match(text, /application\/problem\+json/);
    }
    await waitFor(async () => (await p.get('/healthz')).status === 200, 'a free place');
  }, p);
});

test('values that a session is made with settle what depends on them, as those of an experiment do', async () => {
  for (const [set, wanted] of [
    [{ 'players.0.prediction': false }, [false, false]],
    [{ 'players.1.reconciliation': true }, [true, true]],
  ]) {
    const made = (await c.call('POST', '/api/v1/sessions', { body: { scenario: 'race', set, paused: true } })).json,
      { players } = (await c.get(`/api/v1/sessions/${made.id}`)).json.params,
      { prediction, reconciliation } = players[Number(Object.keys(set)[0].split('.')[1])];
    assert.deepEqual([prediction, reconciliation], wanted, JSON.stringify(set));
  }
});
