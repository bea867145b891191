// A campaign of the fuzzers, which goes on where the last one ended: what was executed is added to bench/results/fuzz.csv, and what was
// found is kept in build/fuzz-found/READER/.
//   node tests/fuzz/campaign.mjs [--build=fuzz|fuzz-plain] [--runs=1e7] [--seconds=600] READER...   # in all, of earlier campaigns too
//   node tests/fuzz/campaign.mjs --minimise READER...   # what covers more than tests/fuzz/corpus/READER goes there
// The programs are made by: cmake --preset fuzz && cmake --build --preset fuzz --target tests_fuzz   (or fuzz-plain)
import { execFileSync, spawn } from 'node:child_process';
import { createHash } from 'node:crypto';
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const TABLE = path.join(process.env.BENCH_RESULTS ?? path.join(ROOT, 'bench/results'), 'fuzz.csv');
const COLUMNS = {
  reader: 'the program tests/fuzz/fuzz_READER.c',
  build: 'fuzz: address and undefined-behaviour sanitizers; fuzz-plain: without',
  executions: 'of all campaigns of that build',
  seconds: 'of wall time, at nice 19, while the machine does other work',
  edges: 'of the code that were reached, at the end of the last campaign',
  corpus: 'inputs that reach them',
  crashes: 'inputs that broke a rule, in all',
  commit: 'of the last campaign',
  date: '',
};
const LARGEST = 4096;

const words = process.argv.slice(2),
  option = (name, standard) => words.find((word) => word.startsWith(`--${name}=`))?.split('=')[1] ?? standard;
const names = words.filter((word) => !word.startsWith('--')),
  build = option('build', 'fuzz');
const runs = Number(option('runs', 1e7)),
  seconds = Number(option('seconds', 600));

const folder = (/** @type {string[]} */ ...parts) => {
  const name = path.join(ROOT, ...parts);
  mkdirSync(name, { recursive: true });
  return name;
};
const program = (name) => path.join(ROOT, 'build', build, 'tests/fuzz', `fuzz_${name}`);
const corpus = (name) => folder('tests/fuzz/corpus', name);

// ---- the table ----

function rows() {
  if (!existsSync(TABLE)) return [];
  const [head, ...lines] = readFileSync(TABLE, 'utf8')
    .trim()
    .split('\n')
    .filter((line) => !line.startsWith('#'))
    .map((line) => line.split(','));
  return lines.map((cells) => Object.fromEntries(head.map((name, i) => [name, cells[i]])));
}

function save(all) {
  const names = Object.keys(COLUMNS);
  const lines = [
    ...Object.entries(COLUMNS).map(([name, text]) => `# ${name}: ${text}`),
    names.join(','),
    ...all
      .sort((a, b) => (`${a.reader} ${a.build}` < `${b.reader} ${b.build}` ? -1 : 1))
      .map((row) => names.map((name) => row[name]).join(',')),
  ];
  writeFileSync(TABLE, `${lines.join('\n')}\n`);
}

// ---- a campaign ----

/** @type {import('node:child_process').ChildProcess | undefined} */
let running;
for (const signal of ['SIGINT', 'SIGTERM']) process.on(signal, () => running?.kill('SIGINT')); // it ends with its figures

/** @returns {Promise<string>} what libFuzzer said */
function run(name, args) {
  return new Promise((resolve) => {
    const child = (running = spawn('nice', ['-n', '19', program(name), ...args], { cwd: ROOT, stdio: ['ignore', 'ignore', 'pipe'] }));
    let text = '';
    child.stderr.setEncoding('utf8').on('data', (more) => {
      text = (text + more).slice(-20000);
    });
    child.on('close', () => resolve(text));
  });
}

async function campaign(name) {
  const found = folder('build/fuzz-found', name),
    work = folder('build/fuzz-corpus', name);
  const before = rows().find((row) => row.reader === name && row.build === build) ?? {
    executions: '0',
    seconds: '0',
    crashes: '0',
    edges: '',
    corpus: '',
  };
  const left = runs - Number(before.executions);
  if (left <= 0) return;
  const crashes = () => readdirSync(found).filter((file) => /^(crash|timeout|oom|leak)-/.test(file)).length,
    had = crashes();
  const from = performance.now();
  const text = await run(name, [
    `-runs=${left}`,
    `-max_total_time=${seconds}`,
    `-max_len=${LARGEST}`,
    '-print_final_stats=1',
    '-timeout=25',
    '-rss_limit_mb=4096',
    '-detect_leaks=0',
    '-close_fd_mask=3',
    `-artifact_prefix=${found}/`,
    work,
    corpus(name),
  ]);
  const last = [...text.matchAll(/^#(\d+)\s.*cov: (\d+) ft: \d+ corp: (\d+)/gm)].pop();
  const executed = Number(/stat::number_of_executed_units:\s*(\d+)/.exec(text)?.[1] ?? last?.[1] ?? 0);
  const fresh = crashes() - had;
  const row = {
    reader: name,
    build,
    executions: Number(before.executions) + executed,
    seconds: Math.round(Number(before.seconds) + (performance.now() - from) / 1000),
    edges: last?.[2] ?? before.edges,
    corpus: last?.[3] ?? before.corpus,
    crashes: Number(before.crashes) + fresh,
    commit: execFileSync('git', ['rev-parse', '--short=12', 'HEAD'], { cwd: ROOT, encoding: 'utf8' }).trim(),
    date: `${new Date().toISOString().slice(0, 16)}Z`,
  };
  save([...rows().filter((other) => !(other.reader === name && other.build === build)), row]);
  console.log(`${name}: ${executed} executions, ${row.executions} in all, ${row.edges} edges, ${fresh} new crashes`);
  if (fresh > 0 || executed === 0) console.log(text.slice(-3000));
}

// ---- the corpus that is committed ----

async function minimise(name) {
  const all = [folder('build/fuzz-corpus', name), corpus(name)],
    small = path.join(ROOT, 'build/fuzz-small', name);
  rmSync(small, { recursive: true, force: true });
  mkdirSync(small, { recursive: true });
  // Edges alone: how often each is passed would keep thousands. What is committed already goes first, and is kept.
  for (const from of [corpus(name), ...all])
    await run(name, ['-merge=1', '-use_counters=0', `-max_len=${LARGEST}`, '-close_fd_mask=3', small, from]);
  const hash = (file) => createHash('sha1').update(readFileSync(file)).digest('hex');
  const kept = new Set(readdirSync(corpus(name)).map((file) => hash(path.join(corpus(name), file))));
  let added = 0;
  for (const file of readdirSync(small)) {
    const whole = path.join(small, file);
    if (statSync(whole).size > LARGEST || kept.has(hash(whole))) continue;
    writeFileSync(path.join(corpus(name), `found_${hash(whole).slice(0, 12)}`), readFileSync(whole));
    added++;
  }
  console.log(`${name}: ${added} inputs more`);
}

for (const name of names) await (words.includes('--minimise') ? minimise(name) : campaign(name));
