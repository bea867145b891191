// Sessions on three daemons that share PostgreSQL, behind HAProxy as deploy/cluster configures it, while one thing after the other goes
// wrong: nothing acknowledged is lost, no session runs twice at a time, and the states are those of an undisturbed daemon. The large one:
// bench/run cluster.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { BINARY } from '../lib/daemon.mjs';
import { ownPostgres } from '../lib/chaos.mjs';
import { checkLog, strayFrames } from '../cluster/checks.mjs';
import { broken, disturb, summary } from '../cluster/run.mjs';
import { noCluster } from '../cluster/rig.mjs';

const LEASE_S = 3,
  HZ = 20;
const KINDS = ['killed', 'database crashed', 'frozen beyond its lease', 'proxy restarted', 'cut off beyond its lease', 'clock wrong'];
/** Seconds without frames that a viewer may have, by kind. A daemon that has just claimed a session keeps it for 5 s: a viewer that the
 * proxy sends to another one may wait as long, then tries again. */
const MOST_S = { undisturbed: 2, 'database crashed': 2 },
  OTHER_S = LEASE_S + 8;

function reason() {
  const missing = noCluster(BINARY);
  if (missing) return missing;
  const { missing: none, call } = ownPostgres();
  if (!none) call('remove');
  return none;
}
const skip = reason() || false;

test('a cluster that is disturbed loses nothing and runs no session twice', { skip, timeout: 120000 }, async (t) => {
  const report = await disturb({
    sessions: 12,
    kinds: KINDS,
    lease_s: LEASE_S,
    beyond_s: LEASE_S + 1.5,
    hz: HZ,
    every_ms: 200,
    quiet_s: 1,
    steady_s: 0.3,
    twins: 4,
  });
  t.diagnostic(JSON.stringify(report.totals));
  for (const { kind, gaps } of report.faults) {
    const { viewers, max_s } = summary(gaps, HZ);
    t.diagnostic(`${kind}: ${viewers} viewers without frames, at most for ${max_s.toFixed(2)} s`);
    assert.ok(max_s < (MOST_S[kind] ?? OTHER_S), `${kind}: ${max_s} s without frames`);
  }
  assert.deepEqual(report.findings.slice(0, 10), []);
  assert.deepEqual(broken(report), []);
  assert.ok(report.totals.acknowledged > 200 && report.totals.moves > 0 && report.totals.replayed === 12, 'something was disturbed');
});

test('what does not hold is found: lost, doubled and moved commands, frames of a daemon that did not own the session', () => {
  const line = (/** @type {number} */ tick, /** @type {number} */ value) =>
    JSON.stringify({ op: 'set', tick, values: { 'players.1.lag_ms': value } });
  const commands = [
    { value: 0.0625, status: 200, tick: 10 },
    { value: 0.125, status: 200, tick: 20 },
    { value: 0.1875, status: 200, tick: 30 },
    { value: 0.25, status: 503, tick: -1 },
  ];
  const check = (/** @type {string[]} */ ...lines) => {
    const { lost, twice, disorder, unanswered_stored } = checkLog(
      { id: 'a', commands, log: ['{"op":"create"}', ...lines, ''].join('\n') },
      [],
    );
    return [lost, twice, disorder, unanswered_stored];
  };
  assert.deepEqual(check(line(10, 0.0625), line(20, 0.125), line(30, 0.1875)), [0, 0, 0, 0]);
  assert.deepEqual(check(line(10, 0.0625), line(20, 0.125), line(30, 0.1875), line(40, 0.25)), [0, 0, 0, 1]);
  assert.deepEqual(check(line(10, 0.0625), line(30, 0.1875)), [1, 0, 0, 0]);
  assert.deepEqual(check(line(10, 0.0625), line(21, 0.125), line(30, 0.1875)), [1, 0, 0, 0]);
  assert.deepEqual(check(line(10, 0.0625), line(20, 0.125), line(30, 0.1875), line(30, 0.1875)), [0, 1, 0, 0]);
  assert.deepEqual(check(line(10, 0.0625), line(30, 0.1875), line(20, 0.125)), [0, 0, 1, 0]);

  const spans = new Map([
    [
      'a',
      [
        { name: 'd0', from: 1000, to: 2000 },
        { name: '', from: 2000, to: 2100 },
        { name: 'd1', from: 2100, to: Infinity },
      ],
    ],
  ]);
  const stray = (/** @type {string} */ server, /** @type {number} */ from, /** @type {number} */ to) =>
    strayFrames([{ id: 'a', runs: [{ server, from: from - 500, to: to - 500 }] }], 500, spans).map(({ late }) => late);
  assert.deepEqual(stray('d0', 1001, 1999), []);
  assert.deepEqual(stray('d1', 2100, 9999), []);
  assert.deepEqual(stray('d0', 1001, 2050), [50]);
  assert.deepEqual(stray('d1', 2000, 9999), [100]);
  assert.deepEqual(stray('d2', 1500, 1600), [Infinity]);
});
