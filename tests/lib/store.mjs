// The store of a sweep, FILE.runs, while another process fills it.
import { statSync } from 'node:fs';
import { waitFor } from './client.mjs';

/** Waits until some rows are in it: each transaction changes its log. @param {string} file of the rows */
export async function stored(file) {
  let times = 0,
    last = 0;
  await waitFor(() => {
    const now = statSync(`${file}.runs-wal`, { throwIfNoEntry: false })?.mtimeMs ?? 0;
    if (now > last) times++;
    last = now;
    return times > 3;
  }, 'rows in the store');
}
