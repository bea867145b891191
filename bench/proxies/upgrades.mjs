// "8 requests, then an upgrade", again and again: the requests leave a connection to the daemon in the proxy's pool, and the upgrade
// comes on it. Each stream must say hello and deliver frames.
import http from 'node:http';
import { randomBytes } from 'node:crypto';

const REQUESTS = 8;
const FRAMES = 3;
const LIMIT_MS = 60000;

const get = (agent, url) =>
  new Promise((resolve, reject) => {
    http
      .get(url, { agent }, (response) => {
        response.resume();
        response.on('end', () => resolve(response.statusCode));
      })
      .on('error', reject);
  });

/** Messages of a server, which are unmasked; only what this test meets. */
function* messages(state, part) {
  state.bytes = Buffer.concat([state.bytes, part]);
  for (;;) {
    const b = state.bytes;
    if (b.length < 2) return;
    const short = b[1] & 127;
    const head = short === 126 ? 4 : short === 127 ? 10 : 2;
    if (b.length < head) return;
    const size = short === 126 ? b.readUInt16BE(2) : short === 127 ? Number(b.readBigUInt64BE(2)) : short;
    if (b.length < head + size) return;
    yield { opcode: b[0] & 15, payload: b.subarray(head, head + size) };
    state.bytes = b.subarray(head + size);
  }
}

/** A text message of a client, masked with zeros. @param {string} text below 126 bytes */
const masked = (text) => Buffer.concat([Buffer.from([0x81, 0x80 | text.length, 0, 0, 0, 0]), Buffer.from(text)]);
const SUBSCRIBE = masked('{"subscribe":{"session":60,"scene":60}}');

/** Resolves to "ok" or to what went wrong. */
function upgrade(agent, url) {
  return new Promise((resolve) => {
    let hello = false;
    let frames = 0;
    const request = http.get(url, {
      agent,
      headers: {
        Upgrade: 'websocket',
        Connection: 'Upgrade',
        'Sec-WebSocket-Version': '13',
        'Sec-WebSocket-Key': randomBytes(16).toString('base64'),
        'Sec-WebSocket-Protocol': 'laglab.v2.bin',
      },
    });
    const end = (what) => {
      clearTimeout(timer);
      request.destroy();
      resolve(what);
    };
    const timer = setTimeout(() => end(`after ${LIMIT_MS} ms: hello ${hello}, ${frames} frames`), LIMIT_MS);
    request.on('response', (response) => end(`answered ${response.statusCode}`));
    request.on('error', (error) => end(error.message));
    request.on('upgrade', (_, socket, first) => {
      const state = { bytes: Buffer.alloc(0) };
      socket.write(SUBSCRIBE);
      const take = (part) => {
        for (const { opcode, payload } of messages(state, part)) {
          if (opcode === 1 && !hello) hello = JSON.parse(payload.toString('utf8')).type === 'hello';
          else if (opcode === 2 && hello) frames++;
          else if (opcode === 2) end('a frame before the hello');
        }
        if (hello && frames >= FRAMES) {
          socket.destroy();
          end('ok');
        }
      };
      socket.on('data', take);
      socket.on('error', () => {});
      socket.on('close', () => end(`closed: hello ${hello}, ${frames} frames`));
      if (first.length) take(first);
    });
  });
}

/** The daemon's own count of upgrades that came on connections it had kept. */
export async function bridged(url) {
  const text = await (await fetch(new URL('/metrics', url))).text();
  return Number(/^laglab_bridged_total (\d+)/m.exec(text)?.[1] ?? NaN);
}

/** @returns {Promise<{ok: number, failures: Record<string, number>, ms: number[]}>} */
export async function upgradesOnKept(url, session, count, atOnce = 1) {
  const ms = [];
  /** @type {Record<string, number>} */
  const failures = {};
  let started = 0;
  let ok = 0;
  await Promise.all(
    Array.from({ length: atOnce }, async () => {
      while (started < count) {
        started++;
        const agent = new http.Agent({ keepAlive: true, maxSockets: 1 });
        let what;
        const begin = performance.now();
        try {
          for (let i = 0; i < REQUESTS; i++) {
            const status = await get(agent, `${url}/api/v1/sessions/${session.id}`);
            if (status !== 200) throw new Error(`request answered ${status}`);
          }
          what = await upgrade(agent, `${url}/api/v1/sessions/${session.id}/stream`);
        } catch (error) {
          what = error.message;
        }
        agent.destroy();
        ms.push(performance.now() - begin);
        if (what === 'ok') ok++;
        else failures[what] = (failures[what] ?? 0) + 1;
      }
    }),
  );
  return { ok, failures, ms };
}
