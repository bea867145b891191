// Suites of requests that try the daemon's edges, straight and through the proxies of deploy/: operations at random, requests that two
// parsers could read differently, and slow clients (slowhttptest, where it is installed). Figures for docs/trust.md; none should fail.
import { spawn, spawnSync } from 'node:child_process';
import { join } from 'node:path';
import { startDaemon as daemonOfTests } from '../tests/lib/daemon.mjs';
import { Explorer } from '../tests/lib/explorer.mjs';
import { publicProxy, NAME, plain } from '../tests/lib/public.mjs';
import { damaged, smuggle } from '../tests/lib/smuggled.mjs';
import { REQUESTS } from '../tests/daemon/smuggling.mjs';
import { pause, printTable, root, say, writeCsv } from './lib.mjs';
import { names } from './proxies/proxies.mjs';

const quick = process.argv.includes('--quick');
const SEED = 20261129,
  TURNS = 150,
  RANDOM_S = quick ? 15 : 120,
  DAMAGED = quick ? 200 : 3000,
  SLOW_S = quick ? 10 : 40,
  CONNECTIONS = 400,
  LATE_MS = 1000;
const rows = [];
function row(suite, way, tried, of, failed, first = '') {
  rows.push({ suite, way, tried, of, failed, first: String(first).slice(0, 300) });
  say(`${suite}, ${way}: ${tried} ${of}, ${failed} failed ${first}`);
}

// ---- at random ----

for (const way of ['direct', ...names]) {
  const explorer = new Explorer(SEED, way === 'direct' ? undefined : (port) => publicProxy(way, port, plain)),
    until = performance.now() + 1000 * RANDOM_S;
  let failure;
  try {
    await explorer.start();
    for (let round = 0; performance.now() < until; round++) await explorer.round(round, TURNS, until);
  } catch (error) {
    failure = error;
  }
  row('random', way, explorer.requests, 'requests', Number(Boolean(failure)), failure?.message ?? '');
  await explorer.end();
}

// ---- requests that two parsers could read differently ----

const alone = spawnSync(process.execPath, ['--test', join(root, 'tests/daemon/smuggling.test.mjs')], { encoding: 'utf8' }),
  count = (what) => Number(new RegExp(`^# ${what} (\\d+)$`, 'm').exec(alone.stdout)?.[1]);
row('smuggling', 'direct', count('tests'), 'tests', count('fail'), /^not ok .*$/m.exec(alone.stdout)?.[0]);
const table = REQUESTS.map(([name, bytes]) => /** @type {[string, string]} */ ([name, bytes]));
for (const way of names) {
  const daemon = await daemonOfTests({
    args: ['--trusted-proxy', '127.0.0.1', '--allow-host', NAME, '--max-new-sessions-per-min', '1000000', '--max-sessions', '100000'],
  });
  const { sent, wrong } = await smuggle(way, daemon, [...table, ...damaged(table, SEED, DAMAGED)]);
  row('smuggling', way, sent, 'requests', wrong.length, wrong[0]);
  await daemon.stop();
}

// ---- slow clients ----

/** How long others wait while slowhttptest holds its connections. @param {string[]} options */
async function slow(way, options) {
  const daemon = await daemonOfTests();
  const url = `http://127.0.0.1:${daemon.port}/api/v1/schemas.json`,
    attacker = spawn('slowhttptest', [...options, '-c', CONNECTIONS, '-r', 200, '-l', SLOW_S, '-u', url].map(String), { stdio: 'ignore' });
  const ended = new Promise((resolve) => attacker.once('exit', resolve));
  let tried = 0,
    late = 0,
    most = 0,
    going = true;
  ended.then(() => {
    going = false;
  });
  while (going) {
    const from = performance.now(),
      answer = await fetch(`http://127.0.0.1:${daemon.port}/readyz`, { headers: { connection: 'close' } }).catch(() => undefined),
      took = performance.now() - from;
    tried++;
    most = Math.max(most, took);
    late += Number(answer?.status !== 200 || took > LATE_MS);
    await pause(50);
  }
  row('slow clients', way, tried, 'requests of others', late, `at most ${most.toFixed(0)} ms`);
  await daemon.stop();
}
if (spawnSync('slowhttptest', ['-h']).error) say('slowhttptest is not installed: no slow clients');
else {
  await slow('slow heads', ['-H', '-i', 1, '-x', 20]);
  await slow('slow bodies', ['-B', '-i', 1, '-s', 8192, '-f', 'application/json']);
  await slow('slow readers', ['-X', '-w', 10, '-y', 20, '-n', 1, '-z', 8, '-k', 3]);
}

printTable('suites', rows);
writeCsv(
  'suites',
  `bench/run suites${quick ? ' --quick' : ''}`,
  {
    suite: '',
    way: 'to the daemon, or of the slow clients',
    tried: '',
    of: 'what was tried',
    failed: 'of them; smuggling: connections whose ends saw other requests, or others that were not answered',
    first: 'failure',
  },
  rows,
);
process.exitCode = rows.some(({ failed }) => failed > 0) ? 1 : 0;
