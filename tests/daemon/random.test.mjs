// Requests of every operation, valid ones and damaged ones, in an order that a seed chooses: the daemon stays, each answer is one that
// openapi.yaml has, and the same tick is always the same state: after seeks, in forks, replays, and restarts.
// LAGLAB_RANDOM_SEED and LAGLAB_RANDOM_S (seconds in place of rounds) choose others, LAGLAB_RANDOM_TRACE=FILE writes all requests; with a
// daemon that has sanitizers (LAGLAB_BIN) it can run for hours.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Explorer } from '../lib/explorer.mjs';

const SEED = Number(process.env.LAGLAB_RANDOM_SEED ?? 20261128),
  SECONDS = Number(process.env.LAGLAB_RANDOM_S ?? 0),
  ROUNDS = SECONDS ? Infinity : 1,
  TURNS = 200,
  MOST_FAILURES = Number(process.env.LAGLAB_RANDOM_FAILURES ?? 1);

test(`requests at random, ${SECONDS ? `for ${SECONDS} s` : `${ROUNDS * TURNS} turns`}`, async () => {
  const failures = /** @type {string[]} */ ([]),
    until = SECONDS ? performance.now() + SECONDS * 1000 : Infinity;
  let explorer = new Explorer(SEED);
  const total = { requests: 0, rounds: 0 };
  try {
    await explorer.start();
    for (let round = 0; round < ROUNDS && performance.now() < until && failures.length < MOST_FAILURES; round++) {
      try {
        await explorer.round(round, TURNS, until);
      } catch (error) {
        await new Promise((resolve) => setTimeout(resolve, 300));
        const said = [
          `seed ${SEED}, round ${round}, ${new Date().toISOString()}: ${error.stack}`,
          'The last requests:',
          ...explorer.last,
          explorer.daemon.errors(),
        ].join('\n');
        failures.push(said);
        process.stderr.write(`${said}\n\n`);
        total.requests += explorer.requests;
        total.rounds += explorer.compared.rounds;
        await explorer.end();
        explorer = new Explorer(SEED);
        await explorer.start();
      }
      if (SECONDS > 60)
        process.stderr.write(`round ${round}: ${explorer.requests} requests, rss ${Math.round(explorer.rss() / 2 ** 20)} MiB\n`);
    }
    process.stderr.write(
      `${total.requests + explorer.requests} requests, ${Object.keys(explorer.answers).length} of the documented answers, ` +
        `${JSON.stringify(explorer.compared)}\n`,
    );
  } finally {
    await explorer.end();
  }
  assert.equal(failures.length, 0, 'see above');
});
