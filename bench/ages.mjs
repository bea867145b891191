// Of which results the measured code has changed since, for who publishes figures: node bench/ages.mjs
// The documents say at which commit each was measured, so that a change of the code changes no document.
import { readFileSync, readdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { ROOMS, fingerprint } from './rooms.mjs';

const ROOT = dirname(dirname(fileURLToPath(import.meta.url)));

/** The results that say when they were measured, and whether their rooms are as they were then. @param {string} [root]
 * @returns {{name: string, changed: boolean, head: Map<string, string>}[]} */
export function ages(root = ROOT) {
  return readdirSync(join(root, 'bench/results'), { recursive: true })
    .map(String)
    .filter((file) => file.endsWith('.csv') && file.split(/[/.]/)[0] in ROOMS)
    .sort()
    .flatMap((file) => {
      const name = file.slice(0, -4),
        comments = /^(#.*\n)*/.exec(readFileSync(join(root, 'bench/results', file), 'utf8'))[0],
        head = new Map([...comments.matchAll(/^# ([^:\n]+): ?(.*)$/gm)].map(([, key, value]) => [key, value]));
      return head.has('commit') ? [{ name, changed: head.get('rooms') !== fingerprint(name, root), head }] : [];
    });
}

if (process.argv[1] === fileURLToPath(import.meta.url))
  for (const { name, changed, head } of ages())
    console.log(
      `${changed ? 'older than the code' : 'of this code       '}  ${name.padEnd(24)}  commit ${head.get('commit')}, ${head.get('date')}` +
        (changed ? `; again: ${head.get('command') ?? './dev bench'}` : ''),
    );
