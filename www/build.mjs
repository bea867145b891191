// Makes what a daemon serves: the page in BINARY/www and the scenarios next to it. The build of the program calls it:
//
//   node www/build.mjs SOURCE BINARY [TYPES]        # TYPES: folder with the types of the JavaScript client, for its package
import { execFileSync } from 'node:child_process';
import { cpSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { argv } from 'node:process';
import { build } from 'esbuild';
import { shipRows } from '../cmake/shipped_rows.mjs';

const [source = '', binary = '', ...types] = argv.slice(2).map((one) => path.resolve(one)),
  from = path.join(source, 'www'),
  to = path.join(binary, 'www'),
  js = path.join(from, 'js');
const read = (/** @type {string} */ name) => readFileSync(path.join(from, name), 'utf8');
const list = (/** @type {string} */ folder, /** @type {string} */ end) =>
  readdirSync(path.join(from, folder)).filter((name) => name.endsWith(end));
/** @param {string} name @param {unknown} value text, or JSON, which is written without indents: a first load is measured in bytes */
function write(name, value) {
  const file = path.join(to, name);
  mkdirSync(path.dirname(file), { recursive: true });
  writeFileSync(file, typeof value === 'string' ? value : `${JSON.stringify(value)}\n`);
}

for (const folder of ['www', 'scenarios']) rmSync(path.join(binary, folder), { recursive: true, force: true });
cpSync(path.join(source, 'scenarios'), path.join(binary, 'scenarios'), { recursive: true });
for (const name of ['cards.json', 'finished.json', 'icon.svg', 'lessons', 'words'])
  cpSync(path.join(from, name), path.join(to, name), { recursive: true });

// ---- scripts and styles ----

const FIRST = { early: 'shell/early.js', main: 'shell/main.js' }; /* what the page names; the second has what the others share */
const SHARED = [
  'lessons/steps.js',
  ...['core/frame', 'core/layout', 'lab/drive'].map((name) => `labs/netgame/${name}.js`),
  ...['draw', 'workbench'].flatMap((room) => list(`js/${room}`, '.js').map((name) => `${room}/${name}`)),
];
/** Modules of import() that are wanted together have one file; each other has its own. */
const PARTS = /** @type {Record<string, string[]>} */ ({
  ...Object.fromEntries(Object.entries(FIRST).map(([name, module]) => [name, [module]])),
  lessons: ['lessons/lessons.js', 'labs/netgame/front/lab.js'],
  more: ['shell/later.js', 'labs/netgame/lab/later.js'],
});
const MAIN = [FIRST.main, ...SHARED.filter((name) => !/\/(qr|version)\.js/.test(name))]; /* these are for a class, for a print */

/** @type {import('esbuild').Plugin} */
const parts = {
  name: 'parts',
  setup({ onResolve, onLoad, resolve }) {
    onResolve({ filter: /\/vendor\// }, ({ path: name, kind }) =>
      resolve(path.basename(name, '.js').replace('signals', '@preact/signals'), { kind, resolveDir: source }),
    );
    onResolve({ filter: /^part:/ }, ({ path: name }) => ({ path: name.slice(5), namespace: 'part' }));
    onResolve({ filter: /^\./ }, ({ path: name, kind, resolveDir }) => {
      if (kind !== 'dynamic-import') return undefined;
      const module = path.relative(js, path.resolve(resolveDir, name));
      const part =
        Object.keys(PARTS).find((one) => PARTS[one]?.includes(module)) ??
        path.basename(module.replace(/\/(lab|view|room)\.js$/, ''), '.js');
      PARTS[part] ??= [module];
      return { path: part, namespace: 'part' };
    });
    /* esbuild makes one file of what the same parts reach: that of MAIN is one since all but the first reach all of it. */
    onLoad({ filter: /^/, namespace: 'part' }, ({ path: name }) => ({
      contents: [
        ...(name === 'early' ? [] : MAIN).map((module) => `import './${module}';`),
        ...(PARTS[name] ?? []).map((module) => `export * from './${module}';`),
      ].join('\n'),
      resolveDir: js,
    }));
  },
};
const shared = /** @type {const} */ ({ bundle: true, minify: true, legalComments: 'none', outdir: to, absWorkingDir: source });
const scripts = await build({
  ...shared,
  entryPoints: Object.keys(FIRST).map((name) => ({ in: `part:${name}`, out: name })),
  format: 'esm',
  splitting: true,
  target: 'es2022',
  sourcemap: 'linked',
  entryNames: 'js/[name]-[hash]',
  chunkNames: 'js/[name]-[hash]',
  plugins: [parts],
  metafile: true,
});
const first = read('first.css'),
  styles = list('', '.css').filter((name) => !first.includes(`'./${name}'`));
const styled = await build({ ...shared, entryPoints: styles.map((name) => `www/${name}`), metafile: true });
await build({
  ...shared,
  entryPoints: ['clients/js/laglab.js'],
  format: 'esm',
  external: ['node:*', './node_socket.js'] /* browsers have a socket and inflate by themselves */,
  entryNames: 'clients/js/laglab',
});

/* The page names the files that have what it begins with; those that would import it are of no use. */
let page = read('index.html');
for (const [name, module] of Object.entries(FIRST))
  for (const [file, { inputs, entryPoint }] of Object.entries(scripts.metafile.outputs)) {
    if (`www/js/${module}` in inputs) page = page.replace(`js/${name}.js`, path.relative(to, path.resolve(source, file)));
    if (entryPoint === `part:${name}`) for (const end of ['', '.map']) rmSync(path.join(source, file + end));
  }
write('index.html', page);

const packages = [scripts, styled]
  .flatMap(({ metafile }) => Object.keys(metafile.inputs))
  .flatMap((name) => /^node_modules\/((?:@[^/]+\/)?[^/]+)/.exec(name)?.[1] ?? []);
const licences = [...new Set(packages)].sort().map((name) => {
  const [manifest = '', licence = ''] = ['package.json', 'LICENSE'].map((file) =>
    readFileSync(path.join(source, 'node_modules', name, file), 'utf8'),
  );
  return `\n==== ${name} ${JSON.parse(manifest).version} ====\n\n${licence}`;
});
write('vendor/LICENSES.txt', `The libraries in the scripts and styles of this page, and their licences.\n${licences.join('')}`);

// ---- lessons ----

/** What a list of lessons shows of each, so that a page reads one file for it. */
const MEMBERS = ['order', 'topic', 'title', 'paper', 'scenario', 'minutes', 'age', 'prerequisites', 'hooks'];
write(
  'lessons/index.json',
  list('lessons', '.json')
    .sort()
    .map((name) => {
      const lesson = JSON.parse(read(`lessons/${name}`));
      return {
        id: path.basename(name, '.json'),
        ...Object.fromEntries(MEMBERS.filter((member) => member in lesson).map((member) => [member, lesson[member]])),
      };
    }),
);

// ---- what the program ships of speed against error ----

shipRows(path.join(source, 'bench/results/tradeoff'), path.join(to, 'tradeoffs'));

// ---- words ----

const pick = (/** @type {Record<string, any>} */ table, /** @type {RegExp} */ pattern) =>
  Object.fromEntries(Object.entries(table).filter(([name]) => pattern.test(name)));
const ON_PANELS =
  /^(server\.(update_hz|sync)|players\.\*\.(lag_ms|prediction|reconciliation|interpolation|control|link\.\*\.(jitter_ms|loss_pct)))(\.[a-z_]+)?$/;
const VALUE = /^players\.\*\.game\./;

/* The words of each language in the parts that a page reads: what is wanted first, a class, each lab. The names of parameters, metrics and
 * units come with the lab that shows them: of a netgame those on its panels, the rest with its dialogs, and the metrics with experiments. */
for (const file of list('words', '.json')) {
  const { page, lesson, netgame, units, params, choices, metrics, ...all } = JSON.parse(read(`words/${file}`));
  const values = Object.entries(pick(metrics, VALUE)).map(([at, { label }]) => [at.replace(VALUE, 'netgame.value.'), label]);
  const onPanels = { params: pick(params, ON_PANELS), choices: pick(choices, ON_PANELS) };
  const part = (/** @type {string} */ name, /** @type {Record<string, any>} */ more = {}) => ({
    [name]: { words: all[name] ?? {}, ...more },
  });
  const parts = {
    first: {
      page: { words: page },
      lesson: { words: lesson },
      netgame: { words: { ...netgame, ...Object.fromEntries(values) }, ...onPanels },
    },
    class: part('class'),
    tradeoff: part('tradeoff'),
    experiments: part('experiments', { units }),
    netgame_more: part('netgame_more', { params, choices, units }),
    netgame_metrics: part('netgame_metrics', { metrics }),
    ...Object.fromEntries(
      ['motion', 'rigid', 'fluid'].map((lab) => [
        lab,
        part(lab, { params: all.inputs[lab], metrics: all.labs[lab], choices: all.names[lab], units }),
      ]),
    ),
  };
  for (const [name, words] of Object.entries(parts)) write(`words/${file.slice(0, -5)}/${name}.json`, words);
  write(`words/packet/${file}`, all.packet);
}

// ---- clients, which a daemon serves for a room without Internet ----

const clients = path.join(to, 'clients');
for (const [script, ...more] of [['python/wheel.py'], ['js/pack.py', ...types]])
  execFileSync('python3', [path.join(source, 'clients', script ?? ''), clients, ...more], { stdio: ['ignore', 'ignore', 'inherit'] });
for (const name of ['python/examples/techniques.ipynb', 'r/techniques.R', 'r/techniques.json'])
  cpSync(path.join(source, 'clients', name), path.join(clients, path.basename(name)));
