// One laptop that spoils a class: a worker with thirty of each at once, from one address, until it has to stop. It joins in every part,
// keeps the streams of its members open, votes with all tokens, claims seats, reconnects and guesses codes; it knows the code.
import { parentPort, workerData } from 'node:worker_threads';
import { client, openStream, pause } from './client.mjs';

const { url, id, code, address, many } = workerData;
const headers = { 'x-forwarded-for': address },
  c = client(url, 4 * many),
  at = `/api/v1/classes/${id}`,
  LETTERS = '23456789ABCDEFGHJKMNPQRSTUVWXYZ';
/** @type {Record<string, number>} */
const counts = {};
/** @type {{token: string, stream: any}[]} */
const members = [];
let running = true;
parentPort?.once('message', () => {
  running = false;
});

const count = (/** @type {string} */ what, /** @type {number} */ status) => {
  counts[`${what} ${status}`] = (counts[`${what} ${status}`] ?? 0) + 1;
};
const any = (/** @type {any[]} */ list) => list[Math.floor(Math.random() * list.length)];
/** @param {string} what @param {string} method @param {string} path @param {any} [wish] */
async function call(what, method, path, wish = {}) {
  const answer = await c.call(method, path, { headers, ...wish });
  count(what, answer.status);
  return answer;
}
/** @param {string} token */
async function connect(token) {
  const stream = await openStream(url, `classes/${id}`, 'json', { headers });
  stream.say({ auth: token });
  stream.say({ auth: 'b'.repeat(32) });
  stream.say({ auth: token, id: 1 });
  return stream;
}

const deeds = {
  async join() {
    const body = any([{}, {}, { role: 'play' }, { role: 'play', player: 0 }, { role: 'copy' }]);
    const answer = await call('join', 'POST', `/api/v1/classes/${any([id, code])}/members`, { body });
    if (answer.status !== 201) return pause(5);
    const { token } = answer.json;
    members.push({ token, stream: await connect(token) });
    if (members.length > 90) members.shift()?.stream.socket.terminate();
  },
  async vote() {
    const token = any(members)?.token ?? 'b'.repeat(32);
    await call('vote', 'PUT', `${at}/vote`, { key: token, body: { step: 0, choice: 3 } });
  },
  async seat() {
    const token = any(members)?.token;
    if (token) await call('seat', 'PATCH', `${at}/member`, { key: token, body: { role: any(['play', 'watch']) } });
    else await pause(5);
  },
  async reconnect() {
    const member = any(members);
    if (!member) return pause(5);
    member.stream.socket.terminate();
    member.stream = await connect(member.token);
    count('stream', 101);
  },
  async guess() {
    const name = Array.from({ length: 4 }, () => any([...LETTERS])).join('');
    if (name !== code) await call('guess', 'GET', `/api/v1/classes/${name}`);
  },
};

await Promise.all(
  Object.values(deeds).flatMap((deed) =>
    Array.from({ length: many }, async () => {
      while (running) await deed().catch(() => count('failed', 0));
    }),
  ),
);
for (const { stream } of members) stream.socket.terminate();
c.close();
parentPort?.postMessage(counts);
