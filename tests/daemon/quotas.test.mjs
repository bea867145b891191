// Limits of one client: bytes of log, forks by their size, large answers, experiments; and which client a proxied request belongs to.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import net from 'node:net';
import { client, pause, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { cpu_s } from '../lib/hostile.mjs';

const S = '/api/v1/sessions',
  E = '/api/v1/experiments';
const SMALL = {
  scenario: 'race',
  set: { duration_s: 1, warmup_s: 0 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 100] }],
  metrics: ['players.0.own_lead_m.mean'],
};

/** @param {string[]} args @param {(s: ReturnType<typeof client>, daemon: any) => Promise<void>} use */
async function withDaemon(args, use, wish = {}) {
  const daemon = await startDaemon({ ...wish, args });
  const s = client(daemon.url);
  try {
    await use(s, daemon);
  } finally {
    s.close();
    await daemon.stop();
  }
}

/** A session whose changes are long lines. */
const WIDE = { scenario: 'race', paused: true, set: { players: Array(16).fill({}) } };

/** Fills a log until a change is refused. */
async function fill(s, session) {
  for (let i = 0; ; i++) {
    const line = { jitter_ms: i % 40, delay_ms: i % 30, loss_pct: i % 20, reorder_pct: i % 10, duplicate_pct: i % 9 };
    const each = { lag_ms: i % 200, link: { up: line, down: line } };
    const answer = await s.patch(session, { players: Object.fromEntries(Array.from({ length: 16 }, (_, k) => [k, each])) });
    if (answer.status !== 200) return answer;
    if (i > 4000) throw new Error('it is never full');
  }
}

test('a full log refuses changes with 507; its clock can still be stopped, and other sessions are not affected', async () => {
  await withDaemon(['--max-log-mib', '1', '--max-commands-per-s', '100000'], async (s) => {
    const session = await s.make(WIDE),
      other = await s.make({ paused: true });
    const refused = await fill(s, session);
    assert.equal(refused.status, 507, refused.text);
    assert.match(refused.json.detail, /Log of this session has 1\.0 MiB.*max_log_mib/);
    const log = await s.get(`${S}/${session.id}/log`);
    assert.ok(log.text.length >= 1 << 20 && log.text.length < (1 << 20) + 20000, `${log.text.length} bytes`);
    assert.equal((await s.control(session, { op: 'play' })).status, 200);
    assert.equal((await s.control(session, { op: 'pause' })).status, 200);
    assert.equal((await s.patch(other, { 'players.0.lag_ms': 9 })).status, 200);
    assert.match((await s.get('/metrics')).text, /laglab_refused_total\{limit="log_mib"\} [1-9]/);
    assert.equal((await s.call('DELETE', `${S}/${session.id}`, { key: session.owner_key })).status, 204);
  });
});

test('the logs of all sessions have a limit; deleting frees bytes, and a restart keeps the count', async () => {
  const args = ['--max-log-mib', '0', '--max-logs-mib', '1', '--max-commands-per-s', '100000'];
  await withDaemon(args, async (s, daemon) => {
    const first = await s.make(WIDE),
      second = await s.make({ paused: true });
    assert.match((await fill(s, first)).json.detail, /Session logs use 1\.0 of 1\.0 MiB/);
    assert.equal((await s.patch(second, { 'players.0.lag_ms': 9 })).status, 507);
    assert.equal((await s.call('POST', S, { body: { scenario: 'race' } })).status, 507);
    const again = await startDaemon({
        data: await (async () => {
          await daemon.kill();
          return daemon.data;
        })(),
        args,
      }),
      r = client(again.url);
    assert.equal((await r.call('POST', S, { body: { scenario: 'race' } })).status, 507, 'stored logs are counted');
    assert.equal((await r.call('DELETE', `${S}/${first.id}`, { key: first.owner_key })).status, 204);
    assert.equal((await r.call('POST', S, { body: { scenario: 'race' } })).status, 201);
    assert.equal((await r.patch(second, { 'players.0.lag_ms': 9 })).status, 200);
    r.close();
    await again.stop();
  });
});

test('each address has a limit of its own; deleting frees bytes', async () => {
  await withDaemon(['--max-client-logs-mib', '1', '--max-commands-per-s', '100000', '--trusted-proxy', '127.0.0.1'], async (s) => {
    const as = (address, method, path, wish = {}) => s.call(method, path, { ...wish, headers: { 'x-forwarded-for': address } });
    const make = async (address, body = { scenario: 'race', paused: true }) => (await as(address, 'POST', S, { body })).json;
    const first = await make('192.0.2.7', WIDE),
      second = await make('192.0.2.7'),
      other = await make('192.0.2.8');
    assert.match((await fill(s, first)).json.detail, /Session logs of this address use 1\.0 of 1\.0 MiB.*max_client_logs_mib/);
    assert.equal((await s.patch(second, { 'players.0.lag_ms': 9 })).status, 507, 'its other session is of the same share');
    assert.equal((await s.control(second, { op: 'play' })).status, 200, 'the clock goes on');
    assert.equal((await as('192.0.2.7', 'POST', S, { body: { scenario: 'race' } })).status, 507);
    assert.equal((await as('192.0.2.7', 'POST', `${S}/${other.id}/fork`)).status, 507);
    assert.equal((await s.patch(other, { 'players.0.lag_ms': 9 })).status, 200);
    assert.equal((await as('192.0.2.8', 'POST', S, { body: { scenario: 'race' } })).status, 201);
    assert.equal((await s.call('DELETE', `${S}/${first.id}`, { key: first.owner_key })).status, 204);
    await waitFor(async () => (await s.patch(second, { 'players.0.lag_ms': 9 })).status === 200, 'room for the second');
  });
});

test('a state so large that its ticks take long is refused before any computation', async () => {
  await withDaemon(['--max-state-mib', '8'], async (s, daemon) => {
    const from = cpu_s(daemon.pid);
    const cavity = (n) => ({ kind: 'fluid', scene: 'cavity', params: { re: 400, n }, duration_s: 1 });
    for (const n of [320, 512]) {
      const made = await s.call('POST', S, { body: { scenario: cavity(n), paused: true } });
      assert.equal(made.status, 400, made.text);
      assert.match(made.json.detail, /scenario: state would have [\d.]+ MiB; must have at most 8 MiB \(max_state_mib\)/);
      const dry = await s.call('POST', `${E}?dry_run=true`, { body: { scenario: cavity(n), metrics: ['cfl'] } });
      assert.equal(dry.status, 400, dry.text);
      assert.match(dry.json.detail, /max_state_mib/);
    }
    assert.ok(cpu_s(daemon.pid) - from < 0.5, 'nothing was computed');
    assert.equal((await s.call('POST', S, { body: { scenario: cavity(64), paused: true } })).status, 201);
  });
});

test('forks count by the size of their log', async () => {
  await withDaemon(['--max-log-mib', '1', '--max-commands-per-s', '100000', '--max-new-sessions-per-min', '24'], async (s) => {
    const session = await s.make(WIDE);
    await fill(s, session);
    const statuses = [];
    for (let i = 0; i < 3; i++) statuses.push((await s.call('POST', `${S}/${session.id}/fork`)).status);
    assert.deepEqual(statuses, [201, 429, 429], 'each is 17 sessions of 24');
  });
});

test('large answers are counted until they are sent; small ones are not limited', async () => {
  await withDaemon(['--max-answers-mib', '1'], async (s, daemon) => {
    const session = await s.make({ set: { duration_s: 600 }, paused: true });
    await s.control(session, { op: 'seek', time_s: 17 });
    const one = (await s.get(`${S}/${session.id}/trace`)).text.length;
    assert.ok(one > 100000 && one < 900000, `${one} bytes`);
    const slow = [];
    for (let i = 0; i * one < 3 << 20; i++) {
      const socket = net.connect(daemon.port, '127.0.0.1');
      socket.pause();
      socket.on('error', () => {});
      socket.write(`GET ${S}/${session.id}/trace HTTP/1.1\r\nHost: localhost\r\n\r\n`);
      slow.push(socket);
    }
    let held = 0;
    for (let i = 0; i < 20; i++) {
      const at = Number(/^laglab_answer_bytes (\d+)$/m.exec((await s.get('/metrics')).text)[1]);
      held = Math.max(held, at);
      assert.ok(at <= 1 << 20, `${at} bytes are held`);
      await pause(50);
    }
    assert.equal((await s.get(`${S}/${session.id}`)).status, 200);
    for (const socket of slow) socket.destroy();
    await waitFor(async () => /^laglab_answer_bytes 0$/m.test((await s.get('/metrics')).text), 'the answers to be gone');
    assert.equal((await s.get(`${S}/${session.id}/trace`)).status, 200);
  });
});

test('limits of experiments per client and of results by size; an endless experiment is cancelled', async () => {
  await withDaemon(['--max-client-experiments', '2', '--max-results-mib', '1', '--experiment-run-ttl-s', '1'], async (s) => {
    const make = async (body = {}) => s.call('POST', E, { body: { ...SMALL, ...body } });
    const big = await make({ repeats: 40000 });
    assert.equal(big.status, 507);
    assert.match(big.json.detail, /max_results_mib/);
    const first = (await make()).json;
    assert.equal((await make()).status, 202);
    const third = await make();
    assert.equal(third.status, 429);
    assert.match(third.json.detail, /Limit of 2 experiments of one address/);
    assert.equal((await s.call('DELETE', `${E}/${first.id}`, { key: first.owner_key })).status, 204);
    const long = (await make({ repeats: 5000, set: { duration_s: 600, warmup_s: 0 } })).json;
    await waitFor(async () => (await s.get(`${E}/${long.id}`)).json.state === 'cancelled', 'the end of the one that runs for too long');
  });
});

test('behind a trusted proxy each client has its own quota; untrusted ones cannot set their address', async () => {
  const order = { body: { scenario: 'race', paused: true } };
  const ask = async (s, forwarded) => (await s.call('POST', S, { ...order, headers: { 'x-forwarded-for': forwarded } })).status;
  await withDaemon(
    ['--trusted-proxy', '127.0.0.1, 10.0.0.0/8', '--max-new-sessions-per-min', '2', '--max-connections-per-ip', '4'],
    async (s, daemon) => {
      for (const who of ['203.0.113.7', '2001:db8:1::5', '198.51.100.9:4711', '[2001:db8:2::1]:80'])
        assert.deepEqual([await ask(s, who), await ask(s, who), await ask(s, who)], [201, 201, 429], who);
      assert.equal(await ask(s, '192.0.2.44, 203.0.113.7'), 429, 'what stands before was written by the client');
      assert.equal(await ask(s, '203.0.113.7, 10.1.2.3'), 429, 'a second proxy that is trusted');
      assert.equal(await ask(s, '10.1.2.3, 203.0.113.8'), 201);
      assert.equal(await ask(s, '2001:db8:1::ffff'), 429, 'addresses of one network of IPv6 are one client');
      const two = await new Promise((resolve) => {
        const socket = net.connect(daemon.port, '127.0.0.1'),
          body = JSON.stringify(order.body);
        let text = '';
        socket.on('data', (more) => {
          text += more;
        });
        socket.on('close', () => resolve(text));
        socket.write(
          [
            `POST ${S} HTTP/1.1`,
            'Host: localhost',
            'X-Forwarded-For: 192.0.2.45',
            'X-Forwarded-For: 203.0.113.7',
            'Content-Type: application/json',
            `Content-Length: ${body.length}`,
            'Connection: close',
            '',
            body,
          ].join('\r\n'),
        );
      });
      assert.match(/** @type {string} */ (two), /^HTTP\/1\.1 429 /, 'of two headers the last counts');
      const open = await Promise.all(
        [...Array(12)].map(
          () =>
            new Promise((resolve) => {
              const socket = net.connect(daemon.port, '127.0.0.1', () => resolve(socket));
            }),
        ),
      );
      assert.equal((await s.get('/healthz')).status, 200, 'a proxy may have more connections than one client');
      for (const socket of open) socket.destroy();
    },
  );
  await withDaemon(['--max-new-sessions-per-min', '2'], async (s) => {
    assert.deepEqual(
      [await ask(s, '203.0.113.1'), await ask(s, '203.0.113.2'), await ask(s, '203.0.113.3')],
      [201, 201, 429],
      'clients cannot declare themselves trusted',
    );
  });
});

test('the rate comes before the body: what is refused counts too, and is not read when the rate is used up', async () => {
  await withDaemon(['--max-new-sessions-per-min', '5'], async (s) => {
    const metrics = ['players.0.remote_error_m.mean'],
      axes = [{ path: 'players.0.lag_ms', from: 0, to: 900, count: 10000 }];
    const refused = async (/** @type {string} */ path, /** @type {any} */ body) => (await s.call('POST', path, { body })).status;
    assert.deepEqual(
      [
        await refused('/api/v1/sessions', '{'),
        await refused('/api/v1/experiments', { scenario: 'race', metrics, axes, repeats: 100000 }),
        await refused('/api/v1/experiments?dry_run=true', { scenario: 'none', metrics }),
        await refused('/api/v1/advise', { max_error: -1 }),
        await refused('/api/v1/tradeoffs', { family: 'none' }),
      ],
      [400, 400, 400, 400, 400],
    );
    for (const path of ['sessions', 'experiments', 'experiments?dry_run=true', 'advise', 'tradeoffs', 'classes']) {
      const answer = await s.call('POST', `/api/v1/${path}`, { body: '{' });
      assert.equal(answer.status, 429, path);
      assert.match(answer.json.detail, /must be at most 5\/min for one address/);
    }
  });
});

test('with too few descriptors fewer connections are accepted, more get a 503; the start says so, with the numbers', async (t) => {
  const limited = async (/** @type {number} */ files, /** @type {number} */ connections) => {
    const before = ['prlimit', `--nofile=${files}:${files}`];
    const daemon = await startDaemon({ before, args: ['--max-connections', String(connections)] });
    t.after(() => daemon.stop());
    return daemon;
  };
  const daemon = await limited(180, 123),
    sockets = Array.from({ length: 200 }, () => net.connect(daemon.port, '127.0.0.1')),
    answers = await Promise.all(
      sockets.map(async (socket) => {
        let text = '';
        socket.on('error', () => {});
        socket.on('data', (part) => {
          text += part;
        });
        socket.write('GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n');
        await waitFor(() => /"ok"\}$|\(max_connections\)/.test(text), 'an answer, of any kind');
        return text.slice(9, 12);
      }),
    );
  assert.equal(answers.filter((status) => status === '200').length, 92);
  assert.equal(answers.filter((status) => status === '503').length, 108);
  sockets[3].destroy();
  await waitFor(async () => (await fetch(new URL('/readyz', daemon.url))).status === 200, 'a free place');
  for (const socket of sockets) socket.destroy();
  assert.match(daemon.errors(), /"warn".*180 descriptors \(ulimit -n\) are too few for 123 .*: 217 are needed\. At most 92 /);
  for (const [files, connections, needed] of [
    [217, 123, 0],
    [216, 123, 217],
    [5183, 4096, 5184],
    [5184, 4096, 0],
  ]) {
    const other = await limited(files, connections);
    await other.stop();
    if (needed) assert.match(other.errors(), new RegExp(`${connections} connections.*: ${needed} are needed`));
    else assert.doesNotMatch(other.errors(), /descriptors/);
  }
});

test('who opens many classes makes little more with them: the n-th has the n-th part of the rate', async () => {
  await withDaemon(['--max-new-sessions-per-min', '12'], async (s) => {
    const made = [];
    for (let n = 1; n <= 6; n++) {
      const opened = await s.call('POST', '/api/v1/classes', { body: {} });
      assert.equal(opened.status, 201, opened.text);
      const show = () =>
        s.call('PUT', `/api/v1/classes/${opened.json.id}/board`, { key: opened.json.teacher_key, body: { scenario: 'race' } });
      let boards = 0,
        answer = await show();
      for (; answer.status === 200 && boards < 50; answer = await show()) boards++;
      assert.match(answer.json.detail, /^boards: must be at most [0-9.]+\/min for one class/);
      made.push(boards);
    }
    // One more of each where a busy machine took seconds.
    for (const [i, boards] of made.entries()) assert.ok(boards >= Math.floor(12 / (i + 1)) && boards <= 12 / (i + 1) + 2, made.join());
  });
});
