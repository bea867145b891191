// A Slurm of one's own on this machine: munged, slurmctld and slurmd with a private key, private ports and one folder for all files.
import { execFile, spawn, spawnSync } from 'node:child_process';
import { randomBytes } from 'node:crypto';
import { mkdirSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { hostname } from 'node:os';
import path from 'node:path';
import { promisify } from 'node:util';

const run = promisify(execFile),
  START_MS = 15000;
const PROGRAMS = ['sbatch', 'slurmctld', 'slurmd', 'munged'];

/** Why there can be no Slurm here; empty: there can. */
export function noSlurm() {
  const missing = PROGRAMS.filter((name) => spawnSync('sh', ['-c', `command -v ${name}`]).status !== 0);
  if (missing.length > 0) return `${missing.join(', ')} not installed (packages slurm-wlm and munge)`;
  return process.getuid?.() === 0 ? '' : 'slurmd runs jobs as their owner, which takes root';
}

async function freePorts(/** @type {number} */ count) {
  const servers = await Promise.all(
    Array.from(
      { length: count },
      () =>
        new Promise((resolve) => {
          const server = createServer().listen(0, '127.0.0.1', () => resolve(server));
        }),
    ),
  );
  const ports = servers.map((server) => server.address().port);
  await Promise.all(servers.map((server) => new Promise((resolve) => server.close(resolve))));
  return ports;
}

/** Nodes are this machine under several names; jobs are not confined, and nothing is accounted. What is requeued waits until its credential
 * has expired. */
function configuration(/** @type {string} */ folder, /** @type {string[]} */ nodes, /** @type {number[]} */ ports) {
  const host = hostname();
  return [
    'ClusterName=laglab',
    `SlurmctldHost=${host}(127.0.0.1)`,
    'SlurmUser=root',
    'SlurmdUser=root',
    'AuthType=auth/munge',
    `AuthInfo=socket=${folder}/munge.sock,cred_expire=5`,
    'CredType=cred/munge',
    'ProctrackType=proctrack/linuxproc',
    'TaskPlugin=task/none',
    'JobAcctGatherType=jobacct_gather/none',
    'AccountingStorageType=accounting_storage/none',
    'MpiDefault=none',
    'SelectType=select/cons_tres',
    'SelectTypeParameters=CR_Core',
    'SlurmdParameters=config_overrides',
    'ReturnToService=2',
    'KillWait=5',
    'SchedulerParameters=sched_min_interval=0,batch_sched_delay=0',
    'MailProg=/bin/true',
    `StateSaveLocation=${folder}/state`,
    `SlurmdSpoolDir=${folder}/spool-%n`,
    `SlurmctldPidFile=${folder}/slurmctld.pid`,
    `SlurmdPidFile=${folder}/slurmd-%n.pid`,
    `SlurmctldLogFile=${folder}/slurmctld.log`,
    `SlurmdLogFile=${folder}/slurmd-%n.log`,
    `SlurmctldPort=${ports[0]}`,
    ...nodes.map((name, i) => `NodeName=${name} NodeHostname=${host} NodeAddr=127.0.0.1 Port=${ports[i + 1]} CPUs=1 State=UNKNOWN`),
    `PartitionName=all Nodes=${nodes.join(',')} Default=YES MaxTime=INFINITE State=UP`,
    '',
  ].join('\n');
}

/**
 * `folder` must be there and be empty; it is for the caller to remove. Commands of Slurm find it by `env`.
 * @param {string} folder
 * @param {number} count of nodes
 */
export async function startSlurm(folder, count) {
  const nodes = Array.from({ length: count }, (_, i) => `n${i + 1}`),
    conf = path.join(folder, 'slurm.conf');
  const env = { ...process.env, SLURM_CONF: conf };
  writeFileSync(conf, configuration(folder, nodes, await freePorts(count + 1)));
  writeFileSync(path.join(folder, 'munge.key'), randomBytes(1024), { mode: 0o400 });
  for (const name of ['state', ...nodes.map((node) => `spool-${node}`)]) mkdirSync(path.join(folder, name));
  /** @type {import('node:child_process').ChildProcess[]} */
  const servers = [];
  const start = (/** @type {string} */ program, /** @type {string[]} */ args) => {
    servers.push(spawn(program, args, { env, cwd: folder, stdio: 'ignore' }));
  };
  /** What a command of Slurm prints. */
  const ask = async (/** @type {string} */ program, /** @type {string[]} */ ...args) => (await run(program, args, { env })).stdout.trim();
  const until = async (/** @type {string} */ what, /** @type {() => Promise<boolean>} */ holds) => {
    const end = Date.now() + START_MS;
    while (!(await holds().catch(() => false))) {
      if (Date.now() > end) throw new Error(`Slurm: no ${what} within ${START_MS} ms; its logs are in ${folder}`);
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
  };
  const stop = async () => {
    for (const server of servers.reverse()) {
      if (server.exitCode !== null || server.signalCode !== null) continue;
      const ended = new Promise((resolve) => server.once('exit', resolve));
      server.kill('SIGTERM');
      const timer = setTimeout(() => server.kill('SIGKILL'), 5000);
      await ended;
      clearTimeout(timer);
    }
    rmSync(path.join(folder, 'munge.sock'), { force: true });
  };
  try {
    start('munged', [
      '--foreground',
      '--force',
      `--key-file=${folder}/munge.key`,
      `--socket=${folder}/munge.sock`,
      `--pid-file=${folder}/munged.pid`,
      `--log-file=${folder}/munged.log`,
      `--seed-file=${folder}/munged.seed`,
    ]);
    await until('munged', async () => {
      await run('munge', ['-n', `--socket=${folder}/munge.sock`]);
      return true;
    });
    start('slurmctld', ['-D', '-c', '-f', conf]);
    for (const node of nodes) start('slurmd', ['-D', '-N', node, '-f', conf]);
    await until('idle nodes', async () => (await ask('sinfo', '-h', '-N', '-t', 'idle', '-o', '%N')).split('\n').length === count);
  } catch (error) {
    await stop();
    throw error;
  }
  return { env, ask, until, stop };
}
