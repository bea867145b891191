// The tables of the stream (from `laglab schema stream`) as the page's modules and as parts of the API's description.

const upper = (/** @type {string} */ name) => name.toUpperCase();
const camel = (/** @type {string} */ name) =>
  name
    .split('_')
    .map((part) => part.charAt(0).toUpperCase() + part.slice(1))
    .join('');

/** @param {any} field */
function typeOf(field) {
  if (field.boolean) return 'boolean';
  return 'number';
}

/** @param {any} record */
function typedef(record) {
  const lines = record.fields.map(
    (/** @type {any} */ f) => ` * @property {${typeOf(f)}} ${f.name}  ${f.unit ? `${f.unit}; ` : ''}${f.help}`,
  );
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
    const pairs = names
      .map((/** @type {string} */ name, /** @type {number} */ i) => [name, i])
      .filter(([name]) => name !== '')
      .map(([name, i]) => `${/^[a-z_]\w*$/.test(name) ? name : `'${name}'`}: ${value(i)}`);
    return [`export const ${upper(record.name)}_${upper(f.name)} = Object.freeze({ ${pairs.join(', ')} });`];
  });
}

const WRITTEN = '// Written by docs/generate.mjs from `laglab schema stream`: the tables are in C, and changed there.';

/** www/js/stream/rows.js: the types of the rows. No page loads it. @param {any} schema @returns {string} */
export function rowsModule(schema) {
  const rows = schema.records.map(
    (/** @type {any} */ r) => ` * @property {${r.form === 'one' ? `${camel(r.name)}Row` : `${camel(r.name)}Row[]`}} ${r.name}`,
  );
  return `${WRITTEN}

${schema.records.map(typedef).join('\n\n')}

/**
 * The rows of each record, by its name.
 * @typedef {object} Records
${rows.join('\n')}
 */

export {};
`;
}

/** www/js/stream/names.js: the values of fields that have names. @param {any} schema @returns {string} */
export const namesModule = (schema) => `${WRITTEN}

${schema.records.flatMap(constants).join('\n')}
`;

/** www/js/stream/records.js: the tables of the decoder. @param {any} schema @returns {string} */
export function recordsModule(schema) {
  const bare = schema.records.map(({ help: _, ...record }) => ({
    ...record,
    fields: record.fields.map(({ help: __, names, flags, ...field }) => ({
      ...field,
      ...(names ? { names } : {}),
      ...(flags ? { flags } : {}),
    })),
  }));
  return `${WRITTEN}

/** Of these tables: a daemon whose hello has another gives its own at stream/schema.json. */
export const SCHEMA = '${schema.hash}';

/** @typedef {{name: string, coding: string, boolean?: boolean, bits?: number, unit?: string, names?: string[], flags?: string[]}} Field */
/** @typedef {{id: number, name: string, channel: string, form: string, keys?: number, fields: Field[]}} Layout */

/** @type {readonly Layout[]} */
export const RECORDS = Object.freeze([
${bare
  .map(
    (/** @type {any} */ record) =>
      `  ${JSON.stringify({ ...record, fields: undefined }).slice(0, -1)},"fields":[\n${record.fields
        .map((/** @type {any} */ f) => `    ${JSON.stringify(f)},\n`)
        .join('')}  ]},`,
  )
  .join('\n')}
]);
`;
}

// ---- api/asyncapi.yaml ----

const quoted = (/** @type {string} */ text) => JSON.stringify(text);

/** A field as the text frame has it. @param {any} field */
function propertyOf(field) {
  const parts = [];
  const all = /** @type {string[] | undefined} */ (field.names ?? field.flags);
  const names = all
    ?.filter((name) => name !== '')
    .map(quoted)
    .join(', ');
  if (field.names) parts.push(`enum: [${names}]`);
  else if (field.flags) parts.push('type: array', `items: { enum: [${names}] }`, 'uniqueItems: true');
  else if (field.boolean) parts.push('type: boolean');
  else if (field.coding === 'int') parts.push('type: integer');
  else parts.push(/\bnull\b/.test(field.help) ? 'type: [number, "null"]' : 'type: number');
  parts.push(`description: ${quoted(field.help)}`);
  if (all?.includes('')) parts.push(`x-numbers: [${all.flatMap((name, i) => (name === '' ? [] : [i])).join(', ')}]`);
  if (field.unit) parts.push(`x-unit: ${quoted(field.unit)}`);
  parts.push(`x-coding: ${field.coding === 'int' ? 'int' : `${field.coding} ${field.bits}`}`);
  return `{ ${parts.join(', ')} }`;
}

/** @param {any} record */
function rowSchema(record) {
  const properties = record.fields.map((/** @type {any} */ f) => [f.name, propertyOf(f)]);
  if (record.form === 'log')
    properties.unshift([
      'id',
      '{ type: integer, minimum: 0, description: "Counts them: of the first the number is in the section, which then goes on by one." }',
    ]);
  if (record.form === 'grid')
    properties.push([
      'values',
      '{ type: array, items: { type: integer, minimum: 0, maximum: 255 }, description: "Width x height cells; the bytes behind the row." }',
    ]);
  const facts = ['id', 'name', 'channel', 'form', ...(record.keys ? ['keys'] : [])].map((fact) => `${fact}: ${record[fact]}`);
  return `    ${camel(record.name)}Row:
      type: object
      description: ${quoted(record.help)}
      x-record: { ${facts.join(', ')} }
      required: [${properties.map(([name]) => name).join(', ')}]
      additionalProperties: false
      properties:
${properties.map(([name, property]) => `        ${name}: ${property}`).join('\n')}`;
}

/** The schemas of channels, frames and rows, as they stand in components.schemas. @param {any} schema @returns {string} */
export function asyncSchemas(schema) {
  const channels = schema.channels.map((/** @type {any} */ c) => `\`${c.name}\`: ${c.help}`).join(' ');
  const frame = schema.records.map(
    (/** @type {any} */ r) =>
      `        ${r.name}: { type: array, items: { $ref: "#/components/schemas/${camel(r.name)}Row" }${
        r.form === 'one' ? ', minItems: 1, maxItems: 1' : ''
      } }`,
  );
  return `    Channel:
      enum: [${schema.channels.map((/** @type {any} */ c) => c.name).join(', ')}]
      description: ${quoted(channels)}
    Frame:
      type: object
      required: [type, seq, tick, time_s, flags]
      additionalProperties: false
      properties:
        type: { const: frame }
        seq: { type: integer, minimum: 0, maximum: 4294967295, description: Counts the frames of the stream; what a viewer acknowledges. }
        tick: { type: integer, minimum: 0 }
        time_s: { type: number, minimum: 0, description: Virtual time. }
        flags:
          type: array
          description: "behind: the log goes further; jump: what was kept is of another past."
          items: { enum: [playing, ended, behind, failed, jump] }
          uniqueItems: true
${frame.join('\n')}
${schema.records.map(rowSchema).join('\n')}`;
}
