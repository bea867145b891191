// Captures of packets, read by tshark: what it counts is what the metrics count.
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
  'frame.len',
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

/** What tshark says of a file; its checks of checksums are on. @param {string} file */
function read(file) {
  const options = ['-n', '-r', file, '-o', 'ip.check_checksum:TRUE', '-o', 'udp.check_checksum:TRUE'];
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
      const [at, time, from, to, bytes, checksum, direction, comment] = line.split('|');
      return {
        at,
        time_s: Number(time) - EPOCH_S,
        from,
        to,
        bytes: Number(bytes),
        good: checksum === '1',
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

/** @param {any} table of `bandwidth` @param {string[]} types @param {string} column */
const total = (table, types, column) => types.reduce((sum, type) => sum + table[type][column], 0);

test('tshark counts the packets and bytes that the metrics count', () => {
  const S = 7;
  const { metrics, packets } = run(
    'race',
    '--duration',
    String(S),
    '--set',
    'players.0.link.up.loss_pct=20',
    '--set',
    'players.1.lag_ms=0',
    '--set',
    'players.1.link.down.duplicate_pct=10',
  );
  assert.ok(packets.length > 2000);
  for (const [i, player] of metrics.players.entries()) {
    const address = `198.51.100.${i + 1}`;
    const up = packets.filter((p) => p.sent && p.from === address),
      down = packets.filter((p) => p.sent && p.to === address);
    const b = player.bandwidth;
    /** @param {{bytes: number}[]} list */
    const bytes = (list) => list.reduce((sum, p) => sum + p.bytes, 0);
    assert.equal(up.length / S, total(b, ['input', 'connect', 'ping'], 'packets_per_s'));
    assert.equal(down.length / S, total(b, ['state', 'refusal', 'relay', 'accept', 'pong'], 'packets_per_s'));
    assert.ok(Math.abs(bytes(up) / S - b.up_bytes_per_s) < 0.1, `${bytes(up) / S} ${b.up_bytes_per_s}`);
    assert.ok(Math.abs(bytes(down) / S - b.down_bytes_per_s) < 0.1, `${bytes(down) / S} ${b.down_bytes_per_s}`);
    assert.equal(up.filter((p) => p.comment.endsWith('; lost')).length, player.link_up.lost);
    assert.equal(
      packets.filter((p) => !p.sent && p.to === address && p.comment.endsWith('; duplicate')).length,
      player.link_down.duplicated,
    );
  }
  assert.ok(packets.every((p) => p.good));
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
    const times = new Map(sent.map((p) => [p.comment, p.time_s]));
    for (const p of came.filter((one) => times.has(one.comment)))
      assert.ok(Math.abs(p.time_s - times.get(p.comment) - Number(lag_s)) < 1e-6);
  }
  for (let i = 1; i < packets.length; i++) assert.ok(packets[i].time_s >= packets[i - 1].time_s, 'in the order of time');
});

/** Fields of every packet of a file, by tshark. @param {string} file @param {string[]} fields @param {string} filter */
function fieldsOf(file, fields, filter = 'ip') {
  const options = ['-n', '-r', file, '-o', 'tcp.check_checksum:TRUE', '-Y', filter, '-T', 'fields', '-E', 'separator=|'];
  const result = spawnSync('tshark', [...options, ...fields.flatMap((field) => ['-e', field])], { encoding: 'utf8', maxBuffer: 1 << 28 });
  assert.equal(result.status, 0, result.stderr);
  return result.stdout
    .split('\n')
    .filter(Boolean)
    .map((line) => line.split('|'));
}

test('packets of every transport have the bytes that the metrics count', () => {
  const S = 8;
  for (const transport of ['tcp', 'quic', 'webrtc']) {
    const { metrics, file } = run(
      'race',
      '--duration',
      String(S),
      '--set',
      `server.transport=${transport}`,
      '--set',
      'players.0.link.up.loss_pct=6',
      '--set',
      'players.1.link.down.loss_pct=3',
    );
    const all = fieldsOf(file, ['ip.src', 'ip.dst', 'frame.packet_flags_direction', 'frame.len', 'frame.comment']);
    for (const [i, player] of metrics.players.entries())
      for (const [end, direction] of ['up', 'down'].entries()) {
        const rows = all.filter((row) => row[end] === `198.51.100.${i + 1}` && Number(row[2]) === 2);
        const said = `${transport} ${direction} of player ${i}`;
        assert.equal(rows.length, player[`link_${direction}`].sent, said);
        assert.equal(rows.filter((row) => row[4].endsWith('; lost')).length, player[`link_${direction}`].lost, said);
        const bytes = rows.reduce((sum, row) => sum + Number(row[3]), 0) / S;
        assert.ok(Math.abs(bytes - player.bandwidth[`${direction}_bytes_per_s`]) < 0.1, said);
      }
  }
});

test("tshark's analysis of TCP finds what was sent again, in order, with right checksums", () => {
  const { file } = run(
    'race',
    '--duration',
    '12',
    '--set',
    'server.transport=tcp',
    '--set',
    'players.1.link.up.loss_pct=5',
    '--pcap-at',
    'B',
  );
  const B = 'ip.src == 198.51.100.2';
  const places = fieldsOf(file, ['frame.interface_name']);
  assert.ok(places.every(([name]) => name === 'player B'));
  const rows = fieldsOf(file, ['tcp.seq', 'tcp.len', 'tcp.checksum.status', 'frame.comment', 'tcp.analysis.retransmission'], B);
  assert.ok(rows.length > 600 && rows.every((row) => row[2] === '1'));
  const again = rows.filter((row) => row[3].includes('sent again'));
  assert.ok(again.length > 10);
  // Each is one for tshark, too; of an odd few it says that they were out of order or not needed, by their times.
  const found = fieldsOf(
    file,
    ['frame.comment'],
    `${B} && (${['retransmission', 'fast_retransmission', 'spurious_retransmission', 'out_of_order']
      .map((what) => `tcp.analysis.${what}`)
      .join(' || ')})`,
  );
  assert.deepEqual(
    found.map(([comment]) => comment),
    again.map((row) => row[3]),
  );
  // A stream without gaps at its sender: a new segment begins where those before have ended, one that is sent again before that.
  let end = Number(rows[0][0]);
  for (const [seq, length, , comment] of rows.filter((row) => Number(row[1]) > 0)) {
    assert.equal(Number(seq) === end, !comment.includes('sent again'), comment);
    assert.ok(Number(seq) <= end, comment);
    end = Math.max(end, Number(seq) + Number(length));
  }
  // Every acknowledgement is of bytes that were sent.
  const acks = fieldsOf(file, ['tcp.ack'], 'ip.dst == 198.51.100.2').map(([ack]) => Number(ack));
  assert.ok(acks.every((ack, i) => ack <= end && (i === 0 || ack >= acks[i - 1])));
});

test('a segment of TCP that a link splits, and an interface that there is not, are refused', async () => {
  const refused = (/** @type {string[]} */ ...more) => {
    const file = path.join(folder, 'refused.pcapng');
    const result = spawnSync(BINARY, ['run', 'race', '--duration', '1', '--pcap', file, ...more], { encoding: 'utf8' });
    assert.notEqual(result.status, 0);
    return result.stderr;
  };
  const split = ['--set', 'server.transport=tcp', '--set', 'players.0.link.down.mtu_bytes=90'];
  assert.match(refused(...split), /packets: mtu_bytes must be at least \d+, or 0, with transport tcp/);
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
  const bad = packets.filter((p) => !p.good);
  assert.equal(bad.length, packets.filter((p) => !p.sent && p.comment.endsWith('arrives corrupted')).length);
  assert.ok(bad.length > 10 && bad.every((p) => p.from === '198.51.100.4'));
  const split = packets.filter((p) => p.sent && p.to === '198.51.100.3' && p.comment.includes('fragment 1 of '));
  assert.equal(split.length, metrics.players[2].link_down.split);
  const first = packets.filter((p) => p.sent && p.to === '198.51.100.3' && p.comment.startsWith(`${split[5].comment.split(';')[0]};`));
  assert.ok(first.slice(0, -1).every((p) => p.bytes === 28 + 4 + 100));
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
