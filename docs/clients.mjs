// The types of the JavaScript client: of the API from its contract, declarations from the client's JSDoc and from the tables of the stream.
import { execFileSync } from 'node:child_process';
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import ts from 'typescript';

const API = 'clients/js/types/api.d.ts';

/** Requests and answers of every operation. @param {string} root
 * @param {Map<string, string>} fresh generated files, which can be older on disk */
function apiTypes(root, fresh) {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-api-types-')),
    made = path.join(folder, 'api.d.ts');
  try {
    cpSync(path.join(root, 'api'), path.join(folder, 'api'), { recursive: true });
    for (const [name, text] of fresh) if (name.startsWith('api/')) writeFileSync(path.join(folder, name), text);
    const program = path.join(root, 'node_modules/openapi-typescript/bin/cli.js');
    // A member with a default may be left out of a request.
    const flags = ['--default-non-nullable=false', '--empty-objects-unknown'];
    execFileSync(process.execPath, [program, 'api/openapi.yaml', '-o', made, ...flags], {
      cwd: folder,
      stdio: ['ignore', 'ignore', 'pipe'],
    });
    return readFileSync(made, 'utf8');
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** clients/js/types, by the names of the files. @param {string} root
 * @param {Map<string, string>} generated files, which can be older on disk @returns {Map<string, string>} */
export function clientTypes(root, generated) {
  const fresh = new Map([...generated, [API, apiTypes(root, generated)]]);
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
    rootDir: root,
    outDir: path.join(root, 'clients/js/types'),
  };
  const host = ts.createCompilerHost(options),
    { readFile, fileExists } = host;
  host.readFile = (name) => fresh.get(path.relative(root, name)) ?? readFile(name);
  host.fileExists = (name) => fresh.has(path.relative(root, name)) || fileExists(name);
  const program = ts.createProgram([path.join(root, 'clients/js/laglab.js')], options, host);
  const wrong = ts.getPreEmitDiagnostics(program);
  if (wrong.length > 0) throw new Error(ts.formatDiagnostics(wrong, host));
  // Declarations lie two folders deeper than the modules, in the tree that they have together with those of the page.
  const made = new Map([[API, /** @type {string} */ (fresh.get(API))]]);
  program.emit(undefined, (name, text) => made.set(path.relative(root, name), text.replaceAll('"./types/api.js"', '"../../api.js"')));
  return made;
}
