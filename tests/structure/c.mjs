// As much of C as the check of the structure reads: what a file defines, and which names it uses.

const blank = (text) => text.replace(/[^\n]/g, ' ');

// Each of these keeps every line's number.
const COMMENT = /\/\*[\s\S]*?\*\/|\/\/[^\n]*/;
const LITERAL = /"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'/;
const EITHER = new RegExp(`${COMMENT.source}|${LITERAL.source}`, 'g');
const DIRECTIVE = /^[ \t]*#(?:[^\n]*\\\n)*[^\n]*/gm;

export const withoutComments = (text) => text.replace(EITHER, (part) => (part.startsWith('/') ? blank(part) : part));
export const withoutLiterals = (text) => text.replace(EITHER, blank);
export const lineOf = (text, index) => text.slice(0, index).split('\n').length;

/** Walks the text at brace depth 0: what stands before a { and ends in a parameter list is a function, what stands before a = is data.
 * @param {string} code without comments and literals */
export function definitions(code) {
  const text = code.replace(DIRECTIVE, blank).replace(/__attribute__\s*\(\(.*?\)\)/g, blank);
  const defined = [],
    structs = [];
  let depth = 0,
    start = 0;
  const add = (head, call) => {
    const name = call ? /^[^=(]*?(\w+)\s*\(/.exec(head) : /(\w+)\s*(?:\[[^\]]*\]\s*)*$/.exec(head);
    if (name && !/\b(?:static|typedef|extern)\b/.test(head))
      defined.push({ name: name[1], line: lineOf(text, start + head.indexOf(name[1])), call });
  };
  for (let i = 0; i < text.length; i++) {
    if (text[i] === '{' && depth++ === 0) {
      const head = text.slice(start, i),
        tag = /\b(?:struct|union)\s+(\w+)\s*$/.exec(head);
      if (tag) structs.push(tag[1]);
      else if (/\)\s*$/.test(head)) add(head, true);
    } else if (text[i] === '=' && depth === 0) add(text.slice(start, i), false);
    else if (text[i] === '}' && --depth === 0) start = i + 1;
    else if (text[i] === ';' && depth === 0) {
      const head = text.slice(start, i); // `const int table[2];` is data too
      if (/^\s*(?:_Atomic\s+|const\s+)*(?!struct\b|union\b|enum\b)\w+[\s*]+(?:const\s+)?ll_\w+\s*(?:\[[^\]]*\]\s*)*$/.test(head))
        add(head, false);
      start = i + 1;
    }
  }
  return { defined, structs };
}

/** Every name that starts with ll_, once a line. `inside`: of braces or of a macro; `tag`: behind `struct`.
 * @param {string} code without comments and literals */
export function identifiers(code) {
  const found = [];
  let depth = 0,
    line = 1,
    macro = false;
  for (const match of code.matchAll(/\\\n|\n|[{}]|#\s*define\b|(?:\bstruct\s+)?\bll_\w+/g)) {
    const part = match[0];
    if (part === '\\\n') line++;
    else if (part === '\n') {
      line++;
      macro = false;
    } else if (part === '{') depth++;
    else if (part === '}') depth--;
    else if (part.startsWith('#')) macro = true;
    else found.push({ name: /ll_\w+$/.exec(part)[0], tag: part.startsWith('struct'), line, inside: depth > 0 || macro });
    if (/^struct\s*\n/.test(part)) line++;
  }
  return found;
}
