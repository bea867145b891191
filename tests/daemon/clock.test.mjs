// The machine's date jumps, by hours and days, back and forth: sessions keep their pace, streams their frames, limits their rates, and
// nothing expires that was just used. Only the wall clock jumps, as it does when it is set: a preloaded library (tests/lib/date.c) adds to
// it.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { client, pause, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

const DATE = path.join(path.dirname(fileURLToPath(import.meta.url)), '../lib/date.c');
const X = '/api/v1/experiments';

test('the date jumps while the daemon works', { timeout: 600000 }, async (t) => {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-clock-')),
    data = path.join(folder, 'data'),
    file = path.join(folder, 'date');
  t.after(() => rmSync(folder, { recursive: true, force: true }));
  const jump = (/** @type {number} */ hours) => writeFileSync(file, `${hours * 3600}\n`);
  jump(0);
  execFileSync('cc', ['-shared', '-fPIC', '-o', path.join(folder, 'date.so'), DATE]);
  const before = ['env', `LD_PRELOAD=${path.join(folder, 'date.so')}`, `DATE_FILE=${file}`];
  const daemon = await startDaemon({
    data,
    before,
    args: ['--session-ttl-s', '3600', '--experiment-run-ttl-s', '100000', '--max-code-lookups-per-min', '6'],
  });
  const c = client(daemon.url);
  const date = async () => Date.parse((await c.get('/healthz')).headers.date) - Date.now();
  const session = await c.make({ set: { duration_s: 600 } }),
    still = await c.make({ paused: true });
  const order = { scenario: 'race', set: { duration_s: 1 }, repeats: 100000, metrics: ['players.0.own_lead_m.mean'] };
  const experiment = (await c.call('POST', X, { body: order })).json;
  const stream = await c.stream(session, 'json', { ack: true });
  const progress = await c.progress(experiment.id);
  for (const by of [-2, 72, -9600, 0]) {
    // hours
    jump(by);
    assert.ok(Math.abs((await date()) - by * 3600e3) < 5000, `the daemon's date is off by ${by} h`);
    const frames = stream.frames.length,
      told = progress.messages.length,
      from = performance.now();
    const { tick: first } = (await c.get(session.links.state)).json;
    await pause(1500);
    const { tick: last } = (await c.get(session.links.state)).json,
      seconds = (performance.now() - from) / 1000;
    assert.ok(Math.abs((last - first) / 60 - seconds) < 0.5, `${by}: ${last - first} ticks in ${seconds} s`);
    assert.ok(stream.frames.length - frames > 20, `${by}: ${stream.frames.length - frames} frames in ${seconds} s`);
    assert.ok(progress.messages.length > told, `${by}: the experiment's progress is sent`);
    assert.equal((await c.patch(session, { 'players.0.lag_ms': 10 })).status, 200);
    assert.equal((await c.get(still.links.self)).status, 200, `${by}: nothing expires`);
    assert.equal((await c.get(`${X}/${experiment.id}`)).json.state, 'running', `${by} h`);
  }
  await waitFor(async () => {
    // the bucket of wrong codes fills by the time that passes, not by dates
    jump(24);
    return (await c.get('/api/v1/codes/ZZZZZ')).status === 429;
  }, 'the limit of codes');
  const { hash, tick } = (await c.control(session, { op: 'pause' })).json;
  await stream.close();
  c.close();
  await daemon.kill();
  // Restarted with a date in the past, in the future, and the right one: all sessions are there.
  for (const by of [-216, 0.5, 0]) {
    jump(by);
    const again = await startDaemon({ data, before, args: ['--session-ttl-s', '3600'] }),
      d = client(again.url);
    assert.equal((await d.get(`${session.links.state}?tick=${tick}`)).json.hash, hash, `${by} h`);
    assert.equal((await d.get(still.links.self)).status, 200, `${by} h`);
    d.close();
    assert.equal((await again.stop()).code, 0);
  }
});
