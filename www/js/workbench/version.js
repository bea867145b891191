// The version of laglab that made a session.
import { address } from '../base/api.js';

/** As the first line of the session's log names it. @param {string} id */
export async function versionOf(id) {
  const answer = await fetch(address(`sessions/${id}/log`));
  const reader = answer.body?.getReader();
  if (!answer.ok || !reader) return '';
  let text = '';
  for (;;) {
    const { value, done } = await reader.read();
    text += new TextDecoder().decode(value);
    if (done || text.length > 200) break;
  }
  reader.cancel().catch(() => {});
  return /"version":"([^"]*)"/.exec(text)?.[1] ?? '';
}
