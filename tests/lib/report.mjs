// Reads the data of a report: src/experiment/report/data.h says what is in it.
import { inflateSync } from 'node:zlib';

const inside = (/** @type {string} */ page, /** @type {string} */ id) =>
  new RegExp(`<script type="[^"]*" id="${id}">([^<]*)</script>`).exec(page)?.[1] ?? '';

/** A column: leading bytes of doubles, plane by plane, each value combined with the one before.
 * @param {Buffer} bytes @param {number} at @param {number} count @param {number} planes */
function unpack(bytes, at, count, planes) {
  const value = Buffer.alloc(8);
  return Array.from({ length: count }, (_, k) => {
    for (let b = 0; b < planes; b++) value[b] ^= bytes[at + b * count + k];
    return value.readDoubleBE(0);
  });
}

/** The head, and the columns of points by `name of`. @param {string} page */
export function readReport(page) {
  const head = JSON.parse(inside(page, 'head')),
    bytes = inflateSync(Buffer.from(inside(page, 'point-data'), 'base64')),
    /** @type {Record<string, number[]>} */ columns = {};
  let at = 0;
  for (const { name, of, planes, count } of head.point_columns) {
    columns[`${name} ${of}`] = unpack(bytes, at, count, planes);
    at += planes * count;
  }
  return { head, columns };
}
