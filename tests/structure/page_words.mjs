// Checks that the page's texts stand in www/words: node tests/structure/page_words.mjs ROOT
//   1. In a room that tests/structure/page_words.txt does not list, no module has a text for a person: between the tags of a template, in
//      an attribute that is read aloud or shown, or in a literal that has two words or begins as a sentence does.
//   2. Every key that a module names is there in each language, and every key of a language is named by a module: as it is, or by the
//      beginning of a template such as `rigid.phase.${name}`.
//   3. Each language has the same keys with the same values in their places.
import { readFileSync, readdirSync } from 'node:fs';
import { join, posix } from 'node:path';
import { argv, exit } from 'node:process';
import { fileURLToPath } from 'node:url';
import ts from 'typescript';

const PARTS = ['page', 'class', 'lesson', 'motion', 'rigid', 'fluid', 'netgame', 'netgame_more', 'experiments', 'tradeoff'];
/** Attributes whose value a person reads or hears. */
const ATTRIBUTE = /\s(aria-label|aria-description|aria-valuetext|title|placeholder|alt|label)\s*=\s*("[^"]*"|'[^']*')/g;
const HOLE = '\ue000'; /* an expression in a template */
/** A word of a person in the text of a template: two letters in a row. */
const WORD = /\p{L}{2,}/u;
/** Between tags these stand as they are: names and units. */
const NAMES = /\b(?:laglab|log|API|CSV|NDJSON|JSON|SQLite|curl|ms|Hz|MB|kg|mm|cm)\b|&\w+;/g;

/** @param {string} text of page_words.txt */
export function readExceptions(text) {
  const rooms = new Set(),
    patterns = [];
  for (const line of text.split('\n')) {
    const [, kind, value = ''] = /^(unconverted|texts):\s*(.*?)\s*$/.exec(line) ?? [];
    if (kind === 'unconverted') for (const room of value.split(/\s+/)) rooms.add(room);
    else if (kind === 'texts') patterns.push(new RegExp(value.slice(1, -1)));
    else if (line.trim() !== '' && !line.startsWith('#')) throw new Error(`page_words.txt: ${line}`);
  }
  return { rooms, patterns };
}

/** Texts of a template of HTML. @param {string} markup with HOLE for each expression @returns {string[]} */
function textsOf(markup) {
  const found = [...markup.matchAll(ATTRIBUTE)].map(([, , value]) => value.slice(1, -1));
  const between = markup
    .replace(/<code>[^<]*<\/code>|<pre>[^<]*<\/pre>/g, '<>')
    .replace(/<!--.*?-->/gs, '')
    .replace(/<[^<>]*>?/g, '\n');
  /* a template that begins within a tag, or ends there */
  const inside = /^[^<>]*>/.exec(markup) && !markup.trimStart().startsWith('<') ? between.slice(between.indexOf('\n')) : between;
  found.push(...inside.split(/[\n\ue000]/));
  return found.filter((text) => WORD.test(text.replace(NAMES, ''))).map((text) => text.trim());
}

/** Whether a plain literal looks like a text for a person. @param {string} text */
const reads = (text) => /\p{L}{2,}[,:;]? \p{L}{2,}/u.test(text) || /^\p{Lu}\p{Ll}+/u.test(text);

/** Where literals are no texts: CSS selectors and canvas fonts, names of classes, storage. */
const QUIET_CALLS = new Set([
  ...['querySelector', 'querySelectorAll', 'closest', 'matches', 'matchMedia', 'getContext', 'setAttribute', 'addEventListener'],
  ...['register', 'createElement', 'execCommand', 'getEntriesByType', 'getEntriesByName', 'mark', 'element', 'requestAnimationFrame'],
  ...['get', 'has', 'split', 'join', 'test', 'startsWith', 'endsWith', 'includes', 'replace', 'replaceAll'],
]);

/** Errors that no person meets: the stream is opened again. */
const QUIET_ERRORS = new Set(['StreamError']);

/** @param {string} name @param {string} source @returns {{line: number, text: string}[]} texts, and
 * @param {Set<string>} keys the literals */
function read(name, source, keys, prefixes) {
  const file = ts.createSourceFile(name, source, ts.ScriptTarget.Latest, true, ts.ScriptKind.JS),
    found = [];
  const put = (node, text) => found.push({ line: file.getLineAndCharacterOfPosition(node.getStart()).line + 1, text });
  const visit = (node) => {
    if (ts.isNewExpression(node) && ts.isIdentifier(node.expression) && QUIET_ERRORS.has(node.expression.text)) return;
    if (ts.isImportDeclaration(node) || ts.isExportDeclaration(node)) return;
    if (ts.isTaggedTemplateExpression(node)) {
      const { template } = node;
      const markup = ts.isNoSubstitutionTemplateLiteral(template)
        ? template.text
        : template.head.text + template.templateSpans.map((span) => HOLE + span.literal.text).join('');
      for (const text of textsOf(markup)) put(node, text);
      if (!ts.isNoSubstitutionTemplateLiteral(template)) for (const span of template.templateSpans) visit(span.expression);
      return;
    }
    if (ts.isTemplateExpression(node)) {
      prefixes.add(node.head.text);
      const text = node.head.text + node.templateSpans.map((span) => HOLE + span.literal.text).join('');
      if (/^\p{Lu}\p{Ll}+[ :,]/u.test(text) || text.split(HOLE).some((part) => /\p{L}{2,}[,:;.]? \p{L}{2,}|^\s\p{L}{2,}\s$/u.test(part)))
        put(node, text.replaceAll(HOLE, '…'));
      for (const span of node.templateSpans) visit(span.expression);
      return;
    }
    if (ts.isStringLiteral(node) || ts.isNoSubstitutionTemplateLiteral(node)) {
      keys.add(node.text);
      const call = ts.isCallExpression(node.parent) ? node.parent.expression : null,
        called = call && (ts.isPropertyAccessExpression(call) ? call.name.text : ts.isIdentifier(call) ? call.text : '');
      if (reads(node.text) && !(called && QUIET_CALLS.has(called))) put(node, node.text);
      return;
    }
    ts.forEachChild(node, visit);
  };
  visit(file);
  return found;
}

/** @param {unknown} text @returns {string} the names in a text's places, in alphabetical order */
const placesOf = (text) => [...new Set([...JSON.stringify(text).matchAll(/\{(\w+)\}/g)].map(([, name]) => name))].sort().join(' ');

/** @param {string} root @returns {{findings: string[], modules: number, keys: number}} */
export function checkWords(root) {
  const { rooms, patterns } = readExceptions(readFileSync(join(root, 'tests/structure/page_words.txt'), 'utf8'));
  const findings = [],
    literals = new Set(),
    prefixes = new Set();
  const names = readdirSync(join(root, 'www/js'), { recursive: true, encoding: 'utf8' })
    .map((name) => name.replaceAll('\\', '/'))
    .filter((name) => name.endsWith('.js'))
    .sort();
  for (const name of names) {
    const found = read(name, readFileSync(join(root, 'www/js', name), 'utf8'), literals, prefixes);
    if (rooms.has(posix.dirname(name)) && !name.endsWith('/about.js')) continue;
    for (const { line, text } of found)
      if (!patterns.some((pattern) => pattern.test(text))) findings.push(`www/js/${name}:${line}: a text: ${JSON.stringify(text)}`);
  }
  for (const room of rooms) if (!names.some((name) => posix.dirname(name) === room)) findings.push(`page_words.txt: no room ${room}`);

  const languages = readdirSync(join(root, 'www/words'))
    .filter((file) => file.endsWith('.json')) // scenarios/ has those of the library
    .map((file) => ({ file, words: JSON.parse(readFileSync(join(root, 'www/words', file), 'utf8')) }));
  const keysOf = (words) => PARTS.flatMap((part) => Object.entries(words[part] ?? {}));
  const all = new Set(languages.flatMap(({ words }) => keysOf(words).map(([key]) => key)));
  const counted = [...literals].filter((text) => text.endsWith('.count')); /* handed to countChoice */
  const grouped = [...prefixes].filter((prefix) => /^[a-z_]+\.[\w.]*$/.test(prefix));
  for (const { file, words } of languages) {
    const own = new Map(keysOf(words)),
      count = keysOf(words).length;
    if (own.size !== count) findings.push(`www/words/${file}: a key stands in two parts`);
    for (const key of all) {
      if (!own.has(key)) findings.push(`www/words/${file}: ${key} is missing`);
      else if (placesOf(own.get(key)) !== placesOf(keysOf(languages[0].words).find(([one]) => one === key)?.[1]))
        findings.push(`www/words/${file}: ${key} has other places than in ${languages[0].file}`);
    }
    for (const key of own.keys())
      if (
        !(key in (words.lesson ?? {})) &&
        !literals.has(key) &&
        !grouped.some((prefix) => key.startsWith(prefix)) &&
        !counted.some((start) => key.startsWith(`${start}.`))
      )
        findings.push(`www/words/${file}: no module names ${key}`);
  }
  const parts = new Set([...all].filter((key) => key.includes('.')).map((key) => key.slice(0, key.indexOf('.'))));
  for (const text of literals)
    if (
      /^[a-z_]+(\.\w+)+$/.test(text) &&
      ['base', 'session', 'shell', 'workbench', ...PARTS].includes(text.split('.')[0]) &&
      !all.has(text)
    )
      if (parts.has(text.split('.')[0]) && ![...all].some((key) => key.startsWith(`${text}.`)))
        findings.push(`www/js: no language has ${text}`);
  return { findings, modules: names.length, keys: all.size };
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const { findings, modules, keys } = checkWords(argv[2] ?? '.');
  for (const finding of findings) console.log(finding);
  console.log(`${modules} modules, ${keys} texts, ${findings.length} findings`);
  exit(modules > 0 && keys > 0 && findings.length === 0 ? 0 : 1);
}
