// The cases of Autobahn|Testsuite against a session's stream: what the suite says of each, with a reason where it is not strict. Twice:
// as the suite sends them, and with every byte in a write of its own. --before BIN: another laglab too. --slack N: the suite's waits, of a
// second mostly, N times as long, for a machine that is full.
import { execFileSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { laglab, makeSession, option, printTable, root, run, say, startDaemonOf, writeCsv } from './lib.mjs';

const testsuite = option('testsuite'),
  before = option('before'),
  slack = Number(option('slack') ?? 1);
if (!testsuite || !existsSync(join(testsuite, 'autobahntestsuite'))) {
  console.error('autobahn: --testsuite DIR: must be a checkout of https://github.com/crossbario/autobahn-testsuite');
  process.exit(2);
}
const MESSAGE_MAX = 2 ** 20; // the largest that --max-message-bytes allows
const ARGS = ['--max-message-bytes', String(MESSAGE_MAX), '--max-messages-per-s', '100000'];
const WAYS = [
  { writes: 'as sent', options: [] },
  { writes: 'bytes', options: ['--bytewise', '--only', '1,2,3,4,5,6,7,10'] }, // 9 would be 240 million writes
];
const CHAPTERS = {
  1: 'framing',
  2: 'pings and pongs',
  3: 'reserved bits',
  4: 'opcodes',
  5: 'fragments',
  6: 'UTF-8',
  7: 'closing',
  9: 'limits',
  10: 'automatic fragments',
};

const DESIGN = 'by design',
  OPEN = 'left open',
  NONSTRICT = 'not strict',
  LIBRARY = 'of the library',
  UNEXPLAINED = 'UNEXPLAINED';

/** What a result other than OK means. @returns {[kind: string, why: string]} */
function explain(row) {
  if (row.behaviour === 'OK' && row.closing === 'OK') return ['strict', ''];
  if (row.code === 1003 && row.sent[2]) return [DESIGN, 'the daemon takes text only: a binary message is refused with 1003'];
  if (row.code === 1009 && row.bytes > MESSAGE_MAX) return [DESIGN, 'larger than --max-message-bytes can be (1 MiB): refused with 1009'];
  if (row.behaviour === 'INFORMATIONAL') return [OPEN, `RFC 6455 leaves it open; here: ${row.late || `closed with ${row.code}`}`];
  if (row.behaviour === 'NON-STRICT' && row.closing === 'OK' && row.code === 1002 && row.received.length === 0)
    return [NONSTRICT, 'the fault closes the connection before the message ahead of it is answered, as RFC 6455 7.1.7 allows'];
  if (row.behaviour === 'NON-STRICT' && row.closing === 'OK' && !row.code && row.received.length === 0)
    return [NONSTRICT, 'the same, and input behind the fault ends the connection before its close frame is read'];
  if (/^2.1[01]$/.test(row.case) && row.closing === 'OK' && row.received.every((what) => what === 'pong'))
    return [LIBRARY, 'of several pings in one read the first is answered; RFC 6455 5.5.3 would have the newest answered'];
  return [UNEXPLAINED, row.result];
}

/** @param {string} binary */
async function judge(binary, { writes, options }) {
  const daemon = await startDaemonOf(binary, ...ARGS);
  try {
    const session = await makeSession(daemon.url); // paused: its frames would only be in the way
    await fetch(`${daemon.url}/api/v1/sessions/${session.id}/control`, {
      method: 'POST',
      headers: { 'content-type': 'application/json', authorization: `Bearer ${session.owner_key}` },
      body: '{"op":"pause"}',
    });
    const driver = [
      join(root, 'bench/autobahn/driver.py'),
      '--testsuite',
      testsuite,
      '--port',
      daemon.port,
      '--path',
      session.stream,
      '--slack',
      slack,
    ];
    const lines = await run('python3', [...driver, ...options].map(String));
    return lines
      .trim()
      .split('\n')
      .map((line) => JSON.parse(line))
      .sort((a, b) => a.case.localeCompare(b.case, 'en', { numeric: true }))
      .map((row) => {
        const [kind, why] = explain(row);
        if (kind === 'strict') delete row.sends, delete row.expects; // some hundred sentences that the suite has
        return { writes, ...row, chapter: Number(row.case.split('.')[0]), kind, why };
      });
  } finally {
    await daemon.stop();
  }
}

const daemons = { ...(before ? { before } : {}), now: laglab };
const rows = [];
for (const way of WAYS)
  for (const [name, binary] of Object.entries(daemons)) rows.push(...(await judge(binary, way)).map((row) => ({ daemon: name, ...row })));

const commit = execFileSync('git', ['-C', testsuite, 'rev-parse', '--short=12', 'HEAD']).toString().trim();
const count = (some, kind) => some.filter((row) => row.kind === kind).length;
printTable(
  `Autobahn|Testsuite ${commit}: cases by chapter`,
  Object.keys(daemons).flatMap((name) =>
    WAYS.flatMap(({ writes }) =>
      Object.entries(CHAPTERS).flatMap(([chapter, title]) => {
        const some = rows.filter((row) => row.daemon === name && row.writes === writes && row.chapter === Number(chapter));
        if (some.length === 0) return [];
        return [
          {
            daemon: name,
            writes,
            chapter: `${chapter} ${title}`,
            cases: some.length,
            ...Object.fromEntries(['strict', DESIGN, OPEN, NONSTRICT, LIBRARY, UNEXPLAINED].map((kind) => [kind, count(some, kind)])),
          },
        ];
      }),
    ),
  ),
);
for (const row of rows.filter((each) => each.kind === UNEXPLAINED))
  say(`${row.daemon}, ${row.writes}, ${row.case}: ${row.behaviour}, ${row.closing}, ${row.code ?? 'no code'}, ${row.late || row.why}`);
const unexplained = rows.filter((row) => row.daemon === 'now' && row.kind === UNEXPLAINED).length;
say(`Each case that is not strict has a reason: ${unexplained} have none: ${unexplained === 0 ? 'met' : 'MISSED'}`);
say('Chapters 12 and 13 (compression) do not apply.');
const more = `${before ? ' --before BIN' : ''}${slack > 1 ? ` --slack ${slack}` : ''}`;
writeCsv(
  'autobahn',
  `bench/run autobahn --testsuite DIR${more}; DIR: crossbario/autobahn-testsuite at ${commit}`,
  {
    daemon: '`now`: of this commit; `before`: as --before names it',
    writes: '`as sent`: by the suite; `bytes`: every byte in a write of its own',
    case: 'of Autobahn|Testsuite; 12 and 13 (compression) do not apply, since the daemon agrees to none',
    behaviour: "the suite's judgement, with one answer of the daemon to a text as its echo",
    closing: "the suite's judgement of how the connection ended",
    code: 'of the close frame of the daemon; empty: none',
    kind: '`strict`, or why not: `by design`, `left open` by RFC 6455, `not strict`, `of the library` (docs/limits.md)',
    why: 'for each that is not strict',
    sends: 'what a case that is not strict sends, in the words of the suite',
    expects: 'what it expects of an echo',
  },
  rows,
);
process.exit(unexplained === 0 ? 0 : 1);
