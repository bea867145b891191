// Shards behind HAProxy as deploy/haproxy.cfg has it, on loopback.
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { startProxy } from '../../bench/proxies/proxies.mjs';
import { startDaemon } from './daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');

/**
 * deploy/haproxy.cfg with these servers, each by its name and address, and `more` lines in each backend.
 * @param {string} bind @param {Record<string, string>} servers @param {string} [more]
 */
export function haproxyConfig(bind, servers, more = '') {
  const lines = Object.entries(servers).map(([name, address]) => `    server ${name} ${address}\n`);
  return readFileSync(path.join(ROOT, 'deploy/haproxy.cfg'), 'utf8')
    .replace('bind :8080', `bind ${bind}`)
    .replace('maxconn 20000', 'maxconn 4096') // a process here may have few descriptors
    .replaceAll(/(?:^ +server \w+ \S+\n)+/gm, more + lines.join(''));
}

/** Each has a folder of its own. `wish.args`: of every daemon. @param {string[]} names @param {{args?: string[]}} [wish] */
export async function startShards(names, { args = [] } = {}) {
  const shards = /** @type {Record<string, Awaited<ReturnType<typeof startDaemon>>>} */ ({}),
    folders = /** @type {Record<string, string>} */ ({});
  const start = async (/** @type {string} */ name, listen = '127.0.0.1:0') => {
    folders[name] ??= mkdtempSync(path.join(tmpdir(), 'laglab-test-'));
    shards[name] = await startDaemon({
      data: folders[name],
      listen,
      args: ['--shard', name, '--trusted-proxy', '127.0.0.1', ...args],
    });
  };
  const close = async () => {
    await Promise.all(Object.values(shards).map((shard) => shard.kill()));
    for (const folder of Object.values(folders)) rmSync(folder, { recursive: true, force: true });
  };
  try {
    await Promise.all(names.map((name) => start(name)));
    const servers = Object.fromEntries(names.map((name) => [name, `127.0.0.1:${shards[name].port}`])),
      proxy = await startProxy('haproxy', 0, haproxyConfig('LISTEN', servers));
    return {
      shards,
      url: proxy.url,
      /** On its folder, at its address. @param {string} name */
      again: (name) => start(name, `127.0.0.1:${shards[name].port}`),
      close: async () => {
        await proxy.stop();
        await close();
      },
    };
  } catch (error) {
    await close();
    throw error;
  }
}

/** The name of the shard that an id or a code begins with. @param {string} name */
export const shardOf = (name) => name.slice(0, name.indexOf('-')).toLowerCase();
