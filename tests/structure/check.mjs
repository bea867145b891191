// Checks what the sources may include and call: node tests/structure/check.mjs ROOT
//   1. A file lies in a room, and a room uses only what tests/structure/rooms.txt lets it: by #include, by a function or a
//      table that another file defines, by a struct that another file lays out.
//   2. No files of a room use each other in a circle.
//   3. The pure rooms take time and randomness as arguments, read no file, and call no libm function whose last bit differs
//      between libm versions (base/detmath.h has ours). Those that are named allocate nothing.
//   4. Every function that other files can see starts with ll_, or in the room of the C library with laglab_.
import { readdirSync, readFileSync } from 'node:fs';
import { basename, dirname, join, relative } from 'node:path';
import { argv, exit } from 'node:process';
import { fileURLToPath } from 'node:url';
import { definitions, identifiers, lineOf, withoutComments, withoutLiterals } from './c.mjs';
import { below, circle, readRooms } from './rooms.mjs';

const IMPURE = [
  'rand',
  'srand',
  'rand_r',
  'random',
  'srandom',
  'drand48',
  'time',
  'clock',
  'clock_gettime',
  'gettimeofday',
  'timespec_get',
  'getenv',
  'secure_getenv',
  'fopen',
  'open',
  'readlink',
  'opendir',
];
const LIBM = [
  'sin',
  'cos',
  'tan',
  'sincos',
  'asin',
  'acos',
  'atan',
  'atan2',
  'sinh',
  'cosh',
  'tanh',
  'asinh',
  'acosh',
  'atanh',
  'exp',
  'exp2',
  'expm1',
  'log',
  'log2',
  'log10',
  'log1p',
  'pow',
  'cbrt',
  'hypot',
  'erf',
  'erfc',
  'tgamma',
  'lgamma',
];
const ALLOCATING = [
  'malloc',
  'calloc',
  'realloc',
  'reallocarray',
  'aligned_alloc',
  'posix_memalign',
  'strdup',
  'strndup',
  'asprintf',
  'alloca',
];
const MODULES_MAX = 20;

/** A call, not a member that happens to have the name. @param {string[]} names */
const callOf = (...names) => new RegExp(`(?<![\\w.]|->)(?:${names.join('|')})(?=\\s*\\()`, 'g');
const FORBIDDEN = callOf(...IMPURE, `(?:${LIBM.join('|')})[fl]?`),
  ALLOCATION = callOf(...ALLOCATING);

function sources(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return sources(path);
    return /\.(?:c|h|inc)$/.test(entry.name) ? [path] : [];
  });
}

function readTree(src) {
  return sources(src)
    .sort()
    .map((path) => {
      const name = relative(src, path),
        text = readFileSync(path, 'utf8'),
        code = withoutLiterals(text);
      const includes = [...withoutComments(text).matchAll(/^[ \t]*#\s*include\s*"([^"]*)"/gm)].map((match) => ({
        line: lineOf(text, match.index),
        name: match[1].includes('/') ? match[1] : join(dirname(name), match[1]),
      }));
      return { name, room: name.includes('/') ? dirname(name) : name, code, includes, ...definitions(code) };
    });
}

/** Which file defines it. Headers own structs, the other files what the linker sees. */
function owners(files) {
  const symbols = new Map(),
    structs = new Map();
  for (const file of files) {
    for (const { name } of file.defined) if (!file.name.endsWith('.h')) symbols.set(name, file);
    for (const name of file.structs) structs.set(name, [...(structs.get(name) ?? []), file]);
  }
  return { symbols, structs };
}

/** Every use of another file: what is used, how it is called in a finding, in which line.
 * @param {(room: string) => boolean} may of two structs of one name, that which the file may use is meant */
function uses(file, byName, { symbols, structs }, may) {
  const found = [];
  for (const { line, name } of file.includes) {
    const other = byName.get(name);
    found.push(other ? { line, other, how: `includes "${name}"`, edge: true } : { line, how: `includes "${name}", which is in no room` });
  }
  for (const { name, line, inside, tag } of identifiers(file.code)) {
    const other = tag ? (structs.get(name)?.find((owner) => may(owner.room)) ?? structs.get(name)?.[0]) : symbols.get(name);
    // A header that only declares what another file defines does not use it.
    if (!other || other === file || (!tag && file.name.endsWith('.h') && !inside)) continue;
    found.push({ line, other, how: tag ? `knows struct ${name} of ${other.name}` : `uses ${name} of ${other.name}`, edge: !tag });
  }
  return found;
}

function checkUses(files, rooms, known) {
  const findings = [],
    byName = new Map(files.map((file) => [file.name, file])),
    owned = owners(files);
  const excused = new Set();
  for (const file of files) {
    const seen = new Set(),
      allowed = below(rooms, file.room),
      may = (room) => room === file.room || allowed.has(room);
    file.edges = new Set();
    for (const use of uses(file, byName, owned, may)) {
      if (!use.other) {
        findings.push([file, use.line, use.how]);
        continue;
      }
      const room = use.other.room;
      if (use.edge) file.edges.add(use.other.name);
      if (may(room) || !known.has(room) || seen.has(use.how)) continue;
      seen.add(use.how);
      const exception = rooms.exceptions.find((row) => row.file === file.name && row.other === use.other.name);
      if (exception) excused.add(exception);
      else findings.push([file, use.line, `${file.room} ${use.how}, and may not use ${room}`]);
    }
  }
  for (const row of rooms.exceptions)
    if (!excused.has(row)) findings.push([{ name: row.file }, 1, `the exception for ${row.other} is not needed`]);
  return findings;
}

/** Modules are x.c with x.h. A header that many files implement is no use of them, so headers and the other files are two graphs. */
function checkCircles(files, rooms) {
  const findings = [];
  for (const room of rooms.may.keys()) {
    const here = files.filter((file) => file.room === room);
    for (const headers of [true, false]) {
      const nodes = here.filter((file) => file.name.endsWith('.h') === headers),
        names = new Set(nodes.map((file) => file.name));
      const found = circle(nodes.map((file) => [file.name, [...file.edges].filter((other) => names.has(other) && other !== file.name)]));
      const excused = rooms.circles.some((row) => found?.every((name) => row.files.includes(basename(name))) && row.room === room);
      if (found && !excused)
        findings.push([here.find((file) => file.name === found[0]), 1, `in a circle: ${found.map((name) => basename(name)).join(', ')}`]);
    }
    const modules = new Set(here.map((file) => file.name.replace(/\.\w+$/, '')));
    if (modules.size > MODULES_MAX) findings.push([here[0], 1, `${room} has ${modules.size} modules, more than ${MODULES_MAX}`]);
  }
  return findings;
}

function checkPure(file, rooms) {
  const calls = (pattern) =>
    [...file.code.matchAll(pattern)].map((match) => [lineOf(file.code, match.index), `${file.room} calls ${match[0]}()`]);
  const in_ = (list) => list.some((room) => file.room === room || file.room.startsWith(`${room}/`));
  return [
    ...(in_(rooms.pure) ? calls(FORBIDDEN) : []),
    ...(in_(rooms.pure) && !in_(rooms.allocating) && !rooms.allocating.includes(file.name) ? calls(ALLOCATION) : []),
  ];
}

function checkNames(file) {
  return file.defined
    .filter(
      ({ name, call }) => call && name !== 'main' && !/^(?:ll|LL)_/.test(name) && !(file.room === 'embed' && name.startsWith('laglab_')),
    )
    .map(({ name, line }) => [line, `the public function ${name} does not start with ll_`]);
}

/** @returns {{findings: string[], files: number, rooms: number}} one line per breach, and the number of checked files */
export function check(root) {
  const rooms = readRooms(join(root, 'tests/structure/rooms.txt')),
    files = readTree(join(root, 'src')),
    known = new Set(rooms.may.keys());
  /** @type {any[]} */
  const findings = rooms.findings.map((what) => [{ name: '../tests/structure/rooms.txt' }, 1, what]);
  for (const file of files) {
    if (!known.has(file.room)) findings.push([file, 1, `${file.room} is not one of the rooms`]);
    findings.push(...[...checkPure(file, rooms), ...checkNames(file)].map((found) => [file, ...found]));
  }
  findings.push(...checkUses(files, rooms, known), ...checkCircles(files, rooms));
  const lines = findings.map(([file, line, what]) => `${join('src', file.name)}:${line}: ${what}`);
  return { findings: lines.sort(), files: files.length, rooms: known.size };
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const { findings, files, rooms } = check(argv[2] ?? '.');
  for (const finding of findings) console.log(finding);
  console.log(`${files} files in ${rooms} rooms, ${findings.length} findings`);
  exit(files > 0 && findings.length === 0 ? 0 : 1);
}
