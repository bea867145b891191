// The tables of rooms, tests/structure/rooms.txt and page_rooms.txt, and graphs.
import { readFileSync } from 'node:fs';

/** @typedef {{may: Map<string, string[]>, pure: string[], allocating: string[], exceptions: {file: string, other: string}[],
 *   circles: {room: string, files: string[]}[], games: string[], generated: string[], findings: string[]}} Rooms */

/** @param {string} path @returns {Rooms} */
export function readRooms(path) {
  /** @type {Rooms} */
  const rooms = { may: new Map(), pure: [], allocating: [], exceptions: [], circles: [], games: [], generated: [], findings: [] };
  for (const row of readFileSync(path, 'utf8').split('\n')) {
    const line = row.replace(/#.*/, '').trim();
    if (!line) continue;
    const [, key, rest] = /^([^:]+):(.*)$/.exec(line) ?? ['', line, ''],
      words = rest.split(/\s+/).filter(Boolean);
    const exception = /^except (\S+) -> (\S+)$/.exec(key),
      around = /^circle (\S+) (.+)$/.exec(key);
    if (key === 'pure') rooms.pure.push(...words);
    else if (key === 'allocates') rooms.allocating.push(...words);
    else if (key === 'games') rooms.games.push(...words);
    else if (key === 'generated') rooms.generated.push(...words);
    else if (exception || around) {
      if (words.length < 3) rooms.findings.push(`${key}: no reason is given`);
      if (exception) rooms.exceptions.push({ file: exception[1], other: exception[2] });
      else rooms.circles.push({ room: around[1], files: around[2].split(' ') });
    } else if (rooms.may.has(key)) rooms.findings.push(`${key} stands there twice`);
    else rooms.may.set(key, words);
  }
  for (const [room, words] of rooms.may)
    for (const word of words) if (!rooms.may.has(word)) rooms.findings.push(`${room}: there is no room ${word}`);
  const found = circle([...rooms.may]);
  if (found) rooms.findings.push(`rooms in a circle: ${found.join(', ')}`);
  return rooms;
}

/** What a room may use: what it names, and what these may. @param {Rooms} rooms @param {string} room @returns {Set<string>} */
export function below(rooms, room) {
  const found = new Set(),
    open = [...(rooms.may.get(room) ?? [])];
  for (let next = open.pop(); next !== undefined; next = open.pop()) {
    if (found.has(next)) continue;
    found.add(next);
    open.push(...(rooms.may.get(next) ?? []));
  }
  return found;
}

/** The names of those that lie in circles, or null: the remainder after removing every room that points at no remaining one, and then the
 * same backwards. @param {[string, string[]][]} edges @returns {string[] | null} */
export function circle(edges) {
  const left = new Map(edges.map(([name, others]) => [name, new Set(others)]));
  for (let before = -1; before !== left.size; ) {
    before = left.size;
    for (const [name, others] of left) if (![...others].some((other) => left.has(other))) left.delete(name);
    const pointedAt = new Set([...left.values()].flatMap((others) => [...others]));
    for (const name of [...left.keys()]) if (!pointedAt.has(name)) left.delete(name);
  }
  return left.size > 0 ? [...left.keys()].sort() : null;
}
