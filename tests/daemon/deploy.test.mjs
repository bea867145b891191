// The files in deploy/: Kubernetes objects have the right types and match each other, and a proxy finds the daemon that has a session.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { fileURLToPath } from 'node:url';
import ts from 'typescript';
import { parseAllDocuments, parseDocument } from 'yaml';
import { sbom } from '../../deploy/sbom.mjs';
import { startProxy } from '../../bench/proxies/proxies.mjs';
import { client } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..'),
  K8S = path.join(ROOT, 'deploy/k8s');
const FOLDERS = ['daemon', 'workers'];

/** @typedef {Record<string, any>} Thing an object of Kubernetes */

/** @param {string} text @returns {Thing[]} */
function parse(text) {
  return parseAllDocuments(text, { uniqueKeys: true }).map((document) => {
    assert.deepEqual(document.errors, []);
    return /** @type {Thing} */ (document.toJS());
  });
}

const read = (/** @type {string} */ folder, /** @type {string} */ name) => readFileSync(path.join(K8S, folder, name), 'utf8');
const kustomization = (/** @type {string} */ folder) => parse(read(folder, 'kustomization.yaml'))[0];
const objects = () =>
  FOLDERS.flatMap((folder) => kustomization(folder).resources.flatMap((/** @type {string} */ name) => parse(read(folder, name))));

// ---- types ----

/**
 * TypeScript's messages about each list of objects, checked with Kubernetes' types: unknown, missing and wrong fields.
 * @param {Thing[][]} lists
 */
function typeErrors(lists) {
  const file = (/** @type {number} */ i) => path.join(ROOT, `objects-${i}.ts`);
  const sources = new Map(
    lists.map((list, i) => [
      file(i),
      list
        .map((thing, k) => {
          const group = String(thing.apiVersion).includes('/') ? thing.apiVersion.replace('.k8s.io', '') : `core/${thing.apiVersion}`;
          return `import type { ${thing.kind} as T${k} } from 'kubernetes-types/${group}';\nexport const o${k}: T${k} = ${JSON.stringify(thing)};`;
        })
        .join('\n'),
    ]),
  );
  const options = {
    strict: true,
    noEmit: true,
    skipLibCheck: true,
    types: [],
    module: ts.ModuleKind.ESNext,
    moduleResolution: ts.ModuleResolutionKind.Bundler,
  };
  const host = ts.createCompilerHost(options),
    { getSourceFile, fileExists, readFile } = host;
  host.fileExists = (name) => sources.has(name) || fileExists(name);
  host.readFile = (name) => sources.get(name) ?? readFile(name);
  host.getSourceFile = (name, target, ...rest) => {
    const text = sources.get(name);
    return text === undefined ? getSourceFile(name, target, ...rest) : ts.createSourceFile(name, text, target);
  };
  const program = ts.createProgram([...sources.keys()], options, host);
  return lists.map((_, i) =>
    program.getSemanticDiagnostics(program.getSourceFile(file(i))).map((d) => ts.flattenDiagnosticMessageText(d.messageText, ' ')),
  );
}

// ---- checks beyond types ----

const pods = (/** @type {Thing[]} */ all) => all.filter((thing) => thing.spec?.template);
const selects = (/** @type {Thing} */ selector, /** @type {Thing} */ pod) =>
  Object.entries(selector).every(([key, value]) => pod.spec.template.metadata.labels[key] === value);

/** @param {Thing} workload @returns {string[]} */
function podProblems(workload) {
  const pod = workload.spec.template.spec,
    problems = [],
    name = `${workload.kind} ${workload.metadata.name}`;
  const say = (/** @type {boolean} */ right, /** @type {string} */ what) => {
    if (!right) problems.push(`${name}: ${what}`);
  };
  const volumes = [
    ...(pod.volumes ?? []),
    ...(workload.spec.volumeClaimTemplates ?? []).map((/** @type {Thing} */ claim) => claim.metadata),
  ];
  say(['Always', 'OnFailure', 'Never', undefined].includes(pod.restartPolicy), `restartPolicy ${pod.restartPolicy}`);
  say(pod.securityContext?.runAsNonRoot === true && pod.securityContext.runAsUser === 10001, 'runs as the user of the image');
  say(pod.securityContext?.seccompProfile?.type === 'RuntimeDefault', 'seccomp profile');
  say(pod.automountServiceAccountToken === false, 'needs no token of the cluster');
  for (const container of pod.containers) {
    const security = container.securityContext ?? {},
      ports = (container.ports ?? []).map((/** @type {Thing} */ port) => port.name);
    say(security.allowPrivilegeEscalation === false && security.readOnlyRootFilesystem === true, 'may gain privileges or write its root');
    say(JSON.stringify(security.capabilities?.drop) === '["ALL"]', 'keeps capabilities');
    for (const mount of container.volumeMounts ?? [])
      say(
        volumes.some((volume) => volume.name === mount.name),
        `volume ${mount.name} is not there`,
      );
    for (const probe of [container.readinessProbe, container.livenessProbe])
      if (probe) say(ports.includes(probe.httpGet.port), `probe of port ${probe.httpGet.port}`);
    const environment = (container.env ?? []).map((/** @type {Thing} */ one) => one.name);
    for (const [, variable] of container.args.join(' ').matchAll(/\$\((\w+)\)/g))
      say(environment.includes(variable), `$(${variable}) is not set`);
    const [verb, ...rest] = container.args,
      help = spawnSync(BINARY, [verb, '--help'], { encoding: 'utf8' });
    say(help.status === 0, `laglab ${verb}`);
    say(verb !== 'worker' || rest.includes('--store') || environment.includes('LAGLAB_STORE'), 'a worker without a store');
    for (const option of rest.filter((/** @type {string} */ word) => word.startsWith('--')))
      say(help.stdout.includes(`${option} `) || help.stdout.includes(`${option}\n`), `laglab ${verb} ${option}`);
    for (const one of container.env ?? []) {
      const secret = one.valueFrom?.secretKeyRef;
      if (secret)
        say(
          FOLDERS.some((folder) =>
            read(folder, 'kustomization.yaml').includes(`create secret generic ${secret.name} --from-literal=${secret.key}=`),
          ),
          `secret ${secret.name} with ${secret.key}: has no instructions to create it`,
        );
    }
  }
  return problems;
}

/** @param {Thing[]} all @returns {string[]} */
function problems(all) {
  const found = pods(all).flatMap(podProblems);
  const say = (/** @type {boolean} */ right, /** @type {string} */ what) => {
    if (!right) found.push(what);
  };
  for (const thing of all) {
    const { kind, spec } = thing,
      name = `${kind} ${thing.metadata?.name}`;
    say(Boolean(thing.apiVersion && kind && thing.metadata?.name), `${name}: apiVersion, kind and name`);
    if (kind === 'Service') {
      const behind = pods(all).filter((pod) => selects(spec.selector, pod));
      say(behind.length === 1, `${name}: selects ${behind.length} workloads`);
      for (const port of spec.ports)
        say(
          behind.every((pod) =>
            pod.spec.template.spec.containers.some((/** @type {Thing} */ c) =>
              c.ports?.some((/** @type {Thing} */ p) => p.name === port.targetPort),
            ),
          ),
          `${name}: no container has the port ${port.targetPort}`,
        );
    }
    if (kind === 'StatefulSet') {
      say(selects(spec.selector.matchLabels, thing), `${name}: does not select its own pods`);
      say(
        all.some((other) => other.kind === 'Service' && other.metadata.name === spec.serviceName && other.spec.clusterIP === 'None'),
        `${name}: ${spec.serviceName} is no headless service`,
      );
      say(['Parallel', 'OrderedReady'].includes(spec.podManagementPolicy), `${name}: podManagementPolicy`);
    }
    if (kind === 'PodDisruptionBudget')
      say(
        pods(all).some((pod) => selects(spec.selector.matchLabels, pod)),
        `${name}: selects nothing`,
      );
    if (kind === 'NetworkPolicy') {
      const chosen = pods(all).filter((pod) => selects(spec.podSelector.matchLabels, pod));
      say(chosen.length === 1, `${name}: selects ${chosen.length} workloads`);
      say(JSON.stringify(spec.policyTypes) === '["Ingress","Egress"]', `${name}: leaves a direction open`);
      say(
        spec.ingress.every((/** @type {Thing} */ rule) => rule.from?.length > 0 && rule.ports?.length > 0),
        `${name}: admits all clients`,
      );
      for (const { port } of spec.ingress.flatMap((/** @type {Thing} */ rule) => rule.ports ?? []))
        say(
          chosen.every((pod) =>
            pod.spec.template.spec.containers.some((/** @type {Thing} */ c) => c.ports?.some((/** @type {Thing} */ p) => p.name === port)),
          ),
          `${name}: no container has the port ${port}`,
        );
    }
    if (kind === 'Job') {
      say(spec.completionMode === 'Indexed' && spec.completions >= spec.parallelism, `${name}: an indexed job has an index for each pod`);
      say(
        spec.backoffLimitPerIndex === undefined || spec.template.spec.restartPolicy === 'Never',
        `${name}: backoffLimitPerIndex needs restartPolicy Never`,
      );
    }
  }
  return found;
}

test('Kubernetes objects have valid fields and types, and match each other', () => {
  const all = objects();
  assert.deepEqual(all.map((thing) => thing.kind).sort(), ['Job', 'NetworkPolicy', 'PodDisruptionBudget', 'Service', 'StatefulSet']);
  assert.deepEqual(typeErrors([all]), [[]]);
  assert.deepEqual(problems(all), []);
  const { version } = JSON.parse(readFileSync(path.join(ROOT, 'package.json'), 'utf8'));
  for (const folder of FOLDERS) assert.deepEqual(kustomization(folder).images, [{ name: 'laglab', newTag: version }]);
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
      'a worker without a store',
      (o) => {
        o.Job.spec.template.spec.containers[0].env = [];
      },
    ],
    [
      '$(WORKERS) is not set',
      (o) => {
        o.Job.spec.template.spec.containers[0].args.push('--jobs', '$(WORKERS)');
      },
    ],
    [
      'secret laglab with url',
      (o) => {
        o.Job.spec.template.spec.containers[0].env[0].valueFrom.secretKeyRef.name = 'laglab';
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
      'indexed job',
      (o) => {
        o.Job.spec.completionMode = 'NonIndexed';
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
    change(Object.fromEntries(all.map((thing) => [thing.kind, thing])));
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
  const linked = 'libarchive-dev:amd64\t3.6.2-1+deb12u5\tamd64\tlibarchive\t3.6.2-1+deb12u5\n';
  const bill = sbom(`${rows.join('\n')}\n`, lock, '2026-11-23T00:00:00Z', linked);
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
  for (const [name, version] of libraries) {
    assert.equal(by_name[name].versionInfo, version);
    assert.equal(by_name[name].checksums[0].checksumValue.length, 128);
  }
  assert.ok(!('playwright-core' in by_name), 'tools of the tests are not in the image');
  for (const { spdxElementId, relatedSpdxElement } of bill.relationships)
    for (const one of [spdxElementId, relatedSpdxElement]) assert.ok(one === 'SPDXRef-DOCUMENT' || ids.includes(one), one);
  const related = (/** @type {string} */ type) => bill.relationships.filter((one) => one.relationshipType === type);
  assert.equal(related('DEPENDS_ON').length, ids.length - 2);
  assert.deepEqual(
    related('STATIC_LINK').map((one) => one.relatedSpdxElement),
    [by_name['libarchive-dev'].SPDXID],
  );
});

test('the image is built on a base that is pinned, and its two stages on the same', () => {
  const text = readFileSync(path.join(ROOT, 'Dockerfile'), 'utf8');
  assert.match(text, /^ARG BASE=docker\.io\/library\/debian:bookworm-slim@sha256:[0-9a-f]{64}$/m);
  const bases = [...text.matchAll(/^FROM (\S+)(?: AS (\S+))?/gm)],
    own = bases.map(([, , name]) => name);
  for (const [, base] of bases) assert.ok(base === '${BASE}' || own.includes(base), `FROM ${base}`);
});

const kubectl = spawnSync('kubectl', ['version', '--client']).status === 0;
test('Kustomize makes the same objects of them', { skip: kubectl ? false : 'kubectl is not installed' }, () => {
  const rendered = FOLDERS.flatMap((folder) => {
    const result = spawnSync('kubectl', ['kustomize', path.join(K8S, folder)], { encoding: 'utf8' });
    assert.equal(result.status, 0, result.stderr);
    return parse(result.stdout);
  });
  assert.deepEqual(
    rendered.map((thing) => thing.kind).sort(),
    objects()
      .map((thing) => thing.kind)
      .sort(),
  );
  assert.deepEqual(typeErrors([rendered]), [[]]);
  assert.deepEqual(problems(rendered), []);
  assert.match(pods(rendered)[0].spec.template.spec.containers[0].image, /^laglab:\d/);
});

test('HAProxy sends requests for a session to the daemon that created it', async (t) => {
  const daemons = await Promise.all([startDaemon(), startDaemon()]);
  t.after(() => Promise.all(daemons.map((daemon) => daemon.stop())));
  const text = readFileSync(path.join(ROOT, 'deploy/haproxy.cfg'), 'utf8')
    .replace('bind 0.0.0.0:80 ', 'bind LISTEN ')
    .replace('10.0.0.1:8080', `127.0.0.1:${daemons[0].port}`)
    .replace('10.0.0.2:8080', `127.0.0.1:${daemons[1].port}`);
  const proxy = await startProxy('haproxy', 0, text);
  t.after(() => proxy.stop());
  const http = client(proxy.url);
  t.after(() => http.close());
  const made = [];
  for (let i = 0; i < 8; i++) made.push(await http.make());
  for (const session of made)
    for (let i = 0; i < 3; i++) assert.equal((await fetch(`${proxy.url}/api/v1/sessions/${session.id}/state`)).status, 200);
  const here = await Promise.all(
    daemons.map(
      async (daemon) =>
        (await Promise.all(made.map((session) => fetch(`${daemon.url}api/v1/sessions/${session.id}`)))).filter(
          (answer) => answer.status === 200,
        ).length,
    ),
  );
  assert.equal(here[0] + here[1], made.length);
  assert.ok(here[0] > 0 && here[1] > 0, `both daemons have sessions: ${here}`);
});
