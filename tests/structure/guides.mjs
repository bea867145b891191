// Checks what ARCHITECTURE.md, CONTRIBUTING.md and the README of each top room name: node tests/structure/guides.mjs ROOT
//   1. Every file, folder and function in `backticks` exists. Those of build/ are there only after a build.
//   2. ARCHITECTURE.md has every room of tests/structure/rooms.txt and page_rooms.txt; each README has every sub-room, or every header of a
//      room without.
//   3. A README has at most 30 lines.
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { argv, exit } from 'node:process';
import { fileURLToPath } from 'node:url';
import { readRooms } from './rooms.mjs';

const LINES_MAX = 30;
const folders = (path) =>
  readdirSync(path, { withFileTypes: true })
    .filter((entry) => entry.isDirectory())
    .map((entry) => entry.name);

function words(src) {
  const found = new Set();
  for (const name of readdirSync(src, { recursive: true, encoding: 'utf8' })) {
    if (!/\.(?:c|h|inc)$/.test(name)) continue;
    for (const word of readFileSync(join(src, name), 'utf8').matchAll(/\b(?:ll|LL)_\w+\b/g)) found.add(word[0]);
  }
  return found;
}

/** Names in backticks, with their line. Code blocks do not count. @param {string} text */
function quoted(text) {
  const plain = text.replace(/```[\s\S]*?```/g, (block) => block.replace(/[^\n]/g, ' '));
  return [...plain.matchAll(/`([^`\n]+)`/g)].map((match) => ({ name: match[1], line: plain.slice(0, match.index).split('\n').length }));
}

/** @param {string} root @returns {string[]} one line per breach */
export function checkGuides(root) {
  const src = join(root, 'src'),
    known = words(src),
    findings = [],
    tops = folders(src);
  const guides = ['ARCHITECTURE.md', 'CONTRIBUTING.md', ...tops.map((room) => `src/${room}/README.md`)];
  for (const guide of guides) {
    if (!existsSync(join(root, guide))) {
      findings.push(`${guide}: is missing`);
      continue;
    }
    const text = readFileSync(join(root, guide), 'utf8'),
      room = /^src\/(\w+)\/README/.exec(guide)?.[1];
    const inside = room ? folders(join(src, room)) : [],
      names = quoted(text);
    const places = [root, src, ...(room ? [join(src, room), ...inside.map((sub) => join(src, room, sub))] : [])];
    for (const { name, line } of names) {
      if (/^(?:ll|LL)_\w+$/.test(name) && !/NAME/.test(name) && !known.has(name)) findings.push(`${guide}:${line}: ${name} is not in src`);
      if (
        /^(?!build\/)[\w.-]+(?:\/[\w.-]+)*\.(?:c|h|inc|js|mjs|md|txt|csv|json|jsonc|yaml)$/.test(name) &&
        !/NAME/.test(name) &&
        !places.some((place) => existsSync(join(place, name)))
      ) {
        findings.push(`${guide}:${line}: there is no file ${name}`);
      }
      if (/^(?:src|tests|docs|www|api|scenarios|bench)\/[\w/.-]*$/.test(name) && !/NAME/.test(name) && !existsSync(join(root, name)))
        findings.push(`${guide}:${line}: there is no ${name}`);
    }
    if (!room) continue;
    const said = new Set(names.map(({ name }) => name)),
      lines = text.trimEnd().split('\n').length;
    const needed = inside.length > 0 ? inside : readdirSync(join(src, room)).filter((name) => name.endsWith('.h'));
    for (const name of needed) if (!said.has(name)) findings.push(`${guide}:1: does not name ${name}`);
    if (lines > LINES_MAX) findings.push(`${guide}:${lines}: more than ${LINES_MAX} lines`);
  }
  const map = readFileSync(join(root, 'ARCHITECTURE.md'), 'utf8');
  for (const room of readRooms(join(root, 'tests/structure/rooms.txt')).may.keys()) {
    if (!map.includes(`\`${room}\``)) findings.push(`ARCHITECTURE.md:1: does not name the room ${room}`);
  }
  const page = join(root, 'tests/structure/page_rooms.txt');
  for (const room of existsSync(page) ? readRooms(page).may.keys() : [])
    if (!map.includes(`\`www/js/${room}\``)) findings.push(`ARCHITECTURE.md:1: does not name the room www/js/${room}`);
  return [...new Set(findings)];
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const findings = checkGuides(argv[2] ?? '.');
  for (const finding of findings) console.log(finding);
  console.log(`${findings.length} findings`);
  exit(findings.length === 0 ? 0 : 1);
}
