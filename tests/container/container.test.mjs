// The image, run by the lines of docs/deploy.md: what it may not do, every format of results from it, its health, its bill of materials,
// and its end. `./dev container-test` builds it, and runs this where podman may work: `docker` of the page is podman here, on a network of
// its own.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { after, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { client, waitFor } from '../lib/client.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const URL_ = 'http://127.0.0.1:8080/';
// What is missing where podman runs in another container: cgroups by systemd, bridges, limits above one's own.
const ENGINE = ['podman', '--cgroup-manager=cgroupfs'],
  HERE = ['--network', 'host', '--ulimit', 'nproc=4096:4096'];

const text = readFileSync(path.join(ROOT, 'docs/deploy.md'), 'utf8'),
  from = text.indexOf('\n## Container\n');
const part = text.slice(from, text.indexOf('\n## ', from + 5));
const lines = [...part.matchAll(/^```console\n([\s\S]*?)^```$/gm)].flatMap(([, block]) =>
  block
    .replace(/\\\n\s*/g, '')
    .trim()
    .split('\n'),
);
const line = (/** @type {RegExp} */ which) => {
  const found = lines.filter((one) => which.test(one));
  assert.equal(found.length, 1, `${which} in docs/deploy.md`);
  return found[0];
};

const podman = (/** @type {string[]} */ ...args) =>
  execFileSync(ENGINE[0], [...ENGINE.slice(1), ...args], { encoding: 'utf8', maxBuffer: 1 << 26 });

/** A line of the page, adapted to podman. */
function documented(/** @type {string} */ command) {
  const [docker, verb, ...rest] = command.split(/\s+/);
  assert.equal(docker, 'docker');
  return podman(verb, ...(verb === 'run' ? HERE : []), ...rest);
}

after(() => {
  spawnSync(ENGINE[0], [...ENGINE.slice(1), 'rm', '-f', 'laglab', 'lab']);
  spawnSync(ENGINE[0], [...ENGINE.slice(1), 'volume', 'rm', '-f', 'laglab']);
});

const ready = () => waitFor(async () => (await fetch(`${URL_}readyz`).catch(() => ({ status: 0 }))).status === 200, 'the daemon', 30000);
const X = '/api/v1/experiments';
let session;

test('it starts as described, without privileges, and can write only its data', async () => {
  documented(line(/^docker run .*--name laglab .*laglab$/));
  await ready();
  const status = podman('exec', 'laglab', 'cat', '/proc/1/status'),
    of = (/** @type {string} */ name) => new RegExp(`^${name}:\\s+(\\S+)`, 'm').exec(status)?.[1];
  assert.deepEqual(
    [of('Uid'), of('Gid'), of('CapEff'), of('CapBnd'), of('NoNewPrivs'), of('Seccomp')],
    ['10001', '10001', '0000000000000000', '0000000000000000', '1', '2'],
  );
  for (const place of ['/x', '/opt/laglab/x', '/etc/x', '/var/x'])
    assert.notEqual(spawnSync(ENGINE[0], [...ENGINE.slice(1), 'exec', 'laglab', 'touch', place]).status, 0, place);
  podman('exec', 'laglab', 'touch', '/data/x');
  const [one] = JSON.parse(podman('inspect', 'laglab'));
  assert.deepEqual(
    [one.HostConfig.Memory, one.HostConfig.PidsLimit, one.HostConfig.NanoCpus, one.HostConfig.ReadonlyRootfs],
    [2 ** 31, 256, 2e9, true],
  );
  const limit = podman(
    'exec',
    'laglab',
    'sh',
    '-c',
    'cat /sys/fs/cgroup/memory/memory.limit_in_bytes /sys/fs/cgroup/memory.max 2>/dev/null || true',
  );
  assert.match(limit, /^2147483648$/m);
});

test('every format of results, report, trace and search is answered from it', async () => {
  const c = client(URL_);
  const order = {
    scenario: 'race',
    set: { duration_s: 0.5 },
    axes: [{ path: 'players.0.lag_ms', values: [0, 100] }],
    repeats: 10,
    metrics: ['players.0.own_lead_m.mean', 'players.0.bandwidth.down_bytes_per_s'],
  };
  const { id } = (await c.call('POST', X, { body: order })).json;
  await waitFor(async () => (await c.get(`${X}/${id}`)).json.state === 'done', 'the experiment', 60000);
  /** @type {Record<string, RegExp>} */
  const begins = { csv: /^run,point,/, ndjson: /^\{"run":0/, json: /^\[/, sqlite: /^SQLite format 3/ };
  for (const [format, begin] of Object.entries(begins)) {
    const answer = await c.get(`${X}/${id}/results?format=${format}`);
    assert.equal(answer.status, 200, `${format}: ${answer.text.slice(0, 300)}`);
    assert.match(answer.text, begin);
    assert.ok(answer.text.length > 1000, format);
  }
  for (const place of [`${X}/${id}/results?points=true&format=csv`, ...['report', 'runs/3/trace'].map((part) => `${X}/${id}/${part}`)])
    assert.equal((await c.get(place)).status, 200, place);
  const advice = await c.call('POST', '/api/v1/advise', { body: { experiment: order, max_error: 10 } });
  assert.equal(advice.status, 202, advice.text);
  session = await c.make({ paused: true });
  await c.control(session, { op: 'seek', time_s: 2 });
  for (const name of ['state', 'metrics', 'trace', 'log']) assert.equal((await c.get(session.links[name])).status, 200, name);
  const stream = await c.stream(session, 'bin');
  await stream.frame();
  await stream.close();
  c.close();
});

test('its health is asked for as the image says', () =>
  assert.equal(spawnSync(ENGINE[0], [...ENGINE.slice(1), 'healthcheck', 'run', 'laglab']).status, 0));

test("its bill of materials has every package of the image, and the page's libraries", () => {
  const bill = JSON.parse(podman('exec', 'laglab', 'cat', '/opt/laglab/sbom.spdx.json'));
  const there = podman('exec', 'laglab', 'dpkg-query', '-W', '-f', '${Package} ${Version}\n').trim().split('\n').sort();
  const purl = (/** @type {any} */ one) => one.externalRefs?.[0].referenceLocator ?? '';
  const debian = bill.packages.filter((/** @type {any} */ one) => purl(one).startsWith('pkg:deb/'));
  assert.deepEqual(debian.map((/** @type {any} */ one) => `${one.name} ${one.versionInfo}`).sort(), there);
  for (const name of ['libmicrohttpd12', 'libwebsockets17', 'libwebsockets-evlib-ev', 'zlib1g', 'libssl3'])
    assert.ok(
      there.some((one) => one.startsWith(`${name} `)),
      name,
    );
  for (const name of ['lean-qr', 'lit-html', 'uplot', '@preact/signals-core'])
    assert.ok(
      bill.packages.some((/** @type {any} */ one) => one.name === name && one.checksums[0].algorithm === 'SHA512'),
      name,
    );
});

test('it ends with 0 when it is stopped, and goes on with its sessions', async () => {
  documented(line(/^docker stop laglab$/));
  const [one] = JSON.parse(podman('inspect', 'laglab'));
  assert.equal(one.State.ExitCode, 0);
  podman('start', 'laglab');
  await ready();
  const c = client(URL_),
    again = await c.get(session.links.self);
  assert.equal(again.status, 200);
  assert.equal(again.json.tick, 120);
  c.close();
  podman('stop', 'laglab');
  podman('rm', 'laglab');
});

test('with options, as shown', async () => {
  const id = documented(line(/^docker run .* serve .*--allow-host/)).trim();
  try {
    await ready();
    const c = client(URL_);
    assert.equal((await c.get('/api/v1/creation', { headers: { host: 'lab.example.org' } })).status, 200);
    assert.equal((await c.get('/api/v1/creation', { headers: { host: 'evil.example' } })).status, 421);
    assert.equal((await c.get(session.links.self)).status, 200, 'the volume is the same');
    c.close();
  } finally {
    podman('rm', '-f', id);
  }
});
