// Holds the page's decoder of binary frames against the text frames of the same instant, for scenarios of every kind.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { client, decodeAll, seqOf, waitFor } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { RECORDS, SCHEMA } from '../../www/js/stream/records.js';

let daemon, c;
before(async () => {
  daemon = await startDaemon({});
  c = client(daemon.url);
});
after(async () => {
  c.close();
  await daemon.stop();
});

/** A value as the text has it. @param {any} field @param {any} value */
function told(field, value) {
  if (field.names) return field.names[value] ?? '';
  if (field.flags)
    return field.flags.filter(
      (/** @type {string} */ name, /** @type {number} */ bit) => name !== '' && Math.floor(value / 2 ** bit) % 2 === 1,
    );
  return typeof value === 'number' && !Number.isFinite(value) ? null : value;
}

/** @param {any} layout @param {any} row */
const rowOf = (layout, row) => ({
  ...(layout.form === 'log' ? { id: row.id } : {}),
  ...Object.fromEntries(layout.fields.map((field) => [field.name, told(field, row[field.name])])),
  ...(row.values ? { values: [...row.values] } : {}),
});

/** Waits until the one has the newest frame of the other. */
const whole = (bin, text) => waitFor(() => bin.frames.length > 0 && seqOf(bin.frames.at(-1)) >= text.frames.at(-1).seq, 'the same frame');

for (const scenario of [
  'race',
  'eight',
  'rifle',
  'rollback',
  'crates',
  'motion/orbit',
  'rigid/bridge',
  'rigid/tumbler',
  'fluid/cylinder',
  'fluid/dam_break',
  'fluid/sea',
]) {
  test(`${scenario}: text and bytes are the same`, async () => {
    const session = await c.make({ scenario, paused: true });
    const bin = await c.stream(session, 'bin', { ack: true }),
      text = await c.stream(session, 'json', { ack: true });
    assert.equal(bin.hello.schema, SCHEMA);
    for (const time_s of [0.4, 0.5, 0.2]) {
      await c.control(session, { op: 'seek', time_s });
      const { json } = await c.get(`/api/v1/sessions/${session.id}`);
      await text.frame((frame) => frame.tick === json.tick);
    }
    await whole(bin, text);
    const read = await decodeAll(bin.frames, bin.hello.tick_hz);
    let compared = 0;
    for (const frame of read) {
      const twin = text.frames.find((one) => one.seq === frame.seq);
      if (!twin) continue;
      assert.equal(frame.tick, twin.tick);
      assert.ok(Math.abs(frame.time_s - twin.time_s) < 2e-9);
      for (const layout of RECORDS) {
        const rows = twin[layout.name];
        if (!rows || layout.form === 'log') continue;
        assert.deepEqual(
          frame.rows(layout.name).map((row) => rowOf(layout, row)),
          rows,
          `${scenario}: ${layout.name} of frame ${frame.seq}`,
        );
      }
      compared++;
    }
    assert.ok(compared >= 3, `${compared} frames compared`);
    await bin.close();
    await text.close();
  });
}

test('events come once each, in both', async () => {
  const session = await c.make({ scenario: 'race' });
  const bin = await c.stream(session, 'bin', { ack: true }),
    text = await c.stream(session, 'json', { ack: true });
  await waitFor(() => text.frames.flatMap((frame) => frame.events ?? []).length > 400, 'events');
  await c.control(session, { op: 'pause' });
  await waitFor(() => !text.frames.at(-1).flags.includes('playing'), 'the last frame');
  await whole(bin, text);
  const byId = new Map(),
    layout = RECORDS.find(({ name }) => name === 'events');
  let next = -1;
  for (const frame of await decodeAll(bin.frames, bin.hello.tick_hz)) {
    for (const event of frame.events) {
      assert.ok(next < 0 || event.id === next, `${event.id} after ${next - 1}`);
      next = event.id + 1;
      byId.set(event.id, rowOf(layout, event));
    }
  }
  const twins = text.frames.flatMap((frame) => frame.events ?? []);
  assert.ok(twins.length > 300, `${twins.length}`);
  for (const event of twins) if (byId.has(event.id)) assert.deepEqual(event, byId.get(event.id));
  await bin.close();
  await text.close();
});
