// Decodes the binary stream, laglab.v2.bin, by the tables: nothing here knows a field.
import { RECORDS } from './records.js';

/** @typedef {import('./records.js').Layout} Layout */
/** @typedef {import('./records.js').Field} Field */

/** Flags of a frame. */
export const PLAYING = 2,
  ENDED = 4,
  BEHIND = 8,
  FAILED = 16,
  JUMP = 32;

const INTEGER_MAX = 2 ** 51 - 1,
  NONE = -(2 ** 51); /* the infinities and unknown values */
const ROWS_MAX = 2 ** 21,
  MASK_BITS = 49;
const POWERS = Float64Array.from({ length: 53 }, (_, bits) => 2 ** bits),
  /** By the exponent of a number's bits: a look-up takes a small part of the time of a power. */
  SCALES = Float64Array.from({ length: 2047 }, (_, exponent) => 2 ** (exponent - 1023));

/** The stream must be opened again: the bytes are none that this decoder understands. */
export class StreamError extends Error {}

/** Bytes from front to back. */
class Reader {
  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }

  get done() {
    return this.at >= this.bytes.length;
  }

  /** @returns {number} */
  byte() {
    const value = this.bytes[this.at++];
    if (value === undefined) throw new StreamError('the bytes end too early');
    return value;
  }

  /** Below 2^53. By arithmetic: shifts end at 32 bits. @returns {number} */
  varint() {
    let byte = this.byte();
    if (byte < 128) return byte;
    let value = byte - 128,
      scale = 128;
    do {
      byte = this.byte();
      value += (byte % 128) * scale;
      scale *= 128;
      if (scale > 2 ** 56) throw new StreamError('a number has more than 8 bytes');
    } while (byte >= 128);
    if (value > Number.MAX_SAFE_INTEGER) throw new StreamError('a number is 2^53 or more');
    return value;
  }

  /** @returns {number} */
  zigzag() {
    const value = this.varint();
    return value % 2 === 0 ? value / 2 : -(value + 1) / 2;
  }

  /** @param {number} size @returns {Uint8Array} */
  take(size) {
    if (size > this.bytes.length - this.at) throw new StreamError('the bytes end too early');
    this.at += size;
    return this.bytes.subarray(this.at - size, this.at);
  }
}

/** The value of an integer. @param {Field} field @param {number} n @returns {number} */
export function valueOf(field, n) {
  if (field.coding === 'int') return n;
  if (n === NONE) return NaN;
  if (Math.abs(n) === INTEGER_MAX) return n < 0 ? -Infinity : Infinity;
  const unit = /** @type {number} */ (POWERS[field.bits ?? 0]);
  if (field.coding === 'step') return n / unit;
  const size = Math.abs(n),
    exponent = Math.floor(size / unit),
    mantissa = size / unit - exponent;
  const value =
    exponent === 0 ? mantissa * 2 ** -1022 : exponent === 2047 ? Infinity : (1 + mantissa) * /** @type {number} */ (SCALES[exponent]);
  return n < 0 ? -value : value;
}

/** The last rows of a record: integers, and objects on request. */
export class Section {
  /** @param {Layout} layout @param {number} count */
  constructor(layout, count) {
    this.layout = layout;
    this.count = count;
    this.values = new Float64Array(count * layout.fields.length);
    this.first = 0; /* of a log: the number of the first row */
    this.lost = 0; /* and how many before it did not come */
    /** Of a grid: of each row. @type {Uint8Array[]} */
    this.planes = [];
    /** @type {any[] | null} */
    this.objects = null;
    /** @type {Map<string, Float64Array>} */
    this.columns = new Map();
    /** By field, by its value. @type {Map<string, Map<number, any[]>>} */
    this.groups = new Map();
  }

  /** The rows in which a field has a value. @param {string} field @param {number} value @returns {any[]} */
  where(field, value) {
    let groups = this.groups.get(field);
    if (!groups) {
      groups = new Map();
      for (const row of this.rows()) {
        const group = groups.get(row[field]);
        if (group) group.push(row);
        else groups.set(row[field], [row]);
      }
      this.groups.set(field, groups);
    }
    return groups.get(value) ?? [];
  }

  /** Values of a field, row by row: for records of many rows. @param {string} name @returns {Float64Array} */
  column(name) {
    const known = this.columns.get(name);
    if (known) return known;
    const { fields } = this.layout,
      width = fields.length,
      k = fields.findIndex((field) => field.name === name);
    const field = /** @type {Field} */ (fields[k]),
      column = new Float64Array(this.count),
      { values } = this;
    for (let i = 0, at = k; i < this.count; i++, at += width) column[i] = valueOf(field, /** @type {number} */ (values[at]));
    this.columns.set(name, column);
    return column;
  }

  /** An object of each row. @returns {any[]} */
  rows() {
    return (this.objects ??= Array.from({ length: this.count }, (_, i) => this.row(i)));
  }

  /** @param {number} i */
  row(i) {
    const { fields } = this.layout,
      from = i * fields.length;
    /** @type {any} */
    const row = this.layout.form === 'log' ? { id: this.first + i } : {};
    fields.forEach((field, k) => {
      const value = valueOf(field, /** @type {number} */ (this.values[from + k]));
      row[field.name] = field.boolean ? value !== 0 : value;
    });
    if (this.planes[i]) row.values = this.planes[i];
    return row;
  }
}

/** @param {Reader} reader @param {Float64Array} values @param {number} from of the row @param {number} width */
function applyChanges(reader, values, from, width) {
  let mask = reader.varint();
  for (let k = 0; mask > 0; k++, mask = Math.floor(mask / 2)) {
    if (k >= MASK_BITS) throw new StreamError('a row has too many fields');
    if (mask % 2 === 0) continue;
    const change = reader.zigzag();
    if (k < width)
      values[from + k] = /** @type {number} */ (values[from + k]) + change; /* a field that is newer than the table is skipped */
  }
}

/** Where each row starts from: the one that it was, or -1: it is new.
 * @param {Reader} reader @param {Layout} layout @param {Section | null} base @returns {number[]} */
function origins(reader, layout, base) {
  const old = base?.count ?? 0;
  if (layout.form !== 'keyed') {
    const count = limited(reader.varint());
    return Array.from({ length: count }, (_, i) => (i < old ? i : -1));
  }
  /** @type {number[]} */
  const from = [];
  let was = 0;
  for (let runs = reader.varint(); runs > 0; runs--) {
    const copied = reader.varint(),
      dropped = reader.varint(),
      added = reader.varint();
    if (copied + dropped + added === 0 || was + copied + dropped > old) throw new StreamError('a run leaves its rows');
    limited(from.length + copied + added);
    for (let i = 0; i < copied; i++) from.push(was++);
    was += dropped;
    for (let i = 0; i < added; i++) from.push(-1);
  }
  if (was !== old) throw new StreamError('the runs leave rows over');
  return from;
}

/** @param {number} count */
function limited(count) {
  if (count > ROWS_MAX) throw new StreamError('too many rows');
  return count;
}

/** By a loop: a row is short, and a call of the engine costs more than what it copies. @param {Float64Array} from @param {number} first
 * @param {Float64Array} to @param {number} at @param {number} width */
function copyRow(from, first, to, at, width) {
  for (let k = 0; k < width; k++) to[at + k] = /** @type {number} */ (from[first + k]);
}

/** @param {Reader} reader @param {Layout} layout @param {Section | null} base @returns {Section} */
function readRows(reader, layout, base) {
  const from = origins(reader, layout, base),
    width = layout.fields.length;
  const section = new Section(layout, from.length),
    { values } = section;
  let changed = reader.varint(),
    skip = changed > 0 ? reader.varint() : -1;
  from.forEach((was, i) => {
    const at = i * width;
    if (was >= 0 && base) copyRow(base.values, was * width, values, at, width);
    else if (i > 0) copyRow(values, at - width, values, at, width);
    if (changed === 0 || skip-- > 0) return;
    applyChanges(reader, values, at, width);
    changed--;
    skip = changed > 0 ? reader.varint() : -1;
  });
  if (changed > 0) throw new StreamError('more rows changed than there are');
  return section;
}

/** @param {Reader} reader @param {Layout} layout @returns {Section} */
function readLog(reader, layout) {
  const lost = reader.varint(),
    first = reader.varint(),
    width = layout.fields.length;
  const section = new Section(layout, limited(reader.varint()));
  section.lost = lost;
  section.first = first;
  for (let i = 0; i < section.count; i++) {
    const { values } = section,
      at = i * width;
    if (i > 0) copyRow(values, at - width, values, at, width);
    applyChanges(reader, values, at, width);
  }
  return section;
}

/** @param {Reader} reader @param {Section} section @param {Section | null} base */
function readPlanes(reader, section, base) {
  const width = section.layout.fields.length;
  for (let i = 0; i < section.count; i++) {
    const columns = /** @type {number} */ (section.values[i * width]),
      size = columns * /** @type {number} */ (section.values[i * width + 1]);
    const coding = reader.byte(),
      plane = reader.take(size).slice(),
      before = base?.planes[i];
    if (coding > 1 || (coding === 1 && before?.length !== size)) throw new StreamError('a plane has an unknown coding, or no base');
    if (coding === 1 && before) {
      for (let k = 0, change = 0; k < size; k++) {
        const coded = /** @type {number} */ (plane[k]);
        change = (coded + (k % columns === 0 ? 0 : change)) % 256;
        plane[k] = /** @type {number} */ (before[k]) + change;
      }
    }
    section.planes.push(plane);
  }
}

/** A section's body. @param {Layout} layout @param {Section | null} base the section that it is a delta of; null: it is whole
 * @param {Uint8Array} bytes
 * @returns {Section} */
export function readSection(layout, base, bytes) {
  const reader = new Reader(bytes);
  const section = layout.form === 'log' ? readLog(reader, layout) : readRows(reader, layout, base);
  if (layout.form === 'grid') readPlanes(reader, section, base);
  if (!reader.done) throw new StreamError('bytes are left over');
  return section;
}

/** @param {Uint8Array} bytes raw deflate @returns {Promise<Uint8Array>} */
async function inflate(bytes) {
  /* Not by way of a Blob: that lies in another process. */
  const { readable, writable } = new DecompressionStream('deflate-raw'),
    writer = writable.getWriter(),
    answer = new Response(readable).arrayBuffer();
  await Promise.all([writer.write(/** @type {Uint8Array<ArrayBuffer>} */ (bytes)), writer.close(), answer]);
  return new Uint8Array(await answer);
}

/** One frame: its head, and the rows of each record as of then. Those of a log are the frame's own. */
export class FrameBase {
  /** @param {number} flags @param {number} seq @param {number} tick @param {number} tickHz @param {Map<string, Section>} sections */
  constructor(flags, seq, tick, tickHz, sections) {
    this.flags = flags;
    this.seq = seq;
    this.tick = tick;
    this.time_s = tick / tickHz;
    this.tickHz = tickHz;
    this.sections = sections;
  }

  /** @param {string} name @returns {any[]} */
  rows(name) {
    return this.sections.get(name)?.rows() ?? [];
  }

  /** Rows of logs that were forgotten before they could be sent. */
  get lost() {
    let lost = 0;
    for (const section of this.sections.values()) lost += section.lost;
    return lost;
  }

  /** Without what it can do, for inspection only. @returns {any} */
  plain() {
    const { flags, seq, tick, time_s } = this;
    return {
      flags,
      seq,
      tick,
      time_s,
      ...Object.fromEntries([...this.sections.keys()].map((name) => [name, /** @type {any} */ (this)[name]])),
    };
  }

  /** The rows of a record in which a field has a value. @param {string} name @param {string} field @param {number} value
   * @returns {any[]} */
  where(name, field, value) {
    return this.sections.get(name)?.where(field, value) ?? [];
  }
}
for (const { name, form } of RECORDS) {
  Object.defineProperty(FrameBase.prototype, name, {
    /** @this {FrameBase} */
    get() {
      return form === 'one' ? this.rows(name)[0] : this.rows(name);
    },
  });
}

/** @typedef {FrameBase & import('./rows.js').Records} Frame */

/** @typedef {{id: number, whole: boolean, bytes: Uint8Array}} Part */

/** The reading end of one stream: it keeps what came last of each record. */
export class Decoder {
  /** @param {readonly Layout[]} records @param {number} tickHz of the session, from the hello
   * @param {(bytes: Uint8Array) => Promise<Uint8Array>} [unpack] raw deflate, where there is another way than a browser's */
  constructor(records, tickHz, unpack = inflate) {
    this.unpack = unpack;
    this.layouts = new Map(records.map((layout) => [layout.id, layout]));
    this.tickHz = tickHz;
    /** @type {Map<string, Section>} */
    this.sections = new Map();
    /** Messages are decoded one after the other, also where one has to be inflated. @type {Promise<unknown> | null} */
    this.busy = null;
  }

  /** What follows is read by tables that are still to come. @param {Promise<readonly Layout[]>} records */
  learn(records) {
    const mine = records
      .then((list) => {
        this.layouts = new Map(list.map((layout) => [layout.id, layout]));
      })
      .catch(() => {})
      .then(() => {
        if (this.busy === mine) this.busy = null;
      });
    this.busy = mine;
  }

  /** Gives the frame to `take`, at once where nothing is to be inflated. `fail` gets a StreamError.
   * @param {ArrayBuffer} bytes @param {(frame: Frame) => void} take @param {(error: unknown) => void} fail */
  decode(bytes, take, fail) {
    const message = new Uint8Array(bytes);
    if (this.busy === null) {
      try {
        const parts = this.split(message);
        if (parts.every(({ deflated }) => !deflated)) {
          take(this.apply(message, parts));
          return;
        }
      } catch (error) {
        fail(error);
        return;
      }
    }
    const mine = (this.busy ?? Promise.resolve())
      .then(async () => {
        const parts = await Promise.all(
          this.split(message).map(async (part) => ({ ...part, bytes: part.deflated ? await this.unpack(part.bytes) : part.bytes })),
        );
        take(this.apply(message, parts));
      })
      .catch(fail)
      .then(() => {
        if (this.busy === mine) this.busy = null;
      });
    this.busy = mine;
  }

  /** @param {Uint8Array} message */
  split(message) {
    const reader = new Reader(message);
    if (reader.byte() !== 1) throw new StreamError('the message is no frame');
    reader.byte();
    reader.varint();
    reader.varint();
    /** @type {(Part & {deflated: boolean})[]} */
    const parts = [];
    while (!reader.done) {
      const id = reader.varint(),
        head = reader.varint();
      parts.push({ id, whole: Math.floor(head / 2) % 2 === 1, deflated: head % 2 === 1, bytes: reader.take(Math.floor(head / 4)) });
    }
    return parts;
  }

  /** @param {Uint8Array} message @param {Part[]} parts @returns {Frame} */
  apply(message, parts) {
    const reader = new Reader(message);
    reader.byte();
    const flags = reader.byte(),
      seq = reader.varint(),
      tick = reader.zigzag();
    const sections = new Map(flags & JUMP ? [] : this.sections);
    for (const name of [...sections.keys()]) if (sections.get(name)?.layout.form === 'log') sections.delete(name);
    for (const { id, whole, bytes } of parts) {
      const layout = this.layouts.get(id);
      if (!layout) continue; /* newer than the table */
      const base = whole ? null : (this.sections.get(layout.name) ?? null);
      if (!whole && base === null && layout.form !== 'log') throw new StreamError(`${layout.name} is a delta to what did not come`);
      sections.set(layout.name, readSection(layout, base, bytes));
    }
    this.sections = sections;
    return /** @type {Frame} */ (new FrameBase(flags, seq, tick, this.tickHz, sections));
  }
}
