// What was before the first frame that the page has had, after a jump or where it has joined late: rows of the daemon's trace.
import { call } from '../base/api.js';
import { touch } from '../draw/redraw.js';
import { session } from '../session/state.js';

const MOST_S = 120; /* before the frame */

/** @typedef {Record<string, number | string | null>} Row  the first columns are time_s and tick */
/** `first`: s, of the first frame; `asked`: its past was. @typedef {{first: number, asked: boolean}} Remembering */

/** Asks once for what a record of a run lacks, and gives it, oldest first. @template {Remembering} T @param {T} record
 * @param {string} of `ticks`, or a record of the stream @param {(record: T, rows: Row[]) => void} take asked for while it is still shown */
export async function recall(record, of, take) {
  const now = session.value;
  if (record.asked || record.first <= 0 || now === null) return;
  record.asked = true;
  try {
    const range = `from_s=${Math.max(0, record.first - MOST_S)}&to_s=${record.first}`;
    const rows = /** @type {Row[]} */ (await call('GET', `sessions/${now.id}/trace?of=${of}&${range}&format=json`));
    take(
      record,
      rows.filter((row) => Number(row.time_s) < record.first - 1e-6),
    );
    touch();
  } catch {
    /* it begins where the page came in */
  }
}
