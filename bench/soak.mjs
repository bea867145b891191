// An hour at full load, after which memory and descriptors must be where they were: sessions of every kind come and go with viewers,
// commands, forks, seeks and reads; experiments and searches for advice run and are fetched in every format; clients leave in the middle,
// and send malformed requests. Every ten seconds a line with the resources of the daemon goes into bench/results/soak.csv. Under load that
// depends on the present sessions: so the load pauses now and then until all are deleted, and the lines of these rests (idle 1) show what
// remains.
//   bench/run soak [--quick] [--seconds=3600] [--rest-every=600] [--clients=12]
import { readFileSync, readdirSync, statSync } from 'node:fs';
import { loadavg } from 'node:os';
import { join } from 'node:path';
import net from 'node:net';
import { digits, pause, printTable, say, writeCsv } from './lib.mjs';
import { client } from '../tests/lib/client.mjs';
import { startDaemon } from '../tests/lib/daemon.mjs';
import { cpu_s } from '../tests/lib/hostile.mjs';

const option = (name, standard) => Number(process.argv.find((word) => word.startsWith(`--${name}=`))?.split('=')[1] ?? standard);
const quick = process.argv.includes('--quick'),
  seconds = option('seconds', quick ? 60 : 3600),
  rest_every = option('rest-every', quick ? 30 : 600),
  clients = option('clients', 12),
  every_s = quick ? 2 : 10;
const REST_S = 20;
const GROWTH_MIB_PER_H = 5; // of anonymous memory, from the first rest to the last

// No more than 100 searches at once and 50 experiments kept per client are meant for persons; here one address is all of them.
const daemon = await startDaemon({
  args: [
    '--max-new-sessions-per-min',
    '1000000',
    '--max-commands-per-s',
    '1000000',
    '--max-code-lookups-per-min',
    '1000000',
    '--max-client-experiments',
    '1000000',
    '--park-after-s',
    '2',
  ],
});
const end = performance.now() + seconds * 1000;
let phase_end = 0;
const over = () => performance.now() >= phase_end;
const whole = (low, high) => low + Math.floor(Math.random() * (high - low + 1)),
  pick = (list) => list[whole(0, list.length - 1)];

const statuses = new Map();
let broken = 0; // connections that failed: the load cuts some by itself
const SCENARIOS = [
  'race',
  'eight',
  'cannon',
  'race',
  'lockstep',
  'motion/kepler',
  'rigid/pyramid',
  { kind: 'fluid', scene: 'pool', params: { size: 40 }, duration_s: 60 },
];
const known = new Set(
  await (async () => {
    const c = client(daemon.url),
      list = (await c.get('/api/v1/scenarios')).json;
    c.close();
    return (list.scenarios ?? list).map((s) => s.id);
  })(),
);

/** A class of its own: a session from its making to its end. */
async function session(c) {
  const ask = async (method, path, wish) => {
    const answer = await c.call(method, path, wish);
    statuses.set(answer.status, (statuses.get(answer.status) ?? 0) + 1);
    return answer;
  };
  const scenario = pick(SCENARIOS.filter((s) => typeof s !== 'string' || known.has(s)));
  const made = await ask('POST', '/api/v1/sessions', { body: { scenario, speed: pick([1, 1, 2]) } });
  if (made.status !== 201) return;
  const s = made.json,
    key = s.owner_key,
    viewers = [];
  for (let i = whole(0, 3); i > 0; i--) viewers.push(await c.stream(s, pick(['bin', 'json']), { ack: Math.random() < 0.8 }));
  const until = performance.now() + whole(2, 30) * 1000;
  while (performance.now() < until && !over()) {
    const what = whole(0, 11);
    if (what < 4) await ask('PATCH', s.links.params ?? `${s.links.self}/params`, { key, body: { 'players.0.lag_ms': whole(0, 300) } });
    else if (what === 4)
      await ask('POST', s.links.control, {
        key,
        body: pick([{ op: 'pause' }, { op: 'play' }, { op: 'play' }, { op: 'step', ticks: 5 }, { op: 'seek', time_s: whole(0, 5) }]),
      });
    else if (what === 5) await ask('GET', pick([s.links.state, s.links.metrics, s.links.log, s.links.trace, s.links.self]));
    else if (what === 6) await ask('GET', `/api/v1/codes/${s.code}`);
    else if (what === 7 && viewers.length > 0) pick(viewers).say({ subscribe: { scene: whole(1, 60) }, id: 1 });
    else if (what === 8 && viewers.length > 0) viewers.pop().socket.terminate();
    else if (what === 9) await ask('POST', s.links.control, { key: "nobody's", body: { op: 'pause' } });
    else if (what === 10 && Math.random() < 0.2) {
      const fork = await ask('POST', s.links.fork, { body: {} });
      if (fork.status === 201) await ask('DELETE', fork.json.links.self, { key: fork.json.owner_key });
    } else await ask('GET', pick(['/', '/healthz', '/metrics', '/api/v1/schema', '/nothing', '/api/v1/sessions/none']));
    await pause(whole(0, 40));
  }
  if (Math.random() < 0.5) await Promise.all(viewers.map((viewer) => viewer.close()));
  await ask('DELETE', s.links.self, { key });
  for (const viewer of viewers) viewer.socket.terminate();
}

async function experiment(c) {
  const order = {
    scenario: pick(['race', 'cannon']),
    set: { duration_s: 2 },
    axes: [{ path: 'players.0.lag_ms', values: [0, 50, 100, 200] }],
    repeats: whole(1, 30),
    metrics: ['players.0.own_lead_m.mean', 'players.0.bandwidth.down_bytes_per_s'].slice(Math.random() < 0.5 ? 1 : 0),
  };
  const made = await c.call('POST', '/api/v1/experiments', { body: order });
  statuses.set(made.status, (statuses.get(made.status) ?? 0) + 1);
  if (made.status !== 202) return pause(500);
  const at = `/api/v1/experiments/${made.json.id}`,
    until = performance.now() + 20000;
  while (performance.now() < until && (await c.get(at)).json.state === 'running') await pause(200);
  for (const format of ['csv', 'ndjson', 'json', 'sqlite']) await c.get(`${at}/results?format=${format}`);
  await c.get(`${at}/report`);
  await c.call('DELETE', at, { key: made.json.owner_key });
}

/** Who leaves in the middle of something, or says what is none. */
async function rude(port) {
  const words = pick([
    'GET / HTTP/1.1\r\nHost: localhost\r\n',
    'POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 900\r\n\r\n{"sc',
    '\x16\x03\x01\x02\x00\x01',
    'GET /api/v1/experiments HTTP/1.1\r\nHost: localhost\r\n\r\n'.repeat(20),
    'GET / HTTP/9.9\r\n\r\n',
  ]);
  await new Promise((resolve) => {
    const socket = net.connect(port, '127.0.0.1', () => {
      socket.write(words);
      setTimeout(() => socket.destroy(), whole(0, 300));
    });
    socket.on('error', () => {});
    socket.on('close', resolve);
    socket.resume();
  });
  await pause(50);
}

async function repeat(what) {
  while (!over()) {
    const c = client(daemon.url);
    try {
      for (let i = 0; i < 5 && !over(); i++) await what(c);
    } catch {
      broken++;
      await pause(100);
    }
    c.close();
  }
}

// ---- samples ----

const proc = (name) => readFileSync(`/proc/${daemon.pid}/${name}`, 'utf8');
const rows = [],
  begun = performance.now();

async function sample(c, idle = 0) {
  const status = proc('status'),
    kib = (name) => Number(new RegExp(`^${name}:\\s+(\\d+)`, 'm').exec(status)?.[1] ?? 0);
  const text = (await c.get('/metrics', { timeout: 60000 })).text,
    metric = (name) => Number(new RegExp(`^laglab_${name} (\\S+)$`, 'm').exec(text)?.[1] ?? NaN);
  const disk = readdirSync(daemon.data).reduce((sum, name) => sum + statSync(join(daemon.data, name)).size, 0);
  rows.push({
    t_s: Math.round((performance.now() - begun) / 1000),
    rss_mib: (kib('VmRSS') / 1024).toFixed(1),
    anonymous_mib: (kib('RssAnon') / 1024).toFixed(1),
    used_mib: (metric('heap_used_bytes') / 2 ** 20).toFixed(1),
    kept_mib: (metric('heap_kept_bytes') / 2 ** 20).toFixed(1),
    descriptors: readdirSync(`/proc/${daemon.pid}/fd`).length,
    threads: kib('Threads'),
    sessions: metric('sessions'),
    disk_mib: (disk / 2 ** 20).toFixed(1),
    idle,
    requests: [...statuses.values()].reduce((a, b) => a + b, 0),
    cpu_s: cpu_s(daemon.pid).toFixed(0),
    load: loadavg()[0].toFixed(2),
  });
}

async function samples() {
  const c = client(daemon.url);
  while (!over()) {
    await sample(c);
    await pause(every_s * 1000);
  }
  c.close();
}

function store() {
  writeCsv(
    'soak',
    `bench/run soak --seconds=${seconds} --rest-every=${rest_every} --clients=${clients}`,
    {
      t_s: 'since the load began',
      rss_mib: 'resident set',
      anonymous_mib: 'of it anonymous',
      used_mib: 'of allocated blocks',
      kept_mib: 'that the C library holds for blocks, free ones included',
      descriptors: 'open',
      threads: '',
      sessions: 'now',
      disk_mib: 'of the folder of --data',
      idle: '1: the load has rested for 20 s',
      requests: "answered to sessions' clients",
      cpu_s: 'of the daemon so far',
      load: '1-minute average of the machine',
    },
    rows,
  );
}

while (performance.now() < end) {
  phase_end = Math.min(end, performance.now() + rest_every * 1000);
  await Promise.all([
    samples(),
    ...Array.from({ length: clients }, () => repeat(session)),
    repeat(experiment),
    repeat(experiment),
    repeat(() => rude(daemon.port)),
  ]);
  await pause(REST_S * 1000);
  const c = client(daemon.url);
  await sample(c, 1);
  c.close();
  console.log(JSON.stringify(rows.at(-1)));
  store();
}

const rests = rows.filter((row) => row.idle),
  loaded = rows.filter((row) => !row.idle),
  first = rests[0],
  last = rests.at(-1),
  hours = (last.t_s - first.t_s) / 3600;
const growth = hours > 0 ? (Number(last.anonymous_mib) - Number(first.anonymous_mib)) / hours : NaN;
const most = (column, of) => Math.max(...of.map((row) => Number(row[column])));
printTable(`${clients} clients for ${seconds} s, ${rests.length} rests`, [
  {
    requests: last.requests,
    'cpu s': last.cpu_s,
    'MiB at the first rest': first.anonymous_mib,
    'at the last': last.anonymous_mib,
    'growth, MiB/h': digits(growth),
    'under load, most MiB': most('anonymous_mib', loaded),
    'descriptors, most': most('descriptors', loaded),
    'at the first rest': first.descriptors,
    'at the last ': last.descriptors,
    'sessions then': last.sessions,
    'cut by the load': broken,
  },
]);
say(
  `Answers: ${[...statuses]
    .sort(([a], [b]) => a - b)
    .map(([status, count]) => `${status} ${count}`)
    .join(', ')}.`,
);
const met = growth < GROWTH_MIB_PER_H && last.descriptors <= Number(first.descriptors) + 4 && last.sessions === 0 && !statuses.has(500);
say(
  `${met ? 'Met' : 'Missed'}: anonymous memory of rests grows by less than ${GROWTH_MIB_PER_H} MiB/h, ` +
    'descriptors and sessions are back where they were, no 500.',
);
const how = await daemon.stop();
say(`SIGTERM: exit ${how.code ?? how.signal}.`);
store();
process.exit(met && how.code === 0 ? 0 : 1);
