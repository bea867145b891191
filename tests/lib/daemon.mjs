// Starts the daemon under test on a free port, waits for its line, and stops it by its process id.
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
export const BINARY = path.resolve(process.env.LAGLAB_BIN ?? path.join(ROOT, 'build/laglab'));
const START_MS = 60000,
  STOP_MS = 60000; // these only end a hang

/**
 * `listen` defaults to a free port of 127.0.0.1, `data` to a folder of the daemon's own that goes with it; `before` is put in front of the
 * command (`ip netns exec NAME`).
 * @param {{listen?: string, data?: string, args?: string[], before?: string[]}} [wish]
 */
export async function startDaemon(wish = {}) {
  const own = wish.data === undefined;
  const data = wish.data ?? mkdtempSync(path.join(tmpdir(), 'laglab-test-'));
  const command = [...(wish.before ?? []), BINARY, 'serve', '--data', data, '--listen', wish.listen ?? '127.0.0.1:0', ...(wish.args ?? [])];
  const child = spawn(command[0], command.slice(1), { cwd: ROOT, stdio: ['ignore', 'pipe', 'pipe'] });
  const die = () => child.kill('SIGKILL'); // with who started it, also where that failed
  process.once('exit', die);
  child.once('close', () => process.off('exit', die));
  let errors = '';
  child.stderr.setEncoding('utf8').on('data', (text) => {
    errors = (errors + text).slice(-4000);
  });
  let asked = false;
  const ended = new Promise((resolve) =>
    child.on('close', (code, signal) => {
      if (!asked && signal !== null) process.stderr.write(`the daemon ended by itself, with ${signal}: ${errors}\n`);
      resolve({ code, signal });
    }),
  );
  const line = new Promise((resolve, reject) => {
    let text = '';
    const timer = setTimeout(() => reject(new Error(`the daemon did not print its address: ${text}${errors}`)), START_MS);
    child.on('error', reject);
    child.stdout.setEncoding('utf8').on('data', (more) => {
      text += more;
      const found = /laglab listening on (http:\/\/(\S+):(\d+)\/)/.exec(text);
      if (found) {
        clearTimeout(timer);
        resolve({ url: found[1], host: found[2], port: Number(found[3]) });
      }
    });
    ended.then(({ code, signal }) => {
      clearTimeout(timer);
      reject(new Error(`the daemon ended with ${code ?? signal}: ${errors}`));
    });
  });
  /** @param {NodeJS.Signals} signal */
  const end = async (signal) => {
    asked = true;
    if (child.exitCode === null && child.signalCode === null) child.kill(signal);
    const timer = setTimeout(() => child.kill('SIGKILL'), STOP_MS);
    const how = await ended;
    clearTimeout(timer);
    return how;
  };
  let place;
  try {
    place = await line;
  } catch (error) {
    await end('SIGKILL');
    if (own) rmSync(data, { recursive: true, force: true });
    throw error;
  }
  return {
    ...place,
    data,
    pid: child.pid,
    errors: () => errors,
    kill: () => end('SIGKILL') /* as a crash: the data stay */,
    stop: async () => {
      const how = await end('SIGTERM');
      if (own) rmSync(data, { recursive: true, force: true });
      return how;
    },
  };
}
