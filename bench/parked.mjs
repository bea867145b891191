// Memory of many sessions without viewers: 10,000 races that have played for ten seconds and are parked, by the daemon's own memory.
import { readFileSync } from 'node:fs';
import { digits, makeSession, pause, printTable, say, startDaemon, writeCsv } from './lib.mjs';

const GOAL_MIB = 64;
const count = process.argv.includes('--quick') ? 1000 : 10000,
  steps = 5,
  at_once = 8;

const daemon = await startDaemon('--max-sessions', '20000', '--park-after-s', '1', '--max-client-logs-mib', '0');
const metric = async (name) =>
  Number(new RegExp(`^laglab_${name} (\\S+)$`, 'm').exec(await (await fetch(`${daemon.url}/metrics`)).text())[1]);

async function sample(sessions) {
  const status = readFileSync(`/proc/${daemon.pid}/status`, 'utf8'),
    mib = (name) => Number(new RegExp(`^${name}:\\s+(\\d+)`, 'm').exec(status)[1]) / 1024;
  return {
    sessions,
    parked: await metric('sessions_parked'),
    rss_mib: mib('VmRSS'),
    anonymous_mib: mib('RssAnon'),
    heap_used_mib: (await metric('heap_used_bytes')) / 2 ** 20,
    heap_kept_mib: (await metric('heap_kept_bytes')) / 2 ** 20,
  };
}

/** Until no session is awake. */
async function allParked(sessions) {
  for (let waited = 0; (await metric('sessions_parked')) < sessions; waited++) {
    if (waited > 600) throw new Error(`${await metric('sessions_parked')} of ${sessions} sessions are parked after a minute`);
    await pause(100);
  }
  await pause(2000); // what they needed is returned a moment later
}

const rows = [await sample(0)];
for (let made = 0; made < count; ) {
  const until = made + count / steps;
  while (made < until) {
    await Promise.all(Array.from({ length: at_once }, () => makeSession(daemon.url)));
    made += at_once;
  }
  await allParked(made);
  rows.push(await sample(made));
}
await daemon.stop();

const [first] = rows,
  last = rows.at(-1);
printTable(
  'Races without viewers',
  rows.map((row) => ({
    sessions: row.sessions,
    parked: row.parked,
    'resident MiB': digits(row.rss_mib, 4),
    'anonymous MiB': digits(row.anonymous_mib, 4),
    'bytes a session': row.sessions ? Math.round(((row.anonymous_mib - first.anonymous_mib) * 2 ** 20) / row.sessions) : '',
  })),
);
const met = last.rss_mib <= GOAL_MIB;
say('');
say(
  `${last.sessions} parked sessions in ${digits(last.rss_mib, 3)} MiB of resident memory, ` +
    `the program included (goal ${GOAL_MIB}): ${met ? 'met' : 'MISSED'}`,
);
writeCsv(
  'parked',
  `bench/run parked${count === 10000 ? '' : ' --quick'}`,
  {
    sessions: 'races that were made and have no viewer',
    parked: 'of them parked',
    rss_mib: 'resident memory of the daemon',
    anonymous_mib: 'of it anonymous',
    heap_used_mib: 'of the C library, in use',
    heap_kept_mib: 'held by the C library, with what is free',
  },
  rows,
);
process.exitCode = met ? 0 : 1;
