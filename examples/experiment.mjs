// An experiment with Node 18 or newer: node examples/experiment.mjs [URL]
import { readFileSync } from 'node:fs';

const url = (process.argv[2] ?? 'http://127.0.0.1:8080').replace(/\/$/, '');

/** @param {string} method @param {string} path @param {{body?: string, headers?: Record<string, string>}} [wish] */
async function call(method, path, wish = {}) {
  const answer = await fetch(url + path, { method, ...wish });
  const text = await answer.text();
  if (!answer.ok) throw new Error(`${method} ${path}: ${answer.status} ${text}`);
  return text;
}

const body = readFileSync(new URL('experiment.json', import.meta.url), 'utf8');
const made = JSON.parse(await call('POST', '/api/v1/experiments', { body, headers: { 'Content-Type': 'application/json' } }));
const path = made.links.self;
while (JSON.parse(await call('GET', path)).state !== 'done') await new Promise((resolve) => setTimeout(resolve, 200));
process.stdout.write(await call('GET', `${path}/results?points=true`, { headers: { Accept: 'text/csv' } }));
await call('DELETE', path, { headers: { Authorization: `Bearer ${made.owner_key}` } });
