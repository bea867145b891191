// Kubernetes' objects without a cluster: their fields and types (kubernetes-types), and whether they match each other.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import ts from 'typescript';
import { parseAllDocuments } from 'yaml';
import { BINARY } from './daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');

/** @typedef {Record<string, any>} Thing an object of Kubernetes */

/** @param {string} text @returns {Thing[]} */
export function parse(text) {
  return parseAllDocuments(text, { uniqueKeys: true, merge: true }).map((document) => {
    assert.deepEqual(document.errors, []);
    return /** @type {Thing} */ (document.toJS());
  });
}

// ---- types ----

/**
 * TypeScript's messages about each list of objects, checked with Kubernetes' types: unknown, missing and wrong fields.
 * @param {Thing[][]} lists
 */
export function typeErrors(lists) {
  const file = (/** @type {number} */ i) => path.join(ROOT, `objects-${i}.ts`);
  const sources = new Map(
    lists.map((list, i) => [
      file(i),
      list
        .map((thing, k) => {
          const group = String(thing.apiVersion).includes('/') ? thing.apiVersion.replace('.k8s.io', '') : `core/${thing.apiVersion}`;
          return [
            `import type { ${thing.kind} as T${k} } from 'kubernetes-types/${group}';`,
            `export const o${k}: T${k} = ${JSON.stringify(thing)};`,
          ].join('\n');
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

export const pods = (/** @type {Thing[]} */ all) => all.filter((thing) => thing.spec?.template);
const selects = (/** @type {Thing} */ selector, /** @type {Thing} */ pod) =>
  Object.entries(selector).every(([key, value]) => pod.spec.template.metadata.labels[key] === value);

/** @param {Thing} workload @param {string[]} claims @param {string} instructions the files that say how secrets and config maps
 * are made @returns {string[]} */
function podProblems(workload, claims, instructions) {
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
  const users = { laglab: 10001, haproxy: 99 };
  say(
    pod.securityContext?.runAsNonRoot === true &&
      pod.containers.every((/** @type {Thing} */ one) => pod.securityContext.runAsUser === users[one.image.split(':')[0]]),
    'runs as the user of the image',
  );
  say(pod.securityContext?.seccompProfile?.type === 'RuntimeDefault', 'seccomp profile');
  say(pod.automountServiceAccountToken === false, 'needs no token of the cluster');
  for (const { configMap, persistentVolumeClaim: claim } of pod.volumes ?? []) {
    const generated = `configMapGenerator:\\n +- name: ${configMap?.name.replace(/-\w{10}$/, '')}\\n`,
      made = new RegExp(`create configmap ${configMap?.name} --from-file=|${generated}`);
    if (configMap) say(made.test(instructions), `config map ${configMap.name}: has no instructions to create it`);
    if (claim) say(claims.includes(claim.claimName), `claim ${claim.claimName} is not there`);
  }
  for (const container of [...(pod.initContainers ?? []), ...pod.containers]) {
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
      if (probe) say(ports.includes((probe.httpGet ?? probe.tcpSocket).port), `probe of port ${(probe.httpGet ?? probe.tcpSocket).port}`);
    const environment = (container.env ?? []).map((/** @type {Thing} */ one) => one.name);
    for (const [, variable] of container.args.join(' ').matchAll(/\$\((\w+)\)/g))
      say(environment.includes(variable), `$(${variable}) is not set`);
    for (const one of container.env ?? []) {
      const secret = one.valueFrom?.secretKeyRef;
      if (secret)
        say(
          new RegExp(`create secret generic ${secret.name} (--from-literal=\\S+ )*--from-literal=${secret.key}=`).test(instructions),
          `secret ${secret.name} with ${secret.key}: has no instructions to create it`,
        );
    }
    if (!container.image.startsWith('laglab')) continue;
    const [verb, ...rest] = container.args,
      help = spawnSync(BINARY, [verb, '--help'], { encoding: 'utf8' });
    say(help.status === 0, `laglab ${verb}`);
    if (rest.join(' ').includes('--shard auto'))
      say(
        workload.spec.completionMode === 'Indexed' &&
          container.env.some((/** @type {Thing} */ one) => one.name === 'LAGLAB_SHARDS' && Number(one.value) === workload.spec.completions),
        'must be an indexed job with a pod for each of LAGLAB_SHARDS',
      );
    for (const option of rest.filter((/** @type {string} */ word) => word.startsWith('--')))
      say(help.stdout.includes(`${option} `) || help.stdout.includes(`${option}\n`), `laglab ${verb} ${option}`);
  }
  return problems;
}

/** @param {Thing[]} all @param {string} instructions @returns {string[]} */
export function problems(all, instructions) {
  const claims = all.filter((thing) => thing.kind === 'PersistentVolumeClaim').map((thing) => thing.metadata.name);
  const found = pods(all).flatMap((workload) => podProblems(workload, claims, instructions));
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
    if (kind === 'Deployment') say(selects(spec.selector.matchLabels, thing), `${name}: does not select its own pods`);
    if (kind === 'HorizontalPodAutoscaler') {
      const { kind: of, name: target } = spec.scaleTargetRef,
        workload = all.find((other) => other.kind === of && other.metadata.name === target);
      say(
        workload?.spec.replicas >= spec.minReplicas && workload?.spec.replicas <= spec.maxReplicas,
        `${name}: scales no workload, or out of its limits`,
      );
    }
    if (kind === 'Job')
      say(
        spec.backoffLimitPerIndex === undefined || spec.template.spec.restartPolicy === 'Never',
        `${name}: backoffLimitPerIndex needs restartPolicy Never`,
      );
  }
  return found;
}
