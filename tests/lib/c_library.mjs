// The C library as a course has it: installed into a folder, and linked by pkg-config.
import { execFile } from 'node:child_process';
import { mkdirSync, mkdtempSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { BINARY } from './daemon.mjs';

export const run = promisify(execFile);
export const WARNINGS = ['-std=c99', '-Wall', '-Wextra', '-pedantic', '-Werror'];

export async function install() {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-c-')),
    prefix = path.join(folder, 'prefix'),
    program = path.join(folder, 'everything');
  await run('cmake', ['--install', path.dirname(BINARY), '--prefix', prefix]);
  const config = readdirSync(prefix, { recursive: true, encoding: 'utf8' }).find((name) => name.endsWith('laglab.pc')) ?? '',
    libraries = path.join(prefix, path.dirname(path.dirname(config))),
    environment = { ...process.env, PKG_CONFIG_PATH: path.join(libraries, 'pkgconfig'), LD_LIBRARY_PATH: libraries };
  const pkgConfig = async (/** @type {string[]} */ ...options) => {
    const { stdout } = await run('pkg-config', [...options, 'laglab'], { env: environment });
    return (stdout.match(/(?:\\.|\S)+/g) ?? []).map((word) => word.replace(/\\(.)/g, '$1')); // a space in a path is escaped
  };
  const [scenarios] = await pkgConfig('--variable=scenarios');
  mkdirSync(path.join(folder, 'folder.json')); // opens as a file, and cannot be read
  const source = fileURLToPath(new URL('c_library.c', import.meta.url));
  await run('cc', [...WARNINGS, '-g', '-o', program, source, ...(await pkgConfig('--cflags', '--libs'))]);
  return {
    folder,
    libraries,
    environment,
    scenarios,
    pkgConfig,
    /** What the program of c_library.c prints, by name. @param {string[]} [before] @param {Record<string, string>} [more] */
    async everything(before = [], more = {}) {
      const [command, ...args] = [...before, program, scenarios, folder];
      const { stdout } = await run(command, args, { env: { ...environment, ...more }, maxBuffer: 1 << 24 });
      const said = stdout
        .trim()
        .split('\n')
        .map((line) => JSON.parse(line));
      return new Map(said.map((one) => [one.name, one]));
    },
    remove: () => rmSync(folder, { recursive: true, force: true }),
  };
}
