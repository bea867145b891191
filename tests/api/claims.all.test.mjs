// The paper's claims whose experiments take longest; the others are in claims.test.mjs.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { along, points, rises } from '../lib/claims.mjs';

test('rewind limit: more hits behind cover, fewer hits that do not count', () => {
  const rows = points('rewind_cover');
  const behind = along(rows, {}, 'players.1.shots.hitscan.shot_behind_cover'),
    missed = along(rows, {}, 'players.1.shots.hitscan.false_misses');
  // without rewinding only a victim that is hit while its own view, ahead of the server, shows it hidden
  assert.ok(rises(behind) && behind[0] < 0.5 && behind[6] > 20, String(behind));
  assert.ok(missed[0] > 50 && missed[6] === 0, String(missed));
});

test('policies of lag compensation: the shooter bears the lag, its victims, or both by its amount', () => {
  const rows = points('lag_policies');
  const of = (/** @type {string} */ policy, /** @type {string} */ metric) =>
    along(rows, { 'server.hitscan': policy }, `players.1.shots.${metric}`);
  const [none, rewind, hybrid, veto] = ['none', 'rewind', 'hybrid', 'victim_veto'].map((policy) => ({
    favour: of(policy, 'hitscan.favour_the_shooter'),
    longest: of(policy, 'behind_cover_ms.max'),
    hits: of(policy, 'behind_cover_ms.count'),
  }));
  assert.ok(none.favour[4] < none.favour[0] - 0.3, String(none.favour));
  assert.ok(rewind.favour.every((value) => value > 0.99) && rises(rewind.longest), String(rewind.longest));
  assert.ok(hybrid.favour[0] === rewind.favour[0] && hybrid.favour[4] === none.favour[4], String(hybrid.favour));
  for (let i = 0; i < 5; i++) {
    assert.ok(hybrid.favour[i] >= none.favour[i] && hybrid.favour[i] <= rewind.favour[i]);
    // A's own two ways of 40 ms, the grace of 100 ms, four ticks and an update
    assert.ok(veto.longest[i] <= 280 && veto.hits[i] <= rewind.hits[i], String(veto.longest));
  }
});

test('transports against loss: one stream holds up what is behind a lost message, datagrams do not', () => {
  const rows = points('transports'),
    loss = 'players.0.link.up.loss_pct',
    T = 1000 / 30;
  const age = (/** @type {string} */ transport, part = 'mean') =>
    along(rows, { 'server.transport': transport }, `players.0.age_of_information_ms.${part}`);
  const pct = along(rows, { 'server.transport': 'udp' }, loss);
  assert.deepEqual(pct, [0, 0.5, 1, 2, 3, 5]);
  for (const transport of ['tcp', 'quic', 'webrtc'])
    assert.ok(Math.abs(age(transport)[0] - age('udp')[0]) < 1e-6, `without loss ${transport} is as fast as udp`);
  for (const [i, percent] of pct.entries()) {
    // The newest of states that arrive every T, each with probability 1 - p: mean age d + T / 2 (1 + p) / (1 - p).
    const p = percent / 100,
      more = (T / 2) * ((1 + p) / (1 - p) - 1);
    for (const transport of ['udp', 'webrtc'])
      assert.ok(Math.abs(age(transport)[i] - age(transport)[0] - more) < 0.4, `${transport} ${percent} %: ${age(transport)}`);
    if (i > 0) assert.ok(age('tcp')[i] > age('quic')[i] && age('quic')[i] > age('udp')[i] + 1, `${percent} %`);
    // A lost state is sent again when three later ones were acknowledged: it and those behind it are up to 3 T + R late.
    if (i > 0) assert.ok(age('tcp', 'p99')[i] > age('tcp', 'p99')[0] + 0.5 * (3 * T + 100));
  }
});
