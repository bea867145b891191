// The guard can fail: by the functions that cost.test.mjs uses, on a program whose loop is made 5 % slower.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { git_in, heaviest, judge, raised_silently, text_before } from './guard.mjs';
import { measure, plain_name, profile_of, spans } from './profile.mjs';

const SOURCE = fileURLToPath(new URL('selftest.c', import.meta.url)),
  folder = mkdtempSync(join(tmpdir(), 'cost-selftest-'));
after(() => rmSync(folder, { recursive: true }));

/** @param {string[]} macros @returns {Promise<import('./profile.mjs').Profile>} of the program that they make */
async function measured(...macros) {
  const program = join(folder, ['selftest', ...macros].join('-'));
  execFileSync('cc', ['-O2', '-g', ...macros.map((m) => `-D${m}`), '-o', program, SOURCE]);
  return measure({ program, arguments: '{}', from: 2, to: 6, steps_per_unit: 1 });
}

/** @param {import('./profile.mjs').Profile} now @returns {[any, any[]]} what --update would commit */
const commit = (now) => [
  { instructions_per_step: now.total, why: 'first' },
  heaviest(now).map((f) => ({ function: f.function, counted: f.counted, instructions_per_step: f.count, why: 'first' })),
];

const WRITTEN = 'tests/cost/selftest.c:trace_row';
const plain = await measured(),
  [total, functions] = commit(plain);

test('a program passes against its own counts, also when it is compiled again', async () => {
  assert.deepEqual(judge(total, functions, plain), { failures: [], notes: [] });
  assert.deepEqual(judge(total, functions, await measured()), { failures: [], notes: [] });
});

test('a loop of a quarter of a case made 5 % slower fails; the case as a whole does not see it', async () => {
  const now = await measured('AGAIN=20'),
    share = (plain.compiled.get('trace_rows') ?? 0) / plain.total;
  assert.ok(share > 0.15 && share < 0.4, `trace_rows has ${share}`);
  assert.ok(now.total < plain.total * 1.03, 'the whole passes');
  const { failures } = judge(total, functions, now);
  assert.deepEqual(
    failures.map((text) => text.split(':')[0]),
    ['trace_rows (compiled)', 'tests/cost/selftest.c'],
  );
  assert.match(failures[0], /instructions per step, [4-7]\.\d+ % above the \d+ committed \(first\)/);
});

test('a loop of 50 % slower fails as a whole', async () => {
  assert.match(judge(total, functions, await measured('AGAIN=2')).failures[0], /^the whole: /);
});

test('a function that is inlined elsewhere is reported; its lines are still counted', async () => {
  const same = judge(total, functions, await measured('INLINED=1'));
  assert.match(same.notes[0], /^trace_rows \(compiled\) has gone/);
  const slower = judge(total, functions, await measured('INLINED=1', 'AGAIN=20'));
  assert.ok(
    slower.failures.some((text) => text.startsWith(`${WRITTEN} (written): `)),
    slower.failures.join('\n'),
  );
});

/** @param {number} sum @param {Record<string, number>} compiled @returns {import('./profile.mjs').Profile} */
const made = (sum, compiled) => ({ total: sum, compiled: new Map(Object.entries(compiled)), written: new Map() });

test('what is no number fails', () => {
  const [whole, heavy] = commit(made(10000, { loop: 5000 })),
    none = { instructions_per_step: NaN, why: 'first' };
  assert.match(judge(none, heavy, made(10000, { loop: 5000 })).failures[0], /^the whole: /);
  assert.match(judge(whole, heavy, made(NaN, { loop: 5000 })).failures[0], /^the whole: /);
  assert.match(judge(whole, [{ ...heavy[0], ...none }], made(10000, { loop: 5000 })).failures[0], /^loop /);
  assert.equal(raised_silently(new Map([['race', whole]]), new Map([['race', none]])).length, 1);
});

test('a rise of few instructions is none; a heavy function without a count is a failure', () => {
  const [whole, heavy] = commit(made(10000, { loop: 5000, small: 100 })),
    rows = [...heavy, { function: 'small', counted: 'compiled', instructions_per_step: 100, why: 'heavier once' }];
  assert.deepEqual(
    heavy.map((row) => row.function),
    ['loop'],
  );
  assert.deepEqual(judge(whole, rows, made(10000, { loop: 5000, small: 105 })), { failures: [], notes: [] });
  assert.match(judge(whole, rows, made(10000, { loop: 5000, small: 106 })).failures[0], /^small \(compiled\): 106 /);
  assert.match(judge(whole, rows, made(10000, { loop: 5151 })).failures[0], /^loop \(compiled\): 5151 .* 3\.02 % above the 5000/);
  assert.deepEqual(judge(whole, rows, made(10000, { loop: 5150, small: 100 })).failures, []);
  assert.match(judge(whole, rows, made(10000, { other: 5000 })).failures[0], /^other \(compiled\) has 50\.00 % of the case and no/);
  const [copies, of_copies] = commit(made(10000, { 'library:memcpy': 1000 }));
  assert.deepEqual(judge(copies, of_copies, made(10000, { 'library:memcpy': 1100 })).failures, []);
  assert.match(judge(copies, of_copies, made(10000, { 'library:memcpy': 1101 })).failures[0], /^library:memcpy \(compiled\): 1101 /);
  assert.match(judge(whole, rows, made(10301, {})).failures[0], /^the whole: 10301/);
});

test('clones of a function are one, and lines are those of the function around them', () => {
  for (const [symbol, name] of [
    ['step.lto_priv.4', 'step'],
    ['measure_all.constprop.0', 'measure_all'],
    ['solve.constprop.0.isra.0', 'solve'],
    ['fill.part.0.cold', 'fill'],
    ['ll_dot', 'll_dot'],
    ['__memcpy_avx_unaligned_erms', 'memcpy'],
    ['__memset_avx2_unaligned_erms', 'memset'],
    ['sqrt@@GLIBC_2.2.5', 'sqrt'],
  ])
    assert.equal(plain_name(symbol), name);
  assert.deepEqual(
    spans(
      '#include <a.h>\n\nint a(void)\n{\n    return 1;\n}\n\n' +
        'static __attribute__((x(1))) int b(int c,\n      int d)\n{\n}\n\nVISIT(each)\n{\n}\n',
    ),
    [
      { name: 'a', from: 3, to: 6 },
      { name: 'b', from: 8, to: 11 },
      { name: 'each', from: 13, to: 15 },
    ],
  );
  const { total: sum, compiled } = profile_of(
    'events: Ir\nfl=a.c\nfn=f.part.0\n1 20\n2 3\nfn=f.constprop.1\n7 100\nfn=g\n1 1\nsummary: 124\n',
  );
  assert.deepEqual(
    [sum, [...compiled]],
    [
      124,
      [
        ['library:f', 123],
        ['library:g', 1],
      ],
    ],
  );
});

/** What text_before must find in a history of the file.
 * @param {(...args: string[]) => string} git @param {(text: string) => void} commits */
function before_each_commit(git, commits) {
  const before = (/** @type {string} */ now) => text_before(join(folder, 'counts.csv'), now, git);
  assert.equal(before('1'), null);
  commits('1');
  assert.equal(before('1'), null);
  assert.equal(before('2'), '1');
  commits('2');
  assert.equal(before('2'), '1');
  assert.equal(before('3'), '2');
}

test('what was committed before is found by what git says, also where git is not installed', () => {
  const history = /** @type {string[]} */ ([]);
  const git = (/** @type {string[]} */ ...args) => {
    const asked = args.join(' '),
      at = { 'show HEAD:./counts.csv': 1, 'show newest^:./counts.csv': 2 }[asked];
    if (asked === 'rev-list -1 HEAD -- counts.csv') return 'newest\n';
    const text = at && history.at(-at);
    if (text === undefined) throw new Error(`git ${asked}`);
    return text;
  };
  before_each_commit(git, (text) => history.push(text));
  assert.equal(
    text_before('counts.csv', '1', () => {
      throw new Error('no git');
    }),
    null,
  );
});

test('git says so', { skip: spawnSync('git', ['--version']).error ? 'git is not installed' : false }, () => {
  const own = git_in(folder),
    config = ['user.name=t', 'user.email=t', 'commit.gpgsign=false'].flatMap((one) => ['-c', one]);
  before_each_commit(own, (text) => {
    if (text === '1') own('init', '-q');
    writeFileSync(join(folder, 'counts.csv'), text);
    own('add', 'counts.csv');
    own(...config, 'commit', '-q', '-m', text);
  });
});

test('a count that rises without a new reason is refused', () => {
  const row = (/** @type {number} */ count, /** @type {string} */ why) => new Map([['a', { instructions_per_step: count, why }]]);
  assert.deepEqual(raised_silently(row(10, 'x'), row(11, 'x')), ['a: 10 was committed, now 11, and the reason is the same']);
  assert.deepEqual(raised_silently(row(10, 'x'), row(11, 'y')), []);
  assert.deepEqual(raised_silently(row(10, 'x'), row(9, 'x')), []);
});
