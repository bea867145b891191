// What a visitor, a teacher and two students do from the first page, written once for all browsers, sizes and languages. Each finds what to
// press by the page's own words, reads what they ask for, and sees what they are about at least 40 px and 3 % of its view apart.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { setTimeout as wait } from 'node:timers/promises';

/** @typedef {import('./browsers.mjs').Visitor} Visitor */
/** Opens an address of the page in a browser of its own. @typedef {(at: string) => Promise<Visitor>} Open */
/** A visitor whose clicks and keys are counted; note: that something has happened, for `notes`, with seconds and clicks until then
 * @typedef {Visitor & {clicks: () => number, note: (what: string) => void, notes: string[]}} Person */

const LATE_MS = 120000; /* ends what hangs */

/** Until the function gives a true value in the page, and gives it. @param {Visitor} visitor @param {Function | string} test_
 * @param {any} arg @param {string} what */
export async function seen(visitor, test_, arg, what) {
  const end = Date.now() + LATE_MS;
  for (;;) {
    const value = await visitor.evaluate(test_, arg).catch((error) => {
      if (Date.now() > end) throw error;
      return null; /* the page is on its way to another */
    });
    if (value) return value;
    if (Date.now() > end) {
      const text = await visitor.evaluate(() => document.body.innerText.slice(0, 300)).catch(() => '');
      assert.fail(`not within ${LATE_MS} ms: ${what}; the page shows: ${text}; ${await visitor.complaints().catch(String)}`);
    }
    await wait(50);
  }
}

/** A button or link that is shown and can be used, by its name. @param {string} name */
const byName = (name) =>
  /** @type {HTMLButtonElement[]} */ ([...document.querySelectorAll('button, a')]).find(
    (one) =>
      (one.getAttribute('aria-label') ?? one.innerText).replace(/\s+/g, ' ').trim() === name &&
      !one.disabled &&
      one.getClientRects().length > 0,
  ) ?? null;
/** @param {string} selector */
const bySelector = (selector) => document.querySelector(selector);

/** @param {Visitor} visitor @param {string} name */
async function push(visitor, name) {
  await seen(visitor, `(name) => (${byName})(name) !== null`, name, `the button ${name}`);
  await visitor.click(byName, name).catch(() => visitor.click(byName, name)); /* it was drawn again in between */
}
/** @param {Visitor} visitor @param {string} selector */
export async function pushOn(visitor, selector) {
  await there(visitor, selector);
  await visitor.click(bySelector, selector).catch(() => visitor.click(bySelector, selector));
}
/** @param {Visitor} visitor @param {string} selector */
export const there = (visitor, selector) =>
  seen(visitor, (/** @type {string} */ at) => (document.querySelector(at)?.getClientRects().length ?? 0) > 0, selector, selector);
/** @param {Visitor} visitor */
export const framed = (visitor) => seen(visitor, () => (globalThis.laglab?.().frame ?? null) !== null, null, 'a frame');

/** @param {Visitor[]} visitors */
export async function quiet(...visitors) {
  for (const { complaints } of visitors) assert.deepEqual(await complaints(), []);
}

/** @param {string} file */
const fileOf = (file) => JSON.parse(readFileSync(new URL(`../../www/${file}`, import.meta.url), 'utf8'));
/** All words of a language by their keys. @param {string} lang @returns {Record<string, any>} */
const wordsOf = (lang) => Object.assign({}, ...Object.values(fileOf(`words/${lang}.json`)));

/** A text of the page: what stands in its gaps is the page's to say, but where it is given.
 * @param {string} text @param {Record<string, string>} [values] */
const reading = (text, values = {}) =>
  text
    .replace(/\s+/g, ' ')
    .trim()
    .split(/(\{\w+\})/)
    .map((one) => (/^\{\w+\}$/.test(one) ? (values[one.slice(1, -1)] ?? '.+') : one.replace(/[.*+?^${}()|[\]\\]/g, '\\$&')))
    .join('');

/** Until an element shows a text, which it gives. @param {Visitor} visitor @param {string} selector @param {string} pattern
 * @returns {Promise<string>} */
const reads = (visitor, selector, pattern) =>
  seen(
    visitor,
    ([at, wanted]) =>
      [...document.querySelectorAll(at)]
        .map((one) => /** @type {HTMLElement} */ (one).innerText.replace(/\s+/g, ' ').trim())
        .find((text) => new RegExp(wanted).test(text)),
    [selector, pattern],
    `${selector}: ${pattern}`,
  );

/** Until the two places that the sentence is about are seen apart. @param {Visitor} visitor @param {string} from @param {string} to */
const apart = (visitor, from, to) =>
  seen(
    visitor,
    ([a, b]) => {
      const now = globalThis.laglab.shown();
      return now?.from === a && now.to === b && now.px >= 40 && now.percent >= 3 && now.inside && now.seen;
    },
    [from, to],
    `${from} and ${to}, 40 px and 3 % apart`,
  );

/** @param {Open} open @param {string} at @returns {Promise<Person>} */
async function person(open, at) {
  const began = performance.now(),
    visitor = await open(at),
    /** @type {string[]} */ notes = [];
  let clicks = 0;
  const counted =
    (/** @type {Function} */ act) =>
    async (/** @type {any[]} */ ...args) => {
      const done = await act(...args);
      clicks++;
      return done;
    };
  return {
    ...visitor,
    click: counted(visitor.click),
    press: counted(visitor.press),
    clicks: () => clicks,
    note: (what) => notes.push(`${what}: ${((performance.now() - began) / 1000).toFixed(1)} s, ${clicks} clicks`),
    notes,
  };
}

/** From the first page, with nothing explained, to the end of the question to which it leads. @param {Open} open @param {string} lang
 * @param {{front?: (visitor: Visitor) => Promise<void>, end?: (visitor: Visitor) => Promise<void>}} [also] what else a test checks */
export async function firstVisit(open, lang, also = {}) {
  const words = wordsOf(lang),
    decimal = lang === 'de' ? ',' : '[.]',
    me = await person(open, `?lang=${lang}`);
  /** The server's car, as the page has it. @param {'x' | 'vx'} of @returns {Promise<number>} */
  const now = (of) =>
    me.evaluate((/** @type {'x' | 'vx'} */ name) => {
      const car = globalThis
        .laglab()
        .frame.plain()
        .entities.find((/** @type {any} */ one) => one.view === 0);
      return car[name];
    }, of);
  const until = async (/** @type {() => Promise<boolean>} */ test, /** @type {string} */ what) => {
    for (const end = Date.now() + LATE_MS; !(await test()); await wait(50))
      assert.ok(Date.now() < end, `not within ${LATE_MS} ms: ${what}`);
  };
  const says = async (/** @type {string} */ key, /** @type {Record<string, string>} */ values = {}) => {
    for (const part of ['was', 'do'])
      await reads(me, '#front-line', reading(words[`front.${key}.${part}`], { key: me.finger ? words['front.go'] : '→', ...values }));
  };
  const go = async () => {
    if (me.finger) return me.finger('.pedal[data-way="ahead"]');
    await me.down('ArrowRight');
    return () => me.up('ArrowRight');
  };
  /** @type {() => Promise<unknown>} */
  let release = () => Promise.resolve();
  const again = async () => {
    await release();
    const speed = await now('vx');
    await until(async () => (await now('vx')) < speed, 'the server knows that the key is up');
    release = await go();
  };
  const lit = (/** @type {string} */ name) => there(me, `.technique[data-lit="yes"] [data-path="players.0.${name}"]`);

  await framed(me);
  await says('drive');
  if (me.finger) await reads(me, '.pedal[data-way="ahead"]', reading(words['front.go']));
  me.note('asked to drive');
  await also.front?.(me);
  const x = await now('x');
  release = await go();
  await until(async () => (await now('x')) > x, 'the car drives');
  me.note('drives');
  await seen(me, () => globalThis.laglab().felt.felt.none, null, 'a latency');
  const { latency } = await me.evaluate(() => globalThis.laglab().felt.felt.none);
  assert.ok(latency > 0.3 && latency < 0.4, `${latency} s: there and back, and the next updates`);
  const s = latency.toFixed(2).replace('.', decimal);
  await says('late', { s });
  await reads(me, '#front-latency', `^${s} s$`);
  await apart(me, 'nose_0', 'true_nose_0');
  await lit('prediction');
  me.note('sees how late it is');
  assert.equal(me.clicks(), 0, 'before the first click');
  assert.equal(
    await me.evaluate(() => document.querySelector('[data-path="players.0.reconciliation"]')?.matches(':disabled')),
    true,
    'needs Predict',
  );
  await pushOn(me, '.technique:has([data-path="players.0.prediction"])');
  await says('again_predict');
  me.note('predicts');
  await again();
  await says('thrown', { s: `0${decimal}00` });
  await reads(me, '#front-latency', `^0${decimal}00 s$`);
  await apart(me, 'nose_0', 'true_nose_0');
  await lit('reconciliation');
  await pushOn(me, '.technique:has([data-path="players.0.reconciliation"])');
  await says('again_both');
  await again();
  await says('stays', { s: `0${decimal}00`, age: `0${decimal}1[678]` });
  await apart(me, 'nose_1', 'true_nose_1');
  me.note('corrects, and sees that the other car is old');
  await release();

  await push(me, words['front.why']);
  await lesson(me, 'in_the_past', lang);
  await also.end?.(me);
  await push(me, words.all);
  await says('drive');
  return me;
}

/** A question, answered right, to its end. @param {Person} me @param {string} id @param {string} lang */
async function lesson(me, id, lang) {
  const { title, steps, choices, answer, change, shows, stop_tick } = fileOf(`lessons/${id}.json`),
    words = wordsOf(lang);
  const stands = () =>
    seen(me, (/** @type {number} */ tick) => globalThis.laglab().frame?.tick === tick, stop_tick, `tick ${stop_tick}, where it stops`);
  const amount = async (/** @type {string} */ at, /** @type {{value: number, tol: number}} */ { value, tol }) => {
    const text = await reads(me, at, '\\d'),
      shown = Number.parseFloat(text.replace(',', '.'));
    assert.ok(Math.abs(shown - value) <= tol, `${at}: ${text}`);
  };
  await reads(me, '#lesson-step', reading(title[lang]));
  await reads(me, '#rail p', reading(steps.predict[lang]));
  await framed(me);
  const right = choices.findIndex((/** @type {any} */ one) => one.right);
  await me.press(String(right + 1));
  await reads(me, '#lock-in', reading(words['predict.go']));
  me.note('has answered a question');
  await pushOn(me, '#lock-in');
  await reads(me, '#rail p', reading(steps.observe[lang]));
  await stands();
  await apart(me, shows.observe.from, shows.observe.to);
  await push(me, words['steps.explain']);
  await reads(me, '.why', reading(choices[right].why[lang]));
  await reads(me, '#rail p', reading(steps.explain[lang]));
  await amount('#answer', answer);
  me.note('has it explained');
  await push(me, words['steps.change']);
  await reads(me, '#rail p', reading(steps.change[lang]));
  await amount('#changed', change.answer);
  await push(me, words['change.go']);
  await seen(me, () => globalThis.laglab().frame?.tick < 60, null, 'it begins again');
  await stands();
  await apart(me, shows.change.from, shows.change.to);
  me.note('has seen what one change does');
}

/** A teacher opens a class on the first page, with question 1 on the projector; two students vote, see the run, read their own reason, and
 * drive. @param {Open} open the teacher's @param {Open[]} students @param {string} lang
 * @param {(phase: string, teacher: Visitor, students: Visitor[]) => Promise<void>} [look] what else a test checks */
export async function firstClass(open, students, lang, look = async () => {}) {
  const { steps, choices, answer } = fileOf('lessons/late_answer.json'),
    words = wordsOf(lang),
    teacher = await person(open, `?lang=${lang}`);
  await framed(teacher);
  const began = teacher.clicks();
  await push(teacher, words['shell.class']);
  await there(teacher, '#class .next');
  teacher.note('class open');
  const code = await seen(teacher, () => /^#class=(\w{4})$/.exec(location.hash)?.[1], null, 'a code');

  /* One types the code on the first page, the other opens its address. */
  const [a, b] = await Promise.all([
    person(students[0], `#questions&lang=${lang}`).then(async (me) => {
      await pushOn(me, '#join-code');
      for (const letter of code.toLowerCase()) await me.press(letter);
      await me.press('Enter');
      await there(me, '#class-seat-0');
      await me.listen?.();
      return me;
    }),
    person(students[1], `?lang=${lang}#class=${code}`),
  ]);
  const pupils = [a, b];
  for (const [i, me] of pupils.entries()) {
    await push(me, words['class.play'].replace('{player}', 'AB'[i]));
    await reads(me, '#class', reading(words['class.are_in']));
    me.note('is in');
  }
  const phase = async (/** @type {string} */ name) => {
    for (const me of [teacher, ...pupils]) await there(me, `[data-phase="${name}"]`);
    await look(name, teacher, pupils);
  };
  const next = () => pushOn(teacher, '#class .next');
  await phase('lobby');

  await next();
  await reads(teacher, '.asked', reading(steps.predict[lang]));
  teacher.note('question 1 on the projector');
  assert.ok(teacher.clicks() - began <= 3, `${teacher.clicks() - began} clicks until the question is on the projector`);
  await phase('predict');
  const label = (/** @type {number} */ i) => reading(choices[i].label?.[lang] ?? `${choices[i].value} ms`);
  for (const me of pupils) await reads(me, '.asked', reading(steps.predict[lang]));
  await a.press('2');
  await pushOn(b, '.answer:nth-of-type(3)');
  for (const [i, me] of pupils.entries()) {
    await reads(me, '.after', reading(words['class.sent'], { choice: label(i + 1) }));
    me.note('has voted');
  }
  assert.equal(await teacher.evaluate(() => document.querySelector('.tally')), null, 'no bar before the lock');
  await next();
  for (const me of [teacher, ...pupils]) await there(me, '.tally');
  await phase('locked');
  await next();
  await phase('stopped');
  for (const me of [teacher, ...pupils]) await reads(me, '.classwords', reading(steps.observe[lang]));
  await next();
  await phase('explain');
  for (const me of [teacher, ...pupils]) {
    const was = await reads(me, '.measured', reading(answer.says?.[lang] ?? words['class.was']));
    assert.ok(Math.abs(Number(/(\d+) ms/.exec(was)?.[1]) - answer.value) <= answer.tol, was);
    await reads(me, '.classwords', reading(steps.explain[lang]));
  }
  for (const [i, me] of pupils.entries()) {
    await reads(me, '.reasoned', `^${reading(words['class.you_said'], { choice: label(i + 1) })} ${reading(choices[i + 1].why[lang])}$`);
    me.note('reads why');
  }
  teacher.note('explained');

  /* What is seldom needed. */
  await push(teacher, words['class.more']);
  await push(teacher, words['class.do.free']);
  for (const [player, me] of pupils.entries()) {
    await reads(me, '#class', reading(words['class.you_drive']));
    await me.evaluate(
      (/** @type {number} */ of) => /** @type {HTMLElement} */ (document.querySelector(`.view[data-drive="${of}"]`)).focus(),
      player,
    );
    await me.down('ArrowRight');
    await seen(
      teacher,
      (/** @type {number} */ of) =>
        globalThis
          .laglab()
          .frame?.plain()
          .entities.filter((/** @type {any} */ one) => one.view === 0)[of]?.vx > 0.5,
      player,
      `player ${player} drives`,
    );
    await me.up('ArrowRight');
  }
  await push(teacher, words['class.more']);
  await push(teacher, words['class.freeze']);
  for (const me of pupils) await reads(me, '#class', reading(words['class.frozen']));
  await push(teacher, words['class.end']);
  await push(teacher, words['class.end_all']);
  for (const me of pupils) await reads(me, '#class', reading(words['class.ended_code']));
  return [teacher, ...pupils];
}
