// What the daemon says is said in German too: every sentence of the sources that a page can get has one in www/words/messages.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { BINARY } from '../lib/daemon.mjs';
import { translator } from '../../www/js/base/sentences.js';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const TABLE = JSON.parse(readFileSync(path.join(ROOT, 'www/words/messages/de.json'), 'utf8'));
const said = translator(TABLE, (given) => given);

/** Rooms whose errors answer what a person does on the page. */
const ROOMS = [
  'daemon/api daemon/class daemon/hosting daemon/jobs param session experiment/spec library',
  'sim/core sim/motion sim/fluid sim/rigid sim/netgame',
  'ode/core rigid/world fluid/grid fluid/particle fluid/pressure game/games',
]
  .join(' ')
  .split(' ');
/** What a page never gets: of starts of the daemon, of files of the command line, of logs, of requests that no page makes, of faults of
 * tables. */
const NEVER = [
  /^cannot (?:start|read|create)/,
  /thread|^workload|log\b|^line %zu|^row %d|rows$|^a table|has no name$|^Accept|^Idempotency|^Range|^run: /,
  /^a stored class|^`|^tick is|^unknown op|^header missing|^restart of|^not the header|%\.150s|the store /,
  /^(?:input|subscribe|id|auth|A message)|is missing\.$|^must be|needs a task|%s: must be a whole number from 0 to %\.15g|two numbers from/,
  /^--set|not asleep|can be saved|the state is/,
  /was (?:busy|parked)|not awake|not up to date|No space|temporary|is not installed|^This stream|^listen/,
];

/** A literal of C, in one piece. @param {string} text */
const rejoined = (text) =>
  text
    .replace(/\s*\bPRI[a-z]\d+/g, '"lld"')
    .replace(/"\s*"/g, '')
    .slice(1, -1);

/** Formats of the errors of a room. @param {string} room @returns {string[]} */
function formatsOf(room) {
  const folder = path.join(ROOT, 'src', room);
  return readdirSync(folder)
    .filter((name) => name.endsWith('.c'))
    .flatMap((name) => {
      const text = readFileSync(path.join(folder, name), 'utf8');
      return [...text.matchAll(/\bll_(?:field_)?error\(\s*LL_\w+,((?:[^;"]|"(?:[^"\\]|\\.)*")*?);/g)].flatMap(([, given = '']) =>
        [...given.matchAll(/"(?:[^"\\]|\\.)*"(?:\s*(?:PRI[a-z]\d+|"(?:[^"\\]|\\.)*"))*/g)]
          .map(([literal]) => rejoined(literal).replaceAll('\\"', '"'))
          .filter((literal) => / /.test(literal) && /[a-z]{3}/.test(literal)),
      );
    });
}

/** With something in its places, as vsnprintf would. @param {string} format */
const sampled = (format) =>
  format
    .replaceAll('%%', '\u0000')
    .replace(/%[-0-9.*]*(?:ll|z|l)?([a-zA-Z])/g, (_, kind) => (kind === 's' ? 'players.0.lag_ms' : '7'))
    .replaceAll('\u0000', '%');

test('each sentence that a page can get has a German one', () => {
  const missing = ROOMS.flatMap((room) =>
    formatsOf(room)
      .filter((format) => !NEVER.some((one) => one.test(format)) && !/^(?:%s|[\w.]+)(?:: %s)?$|^ and/.test(format))
      .filter((format) => said(sampled(format)) === null)
      .map((format) => `${room}: ${format}`),
  );
  assert.deepEqual(missing, []);
});

test('texts of problems, solvers and fluids have a German one', () => {
  const problems = execFileSync(BINARY, ['problems'], { encoding: 'utf8' })
    .split('\n')
    .map((line) => /\ds(?: {2}stiff)? {2,}(\S.*?) \(/.exec(line.replace(/ s /, 's '))?.[1])
    .filter((text) => text !== undefined);
  assert.ok(problems.length > 25, `${problems.length} problems`);
  const helps = ['rigid/solver', 'fluid/scenes', 'fluid/grid', 'fluid/particle', 'fluid/ocean'].flatMap((room) =>
    readdirSync(path.join(ROOT, 'src', room)).flatMap((name) =>
      [
        ...readFileSync(path.join(ROOT, 'src', room, name), 'utf8').matchAll(
          /const ll_(?:fluid_scene|solver)\s+\w+ = \{[^;]*?\.help\s*=\s*((?:"(?:[^"\\]|\\.)*"\s*)+)/g,
        ),
      ].map(([, literal = '']) => rejoined(literal.trim())),
    ),
  );
  assert.ok(helps.length >= 12, `${helps.length} texts`);
  assert.deepEqual(
    [...problems, ...helps].filter((text) => said(text) === null),
    [],
  );
});

test('what differs keeps its value, and parts of a sentence have their German too', () => {
  const named = translator(TABLE, (given) => (given === 'players.0.lag_ms' ? 'A: Lag je Weg' : given));
  for (const { en, de } of JSON.parse(readFileSync(path.join(ROOT, 'tests/api/messages.json'), 'utf8'))) assert.equal(named(en), de);
  assert.equal(said('nothing that the daemon says'), null);
});
