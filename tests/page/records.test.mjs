// The page's decoder and the encoder in C: chains of random rows of every form, and faults.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import path from 'node:path';
import { test } from 'node:test';
import { readSection, StreamError } from '../../www/js/stream/decode.js';

const PROGRAM = path.join(path.dirname(process.env.LAGLAB_BIN ?? 'build/laglab'), 'tests/record/test_record');
const FIELDS = [
  { name: 'width', coding: 'int' },
  { name: 'height', coding: 'int' },
  { name: 'number', coding: 'int' },
  { name: 'sign', coding: 'int' },
  { name: 'big', coding: 'int' },
  { name: 'on', coding: 'int', boolean: true },
  { name: 'kind', coding: 'int', names: ['soup', 'pie'] },
  { name: 'x', coding: 'step', bits: 13 },
  { name: 'energy', coding: 'real', bits: 23 },
  { name: 'ms', coding: 'step', bits: 7 },
];
const layoutOf = (/** @type {string} */ form) => ({
  id: 1,
  name: form,
  channel: 'scene',
  form,
  ...(form === 'keyed' ? { keys: 3 } : {}),
  fields: FIELDS,
});

/** As JSON has it: names of values, and null for what is no number. @param {any} row */
const told = (row) => ({
  ...row,
  kind: FIELDS[6]?.names?.[row.kind],
  ...Object.fromEntries(['x', 'energy', 'ms'].map((name) => [name, Number.isFinite(row[name]) ? row[name] || 0 : null])),
  ...(row.values ? { values: [...row.values] } : {}),
});

const chains = execFileSync(PROGRAM, ['rows', 'vectors', '300'], { encoding: 'utf8', maxBuffer: 1 << 28 })
  .trim()
  .split('\n')
  .map((line) => JSON.parse(line));

test('chains of sections come out as they went in', () => {
  let last = null,
    seen = 0;
  for (const { record, whole, bytes, rows } of chains) {
    const base = whole || last?.layout.name !== record ? null : last;
    const section = readSection(layoutOf(record), base, Buffer.from(bytes, 'hex'));
    assert.deepEqual(section.rows().map(told), rows);
    last = section;
    seen += rows.length;
  }
  assert.ok(seen > 5000, `${seen} rows`);
});

test('a column has the values of the rows', () => {
  const { record, bytes } = chains.find(({ record: name, whole, rows }) => name === 'by_index' && whole && rows.length > 4);
  const section = readSection(layoutOf(record), null, Buffer.from(bytes, 'hex'));
  for (const { name, boolean } of FIELDS) {
    assert.deepEqual(
      [...section.column(name)],
      section.rows().map((row) => (boolean ? Number(row[name]) : row[name])),
      name,
    );
  }
});

test('bytes that end too early are refused', () => {
  for (const { record, bytes } of chains.filter((_, i) => i % 50 === 0 && i % 300 === 0)) {
    const all = Buffer.from(bytes, 'hex');
    for (let n = 0; n < all.length; n++) assert.throws(() => readSection(layoutOf(record), null, all.subarray(0, n)), StreamError);
  }
});
