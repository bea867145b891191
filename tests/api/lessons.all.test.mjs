// The questions of all lessons, and the cards, asked of the engine.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { FOLDER, engine, layout, lessonIds, problems, withNumbers } from '../../docs/lessons.mjs';
import { CARDS, cards, layout as layoutCards } from '../../docs/cards.mjs';
import { BINARY } from '../lib/daemon.mjs';

const textOf = (/** @type {string} */ id) => readFileSync(path.join(FOLDER, `${id}.json`), 'utf8');
const read = (/** @type {string} */ id) => JSON.parse(textOf(id));
const asked = engine(BINARY);

for (const id of lessonIds())
  test(`${id}: the engine gives its answers and numbers`, () => {
    assert.deepEqual(problems(read(id), asked), []);
    assert.equal(textOf(id), `${layout(withNumbers(read(id), asked))}\n`, 'node docs/lessons.mjs writes it');
  });

test('what the cards play is what the engine gives', () => {
  assert.equal(readFileSync(CARDS, 'utf8'), layoutCards(cards(asked)), 'node docs/cards.mjs writes it');
});
