// Shards behind a proxy as deploy/shards configures it, on loopback.
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { startProxy } from '../../bench/proxies/proxies.mjs';
import { startDaemon } from './daemon.mjs';

const DEPLOY = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../deploy/shards');
const read = (/** @type {string} */ name) => readFileSync(path.join(DEPLOY, name), 'utf8');

/** `text` with another part in place of the one that the expression finds; it must be there. */
export function put(/** @type {string} */ text, /** @type {RegExp} */ found, /** @type {string} */ other) {
  if (!found.test(text)) throw new Error(`not in the configuration: ${found}`);
  return text.replace(found, () => other);
}

/** @typedef {[name: string, address: string][]} Servers */

/** deploy/shards/haproxy.cfg for these shards, whose addresses are numbers. @param {string} bind @param {Servers} servers */
export function haproxyConfig(bind, servers) {
  const [any, own] = [([name, at]) => `    server ${name} ${at}\n`, ([name, at]) => `backend ${name}\n    server ${name} ${at}\n`].map(
    (line) => servers.map(line).join(''),
  );
  let text = read('haproxy.cfg');
  text = put(text, /(?:^ +server \w+ laglab\S+\n)+(?=\n)/m, any);
  text = put(text, /(?:^backend \w+\n +server \w+ laglab\S+\n)+$/m, own);
  text = put(text, /^resolvers names\n(?: .*\n)+/m, '');
  text = put(text, /^ +default-server resolvers .*\n/m, '');
  text = put(text, /maxconn 20000/, 'maxconn 4096'); // a process here may have few descriptors
  return put(text, /bind :8080/, `bind ${bind}`);
}

/** deploy/shards/nginx.conf for these shards, in a file that runs by itself. @param {string} listen @param {Servers} servers */
export function nginxConfig(listen, servers) {
  let text = read('nginx.conf');
  text = put(text, /(?:^ +s\d +laglab-s\d;\n)+/m, servers.map(([name]) => `    ${name} laglab-${name};\n`).join(''));
  text = put(text, /(?:^ +server 10\S+;\n){3}/m, servers.map(([, at]) => `    server ${at};\n`).join(''));
  text = put(
    text,
    /(?:^upstream laglab-s\d \{\n.*\n\}\n)+/m,
    servers.map(([name, at]) => `upstream laglab-${name} { server ${at}; }\n`).join(''),
  );
  return standingAlone(put(text, /listen 80;/, `listen ${listen};`));
}

/** A file of nginx's sites, in one that runs by itself. @param {string} site */
export function standingAlone(site) {
  const temporary = ['client_body', 'proxy', 'fastcgi', 'uwsgi', 'scgi'].map((what) => `${what}_temp_path tmp;\n`).join('');
  const user = process.getuid?.() === 0 ? 'user root;\n' : ''; // larger bodies go to files of its folder
  return `${user}worker_processes 1;\npid nginx.pid;\nerror_log stderr warn;\ndaemon off;\nevents { worker_connections 2048; }
http {\naccess_log off;\n${temporary}${site}}\n`;
}

/**
 * Each has a folder of its own. `proxy`: haproxy or nginx. `args`: of every daemon.
 * @param {string[]} names @param {{proxy?: string, args?: string[]}} [wish]
 */
export async function startShards(names, { proxy: kind = 'haproxy', args = [] } = {}) {
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
    const servers = names.map((name) => /** @type {[string, string]} */ ([name, `127.0.0.1:${shards[name].port}`])),
      proxy = await startProxy(kind, 0, (kind === 'nginx' ? nginxConfig : haproxyConfig)('LISTEN', servers));
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
