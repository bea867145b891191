// Captures of packets, read by tshark: what it counts is what the metrics count, as docs/links.md says.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { client } from '../lib/client.mjs';
import { BINARY, startDaemon } from '../lib/daemon.mjs';

const FIELDS = [
  'frame.interface_name',
  'frame.time_epoch',
  'ip.src',
  'ip.dst',
  'ip.id',
  'udp.srcport',
  'udp.dstport',
  'frame.len',
  'ip.len',
  'udp.length',
  'ip.checksum.status',
  'udp.checksum.status',
  'frame.packet_flags_direction',
  'frame.comment',
];
const EPOCH_S = Date.UTC(2000, 0, 1) / 1000;

let daemon, c;
const folder = mkdtempSync(path.join(tmpdir(), 'laglab-packets-'));
before(async () => {
  daemon = await startDaemon();
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** What tshark says of a file, which checks the sums and does not take a length of 0 for that of the frame. @param {string} file */
function read(file) {
  const settings = ['ip.check_checksum:TRUE', 'udp.check_checksum:TRUE', 'ip.tso_support:FALSE'],
    options = ['-n', '-r', file, ...settings.flatMap((one) => ['-o', one])];
  const result = spawnSync('tshark', [...options, '-T', 'fields', '-E', 'separator=|', ...FIELDS.flatMap((field) => ['-e', field])], {
    encoding: 'utf8',
    maxBuffer: 1 << 28,
  });
  assert.equal(result.status, 0, result.stderr);
  const complaints = result.stderr.split('\n').filter((line) => line && !line.startsWith('Running as user'));
  assert.deepEqual(complaints, []);
  return result.stdout
    .trimEnd()
    .split('\n')
    .map((line) => {
      const [at, time, from, to, id, source, destination, bytes, packet, datagram, ip, udp, direction, comment] = line.split('|');
      assert.equal(ip, '1', 'the checksum of IPv4 is right');
      assert.equal(packet, bytes, 'IPv4 has its length');
      return {
        at,
        time_s: Number(time) - EPOCH_S,
        from,
        to,
        id: Number(id),
        ports: `${source} ${destination}`,
        bytes: Number(bytes),
        payload: Number(datagram) - 8,
        good: udp === '1',
        sent: Number(direction) === 2,
        comment,
      };
    });
}

/** @param {string} scenario @param {string[]} more */
function run(scenario, ...more) {
  const file = path.join(folder, `${scenario}.pcapng`);
  const out = execFileSync(BINARY, ['run', scenario, '--set', 'warmup_s=0', '--pcap', file, ...more], {
    encoding: 'utf8',
    maxBuffer: 1 << 28,
  });
  return { ...JSON.parse(out), packets: read(file), file };
}

/** @typedef {ReturnType<typeof read>} Packets */
const UP = ['input', 'connect', 'ping'],
  DOWN = ['state', 'refusal', 'relay', 'accept', 'pong'];
const bytesOf = (/** @type {Packets} */ list) => list.reduce((sum, p) => sum + p.bytes, 0);
/** How often these comments say so. @param {Packets} list @param {string[]} what */
const said = (list, ...what) => what.reduce((sum, part) => sum + list.filter((p) => p.comment.includes(part)).length, 0);

/** Packets of one direction of player `i`. @param {Packets} packets @param {number} i @param {string} direction */
const ofPlayer = (packets, i, direction) => packets.filter((p) => (direction === 'up' ? p.from : p.to) === `198.51.100.${i + 1}`);

/** The counts of docs/links.md, in each direction of each player. @param {ReturnType<typeof run>} of @param {number} s of the run */
function assertCounts({ metrics, packets }, s) {
  for (const [i, player] of metrics.players.entries())
    for (const direction of ['up', 'down']) {
      const own = ofPlayer(packets, i, direction),
        sent = own.filter((p) => p.sent),
        link = player[`link_${direction}`],
        at = `${direction} of player ${i}`;
      assert.equal(sent.length, link.sent, at);
      assert.equal(said(sent, '; lost', '; copy lost'), link.lost + link.trace_lost, at);
      assert.equal(said(sent, '; dropped', '; copy dropped'), link.queue_drops + link.overflowed, at);
      assert.equal(said(sent, '; corrupted', '; copy corrupted'), link.corrupted, at);
      assert.equal(said(sent, '; duplicated'), link.duplicated, at);
      assert.ok(Math.abs(bytesOf(sent) / s - player.bandwidth[`${direction}_bytes_per_s`]) < 1e-6, at);
    }
}

test('tshark counts the packets and bytes of every transport that the metrics count', () => {
  const S = 6;
  for (const transport of ['udp', 'tcp', 'quic', 'webrtc']) {
    const of = run(
      'race',
      '--duration',
      String(S),
      ...[
        `server.transport=${transport}`,
        'players.0.link.up.loss_pct=20',
        'players.0.link.up.duplicate_pct=30',
        'players.0.link.up.corrupt_pct=6',
        'players.0.link.down.rate_kbps=48',
        'players.0.link.down.limit_packets=2',
        'players.1.link.down.mtu_bytes=90',
        'players.1.link.down.loss_pct=5',
      ].flatMap((one) => ['--set', one]),
    );
    assertCounts(of, S);
    const { link_up, link_down } = of.metrics.players[0],
      split = of.metrics.players[1].link_down;
    assert.ok(link_up.lost > 30 && link_up.duplicated > 50 && link_up.corrupted > 5 && link_down.queue_drops > 5, transport);
    assert.ok(split.fragments > 100 && split.lost > 5, transport);
    assert.ok(of.packets.every((p) => p.good || !p.sent));
    assert.ok(of.packets.every((p) => p.bytes === 28 + p.payload));
    assert.ok(of.packets.every((p) => transport === 'udp' || /^packet(;|$)/.test(p.comment)));
  }
});

test('a link delivers what is received with a right checksum', () => {
  const set = ['players.0.link.up.loss_pct=10', 'players.0.link.up.duplicate_pct=20', 'players.1.link.down.corrupt_pct=10'];
  for (const transport of ['udp', 'quic']) {
    const settings = [`server.transport=${transport}`, ...set].flatMap((one) => ['--set', one]);
    const before = run('race', '--duration', '2', ...settings).metrics, // from then on no packet is older than the file
      { metrics, packets } = run('race', '--duration', '8', ...settings);
    for (const i of [0, 1])
      for (const direction of ['up', 'down']) {
        const came = ofPlayer(packets, i, direction).filter((p) => !p.sent && p.good && p.time_s > 2);
        const [from, to] = [before, metrics].map((m) => m.players[i][`link_${direction}`].delivered);
        assert.equal(came.length, to - from, `${transport} ${direction} of player ${i}`);
      }
  }
});

test('a packet of udp is named as its message is in the metrics, and has its payload', () => {
  const S = 5;
  const { metrics, packets } = run('race', '--duration', String(S), '--set', 'players.1.link.up.loss_pct=20');
  for (const [i, player] of metrics.players.entries())
    for (const [direction, types] of /** @type {[string, string[]][]} */ ([
      ['up', UP],
      ['down', DOWN],
    ])) {
      const sent = ofPlayer(packets, i, direction).filter((p) => p.sent);
      for (const type of types) {
        const own = sent.filter((p) => p.comment.split(';')[0] === type),
          b = player.bandwidth[type];
        assert.equal(own.length / S, b.packets_per_s, type);
        assert.ok(Math.abs(own.reduce((sum, p) => sum + p.payload, 0) / S - b.payload_bytes_per_s) < 1e-6, type);
      }
      assert.ok(sent.every((p) => p.ports === (direction === 'up' ? `${50000 + i} 7777` : `7777 ${50000 + i}`)));
    }
});

test('a packet arrives one lag after it was sent, at the interface of its receiver', () => {
  const { packets } = run('race', '--duration', '4', '--set', 'players.0.lag_ms=85', '--set', 'players.1.lag_ms=210');
  for (const [address, lag_s, name] of [
    ['198.51.100.1', 0.085, 'player A'],
    ['198.51.100.2', 0.21, 'player B'],
  ]) {
    const sent = packets.filter((p) => p.sent && p.from === address),
      came = packets.filter((p) => !p.sent && p.from === address);
    assert.ok(sent.every((p) => p.at === name) && came.every((p) => p.at === 'server'));
    assert.ok(came.length > 200);
    const times = new Map(sent.map((p) => [p.id, p.time_s]));
    for (const p of came) assert.ok(Math.abs(p.time_s - (times.get(p.id) ?? NaN) - Number(lag_s)) < 1e-6);
  }
  for (let i = 1; i < packets.length; i++) assert.ok(packets[i].time_s >= packets[i - 1].time_s, 'in the order of time');
});

test('the file has the packets of one interface, and refuses one that there is not', async () => {
  const all = run('race', '--duration', '3').packets,
    server = run('race', '--duration', '3', '--pcap-at', 'server').packets;
  assert.deepEqual(
    server,
    all.filter((p) => p.at === 'server'),
  );
  const refused = (/** @type {string[]} */ ...more) => {
    const file = path.join(folder, 'refused.pcapng');
    const result = spawnSync(BINARY, ['run', 'race', '--duration', '1', '--pcap', file, ...more], { encoding: 'utf8' });
    assert.notEqual(result.status, 0);
    return result.stderr;
  };
  assert.match(refused('--pcap-at', 'C'), /at: must be one of server, A, B; got `C`/);
  const made = await c.make({ paused: true });
  const answer = await c.get(`${made.links.packets}?at=Q`);
  assert.equal(answer.status, 400);
  assert.equal(answer.json.errors[0].field, 'at');
});

test('a corrupted packet arrives with a wrong checksum, fragments have a header each', () => {
  const { metrics, packets } = run(
    'eight',
    '--duration',
    '3',
    '--set',
    'players.3.link.up.corrupt_pct=25',
    '--set',
    'players.2.link.down.mtu_bytes=100',
  );
  const bad = packets.filter((p) => !p.good),
    damaged = new Set(packets.filter((p) => p.comment.endsWith('; corrupted')).map((p) => p.id));
  assert.ok(bad.length > 10 && bad.every((p) => !p.sent && p.from === '198.51.100.4' && damaged.has(p.id)));
  // Those of one message follow each other: all but the last are full.
  const parts = packets.filter((p) => p.sent && p.to === '198.51.100.3' && p.comment.startsWith('state')),
    { split, fragments } = metrics.players[2].link_down;
  assert.ok(split > 50 && parts.filter((p) => p.payload === 4 + 100).length >= fragments - split);
  assert.ok(parts.every((p) => p.payload <= 4 + 100));
});

test('a session has its packets by HTTP: those of a time, equal to those of a run', async () => {
  const { packets } = run('race', '--seed', '5', '--duration', '6');
  const made = await c.make({ seed: 5, paused: true, set: { warmup_s: 0, duration_s: 6 } });
  await c.control(made, { op: 'seek', time_s: 5 });
  const file = path.join(folder, 'session.pcapng');
  const answer = await fetch(`${daemon.url}${made.links.packets.slice(1)}?from_s=2&to_s=4`);
  assert.equal(answer.status, 200);
  assert.equal(answer.headers.get('content-type'), 'application/x-pcapng');
  writeFileSync(file, Buffer.from(await answer.arrayBuffer()));
  const between = read(file);
  const sent = (/** @type {ReturnType<typeof read>} */ list) =>
    list.filter((p) => p.sent && p.time_s > 2.0001 && p.time_s <= 4).map((p) => `${p.time_s} ${p.from} ${p.bytes} ${p.comment}`);
  assert.ok(between.every((p) => p.time_s >= 2 && p.time_s <= 4));
  assert.deepEqual(sent(between), sent(packets));
  const whole = await fetch(`${daemon.url}${made.links.packets.slice(1)}?from_s=3&to_s=2`);
  assert.equal(whole.status, 400);
  assert.equal((await whole.json()).errors[0].field, 'from_s');
});

test('kinds without packets say so', async () => {
  const result = spawnSync(BINARY, ['run', 'rigid/pyramid', '--duration', '0.1', '--pcap', path.join(folder, 'none.pcapng')], {
    encoding: 'utf8',
  });
  assert.notEqual(result.status, 0);
  assert.match(result.stderr, /packets: the kind must be netgame; got rigid/);
  const made = await c.make({ scenario: 'rigid/pyramid', paused: true });
  const answer = await c.get(made.links.packets);
  assert.equal(answer.status, 409);
  assert.match(answer.json.detail, /packets: the kind must be netgame; got rigid/);
});
