// Clients that send requests without a pause, as a process of its own: the next one of each client when its last is answered. What they
// make is deleted again. The message `end` is answered with how many answers of which status there were.
//
// node storm.mjs URL CLIENTS SEED, and the requests (heavy.mjs) as the first message. With a seed each client takes them in an order of
// its own and damages every other body; without one (0) in their order.
import { setPriority } from 'node:os';
import { client } from './client.mjs';

setPriority(10); // clients are other machines: they must not take the processor from the daemon and from who measures it
const [url, clients, seed] = [process.argv[2], Number(process.argv[3]), Number(process.argv[4])];
const statuses = /** @type {Record<string, number>} */ ({});
let over = false;

function draws(/** @type {number} */ state) {
  return (/** @type {number} */ below) => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return Math.floor((state / 2 ** 32) * below);
  };
}

/** A part missing, twice, or one byte of another value. */
function damaged(/** @type {string} */ body, /** @type {(below: number) => number} */ draw) {
  const from = draw(body.length),
    to = from + draw(40);
  return [
    body.slice(0, from) + body.slice(to),
    body.slice(0, to) + body.slice(from),
    body.slice(0, from) + '"{[]},:e0'[draw(9)] + body.slice(from + 1),
  ][draw(3)];
}

/** @param {any[]} requests @param {number} number */
async function run(requests, number) {
  const c = client(url, 1),
    draw = draws(seed + 7919 * number);
  for (let i = number; !over; i++) {
    const { method, path, body, ...wish } = requests[seed ? draw(requests.length) : i % requests.length];
    const text = body === undefined || typeof body === 'string' ? body : JSON.stringify(body);
    const wanted = { ...wish, body: text && seed && draw(2) ? damaged(text, draw) : text, timeout: 600000 };
    try {
      const answer = await c.call(method, path, wanted);
      statuses[answer.status] = (statuses[answer.status] ?? 0) + 1;
      const made = answer.json?.owner_key ?? answer.json?.teacher_key ?? answer.json?.token;
      if (made && (answer.headers.location || answer.json.token))
        await c.call('DELETE', answer.headers.location ?? path.replace('/members', '/member'), { key: made, timeout: 600000 });
    } catch {
      statuses.none = (statuses.none ?? 0) + 1;
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
  }
}

process.on('message', (/** @type {any} */ message) => {
  if (message !== 'end') {
    for (let i = 0; i < clients; i++) run(message, i);
    process.send?.('begun');
    return;
  }
  over = true;
  process.send?.(statuses, () => process.exit(0));
});
process.on('disconnect', () => process.exit(1));
