// Decodes binary frames by nothing but the layout table of asyncapi.yaml.
const READ = {
  u8: (b, at) => b.readUInt8(at), u16: (b, at) => b.readUInt16LE(at), u32: (b, at) => b.readUInt32LE(at),
  i32: (b, at) => b.readInt32LE(at),
  u64: (b, at) => Number(b.readBigUInt64LE(at)), i64: (b, at) => Number(b.readBigInt64LE(at)),
  f32: (b, at) => b.readFloatLE(at), f64: (b, at) => b.readDoubleLE(at),
};

/** @returns {any} */
function record(fields, buffer, at) {
  const value = {};
  for (const field of fields) {
    value[field.name] = READ[field.type](buffer, at + field.offset);
    if (field.nullable && Number.isNaN(value[field.name])) value[field.name] = null;
    for (const [name, { shift, bits, values }] of Object.entries(field.words ?? {})) {
      value[name] = values[(value[field.name] >> shift) & ((1 << bits) - 1)];
    }
    if ('const' in field && value[field.name] !== field.const) throw new Error(`${field.name} is ${value[field.name]}`);
  }
  return value;
}

function records(section, { count, bytes }, buffer, at) {
  const stride = count ? bytes / count : 0;
  return Array.from({ length: count }, (_, i) => {
    const from = at + i * stride;
    if (section.columns) return Array.from({ length: stride / 8 }, (__, k) => READ[section.columns](buffer, from + 8 * k));
    const value = record(section.fields, buffer, from);
    if (section.items) {
      const { name, bytes: size, fields, type } = section.items;
      const item = (at) => (fields ? record(fields, buffer, at) : READ[type](buffer, at));
      value[name] = Array.from({ length: value[name] }, (__, k) => item(from + section.bytes + k * size));
      if (section.bytes + value[name].length * size !== stride) throw new Error(`a record of ${section.name} has ${stride} bytes`);
    } else if (stride !== section.bytes && count) throw new Error(`a record of ${section.name} has ${stride} bytes`);
    return value;
  });
}

/** @param {any} layout x-layout of the binary frame @param {Buffer} buffer */
export function decodeFrame(layout, buffer) {
  const frame = record(layout.header.fields, buffer, 0);
  let at = layout.header.bytes;
  for (let i = 0; i < frame.sections; i++) {
    if (at % 8 !== 0) throw new Error(`section ${i} begins at ${at}`);
    const head = record(layout.sectionHeader.fields, buffer, at);
    const section = layout.sections.find((each) => each.type === head.type);
    at += layout.sectionHeader.bytes;
    if (section) frame[section.name] = records(section, head, buffer, at);
    at += head.bytes;
  }
  if (at !== buffer.length) throw new Error(`${buffer.length - at} bytes are left`);
  return frame;
}
