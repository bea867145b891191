// Texts inside a PNG: iTXt chunks (PNG, third edition, 11.3.3.4), which are UTF-8, before the end of the file.

const SIGNATURE = 8,
  IEND = 12; /* bytes of the last chunk: length, type, CRC */

/** CRC-32 of ISO 3309, as PNG has it. @param {Uint8Array} bytes */
function crc(bytes) {
  let sum = 0xffffffff;
  for (const byte of bytes) {
    sum ^= byte;
    for (let bit = 0; bit < 8; bit++) sum = sum & 1 ? (sum >>> 1) ^ 0xedb88320 : sum >>> 1;
  }
  return ~sum >>> 0;
}

/** @param {string} keyword @param {string} text */
function chunk(keyword, text) {
  const body = new TextEncoder().encode(`iTXt${keyword}\0\0\0\0\0${text}`); /* not compressed, no language */
  const made = new Uint8Array(body.length + 8),
    view = new DataView(made.buffer);
  view.setUint32(0, body.length - 4);
  made.set(body, 4);
  view.setUint32(body.length + 4, crc(body));
  return made;
}

/** @param {Blob} png @param {Record<string, string>} texts by keyword: Title, Description, Software, Source @returns {Promise<Blob>} */
export async function withTexts(png, texts) {
  const bytes = new Uint8Array(await png.arrayBuffer());
  if (bytes.length < SIGNATURE + IEND) return png;
  const chunks = Object.entries(texts).map(([keyword, text]) => chunk(keyword, text));
  return new Blob([bytes.subarray(0, bytes.length - IEND), ...chunks, bytes.subarray(bytes.length - IEND)], { type: 'image/png' });
}
