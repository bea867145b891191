// Reads binary frames by nothing but api/asyncapi.yaml: the tables of its schemas, and what it says of bytes. Slow and plain, with whole
// numbers of any size: to compare the page's decoder with.
import { inflateRawSync } from 'node:zlib';

const NONE = -(2n ** 51n),
  END = 2n ** 51n - 1n;
const FLAGS = { 2: 'playing', 4: 'ended', 8: 'behind', 16: 'failed', 32: 'jump' };

class Bytes {
  /** @param {Buffer} buffer */
  constructor(buffer) {
    this.buffer = buffer;
    this.at = 0;
  }

  byte() {
    if (this.at >= this.buffer.length) throw new Error('the bytes end');
    return this.buffer[this.at++];
  }

  varint() {
    let value = 0n;
    for (let shift = 0n; ; shift += 7n) {
      if (shift > 49n) throw new Error('a varint of more than 8 bytes');
      const byte = this.byte();
      value |= BigInt(byte & 127) << shift;
      if (byte < 128) return value;
    }
  }

  zigzag() {
    const value = this.varint();
    return value & 1n ? -(value >> 1n) - 1n : value >> 1n;
  }

  number() {
    return Number(this.varint());
  }

  /** @param {number} size */
  take(size) {
    if (this.at + size > this.buffer.length) throw new Error('the bytes end');
    this.at += size;
    return this.buffer.subarray(this.at - size, this.at);
  }

  end() {
    if (this.at !== this.buffer.length) throw new Error(`${this.buffer.length - this.at} bytes are left`);
  }
}

/** What the integers of a field stand for, as a text frame has them. @param {any} property @returns {(n: bigint) => any} */
function meaning(property) {
  const [coding, digits] = property['x-coding'].split(' '),
    bits = BigInt(digits ?? 0),
    scale = 2 ** Number(bits);
  const names = property.enum ?? property.items?.enum,
    numbers = property['x-numbers'] ?? names?.map((_, i) => i);
  if (property.items) return (n) => names.filter((_, i) => (n >> BigInt(numbers[i])) & 1n);
  if (names) return (n) => names[numbers.indexOf(Number(n))];
  if (property.type === 'boolean') return (n) => n !== 0n;
  if (coding === 'int') return Number;
  return (n) => {
    if (n === NONE || n === END || n === -END) return null;
    if (coding === 'step') return Number(n) / scale;
    const size = n < 0n ? -n : n,
      exponent = Number(size >> bits),
      part = Number(size & ((1n << bits) - 1n)) / scale;
    const value = exponent === 0 ? part * 2 ** -1022 : 2 ** (exponent - 1023) * (1 + part);
    return n < 0n ? -value : value;
  };
}

/** @param {Bytes} bytes @param {bigint[]} row */
function change(bytes, row) {
  const mask = bytes.varint();
  for (let k = 0; mask >> BigInt(k); k++) {
    if (!((mask >> BigInt(k)) & 1n)) continue;
    const difference = bytes.zigzag();
    if (k < row.length) row[k] += difference;
  }
}

/** @typedef {{rows: bigint[][], planes: number[][], lost: number, first: number}} Section */

/** @param {any} table @param {Section | undefined} base @param {Bytes} bytes @returns {Section} */
function readSection(table, base, bytes) {
  const zeros = table.fields.map(() => 0n);
  /** @type {Section} */
  const section = { rows: [], planes: [], lost: 0, first: 0 };
  if (table.form === 'log') {
    section.lost = bytes.number();
    section.first = bytes.number();
    for (let left = bytes.number(); left > 0; left--) {
      const row = [...(section.rows.at(-1) ?? zeros)];
      change(bytes, row);
      section.rows.push(row);
    }
    return section;
  }
  /** @type {(bigint[] | undefined)[]} */
  let starts = [];
  const old = base?.rows ?? [];
  if (table.form === 'keyed') {
    let at = 0;
    for (let runs = bytes.number(); runs > 0; runs--) {
      const kept = bytes.number(),
        out = bytes.number(),
        fresh = bytes.number();
      starts.push(...old.slice(at, at + kept), ...new Array(fresh).fill(undefined));
      at += kept + out;
    }
    if (at !== old.length) throw new Error(`${table.name}: runs of ${at} rows, where ${old.length} were`);
  } else {
    const count = bytes.number();
    starts = Array.from({ length: count }, (_, i) => old[i]);
  }
  let changed = bytes.number(),
    skip = changed > 0 ? bytes.number() : -1;
  for (const start of starts) {
    const row = [...(start ?? section.rows.at(-1) ?? zeros)];
    if (skip === 0) {
      change(bytes, row);
      skip = --changed > 0 ? bytes.number() : -1;
    } else {
      skip--;
    }
    section.rows.push(row);
  }
  if (changed !== 0) throw new Error(`${table.name}: ${changed} more rows changed than there are`);
  if (table.form === 'grid')
    section.rows.forEach((row, i) => section.planes.push(readPlane(Number(row[0]), Number(row[1]), base?.planes[i], bytes)));
  return section;
}

/** @param {number} width @param {number} height @param {number[] | undefined} base @param {Bytes} bytes */
function readPlane(width, height, base, bytes) {
  const coding = bytes.byte(),
    plane = [...bytes.take(width * height)];
  if (coding === 0) return plane;
  if (coding !== 1 || base?.length !== plane.length) throw new Error(`a plane of coding ${coding}`);
  for (let y = 0; y < height; y++)
    for (let x = 1; x < width; x++) plane[y * width + x] = (plane[y * width + x] + plane[y * width + x - 1]) % 256;
  return plane.map((value, i) => (value + base[i]) % 256);
}

/** The reading end of a stream by the parsed document: `read` gives each frame as its text twin has it, all records that came until now but
 * for the events, which are the frame's. @param {any} api */
export function reader(api) {
  const tables = new Map(
    Object.values(api.components.schemas)
      .filter((schema) => schema['x-record'])
      .map((schema) => {
        const { id, name, form } = schema['x-record'];
        const fields = Object.entries(schema.properties).filter(([, property]) => property['x-coding']);
        const values = fields.map(([, property]) => meaning(property));
        return [id, { id, name, form, fields, values }];
      }),
  );
  /** @type {Map<number, Section>} */
  const kept = new Map();
  return {
    tables,
    /** @param {Buffer} buffer @returns {any} */
    read(buffer) {
      const bytes = new Bytes(buffer);
      if (bytes.byte() !== 1) throw new Error('this is no frame');
      const flags = bytes.byte(),
        seq = bytes.number(),
        tick = Number(bytes.zigzag());
      const jump = (flags & 32) !== 0;
      if (jump) kept.clear();
      for (const [id, { form }] of tables) if (form === 'log' && kept.has(id)) kept.set(id, { rows: [], planes: [], lost: 0, first: 0 });
      const whole = new Set();
      while (bytes.at < buffer.length) {
        const id = bytes.number(),
          head = bytes.number(),
          table = tables.get(id);
        const body = bytes.take(Math.floor(head / 4)),
          inner = new Bytes(head & 1 ? inflateRawSync(body) : body);
        if (!table) throw new Error(`record ${id} is in no schema`);
        if (head & 2) whole.add(table.name);
        else if (!kept.has(id)) throw new Error(`${table.name} is a delta to what did not come`);
        kept.set(id, readSection(table, head & 2 ? undefined : kept.get(id), inner));
        inner.end();
      }
      const frame = {
        type: 'frame',
        seq,
        tick,
        flags: Object.entries(FLAGS)
          .filter(([bit]) => flags & Number(bit))
          .map(([, name]) => name),
        whole,
        lost: 0,
      };
      for (const [id, section] of kept) {
        const { name, form, fields, values } = tables.get(id);
        if (form === 'log') frame.lost = section.lost;
        const make = () =>
          section.rows.map((row, i) => ({
            ...(form === 'log' ? { id: section.first + i } : {}),
            ...Object.fromEntries(fields.map(([field], k) => [field, values[k](row[k])])),
            ...(form === 'grid' ? { values: section.planes[i] } : {}),
          }));
        /** @type {any[] | undefined} */
        let rows; // made when they are read: most are in some frames only
        Object.defineProperty(frame, name, { enumerable: true, get: () => (rows ??= make()) });
      }
      return frame;
    },
  };
}
