// The workflows of deploy/snakemake and deploy/nextflow: their commands, taken from the files, give the rows of an undivided sweep. Where
// Snakemake is installed it runs its file as it is.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { BINARY } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const SNAKEFILE = path.join(ROOT, 'deploy/snakemake/Snakefile'),
  NEXTFLOW = path.join(ROOT, 'deploy/nextflow/main.nf');
const SHARDS = 3;
const ORDER = {
  scenario: 'race',
  set: { duration_s: 3 },
  axes: [{ path: 'players.0.lag_ms', values: [0, 80, 160, 240] }],
  repeats: 5,
  metrics: ['players.0.remote_error_m.mean'],
};

let folder, whole;
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-workflows-'));
  writeFileSync(path.join(folder, 'lag.json'), JSON.stringify(ORDER));
  whole = execFileSync(BINARY, ['sweep', 'lag.json'], { cwd: folder, encoding: 'utf8' });
});
after(() => rmSync(folder, { recursive: true, force: true }));

/** A folder with the experiment. @param {string} name */
function place(name) {
  const at = path.join(folder, name);
  mkdirSync(path.join(at, 'shards'), { recursive: true });
  writeFileSync(path.join(at, 'lag.json'), JSON.stringify(ORDER));
  return at;
}

/** A command with values for what it leaves open; nothing may stay open. @param {string} template @param {RegExp} hole
 * @param {Record<string, string | number>} values */
function filled(template, hole, values) {
  return template.replace(hole, (_, name) => {
    assert.ok(name in values, `${template}: ${name}`);
    return String(values[name]);
  });
}

/** @param {string} command @param {string} at */
function shell(command, at) {
  const { status, stderr } = spawnSync('sh', ['-c', command], { cwd: at, encoding: 'utf8' });
  assert.equal(status, 0, `${command}: ${stderr}`);
}

test("the commands of Snakemake's rules", () => {
  const text = readFileSync(SNAKEFILE, 'utf8'),
    at = place('commands');
  const rules = Object.fromEntries(
    [...text.matchAll(/^rule (\w+):\n((?: {4}.*\n)+)/gm)].map(([, name, body]) => [
      name,
      { command: /^ {4}shell: "(.*)"$/m.exec(body)?.[1] ?? '', output: /^ {4}output: "(.*)"$/m.exec(body)?.[1] ?? '' },
    ]),
  );
  assert.deepEqual(Object.keys(rules), ['all', 'shard', 'merge']);
  const hole = /\{([\w.]+)\}/g,
    values = { LAGLAB: BINARY, EXPERIMENT: 'lag.json', SHARDS, threads: 1 };
  const shards = Array.from({ length: SHARDS }, (_, i) => filled(rules.shard.output, hole, { i: i + 1 }));
  for (const [i, output] of shards.entries()) shell(filled(rules.shard.command, hole, { ...values, 'wildcards.i': i + 1, output }), at);
  shell(filled(rules.merge.command, hole, { ...values, input: shards.join(' '), output: rules.merge.output }), at);
  assert.equal(readFileSync(path.join(at, rules.merge.output), 'utf8'), whole);
});

test("the commands of Nextflow's processes", () => {
  const text = readFileSync(NEXTFLOW, 'utf8'),
    at = place('processes');
  const processes = Object.fromEntries(
    [...text.matchAll(/^process (\w+) \{\n(.*?)^\}/gms)].map(([, name, body]) => [
      name,
      { command: /"""\n\s*(.*?)\n\s*"""/s.exec(body)?.[1] ?? '', output: /^ {4}output:\n {4}path ["'](.*)["']$/m.exec(body)?.[1] ?? '' },
    ]),
  );
  assert.deepEqual(Object.keys(processes), ['shard', 'merge']);
  const hole = /\$\{([\w.]+)\}/g,
    values = { 'params.laglab': BINARY, 'params.experiment': 'lag.json', 'params.shards': SHARDS, 'task.cpus': 1 };
  const shards = Array.from({ length: SHARDS }, (_, i) => filled(processes.shard.output, hole, { i: i + 1 }));
  for (const [i, output] of shards.entries()) {
    shell(filled(processes.shard.command, hole, { ...values, i: i + 1 }), at);
    assert.ok(existsSync(path.join(at, output)), output);
  }
  shell(filled(processes.merge.command, hole, { ...values, shards: shards.join(' ') }), at);
  assert.equal(readFileSync(path.join(at, processes.merge.output), 'utf8'), whole);
});

const snakemake = spawnSync('snakemake', ['--version']).status === 0;
test('Snakemake runs its file as it is', { skip: snakemake ? false : 'snakemake is not installed' }, () => {
  const at = place('snakemake');
  const wish = ['--config', 'experiment=lag.json', `shards=${SHARDS}`, `laglab=${BINARY}`];
  const run = spawnSync('snakemake', ['-s', SNAKEFILE, '--cores', '2', ...wish], {
    cwd: at,
    encoding: 'utf8',
    env: { ...process.env, HOME: at },
  });
  assert.equal(run.status, 0, run.stderr);
  assert.equal(readFileSync(path.join(at, 'rows.csv'), 'utf8'), whole);
});
