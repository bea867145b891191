// Transports against theory: the same messages over each, at 0 to 5 % loss. Writes bench/results/transports.md.
// Usage: node bench/transports.mjs [build/laglab]
import { execFileSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';

const LAGLAB = process.argv[2] ?? 'build/laglab';
const LOSSES = [0, 0.5, 1, 2, 3, 5];
const LAG_MS = 50,
  INPUT_MS = 1000 / 60,
  SECONDS = 600;
const WAYS = [
  { name: 'udp', set: ['server.transport=udp'] },
  { name: 'tcp', set: ['server.transport=tcp', 'server.delivery=usual'] },
  { name: 'quic, by type', set: ['server.transport=quic', 'server.delivery=reliable_ordered_by_type'] },
  { name: 'quic, by message', set: ['server.transport=quic', 'server.delivery=reliable_unordered'] },
  { name: 'webrtc', set: ['server.transport=webrtc', 'server.delivery=usual'] },
];

/** @param {string[]} sets @param {number} loss */
function run(sets, loss) {
  const all = [...sets, ...['up', 'down'].map((way) => `players.0.link.${way}.loss_pct=${loss}`)];
  const args = ['run', 'scenarios/transport_tcp.json', '--duration', String(SECONDS), ...all.flatMap((set) => ['--set', set])];
  return JSON.parse(execFileSync(LAGLAB, args, { encoding: 'utf8' })).metrics.players[0];
}

/** First order in the loss p that was met. @param {string} name @param {number} p @returns {{delayed: number, extra: number}} */
function theory(name, p) {
  const round = 2 * LAG_MS,
    three = 3 * INPUT_MS + round;
  const late = name.startsWith('quic') ? Math.min(three, Math.max(INPUT_MS + round, (9 / 8) * round)) : three;
  if (name === 'udp' || name === 'webrtc') return { delayed: 0, extra: 0 };
  if (name === 'quic, by message') return { delayed: p, extra: p * late };
  const n = Math.ceil(late / INPUT_MS - 1e-9);
  return { delayed: 1 - (1 - p) ** n, extra: p * (n * late - (INPUT_MS * n * (n - 1)) / 2) };
}

const rows = [];
for (const way of WAYS) {
  for (const loss of LOSSES) {
    const player = run(way.set, loss),
      link = player.link_up,
      flow = player.transport_up;
    const expected = theory(way.name, link.loss_pct / 100);
    const latency = flow ? flow.latency_ms : { mean: link.delay_mean_ms, p50: LAG_MS, p95: LAG_MS, p99: LAG_MS, max: link.delay_max_ms };
    const lost = flow ? flow.lost / Math.max(1, flow.messages) : link.message_loss_pct / 100;
    rows.push([
      way.name,
      loss,
      latency.mean - LAG_MS,
      expected.extra,
      latency.p50,
      latency.p95,
      latency.p99,
      latency.max,
      100 * (flow?.delayed_ratio ?? 0),
      100 * expected.delayed,
      100 * lost,
      player.bandwidth.up_bytes_per_s,
    ]);
  }
}

const text = (/** @type {string | number} */ value) => (typeof value === 'number' ? String(Math.round(value * 100) / 100) : value);
writeFileSync(
  'bench/results/transports.md',
  `# Transports against theory

Inputs at 60 Hz, ${LAG_MS} ms each way, ${SECONDS} s; latency from sending a message to handing it over, ms. Theory: first order in the loss
that was met, of inputs alone ([Transports](../../docs/transports.md#head-of-line-blocking)). Written by \`node bench/transports.mjs\`.

| transport | loss, % | extra mean | theory | p50 | p95 | p99 | max | delayed, % | theory, % | lost, % | up, B/s |
|---|---|---|---|---|---|---|---|---|---|---|---|
${rows.map((row) => `| ${row.map(text).join(' | ')} |`).join('\n')}
`,
);
