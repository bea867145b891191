// Ambiguous requests through the proxies of deploy/: proxy and daemon must agree where each request ends. The proxy numbers what it takes
// for a request, and the daemon repeats the number with its answer. What passes between the two is recorded: on each connection the
// numbers of the answers must be those of the requests, in their order. Another one belongs to a request that only one of the two saw.
import { once } from 'node:events';
import net from 'node:net';
import { HANG_MS, raw } from './client.mjs';
import { random } from './draws.mjs';
import { publicProxy, plain } from './public.mjs';
import { put } from './shards.mjs';

/** @type {Record<string, (text: string) => string>} */
const numbered = {
  haproxy: (text) =>
    put(text, /^ +default_backend laglab$/m, '    http-request set-header X-Request-Id %[uuid()]\n    default_backend laglab'),
  nginx: (text) =>
    put(text, /^ +proxy_set_header Host/m, '        proxy_set_header X-Request-Id $request_id;\n        proxy_set_header Host'),
};

const LAST = 'GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n';
const OTHERS = 3,
  AT_ONCE = 10,
  PATIENCE_MS = 700; // the proxies wait for the rest of a request for longer

/** Status and number of each answer, and whether it is the last. @param {string} text */
const answersOf = (text) =>
  [...text.matchAll(/HTTP\/1\.[01] (\d{3})[^\r\n]*\r\n((?:[^\r\n]+\r\n)*)\r\n/g)]
    .map(([, status, head]) => ({
      status: Number(status),
      id: /^x-request-id: (\S+)/im.exec(head)?.[1],
      last: /^connection: close\r$/im.test(head),
    }))
    .filter(({ status }) => status !== 100);

/** Between a proxy and the daemon: passes bytes on, and keeps them. @param {number} port of the daemon */
async function recorder(port) {
  const connections = /** @type {{asked: string, answered: string}[]} */ ([]);
  const server = net.createServer((proxy) => {
    const daemon = net.connect(port, '127.0.0.1'),
      kept = { asked: '', answered: '' };
    connections.push(kept);
    proxy.on('data', (part) => {
      kept.asked += part.toString('latin1');
    });
    daemon.on('data', (part) => {
      kept.answered += part.toString('latin1');
    });
    for (const [from, to] of [
      [proxy, daemon],
      [daemon, proxy],
    ]) {
      from.pipe(to);
      from.on('error', () => to.destroy());
    }
  });
  await once(server.listen(0, '127.0.0.1'), 'listening');
  return {
    port: /** @type {net.AddressInfo} */ (server.address()).port,
    connections,
    stop: () => new Promise((resolve) => server.close(resolve)),
  };
}

/**
 * What the two ends of a connection saw differently; undefined: nothing. A request whose head the daemon refuses gets an answer without its
 * number, which must be the last: what follows `Connection: close` is no answer to any request.
 * libmicrohttpd sends some of these heads twice.
 * @param {{asked: string, answered: string}} connection
 */
export function disagreement({ asked, answered }) {
  const ids = [...asked.matchAll(/^x-request-id: (\S+)\r$/gim)].map(([, id]) => id),
    answers = answersOf(answered);
  const last = answers.findIndex((one) => one.last) + 1,
    counted = last > 0 ? answers.slice(0, last) : answers;
  const at = counted.findIndex(({ status, id, last }, i) => (id ? id !== ids[i] : status < 400 || !last || i >= ids.length));
  if (at < 0) return undefined;
  return `answer ${at} is ${counted[at].status} of ${counted[at].id}, request ${at} is ${ids[at]}: ${asked.slice(-400)}`;
}

/** @typedef {[name: string, bytes: string]} Request */

/** Requests of the table with a few bytes put in, taken out or doubled.
 * @param {Request[]} table @param {number} seed @param {number} count */
export function damaged(table, seed, count) {
  const next = random(seed),
    below = (/** @type {number} */ n) => Math.floor(next() * n),
    small = table.filter(([, bytes]) => bytes.length < 2000),
    bits = [
      '\r',
      '\n',
      '\r\n',
      '\0',
      ' ',
      '\t',
      '\v',
      '0',
      '1',
      ',',
      ':',
      ';',
      'chunked',
      'Content-Length: 3\r\n',
      'Transfer-Encoding: chunked\r\n',
      '\r\n\r\n',
    ];
  return Array.from({ length: count }, (_, i) => {
    const [name, whole] = small[below(small.length)];
    let bytes = whole;
    for (let n = 1 + below(3); n > 0; n--) {
      const at = below(bytes.length),
        how = below(3),
        length = 1 + below(4);
      bytes =
        bytes.slice(0, at) +
        (how === 0 ? bits[below(bits.length)] : how === 1 ? bytes.slice(at, at + length).repeat(2) : '') +
        bytes.slice(at + length * Number(how > 0));
    }
    return /** @type {Request} */ ([`${name}, damaged (${seed}, ${i})`, bytes]);
  });
}

/**
 * Sends each, in one piece and in two, between those of others; what does not agree.
 * @param {string} kind haproxy or nginx @param {{port: number}} daemon which must trust 127.0.0.1 @param {Request[]} requests
 */
export async function smuggle(kind, daemon, requests) {
  const between = await recorder(daemon.port),
    proxy = await publicProxy(kind, between.port, (text) => plain(numbered[kind](text)));
  const found = { sent: 0, passed: 0, wrong: /** @type {string[]} */ ([]) };
  const send = async (/** @type {string} */ bytes, split = 0, patience_ms = PATIENCE_MS) => {
    const socket = net.connect(proxy.port, '127.0.0.1');
    if (split > 0) setTimeout(() => socket.write(bytes.slice(split), 'latin1'), 30);
    found.sent++;
    return answersOf((await raw(socket, Buffer.from(split > 0 ? bytes.slice(0, split) : bytes, 'latin1'), patience_ms)).text);
  };
  try {
    for (let i = 0; i < requests.length; i += AT_ONCE) {
      const some = requests.slice(i, i + AT_ONCE);
      await Promise.all(some.flatMap(([, bytes]) => [send(bytes + LAST), send(bytes + LAST, Math.ceil(bytes.length / 2))]));
      const others = await Promise.all(
        Array.from({ length: OTHERS }, () => send(LAST.replace('Connection: close\r\n', '') + LAST, 0, HANG_MS)),
      );
      if (!others.every((answers) => answers.length === 2 && answers.every(({ status }) => status === 200)))
        found.wrong.push(`others got ${JSON.stringify(others)} after ${some.map(([name]) => name).join('; ')}`);
    }
  } finally {
    await proxy.stop();
    await between.stop();
  }
  found.passed = between.connections.reduce((sum, { answered }) => sum + answersOf(answered).length, 0);
  found.wrong.push(...between.connections.map(disagreement).filter((one) => one !== undefined));
  return found;
}
