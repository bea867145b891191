// Checks what the sources may include and call: node tests/structure/check.mjs ROOT
//   1. A room under src includes only itself and rooms below it.
//   2. The simulating rooms take time and randomness as arguments and call no libm function whose last bit
//      differs between libm versions (base/detmath.h has ours).
//   3. Every function that other files can see starts with ll_.
import { readdirSync, readFileSync } from "node:fs";
import { join, relative, sep } from "node:path";
import { argv, exit } from "node:process";
import { fileURLToPath } from "node:url";

const ROOMS = ["base", "param", "input", "ode", "rigid", "fluid", "link", "game", "netcode", "sim", "session", "library",
  "experiment", "daemon", "cli", "main.c"];
const PURE = new Set(["base", "ode", "rigid", "fluid", "link", "game", "netcode", "sim"]);

const IMPURE = ["rand", "srand", "rand_r", "random", "srandom", "drand48", "time", "clock", "clock_gettime",
  "gettimeofday", "timespec_get", "getenv"];
const LIBM = ["sin", "cos", "tan", "sincos", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh",
  "atanh", "exp", "exp2", "expm1", "log", "log2", "log10", "log1p", "pow", "cbrt", "hypot", "erf", "erfc", "tgamma",
  "lgamma"];
// A call, not a member that happens to have the name.
const FORBIDDEN = new RegExp(`(?<![\\w.]|->)(?:(?:${IMPURE.join("|")})|(?:${LIBM.join("|")})[fl]?)(?=\\s*\\()`, "g");

function sources(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) return sources(path);
    return /\.[ch]$/.test(entry.name) ? [path] : [];
  });
}

const blank = (text) => text.replace(/[^\n]/g, " ");
const lineOf = (text, index) => text.slice(0, index).split("\n").length;

// Each of these keeps every line's number.
const COMMENT = /\/\*[\s\S]*?\*\/|\/\/[^\n]*/;
const LITERAL = /"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'/;
const EITHER = new RegExp(`${COMMENT.source}|${LITERAL.source}`, "g");
const DIRECTIVE = /^[ \t]*#(?:[^\n]*\\\n)*[^\n]*/gm;

const withoutComments = (text) => text.replace(EITHER, (part) => (part.startsWith("/") ? blank(part) : part));
const withoutLiterals = (text) => text.replace(EITHER, blank);

function checkIncludes(room, text) {
  const found = [];
  const rank = ROOMS.indexOf(room);
  for (const match of withoutComments(text).matchAll(/^[ \t]*#\s*include\s*"([^"]*)"/gm)) {
    const other = match[1].includes("/") ? match[1].split("/")[0] : room;
    const line = lineOf(text, match.index);
    if (!ROOMS.includes(other)) found.push([line, `includes "${match[1]}", which is in no room`]);
    else if (ROOMS.indexOf(other) > rank) found.push([line, `${room} includes "${match[1]}", a room above it`]);
  }
  return found;
}

function checkCalls(room, text) {
  if (!PURE.has(room)) return [];
  const code = withoutLiterals(text);
  return [...code.matchAll(FORBIDDEN)].map((match) => [lineOf(code, match.index), `${room} calls ${match[0]}()`]);
}

/** Walks the text at brace depth 0: what stands before a { and ends in a parameter list is a function. */
function checkNames(text) {
  const code = withoutLiterals(text).replace(DIRECTIVE, blank).replace(/__attribute__\s*\(\(.*?\)\)/g, blank);
  const found = [];
  let depth = 0;
  let start = 0;
  for (let i = 0; i < code.length; i++) {
    if (code[i] === "{" && depth++ === 0) {
      const head = code.slice(start, i);
      const name = /^[^=(]*?(\w+)\s*\(/.exec(head);
      const visible = !/\b(?:static|typedef)\b/.test(head);
      if (name && visible && /\)\s*$/.test(head) && name[1] !== "main" && !name[1].startsWith("ll_"))
        found.push([lineOf(code, start + name[0].length), `the public function ${name[1]} does not start with ll_`]);
    } else if (code[i] === "}" && --depth === 0) start = i + 1;
    else if (code[i] === ";" && depth === 0) start = i + 1;
  }
  return found;
}

/** @returns {{findings: string[], files: number}} one line per breach, and how many files were looked at */
export function check(root) {
  const src = join(root, "src");
  const files = sources(src).sort();
  const findings = files.flatMap((path) => {
    const text = readFileSync(path, "utf8");
    const room = relative(src, path).split(sep)[0];
    const found = ROOMS.includes(room)
      ? [...checkIncludes(room, text), ...checkCalls(room, text), ...checkNames(text)]
      : [[1, `${room} is not one of the rooms`]];
    return found.map(([line, what]) => `${relative(root, path)}:${line}: ${what}`);
  });
  return { findings, files: files.length };
}

if (argv[1] === fileURLToPath(import.meta.url)) {
  const { findings, files } = check(argv[2] ?? ".");
  for (const finding of findings) console.log(finding);
  console.log(`${files} files, ${findings.length} findings`);
  exit(files > 0 && findings.length === 0 ? 0 : 1);
}
