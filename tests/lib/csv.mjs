// CSV as laglab writes it.
import assert from 'node:assert/strict';

/** RFC 4180, nothing forgiven: records end with CRLF, and a quote stands at the beginning and the end of a field only.
 * @param {string} text @returns {string[][]} */
export function parseCsv(text) {
  const rows = [];
  let row = [],
    at = 0;
  while (at < text.length) {
    const field = /(?:"((?:[^"]|"")*)"|([^",\r\n]*))(,|\r\n)/y;
    field.lastIndex = at;
    const found = field.exec(text);
    assert.ok(found, `not CSV at ${at}: ${JSON.stringify(text.slice(at, at + 40))}`);
    row.push(found[1] === undefined ? found[2] : found[1].replaceAll('""', '"'));
    at = field.lastIndex;
    if (found[3] === '\r\n') {
      rows.push(row);
      row = [];
    }
  }
  assert.deepEqual(row, [], 'the last record ends like all');
  return rows;
}
