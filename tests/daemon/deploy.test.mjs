// The files in deploy/: Kubernetes objects have the right types and match each other. The proxies: shards.test.mjs.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { fileURLToPath } from 'node:url';
import { parseDocument } from 'yaml';
import { sbom } from '../../deploy/sbom.mjs';
import { BINARY } from '../lib/daemon.mjs';
import { parse, pods, problems as problemsOf, typeErrors } from '../lib/objects.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..'),
  DEPLOY = path.join(ROOT, 'deploy');
const FOLDERS = ['shards', 'k8s/sweep'];

/** @typedef {import('../lib/objects.mjs').Thing} Thing */

const read = (/** @type {string} */ folder, /** @type {string} */ name) => readFileSync(path.join(DEPLOY, folder, name), 'utf8');
const kustomization = (/** @type {string} */ folder) => parse(read(folder, 'kustomization.yaml'))[0];
const objects = () =>
  FOLDERS.flatMap((folder) => kustomization(folder).resources.flatMap((/** @type {string} */ name) => parse(read(folder, name))));
const problems = (/** @type {Thing[]} */ all) => problemsOf(all, FOLDERS.map((folder) => read(folder, 'kustomization.yaml')).join('\n'));

test('Kubernetes objects have valid fields and types, and match each other', () => {
  const all = objects();
  assert.deepEqual(all.map((thing) => `${thing.kind} ${thing.metadata.name}`).sort(), [
    'Deployment laglab-proxy',
    'Job laglab-merge',
    'Job laglab-sweep',
    'NetworkPolicy laglab',
    'PersistentVolumeClaim laglab-rows',
    'PodDisruptionBudget laglab',
    'Service laglab',
    'Service laglab-proxy',
    'StatefulSet laglab',
  ]);
  assert.deepEqual(typeErrors([all]), [[]]);
  assert.deepEqual(problems(all), []);
  const { version } = JSON.parse(readFileSync(path.join(ROOT, 'package.json'), 'utf8'));
  for (const folder of FOLDERS) assert.deepEqual(kustomization(folder).images[0], { name: 'laglab', newTag: version });
});

test('mistakes in them are found', () => {
  /** @type {[string, (all: Record<string, Thing>) => void][]} */
  const typed = [
    [
      '\'"replicass"\' does not exist',
      (o) => {
        o.StatefulSet.spec.replicass = 2;
      },
    ],
    [
      "'string' is not assignable to type 'number'",
      (o) => {
        o.Job.spec.completions = '8';
      },
    ],
    [
      "has no exported member named 'StatefullSet'",
      (o) => {
        o.StatefulSet.kind = 'StatefullSet';
      },
    ],
    [
      "Cannot find module 'kubernetes-types/batch/v2'",
      (o) => {
        o.Job.apiVersion = 'batch/v2';
      },
    ],
    [
      '\'"readonlyRootFilesystem"\' does not exist',
      (o) => {
        o.Job.spec.template.spec.containers[0].securityContext.readonlyRootFilesystem = true;
      },
    ],
    [
      "Property 'serviceName' is missing",
      (o) => {
        delete o.StatefulSet.spec.serviceName;
      },
    ],
  ];
  /** @type {[string, (all: Record<string, Thing>) => void][]} */
  const ruled = [
    [
      'selects 0 workloads',
      (o) => {
        o.Service.spec.selector = { app: 'lab' };
      },
    ],
    [
      'no container has the port web',
      (o) => {
        o.Service.spec.ports[0].targetPort = 'web';
      },
    ],
    [
      'no headless service',
      (o) => {
        delete o.Service.spec.clusterIP;
      },
    ],
    [
      'does not select its own',
      (o) => {
        o.StatefulSet.spec.selector.matchLabels = { app: 'lab' };
      },
    ],
    [
      'podManagementPolicy',
      (o) => {
        o.StatefulSet.spec.podManagementPolicy = 'parallel';
      },
    ],
    [
      'volume data',
      (o) => {
        o.StatefulSet.spec.volumeClaimTemplates[0].metadata.name = 'store';
      },
    ],
    [
      'probe of port',
      (o) => {
        o.StatefulSet.spec.template.spec.containers[0].readinessProbe.httpGet.port = 'web';
      },
    ],
    [
      'user of the image',
      (o) => {
        o.StatefulSet.spec.template.spec.securityContext.runAsUser = 0;
      },
    ],
    [
      'seccomp',
      (o) => {
        delete o.Job.spec.template.spec.securityContext.seccompProfile;
      },
    ],
    [
      'capabilities',
      (o) => {
        o.Job.spec.template.spec.containers[0].securityContext.capabilities.drop = [];
      },
    ],
    [
      'laglab serve --lisen',
      (o) => {
        o.StatefulSet.spec.template.spec.containers[0].args[1] = '--lisen';
      },
    ],
    [
      'laglab work',
      (o) => {
        o.Job.spec.template.spec.containers[0].args[0] = 'work';
      },
    ],
    [
      'must be an indexed job with a pod for each',
      (o) => {
        o.Job.spec.completions = 7;
      },
    ],
    [
      'must be an indexed job with a pod for each',
      (o) => {
        o.Job.spec.completionMode = 'NonIndexed';
      },
    ],
    [
      '$(WORKERS) is not set',
      (o) => {
        o.Job.spec.template.spec.containers[0].args.push('--jobs', '$(WORKERS)');
      },
    ],
    [
      'secret laglab with operator',
      (o) => {
        const env = o.StatefulSet.spec.template.spec.containers[0].env;
        env.find((/** @type {Thing} */ one) => one.valueFrom?.secretKeyRef?.key === 'operator').valueFrom.secretKeyRef.name = 'laglab';
      },
    ],
    [
      'config map lag: has no instructions',
      (o) => {
        o.Job.spec.template.spec.volumes[0].configMap.name = 'lag';
      },
    ],
    [
      'claim rows is not there',
      (o) => {
        o.Job.spec.template.spec.volumes[1].persistentVolumeClaim.claimName = 'rows';
      },
    ],
    [
      'NetworkPolicy laglab: selects 0',
      (o) => {
        o.NetworkPolicy.spec.podSelector.matchLabels = { app: 'lab' };
      },
    ],
    [
      'leaves a direction open',
      (o) => {
        o.NetworkPolicy.spec.policyTypes = ['Ingress'];
      },
    ],
    [
      'admits all clients',
      (o) => {
        delete o.NetworkPolicy.spec.ingress[0].from;
      },
    ],
    [
      'no container has the port web',
      (o) => {
        o.NetworkPolicy.spec.ingress[0].ports[0].port = 'web';
      },
    ],
    [
      'needs restartPolicy Never',
      (o) => {
        o.Job.spec.template.spec.restartPolicy = 'OnFailure';
      },
    ],
    [
      'PodDisruptionBudget laglab: selects nothing',
      (o) => {
        o.PodDisruptionBudget.spec.selector.matchLabels = { app: 'lab' };
      },
    ],
  ];
  const changed = (/** @type {(all: Record<string, Thing>) => void} */ change) => {
    const all = objects();
    change(Object.fromEntries(all.filter((thing) => !/proxy|merge/.test(thing.metadata.name)).map((thing) => [thing.kind, thing])));
    return all;
  };
  typeErrors(typed.map(([, change]) => changed(change))).forEach((errors, i) =>
    assert.ok(
      errors.some((error) => error.includes(typed[i][0])),
      `${typed[i][0]}: ${errors.join('; ')}`,
    ),
  );
  for (const [told, change] of ruled) {
    const found = problems(changed(change));
    assert.ok(
      found.some((problem) => problem.includes(told)),
      `${told}: ${found.join('; ')}`,
    );
  }
  assert.equal(parseDocument('a: 1\na: 2\n', { uniqueKeys: true }).errors.length, 1, 'a key given twice');
});

test('the bill of materials is SPDX with every package once', () => {
  const lock = JSON.parse(readFileSync(path.join(ROOT, 'package-lock.json'), 'utf8'));
  const rows = [
    'libc6:amd64\t2.36-9+deb12u13\tamd64\tglibc\t2.36-9+deb12u13',
    'adduser\t3.134\tall\tadduser\t3.134',
    'libstdc++6:amd64\t12.2.0-14\tamd64\tgcc-12\t12.2.0-14',
  ];
  const bill = sbom(`${rows.join('\n')}\n`, lock, '2026-11-23T00:00:00Z');
  assert.deepEqual(
    [bill.spdxVersion, bill.dataLicense, bill.SPDXID, bill.creationInfo.created],
    ['SPDX-2.3', 'CC0-1.0', 'SPDXRef-DOCUMENT', '2026-11-23T00:00:00Z'],
  );
  const ids = bill.packages.map((one) => one.SPDXID);
  assert.equal(new Set(ids).size, ids.length);
  for (const one of ids) assert.match(one, /^SPDXRef-[A-Za-z0-9.-]+$/);
  const by_name = Object.fromEntries(bill.packages.map((/** @type {Thing} */ one) => [one.name, one]));
  assert.equal(
    by_name.libc6.externalRefs[0].referenceLocator,
    'pkg:deb/debian/libc6@2.36-9%2Bdeb12u13?arch=amd64&distro=debian-12&upstream=glibc%402.36-9%2Bdeb12u13',
  );
  const libraries = Object.entries(JSON.parse(readFileSync(path.join(ROOT, 'package.json'), 'utf8')).dependencies);
  assert.ok(libraries.length >= 3);
  for (const [name, version] of libraries.filter(([name]) => name !== 'esbuild')) {
    assert.equal(by_name[name].versionInfo, version);
    assert.equal(by_name[name].checksums[0].checksumValue.length, 128);
  }
  for (const tool of ['playwright-core', 'esbuild', '@esbuild/linux-x64'])
    assert.ok(!(tool in by_name), 'tools of the tests and of the build are not in the image');
  for (const { spdxElementId, relatedSpdxElement } of bill.relationships)
    for (const one of [spdxElementId, relatedSpdxElement]) assert.ok(one === 'SPDXRef-DOCUMENT' || ids.includes(one), one);
  assert.equal(bill.relationships.filter((one) => one.relationshipType === 'DEPENDS_ON').length, ids.length - 1);
});

test('the image is built on a base that is pinned, and its two stages on the same', () => {
  const text = readFileSync(path.join(ROOT, 'Dockerfile'), 'utf8');
  assert.match(text, /^ARG BASE=debian:bookworm-slim@sha256:[0-9a-f]{64}$/m);
  const bases = [...text.matchAll(/^FROM (\S+)(?: AS (\S+))?/gm)],
    own = bases.map(([, , name]) => name);
  for (const [, base] of bases) assert.ok(base === '${BASE}' || own.includes(base), `FROM ${base}`);
});

test('proxies, compose file and Kubernetes have the same shards at the same names', () => {
  const haproxy = read('shards', 'haproxy.cfg'),
    servers = (/** @type {string} */ part) => [...part.matchAll(/^ +server (\S+) (\S+)$/gm)].map(([, name, at]) => [name, at]),
    own = haproxy.indexOf('\nbackend s0\n');
  const wanted = [0, 1, 2].map((i) => [`s${i}`, `laglab-${i}.laglab:8080`]);
  assert.deepEqual(servers(haproxy.slice(0, own)), wanted);
  assert.deepEqual(servers(haproxy.slice(own)), wanted);
  assert.deepEqual(
    [...haproxy.slice(own).matchAll(/^backend (\w+)$/gm)].map(([, name]) => name),
    wanted.map(([name]) => name),
  );
  const nginx = read('shards', 'nginx.conf');
  for (const [name] of wanted) assert.match(nginx, new RegExp(`^ +${name} +laglab-${name};$[^]*^upstream laglab-${name} `, 'm'));
  const [{ services, volumes }] = parse(read('shards', 'compose.yaml'));
  for (const [name, at] of wanted) {
    const { command, networks, volumes: own_volumes } = services[name];
    assert.equal(command[command.indexOf('--shard') + 1], name);
    assert.deepEqual([networks.inside.aliases, own_volumes], [[at.replace(':8080', '')], [`${name}:/data`]]);
    assert.ok(name in volumes && services.haproxy.depends_on.includes(name));
    const { status, stderr } = spawnSync(BINARY, [...command.slice(0, -1), '127.0.0.1', '--help'], { encoding: 'utf8' });
    assert.equal(status, 0, stderr);
  }
  const set = objects().find((thing) => thing.kind === 'StatefulSet');
  assert.deepEqual([set?.spec.replicas, `${set?.metadata.name}-0.${set?.spec.serviceName}:8080`], [wanted.length, wanted[0][1]]);
  assert.match(set?.spec.template.spec.containers[0].args.join(' '), / --shard s\$\(INDEX\) /);
});

const kubectl = spawnSync('kubectl', ['version', '--client']).status === 0;
test('Kustomize makes the same objects of them', { skip: kubectl ? false : 'kubectl is not installed' }, () => {
  const rendered = FOLDERS.flatMap((folder) => {
    const result = spawnSync('kubectl', ['kustomize', path.join(DEPLOY, folder)], { encoding: 'utf8' });
    assert.equal(result.status, 0, result.stderr);
    return parse(result.stdout);
  });
  assert.deepEqual(
    rendered
      .map((thing) => thing.kind)
      .filter((kind) => kind !== 'ConfigMap')
      .sort(),
    objects()
      .map((thing) => thing.kind)
      .sort(),
  );
  assert.deepEqual(typeErrors([rendered]), [[]]);
  assert.deepEqual(problems(rendered.filter((thing) => thing.kind !== 'ConfigMap')), []);
  for (const pod of pods(rendered)) assert.match(pod.spec.template.spec.containers[0].image, /^(laglab|haproxy):\d/);
});
