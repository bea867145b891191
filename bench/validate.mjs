// Stoplight Prism as a validating proxy between a client that uses every operation at random (tests/lib/explorer.mjs) and the daemon: it
// judges each answer by the contract that the daemon serves. The goal is no violation. Prism is fetched into build/prism, pinned.
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdirSync } from 'node:fs';
import { join } from 'node:path';
import { client } from '../tests/lib/client.mjs';
import { Explorer } from '../tests/lib/explorer.mjs';
import { root, say, writeCsv } from './lib.mjs';
import { answers, freePort } from './proxies/proxies.mjs';

const PRISM = '@stoplight/prism-cli@5.16.0',
  TURNS = 150;
const number = (name, otherwise) => Number(process.argv.find((word) => word.startsWith(`--${name}=`))?.split('=')[1] ?? otherwise);
const seed = number('seed', 1),
  seconds = number('seconds', process.argv.includes('--quick') ? 60 : 300);

const folder = join(root, 'build/prism');
if (!existsSync(join(folder, 'node_modules/.bin/prism'))) {
  mkdirSync(folder, { recursive: true });
  execFileSync(
    'npm',
    ['install', '--no-save', '--ignore-scripts', '--no-audit', '--no-fund', '--loglevel=error', '--prefix', folder, PRISM],
    {
      stdio: 'inherit',
    },
  );
}

async function prism(daemon) {
  const port = await freePort(),
    document = `http://127.0.0.1:${daemon}/api/v1/openapi.yaml`;
  const options = ['--port', port, '--validate-request', false, '--cors', false, '--verboseLevel', 'silent'].map(String);
  const child = spawn(join(folder, 'node_modules/.bin/prism'), ['proxy', document, `http://127.0.0.1:${daemon}`, ...options], {
    stdio: ['ignore', 'ignore', 'inherit'],
  });
  const ended = new Promise((resolve) => child.once('exit', resolve));
  process.once('exit', () => child.kill());
  if (!(await Promise.race([answers(port, 60), ended.then(() => false)]))) throw new Error('Prism did not start');
  return {
    url: `http://127.0.0.1:${port}`,
    stop: async () => {
      child.kill();
      await ended;
    },
  };
}

/** By operation. @type {Map<string, {answers: number, judged: number, statuses: Set<number>, violations: string[]}>} */
const operations = new Map();

class Judged extends Explorer {
  async start() {
    const first = !this.contract;
    await super.start();
    this.url = this.daemon.url; // of streams, since Prism passes no upgrade on
    const past = client(this.daemon.url),
      through = this.c.call;
    // Prism itself answers what it cannot read, such as JSON of a thousand brackets; that goes past it.
    this.c.call = async (...wish) => {
      const answer = await through(...wish);
      return answer.headers['x-request-id'] ? answer : past.call(...wish);
    };
    if (first) this.judge();
  }

  judge() {
    for (const [template, item] of Object.entries(this.contract.api.paths))
      for (const method of ['get', 'put', 'post', 'patch', 'delete'])
        if (item[method]) operations.set(`${method} ${template}`, { answers: 0, judged: 0, statuses: new Set(), violations: [] });
    const { check } = this.contract;
    this.contract.check = (method, template, answer) => {
      const of = operations.get(`${method} ${template}`),
        said = answer.headers['sl-violations'];
      const violations = said ? JSON.parse(String(said)) : [];
      // An id with a slash is a path of another form to Prism, which does not find its operation.
      const judged = answer.headers['x-request-id'] && !violations.some(({ message }) => message === 'Selected route not found');
      of.answers++;
      of.judged += Number(judged);
      of.statuses.add(answer.status);
      for (const { location, message } of violations)
        if (location[0] === 'response') of.violations.push(`${answer.status} ${location.join('.')}: ${message}`);
      return check(method, template, answer);
    };
  }
}

const explorer = new Judged(seed, prism);
await explorer.start();
// Each once: then at random. Of a stream without an upgrade, which Prism does not know.
const nobody = { id: 'a'.repeat(26), code: '2222', run: 0 };
for (const operation of operations.keys()) {
  const [method, template] = operation.split(' ');
  await explorer.call(method, template, nobody, ['put', 'post', 'patch'].includes(method) ? { body: {} } : {});
}
const until = performance.now() + 1000 * seconds;
let failure = '';
try {
  for (let round = 0; performance.now() < until; round++) await explorer.round(round, TURNS, until);
} catch (error) {
  failure = `${error.stack}\n${explorer.last.join('\n')}`;
}
await explorer.end();

const rows = [...operations].map(([operation, of]) => ({
  operation,
  answers: of.answers,
  judged: of.judged,
  statuses: [...of.statuses].sort().join(' '),
  violations: of.violations.length,
  first: of.violations[0] ?? '',
}));
for (const row of rows.filter(({ violations, judged }) => violations || !judged)) say(JSON.stringify(row));
const violations = rows.reduce((sum, row) => sum + row.violations, 0);
say(`${rows.reduce((sum, row) => sum + row.judged, 0)} answers of ${rows.length} operations judged: ${violations} violations`);
if (failure) say(failure);
writeCsv(
  'validate',
  'bench/run validate',
  {
    operation: `of openapi.yaml; seed ${seed}, ${seconds} s, ${PRISM}`,
    answers: 'of the daemon',
    judged: 'that came through Prism, and whose operation it found',
    statuses: 'among them',
    violations: 'found by Prism',
    first: 'of them',
  },
  rows,
);
process.exitCode = violations || failure ? 1 : 0;
