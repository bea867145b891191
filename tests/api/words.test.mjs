// The page's words: each language names every parameter of every kind, every choice and stream field of a netgame, and every metric, and
// each name is short enough.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { LANGUAGES } from '../../docs/lessons.mjs';
import { BINARY } from '../lib/daemon.mjs';
import { findings, readList } from '../structure/words.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const LABEL_MAX = 36, // a line of the narrowest panel
  TIP_MAX = 72; // one line of a tooltip
const RECORDS = ['views', 'buffers', 'measures', 'peers']; // of the page of a netgame
const LABS = ['motion', 'rigid', 'fluid'];

/** @typedef {{label: string, tip: string}} Entry */
/** @typedef {{language: string, name: string, units: Record<string, string>, params: Record<string, Entry>, metrics: Record<string, Entry>,
 * records: Record<string, Entry>, choices: Record<string, string>, labs: Record<string, Record<string, Entry>>, inputs: Record<string,
 * Record<string, Entry>>, lesson: Record<string, string>, compare: Record<string, string>}} Words */

/** @type {Record<string, Words>} */
const words = Object.fromEntries(
  LANGUAGES.map((language) => [language, JSON.parse(readFileSync(path.join(ROOT, `www/words/${language}.json`), 'utf8'))]),
);
const ask = (/** @type {string[]} */ ...args) =>
  JSON.parse(execFileSync(BINARY, ['schema', ...args], { encoding: 'utf8', maxBuffer: 1 << 26 }));
const schema = ask(),
  stream = ask('stream'),
  kinds = ask('metrics').kinds;

/** Every parameter of a netgame with its unit, and every value of those that are choices; both directions of a link are one. */
function params() {
  const found = new Map(),
    choices = new Set();
  const visit = (node, at) => {
    for (const [name, row] of Object.entries(node.properties)) {
      const here = at ? `${at}.${name}` : name;
      const ref = row.$ref ?? row.items?.$ref;
      if (here === 'timeline' || here === 'expect') continue; // no value that a panel shows
      if (row.anyOf) for (const game of node.properties.game.enum) visit(schema.$defs[game], here);
      else if (ref) visit(schema.$defs[ref.split('/').pop()], row.items ? `${here}.*` : here);
      else {
        const key = here.replace(/\.link\.(?:up|down)\./, '.link.*.');
        found.set(key, row['x-unit'] ?? '');
        for (const choice of row.enum ?? []) choices.add(`${key}.${choice}`);
      }
    }
  };
  visit(
    schema.oneOf.find((kind) => kind.properties.kind?.const === 'netgame' || kind.title === 'netgame'),
    '',
  );
  return { found, choices };
}

/** Every parameter of another kind with its unit; those side by side are as the first. @param {string} wanted */
function inputs(wanted) {
  const found = new Map();
  const visit = (node, at) => {
    for (const [name, row] of Object.entries(node.properties)) {
      const here = at ? `${at}.${name}` : name;
      if (['timeline', 'expect', 'side_by_side'].includes(here)) continue;
      const refs = [row.$ref, row.items?.$ref, ...(row.anyOf ?? []).map((any) => any.$ref)].filter(Boolean);
      for (const ref of refs) visit(schema.$defs[ref.split('/').pop()], row.items ? `${here}.*` : here);
      if (refs.length === 0) found.set(here, row['x-unit'] ?? '');
    }
  };
  visit(
    schema.oneOf.find(({ title }) => title === wanted),
    '',
  );
  return found;
}

/** @param {string} wanted */
function metrics(wanted) {
  const found = new Map();
  for (const { path: at, metrics } of kinds.find(({ kind }) => kind === wanted).tables)
    for (const { name, unit } of metrics) found.set(at === '' ? name : `${at}.${name}`, unit ?? '');
  return found;
}

const records = () =>
  new Map(
    stream.records
      .filter(({ name }) => RECORDS.includes(name))
      .flatMap(({ name, fields }) => fields.map((field) => [`${name}.${field.name}`, field.unit ?? ''])),
  );

const { found, choices } = params();
const parts = { params: found, metrics: metrics('netgame'), records: records() };
const labs = Object.fromEntries(LABS.map((kind) => [kind, metrics(kind)]));
const given = Object.fromEntries(LABS.map((kind) => [kind, inputs(kind)]));

for (const [part, rows] of Object.entries(parts))
  for (const language of LANGUAGES)
    test(`${language}: every one of the ${part} has a name, and no other has`, () => {
      const named = Object.keys(words[language][/** @type {'params'} */ (part)]);
      assert.ok(rows.size > 40, `${rows.size} ${part}`);
      assert.deepEqual(
        named.filter((key) => !rows.has(key)),
        [],
        'unknown',
      );
      assert.deepEqual(
        [...rows.keys()].filter((key) => !named.includes(key)),
        [],
        'without a name',
      );
    });

for (const [kind, rows] of Object.entries(labs))
  test(`every metric of ${kind} has a name in both languages, and no other has`, () => {
    assert.ok(rows.size > 30);
    for (const language of LANGUAGES) assert.deepEqual(Object.keys(words[language].labs[kind]).sort(), [...rows.keys()].sort(), language);
  });

for (const [kind, rows] of Object.entries(given))
  test(`every parameter of ${kind} has a name in both languages, and no other has`, () => {
    assert.ok(rows.size > 40, `${rows.size}`);
    for (const language of LANGUAGES) assert.deepEqual(Object.keys(words[language].inputs[kind]).sort(), [...rows.keys()].sort(), language);
  });

test('what the schema of lessons has to be chosen has a name', () => {
  const lesson = JSON.parse(readFileSync(path.join(ROOT, 'api/lesson.schema.json'), 'utf8')).properties;
  const wanted = [
    ...Object.keys(lesson.steps.properties).map((step) => `steps.${step}`),
    ...lesson.topic.enum.map((topic) => `topic.${topic}`),
    ...lesson.hooks.items.enum.map((hook) => `hooks.${hook}`),
  ];
  for (const language of LANGUAGES) for (const key of wanted) assert.ok(words[language].lesson[key], `${language} ${key}`);
  assert.deepEqual(Object.keys(words.de.lesson), Object.keys(words.en.lesson));
});

test('what the comparison of two runs says is there in both languages, with the same numbers', () => {
  const { en, de } = words;
  assert.ok(Object.keys(en.compare).length > 20);
  assert.deepEqual(Object.keys(de.compare), Object.keys(en.compare));
  const places = (/** @type {string} */ text) => [...text.matchAll(/\{\w+\}/g)].map(String).sort();
  for (const [key, text] of Object.entries(en.compare)) assert.deepEqual(places(de.compare[key]), places(text), key);
});

test('every value of a choice has a name in both languages', () => {
  for (const language of LANGUAGES) {
    const named = words[language].choices;
    assert.deepEqual(Object.keys(named).sort(), [...choices].sort());
    for (const [key, label] of Object.entries(named)) {
      assert.ok(label.length > 0 && label.length <= LABEL_MAX, `${language} ${key}: has ${label.length} characters`);
      assert.match(label, /^[^_\n"]*[^_\n".\s]$/, key);
    }
  }
});

test('every unit has a name in both languages', () => {
  const units = new Set([...Object.values(parts), ...Object.values(labs), ...Object.values(given)].flatMap((rows) => [...rows.values()]));
  units.delete('');
  for (const language of LANGUAGES) for (const unit of units) assert.ok(words[language].units[unit], `${language}: ${unit}`);
  assert.deepEqual(Object.keys(words.de.units), Object.keys(words.en.units));
});

/** @type {(visit: (where: string, entry: Entry, language: string) => void) => void} */
const each = (visit) => {
  for (const language of LANGUAGES)
    for (const part of /** @type {const} */ (['params', 'metrics', 'records']))
      for (const [key, entry] of Object.entries(words[language][part])) visit(`${language} ${part} ${key}`, entry, language);
  for (const language of LANGUAGES)
    for (const [kind, entries] of Object.entries(words[language].labs))
      for (const [key, entry] of Object.entries(entries)) visit(`${language} ${kind} ${key}`, entry, language);
  for (const language of LANGUAGES)
    for (const [kind, entries] of Object.entries(words[language].inputs))
      for (const [key, entry] of Object.entries(entries)) visit(`${language} inputs ${kind} ${key}`, entry, language);
};

test('labels and tips fit, and are text', () => {
  each((where, { label, tip, ...others }) => {
    assert.deepEqual(others, {}, where);
    assert.ok(label.length > 0 && label.length <= LABEL_MAX, `${where}: the label has ${label.length} characters`);
    assert.ok(tip.length > 0 && tip.length <= TIP_MAX, `${where}: the tip has ${tip.length} characters`);
    assert.match(label, /^\p{Lu}/u, where);
    for (const text of [label, tip]) assert.doesNotMatch(text, /[_\n"]|\s$|^\s|\.$/, where);
  });
});

test('English has no banned words, German is German', () => {
  const list = readList(readFileSync(path.join(ROOT, 'tests/structure/words.txt'), 'utf8'));
  each((where, { label, tip }, language) => {
    if (language === 'en') assert.deepEqual(findings(`${label}. ${tip}`, 'markdown', list), [], where);
    else assert.doesNotMatch(`${label} ${tip}`, /\b(?:fuer|ueber|koennen|muessen|waere|groesse|the|of|and)\b/i, where);
  });
  for (const part of /** @type {const} */ (['params', 'metrics', 'records']))
    for (const [key, { tip }] of Object.entries(words.en[part]))
      assert.notEqual(words.de[part][key].tip, tip, `${part} ${key}: is not translated`);
  for (const [kind, entries] of Object.entries(words.en.inputs))
    for (const [key, { tip }] of Object.entries(entries))
      assert.notEqual(words.de.inputs[kind][key].tip, tip, `${kind} ${key}: is not translated`);
});
