// The tables of the stream (from `laglab schema stream`) as the page's module and as parts of the API's description.

const upper = (/** @type {string} */ name) => name.toUpperCase();
const camel = (/** @type {string} */ name) => name.split('_').map((part) => part.charAt(0).toUpperCase() + part.slice(1)).join('');

/** @param {any} field */
function typeOf(field) {
  if (field.boolean) return 'boolean';
  return 'number';
}

/** @param {any} record */
function typedef(record) {
  const lines = record.fields.map((/** @type {any} */ f) => ` * @property {${typeOf(f)}} ${f.name}  ${f.unit ? `${f.unit}; ` : ''}${f.help}`);
  const id = record.form === 'log' ? [' * @property {number} id  counts them'] : [];
  const plane = record.form === 'grid' ? [' * @property {Uint8Array} values  width x height cells'] : [];
  return ['/**', ` * ${record.help}`, ` * @typedef {object} ${camel(record.name)}Row`, ...id, ...lines, ...plane, ' */'].join('\n');
}

/** Names of values and of flags: `EVENTS_TYPE.input`. @param {any} record */
function constants(record) {
  return record.fields.flatMap((/** @type {any} */ f) => {
    const names = f.names ?? f.flags;
    if (!names) return [];
    const value = (/** @type {number} */ i) => (f.flags ? 2 ** i : i);
    const pairs = names.map((/** @type {string} */ name, /** @type {number} */ i) => [name, i]).filter(([name]) => name !== '')
      .map(([name, i]) => `${/^[a-z_]\w*$/.test(name) ? name : `'${name}'`}: ${value(i)}`);
    return [`export const ${upper(record.name)}_${upper(f.name)} = Object.freeze({ ${pairs.join(', ')} });`];
  });
}

/** www/js/stream/records.js. @param {any} schema @returns {string} */
export function pageModule(schema) {
  const bare = schema.records.map(({ help: _, ...record }) => ({
    ...record, fields: record.fields.map(({ help: __, names, flags, ...field }) => ({ ...field, ...(names ? { names } : {}), ...(flags ? { flags } : {}) })),
  }));
  const rows = schema.records.map((/** @type {any} */ r) => ` * @property {${r.form === 'one' ? `${camel(r.name)}Row` : `${camel(r.name)}Row[]`}} ${r.name}`);
  return `// Written by docs/generate.mjs from \`laglab schema stream\`: the tables are in C, and changed there.

/** Of these tables: a daemon whose hello has another gives its own at stream/schema.json. */
export const SCHEMA = '${schema.hash}';

/** @typedef {{name: string, coding: string, boolean?: boolean, bits?: number, unit?: string, names?: string[], flags?: string[]}} Field */
/** @typedef {{id: number, name: string, channel: string, form: string, keys?: number, fields: Field[]}} Layout */

${schema.records.map(typedef).join('\n\n')}

/**
 * The rows of each record, by its name.
 * @typedef {object} Records
${rows.join('\n')}
 */

${schema.records.flatMap(constants).join('\n')}

/** @type {readonly Layout[]} */
export const RECORDS = Object.freeze([
${bare.map((/** @type {any} */ record) => `  ${JSON.stringify({ ...record, fields: undefined }).slice(0, -1)},"fields":[\n${
    record.fields.map((/** @type {any} */ f) => `    ${JSON.stringify(f)},\n`).join('')}  ]},`).join('\n')}
]);
`;
}
