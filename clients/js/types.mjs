// The types of this client: of the API from its contract in BUILD/api, declarations from the JSDoc of the client and of the stream.
//
//   node clients/js/types.mjs BUILD        # writes BUILD/clients/js/types; the build does it
import { execFileSync } from 'node:child_process';
import { mkdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import ts from 'typescript';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');

const build = path.resolve(process.argv[2]),
  types = path.join(build, 'clients/js/types'),
  api = path.join(types, 'api.d.ts');
rmSync(types, { recursive: true, force: true });

// A member with a default may be left out of a request.
const flags = ['--default-non-nullable=false', '--empty-objects-unknown'];
const generator = path.join(ROOT, 'node_modules/openapi-typescript/bin/cli.js');
execFileSync(process.execPath, [generator, path.join(build, 'api/openapi.yaml'), '-o', api, ...flags], {
  cwd: build,
  stdio: ['ignore', 'ignore', 'inherit'],
});

/** @type {ts.CompilerOptions} */
const options = {
  allowJs: true,
  checkJs: true,
  strict: true,
  declaration: true,
  emitDeclarationOnly: true,
  skipLibCheck: true,
  target: ts.ScriptTarget.ES2022,
  module: ts.ModuleKind.ES2022,
  moduleResolution: ts.ModuleResolutionKind.Bundler,
  lib: ['lib.es2022.d.ts', 'lib.dom.d.ts', 'lib.dom.iterable.d.ts'],
  types: ['node'],
  typeRoots: [path.join(ROOT, 'node_modules/@types')],
  rootDir: ROOT,
  rootDirs: [ROOT, build],
  outDir: types,
};
const program = ts.createProgram([path.join(ROOT, 'clients/js/laglab.js')], options),
  wrong = ts.getPreEmitDiagnostics(program);
if (wrong.length > 0) {
  rmSync(api); // or the next build would take the types for made
  console.error(ts.formatDiagnostics(wrong, ts.createCompilerHost(options)));
  process.exit(1);
}
// Declarations lie two folders deeper than the modules, in the tree that they have together with those of the page.
program.emit(undefined, (name, text) => {
  mkdirSync(path.dirname(name), { recursive: true });
  writeFileSync(name, text.replaceAll('"./types/api.js"', '"../../api.js"'));
});
