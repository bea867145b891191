// An experiment in shards by the queues of docs/experiments.md: the commands for Snakemake, Nextflow, Kubernetes and Slurm, taken from the
// files, give rows, report and points of an undivided sweep. Snakemake itself: snakemake.all.test.mjs.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, symlinkSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { BINARY } from '../lib/daemon.mjs';
import { parse } from '../lib/objects.mjs';
import { makeFolder, RESULTS, ROOT, results, SHARDS, SNAKEFILE } from '../lib/workflows.mjs';

const NEXTFLOW = path.join(ROOT, 'deploy/nextflow/main.nf');

/** @type {ReturnType<typeof makeFolder>} */ let folder;
before(() => {
  folder = makeFolder();
});
after(() => folder.remove());

/** A command with values for what it leaves open; nothing may stay open. @param {string} template @param {RegExp} hole
 * @param {Record<string, string | number>} values */
function filled(template, hole, values) {
  return template.replace(hole, (_, name) => {
    assert.ok(name in values, `${template}: ${name}`);
    return String(values[name]);
  });
}

/** @param {string} command @param {string} at @param {Record<string, string>} [env] */
function shell(command, at, env) {
  const { status, stderr } = spawnSync('sh', ['-c', command], { cwd: at, encoding: 'utf8', env: { ...process.env, ...env } });
  assert.equal(status, 0, `${command}: ${stderr}`);
}

test("the commands of Snakemake's rules", () => {
  const text = readFileSync(SNAKEFILE, 'utf8'),
    at = folder.place('commands');
  const rules = Object.fromEntries(
    [...text.matchAll(/^rule (\w+):\n((?: {4}.*\n)+)/gm)].map(([, name, body]) => [
      name,
      { command: /^ {4}shell: "(.*)"$/m.exec(body)?.[1] ?? '', output: /^ {4}output: (.*)$/m.exec(body)?.[1] ?? '' },
    ]),
  );
  assert.deepEqual(Object.keys(rules), ['all', 'shard', 'merge', 'points']);
  const hole = /\{([\w.]+)\}/g,
    values = { LAGLAB: `'${BINARY}'`, EXPERIMENT: 'lag.json', SHARDS, threads: 1 },
    files = (/** @type {string} */ rule) => [...rules[rule].output.matchAll(/"(.*?)"/g)].map(([, name]) => name);
  const shards = Array.from({ length: SHARDS }, (_, i) => filled(files('shard')[0], hole, { i: i + 1 }));
  for (const [i, output] of shards.entries()) shell(filled(rules.shard.command, hole, { ...values, 'wildcards.i': i + 1, output }), at);
  const [rows, report] = files('merge');
  shell(filled(rules.merge.command, hole, { ...values, input: shards.join(' '), 'output.rows': rows, 'output.report': report }), at);
  shell(filled(rules.points.command, hole, { ...values, input: rows, output: files('points')[0] }), at);
  assert.deepEqual(results(at), folder.whole);
});

test("the commands of Nextflow's processes", () => {
  const text = readFileSync(NEXTFLOW, 'utf8'),
    at = folder.place('processes');
  const processes = Object.fromEntries(
    [...text.matchAll(/^process (\w+) \{\n(.*?)^\}/gms)].map(([, name, body]) => [
      name,
      {
        command: /"""\n\s*(.*?)\n\s*"""/s.exec(body)?.[1] ?? '',
        outputs: [...(/^ {4}output:\n((?: {4}path .*\n)+)/m.exec(body)?.[1].matchAll(/path ["'](.*?)["']/g) ?? [])].map(([, name]) => name),
      },
    ]),
  );
  assert.deepEqual(Object.keys(processes), ['shard', 'merge', 'points']);
  const hole = /\$\{([\w.]+)\}/g,
    values = { 'params.laglab': `'${BINARY}'`, 'params.experiment': 'lag.json', 'params.shards': SHARDS, 'task.cpus': 1 };
  const shards = Array.from({ length: SHARDS }, (_, i) => filled(processes.shard.outputs[0], hole, { i: i + 1 }));
  for (const [i, output] of shards.entries()) {
    shell(filled(processes.shard.command, hole, { ...values, i: i + 1 }), at);
    assert.ok(existsSync(path.join(at, output)), output);
  }
  shell(filled(processes.merge.command, hole, { ...values, shards: shards.join(' ') }), at);
  shell(filled(processes.points.command, hole, { ...values, rows: processes.merge.outputs[0] }), at);
  assert.deepEqual([...processes.merge.outputs, ...processes.points.outputs], RESULTS);
  assert.deepEqual(results(at), folder.whole);
});

test("the commands of Kubernetes' jobs, with the index that each pod has", () => {
  const at = folder.place('jobs'),
    job = (/** @type {string} */ name) => parse(readFileSync(path.join(ROOT, 'deploy/k8s/sweep', name), 'utf8'))[0].spec,
    [sweep, merge] = ['sweep.yaml', 'merge.yaml'].map(job),
    [shard] = sweep.template.spec.containers;
  /** @param {any} container @param {Record<string, string>} env */
  const run = ({ args }, env) => {
    const here = args.map((/** @type {string} */ word) =>
      filled(word, /\$\((\w+)\)/g, env)
        .replace('/experiment/experiment.json', 'lag.json')
        .replace(/^\/rows\//, ''),
    );
    const { status, stderr } = spawnSync(BINARY, here, { cwd: at, encoding: 'utf8', env: { ...process.env, ...env } });
    assert.equal(status, 0, stderr);
  };
  const LAGLAB_SHARDS = shard.env.find((/** @type {any} */ one) => one.name === 'LAGLAB_SHARDS').value;
  for (let i = 0; i < sweep.completions; i++) run(shard, { JOB_COMPLETION_INDEX: String(i), LAGLAB_SHARDS });
  for (const container of [...merge.template.spec.initContainers, ...merge.template.spec.containers]) run(container, {});
  assert.deepEqual(results(at), folder.whole);
});

test('the commands of the documentation for Slurm', () => {
  const at = folder.place('slurm'),
    text = readFileSync(path.join(ROOT, 'docs/experiments.md'), 'utf8'),
    [, first, last, task] = /^sbatch .*--array=(\d+)-(\d+) .*--wrap '(.*)'$/m.exec(text) ?? [],
    merges = [...text.matchAll(/^(laglab merge .*)$/gm)].map(([command]) => command);
  const bin = path.join(at, 'bin');
  mkdirSync(bin);
  symlinkSync(BINARY, path.join(bin, 'laglab'));
  const env = { PATH: `${bin}:${process.env.PATH}` },
    array = { SLURM_ARRAY_TASK_COUNT: String(Number(last) - Number(first) + 1), SLURM_ARRAY_TASK_MIN: first };
  for (let i = Number(first); i <= Number(last); i++) shell(task, at, { ...env, ...array, SLURM_ARRAY_TASK_ID: String(i) });
  assert.equal(merges.length, 2);
  for (const command of merges) shell(command, at, env);
  assert.deepEqual(results(at), folder.whole);
});
