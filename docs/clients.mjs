// The types of the JavaScript client: declarations from its JSDoc and from the tables of the stream.
import path from 'node:path';
import ts from 'typescript';

/** clients/js/types, by the names of the files. @param {string} root @param {Map<string, string>} fresh generated modules, which can be older on disk
 * @returns {Map<string, string>} */
export function clientTypes(root, fresh) {
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
    onDisk = host.readFile;
  host.readFile = (name) => fresh.get(path.relative(root, name)) ?? onDisk(name);
  const program = ts.createProgram([path.join(root, 'clients/js/laglab.js')], options, host);
  const wrong = ts.getPreEmitDiagnostics(program);
  if (wrong.length > 0) throw new Error(ts.formatDiagnostics(wrong, host));
  /** @type {Map<string, string>} */
  const made = new Map();
  program.emit(undefined, (name, text) => made.set(path.relative(root, name), text));
  return made;
}
