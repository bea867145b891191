// Asks the engine the questions of lessons, and writes the numbers of their texts:
//
//   node docs/lessons.mjs             # every lesson of www/lessons; uses build/laglab, or the binary that LAGLAB_BIN names
//   node docs/lessons.mjs mine.json   # your own
//
// Prints what is wrong, a line each, and exits with 1 if anything is. docs/lessons.md explains the format.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import Ajv from 'ajv/dist/2020.js';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '..');
export const FOLDER = path.join(ROOT, 'www/lessons');
export const LANGUAGES = ['en', 'de'];
export const WORDS_MAX = 40;
const WIDTH = 140;
const PLACEHOLDER = /\{([^{}]*)\}/g;
const NAME_WITH_DIGITS = /\p{L}\d+/gu; // RK4, AABB2

/** @typedef {{metric?: string, trace?: string, tick?: number, since?: number, setting?: string, record?: string,
 *   where?: Record<string, string>, column?: string, per?: number, scale?: number,
 *   way?: 'there' | 'wait' | 'back' | 'frame', minus?: Measure, scenario?: string, set?: Record<string, any>, changed?: true}} Measure */
/** @typedef {{metrics: any, scenario: any, trace: () => {ticks: Map<number, string[]>, columns: string[]},
 *   record: (name: string) => Record<string, string>[]}} Run */

/** @typedef {{inputs: {tick: number, player: number, axes: number[]}[]}} Workload */

/** Ids of the lessons of the library. */
export const lessonIds = () =>
  readdirSync(FOLDER)
    .filter((name) => name.endsWith('.json'))
    .map((name) => name.slice(0, -5))
    .sort();

// ---- the engine ----

/** A table, by its columns. @param {string} text @returns {Record<string, string>[]} */
function rowsOf(text) {
  const [head = '', ...rows] = text.trim().split(/\r?\n/),
    columns = head.split(',');
  return rows.map((row) => Object.fromEntries(row.split(',').map((cell, i) => [columns[i], cell])));
}

const ALMOST_S = 1e-3;

/** The way of the last input of a workload: to the server, its wait for the next update, the way back, and the wait for the next frame of
 * the player's own screen, ms. @param {Run} run @param {Workload | undefined} workload @param {string} part */
function wayOf(run, workload, part) {
  const pressed = workload?.inputs.at(-1);
  if (!pressed) throw new Error(`way: ${part} needs a workload`);
  const events = run
    .record('events')
    .filter(({ player }) => Number(player) === pressed.player)
    .map(({ type, begin_s: begin, end_s: end }) => ({ type, begin: Number(begin), end: Number(end) }));
  const from = (pressed.tick + 0.5) / run.scenario.tick_hz,
    input = events.find(({ type, begin }) => type === 'input' && begin > from),
    shown = (input?.begin ?? 0) + run.metrics.players[pressed.player].input_latency_ms.max / 1000;
  const frame = events.find(({ type, begin }) => type === 'display' && begin > shown - ALMOST_S),
    state = events.filter(({ type, end }) => type === 'state' && end <= (frame?.begin ?? 0)).at(-1);
  if (!input || !state || !frame) throw new Error('way: the last input of the workload is on no screen');
  const parts = {
    there: input.end - input.begin,
    wait: state.begin - input.end,
    back: state.end - state.begin,
    frame: frame.begin - state.end,
  };
  return 1000 * parts[/** @type {keyof typeof parts} */ (part)];
}

/** Runs scenarios, each set of parameters once. @param {string} binary */
export function engine(binary) {
  /** @type {Map<string, Run>} */
  const runs = new Map();
  /** @param {string} scenario @param {Record<string, any>} set @param {number} seed @param {Workload} [workload] @returns {Run} */
  function run(scenario, set, seed, workload) {
    const key = JSON.stringify([scenario, Object.entries(set).sort(), seed, workload]);
    const known = runs.get(key);
    if (known) return known;
    const folder = mkdtempSync(path.join(tmpdir(), 'laglab-lesson-'));
    try {
      const settings = Object.entries(set).flatMap(([name, value]) => ['--set', `${name}=${value}`]);
      const order = (/** @type {string[]} */ ...more) =>
        execFileSync(binary, ['run', scenario, '--seed', String(seed), ...settings, ...more], {
          encoding: 'utf8',
          maxBuffer: 1 << 28,
          stdio: ['ignore', 'pipe', 'pipe'],
        });
      /** @param {string[]} files */
      const ran = (...files) => {
        if (!workload) return order(...files);
        const own = mkdtempSync(path.join(tmpdir(), 'laglab-lesson-')),
          log = path.join(own, 'inputs');
        try {
          order('--record-inputs', log);
          const [head, ...lines] = readFileSync(log, 'utf8').trim().split('\n');
          const inputs = workload.inputs.map((one) => JSON.stringify({ op: 'input', ...one }));
          writeFileSync(log, [head, ...inputs, lines.at(-1)].join('\n'));
          return order('--workload', log, ...files);
        } finally {
          rmSync(own, { recursive: true });
        }
      };
      const text = ran('--trace', path.join(folder, 'trace.csv'), '--log', path.join(folder, 'log'));
      const table = readFileSync(path.join(folder, 'trace.csv'), 'utf8').trim().split('\n');
      const log = readFileSync(path.join(folder, 'log'), 'utf8');
      /** @type {ReturnType<Run['trace']>} */
      let parsed;
      /** @type {Map<string, Record<string, string>[]>} */
      const records = new Map();
      const made = {
        metrics: JSON.parse(text).metrics,
        scenario: JSON.parse(log.slice(0, log.indexOf('\n'))).scenario,
        trace() {
          const [columns, ...rows] = table.map((line) => line.split(','));
          const tick = columns.indexOf('tick');
          return (parsed ??= { columns, ticks: new Map(rows.map((row) => [Number(row[tick]), row])) });
        },
        record(/** @type {string} */ name) {
          const known = records.get(name);
          if (known) return known;
          const own = mkdtempSync(path.join(tmpdir(), 'laglab-lesson-')),
            file = path.join(own, 'record.csv');
          try {
            ran('--trace-of', `${name}=${file}`);
            const rows = rowsOf(readFileSync(file, 'utf8'));
            records.set(name, rows);
            return rows;
          } finally {
            rmSync(own, { recursive: true });
          }
        },
      };
      runs.set(key, made);
      return made;
    } finally {
      rmSync(folder, { recursive: true });
    }
  }
  return { run };
}

const at = (/** @type {any} */ tree, /** @type {string} */ where) => where.split('.').reduce((node, name) => node?.[name], tree);

/** A number of a run, or an error that says why there is none. @param {any} lesson @param {Measure} what
 * @param {ReturnType<typeof engine>} asked */
export function measure(lesson, what, asked) {
  const set = { ...(what.scenario ? {} : lesson.set), ...(what.changed ? lesson.change.set : {}), ...what.set };
  const run = asked.run(what.scenario ?? lesson.scenario, set, lesson.seed, what.scenario ? undefined : lesson.workload);
  let value;
  if (what.trace !== undefined) {
    const { columns, ticks } = run.trace();
    const column = columns.indexOf(what.trace);
    if (column < 0) throw new Error(`the trace has no column ${what.trace}`);
    const cell = (/** @type {number} */ tick) => {
      const row = ticks.get(tick);
      if (!row) throw new Error(`the trace has no tick ${tick}`);
      return row[column] === '' ? Number.NaN : Number(row[column]);
    };
    value = cell(what.tick ?? 0) - (what.since === undefined ? 0 : cell(what.since));
  } else if (what.record !== undefined) {
    const rows = run
      .record(what.record)
      .filter(
        (row) => Number(row.session_tick) === what.tick && Object.entries(what.where ?? {}).every(([name, want]) => row[name] === want),
      );
    if (rows.length !== 1) throw new Error(`${what.record} has ${rows.length} such rows at tick ${what.tick}; exactly one is wanted`);
    const cell = rows[0]?.[what.column ?? ''];
    if (cell === undefined) throw new Error(`${what.record} has no column ${what.column}`);
    value = cell === '' ? Number.NaN : Number(cell);
  } else if (what.way !== undefined) value = wayOf(run, lesson.workload, what.way);
  else if (what.metric !== undefined) value = at(run.metrics, what.metric);
  else value = at(run.scenario, what.setting ?? '');
  if (typeof value !== 'number' || !Number.isFinite(value)) {
    const name = what.trace ?? what.column ?? what.metric ?? what.setting;
    throw new Error(value === undefined ? `there is no ${what.metric ? 'metric' : 'parameter'} ${name}` : `${name} is no number: ${value}`);
  }
  if (what.per !== undefined) value = what.per / value;
  if (what.scale !== undefined) value *= what.scale;
  if (what.minus) value -= measure(lesson, what.minus, asked);
  return value;
}

/** @param {number} value @param {number} digits @returns {number} */
export const rounded = (value, digits) => Number(value.toFixed(digits)) + 0; // no -0

// ---- what a lesson must fulfil ----

/** @type {import('ajv').ValidateFunction | undefined} */
let validate;

/** What the schema says against a lesson, a sentence each. @param {unknown} lesson @returns {string[]} */
export function schemaProblems(lesson) {
  validate ??= new Ajv({ allErrors: true, strict: false }).compile(
    JSON.parse(readFileSync(path.join(ROOT, 'api/lesson.schema.json'), 'utf8')),
  );
  if (validate(lesson)) return [];
  const said = (validate.errors ?? []).map(({ instancePath, keyword, params, message }) => {
    const where = instancePath.slice(1).replaceAll('/', '.') || 'the lesson';
    if (keyword === 'required') return `${where}: ${params.missingProperty} is missing`;
    if (keyword === 'additionalProperties' || keyword === 'unevaluatedProperties')
      return `${where}: ${params.additionalProperty ?? params.unevaluatedProperty} is unknown`;
    if (keyword === 'enum') return `${where}: must be one of ${params.allowedValues.join(', ')}`;
    if (keyword === 'oneOf') return `${where}: must name one of metric, trace with tick, record with tick and column, setting, way`;
    return `${where}: ${message}`;
  });
  return [...new Set(said)];
}

/** Every text with its place. @param {any} lesson @returns {{where: string, text: {en: string, de: string}}[]} */
export function textsOf(lesson) {
  return [
    { where: 'title', text: lesson.title },
    ...Object.entries(lesson.steps).map(([step, text]) => ({ where: `steps.${step}`, text: /** @type {any} */ (text) })),
    ...Object.entries(lesson.headings ?? {}).map(([step, text]) => ({ where: `headings.${step}`, text: /** @type {any} */ (text) })),
    ...lesson.choices.flatMap((/** @type {any} */ choice, /** @type {number} */ i) => [
      { where: `choices.${i}.why`, text: choice.why },
      ...(choice.label ? [{ where: `choices.${i}.label`, text: choice.label }] : []),
    ]),
    ...Object.entries(lesson.bars ?? {}).flatMap(([step, list]) =>
      /** @type {any[]} */ (list).map(({ text }, i) => ({ where: `bars.${step}.${i}.label`, text })),
    ),
    ...Object.entries(lesson.shows ?? {}).flatMap(([step, one]) =>
      /** @type {any} */ (one).label ? [{ where: `shows.${step}.label`, text: /** @type {any} */ (one).label }] : [],
    ),
    ...(lesson.moments ? [{ where: 'moments.text', text: lesson.moments.text }] : []),
    ...(lesson.look.before ? [{ where: 'look.before.text', text: lesson.look.before.text }] : []),
    ...(lesson.erratum ? [{ where: 'erratum', text: lesson.erratum }] : []),
    ...lesson.misconceptions.map((/** @type {any} */ text, /** @type {number} */ i) => ({ where: `misconceptions.${i}`, text })),
  ];
}

/** The text as a page shows it. @param {any} lesson @param {string} text @param {string} language */
export const filled = (lesson, text, language) =>
  text.replace(PLACEHOLDER, (_, name) => {
    const { value, digits } = lesson.numbers[name];
    return value.toLocaleString(language, { minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: false });
  });

/** @param {any} lesson @returns {string[]} */
function textProblems(lesson) {
  const found = [],
    used = new Set();
  for (const { where, text } of textsOf(lesson))
    for (const language of LANGUAGES) {
      const words = text[/** @type {'en' | 'de'} */ (language)];
      const names = [...words.matchAll(PLACEHOLDER)].map((match) => match[1]);
      for (const name of names) {
        used.add(name);
        if (!(name in lesson.numbers)) found.push(`${where}.${language}: {${name}} is not among numbers`);
      }
      const digits = words
        .replace(PLACEHOLDER, '')
        .replace(NAME_WITH_DIGITS, '')
        .match(/\d[\d.,]*/);
      if (digits) found.push(`${where}.${language}: ${digits[0]} is written by hand; name it in numbers and write {name}`);
      const count = words.split(/\s+/).filter((word) => /[\p{L}\d{]/u.test(word)).length;
      if (count > WORDS_MAX) found.push(`${where}.${language}: has ${count} words; ${WORDS_MAX} are the most`);
      if (!where.endsWith('label') && language === 'de' && words === text.en) found.push(`${where}.de: is not translated`);
    }
  const both = (/** @type {any} */ text) =>
    LANGUAGES.map((language) =>
      [...text[language].matchAll(PLACEHOLDER)]
        .map((match) => match[1])
        .sort()
        .join(),
    );
  for (const { where, text } of textsOf(lesson)) {
    const [en, de] = both(text);
    if (en !== de) found.push(`${where}: en has the numbers ${en || 'none'}, de ${de || 'none'}`);
  }
  for (const [step, { number }] of /** @type {[string, {number?: string}][]} */ (Object.entries(lesson.shows ?? {}))) {
    if (number === undefined) continue;
    used.add(number);
    if (!(number in lesson.numbers)) found.push(`shows.${step}.number: ${number} is not among numbers`);
  }
  for (const [step, list] of /** @type {[string, {number: string}[]][]} */ (Object.entries(lesson.bars ?? {})))
    for (const { number } of list) {
      used.add(number);
      if (!(number in lesson.numbers)) found.push(`bars.${step}: ${number} is not among numbers`);
    }
  for (const name of Object.keys(lesson.numbers)) if (!used.has(name)) found.push(`numbers.${name}: no text has it`);
  return found;
}

const reason = (/** @type {unknown} */ error) => {
  const { stderr, message } = /** @type {any} */ (error);
  return String(stderr || message)
    .trim()
    .split('\n')[0]
    .replace(/^laglab: /, '');
};

/** @param {any} lesson @param {ReturnType<typeof engine>} asked @returns {string[]} */
function answerProblems(lesson, asked) {
  const found = [];
  const right = lesson.choices.filter((/** @type {any} */ choice) => choice.right);
  if (right.length !== 1) found.push(`choices: ${right.length} are right; exactly one must be`);
  for (const [where, answer] of [
    ['answer', lesson.answer],
    ['change.answer', { changed: true, ...lesson.change.answer }],
  ]) {
    let value;
    try {
      value = measure(lesson, answer, asked);
    } catch (error) {
      found.push(`${where}: ${reason(error)}`);
      continue;
    }
    if (Math.abs(value - answer.value) > answer.tol)
      found.push(`${where}: the lesson says ${answer.value} within ${answer.tol}; the engine says ${value}`);
    if (where !== 'answer') continue;
    lesson.choices.forEach((/** @type {any} */ choice, /** @type {number} */ i) => {
      const near = Math.min(Math.abs(choice.value - answer.value), Math.abs(choice.value - value)) <= answer.tol;
      if (choice.right && Math.abs(choice.value - value) > answer.tol)
        found.push(`choices.${i}: ${choice.value} is to be right; the engine says ${value}`);
      if (!choice.right && near) found.push(`choices.${i}: ${choice.value} is to be wrong, and is within ${answer.tol} of the answer`);
    });
  }
  return found;
}

/** @param {any} lesson @param {ReturnType<typeof engine>} asked @returns {string[]} */
function numberProblems(lesson, asked) {
  const found = [];
  for (const [name, number] of Object.entries(lesson.numbers))
    try {
      const value = rounded(measure(lesson, number, asked), number.digits);
      if (value !== number.value) found.push(`numbers.${name}: has the value ${number.value}; the engine says ${value}`);
    } catch (error) {
      found.push(`numbers.${name}: ${reason(error)}`);
    }
  return found;
}

/** Controls that are no settings of a scenario: those of api/lesson.schema.json. @type {() => string[]} */
const otherControls = () => JSON.parse(readFileSync(path.join(ROOT, 'api/lesson.schema.json'), 'utf8')).$defs.controls.items.anyOf[0].enum;

/** Each setting that a step names is one of the scenario that it shows. @param {any} lesson @param {ReturnType<typeof engine>} asked
 * @returns {string[]} */
function controlProblems(lesson, asked) {
  const found = [],
    others = otherControls();
  for (const [step, names] of Object.entries(lesson.controls ?? {})) {
    const set = step === 'change' ? { ...lesson.set, ...lesson.change.set } : lesson.set;
    for (const name of /** @type {string[]} */ (names).filter((one) => !others.includes(one)))
      try {
        if (
          !['number', 'boolean', 'string'].includes(typeof at(asked.run(lesson.scenario, set, lesson.seed, lesson.workload).scenario, name))
        )
          found.push(`controls.${step}: there is no control ${name}`);
      } catch (error) {
        found.push(`controls.${step}: ${reason(error)}`);
      }
  }
  return found;
}

/** The ticks at which the same happens as at the stop. @param {any} lesson @param {ReturnType<typeof engine>} asked @returns {number[]} */
export function momentsOf(lesson, asked) {
  const { record, where, from_s: from } = lesson.moments;
  /** @type {Set<string>} each row once: a record may show it for longer */
  const met = new Set();
  return asked
    .run(lesson.scenario, lesson.set, lesson.seed)
    .record(record)
    .flatMap((/** @type {Record<string, string>} */ row) => {
      const is = Object.entries(where).every(([name, want]) => row[name]?.split('|').includes(/** @type {string} */ (want))),
        key = `${row.player} ${row.tick}`;
      if (!is || met.has(key)) return [];
      met.add(key);
      return Number(row.time_s) >= from ? [Number(row.session_tick)] : [];
    });
}

/** @param {any} lesson @param {ReturnType<typeof engine>} asked @returns {string[]} */
function momentProblems(lesson, asked) {
  if (!lesson.moments) return [];
  const ticks = momentsOf(lesson, asked),
    found = [];
  if (String(ticks) !== String(lesson.moments.ticks)) found.push(`moments.ticks: the engine says ${ticks.join(', ')}`);
  if (!ticks.includes(lesson.stop_tick)) found.push(`stop_tick: ${lesson.stop_tick} is not among the moments`);
  return found;
}

/** The parts of its time line are numbers, and together they are the answer. @param {any} lesson @returns {string[]} */
function lineProblems(lesson) {
  const names = /** @type {string[]} */ (lesson.line ?? []),
    unknown = names.filter((name) => !(name in lesson.numbers));
  if (names.length === 0 || unknown.length > 0) return unknown.map((name) => `line: ${name} is not among numbers`);
  const sum = names.reduce((total, name) => total + lesson.numbers[name].value, 0);
  return sum === lesson.answer.value ? [] : [`line: its parts are ${sum} together; the answer is ${lesson.answer.value}`];
}

/** Everything that is wrong with a lesson, a sentence each. @param {any} lesson @param {ReturnType<typeof engine>} asked
 * @returns {string[]} */
export function problems(lesson, asked) {
  const shape = schemaProblems(lesson);
  if (shape.length > 0) return shape;
  const found = [
    ...textProblems(lesson),
    ...answerProblems(lesson, asked),
    ...numberProblems(lesson, asked),
    ...controlProblems(lesson, asked),
    ...lineProblems(lesson),
    ...momentProblems(lesson, asked),
  ];
  try {
    const start = lesson.start_tick ?? 0;
    for (const [where, tick, more] of /** @type {[string, number, Record<string, any>][]} */ ([
      ['start_tick', start, {}],
      ['stop_tick', lesson.stop_tick, {}],
      ...(lesson.change.stop_tick === undefined ? [] : [['change.stop_tick', lesson.change.stop_tick, lesson.change.set]]),
    ]))
      if (
        !asked
          .run(lesson.scenario, { ...lesson.set, ...more }, lesson.seed, lesson.workload)
          .trace()
          .ticks.has(tick)
      )
        found.push(`${where}: the run has no tick ${tick}`);
    if (start >= lesson.stop_tick) found.push(`start_tick: ${start} is not before stop_tick, ${lesson.stop_tick}`);
  } catch (error) {
    found.push(`scenario: ${reason(error)}`);
  }
  return [...new Set(found)];
}

/** The lesson with the engine's values of its numbers; those without one are as they were. @param {any} lesson
 * @param {ReturnType<typeof engine>} asked */
export function withNumbers(lesson, asked) {
  const numbers = Object.entries(lesson.numbers ?? {}).map(([name, number]) => {
    try {
      return [name, { ...number, value: rounded(measure(lesson, number, asked), number.digits) }];
    } catch {
      return [name, number];
    }
  });
  const moments = lesson.moments && { moments: { ...lesson.moments, ticks: momentsOf(lesson, asked) } };
  return { ...lesson, ...moments, numbers: Object.fromEntries(numbers) };
}

/** JSON in which what fits on a line stands on one. @param {any} value @param {string} [indent] @returns {string} */
export function layout(value, indent = '') {
  const line = (/** @type {any} */ inner) => {
    if (Array.isArray(inner)) return `[${inner.map(line).join(', ')}]`;
    if (inner === null || typeof inner !== 'object') return JSON.stringify(inner);
    return `{${Object.entries(inner)
      .map(([name, item]) => `${JSON.stringify(name)}: ${line(item)}`)
      .join(', ')}}`;
  };
  const short = line(value),
    more = `${indent}  `;
  if (indent !== '' && short.length + indent.length < WIDTH - 20) return short;
  if (value === null || typeof value !== 'object') return short;
  if (Array.isArray(value)) return `[\n${value.map((item) => more + layout(item, more)).join(',\n')}\n${indent}]`;
  return `{\n${Object.entries(value)
    .map(([name, item]) => `${more}${JSON.stringify(name)}: ${layout(item, more)}`)
    .join(',\n')}\n${indent}}`;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const asked = engine(process.env.LAGLAB_BIN ?? path.join(ROOT, 'build/laglab'));
  const files = process.argv.slice(2);
  for (const file of files.length > 0 ? files : lessonIds().map((id) => path.join(FOLDER, `${id}.json`))) {
    const text = readFileSync(file, 'utf8'),
      read = JSON.parse(text);
    const shape = schemaProblems(read),
      lesson = shape.length > 0 ? read : withNumbers(read, asked);
    const after = `${layout(lesson)}\n`;
    if (shape.length === 0 && after !== text) writeFileSync(file, after);
    const found = problems(lesson, asked);
    console.log(`${shape.length === 0 && after !== text ? 'written  ' : 'as it was'}  ${path.relative(process.cwd(), file)}`);
    for (const problem of found) console.log(`  ${problem}`);
    if (found.length > 0) process.exitCode = 1;
  }
}
