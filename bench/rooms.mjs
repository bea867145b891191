// Of which code a result speaks: the rooms of src/ that it measures, and of the page www/. Their fingerprint is written into the result
// when it is measured; bench/ages.mjs says by it whether they have changed since.
import { createHash } from 'node:crypto';
import { readFileSync, readdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = dirname(dirname(fileURLToPath(import.meta.url)));
const GAME = ['base', 'param', 'input', 'game', 'link', 'netcode', 'sim', 'session'],
  DAEMON = [...GAME, 'daemon'];

/** By the name of a result, of which `rigid/growth` is one of `rigid`. */
export const ROOMS = {
  speed: GAME,
  techniques: GAME,
  many: GAME,
  streams: DAEMON,
  frames: DAEMON,
  capacity: DAEMON,
  parked: DAEMON,
  slow: DAEMON,
  proxies: DAEMON,
  hostile: [...DAEMON, 'experiment'],
  stall: [...DAEMON, 'experiment'],
  kills: [...DAEMON, 'experiment'],
  full: [...DAEMON, 'experiment'],
  shards: [...DAEMON, 'experiment'],
  soak: [...DAEMON, 'experiment'],
  classroom: DAEMON,
  autobahn: DAEMON,
  suites: [...DAEMON, 'experiment'],
  validate: [...DAEMON, 'experiment'],
  page: [...DAEMON, 'www'],
  integrators: ['base', 'ode'],
  rigid: ['base', 'rigid'],
  threads: ['base', 'threads', 'rigid'],
  fluid: ['base', 'fluid'],
  fluid_accuracy: ['base', 'fluid'],
  fluid_grid: ['base', 'fluid'],
  fluid_threads: ['base', 'threads', 'fluid'],
  experiments: [...GAME, 'library', 'experiment'],
  tradeoff: [...GAME, 'ode', 'rigid', 'fluid', 'library', 'experiment'],
  published: [...GAME, 'library', 'experiment'],
  advise: [...GAME, 'ode', 'rigid', 'fluid', 'library', 'experiment'],
};

/** @param {string} name of a result @returns {string[]} */
export function roomsOf(name) {
  const rooms = ROOMS[name.split('/')[0]];
  if (!rooms) throw new Error(`bench/rooms.mjs does not say of which rooms ${name} speaks`);
  return rooms;
}

/** @param {string} room @returns {string} */
export const folderOf = (room) => (room === 'www' ? room : `src/${room}`);

/** Twelve digits that any change of a source of the rooms changes. @param {string} name of a result @param {string} [root] */
export function fingerprint(name, root = ROOT) {
  const all = createHash('sha256');
  for (const room of [...roomsOf(name)].sort()) {
    const folder = join(root, folderOf(room));
    const files = readdirSync(folder, { recursive: true })
      .map(String)
      .filter((file) => (room === 'www' ? /\.(js|css|html)$/ : /\.(c|h|inc)$/).test(file))
      .sort();
    for (const file of files)
      all.update(
        `${room}/${file} ${createHash('sha256')
          .update(readFileSync(join(folder, file)))
          .digest('hex')}\n`,
      );
  }
  return all.digest('hex').slice(0, 12);
}
