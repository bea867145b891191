// What must hold for a disturbed cluster, from the answers that clients got, what they saw and what the database holds:
//   1. every acknowledged command is in the log once, at the tick of its answer; no command is there twice; the ticks of a log ascend
//   2. logs have no holes, and each line was written by the daemon that owned the session at that time
//   3. every frame was taken by the daemon that owned the session at that time: no session ran twice at a time
//   4. the state at the end has the hash of a replay, and of a run of the same commands in one daemon with SQLite
// Owners are kept by a trigger of the rig's own, and writers by columns that it adds: the database's word, not the daemons'.
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';

/** Tables of the store. */
const TABLES = { session: 'laglab_sessions.session', line: 'laglab_sessions.line', daemon: 'laglab_sessions.daemon' };

/** Before the first session is made. @param {import('./faults.mjs').Rig} rig */
export function audit({ database }) {
  database.sql(`
    ALTER TABLE ${TABLES.line} ADD COLUMN written_by inet DEFAULT inet_client_addr(),
      ADD COLUMN written timestamptz DEFAULT clock_timestamp();
    CREATE TABLE public.owned(session text, owner bigint, at timestamptz DEFAULT clock_timestamp(),
      serial bigint GENERATED ALWAYS AS IDENTITY);
    CREATE FUNCTION public.note_owner() RETURNS trigger LANGUAGE plpgsql AS
      $$ BEGIN INSERT INTO public.owned(session, owner) VALUES (new.id, new.owner); RETURN new; END $$;
    CREATE TRIGGER note_owner AFTER INSERT OR UPDATE OF owner ON ${TABLES.session} FOR EACH ROW EXECUTE FUNCTION public.note_owner()`);
}

/**
 * When each session was whose, ms since 1970, in order; neighbouring spans of one owner are one.
 * @param {import('./faults.mjs').Rig} rig @returns {Map<string, {name: string, from: number, to: number}[]>}
 */
export function owners({ database, daemons }) {
  const names = new Map(
    database
      .sql(`SELECT inc, url FROM ${TABLES.daemon}`)
      .map(([inc, url]) => [inc, daemons.find((daemon) => url.startsWith(daemon.url))?.name ?? url]),
  );
  const spans = /** @type {Map<string, {name: string, from: number, to: number}[]>} */ (new Map());
  for (const [id, owner, at] of database.sql('SELECT session, owner, extract(epoch FROM at) * 1000 FROM public.owned ORDER BY serial')) {
    const list = spans.get(id) ?? [],
      last = list.at(-1),
      name = names.get(owner) ?? '';
    spans.set(id, list);
    if (last?.name === name) continue;
    if (last) last.to = Number(at);
    list.push({ name, from: last ? Number(at) : 0, to: Infinity }); // the first line is of the statement that makes the session
  }
  return spans;
}

/**
 * Frames that a daemon took of a session that was not its own, by how long before or after.
 * @param {{id: string, runs: {server: string, from: number, to: number}[]}[]} viewers @param {number} offset_ms
 */
export function strayFrames(viewers, offset_ms, spans) {
  const stray = [];
  for (const { id, runs } of viewers)
    for (const { server, from, to } of runs) {
      const [begin, end] = [from + offset_ms, to + offset_ms];
      const late = (spans.get(id) ?? [])
        .filter((span) => span.name === server)
        .map((span) => Math.max(0, span.from - begin, end - span.to))
        .reduce((least, ms) => Math.min(least, ms), Infinity);
      if (late > CLOCKS_MS) stray.push({ id, server, late });
    }
  return stray;
}
/* Two clocks are compared that are read one after the other, by a process that may wait for the processor in between. */
const CLOCKS_MS = 2;

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

/** Point 2. @param {import('./faults.mjs').Rig} rig @param {string[]} findings */
export function checkLines({ database, daemons, net }, spans, findings) {
  const nameAt = new Map(daemons.map(({ name }) => [net.address(name), name]));
  const told = { lines: 0, holes: 0, strangers: 0 };
  for (const [id, lines, first, last] of database.sql(
    `SELECT s.id, count(*), min(l.i), max(l.i) FROM ${TABLES.line} l JOIN ${TABLES.session} s ON s.no = l.session GROUP BY s.id`,
  )) {
    told.lines += Number(lines);
    if (Number(last) - Number(first) + 1 === Number(lines)) continue;
    told.holes++;
    findings.push(`${id}: ${lines} lines numbered ${first} to ${last}`);
  }
  for (const [id, i, address, at] of database.sql(
    `SELECT s.id, l.i, host(l.written_by), extract(epoch FROM l.written) * 1000
     FROM ${TABLES.line} l JOIN ${TABLES.session} s ON s.no = l.session WHERE l.i > 0`,
  )) {
    const name = nameAt.get(address);
    if ((spans.get(id) ?? []).some((span) => span.name === name && Number(at) >= span.from && Number(at) <= span.to)) continue;
    told.strangers++;
    findings.push(`${id}: line ${i} was written by ${name}, which did not own the session then`);
  }
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

/** Point 4, by `laglab replay`. @param {string} binary @param {any[]} sessions @param {string[]} findings */
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

/** Point 4, by another daemon to which the same commands are given at the same ticks. @param {any[]} sessions @param {string[]} findings */
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
