// Questions of lessons, asked of the engine; and that a lesson which is wrong is found.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import {
  FOLDER,
  LANGUAGES,
  engine,
  filled,
  layout,
  lessonIds,
  measure,
  problems,
  rounded,
  textsOf,
  withNumbers,
} from '../../docs/lessons.mjs';
import { CARDS } from '../../docs/cards.mjs';
import { client } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';
import { findings, readList } from '../structure/words.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const textOf = (/** @type {string} */ id) => readFileSync(path.join(FOLDER, `${id}.json`), 'utf8');
const read = (/** @type {string} */ id) => JSON.parse(textOf(id));
const asked = engine(BINARY);
const ids = lessonIds();

/** One of each kind of scenario, and one of the paper; lessons.all.test.mjs asks the engine about all. */
const FIRST = ['late_answer', 'keeps_energy', 'falling_stack', 'vanishing_smoke', 'figure_1'];

for (const id of FIRST)
  test(`${id}: the engine gives its answers and numbers`, () => {
    assert.deepEqual(problems(read(id), asked), []);
    assert.equal(textOf(id), `${layout(withNumbers(read(id), asked))}\n`, 'node docs/lessons.mjs writes it');
  });

test('ten questions, every figure of the paper, and techniques; each lesson has a place', () => {
  const lessons = ids.map((id) => ({ id, ...read(id) }));
  assert.equal(lessons.filter(({ topic }) => topic === 'questions').length, 10);
  const figures = new Set(lessons.map(({ paper }) => paper));
  for (let figure = 1; figure <= 13; figure++) assert.ok(figures.has(`Figure ${figure}`), `Figure ${figure}`);
  const scenarios = new Set(lessons.map(({ scenario }) => scenario));
  for (const name of readdirSync(path.join(ROOT, 'scenarios/paper'))) assert.ok(scenarios.has(`paper/${name.replace('.json', '')}`), name);
  assert.equal(new Set(lessons.map(({ order }) => order)).size, lessons.length, 'places differ');
  const order = new Map(lessons.map((lesson) => [lesson.id, lesson.order]));
  for (const { id, prerequisites } of lessons)
    for (const before of prerequisites) assert.ok(order.get(before) < order.get(id), `${id}: ${before} comes before it`);
});

/** What may be tried before the change, too. @type {Record<string, string[]>} */
const FREE = { who_waits: ['players.2.lag_ms'] };

test('each lesson says what each step leaves to be used: time, and what the change is about', () => {
  for (const id of ids) {
    const { controls, change } = read(id);
    assert.deepEqual(Object.keys(controls), ['predict', 'run', 'observe', 'explain', 'change'], id);
    const settings = controls.change.filter((name) => !name.startsWith('time.'));
    assert.ok(settings.length > 0, id);
    for (const name of settings) assert.ok(name in change.set, `${id}: the change sets ${name}`);
    for (const step of ['predict', 'run', 'observe', 'explain'])
      assert.ok(
        controls[step].length > 0 && controls[step].every((name) => name.startsWith('time.') || FREE[id]?.includes(name)),
        `${id} ${step}`,
      );
  }
});

test('every question has a card whose trouble moves far enough to be seen: an eighth of its width', () => {
  const all = JSON.parse(readFileSync(CARDS, 'utf8')),
    questions = lessonIds().filter((id) => JSON.parse(readFileSync(path.join(FOLDER, `${id}.json`), 'utf8')).topic === 'questions');
  assert.deepEqual(Object.keys(all).sort(), questions.sort());
  for (const [id, parts] of Object.entries(all)) {
    const farthest = Math.max(
      ...Object.values(parts).map((places) =>
        Math.hypot(...[0, 1].map((axis) => Math.max(...places.map((at) => at[axis])) - Math.min(...places.map((at) => at[axis])))),
      ),
    );
    assert.ok(farthest >= 250 / 8, `${id}: ${farthest} of 250 units`);
  }
});

test('texts have no banned words, and German has its own letters and quotes', () => {
  const list = readList(readFileSync(path.join(ROOT, 'tests/structure/words.txt'), 'utf8'));
  for (const id of ids)
    for (const { where, text } of textsOf(read(id))) {
      assert.deepEqual(findings(text.en, 'markdown', list), [], `${id} ${where}`);
      assert.doesNotMatch(text.de, /["']|\b(?:fuer|ueber|koennen|muessen|waere|groesse)/i, `${id} ${where}`);
      assert.doesNotMatch(text.en, /["']/, `${id} ${where}`);
    }
});

test('a text is filled with the numbers of its language', () => {
  const lesson = read('jump_back');
  const { en, de } = lesson.steps.observe;
  const size = -rounded(measure(lesson, lesson.answer, asked), 2);
  assert.match(filled(lesson, en, 'en'), new RegExp(`\\b${size.toFixed(2).replace('.', '\\.')} m`));
  assert.match(filled(lesson, de, 'de'), new RegExp(`\\b${size.toFixed(2).replace('.', ',')} m`));
});

/** What is done to a lesson that holds, and what must then be said. @type {[string, (lesson: any) => void, RegExp][]} */
const BROKEN = [
  ['an answer that is not the engine’s', (l) => (l.answer.value = 300), /^answer: the lesson says 300 within 17; the engine says 350/],
  ['a change with another result', (l) => (l.change.answer.value = 20), /^change\.answer: the lesson says 20 within 1; the engine says 0$/],
  [
    'a wrong choice that is right, too',
    (l) => (l.choices[0].value = 340),
    /^choices\.0: 340 is to be wrong, and is within 17 of the answer$/,
  ],
  ['a right choice that is wrong', (l) => (l.choices[2].value = 400), /^choices\.2: 400 is to be right; the engine says 350/],
  ['two right choices', (l) => (l.choices[0].right = true), /^choices: 2 are right; exactly one must be$/],
  ['no right choice', (l) => delete l.choices[2].right, /^choices: 0 are right/],
  ['a long step', (l) => (l.steps.observe.de = 'Wort '.repeat(41).trim()), /^steps\.observe\.de: has 41 words; 40 are the most$/],
  ['a step without German', (l) => delete l.steps.observe.de, /^steps\.observe: de is missing$/],
  ['German that is English', (l) => (l.title.de = l.title.en), /^title\.de: is not translated$/],
  [
    'an unknown metric',
    (l) => (l.answer.metric = 'players.0.input_delay_ms.mean'),
    /^answer: there is no metric players\.0\.input_delay_ms\.mean$/,
  ],
  ['an unknown column', (l) => (l.numbers.press.trace = 'player_0_x'), /^numbers\.press: the trace has no column player_0_x$/],
  ['a tick beyond the run', (l) => (l.stop_tick = 5000), /^stop_tick: the run has no tick 5000$/],
  ['an unknown scenario', (l) => (l.scenario = 'paper/fig99'), /^answer: there is no scenario paper\/fig99$/],
  ['an unknown option', (l) => (l.set['players.0.lagg_ms'] = 1), /^answer: players\.0\.lagg_ms is unknown/],
  ['an option out of its range', (l) => (l.change.set['players.0.lag_ms'] = 5000), /^change\.answer: players\.0\.lag_ms: must be/],
  ['a number that is not the engine’s', (l) => (l.numbers.lag.value = 149), /^numbers\.lag: has the value 149; the engine says 150$/],
  ['a number by hand', (l) => (l.steps.explain.en += ' That is 300 ms.'), /^steps\.explain\.en: 300 is written by hand/],
  ['a number that is not there', (l) => (l.steps.explain.en = '{felt}'), /^steps\.explain\.en: \{felt\} is not among numbers$/],
  [
    'a number in one language only',
    (l) => (l.steps.explain.de = l.steps.explain.de.replace('{total}', 'so viele')),
    /^steps\.explain: en has the numbers back,frame,there,total,wait, de back,frame,there,wait$/,
  ],
  ['a number that no text has', (l) => (l.numbers.unused = { ...l.numbers.lag }), /^numbers\.unused: no text has it$/],
  ['a time line that is not the answer', (l) => l.line.splice(1, 1, 'back'), /^line: its parts are 466 together; the answer is 350$/],
  ['a time line of no numbers', (l) => (l.line[0] = 'round'), /^line: round is not among numbers$/],
  ['a way without a workload', (l) => delete l.workload, /^numbers\.there: way: there needs a workload$/],
  ['a start after its stop', (l) => (l.start_tick = 230), /^start_tick: 230 is not before stop_tick, 201$/],
  ['a stop of the change beyond the run', (l) => (l.change.stop_tick = 301), /^change\.stop_tick: the run has no tick 301$/],
  ['an unknown member', (l) => (l.subtitle = ''), /^the lesson: subtitle is unknown$/],
  ['an unknown highlight', (l) => (l.look.at = 'sky'), /^look\.at: must be one of own_entity/],
  [
    'a setting that its scenario lacks among controls',
    (l) => l.controls.change.push('methods.0.dt_s'),
    /^controls\.change: there is no control methods\.0\.dt_s$/,
  ],
  ['a control of time that is not there', (l) => l.controls.run.push('time.warp'), /^controls\.run\./],
  [
    'a control that is a group of settings',
    (l) => l.controls.change.push('players.0'),
    /^controls\.change: there is no control players\.0$/,
  ],
  [
    'a measure of two kinds',
    (l) => (l.answer.setting = 'duration_s'),
    /^answer: must name one of metric, trace with tick, record with tick and column, setting, way$/,
  ],
];

test('moments and numbers of a record that are not the engine’s are refused', () => {
  const lesson = read('behind_wall'),
    { moments, numbers } = lesson;
  assert.equal(moments.ticks.length, lesson.answer.value, 'as many as the answer counts');
  moments.ticks.pop();
  numbers.gap.value = 3.5;
  lesson.stop_tick = 161;
  const found = problems(lesson, asked).join('\n');
  assert.match(found, /^moments\.ticks: the engine says 160, 311, /m);
  assert.match(found, /^stop_tick: 161 is not among the moments$/m);
  assert.match(found, /^numbers\.gap: has the value 3\.5; the engine says 1\.9$/m);
  numbers.gap.where = { player: '1' };
  assert.match(problems(lesson, asked).join('\n'), /^numbers\.gap: shot_bodies has 2 such rows at tick 160; exactly one is wanted$/m);
  numbers.gap.where = { player: '1', body: '0' };
  numbers.gap.column = 'looked_z_m';
  assert.match(problems(lesson, asked).join('\n'), /^numbers\.gap: shot_bodies has no column looked_z_m$/m);
});

for (const [what, breakIt, says] of BROKEN)
  test(`a lesson with ${what} is refused`, () => {
    const lesson = read('late_answer');
    breakIt(lesson);
    const found = problems(lesson, asked);
    assert.ok(
      found.some((problem) => says.test(problem)),
      `${says} is not among:\n${found.join('\n')}`,
    );
  });

test('an own lesson: numbers are written, problems printed', () => {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-own-')),
    file = path.join(folder, 'mine.json');
  const run = () =>
    spawnSync(process.execPath, [path.join(ROOT, 'docs/lessons.mjs'), file], {
      encoding: 'utf8',
      env: { ...process.env, LAGLAB_BIN: BINARY },
      timeout: 600000,
    });
  try {
    const lesson = read('late_answer');
    lesson.set['players.0.lag_ms'] = 50;
    writeFileSync(file, JSON.stringify(lesson));
    const wrong = run();
    assert.equal(wrong.status, 1, wrong.stderr);
    assert.match(wrong.stdout, / {2}answer: the lesson says 350 within 17; the engine says 150/);
    assert.equal(JSON.parse(readFileSync(file, 'utf8')).numbers.lag.value, 50);
    lesson.answer.value = 150;
    lesson.choices[2].value = 150;
    lesson.choices[1].value = 50;
    writeFileSync(file, JSON.stringify(lesson));
    const right = run();
    assert.equal(right.status, 0, right.stdout + right.stderr);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

// ---- served ----

let daemon, c;
before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
});

test('the daemon serves each lesson, and an index of all', async () => {
  for (const id of ids) {
    const answer = await fetch(new URL(`/lessons/${id}.json`, daemon.url));
    assert.equal(answer.status, 200, id);
    assert.match(answer.headers.get('content-type') ?? '', /^application\/json/);
    assert.deepEqual(await answer.json(), read(id));
  }
  const index = await (await fetch(new URL('/lessons/index.json', daemon.url))).json();
  assert.deepEqual(index.map((entry) => entry.id).sort(), ids);
  for (const { id, ...entry } of index) {
    const lesson = read(id);
    for (const member of ['order', 'topic', 'title', 'scenario', 'minutes', 'age', 'prerequisites', 'hooks', 'paper'])
      assert.deepEqual(entry[member], lesson[member], `${id} ${member}`);
  }
  assert.equal((await fetch(new URL('/lessons/none.json', daemon.url))).status, 404);
});

test('a session is made from each lesson', async () => {
  for (const id of ids) {
    const { scenario, set, seed } = read(id);
    const made = await c.call('POST', '/api/v1/sessions', { body: { scenario, set, seed, paused: true } });
    assert.equal(made.status, 201, `${id}: ${JSON.stringify(made.json)}`);
    await c.call('DELETE', `/api/v1/sessions/${made.json.id}`, { key: made.json.owner_key });
  }
  assert.equal((await c.get('/api/v1/scenarios')).status, 200);
});

test('words of the languages are served, too', async () => {
  for (const language of LANGUAGES) assert.equal((await fetch(new URL(`/words/${language}.json`, daemon.url))).status, 200, language);
  assert.ok(execFileSync(BINARY, ['scenarios'], { encoding: 'utf8' }).includes('three_bullets'));
});
