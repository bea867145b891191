// Counts banned words in comments, strings and Markdown: node tests/structure/words.mjs ROOT [--update] [--list]
//   Fails when a room has more findings than tests/structure/words.csv allows, or is missing there.
//   --update writes the present counts, if their sum does not rise: words may move with their files to another room.
//   --list prints every finding.
// Names in code are not text; neither is code in Markdown, nor what stands in `backticks`, nor a generated part.
import { existsSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import process, { argv } from 'node:process';
import { fileURLToPath } from 'node:url';

const HERE = 'tests/structure';
const blank = (text) => text.replace(/[^\n]/g, ' ');

/** @param {string} text of words.txt @returns {{allowed: RegExp[], banned: {regex: RegExp, instead: string}[]}} */
export function readList(text) {
  const lines = text
    .split('\n')
    .map((line) => line.trim())
    .filter((line) => line && !line.startsWith('#'));
  return {
    allowed: lines.filter((line) => line.startsWith('!')).map((line) => new RegExp(`\\b(?:${line.slice(1)})\\b`, 'gi')),
    banned: lines
      .filter((line) => !line.startsWith('!'))
      .map((line) => {
        const at = line.lastIndexOf(':');
        if (at < 0) throw new Error(`words.txt: "${line}" has no replacement`);
        return { regex: new RegExp(`\\b(?:${line.slice(0, at)})\\b`, 'gi'), instead: line.slice(at + 1) };
      }),
  };
}

const COMMENT = /\/\*[\s\S]*?\*\/|\/\/[^\n]*/;
const LITERAL = /"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'|`(?:\\.|[^`\\])*`/;
const EITHER = new RegExp(`${COMMENT.source}|${LITERAL.source}`, 'g');
const quoted = (text) => text.replace(/`[^`\n]*`/g, blank);
const untyped = (text) => text.replace(/\{[^{}\n]*(?:\{[^{}\n]*\}[^{}\n]*)*\}/g, blank); // JSDoc's types

/** What is text of a file; the rest is blank, so that lines keep their numbers. @type {Record<string, (text: string) => string>} */
const TEXT = {
  code(text) {
    let out = '';
    let at = 0;
    for (const match of text.matchAll(EITHER)) {
      const part = match[0];
      out += blank(text.slice(at, match.index));
      // An #include, a path or a name is a string without a space.
      if (/^\/[/*]/.test(part)) out += untyped(quoted(part));
      else out += / /.test(part.trim()) ? part.replace(/\$\{[^}]*\}/g, blank) : blank(part);
      at = match.index + part.length;
    }
    return out + blank(text.slice(at));
  },
  markdown: (text) =>
    quoted(
      text
        .replace(/<!-- generated[\s\S]*?<!-- end -->/g, blank)
        .replace(/^```[\s\S]*?^```/gm, blank)
        .replace(/\]\([^)]*\)/g, blank),
    ),
  data: (text) => quoted(text).replace(/^\s*(?:\$ref|[\w-]+):\s*$/gm, blank),
};

const KINDS = [
  [/\.(?:c|h|inc|js|mjs|ts)$/, 'code'],
  [/\.md$/, 'markdown'],
  [/\.(?:ya?ml|json)$/, 'data'],
];
const SKIP = [
  /(?:^|\/)(?:fixture|corpus|golden|results|node_modules)\//,
  /(?:^|\/)package(?:-lock)?\.json$/,
  /^(?:types\/|docs\/glossary\.md|docs\/api\.md|tests\/structure\/words)/,
  /^api\/.*\.json$/,
];

/** @param {string} file @returns {string} `src/rigid`, `tests/ode`, `docs`; files of the root are `.` */
export function roomOf(file) {
  const parts = file.split('/');
  if (parts.length === 1) return '.';
  return (parts[0] === 'src' || parts[0] === 'tests') && parts.length > 2 ? `${parts[0]}/${parts[1]}` : parts[0];
}

/** @param {string} text @param {string} kind @param {ReturnType<typeof readList>} list
 * @returns {{line: number, word: string, instead: string}[]} */
export function findings(text, kind, list) {
  let prose = TEXT[kind](text);
  for (const regex of list.allowed) prose = prose.replace(regex, blank);
  return list.banned.flatMap(({ regex, instead }) =>
    [...prose.matchAll(regex)].map((match) => ({ line: prose.slice(0, match.index).split('\n').length, word: match[0], instead })),
  );
}

/** @param {string} root @param {string} [folder] @returns {string[]} */
function filesIn(root, folder = '') {
  return readdirSync(join(root, folder), { withFileTypes: true }).flatMap((entry) => {
    const path = folder ? `${folder}/${entry.name}` : entry.name;
    if (entry.isDirectory()) return /^(?:\.|node_modules$|build$)/.test(entry.name) ? [] : filesIn(root, path);
    return [path];
  });
}

/** @param {string} root @returns {{counts: Record<string, number>, found: string[]}} */
export function count(root) {
  const list = readList(readFileSync(join(root, HERE, 'words.txt'), 'utf8'));
  const files = filesIn(root).sort();
  /** @type {Record<string, number>} */
  const counts = {};
  const found = [];
  for (const file of files) {
    const kind = KINDS.find(([ending]) => /** @type {RegExp} */ (ending).test(file))?.[1];
    if (!kind || SKIP.some((pattern) => pattern.test(file))) continue;
    const room = roomOf(file);
    counts[room] ??= 0;
    for (const { line, word, instead } of findings(readFileSync(join(root, file), 'utf8'), /** @type {string} */ (kind), list)) {
      counts[room]++;
      found.push(`${file}:${line}: "${word}"; write: ${instead}`);
    }
  }
  return { counts, found };
}

/** @param {string} root @returns {Record<string, number>} */
function limitsOf(root) {
  const path = join(root, HERE, 'words.csv');
  if (!existsSync(path)) return {};
  return Object.fromEntries(
    readFileSync(path, 'utf8')
      .trim()
      .split('\n')
      .slice(1)
      .map((line) => {
        const [room, limit] = line.split(',');
        return [room, Number(limit)];
      }),
  );
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const root = argv[2] ?? '.';
  const { counts, found } = count(root);
  const limits = limitsOf(root);
  const more = Object.keys(counts).filter((room) => counts[room] > (limits[room] ?? 0));
  if (argv.includes('--list')) for (const line of found) console.log(line);
  else for (const line of found) if (more.includes(roomOf(line.split(':')[0]))) console.log(line);
  for (const room of Object.keys(counts).sort()) {
    const limit = limits[room] ?? 0;
    if (counts[room] !== limit) console.log(`${room}: ${counts[room]} banned words, ${limit} allowed`);
  }
  const sum = (/** @type {Record<string, number>} */ of) => Object.values(of).reduce((a, b) => a + b, 0);
  const update = argv.includes('--update') && (sum(counts) <= sum(limits) || Object.keys(limits).length === 0);
  if (update)
    writeFileSync(
      join(root, HERE, 'words.csv'),
      `room,count\n${Object.keys(counts)
        .sort()
        .map((room) => `${room},${counts[room]}\n`)
        .join('')}`,
    );
  console.log(`${Object.keys(counts).length} rooms, ${found.length} findings`);
  process.exitCode = Object.keys(counts).length > 0 && (more.length === 0 || update) ? 0 : 1; // not exit(): output to a pipe may be waiting
}
