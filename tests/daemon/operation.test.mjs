// The files of deploy/cluster and the instructions of docs/scale.md: proxy, compose file, Kubernetes objects, alerts, dashboard, and a
// backup that is restored.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { chmodSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { haproxyConfig } from '../cluster/rig.mjs';
import { ownPostgres } from '../lib/chaos.mjs';
import { client } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';
import { parse, problems, typeErrors } from '../lib/objects.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..'),
  CLUSTER = path.join(ROOT, 'deploy/cluster');
const read = (/** @type {string} */ name) => readFileSync(path.join(CLUSTER, name), 'utf8');
const env = { ...process.env, PATH: `${process.env.PATH}:/usr/sbin:/sbin:${path.dirname(BINARY)}` };
const run = (/** @type {string} */ command, /** @type {string[]} */ ...args) =>
  spawnSync(command, args, { encoding: 'utf8', env, cwd: CLUSTER, timeout: 60000 });
const absent = (/** @type {string} */ command) => (run(command, '--version').error ? `${command} is not installed` : false);
const HELP = spawnSync(BINARY, ['serve', '--help'], { encoding: 'utf8' }).stdout;
const SHARED = /^ {2}--lease-s /m.test(HELP) ? false : 'this laglab keeps sessions in one daemon: serve has no --lease-s';

let folder;
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-operation-'));
});
after(() => rmSync(folder, { recursive: true, force: true }));

// ---- the proxy ----

test('HAProxy takes its configuration, as it is and as the tests change it', { skip: absent('haproxy') }, () => {
  const changed = path.join(folder, 'haproxy.cfg');
  writeFileSync(changed, haproxyConfig('127.0.0.1', [['d0', '127.0.0.2']]));
  for (const file of ['haproxy.cfg', changed]) {
    const { status, stdout, stderr } = run('haproxy', '-c', '-f', file);
    assert.equal(status, 0, `${file}: ${stderr}`);
    assert.match(stdout, /^Configuration file is valid$/m);
    /* The names are those of a cluster. */
    const other = stderr
      .split('\n')
      .filter((line) => /\[(WARNING|ALERT)\]/.test(line) && !/could not resolve address 'laglab-\d\.laglab', disabling server/.test(line));
    assert.deepEqual(other, [], file);
  }
  writeFileSync(changed, read('haproxy.cfg').replace('balance hash path', 'balance hash pth'));
  assert.notEqual(run('haproxy', '-c', '-f', changed).status, 0, 'a mistake is found');
});

// ---- Kubernetes ----

const kustomization = () => parse(read('kustomization.yaml'))[0];
const objects = () => kustomization().resources.flatMap((/** @type {string} */ name) => parse(read(name)));
const servers = () => [...read('haproxy.cfg').matchAll(/^ +server (\S+) (\S+)$/gm)].map(([, name, address]) => ({ name, address }));

/** What only these objects have to match. @param {any[]} all */
function mismatches(all) {
  const of = (/** @type {string} */ kind, name = 'laglab') => all.find((one) => one.kind === kind && one.metadata.name === name);
  const daemons = of('StatefulSet'),
    scaler = of('HorizontalPodAutoscaler'),
    file = of('Deployment', 'laglab-proxy').spec.template.spec.volumes[0].configMap.name;
  const wrong = [];
  const say = (/** @type {boolean} */ right, /** @type {string} */ what) => right || wrong.push(what);
  say(scaler.spec.maxReplicas === servers().length, 'as many daemons as the proxy has servers');
  servers().forEach(({ name, address }, i) =>
    say(name === `${daemons.metadata.name}-${i}` && address === `${name}.${daemons.spec.serviceName}:8080`, `server ${name} ${address}`),
  );
  say(of('Service').spec.publishNotReadyAddresses === true, 'a daemon that ends keeps its name');
  say(
    kustomization().configMapGenerator.some((/** @type {any} */ one) => file.startsWith(one.name)),
    'the file of the proxy',
  );
  say(
    all
      .filter((one) => one.kind === 'NetworkPolicy')
      .every((policy) => policy.spec.egress.every((/** @type {any} */ rule) => rule.ports?.length > 0)),
    'daemons may reach any port',
  );
  return wrong;
}

test('the objects of a cluster have valid fields and types, and match each other and the proxy', () => {
  const all = objects();
  assert.deepEqual(all.map((/** @type {any} */ one) => `${one.kind} ${one.metadata.name}`).sort(), [
    'Deployment laglab-proxy',
    'HorizontalPodAutoscaler laglab',
    'NetworkPolicy laglab',
    'NetworkPolicy laglab-proxy',
    'PodDisruptionBudget laglab',
    'PodDisruptionBudget laglab-proxy',
    'Service laglab',
    'Service laglab-proxy',
    'StatefulSet laglab',
  ]);
  assert.deepEqual(typeErrors([all]), [[]]);
  const wanted = SHARED
    ? problems(all, read('kustomization.yaml')).filter((one) => !/--url$/.test(one))
    : problems(all, read('kustomization.yaml'));
  assert.deepEqual(wanted, []);
  assert.deepEqual(mismatches(all), []);
  const { version } = JSON.parse(readFileSync(path.join(ROOT, 'package.json'), 'utf8'));
  assert.ok(kustomization().images.some((/** @type {any} */ one) => one.name === 'laglab' && one.newTag === version));
  /** @type {[string, (of: (name: string) => any) => void][]} */
  const mistakes = [
    ['as many daemons', (of) => (of('HorizontalPodAutoscaler laglab').spec.maxReplicas = 9)],
    ['server laglab-0', (of) => (of('StatefulSet laglab').spec.serviceName = 'lab')],
    ['keeps its name', (of) => delete of('Service laglab').spec.publishNotReadyAddresses],
    ['any port', (of) => of('NetworkPolicy laglab').spec.egress.push({})],
  ];
  for (const [said, make] of mistakes) {
    const changed = objects();
    make((name) => changed.find((/** @type {any} */ one) => `${one.kind} ${one.metadata.name}` === name));
    assert.ok(
      mismatches(changed).some((one) => one.includes(said)),
      said,
    );
  }
});

test('Kustomize makes the same objects of them, and the file of the proxy', { skip: absent('kubectl') }, () => {
  const { status, stdout, stderr } = run('kubectl', 'kustomize', '.');
  assert.equal(status, 0, stderr);
  const made = parse(stdout),
    map = made.find((one) => one.kind === 'ConfigMap');
  assert.equal(map?.data['haproxy.cfg'], read('haproxy.cfg'));
  const rest = made.filter((one) => one !== map);
  assert.equal(rest.length, objects().length);
  assert.deepEqual(typeErrors([rest]), [[]]);
  assert.deepEqual(mismatches(rest), []);
  const proxy = rest.find((one) => one.kind === 'Deployment');
  assert.equal(proxy?.spec.template.spec.volumes[0].configMap.name, map?.metadata.name);
});

// ---- compose ----

test('the compose file is consistent: services, names, networks, secrets, options', () => {
  const [compose] = parse(read('compose.yaml')),
    { services } = compose,
    daemons = Object.keys(services).filter((name) => /^laglab-\d$/.test(name));
  assert.deepEqual(daemons, ['laglab-0', 'laglab-1', 'laglab-2']);
  const names = servers();
  for (const name of daemons) {
    const { command, networks, env_file, stop_grace_period, image } = services[name];
    assert.equal(image, 'laglab');
    assert.equal(command[0], 'serve');
    assert.equal(command[command.indexOf('--url') + 1], `http://${name}.laglab:8080`);
    assert.deepEqual(networks.inside.aliases, [`${name}.laglab`]);
    assert.ok(names.some((server) => server.address === `${name}.laglab:8080`));
    assert.deepEqual(env_file, ['secrets/store.env']);
    assert.equal(stop_grace_period, '60s');
    for (const option of command.filter((/** @type {string} */ word) => word.startsWith('--')))
      assert.ok(HELP.includes(`  ${option} `) || (SHARED && option === '--url'), option);
    assert.equal(command[command.indexOf('--trusted-proxy') + 1], compose.networks.inside.ipam.config[0].subnet);
  }
  for (const [name, service] of Object.entries(services)) {
    for (const other of Array.isArray(service.depends_on) ? service.depends_on : Object.keys(service.depends_on ?? {}))
      assert.ok(services[other], `${name}: ${other}`);
    for (const network of Array.isArray(service.networks) ? service.networks : Object.keys(service.networks))
      assert.ok(network in compose.networks, `${name}: ${network}`);
    for (const secret of service.secrets ?? []) assert.ok(compose.secrets[secret], `${name}: ${secret}`);
    for (const volume of service.volumes ?? []) {
      const [from] = volume.split(':');
      assert.ok(from.startsWith('./') ? readdirSync(CLUSTER).includes(from.slice(2)) : from in compose.volumes, `${name}: ${volume}`);
    }
  }
  assert.deepEqual(services.haproxy.ports, ['80:8080']);
  assert.match(read('haproxy.cfg'), /^ +bind :8080 /m);
});

// ---- alerts and dashboard ----

/** Names of metrics of ours in a text of PromQL. @param {string} text */
const namesIn = (text) => [...new Set([...text.matchAll(/\blaglab_\w+/g)].map(([name]) => name.replace(/_bucket$/, '')))].sort();
const dashboard = () => JSON.parse(read('dashboard.json'));
const expressions = () =>
  dashboard().panels.flatMap((/** @type {any} */ panel) => (panel.targets ?? []).map((/** @type {any} */ target) => target.expr));

test('alerts and dashboard have only metrics that a daemon has', async (t) => {
  const { missing, call: postgres } = ownPostgres();
  if (!missing) t.after(() => postgres('remove'));
  const shared = missing || SHARED ? [] : ['--store', postgres('start'), '--url', 'http://127.0.0.1:1'];
  const daemon = await startDaemon({ args: shared });
  t.after(() => daemon.stop());
  const text = await (await fetch(new URL('/metrics', daemon.url))).text(),
    there = new Map([...text.matchAll(/^# TYPE (\w+) (\w+)$/gm)].map(([, name, type]) => [name, type]));
  const used = namesIn([read('alerts.yaml'), ...expressions(), read('alerts.test.yaml'), read('k8s/autoscaler.yaml')].join('\n'));
  assert.ok(used.length > 20);
  if (shared.length > 0)
    assert.deepEqual(
      used.filter((name) => !there.has(name)),
      [],
    );
  /* A rate is of what only grows. */
  for (const [, name] of [read('alerts.yaml'), ...expressions()].join('\n').matchAll(/\b(?:rate|increase)\((laglab_\w+)/g))
    assert.match(there.get(name.replace(/_bucket$/, '')) ?? 'counter', /^(counter|histogram)$/, name);
  const labels = new Set(
    [...text.matchAll(/^(laglab_\w+)\{(\w+)="([^"]*)"\}/gm)].map(([, name, label, value]) => `${name}.${label}=${value}`),
  );
  for (const [, name, label, values] of [read('alerts.yaml'), ...expressions()]
    .join('\n')
    .matchAll(/(laglab_\w+)\{(limit|class|status|why)=~?"([^"$]*)"/g))
    for (const value of values.split('|'))
      if (there.has(name)) assert.ok(labels.has(`${name}.${label}=${value}`), `${name}{${label}="${value}"}`);
});

test('Prometheus takes the alerts, and each is raised by what it is for and by nothing else', { skip: absent('promtool') }, () => {
  assert.deepEqual(
    [run('promtool', 'check', 'rules', 'alerts.yaml')].map(({ status, stderr }) => [status, stderr]),
    [[0, '']],
  );
  const { status, stdout, stderr } = run('promtool', 'test', 'rules', 'alerts.test.yaml');
  assert.equal(status, 0, stdout + stderr);
  const [rules] = parse(read('alerts.yaml')),
    [{ tests }] = parse(read('alerts.test.yaml'));
  const alerts = rules.groups.flatMap((/** @type {any} */ group) => group.rules.map((/** @type {any} */ rule) => rule.alert)),
    cases = tests.flatMap((/** @type {any} */ one) => one.alert_rule_test);
  for (const alert of alerts) {
    assert.ok(
      cases.some((/** @type {any} */ one) => one.alertname === alert && one.exp_alerts),
      `${alert} is raised`,
    );
    assert.ok(
      cases.some((/** @type {any} */ one) => one.alertname === alert && !one.exp_alerts),
      `${alert} is not`,
    );
  }
});

test('the dashboard is whole, and Prometheus reads its expressions', { skip: absent('promtool') }, () => {
  const { panels, templating } = dashboard();
  assert.equal(new Set(panels.map((/** @type {any} */ panel) => panel.id)).size, panels.length);
  const covered = new Set();
  for (const { gridPos: at, title } of panels)
    for (let x = at.x; x < at.x + at.w; x++)
      for (let y = at.y; y < at.y + at.h; y++) {
        assert.ok(x < 24 && !covered.has(`${x} ${y}`), `${title} lies over another`);
        covered.add(`${x} ${y}`);
      }
  const variables = templating.list.map((/** @type {any} */ one) => one.name);
  for (const [, name] of JSON.stringify(panels).matchAll(/\$\{?(\w+)\}?/g)) assert.ok(variables.includes(name), `$${name}`);
  const file = path.join(folder, 'expressions.yaml');
  const rules = expressions().map((/** @type {string} */ expr, /** @type {number} */ i) => ({
    record: `panel:${i}`,
    expr: expr.replaceAll('$instance', '.*'),
  }));
  writeFileSync(file, JSON.stringify({ groups: [{ name: 'dashboard', rules }] }));
  const { status, stdout, stderr } = run('promtool', 'check', 'rules', file);
  assert.equal(status, 0, stdout + stderr);
});

// ---- backup ----

/** The blocks of commands of a part of docs/scale.md. */
function blocks(/** @type {string} */ heading) {
  const text = readFileSync(path.join(ROOT, 'docs/scale.md'), 'utf8'),
    from = text.indexOf(`\n## ${heading}\n`),
    end = text.indexOf('\n## ', from + 5);
  return [...text.slice(from, end).matchAll(/^```console\n([\s\S]*?)^```$/gm)].map(([, commands]) => commands);
}

test('a backup is made and restored as docs/scale.md has it', { skip: SHARED || absent('pg_dump') || absent('psql') }, async (t) => {
  const { missing, call: postgres, count } = ownPostgres();
  if (missing) return t.skip(missing);
  t.after(() => postgres('remove'));
  const store = postgres('start'),
    [dump, restore, proof] = blocks('Backup');
  mkdirSync(path.join(folder, 'backup'));
  mkdirSync(path.join(folder, 'bin'), { recursive: true });
  symlinkSync(BINARY, path.join(folder, 'bin/laglab'));
  let url = '';
  const follow = (/** @type {string} */ commands) => {
    const text = commands.replaceAll('/backup/', `${folder}/backup/`).replace('http://127.0.0.1:8080/', url);
    const result = spawnSync('bash', ['-eu', '-o', 'pipefail', '-c', text], {
      encoding: 'utf8',
      cwd: folder,
      env: { ...env, LAGLAB_STORE: store, PATH: `${folder}/bin:${env.PATH}` },
      timeout: 60000,
    });
    assert.equal(result.status, 0, `${text}: ${result.stderr}`);
    return result.stdout;
  };
  const start = async () => {
    const daemon = await startDaemon({ args: ['--store', store, '--url', 'http://127.0.0.1:1', '--max-new-sessions-per-min', '1000'] }),
      c = client(daemon.url);
    url = daemon.url;
    return { daemon, c };
  };
  let { daemon, c } = await start();
  const kept = [];
  for (let i = 0; i < 10; i++) {
    const session = await c.make({ paused: true });
    await c.control(session, { op: 'step', ticks: 60 + i });
    assert.equal((await c.patch(session, { 'players.0.lag_ms': 10 * i })).status, 200);
    kept.push({ session, state: (await c.control(session, { op: 'step', ticks: 30 })).json });
  }
  follow(dump);
  const late = await c.make({ paused: true });
  assert.equal((await c.patch(kept[0].session, { 'players.0.lag_ms': 499 })).status, 200);
  c.close();
  await daemon.stop();
  follow(restore);
  ({ daemon, c } = await start());
  t.after(async () => {
    c.close();
    await daemon.stop();
  });
  assert.equal(count('SELECT count(*) FROM laglab_sessions.session'), 10);
  for (const { session, state } of kept) {
    const { json } = await c.get(session.links.self);
    assert.deepEqual([json.tick, json.status], [state.tick, 'paused']);
    assert.equal((await c.get(session.links.state)).json.hash, state.hash);
  }
  assert.equal((await c.get(late.links.self)).status, 404, 'what came after the backup is lost');
  assert.equal((await c.patch(kept[0].session, { 'players.0.lag_ms': 77 })).status, 200, 'and it goes on');
  const said = follow(proof);
  assert.equal([...said.matchAll(/"hash":/g)].length, 10, said);
});

const BACKUP_TOOLS = absent('pg_basebackup') || absent('psql') || absent('setpriv');

test('the write-ahead log is archived, and a mistake undone, as docs/scale.md has it', { skip: SHARED || BACKUP_TOOLS }, async (t) => {
  const { missing, call: postgres, count } = ownPostgres();
  if (missing) return t.skip(missing);
  t.after(() => postgres('remove'));
  const store = postgres('start'),
    server = store.slice(store.indexOf('host=') + 5),
    [, , , archive, base, restore] = blocks('Backup');
  /* The service manager of the guide is the script that has the server. */
  const script = path.join(ROOT, 'tests/support/postgres'),
    bin = mkdtempSync(path.join(tmpdir(), 'laglab-bin-'));
  t.after(() => rmSync(bin, { recursive: true, force: true }));
  chmodSync(bin, 0o755);
  writeFileSync(
    path.join(bin, 'systemctl'),
    `#!/bin/sh -e\ncase $1 in re*) "${script}" stop "${server}"; "${script}" start "${server}";; *) "${script}" $1 "${server}";; esac\n`,
    { mode: 0o755 },
  );
  const as = process.getuid?.() === 0 ? ['setpriv', '--reuid', 'postgres', '--regid', 'postgres', '--init-groups'] : [];
  const follow = (/** @type {string} */ commands) => {
    const text = commands
      .replaceAll('/backup/', `${server}/backup/`)
      .replaceAll('/var/lib/postgresql/15/main', `${server}/data`)
      .replaceAll('/var/lib/postgresql/15/', `${server}/`);
    const [command, ...rest] = [...as, 'bash', '-eu', '-o', 'pipefail', '-c', text];
    const result = spawnSync(command, rest, {
      encoding: 'utf8',
      cwd: '/',
      env: { ...env, HOME: '/', PGHOST: server, PGUSER: 'laglab', PATH: `${bin}:${env.PATH}` },
      timeout: 60000,
    });
    assert.equal(result.status, 0, `${text}: ${result.stderr}`);
  };
  const start = async () => {
    const daemon = await startDaemon({ args: ['--store', store, '--url', 'http://127.0.0.1:1'] });
    return { daemon, c: client(daemon.url) };
  };
  follow(archive);
  let { daemon, c } = await start();
  const before = await c.make({ paused: true });
  follow(base);
  const after = await c.make({ paused: true });
  for (const session of [before, after]) {
    assert.equal((await c.patch(session, { 'players.0.lag_ms': 77 })).status, 200);
    await c.control(session, { op: 'step', ticks: 90 });
  }
  const hashes = async () => Promise.all([before, after].map(async ({ links }) => (await c.get(links.state)).json.hash)),
    wanted = await hashes(),
    moment = postgres('sql', 'SELECT now()');
  // The mistake, and what comes after it.
  const late = await c.make({ paused: true });
  postgres('sql', `DELETE FROM laglab_sessions.line WHERE session=(SELECT no FROM laglab_sessions.session WHERE id='${after.id}')`);
  c.close();
  await daemon.stop();
  assert.match(restore, /'2026-11-28 09:30:00\+00'/);
  follow(restore.replace('2026-11-28 09:30:00+00', moment));
  ({ daemon, c } = await start());
  t.after(async () => {
    c.close();
    await daemon.stop();
  });
  assert.deepEqual(await hashes(), wanted, 'also what was made after the base');
  assert.equal((await c.get(late.links.self)).status, 404, 'what came later is undone');
  assert.equal((await c.patch(after, { 'players.0.lag_ms': 5 })).status, 200, 'and it goes on');
  assert.equal(count('SELECT count(*) FROM laglab_sessions.session'), 2);
});
