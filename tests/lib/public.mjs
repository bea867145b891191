// A daemon behind a proxy with TLS as deploy/ configures it, on loopback.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import tls from 'node:tls';
import { startProxy } from '../../bench/proxies/proxies.mjs';
import { startDaemon } from './daemon.mjs';
import { put, standingAlone } from './shards.mjs';

const DEPLOY = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../deploy');
export const NAME = 'lab.example.org';

/** @param {string} folder @returns {[certificate: string, key: string]} */
function certificate(folder) {
  const [pem, key] = ['lab.pem', 'lab.key'].map((name) => path.join(folder, name));
  const names = ['-subj', `/CN=${NAME}`, '-addext', `subjectAltName=DNS:${NAME}`];
  execFileSync('openssl', ['req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-days', '2', ...names, '-keyout', key, '-out', pem], {
    stdio: 'ignore',
  });
  return [pem, key];
}

/** The file of deploy/ with ports and certificate of its own; port 80 is a socket of the folder. */
const configurations = {
  haproxy(/** @type {string} */ folder) {
    const [pem, key] = certificate(folder),
      both = path.join(folder, 'both.pem');
    execFileSync('sh', ['-c', 'cat "$0" "$1" > "$2"', pem, key, both]);
    let text = readFileSync(path.join(DEPLOY, 'haproxy-tls.cfg'), 'utf8');
    text = put(text, /^ +user haproxy\n +group haproxy\n/m, '');
    text = put(text, /bind :80\n/, `bind "${folder}/plain"\n`);
    text = put(text, /bind :443 ssl crt \S+/, `bind LISTEN ssl crt "${both}"`);
    return put(text, /127\.0\.0\.1:8080/, 'UPSTREAM');
  },
  nginx(/** @type {string} */ folder) {
    const [pem, key] = certificate(folder);
    let text = readFileSync(path.join(DEPLOY, 'nginx.conf'), 'utf8');
    text = put(text, /listen 80;/, `listen "unix:${folder}/plain";`);
    text = put(text, /listen 443 ssl;/, 'listen LISTEN ssl;');
    text = put(text, /(ssl_certificate +)\S+;/, `ssl_certificate "${pem}";`);
    text = put(text, /(ssl_certificate_key +)\S+;/, `ssl_certificate_key "${key}";`);
    return standingAlone(put(text, /127\.0\.0\.1:8080/, 'UPSTREAM'));
  },
};

/**
 * Without TLS, so that requests can be read and any client will do. HAProxy sends every request on a connection that it has kept, as nginx
 * does, which is the strictest for the daemon.
 * @param {string} text
 */
export const plain = (text) =>
  text
    .replace(/ ssl crt "[^"]*"/, '')
    .replace('LISTEN ssl;', 'LISTEN;')
    .replace(/^backend laglab$/m, 'backend laglab\n    http-reuse always');

/**
 * The proxy alone, before the daemon of this port. `change`: of its configuration.
 * @param {string} kind haproxy or nginx @param {number} port @param {(text: string) => string} [change]
 */
export async function publicProxy(kind, port, change = (text) => text) {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-public-'));
  try {
    const proxy = await startProxy(kind, port, change(configurations[kind](folder)));
    return {
      port: proxy.port,
      url: proxy.url,
      stop: async () => {
        await proxy.stop();
        rmSync(folder, { recursive: true, force: true });
      },
    };
  } catch (error) {
    rmSync(folder, { recursive: true, force: true });
    throw error;
  }
}

/** @param {string} kind haproxy or nginx @param {{args?: string[], change?: (text: string) => string}} [wish] */
export async function startPublic(kind, { args = [], change } = {}) {
  const daemon = await startDaemon({ args: ['--trusted-proxy', '127.0.0.1', '--allow-host', NAME, ...args] });
  try {
    const proxy = await publicProxy(kind, daemon.port, change);
    return {
      daemon,
      connect: () => tls.connect({ port: proxy.port, host: '127.0.0.1', rejectUnauthorized: false }),
      close: async () => {
        await proxy.stop();
        await daemon.stop();
      },
    };
  } catch (error) {
    await daemon.stop();
    throw error;
  }
}
