// What must hold for disturbed shards, from the answers that clients got, what they saw and what the logs have:
//   1. every acknowledged command is in the log once, at the tick of its answer; no command is there twice; the ticks of a log ascend
//   2. the state at the end has the hash of a replay, and of a run of the same commands in an undisturbed daemon
//   3. classes have their code, board and members, and count votes (load.mjs)
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

/** Lines of a log. @param {string} log @returns {any[]} */
const linesOf = (log) =>
  log
    .split('\n')
    .filter(Boolean)
    .map((line) => JSON.parse(line));
const valueOf = (/** @type {any} */ line) => (line.op === 'set' ? line.values?.['players.1.lag_ms'] : undefined);

/** Point 1 for one session. @param {any} session @param {string[]} findings */
export function checkLog({ id, commands, log }, findings) {
  const there = new Map(),
    told = { acknowledged: 0, unanswered: 0, unanswered_stored: 0, lost: 0, twice: 0, disorder: 0 };
  let tick = 0;
  for (const line of linesOf(log)) {
    if (line.op === 'hash' || line.tick === undefined) continue;
    if (line.tick < tick) told.disorder++;
    tick = line.tick;
    const value = valueOf(line);
    if (value === undefined) continue;
    if (there.has(value)) {
      told.twice++;
      findings.push(`${id}: ${value} is there twice, at ${there.get(value)} and ${line.tick}`);
    }
    there.set(value, line.tick);
  }
  for (const { value, status, tick: said } of commands) {
    if (status === 200) {
      told.acknowledged++;
      if (there.get(value) === said) continue;
      told.lost++;
      findings.push(`${id}: ${value} was acknowledged at tick ${said}; the log has it at ${there.get(value)}`);
    } else {
      told.unanswered++;
      if (there.has(value)) told.unanswered_stored++;
    }
  }
  if (told.disorder) findings.push(`${id}: ${told.disorder} ticks of its log are lower than the one before`);
  return told;
}

/** @param {string} binary @param {string[]} args @returns {Promise<{status: number | null, stdout: string, stderr: string}>} */
const outcome = (binary, args) =>
  new Promise((resolve) => {
    const child = spawn(binary, args, { stdio: ['ignore', 'pipe', 'pipe'] });
    let stdout = '',
      stderr = '';
    child.stdout.setEncoding('utf8').on('data', (text) => (stdout += text));
    child.stderr.setEncoding('utf8').on('data', (text) => (stderr += text));
    child.once('close', (status) => resolve({ status, stdout, stderr }));
  });

/** Point 2, by `laglab replay`. @param {string} binary @param {any[]} sessions @param {string[]} findings */
export async function checkReplays(binary, sessions, findings) {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-replay-'));
  let differ = 0;
  const one = async (/** @type {any} */ { id, end, log }) => {
    const file = path.join(folder, `${id}.log`);
    writeFileSync(file, log);
    const { status, stdout, stderr } = await outcome(binary, ['replay', file]);
    const replayed = linesOf(log)
      .filter((line) => line.op === 'hash' && line.tick === end.tick)
      .at(-1);
    if (status === 0 && replayed?.hash === end.hash && JSON.parse(stdout).compared > 0) return;
    differ++;
    findings.push(`${id}: ${end.hash} at tick ${end.tick}, in its log ${replayed?.hash}; replay: ${status} ${stdout}${stderr}`);
  };
  for (let i = 0; i < sessions.length; i += 2) await Promise.all(sessions.slice(i, i + 2).map(one));
  rmSync(folder, { recursive: true, force: true });
  return { replayed: sessions.length, differ };
}

/** Point 2, by another daemon to which the same commands are given at the same ticks. @param {any[]} sessions @param {string[]} findings */
export async function checkTwins(sessions, findings) {
  const daemon = await startDaemon({
      args: ['--max-new-sessions-per-min', '1000000', '--max-commands-per-s', '100000', '--max-sessions', '100000'],
    }),
    c = client(daemon.url);
  const good = (/** @type {any} */ answer) => {
    if (answer.status >= 300) throw new Error(`the undisturbed daemon answered ${answer.status}: ${answer.text}`);
    return answer.json;
  };
  let differ = 0;
  try {
    for (const { id, end, log } of sessions) {
      const [{ scenario }, ...lines] = linesOf(log),
        twin = await c.make({ scenario, paused: true });
      for (const line of lines) {
        if (valueOf(line) === undefined) continue;
        good(await c.control(twin, { op: 'seek', tick: line.tick }));
        good(await c.patch(twin, line.values));
      }
      const { hash } = good(await c.control(twin, { op: 'seek', tick: end.tick }));
      if (hash === end.hash) continue;
      differ++;
      findings.push(`${id}: ${end.hash} at tick ${end.tick}, ${hash} in an undisturbed daemon`);
    }
  } finally {
    c.close();
    await daemon.stop();
  }
  return { twins: sessions.length, differ };
}
