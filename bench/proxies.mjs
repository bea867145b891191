// Upgrades on kept connections, direct and through proxies: 200 of 200 must stream.
import { digits, makeSession, printTable, quantile, say, startDaemon, writeCsv } from './lib.mjs';
import { plain, publicProxy } from '../tests/lib/public.mjs';
import { names } from './proxies/proxies.mjs';
import { bridged, upgradesOnKept } from './proxies/upgrades.mjs';

const count = process.argv.includes('--quick') ? 40 : 200;
const rows = [];
let missing = 0;

const daemon = await startDaemon();
const session = await makeSession(daemon.url);
for (const name of ['direct', ...names]) {
  const proxy = name === 'direct' ? undefined : await publicProxy(name, daemon.port, plain);
  for (const atOnce of [1, 8]) {
    const before = await bridged(daemon.url);
    const { ok, failures, ms } = await upgradesOnKept(proxy?.url ?? daemon.url, session, count, atOnce);
    rows.push({
      way: name,
      at_once: atOnce,
      upgrades: count,
      ok,
      on_kept: (await bridged(daemon.url)) - before,
      p50_ms: digits(quantile(ms, 0.5)),
      max_ms: digits(Math.max(...ms)),
      failures: JSON.stringify(failures),
    });
    missing += count - ok;
  }
  await proxy?.stop();
}
await daemon.stop();

printTable('8 requests, then an upgrade, each with a new client', rows);
say('');
say(`every upgrade streams: ${missing} did not: ${missing === 0 ? 'met' : 'MISSED'}`);
writeCsv(
  'proxies',
  'bench/run proxies',
  {
    way: 'to the daemon',
    at_once: 'clients at a time',
    upgrades: 'asked for',
    ok: 'that gave a hello and three frames',
    on_kept: 'upgrades that came to the daemon on a connection that it had kept (its own count)',
    p50_ms: '8 requests, upgrade, hello and frames',
    max_ms: '',
    failures: 'what went wrong, how often',
  },
  rows,
);
process.exitCode = missing === 0 ? 0 : 1;
