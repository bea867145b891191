// Proves what mutate.mjs draws: the same for the same seed, every line really another, only code; the tree stays as it was.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { execPath } from 'node:process';
import { fileURLToPath } from 'node:url';
import { changes, draw, numbers, OUTSIDE } from '../mutate.mjs';

const source = `/* a < b */
#define LESS(a, b) (a < b)
static const int table[] = {1, 2, 3};
typedef struct pair {
    int a, b;
} pair;

int less(const pair *p, int *count)
{
    LL_ASSERT(p->a < 7 &&
              p->b != 8);
    int sum = p->a + 2; /* 3 * 4 */
    if (p->a < p->b && name("5 < 6")) {
        *count += 1;
        note(p,
             sum);
        note(p, sum);
        sum++;
    }
    return sum == 0 ? p->a : 1.5e3;
}

static const double others[] = {
    1 / 3.0,
};
`;
const made = (text) =>
  changes(text).map(({ line, kind, at, length, text: now }) => `${line} ${kind} ${text.slice(at, at + length)} -> ${now}`);
assert.deepEqual(made(source), [
  '12 arithmetic + -> -',
  '12 constant 2 -> 3',
  '13 condition (p->a < p->b && name("5 < 6")) -> (!(p->a < p->b && name("5 < 6")))',
  '13 comparison < -> <=',
  '13 logical && -> ||',
  '14 removed *count += 1; -> ;',
  '14 arithmetic += -> -=',
  '14 constant 1 -> 2',
  '17 removed note(p, sum); -> ;',
  '18 step ++ -> --',
  '20 returned return sum == 0 ? p->a : 1.5e3; -> return 0;',
  '20 comparison == -> !=',
  '20 constant 0 -> 1',
  '20 constant 1.5e3 -> 2.5e3',
]);

const next = numbers(1),
  many = Array.from({ length: 1000 }, next),
  mean = many.reduce((sum, x) => sum + x, 0) / many.length;
assert.ok(
  many.every((x) => x >= 0 && x < 1) && Math.abs(mean - 0.5) < 0.05 && new Set(many).size === many.length,
  `numbers with a mean of ${mean}`,
);

const root = mkdtempSync(join(tmpdir(), 'mutate-'));
try {
  for (const room of ['large', 'small']) mkdirSync(join(root, 'src', room), { recursive: true });
  for (let i = 0; i < 9; i++) writeFileSync(join(root, `src/large/${i}.c`), source);
  writeFileSync(join(root, 'src/small/a.h'), 'static inline int a(void)\n{\n    return 3;\n}\n');
  const drawn = (count, seed) => {
    const { rooms, slots } = draw(root, count, seed);
    return slots.map((room) => {
      const { file, change } = rooms.get(room).shift();
      return `${file} ${change.at} ${change.text}`;
    });
  };
  assert.deepEqual(drawn(20, 5), drawn(20, 5), 'one seed, one choice');
  assert.notDeepEqual(drawn(20, 5), drawn(20, 6));
  for (let seed = 0; seed < 20; seed++) {
    assert.ok(
      drawn(4, seed).some((one) => one.startsWith('src/small/')),
      'every room is drawn where there are enough',
    );
    assert.equal(new Set(drawn(40, seed)).size, 40, 'a line is drawn once');
  }
  assert.equal(drawn(1000, 1).length, 9 * 6 + 1, 'and no more than there are');
  assert.equal(readFileSync(join(root, 'src/large/0.c'), 'utf8'), source, 'the tree is only read');
} finally {
  rmSync(root, { recursive: true });
}

for (const [folder, names] of Object.entries(OUTSIDE)) {
  assert.ok(existsSync(`src/${folder}`), folder);
  for (const name of names) assert.ok(existsSync(`tests/${name}.test.mjs`), name);
}

for (const [words, answer] of /** @type {[string, RegExp][]} */ ([
  ['-1 x', /^mutate takes N \(1 or more\) and SEED \(0 or more\), or --again=FILE; got -1 x$/m],
  ['1 2 3', /got 1 2 3$/m],
  ['--again=nix.csv', /^--again: there is no file nix\.csv$/m],
])) {
  const wrong = spawnSync(execPath, [fileURLToPath(new URL('../mutate.mjs', import.meta.url)), ...words.split(' ')], { encoding: 'utf8' });
  assert.deepEqual([wrong.status, wrong.stdout], [2, '']);
  assert.match(wrong.stderr, answer);
}
console.log('mutants are drawn as they must');
