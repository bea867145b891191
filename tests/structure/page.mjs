// Checks what the modules of the page import: node tests/structure/page.mjs ROOT
//   1. A module lies in a room, and a room uses only what tests/structure/page_rooms.txt lets it: by import, by import() and by
//      the types of JSDoc. www/vendor is open to all.
//   2. No modules import each other in a circle.
//   3. Names of games, the rows of src/game/games/games.h, occur in the room of the netgame only.
//   4. A room has at most 20 modules, a module at most 500 lines.
import { readdirSync, readFileSync } from 'node:fs';
import { join, posix } from 'node:path';
import { argv, exit } from 'node:process';
import { fileURLToPath } from 'node:url';
import { below, circle, readRooms } from './rooms.mjs';

const MODULES_MAX = 20,
  LINES_MAX = 500;

/** @param {string} text @param {number} at */
const lineOf = (text, at) => text.slice(0, at).split('\n').length;

/** `import`, `export ... from`, `import()`, and types by `import()`. */
const IMPORT = /\bimport\s*\(\s*'([^']+)'|^import\b[^'";]*'([^']+)'|^export\s*[*{][^'";]*\bfrom\s*'([^']+)'/gm;

/** @param {string} name @param {string} text @returns {{line: number, other: string}[]} the others as paths below www/js */
const importsOf = (name, text) =>
  [...text.matchAll(IMPORT)]
    .map((match) => ({ line: lineOf(text, match.index), path: match[1] ?? match[2] ?? match[3] }))
    .filter(({ path }) => path.startsWith('.'))
    .map(({ line, path }) => ({ line, other: posix.join(posix.dirname(name), path) }))
    .filter(({ other }) => !other.startsWith('../vendor/'));

function readModules(js) {
  return readdirSync(js, { recursive: true, encoding: 'utf8' })
    .filter((name) => name.endsWith('.js'))
    .map((path) => {
      const name = path.replaceAll('\\', '/'),
        text = readFileSync(join(js, path), 'utf8');
      return { name, room: posix.dirname(name), text, imports: importsOf(name, text) };
    })
    .sort((a, b) => (a.name < b.name ? -1 : 1));
}

/** @param {string} root @returns {string[]} */
function gamesOf(root) {
  const table = /#define LL_GAMES\(ROW\)([\s\S]*?)\n(?!\s+ROW)/.exec(readFileSync(join(root, 'src/game/games/games.h'), 'utf8'));
  return [...(table?.[1] ?? '').matchAll(/ROW\((\w+)\)/g)].map(([, name]) => name);
}

function checkImports(modules, rooms) {
  const findings = [],
    byName = new Map(modules.map((module) => [module.name, module]));
  for (const { name, room, imports } of modules) {
    const allowed = below(rooms, room);
    for (const { line, other } of imports) {
      const target = byName.get(other);
      if (!target) findings.push([name, line, `imports ${other}, which is in no room`]);
      else if (target.room !== room && !allowed.has(target.room))
        findings.push([name, line, `${room} imports ${other}, and may not use ${target.room}`]);
    }
  }
  return findings;
}

function checkCircle(modules) {
  const found = circle(modules.map(({ name, imports }) => [name, imports.map(({ other }) => other)]));
  return found ? [[found[0], 1, `in a circle: ${found.join(', ')}`]] : [];
}

function checkGames(modules, games, home) {
  const pattern = new RegExp(`\\b(?:${games.join('|')})\\b`, 'g');
  return modules
    .filter(({ room }) => room !== home && !room.startsWith(`${home}/`))
    .flatMap(({ name, text }) =>
      [...text.matchAll(pattern)].map((match) => [name, lineOf(text, match.index), `knows the game ${match[0]}`]),
    );
}

function checkSizes(modules, rooms) {
  const findings = [];
  for (const room of rooms.may.keys()) {
    const count = modules.filter((module) => module.room === room).length;
    if (count === 0) findings.push([room, 1, 'has no modules']);
    if (count > MODULES_MAX) findings.push([room, 1, `${count} modules, more than ${MODULES_MAX}`]);
  }
  for (const { name, text } of modules) {
    const lines = text.trimEnd().split('\n').length;
    if (lines > LINES_MAX) findings.push([name, lines, `more than ${LINES_MAX} lines`]);
  }
  return findings;
}

/** @param {string} root @returns {{findings: string[], modules: number, rooms: number}} */
export function checkPage(root) {
  const rooms = readRooms(join(root, 'tests/structure/page_rooms.txt')),
    [home = ''] = rooms.games;
  const modules = readModules(join(root, 'www/js')),
    own = modules.filter(({ name }) => !rooms.generated.includes(name));
  const findings = rooms.findings.map((what) => ['../../tests/structure/page_rooms.txt', 1, what]);
  for (const { name, room } of modules) if (!rooms.may.has(room)) findings.push([name, 1, `${room} is not one of the rooms`]);
  findings.push(
    ...checkImports(modules, rooms),
    ...checkCircle(modules),
    ...checkGames(own, gamesOf(root), home),
    ...checkSizes(own, rooms),
  );
  const lines = findings.map(([name, line, what]) => `${posix.join('www/js', String(name))}:${line}: ${what}`);
  return { findings: [...new Set(lines)].sort(), modules: modules.length, rooms: rooms.may.size };
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const { findings, modules, rooms } = checkPage(argv[2] ?? '.');
  for (const finding of findings) console.log(finding);
  console.log(`${modules} modules in ${rooms} rooms, ${findings.length} findings`);
  exit(modules > 0 && findings.length === 0 ? 0 : 1);
}
