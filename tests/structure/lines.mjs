// Checks how long the lines of JavaScript are, and that they use nothing that Node 18 has not: node tests/structure/lines.mjs ROOT
// Biome lays out code in 140 columns, but leaves comments and the text of templates as they are. A template that needs more has parts
// that want names of their own. The compiler finds what is too new only where it knows the type. Generated modules are as
// docs/generate.mjs writes them.
import { existsSync, readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { argv, exit } from 'node:process';
import { fileURLToPath } from 'node:url';
import { readRooms } from './rooms.mjs';

const COLUMNS_MAX = 140;
const NEWER = new RegExp(
  [
    '\\.(toSorted|toReversed|toSpliced)\\(',
    '\\b(Object|Map)\\.groupBy',
    '\\bArray\\.fromAsync',
    '\\bPromise\\.withResolvers',
    '\\bAbortSignal\\.any',
    'import\\.meta\\.(dirname|filename)',
  ].join('|'),
);
const PLACES = ['www/js', 'www/report', 'clients', 'src', 'tests', 'bench', 'docs', 'examples'];
const OTHERS = new Set(['node_modules', 'build', 'vendor', 'results']);

/** @param {string} root @param {string} folder @returns {string[]} paths below the root */
function scripts(root, folder) {
  return readdirSync(join(root, folder), { withFileTypes: true }).flatMap((entry) => {
    const path = `${folder}/${entry.name}`;
    if (entry.isDirectory()) return OTHERS.has(entry.name) ? [] : scripts(root, path);
    return /\.m?js$/.test(entry.name) ? [path] : [];
  });
}

/** @param {string} root @returns {{findings: string[], files: number}} one line per breach */
export function checkLines(root) {
  const { generated } = readRooms(join(root, 'tests/structure/page_rooms.txt')),
    files = PLACES.filter((place) => existsSync(join(root, place)))
      .flatMap((place) => scripts(root, place))
      .filter((path) => !generated.some((name) => path === `www/js/${name}`));
  const findings = files.flatMap((path) =>
    readFileSync(join(root, path), 'utf8')
      .split('\n')
      .flatMap((line, i) => {
        const columns = [...line].length;
        return [
          ...(columns > COLUMNS_MAX ? [`${path}:${i + 1}: ${columns} columns, more than ${COLUMNS_MAX}`] : []),
          ...(NEWER.test(line) ? [`${path}:${i + 1}: ${NEWER.exec(line)?.[0]}, which Node 18 has not`] : []),
        ];
      }),
  );
  return { findings: findings.sort(), files: files.length };
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const { findings, files } = checkLines(argv[2] ?? '.');
  for (const finding of findings) console.log(finding);
  console.log(`${files} files of JavaScript, ${findings.length} findings`);
  exit(files > 0 && findings.length === 0 ? 0 : 1);
}
