// A visitor of a public server, without a key: node visitor.mjs URL SESSION.json. Prints, as JSON, what each request was answered.
// SESSION.json is the answer to a client with the class key.
import { readFileSync } from 'node:fs';
import WebSocket from 'ws';

const [url, file] = process.argv.slice(2);
const session = JSON.parse(readFileSync(file, 'utf8')),
  S = `/api/v1/sessions/${session.id}`;
/** @type {Record<string, number | string>} */
const told = {};

async function ask(name, method, path, wish = {}) {
  const answer = await fetch(new URL(path, url), {
    method,
    redirect: 'manual',
    headers: { ...(wish.body === undefined ? {} : { 'content-type': 'application/json' }), ...wish.headers },
    body: wish.body === undefined ? undefined : JSON.stringify(wish.body),
  });
  told[name] = answer.status;
  return { headers: answer.headers, text: await answer.text() };
}

/** Frames of a stream; whether a command on it is refused. */
function watch(format) {
  return new Promise((resolve, reject) => {
    const protocols = [`laglab.v2.${format}`];
    const socket = new WebSocket(`${url.replace(/^http/, 'ws')}${S}/stream`, protocols);
    const timer = setTimeout(() => reject(new Error('no frames')), 10000);
    let frames = 0,
      refused = '';
    socket.on('error', reject);
    socket.on('open', () => socket.send(JSON.stringify({ input: { player: 0, axes: [1, 0] }, id: 7 })));
    socket.on('message', (data, binary) => {
      const message = binary ? { type: 'frame' } : JSON.parse(data.toString());
      if (message.type === 'frame') frames++;
      if (message.id === 7) refused = String(message.problem?.status ?? 'done');
      if (frames < 5 || !refused) return;
      clearTimeout(timer);
      socket.terminate();
      resolve(refused);
    });
  });
}

const page = await ask('page', 'GET', '/');
told.title = /<title>([^<]*)/.exec(page.text)?.[1] ?? '';
told.hsts = page.headers.get('strict-transport-security') ?? '';
for (const part of ['', '/state', '/metrics', '/trace', '/log']) await ask(`session${part}`, 'GET', `${S}${part}`);
const by_code = await ask('code', 'GET', `/api/v1/codes/${session.code}`);
told.by_code = JSON.parse(by_code.text).id === session.id ? 'the session' : by_code.text;
for (const format of ['bin', 'json']) told[`stream ${format}: command`] = await watch(format);

const small = { scenario: 'race', metrics: ['players.0.own_lead_m.mean'] };
await ask('create', 'POST', '/api/v1/sessions', { body: { scenario: 'race' } });
await ask('fork', 'POST', `${S}/fork`, { body: {} });
await ask('experiment', 'POST', '/api/v1/experiments', { body: small });
await ask('dry run', 'POST', '/api/v1/experiments?dry_run=true', { body: small });
await ask('advise', 'POST', '/api/v1/advise', { body: { experiment: small, max_error: 1 } });
await ask('control', 'POST', `${S}/control`, { body: { op: 'pause' } });
await ask('change', 'PATCH', `${S}/params`, {
  body: { 'players.0.lag_ms': 1 },
  headers: { 'content-type': 'application/merge-patch+json' },
});
await ask('input', 'POST', `${S}/input`, { body: { player: 0, axes: [1, 0], buttons: 0 } });
await ask('delete', 'DELETE', S);
await ask('list', 'GET', '/api/v1/sessions');
await ask('list of experiments', 'GET', '/api/v1/experiments');
await ask('close creation', 'PUT', '/api/v1/creation', { body: { creation: 'operator' } });
await ask('figures', 'GET', '/metrics');
await ask('guessed id', 'GET', '/api/v1/sessions/AAAAAAAAAAAAAAAAAAAAAA');
const plain = await ask('without TLS', 'GET', `${url.replace(/^https/, 'http')}/some?thing=1`);
told.redirected = plain.headers.get('location') ?? '';
console.log(JSON.stringify(told));
