// nginx and HAProxy in front of a daemon, without root. tests/lib has the configurations, which are those of deploy/.
import { spawn } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { connect, createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const environment = { ...process.env, PATH: `${process.env.PATH}:/usr/sbin:/sbin` }; // where Debian keeps both

const kinds = {
  nginx: { file: 'nginx.conf', command: (folder, file) => ['nginx', '-p', folder, '-e', 'stderr', '-c', file] },
  haproxy: { file: 'haproxy.cfg', command: (_, file) => ['haproxy', '-db', '-f', file] },
};
export const names = Object.keys(kinds);

export async function freePort() {
  const server = createServer().listen(0, '127.0.0.1');
  await new Promise((resolve) => server.once('listening', resolve));
  const { port } = /** @type {import("node:net").AddressInfo} */ (server.address());
  await new Promise((resolve) => server.close(resolve));
  return port;
}

export async function answers(port, within_s = 5) {
  for (let i = 0; i < 40 * within_s; i++) {
    const open = await new Promise((resolve) => {
      const socket = connect(port, '127.0.0.1', () => {
        socket.destroy();
        resolve(true);
      });
      socket.on('error', () => resolve(false));
    });
    if (open) return true;
    await pause(25);
  }
  return false;
}

/**
 * LISTEN and UPSTREAM of the configuration become addresses.
 * @param {string} name @param {number} upstream port of the daemon @param {string} configuration
 */
export async function startProxy(name, upstream, configuration) {
  const folder = mkdtempSync(join(tmpdir(), `laglab-${name}-`));
  const port = await freePort();
  const text = configuration.replaceAll('LISTEN', `127.0.0.1:${port}`).replaceAll('UPSTREAM', `127.0.0.1:${upstream}`);
  const file = join(folder, kinds[name].file);
  mkdirSync(join(folder, 'tmp'));
  writeFileSync(file, text);
  const prefix = (process.env.BENCH_PREFIX ?? '').split(' ').filter(Boolean); // as bench/lib.mjs does for other servers
  const [command, ...args] = [...prefix, ...kinds[name].command(folder, file)];
  let errors = '';
  const child = spawn(command, args, { stdio: ['ignore', 'ignore', 'pipe'], env: environment });
  child.stderr.on('data', (part) => {
    errors = (errors + part).slice(-4000);
  });
  const ended = new Promise((resolve) => {
    child.once('exit', resolve);
    child.once('error', resolve);
  });
  const kill = () => child.kill('SIGKILL');
  process.once('exit', kill);
  const stop = async () => {
    child.kill('SIGTERM');
    if ((await Promise.race([ended, pause(3000).then(() => 'late')])) === 'late') kill();
    await ended;
    process.off('exit', kill);
    rmSync(folder, { recursive: true, force: true });
  };
  if (!(await Promise.race([answers(port), ended.then(() => false)]))) {
    await stop();
    throw new Error(`${name} did not start: ${errors}`);
  }
  return { port, url: `http://127.0.0.1:${port}`, pid: child.pid, errors: () => errors, stop };
}
