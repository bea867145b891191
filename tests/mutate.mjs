// Mutation testing: `./dev mutate N SEED` draws N places of src, changes one line at a time, and says which test notices.
//
//   node tests/mutate.mjs N SEED [--jobs=2] [--list]        --list only prints what would be tried
//   --near                                                  only short tests of the room; those from outside where it has none
//   node tests/mutate.mjs --again=FILE [--result=survived]  tries the lines of an earlier table again, where they still stand
//
// The tree is not touched: each job has a copy of its own in build/mutants, with a build at -O1. For each mutant run the tests of its
// room, those of the rooms above, and those from outside of the table OUTSIDE, each time the shortest first, until one fails. A test that
// fails for the first time is run once more without the change; where it fails then, too, it is left out from there on. A mutant that does
// not compile, and one that gives the same machine code, is replaced by the next draw. The table: build/mutants/mutants.csv.
import { spawn } from 'node:child_process';
import { createHash } from 'node:crypto';
import {
  appendFileSync,
  copyFileSync,
  existsSync,
  mkdirSync,
  readFileSync,
  readdirSync,
  rmSync,
  statSync,
  symlinkSync,
  writeFileSync,
} from 'node:fs';
import { availableParallelism, setPriority } from 'node:os';
import path from 'node:path';
import { argv, execPath } from 'node:process';
import { fileURLToPath } from 'node:url';
import { parseCsv } from './lib/csv.mjs';
import { withoutComments, withoutLiterals } from './structure/c.mjs';
import { below, readRooms } from './structure/rooms.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '..');
const COLUMNS = ['room', 'file', 'line', 'kind', 'before', 'after', 'result', 'by', 'seconds'];
const UNKNOWN_S = 600; // the limit of a test that has not passed yet

// What else notices a change: tests from outside, which ctest does not run. The nearest folder counts.
export const OUTSIDE = {
  cli: ['api/trace', 'api/scripts', 'api/reproduce', 'api/workflows', 'api/merge', 'api/cli'],
  'daemon/api': [
    'api/notices',
    'api/idempotency',
    'api/openapi',
    'api/query',
    'api/access',
    'api/contract',
    'api/class',
    'api/experiments',
    'api/answers',
  ],
  'daemon/class': ['daemon/class_keys', 'daemon/class_restart', 'api/access_matrix', 'api/class'],
  'daemon/hosting': [
    'api/notices',
    'api/idempotency',
    'daemon/paused',
    'daemon/hosting',
    'daemon/recovery',
    'api/input',
    'api/contract',
    'daemon/quotas',
  ],
  'daemon/http': ['api/openapi', 'api/query', 'api/access', 'daemon/wire'],
  'daemon/jobs': ['api/advise', 'api/experiments', 'api/tradeoffs', 'daemon/measurements'],
  'daemon/listener': ['api/access', 'api/input', 'daemon/idle', 'daemon/wire'],
  'daemon/net': ['api/access', 'api/input', 'daemon/wire'],
  'daemon/serve': ['api/access', 'daemon/failure', 'daemon/recovery', 'api/cli'],
  'daemon/store': ['daemon/store', 'daemon/recovery', 'daemon/failure', 'api/experiments'],
  'daemon/stream': ['api/input', 'api/contract', 'daemon/idle', 'daemon/wire'],
  'daemon/support': ['api/openapi', 'api/access', 'api/query', 'daemon/class_keys'],
  embed: ['api/c_library'],
  experiment: ['api/trace', 'api/reproduce', 'api/advise', 'api/tradeoff', 'api/experiments', 'api/merge'],
  fluid: ['api/metrics'],
  game: ['api/metrics'],
  input: ['api/input'],
  library: ['api/trace', 'api/contract', 'api/cli'],
  link: ['api/metrics'],
  'main.c': ['api/trace', 'api/cli'],
  netcode: ['api/metrics'],
  ode: ['api/metrics'],
  param: ['api/openapi'],
  record: ['api/decoder', 'api/openapi', 'api/metrics'],
  rigid: ['api/rigid', 'api/metrics'],
  session: ['daemon/paused', 'api/input', 'daemon/recovery', 'api/packets.all'],
  sim: ['api/metrics'],
};

/** Numbers from 0 to below 1, the same for each seed. @param {number} seed */
export function numbers(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let x = Math.imul(state ^ (state >>> 15), state | 1);
    x ^= x + Math.imul(x ^ (x >>> 7), x | 61);
    return ((x ^ (x >>> 14)) >>> 0) / 4294967296;
  };
}

// ---- what may be changed ----

const SWAPS = {
  comparison: { '<': '<=', '<=': '<', '>': '>=', '>=': '>', '==': '!=', '!=': '==' },
  arithmetic: { '+': '-', '-': '+', '*': '/', '/': '*', '+=': '-=', '-=': '+=', '*=': '/=', '/=': '*=' },
  logical: { '&&': '||', '||': '&&' },
};

/** Where the bracket that opens at `from` is closed, or -1. */
function closing(code, from) {
  let depth = 0;
  for (let i = from; i < code.length; i++) {
    if ('([{'.includes(code[i])) depth++;
    else if (')]}'.includes(code[i]) && --depth === 0) return i;
  }
  return -1;
}

/** Every change of one line of a C file: what stands at `at` with a length of `length` becomes `text`. Only bodies of functions, which
 * begin and end with a brace at the start of a line; without comments, literals, directives and assertions.
 * @param {string} source @returns {{line: number, kind: string, at: number, length: number, text: string}[]} */
export function changes(source) {
  const blank = (text) => text.replace(/[^\n]/g, ' ');
  let code = withoutLiterals(withoutComments(source)).replace(/^[ \t]*#(?:[^\n]*\\\n)*[^\n]*/gm, blank);
  for (const match of [...code.matchAll(/\b(?:LL_ASSERT|assert|_Static_assert|static_assert)\s*\(/g)]) {
    const end = closing(code, match.index + match[0].length - 1) + 1;
    code = code.slice(0, match.index) + blank(code.slice(match.index, end)) + code.slice(end);
  }
  // Between the bodies stand declarations and tables.
  let inside = false;
  code = code
    .split('\n')
    .map((line) => {
      if (line.startsWith('{')) inside = true;
      if (line.startsWith('}')) inside = false;
      return inside ? line : blank(line);
    })
    .join('\n');
  const found = [];
  const add = (kind, at, length, text) => {
    const line = code.slice(0, at).split('\n').length;
    if (!source.slice(at, at + length).includes('\n')) found.push({ line, kind, at, length, text });
  };
  for (const [kind, swaps] of Object.entries(SWAPS))
    for (const { 0: operator, index } of code.matchAll(/(?<=\s)(?:[-+*/]=?|[<>]=?|[=!]=|&&|\|\|)(?=\s)/g))
      if (operator in swaps) add(kind, index, operator.length, swaps[operator]);
  for (const { 0: number, 1: whole, index } of code.matchAll(/(?<![\w.])(\d+)(?:\.\d*)?(?:[eE][-+]?\d+)?[uUlLfF]*(?![\w.])/g))
    add('constant', index, number.length, String(Number(whole) + 1) + number.slice(whole.length));
  for (const { 0: word, index } of code.matchAll(/\b(?:true|false)\b/g))
    add('constant', index, word.length, word === 'true' ? 'false' : 'true');
  for (const { 0: head, index } of code.matchAll(/\b(?:if|while) \(/g)) {
    const open = index + head.length - 1,
      end = closing(code, open);
    if (end > 0) add('condition', open, end + 1 - open, `(!${source.slice(open, end + 1)})`);
  }
  for (const { 0: step, index } of code.matchAll(/\+\+|--/g)) add('step', index, 2, step === '++' ? '--' : '++');
  // A statement on a line of its own: a call or an assignment, not a declaration, which has a space before its name.
  let at = 0,
    last = '{';
  for (const text of code.split('\n')) {
    const [, space, statement] = /^(\s*)(.*?)\s*$/.exec(text);
    const whole =
      /^(?!return\b)\w+\(.*\);$/.test(statement) ||
      /^[*(]*[a-z_]\w*\)?(?:->|\.|\w|\[[^=\]]*\]|\([^=]*\))* (?:[-+*/|&^%]|<<|>>)?= .*;$/.test(statement);
    if (whole && /(?:[;{}):]|\belse)$/.test(last)) add('removed', at + space.length, statement.length, ';');
    if (statement !== '') last = statement;
    at += text.length + 1;
  }
  for (const { 0: statement, 1: value, index } of code.matchAll(/\breturn ([^;\n]+);/g))
    if (!/^(?:0|NULL|true|false|ll_ok\(\))$/.test(value)) add('returned', index, statement.length, 'return 0;');
  return found.sort((a, b) => a.at - b.at || a.length - b.length);
}

const roomOf = (file) => file.split('/')[1];

/** All files of a tree's src that hold code. @param {string} root @returns {string[]} */
const sources = (root) =>
  readdirSync(path.join(root, 'src'), { recursive: true, encoding: 'utf8' })
    .filter((name) => /\.(?:c|h|inc)$/.test(name))
    .map((name) => `src/${name}`)
    .sort();

/** One change as a mutant: the whole line before and after. */
function mutant(file, source, change) {
  const begin = source.lastIndexOf('\n', change.at) + 1,
    end = source.indexOf('\n', change.at),
    text = source.slice(0, change.at) + change.text + source.slice(change.at + change.length);
  return {
    room: roomOf(file),
    file,
    line: change.line,
    kind: change.kind,
    before: source.slice(begin, end).trim(),
    after: text.slice(begin, end + text.length - source.length).trim(),
    text,
  };
}

/** For each room the order in which its mutants are tried: first a line is drawn, then one of its changes; and how many are wanted of each
 * room, one at least where there are enough, the others by lines. @param {string} root @param {number} count @param {number} seed */
export function draw(root, count, seed) {
  const next = numbers(seed),
    rooms = new Map();
  for (const file of sources(root)) {
    const byLine = new Map();
    const source = readFileSync(path.join(root, file), 'utf8');
    for (const change of changes(source)) byLine.set(change.line, [...(byLine.get(change.line) ?? []), change]);
    const list = rooms.get(roomOf(file)) ?? [];
    list.push(...[...byLine.values()].map((all) => ({ file, source, all })));
    if (list.length > 0) rooms.set(roomOf(file), list);
  }
  for (const [, list] of rooms)
    for (let i = list.length - 1; i >= 0; i--) {
      const j = Math.floor(next() * (i + 1)); // Fisher and Yates
      [list[i], list[j]] = [list[j], list[i]];
      list[i].change = list[i].all[Math.floor(next() * list[i].all.length)];
    }
  const names = [...rooms.keys()],
    total = names.reduce((sum, name) => sum + rooms.get(name).length, 0),
    slots = count >= names.length ? [...names] : [];
  while (slots.length < Math.min(count, total)) {
    let at = next() * total;
    const name = names.find((one) => (at -= rooms.get(one).length) < 0) ?? names[names.length - 1];
    if (slots.filter((one) => one === name).length < rooms.get(name).length) slots.push(name);
  }
  return { rooms, slots };
}

// ---- a copy of the tree, its build and its tests ----

/** Runs a command in a group of its own, which ends with it.
 * @returns {Promise<{status: number | null, text: string, seconds: number, late: boolean}>} */
function run(command, args, { cwd, env = {}, seconds = 3600 }) {
  return new Promise((resolve) => {
    const begin = Date.now(),
      child = spawn(command, args, { cwd, env: { ...process.env, ...env }, detached: true, stdio: ['ignore', 'pipe', 'pipe'] });
    let text = '',
      late = false;
    const stop = () => {
      try {
        process.kill(-(child.pid ?? 0), 'SIGKILL');
      } catch {} // it has ended
    };
    const timer = setTimeout(() => {
      late = true;
      stop();
    }, seconds * 1000);
    const keep = (data) => {
      if (text.length < 1 << 24) text += data;
    };
    child.stdout.on('data', keep);
    child.stderr.on('data', keep);
    child.on('error', (error) => keep(error.message));
    child.on('exit', (status) => {
      clearTimeout(timer);
      stop(); // what it has left behind
      child.stdout.destroy();
      child.stderr.destroy();
      setImmediate(() => resolve({ status, text, seconds: (Date.now() - begin) / 1000, late }));
    });
  });
}

class Copy {
  constructor(number) {
    this.root = path.join(ROOT, 'build/mutants', String(number));
    this.build = path.join(this.root, 'build');
    this.objects = new Map();
    this.tests = new Map();
  }

  async prepare() {
    const listed = await run('git', ['ls-files', '-z', '-co', '--exclude-standard'], { cwd: ROOT });
    if (listed.status !== 0) throw new Error(`git: ${listed.text}`);
    const files = listed.text.split('\0').filter((name) => name && existsSync(path.join(ROOT, name)));
    for (const name of readdirSync(this.root, { recursive: true, encoding: 'utf8' }).filter((one) => /^(?:src|tests)\//.test(one)))
      if (!files.includes(name) && statSync(path.join(this.root, name)).isFile()) rmSync(path.join(this.root, name));
    for (const name of files) {
      const to = path.join(this.root, name),
        from = path.join(ROOT, name);
      if (existsSync(to) && readFileSync(to).equals(readFileSync(from))) continue;
      mkdirSync(path.dirname(to), { recursive: true });
      copyFileSync(from, to);
    }
    if (!existsSync(path.join(this.root, 'node_modules')))
      symlinkSync(path.join(ROOT, 'node_modules'), path.join(this.root, 'node_modules'));
    const options = ['-DCMAKE_BUILD_TYPE=Release', '-DLAGLAB_OPTIMISE=-O1', '-DLAGLAB_LTO=OFF', '-DLAGLAB_WERROR=OFF', '-DLAGLAB_TESTS=ON'];
    const configured = await run('cmake', ['-S', '.', '-B', 'build', '-G', 'Ninja', ...options], { cwd: this.root });
    if (configured.status !== 0) throw new Error(configured.text);
    const built = await this.ninja(['all']);
    if (built.status !== 0) throw new Error(built.text);
    for (const [name, hash] of this.changedObjects(0)) this.objects.set(name, hash);
    const shown = await run('ctest', ['--test-dir', 'build', '--show-only=json-v1'], { cwd: this.root });
    const of = (one, name) => one.properties.find((property) => property.name === name)?.value ?? [];
    this.units = JSON.parse(shown.text.slice(shown.text.indexOf('{')))
      .tests.filter((one) => one.command)
      .map((one) => ({
        name: one.name,
        labels: of(one, 'LABELS'),
        long: of(one, 'COST') >= 10, // seconds
        command: one.command,
        env: Object.fromEntries(of(one, 'ENVIRONMENT').map((pair) => pair.split(/=(.*)/s))),
      }))
      .filter((one) => !one.labels.includes('all'));
  }

  ninja(targets) {
    return run('ninja', ['-C', 'build', '-j', '1', ...targets], { cwd: this.root });
  }

  /** Objects that were written since, and what is in them; but for the version, which every change gives another. */
  changedObjects(since) {
    return readdirSync(path.join(this.build, 'CMakeFiles'), { recursive: true, encoding: 'utf8' })
      .filter((name) => /^laglab[a-z_]*\.dir\/.*\.o$/.test(name) && !name.endsWith('/version.c.o'))
      .map((name) => path.join(this.build, 'CMakeFiles', name))
      .filter((name) => statSync(name).mtimeMs >= since)
      .map((name) => [name, createHash('sha1').update(readFileSync(name)).digest('hex')]);
  }

  /** In limits of memory and of files, which a changed loop may want without end. */
  test(one, seconds) {
    const temporary = path.join(this.root, 'tmp');
    rmSync(temporary, { recursive: true, force: true });
    mkdirSync(temporary);
    return run('bash', ['-c', `ulimit -f 4194304 ${one.outside ? '' : '-v 16777216'}; exec "$@"`, '-', ...one.command], {
      cwd: this.root,
      env: { ...one.env, TMPDIR: temporary, LAGLAB_BIN: path.join(this.build, 'laglab') },
      seconds,
    });
  }
}

/** The tests of a file, in steps: {targets to build, tests}. Of the rooms above those of the engine count, without their longest tests.
 * @param {Copy} copy @param {string} file @param {import('./structure/rooms.mjs').Rooms} rooms @param {boolean} near */
function steps(copy, file, rooms, near) {
  const room = roomOf(file),
    top = (name) => name.split('/')[0],
    above = [...rooms.may.keys()].filter(
      (one) => rooms.pure.includes(top(one)) && [...below(rooms, one)].some((name) => top(name) === room),
    ),
    upper = new Set(above.map(top).filter((name) => name !== room));
  if (upper.has('session') || room === 'session') upper.add('golden').add('oracle');
  const labelled = (label) => copy.units.filter((one) => one.labels.includes(label)),
    higher = [...upper].flatMap(labelled).filter((one) => !one.labels.includes(room) && !one.long);
  let folder = path.dirname(file.slice(4));
  if (!(folder in OUTSIDE)) folder = room;
  const outside = (OUTSIDE[folder] ?? [])
    .map((name) => ({ name, outside: true, command: [execPath, '--test', `tests/${name}.test.mjs`], env: {} }))
    .filter((one) => existsSync(path.join(copy.root, one.command[2])));
  const targets = (names) => [...names].filter((name) => name !== 'oracle' && labelled(name).length > 0).map((name) => `tests_${name}`);
  const own = labelled(room).filter((one) => !near || !one.long);
  return [
    { targets: targets([room]), tests: own },
    { targets: targets(upper), tests: near ? [] : higher },
    { targets: ['api', ...(room === 'embed' ? ['liblaglab', 'www'] : [])], tests: near && own.length > 0 ? [] : outside },
  ].filter(({ tests }) => tests.length > 0);
}

const EOF_ROW = '\r\n';
const field = (value) => (/[",\r\n]/.test(String(value)) ? `"${String(value).replaceAll('"', '""')}"` : String(value));

/** @param {any} row */
const csvRow = (row) => COLUMNS.map((name) => field(row[name])).join(',') + EOF_ROW;

/** What is known of tests: seconds of the last time that one passed; whether it passed without a change once; or whether it does not. */
class Known {
  seconds = new Map();
  passes = new Set();
  fails = new Set();
}

/** Tries one mutant.
 * @param {Copy} copy @param {ReturnType<typeof mutant>} one @param {import('./structure/rooms.mjs').Rooms} rooms @param {Known} known
 * @param {boolean} near only short tests of the room itself */
async function attempt(copy, one, rooms, known, near) {
  const file = path.join(copy.root, one.file),
    original = readFileSync(file, 'utf8'),
    begin = Date.now();
  const outcome = (result, by = '') => ({ result, by, seconds: ((Date.now() - begin) / 1000).toFixed(1) });
  const fails = async (test) => {
    const result = await copy.test(test, known.seconds.has(test.name) ? 60 + 10 * known.seconds.get(test.name) : UNKNOWN_S);
    if (result.status === 0) known.seconds.set(test.name, result.seconds);
    return result.status === 0 ? '' : result.late ? `${test.name} (time)` : test.name;
  };
  const withoutChange = async (targets, test) => {
    writeFileSync(file, original);
    await copy.ninja(targets);
    const good = !(await fails(test));
    (good ? known.passes : known.fails).add(test.name);
    if (good) return true;
    console.log(`left out: ${test.name} fails without a change`);
    writeFileSync(file, one.text);
    await copy.ninja(targets);
    return false;
  };
  writeFileSync(file, one.text);
  try {
    const all = steps(copy, one.file, rooms, near),
      [first] = all;
    const made = one.room === 'embed' ? ['laglab', 'liblaglab'] : first.targets.includes(`tests_${one.room}`) ? first.targets : ['laglab'];
    if ((await copy.ninja(made)).status !== 0) return outcome('not built');
    if (copy.changedObjects(begin - 1000).every(([name, hash]) => copy.objects.get(name) === hash)) return outcome('same code');
    const time = (test) => known.seconds.get(test.name) ?? (test.long ? 60 : 1);
    for (const { targets, tests } of all) {
      if (targets !== made && (await copy.ninja(targets)).status !== 0) return outcome('caught', 'the build');
      for (const test of tests.sort((a, b) => time(a) - time(b))) {
        if (known.fails.has(test.name)) continue;
        const by = await fails(test);
        if (by && (known.passes.has(test.name) || (await withoutChange(targets, test)))) return outcome('caught', by);
      }
    }
    return outcome('survived');
  } finally {
    writeFileSync(file, original);
  }
}

/** The lines of an earlier table, where they stand now. */
function earlier(file, wanted) {
  const [head, ...rows] = parseCsv(readFileSync(file, 'utf8').replace(/^(?:# .*\n)*/, ''));
  return rows
    .map((row) => Object.fromEntries(head.map((name, i) => [name, row[i]])))
    .filter((row) => wanted === '' || row.result === wanted)
    .flatMap((row) => {
      const source = existsSync(path.join(ROOT, row.file)) ? readFileSync(path.join(ROOT, row.file), 'utf8') : '',
        same = changes(source)
          .map((change) => mutant(row.file, source, change))
          .filter((one) => one.before === row.before && one.after === row.after);
      same.sort((a, b) => Math.abs(a.line - Number(row.line)) - Math.abs(b.line - Number(row.line)));
      if (same.length === 0) console.log(`gone: ${row.file}:${row.line} ${row.before}`);
      return same.slice(0, 1);
    });
}

async function main() {
  const options = argv.slice(2).filter((word) => word.startsWith('--')),
    numerals = argv.slice(2).filter((word) => !word.startsWith('--')),
    [count, seed] = numerals.map(Number),
    option = (name, fallback) => options.find((word) => word.startsWith(`--${name}=`))?.replace(/^[^=]*=/, '') ?? fallback;
  const again = option('again', ''),
    jobs = Number(option('jobs', Math.min(2, availableParallelism())));
  const strange = options.filter((word) => !/^--(?:list|near|jobs=[12]|again=.+|result=.*)$/.test(word));
  if (again !== '' && !existsSync(again)) {
    console.error(`--again: there is no file ${again}`);
    process.exit(2);
  }
  if (
    strange.length > 0 ||
    numerals.length !== (again === '' ? 2 : 0) ||
    (again === '' && !(Number.isInteger(count) && count > 0 && Number.isInteger(seed) && seed >= 0))
  ) {
    console.error(`mutate takes N (1 or more) and SEED (0 or more), or --again=FILE; got ${argv.slice(2).join(' ') || 'nothing'}`);
    process.exit(2);
  }
  const { rooms: queues, slots } = again ? { rooms: new Map([['', []]]), slots: [] } : draw(ROOT, count, seed);
  const listed = again ? earlier(again, option('result', '')) : [];
  const next = (room) => {
    if (again) return listed.shift();
    const drawn = queues.get(room)?.shift();
    return drawn && mutant(drawn.file, drawn.source, drawn.change);
  };
  if (again) slots.push(...listed.map(() => ''));
  if (options.includes('--list')) {
    for (const room of slots) process.stdout.write(csvRow({ ...next(room), result: '', by: '', seconds: '' }));
    return;
  }
  setPriority(10);
  const table = path.join(ROOT, 'build/mutants/mutants.csv'),
    copies = Array.from({ length: jobs }, (_, i) => new Copy(i + 1)),
    rooms = readRooms(path.join(ROOT, 'tests/structure/rooms.txt')),
    known = new Known();
  for (const copy of copies) mkdirSync(copy.root, { recursive: true });
  console.log(`${slots.length} mutants`);
  writeFileSync(table, COLUMNS.join(',') + EOF_ROW);
  const rows = [];
  let ready = Promise.resolve(); // one copy after the other: a cache of the compiler then has what the second one needs
  await Promise.all(
    copies.map(async (copy) => {
      await (ready = ready.then(() => copy.prepare()));
      for (let room = slots.shift(); room !== undefined; room = slots.shift())
        for (let one = next(room), done = false; one && !done; one = done ? one : next(room)) {
          const row = { ...one, ...(await attempt(copy, one, rooms, known, options.includes('--near'))) };
          rows.push(row);
          appendFileSync(table, csvRow(row));
          process.stdout.write(csvRow(row));
          done = again !== '' || row.result === 'caught' || row.result === 'survived';
        }
    }),
  );
  rows.sort((a, b) => (a.file < b.file ? -1 : a.file > b.file ? 1 : a.line - b.line));
  writeFileSync(table, COLUMNS.join(',') + EOF_ROW + rows.map(csvRow).join(''));
  const of = (result, room) => rows.filter((row) => row.result === result && (room === undefined || row.room === room)).length;
  console.log('\nroom            caught  survived  not built  same code');
  for (const room of [...new Set(rows.map((row) => row.room)), undefined])
    console.log(
      (room ?? 'all').padEnd(14) +
        String(of('caught', room)).padStart(8) +
        String(of('survived', room)).padStart(10) +
        String(of('not built', room)).padStart(11) +
        String(of('same code', room)).padStart(11),
    );
  const tried = of('caught') + of('survived');
  console.log(`caught: ${of('caught')} of ${tried} (${Math.round((100 * of('caught')) / tried)} %)`);
}

if (argv[1] === fileURLToPath(import.meta.url)) await main();
