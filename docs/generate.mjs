// Writes what is in two places: the scenario format (from `laglab schema`), the records of the stream (from `laglab schema stream`), the
// API (from api/*.yaml), the daemon's options (from `laglab serve --help`), the bytes of a session (from `laglab run`) and the figures of
// the benchmarks (from bench/results/*.csv).
//
//   node docs/generate.mjs            # uses build/laglab, or the binary that LAGLAB_BIN names
//
// Whole files are written but for api/asyncapi.yaml and the documents that are `filled` below, where the text between two marks is.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import YAML from 'yaml';
import { folderOf, roomsOf } from '../bench/rooms.mjs';
import { columnsDoc, metricsDoc } from './metrics.mjs';
import { paperDoc } from './paper.mjs';
import { publishedDoc } from './published.mjs';
import { tradeoffDoc } from './tradeoff.mjs';
import { asyncSchemas, namesModule, recordsModule, rowsModule } from './records.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '..');
const NOTE = (/** @type {string} */ from) => `<!-- Written by docs/generate.mjs from ${from}: change it there. -->\n`;

const read = (/** @type {string} */ name) => readFileSync(path.join(ROOT, name), 'utf8');
const cell = (/** @type {unknown} */ value) =>
  String(value ?? '')
    .replace(/\s*\n\s*/g, ' ')
    .replaceAll('|', '\\|')
    .trim();
const code = (/** @type {unknown} */ value) => (value === undefined || value === '' ? '' : `\`${value}\``);

/** @param {string[]} head @param {unknown[][]} rows */
function table(head, rows) {
  const used = head.map((_, i) => rows.some((row) => cell(row[i]) !== ''));
  const line = (/** @type {unknown[]} */ cells) =>
    `| ${cells
      .filter((_, i) => used[i])
      .map(cell)
      .join(' | ')} |`;
  return [line(head), line(head.map(() => '---')), ...rows.map(line)].join('\n') + '\n';
}

/** The anchor of a heading, as GitHub makes it. @param {string} heading */
export function anchor(heading) {
  return heading
    .toLowerCase()
    .replace(/[^\p{L}\p{N}\s_-]/gu, '')
    .trim()
    .replace(/\s/g, '-');
}

// ---- the scenario format ----

function range(row) {
  const limit = (/** @type {number | undefined} */ value) => (value === undefined ? '' : String(value));
  if (row.enum) return row.enum.map(code).join(', ');
  if (row.const !== undefined) return code(row.const);
  if (row.type === 'string') return `at most ${row.maxLength} characters`;
  if (row.type === 'array') return `${row.minItems} to ${row.maxItems}`;
  return row.minimum === undefined && row.maximum === undefined ? '' : `${limit(row.minimum)} to ${limit(row.maximum)}`;
}

function rowsOf(node, linkOf) {
  const must = new Set(node.required ?? []);
  return Object.entries(node.properties).map(([name, row]) => {
    const inner = row.$ref ?? row.items?.$ref;
    const type = inner
      ? linkOf(inner) + (row.items ? ', an array' : '')
      : row.anyOf
        ? row.anyOf.map((any) => linkOf(any.$ref)).join(' or ')
        : row.enum
          ? 'choice'
          : row.type === 'string'
            ? 'text'
            : row.type;
    const standard = must.has(name) ? 'required' : row.default === '' ? '' : code(row.default);
    return [code(name), type, range(row), row['x-unit'] ?? '', standard, row['x-live'] ? 'yes' : 'no', row.description];
  });
}

/** Where each definition stands in a scenario: `players[].link.up`. */
function placesOf(schema, defs) {
  const places = new Map();
  const visit = (node, at) => {
    for (const [name, row] of Object.entries(node.properties)) {
      const here = at ? `${at}.${name}` : name;
      for (const ref of [row.$ref, row.items?.$ref, ...(row.anyOf ?? []).map((any) => any.$ref)].filter(Boolean)) {
        const key = ref.replace('#/$defs/', '');
        places.set(key, [...(places.get(key) ?? []), row.items ? `${here}[]` : here]);
        visit(defs[key], row.items ? `${here}[]` : here);
      }
    }
  };
  visit(schema, '');
  return places;
}

function library(folder = 'scenarios', at = '') {
  return readdirSync(path.join(ROOT, folder, at), { withFileTypes: true })
    .sort((a, b) => (a.name < b.name ? -1 : 1))
    .flatMap((entry) => {
      const name = at ? `${at}/${entry.name}` : entry.name;
      if (entry.isDirectory()) return library(folder, name);
      const scenario = name.endsWith('.json') ? JSON.parse(read(`${folder}/${name}`)) : {};
      return scenario.kind ? [{ id: name.slice(0, -5), ...scenario }] : []; // experiments have none
    });
}

function kindDoc(schema, defs) {
  const places = placesOf(schema, defs);
  const heading = (/** @type {string} */ name) => `${places.get(name).map(code).join(', ')}: ${name.replaceAll('_', ' ')}`;
  const linkOf = (/** @type {string} */ ref) => {
    const name = ref.replace('#/$defs/', '');
    return `[${name.replaceAll('_', ' ')}](#${anchor(heading(name))})`;
  };
  const head = ['Name', 'Type', 'Range', 'Unit', 'Default', 'Live', 'Meaning'];
  const parts = [`## Kind \`${schema.title}\``, schema.description, table(head, rowsOf(schema, linkOf))];
  for (const name of places.keys()) {
    const node = defs[name];
    parts.push(`### ${heading(name)}`, node.description, table(head, rowsOf(node, linkOf)));
  }
  return parts.join('\n\n');
}

function scenarioDoc(schema) {
  return `${NOTE('`laglab schema` and scenarios/')}
# The scenario format

A scenario is a JSON object of at most 32 levels. It names a kind, the kind's parameters, a duration and a seed. Missing values have their
defaults. An unlisted key is an error, and so is a value of the wrong type or out of its range: the message names the field, the
range and the value. Names carry their units.

A row that is **live** can be changed while a session runs, by \`PATCH /api/v1/sessions/ID/params\` or by the page. The others are set
before a session is created: in the scenario, by \`--set\` of \`laglab run\`, or by \`set\` of \`POST /api/v1/sessions\`. Dotted paths
address a value; elements of arrays are counted from 0. Rules that connect several values are checked after all of them are set, in any
order; of two \`--set\` of one path the later counts.

Two rows depend on each other: reconciliation switched on switches prediction on, and prediction switched off switches reconciliation off.

\`laglab schema\` prints the same rules as a JSON Schema (2020-12), which a daemon also serves at \`/api/v1/schema\`; the build writes it to
\`build/api/scenario.schema.json\`, for editors. Units are in \`x-unit\`, live rows have \`x-live\`.

Your own scenario, from a file:

\`\`\`sh
cat > mine.json <<'END'
{"kind": "netgame", "game": "race", "title": "A bad link", "duration_s": 20, "seed": 7,
 "server": {"update_hz": 20},
 "players": [
   {"name": "A", "lag_ms": 80, "prediction": true, "reconciliation": true, "interpolation": true,
    "link": {"up": {"jitter_ms": 20}, "down": {"jitter_ms": 20, "loss_pct": 2}}},
   {"name": "B", "lag_ms": 30}]}
END
build/laglab run mine.json --set players.1.lag_ms=60 --set server.update_hz=30
\`\`\`

${schema.oneOf.map((kind) => kindDoc(kind, schema.$defs)).join('\n\n')}

## The library

\`laglab scenarios\` lists the scenarios; \`laglab run ID\` runs one; the page offers all of them.

${table(
  ['Id', 'Title', 'Paper', 'Description'],
  library().map((s) => [code(s.id), s.title, s.paper, s.text]),
)}`;
}

// ---- the API ----

const METHODS = ['get', 'post', 'patch', 'put', 'delete'];

function reader(document) {
  const follow = (node) => {
    while (node?.$ref?.startsWith('#'))
      node = node.$ref
        .slice(2)
        .split('/')
        .reduce((at, key) => at[key.replaceAll('~1', '/')], document);
    return node;
  };
  const type = (node) => {
    if (!node) return '';
    const name = /^#\/components\/schemas\/(\w+)$/.exec(node.$ref ?? '')?.[1];
    if (name) return `[${name}](#${anchor(name)})`;
    if (/\.json#/.test(node.$ref ?? '')) return `object, see ${code(`/api/v1/${node.$ref}`)}`;
    if (node.oneOf) return node.oneOf.map(type).join(' or ');
    if (node.const !== undefined) return code(JSON.stringify(node.const));
    if (node.enum) return node.enum.map((value) => code(JSON.stringify(value))).join(', ');
    if (node.type === 'array') return `array of ${type(node.items)}`;
    return node.type ?? 'anything';
  };
  const limits = (node) => {
    const words = [];
    const low = node.minimum ?? (node.exclusiveMinimum === undefined ? undefined : `above ${node.exclusiveMinimum}`);
    if (low !== undefined && node.maximum !== undefined) words.push(`${low} to ${node.maximum}`);
    else if (low !== undefined) words.push(typeof low === 'string' ? low : `at least ${low}`);
    if (node.maxLength !== undefined) words.push(`at most ${node.maxLength} bytes`);
    if (node.maxItems !== undefined) words.push(`at most ${node.maxItems}`);
    if (node.pattern) words.push(`\`${node.pattern}\``);
    return words.join(', ');
  };
  /** Inner objects follow their field: `errors[].field`. */
  const fields = (node, at = '') =>
    Object.entries(node.properties ?? {}).flatMap(([name, field]) => [
      [
        code(at + name),
        type(field),
        limits(field),
        (node.required ?? []).includes(name) ? 'yes' : 'no',
        field.default === undefined ? '' : code(JSON.stringify(field.default)),
        field.description,
      ],
      ...fields(field, `${at}${name}.`),
      ...fields(field.items ?? {}, `${at}${name}[].`),
    ]);
  const fieldTable = (node) => table(['Field', 'Type', 'Range', 'Required', 'Default', 'Meaning'], fields(node));
  return { follow, type, limits, fieldTable };
}

const isProblem = (response) => Object.keys(response.content ?? {}).includes('application/problem+json');

function operationDoc(_api, r, method, template, path_, operation) {
  const parts = [`### \`${method.toUpperCase()} ${template}\``, operation.summary];
  if (operation.description) parts.push(operation.description.trim());
  parts.push(operation.security ? 'Needs a key.' : 'Needs no key.');
  const parameters = [...(path_.parameters ?? []), ...(operation.parameters ?? [])].map(r.follow);
  if (parameters.length > 0) {
    parts.push(
      table(
        ['Parameter', 'In', 'Type', 'Range', 'Required', 'Meaning'],
        parameters.map((p) => [
          code(p.name),
          p.in,
          r.type(p.schema),
          r.limits(r.follow(p.schema)),
          p.required ? 'yes' : 'no',
          p.description,
        ]),
      ),
    );
  }
  if (operation.requestBody) {
    const content = Object.entries(operation.requestBody.content);
    const schema = content[0][1].schema;
    parts.push(
      `Body (${content.map(([type]) => code(type)).join(' or ')}${operation.requestBody.required ? '' : ', may be left out'}): ` +
        `${schema.$ref ? r.type(schema) : 'an object.'}`,
    );
    if (!schema.$ref && schema.properties) parts.push(r.fieldTable(schema));
    const examples = Object.values(content[0][1].examples ?? {});
    if (examples.length > 0) parts.push('```json\n' + examples.map((example) => JSON.stringify(example.value)).join('\n') + '\n```');
  }
  const errors = [];
  for (const [status, given] of Object.entries(operation.responses)) {
    const response = r.follow(given);
    const shared = given.$ref?.replace('#/components/responses/', '');
    if (isProblem(response)) {
      errors.push(shared ? `[${status}](#errors)` : `${status} (${response.description.replace(/\.$/, '')})`);
      continue;
    }
    const [type, body] = Object.entries(response.content ?? {})[0] ?? [];
    const headers = Object.keys(response.headers ?? {}).map(code);
    parts.push(
      `Answers ${status}${type ? ` (\`${type}\`)` : ''}: ${response.description}` +
        `${headers.length > 0 ? ` Header ${headers.join(', ')}.` : ''}${body?.schema.$ref ? ` Body: ${r.type(body.schema)}.` : ''}`,
    );
    if (body && !body.schema.$ref && body.schema.properties) parts.push(r.fieldTable(body.schema));
  }
  if (errors.length > 0) parts.push(`Errors: ${errors.join(', ')}.`);
  return parts.join('\n\n');
}

function streamDoc(stream) {
  const r = reader(stream);
  const parts = ['## The stream', stream.info.description.trim()];
  for (const { action, title, messages } of Object.values(stream.operations)) {
    parts.push(`### ${title}`);
    for (const given of messages) {
      const message = r.follow(r.follow(given));
      parts.push(`**${message.title}.** ${(message.description ?? '').trim()}`.trim());
      if (message.payload.properties) parts.push(r.fieldTable(message.payload));
      if (message.payload.$ref) parts.push(`Fields: ${r.type(message.payload)}.`);
    }
    if (action === 'receive')
      parts.push('Each in a text message. Of `ack`, `auth`, `input`, `subscribe` and `ping` a message has exactly one.');
  }
  for (const [name, schema] of Object.entries(stream.components.schemas)) parts.push(schemaDoc(r, name, schema));
  return parts.join('\n\n');
}

/** The rows of a record of the stream. @param {any} schema */
function recordDoc(schema) {
  const { id, name, channel, form, keys } = schema['x-record'];
  const names = (/** @type {any} */ p) => p.enum ?? p.items?.enum;
  return [
    `${schema.description} Record ${id}, ${code(name)}, of channel ${code(channel)}; ` +
      `form ${code(form)}${keys ? ` by its first ${keys} fields` : ''}.`,
    table(
      ['Field', 'Coding', 'Unit', 'Meaning'],
      Object.entries(schema.properties).map(([field, p]) => [
        code(field),
        p['x-coding'] ?? '',
        p['x-unit'] ?? '',
        p.description + (names(p) ? ` (${p.enum ? '' : 'some of '}${names(p).map(code).join(', ')})` : ''),
      ]),
    ),
  ].join('\n\n');
}

function schemaDoc(r, name, schema) {
  const parts = [`### ${name}`];
  if (schema['x-record']) return [...parts, recordDoc(schema)].join('\n\n');
  if (schema.description) parts.push(schema.description.trim());
  if (!schema.properties) parts.push(`Type: ${r.type(schema)} ${r.limits(schema)}`.trim());
  if (schema.properties) parts.push(r.fieldTable(schema));
  for (const option of schema.oneOf ?? []) if (option.properties) parts.push('Either', r.fieldTable(option));
  return parts.join('\n\n');
}

function apiDoc(api, stream) {
  const r = reader(api);
  const operations = Object.entries(api.paths).flatMap(([template, path_]) =>
    METHODS.filter((method) => path_[method]).map((method) => ({ method, template, path_, operation: path_[method] })),
  );
  const title = (o) => `\`${o.method.toUpperCase()} ${o.template}\``;
  const parts = [
    NOTE('api/openapi.yaml and api/asyncapi.yaml'),
    '# The HTTP API and the stream',
    'The contract is [openapi.yaml](../api/openapi.yaml) and [asyncapi.yaml](../api/asyncapi.yaml); a daemon serves both at ' +
      '`/api/v1/openapi.yaml` and `/api/v1/asyncapi.yaml`. First steps with curl are in the [README](../README.md#first-experiment).',
    api.info.description.trim(),
    '## Operations',
    table(
      ['Operation', 'Summary'],
      operations.map((o) => [`[${title(o)}](#${anchor(title(o))})`, o.operation.summary]),
    ),
  ];
  for (const tag of api.tags) {
    parts.push(`## ${tag.name[0].toUpperCase()}${tag.name.slice(1)}`, tag.description);
    for (const o of operations.filter((each) => each.operation.tags.includes(tag.name)))
      parts.push(operationDoc(api, r, o.method, o.template, o.path_, o.operation));
  }
  /** @type {Map<string, Set<string>>} */
  const statuses = new Map();
  for (const { operation } of operations) {
    for (const [status, { $ref }] of Object.entries(operation.responses)) {
      const name = $ref?.replace('#/components/responses/', '');
      if (name && isProblem(r.follow({ $ref }))) statuses.set(name, (statuses.get(name) ?? new Set()).add(status));
    }
  }
  parts.push(
    '## Errors',
    'Each is a [Problem](#problem) of type `application/problem+json`.',
    table(
      ['Status', 'When', 'Header'],
      [...statuses]
        .sort(([, a], [, b]) => Number([...a][0]) - Number([...b][0]))
        .map(([name, all]) => {
          const response = api.components.responses[name];
          return [
            [...all].join(', '),
            response.description,
            Object.keys(response.headers ?? {})
              .map(code)
              .join(', '),
          ];
        }),
    ),
  );
  parts.push('## Schemas');
  for (const [name, schema] of Object.entries(api.components.schemas)) parts.push(schemaDoc(r, name, schema));
  parts.push(streamDoc(stream));
  return (
    parts
      .join('\n\n')
      .replace(/\n{3,}/g, '\n\n')
      .trimEnd() + '\n'
  );
}

// ---- the options of the daemon ----

function optionsDoc(help) {
  const parts = [];
  let rows = [];
  let name = '';
  const end = () => {
    if (rows.length > 0) parts.push(table(['Option', 'Meaning'], rows));
    rows = [];
  };
  for (const line of help.split('\n').slice(1)) {
    if (/^ {2}--/.test(line)) {
      name = line.trim();
    } else if (/^ {6}/.test(line)) {
      rows.push([code(name), line.trim().replace(/ Default: \.$/, '')]);
    } else if (line !== '') {
      end();
      parts.push(line);
    }
  }
  end();
  return parts.join('\n\n');
}

// ---- the figures of the benchmarks ----

/** @param {string} text CSV (RFC 4180) under lines of `# name: value` */
export function parseCsv(text) {
  const comments = /** @type {[string, string][]} */ ([]);
  let body = text;
  for (let line = /^# ([^:\n]+): ?(.*)\n/.exec(body); line; line = /^# ([^:\n]+): ?(.*)\n/.exec(body)) {
    comments.push([line[1], line[2]]);
    body = body.slice(line[0].length);
  }
  const rows = [[]];
  for (const [, quoted, bare, end] of body.matchAll(/(?:"((?:[^"]|"")*)"|([^",\r\n]*))(,|\r?\n|$)/g)) {
    rows[rows.length - 1].push(quoted === undefined ? bare : quoted.replaceAll('""', '"'));
    if (end !== ',') rows.push([]);
  }
  const [head, ...cells] = rows.filter((row) => row.length > 1 || (row[0] ?? '') !== '');
  return { comments, rows: cells.map((row) => Object.fromEntries(head.map((name, i) => [name, row[i] ?? '']))) };
}

const digits = (/** @type {number} */ x) => (Math.abs(x) >= 1000 ? Math.round(x).toLocaleString('en') : String(Number(x.toPrecision(3))));
const numbers = (group, column) =>
  group
    .map((row) => row[column])
    .filter((text) => text !== '' && text !== undefined)
    .map(Number)
    .filter(Number.isFinite)
    .sort((a, b) => a - b);
const median = (group, column) => {
  const all = numbers(group, column);
  return all.length === 0 ? '' : digits((all[(all.length - 1) >> 1] + all[all.length >> 1]) / 2);
};
const spread = (group, column) => {
  const all = numbers(group, column);
  if (all.length === 0) return '';
  const low = digits(all[0]),
    high = digits(all[all.length - 1]);
  return low === high ? low : `${median(group, column)} (${low} to ${high})`;
};
/** A mean and half its 95 % interval. */
const withInterval = (group, column) => {
  const half = median(group, `${column}_ci95`);
  return half === '' ? median(group, column) : `${median(group, column)} ± ${half}`;
};
const worst = (group, column) => {
  const all = numbers(group, column);
  return all.length === 0 ? '' : digits(all[all.length - 1]);
};

const words = (group, column) => [...new Set(group.map((row) => row[column]).filter(Boolean))].join(', ');

const last = (group, column) => group[group.length - 1][column];

/** `column` of each method, side by side. */
const methods = (column, names) =>
  names.map((name) => [
    name,
    column,
    (group) =>
      median(
        group.filter((row) => row.method === name),
        column,
      ),
  ]);

/** Columns of engines side by side, each with what `of` makes of its row. */
const ENGINES = [
  'laglab',
  'laglab SSE2',
  'laglab standard',
  'Box2D 3 SSE2',
  'Box2D 3 AVX2',
  'Box2D 2.4',
  'Chipmunk',
  'Rapier',
  'Rapier SIMD',
  'Planck',
  'Matter',
];
const engines = (of, names = ENGINES) =>
  names.map((name) => [
    name,
    name,
    (group) =>
      group
        .filter((row) => row.engine === name)
        .map(of)
        .join(''),
  ]);
const stepTime = (row) => digits(Number(row.mean_ms));
const centimetres = (metres) => (Math.abs(metres) > 10 ? 'lost' : (100 * metres).toFixed(1));
const offAndDrift = (row) => (Number(row.tilt) > 0.3 ? 'X' : `${centimetres(row.off)} / ${centimetres(row.drift)}`);

/** How each result is shown: rows with the same `by` are one line. */
const RESULTS = [
  {
    name: 'speed',
    title: 'Speed of the engine',
    by: ['group', 'case'],
    columns: [
      ['Times real time, median (range)', 'times_real_time', spread],
      ['Bytes live', 'live_bytes', median],
      ['Bytes parked', 'parked_bytes', median],
    ],
  },
  {
    name: 'speed/bare',
    title: 'A step next to a bare C loop of the same physics',
    by: ['case'],
    columns: [
      ['Loop, ns', 'bare_ns', median],
      ['laglab, ns', 'laglab_ns', median],
      ['Ratio', 'ratio', median],
      ['Loop, bytes', 'bare_bytes', median],
      ['laglab, bytes', 'laglab_bytes', median],
    ],
  },
  {
    name: 'integrators',
    title: 'Integrators and other libraries: CPU time at equal error (1e-4 to 1e-10)',
    by: ['problem'],
    columns: [
      ['laglab', 'laglab_method', words],
      ['GSL', 'gsl_method', words],
      ['SUNDIALS', 'sundials_method', words],
      ['Odeint', 'odeint_method', words],
      ['Over GSL, median (range)', 'of_gsl', spread],
      ['Over SUNDIALS, median (range)', 'of_sundials', spread],
      ['Over Odeint, median (range)', 'of_odeint', spread],
      ['Over the fastest, worst', 'of_best', worst],
    ],
  },
  { name: 'rigid', title: 'Rigid bodies and other engines: CPU time of a step, ms', by: ['scene'], columns: engines(stepTime) },
  {
    name: 'rigid/peer',
    title: 'A step compared with Box2D 3 on the same SIMD: laglab over Box2D 3',
    by: ['scene'],
    columns: ['SSE2', 'AVX2'].map((simd) => [
      `${simd}, median (range)`,
      'ratio',
      (group, column) =>
        spread(
          group.filter((row) => row.simd === simd),
          column,
        ),
    ]),
  },
  {
    name: 'rigid/stability',
    title: 'Hard cases after 10 s: topmost body too low / farthest drift, cm; X: toppled',
    by: ['case'],
    columns: engines(
      offAndDrift,
      ENGINES.filter((name) => name !== 'laglab SSE2'),
    ),
  },
  {
    name: 'threads',
    title: 'Rigid bodies: a step by two threads, with the same bits',
    by: ['scene'],
    columns: [
      ['Bodies', 'bodies', median],
      ['One thread, ms', 'one_ms', median],
      ['Two threads, ms', 'two_ms', median],
      ['Ratio, median (range)', 'ratio', spread],
    ],
  },
  {
    name: 'threads/peer',
    title: 'The same scenes compared with Box2D 3: wall time of a step, ms',
    by: ['scene'],
    columns: ['laglab', 'Box2D 3 AVX2'].flatMap((engine) =>
      ['1', '2'].map((threads) => [
        `${engine}, ${threads} thread${threads === '1' ? '' : 's'}`,
        'step_ms',
        (group, column) =>
          median(
            group.filter((row) => row.engine === engine && row.threads === threads),
            column,
          ),
      ]),
    ),
  },
  {
    name: 'rigid/growth',
    title: 'Rigid bodies: cost over the number of balls',
    by: ['bodies'],
    columns: [
      ['Broad phase, ms', 'broad_ms', median],
      ['Solver, ms', 'solve_ms', median],
      ['Step, ms', 'step_ms', median],
      ['Step asleep, us', 'asleep_us', median],
    ],
  },
  {
    name: 'fluid',
    title: 'Fluids: frames of 1/60 s per second of one core, and other programs',
    by: ['case', 'method'],
    columns: [
      ['Frames/s, median (range)', 'frames_per_s', spread],
      ['Size, and the price of the speed', 'note', last],
    ],
  },
  {
    name: 'fluid_threads',
    title: 'Large fluids: a step by two threads, with the same bits',
    by: ['case'],
    columns: [
      ['Block, MiB', 'mib', median],
      ['One thread, ms', 'one_ms', median],
      ['Two threads, ms', 'two_ms', median],
      ['Ratio, median (range)', 'ratio', spread],
    ],
  },
  {
    name: 'fluid_accuracy',
    title: 'Particles against known solutions: relative errors',
    by: ['scene', 'size', 'quantity'],
    columns: methods('value', ['wcsph', 'pbf', 'dfsph']),
  },
  {
    name: 'fluid_grid/frames',
    title: 'Smoke past a cylinder: cost of a frame',
    by: ['n', 'settings'],
    columns: [
      ['ms a frame', 'ms_per_frame', median],
      ['Frames/s', 'frames_per_s', median],
      ['Residual', 'residual', median],
      ['Divergence left, 1/s', 'divergence_max_per_s', median],
      ['Sweeps', 'sweeps_mean', median],
    ],
  },
  {
    name: 'fluid_grid/pressure',
    title: 'Pressure solvers to a residual of 1e-6',
    by: ['box', 'solver', 'n'],
    columns: [
      ['Sweeps', 'sweeps', median],
      ['CPU, ms', 'cpu_ms', median],
      ['Residual', 'residual', median],
    ],
  },
  {
    name: 'fluid_grid/rotation',
    title: 'One turn of a shape',
    by: ['shape', 'advection', 'n'],
    columns: [
      ['Error, L1', 'error_l1', median],
      ['Mass gained', 'mass_change', median],
      ['Least', 'least', median],
      ['Most', 'most', median],
      ['CPU, s', 'cpu_s', median],
    ],
  },
  {
    name: 'experiments',
    title: 'Experiments: jobs, store, a large sweep',
    by: ['measured', 'runs'],
    columns: [
      ['Wall, s', 'wall_s', spread],
      ['CPU, s', 'cpu_s', spread],
      ['Memory, MiB', 'peak_mib', worst],
    ],
  },
  {
    name: 'techniques',
    title: 'Techniques of netcode: cost and effect',
    by: ['group', 'technique'],
    columns: [
      ['Input latency, ms', 'input_latency_ms', withInterval],
      ['Own error at its tick, m', 'own_timeline_error_m', withInterval],
      ['Others now, m', 'remote_error_m', withInterval],
      ['Others on their timeline, m', 'timeline_error_m', withInterval],
      ['Age of the view, ms', 'view_age_ms', withInterval],
      ['Corrections/s', 'corrections_per_s', median],
      ['Correction, m', 'correction_m', median],
      ['Bytes/s up', 'up_bytes_per_s', median],
      ['Bytes/s down', 'down_bytes_per_s', median],
      ['us per simulated s', 'us_per_sim_s', median],
    ],
  },
  {
    name: 'many',
    title: 'Many players and entities: speed, bandwidth and error',
    by: ['encoding', 'bodies', 'players'],
    columns: [
      ['Times real time, all metrics', 'times', spread],
      ['No view observed', 'times_unobserved', median],
      ['kB/s a player', 'kb_per_s', median],
      ['Others now, m', 'error_m', median],
      ['Near ones, m', 'near_error_m', median],
      ['Entities drawn', 'drawn', median],
      ['Session, MiB', 'mib', median],
    ],
  },
  {
    name: 'streams',
    title: 'Streams and other servers',
    by: ['sessions', 'viewers', 'server'],
    columns: [
      ['Frames/s', 'frames_per_s', median],
      ['Frames lost, most', 'lost', worst],
      ['Interval p50, ms', 'p50_ms', median],
      ['Interval p99, ms', 'p99_ms', spread],
      ['Age p99, ms', 'age_p99_ms', median],
      ['CPU, % of a core', 'server_cpu_pct', median],
      ['CPU per frame, us', 'server_us_per_frame', spread],
      ['Memory, MB', 'server_rss_mb', median],
    ],
  },
  {
    name: 'frames',
    title: 'Cost of a frame: a bare sender and Node ws',
    by: ['sessions', 'viewers', 'hz', 'server'],
    columns: [
      ['Frames/s', 'frames_per_s', median],
      ['Frames lost, most', 'lost', worst],
      ['CPU per frame, us', 'us_per_frame', spread],
      ['Over the bare sender', 'of_bare', spread],
      ['Over Node ws', 'of_node', spread],
      ['Without simulation: us', 'sending_us', spread],
      ['Over the bare sender', 'sending_of_bare', spread],
      ['Over Node ws', 'sending_of_node', spread],
      ['Memory per viewer, KB', 'viewer_kb', median],
    ],
  },
  {
    name: 'parked',
    title: 'Sessions without viewers',
    by: ['sessions'],
    columns: [
      ['Parked', 'parked', median],
      ['Resident memory, MiB', 'rss_mib', median],
      ['Of it anonymous, MiB', 'anonymous_mib', median],
    ],
  },
  {
    name: 'slow',
    title: 'A viewer that reads a fifth',
    by: ['way', 'scenario', 'reads'],
    columns: [
      ['Frames lost to fast viewers, most', 'fast_lost', worst],
      ['Fast interval p99, ms', 'fast_p99_ms', median],
      ['Slow: age p50, ms', 'slow_age_p50_ms', median],
      ['Slow: age p99, ms', 'slow_age_p99_ms', spread],
      ['Slow: age max, ms', 'slow_age_max_ms', worst],
    ],
  },
  {
    name: 'proxies',
    title: 'Upgrades on kept connections',
    by: ['way', 'at_once'],
    columns: [
      ['Upgrades', 'upgrades', median],
      ['Streamed', 'ok', median],
      ['On kept connections', 'on_kept', median],
      ['p50, ms', 'p50_ms', median],
      ['Max, ms', 'max_ms', worst],
    ],
  },
  {
    name: 'page',
    title: 'The page on a processor six times slower',
    by: ['lab'],
    columns: [
      ['Frames/s', 'fps', median],
      ['Script, ms', 'script_ms', median],
      ['First frame, ms', 'first_ms', spread],
      ['Bytes until then', 'first_bytes', median],
      ['Requests', 'first_requests', median],
      ['Bytes in all', 'bytes', median],
      ['Requests in all', 'requests', median],
    ],
  },
];

/** When a result was measured, and of which rooms it speaks. @param {string} name @param {Map<string, string>} head */
function measuredDoc(name, head) {
  const rooms = roomsOf(name).map((room) => code(folderOf(room)));
  const date = head.get('date') ?? 'at an unknown time';
  return `Measured at commit ${head.get('commit') ?? 'unknown'}, ${date}. Measured code: ${rooms.join(', ')}.`;
}

function resultDoc({ name, title, by, columns }) {
  const file = `bench/results/${name}.csv`;
  if (!existsSync(path.join(ROOT, file))) return `### ${title}\n\nNo figures yet: \`./dev bench ${name.split('/')[0]}\` measures them.\n`;
  const { comments, rows } = parseCsv(read(file));
  const split = comments.findIndex(([key]) => key === 'command');
  const groups = new Map();
  for (const row of rows) {
    const key = by.map((column) => row[column]).join('\n');
    groups.set(key, [...(groups.get(key) ?? []), row]);
  }
  const machine = comments
    .slice(0, split < 0 ? 0 : split + 1)
    .map(([key, value]) => `${key}: ${value}`)
    .join('; ');
  return [
    `### ${title}`,
    measuredDoc(name, new Map(comments)),
    table(
      [...by.map((column) => column.replaceAll('_', ' ')), ...columns.map(([label]) => label)],
      [...groups.values()].map((group) => [...by.map((column) => group[0][column]), ...columns.map(([, column, of]) => of(group, column))]),
    ),
    `[All rows](../${file}). ${machine}.`,
  ].join('\n\n');
}

// ---- errors against closed forms ----

/** A row a case, a column a solver; in brackets what the solver has no limit for. */
function closedFormsDoc() {
  const { rows } = parseCsv(read('tests/rigid/closed_forms.csv'));
  const solvers = [...new Set(rows.map((row) => row.solver))],
    cases = [...new Set(rows.map((row) => row.case))];
  const of = (/** @type {string} */ name, /** @type {string} */ solver) => rows.find((row) => row.case === name && row.solver === solver);
  const limits = (/** @type {string} */ name) =>
    [...new Set(solvers.map((solver) => of(name, solver).limit).filter((limit) => limit !== ''))].map(Number).sort((a, b) => a - b);
  return table(
    ['Case', 'Unit', ...solvers.map(code), 'Test allows'],
    cases.map((name) => [
      name,
      of(name, solvers[0]).unit,
      ...solvers.map((solver) => (of(name, solver).limit === '' ? `(${of(name, solver).error})` : of(name, solver).error)),
      limits(name).length > 1 ? `${limits(name)[0]} to ${limits(name).at(-1)}` : limits(name)[0],
    ]),
  );
}

// ---- memory of a session ----

const PARTS = [
  ['block_bytes', 'server, clients, links, metrics: one block, of a size that follows from the scenario'],
  ['metric_bytes', 'of the block: what only measures'],
  ['history_bytes', 'of the block: past states to look back to'],
  ['checkpoint_bytes', 'of a session: two checkpoints, for seeking back, made when it passes a third and two thirds of its duration'],
  ['event_bytes', 'of a netgame that may have viewers: the last 2048 events, 98,304 bytes'],
  ['trace_bytes', 'the copy on which a trace or a capture was computed; not part of `bytes`'],
  ['log_bytes', 'commands; empty without commands'],
  ['bytes', 'all of these and the scenario'],
  ['parked_bytes', 'the bytes that remain while the session is parked: the scenario and the log'],
];

function memoryDoc(laglab) {
  const [race, eight] = ['race', 'eight'].map((id) => JSON.parse(laglab('run', id)).cost);
  return table(
    ['Part', 'Race of two', 'Race of eight', 'What it is'],
    PARTS.map(([name, meaning]) => [code(name), race[name].toLocaleString('en'), eight[name].toLocaleString('en'), meaning]),
  );
}

// ---- long test runs ----

const READERS = {
  head: 'the head of an HTTP request, as the acceptor reads it',
  http: 'whole requests of a connection, through gate and library to the handlers',
  frames: 'WebSocket frames of a viewer, through its stream thread',
  json: 'JSON of any body, file or message',
  scenario: 'a scenario, which then runs',
  experiment: 'an experiment, of which a run is made',
  log: 'the log of a session, which is replayed',
  merge: 'shards given to `laglab merge`',
  patch: 'commands to a running session',
  set: '`--set path=value`',
  snapshot: 'a snapshot of the game on its way to a client',
  stream: 'messages of a viewer to a session, acknowledgements too',
};
const SANITIZED = { fuzz: 'address, undefined', 'fuzz-plain': 'none' };
const whole = (/** @type {string | number} */ n) => Number(n).toLocaleString('en');

/** @param {string} name @param {string} command @param {(rows: any[], of: Record<string, string>) => string} body */
function held(name, command, body) {
  const file = `bench/results/${name}.csv`;
  if (!existsSync(path.join(ROOT, file))) return `Not run yet: \`${command}\` does.`;
  const { comments, rows } = parseCsv(read(file)),
    of = Object.fromEntries([...comments].reverse()); // a column may have the name of a comment
  const when = of.date && of.commit ? ` ${of.date}, commit ${of.commit}, ${of.cpu}, ${of.compiler}; load of the machine: ${of.load}.` : '';
  return `${body(rows, of)}\n\n[All rows](../${file}). Repeat: \`${command}\`.${when}`;
}

const sum = (/** @type {any[]} */ rows, /** @type {string} */ name) => rows.reduce((total, row) => total + Number(row[name]), 0);

function mutantsDoc() {
  const file = 'tests/mutants.csv',
    { comments, rows } = parseCsv(read(file)),
    of = Object.fromEntries(comments),
    first = (/** @type {any} */ row) => row.result === 'caught',
    now = (/** @type {any} */ row) => first(row) || /^(?:test|sanitizers)/.test(row.now),
    rate = (/** @type {any[]} */ group, /** @type {(row: any) => boolean} */ test) =>
      `${group.filter(test).length} (${Math.round((100 * group.filter(test).length) / group.length)} %)`;
  const parts = {
      drawn: `\`${of.command}\`, commit ${of.commit}`,
      second: `\`${of.second}\`, commit ${of['second commit']}, for which nothing was mended`,
      review: 'faults that a reviewer tried',
    },
    groups = Object.entries(parts)
      .map(([origin, name]) => ({ name, group: rows.filter((row) => row.origin === origin) }))
      .filter(({ group }) => group.length > 0),
    drawn = rows.filter((row) => row.origin === 'drawn'),
    rooms = [...new Set(drawn.map((row) => row.room))].sort();
  const line = (/** @type {string} */ name, /** @type {any[]} */ group) => [name, group.length, rate(group, first), rate(group, now)];
  const counted = table(
    ['Changes', 'Tried', 'Caught at first', 'Caught now'],
    groups.map(({ name, group }) => line(name, group)),
  );
  const byRoom = table(
    ['Room', 'Drawn first', 'Caught at first', 'Caught now'],
    rooms.map((room) => {
      const group = drawn.filter((row) => row.room === room);
      return [code(room), group.length, group.filter(first).length, group.filter(now).length];
    }),
  );
  const left = table(
    ['Not caught', 'Line before', 'Line after', 'Why'],
    rows
      .filter((row) => !now(row))
      .map((row) => [code(row.line ? `${row.file}:${row.line}` : row.file), code(row.before), code(row.after), row.now]),
  );
  return `${counted}\n\n${byRoom}\n\n${left}\n\n[All rows](../${file}), with the test that caught each. Lines are those of the commit.`;
}

function killsDoc() {
  return held('kills', 'bench/run kills', (rows) =>
    table(
      [
        'Kills',
        'Sessions',
        'Acknowledged answers',
        'Commands looked for',
        'Hashes looked for',
        'Deleted sessions looked for',
        'Lost',
        'Resurrected',
        'Hashes that differ',
        'Chains cut short',
      ],
      [
        [
          ...['kills', 'sessions', 'acknowledged', 'commands', 'hashes', 'stayed_away', 'lost', 'resurrected', 'differ'].map((name) =>
            whole(sum(rows, name)),
          ),
          rows.filter((row) => row.broken).length,
        ],
      ],
    ),
  );
}

function fullDoc() {
  return held('full', 'bench/run full', (rows) =>
    table(
      [
        'Trials',
        'Full',
        'Read-only',
        'Slow',
        'kill -9',
        'SIGTERM',
        'Acknowledged',
        'Refused with 507',
        'Looked for',
        'Lost',
        'Other findings',
        'Cut short',
      ],
      [
        [
          ...['trials', 'full', 'read_only', 'slow', 'kills', 'stops', 'acknowledged', 'refused', 'looked_for', 'lost', 'odd'].map((name) =>
            whole(sum(rows, name)),
          ),
          rows.filter((row) => row.broken).length,
        ],
      ],
    ),
  );
}

/** What one daemon carries, and what became of shards that were disturbed. */
function scaleDoc() {
  const middle = (/** @type {any[]} */ rows, /** @type {string} */ name) => {
    const sorted = rows.map((row) => Number(row[name])).sort((a, b) => a - b);
    return sorted[Math.floor(sorted.length / 2)];
  };
  return {
    capacity: held('capacity', 'bench/run capacity', (rows) =>
      table(
        [
          'Sessions',
          'Viewers',
          'Frames/s of each',
          'Frames lost',
          'Interval p99, ms',
          'CPU of a frame, us',
          'CPU, % of a core',
          'Memory, MB',
        ],
        [...new Set(rows.map((row) => `${row.sessions} ${row.viewers}`))].map((way) => {
          const of = rows.filter((row) => `${row.sessions} ${row.viewers}` === way),
            sessions = of[0].sessions;
          const [viewers, ...figures] = ['viewers', 'hz', 'interval_p99_ms', 'us_per_frame', 'cpu_pct', 'rss_mb'].map((name) =>
            middle(of, name),
          );
          figures.splice(1, 0, Math.max(...of.map((row) => Number(row.lost))));
          return [whole(sessions), whole(viewers), ...figures];
        }),
      ),
    ),
    shards: held('shards', 'bench/run shards', ([row]) =>
      table(
        ['Figure', 'Value'],
        [
          ['Sessions, classes, faults, seconds', `${row.sessions}, ${row.classes}, ${row.faults}, ${whole(row.wall_s)}`],
          ['Acknowledged commands; lost; stored twice', `${whole(row.acknowledged)}; ${row.lost}; ${row.twice}`],
          ['Commands without a good answer; of these stored', `${whole(row.unanswered)}; ${whole(row.unanswered_stored)}`],
          ['Replays; with another hash', `${whole(row.replayed)}; ${row.replays_differ}`],
          ['Runs of the same commands in an undisturbed daemon; with another hash', `${whole(row.twins)}; ${row.twins_differ}`],
          ['Votes; losses of classes', `${whole(row.votes)}; ${row.classes_lost}`],
          ['Most ticks that a view went back', row.back_ticks],
          ['Latency of a command without faults, p50 and p99, ms', `${row.command_p50_ms}, ${row.command_p99_ms}`],
        ],
      ),
    ),
    gaps: held('shards/gaps', 'bench/run shards', (rows) =>
      table(
        ['What happened', 'Times', 'Viewers without frames', 'p50, s', 'p99, s', 'longest, s'],
        rows.map((row) => [row.fault, row.times, whole(row.viewers), row.gap_p50_s, row.gap_p99_s, row.gap_max_s]),
      ),
    ),
  };
}

/** What is left when the load rests. */
function restsDoc() {
  return held('soak', 'bench/run soak', (rows) =>
    table(
      ['After, s', 'Anonymous memory, MiB', 'Descriptors', 'Threads', 'Sessions', 'Disk, MiB', 'Answers so far'],
      rows
        .filter((row) => row.idle === '1')
        .map((row) => [row.t_s, row.anonymous_mib, row.descriptors, row.threads, row.sessions, row.disk_mib, whole(row.requests)]),
    ),
  );
}

function soakDoc() {
  return held('soak', 'bench/run soak', (rows) => {
    const quarter = Math.floor((rows.length - 1) / 4),
      part = (/** @type {number} */ i) => rows.slice(i * quarter, (i + 1) * quarter),
      last = rows[rows.length - 1];
    const mean = (/** @type {any[]} */ some, /** @type {string} */ name) => (sum(some, name) / some.length).toFixed(1);
    const line = (/** @type {string} */ what, /** @type {any[]} */ some) => [
      what,
      `${some[0].t_s} to ${some[some.length - 1].t_s}`,
      mean(some, 'anonymous_mib'),
      Math.max(...some.map((row) => Number(row.anonymous_mib))),
      Math.max(...some.map((row) => Number(row.descriptors))),
      Math.max(...some.map((row) => Number(row.threads))),
      some[some.length - 1].disk_mib,
      whole(some[some.length - 1].requests),
    ];
    return table(
      ['Part', 's', 'Anonymous memory, mean MiB', 'most', 'Descriptors, most', 'Threads, most', 'Disk at its end, MiB', 'Answers so far'],
      [...['first quarter', 'second', 'third', 'last'].map((what, i) => line(what, part(i))), line('after the load', [last])],
    );
  });
}

function fuzzDoc() {
  return held('fuzz', 'node tests/fuzz/campaign.mjs --build=fuzz --runs=1e7 READER', (rows) =>
    table(
      ['Reader', 'What it reads', 'Sanitizers', 'Executions', 'Wall time, s', 'Edges reached', 'Inputs kept', 'Broke a rule'],
      rows.map((row) => [
        code(row.reader),
        READERS[row.reader],
        SANITIZED[row.build],
        whole(row.executions),
        whole(row.seconds),
        row.edges,
        row.corpus,
        row.crashes,
      ]),
    ),
  );
}

/** Cases that follow each other as `1.2.1 to 1.2.8`. @param {any[]} rows @param {string} kind @param {string} why */
function casesOf(rows, kind, why) {
  const parts = [];
  let run = [];
  const flush = () => {
    if (run.length) parts.push(run.length > 2 ? `${run[0]} to ${run[run.length - 1]}` : run.join(', '));
    run = [];
  };
  for (const row of rows) {
    if (row.kind === kind && row.why === why) run.push(row.case);
    else flush();
  }
  flush();
  return parts.join(', ');
}

/** What Autobahn says of each case, and why some are not strict. */
function autobahnDoc() {
  return held('autobahn', 'bench/run autobahn --testsuite DIR', (rows) => {
    const kinds = [...new Set(rows.map((row) => row.kind))];
    const ways = [...new Set(rows.map((row) => `${row.daemon}, ${row.writes}`))];
    const of = (/** @type {string} */ way) => rows.filter((row) => `${row.daemon}, ${row.writes}` === way);
    const reasons = [...new Map(rows.filter((row) => row.why).map((row) => [`${row.kind} ${row.why}`, row])).values()];
    return [
      table(
        ['Daemon, writes', 'Cases', ...kinds],
        ways.map((way) => [way, of(way).length, ...kinds.map((kind) => of(way).filter((row) => row.kind === kind).length)]),
      ),
      table(
        ['Not strict', 'Why', ...ways],
        reasons.map(({ kind, why }) => [kind, why, ...ways.map((way) => casesOf(of(way), kind, why))]),
      ),
    ].join('\n');
  });
}

/** What came of the suites at the daemon's port: tables by their results. */
function portDoc() {
  const most = (/** @type {any[]} */ rows, /** @type {string} */ name) => Math.max(...rows.map((row) => Number(row[name])));
  const ms = (/** @type {number} */ value) => String(Number(value.toPrecision(3)));
  const unique = (/** @type {any[]} */ rows, /** @type {(row: any) => string} */ by) => [...new Set(rows.map(by))];
  return {
    suites: held('suites', 'bench/run suites', (rows) =>
      table(
        ['Suite', 'Way', 'Tried', 'Failed'],
        rows.map((row) => [row.suite, row.way, `${whole(row.tried)} ${row.of}`, row.failed]),
      ),
    ),
    validate: held('validate', 'bench/run validate', (rows) =>
      table(
        ['Operations', 'Answers', 'Judged by Prism', 'Kinds of answers (operation and status)', 'Violations'],
        [
          [
            rows.length,
            whole(sum(rows, 'answers')),
            whole(sum(rows, 'judged')),
            rows.reduce((total, row) => total + row.statuses.split(' ').filter(Boolean).length, 0),
            sum(rows, 'violations'),
          ],
        ],
      ),
    ),
    hostile: held('hostile', 'bench/run hostile', (rows) =>
      table(
        ['Four clients send', "p99 of others' requests, ms", 'without the attack', 'Frames off their interval, p99, ms', 'Idle after, s'],
        unique(
          rows.filter((row) => row.what !== 'sigterm'),
          (row) => row.attack,
        ).map((attack) => {
          const of = rows.filter((row) => row.attack === attack && row.what !== 'sigterm'),
            requests = of.filter((row) => !row.what.startsWith('frame'));
          return [
            code(attack),
            ms(most(requests, 'p99_ms')),
            ms(most(requests, 'alone_p99_ms')),
            ms(
              most(
                of.filter((row) => row.what === 'frame_published'),
                'p99_ms',
              ),
            ),
            ms(most(of, 'idle_s')),
          ];
        }),
      ),
    ),
    stall: held('stall', 'bench/run stall', (rows) =>
      table(
        [
          'Daemon',
          'Clients',
          'Control calls, p50, ms',
          'p99',
          'largest p99 of one operation',
          'Operations above 50 ms',
          'Frames late, %',
          'lost, %',
        ],
        rows
          .filter((row) => ['none', 'all'].includes(row.operation))
          .map((row) => {
            const of = rows.filter((one) => one.daemon === row.daemon && one.clients === row.clients && one.operation !== 'all'),
              worst = most(of, 'p99');
            return [
              row.daemon,
              row.clients,
              ms(Number(row.p50)),
              ms(Number(row.p99)),
              `${ms(worst)} (${code(of.find((one) => Number(one.p99) === worst).operation)})`,
              of.filter((one) => Number(one.p99) > 50).length,
              ms(100 * row.late),
              ms(100 * row.lost),
            ];
          }),
      ),
    ),
    slow: held('slow', 'bench/run slow', (rows) =>
      table(
        ['Way', 'Session', 'A viewer reads a fifth of', 'Oldest frame that it saw, ms', 'Frames that fast viewers lost'],
        unique(rows, (row) => `${row.way}\n${row.scenario}\n${row.reads}`).map((key) => {
          const of = rows.filter((row) => `${row.way}\n${row.scenario}\n${row.reads}` === key);
          return [...key.split('\n'), ms(most(of, 'slow_age_max_ms')), sum(of, 'fast_lost')];
        }),
      ),
    ),
  };
}

function crossDoc() {
  return held('cross', './dev cross', (rows) =>
    table(
      ['CPU', 'Scenarios', 'With the same hash and metrics', 'Compiler', 'Emulator', 'Commit', 'When'],
      rows.map((row) => [row.cpu, row.scenarios, row.equal, `gcc ${row.compiler}`, `qemu ${row.emulator}`, row.commit, row.date]),
    ),
  );
}

// ---- presets of links ----

/** What each sets that is not the default, from the log of a run in which every player has one. */
function presetsDoc(binary, schema) {
  const names = schema.$defs.link_pair.properties.preset.enum.slice(1),
    rows = [];
  const defaults = Object.fromEntries(Object.entries(schema.$defs.link.properties).map(([name, row]) => [name, row.default]));
  const most = 8,
    folder = mkdtempSync(path.join(tmpdir(), 'laglab-presets-')),
    file = path.join(folder, 'log');
  for (let from = 0; from < names.length; from += most) {
    const players = names.slice(from, from + most).map((preset) => ({ link: { preset } }));
    execFileSync(binary, ['run', '-', '--log', file], { input: JSON.stringify({ kind: 'netgame', duration_s: 1, players }) });
    const [create] = readFileSync(file, 'utf8').split('\n');
    for (const { link } of JSON.parse(create).scenario.players) {
      const { delay_ms, jitter_ms, distribution, loss_pct, ...others } = link.up;
      const more = Object.entries(others).filter(([name, value]) => value !== defaults[name]);
      rows.push([
        code(link.preset),
        delay_ms,
        jitter_ms,
        distribution,
        loss_pct,
        more.map(([name, value]) => `${code(name)} ${value}`).join(', '),
      ]);
    }
  }
  rmSync(folder, { recursive: true });
  return table(['`preset`', '`delay_ms`', '`jitter_ms`', '`distribution`', '`loss_pct`', 'And'], rows);
}

// ---- files ----

/** The file with each body between the marks of its name. @param {string} file @param {Record<string, string>} bodies */
function filled(file, bodies) {
  return Object.entries(bodies).reduce((text, [name, body]) => fill(file, text, name, body), read(file));
}

function fill(file, text, name, body) {
  return between(file, text, `<!-- generated: ${name} -->`, '<!-- end -->', `\n${body.replace(/\n{3,}/g, '\n\n').trim()}\n`);
}

function between(file, text, begin, end, body) {
  const from = text.indexOf(begin),
    to = text.indexOf(end, from);
  if (from < 0 || to < 0) throw new Error(`${file} has no ${begin} ... ${end}`);
  return `${text.slice(0, from + begin.length)}\n${body}\n${text.slice(to)}`;
}

/** Every generated file with the text that it should have. @param {string} binary @returns {Map<string, string>} */
export function generate(binary) {
  const laglab = (/** @type {string[]} */ ...args) => execFileSync(binary, args, { encoding: 'utf8' });
  const schema = JSON.parse(laglab('schema')),
    records = JSON.parse(laglab('schema', 'stream'));
  const asyncapi = between('api/asyncapi.yaml', read('api/asyncapi.yaml'), '    # generated: records', '    # end', asyncSchemas(records));
  return new Map([
    ['api/asyncapi.yaml', asyncapi],
    ['www/js/stream/records.js', recordsModule(records)],
    ['www/js/stream/rows.js', rowsModule(records)],
    ['www/js/stream/names.js', namesModule(records)],
    [
      'docs/scenario.md',
      scenarioDoc(schema)
        .replace(/\n{3,}/g, '\n\n')
        .trimEnd() + '\n',
    ],
    ['docs/metrics.md', metricsDoc(JSON.parse(laglab('schema', 'metrics')))],
    ['docs/paper.md', paperDoc()],
    ['docs/published.md', publishedDoc(parseCsv, measuredDoc)],
    ['docs/tradeoff.md', tradeoffDoc(JSON.parse(laglab('tradeoff', '--list')), parseCsv, measuredDoc)],
    ['docs/columns.md', columnsDoc(JSON.parse(laglab('schema', 'traces')), JSON.parse(laglab('schema', 'results')))],
    ['docs/api.md', apiDoc(YAML.parse(read('api/openapi.yaml')), YAML.parse(asyncapi))],
    ['docs/accuracy.md', filled('docs/accuracy.md', { 'closed forms': closedFormsDoc() })],
    ['docs/concepts.md', filled('docs/concepts.md', { presets: presetsDoc(binary, schema) })],
    ['docs/deploy.md', filled('docs/deploy.md', { options: optionsDoc(laglab('serve', '--help')) })],
    ['docs/scale.md', filled('docs/scale.md', scaleDoc())],
    [
      'docs/trust.md',
      filled('docs/trust.md', {
        mutants: mutantsDoc(),
        kills: killsDoc(),
        full: fullDoc(),
        soak: soakDoc(),
        rests: restsDoc(),
        fuzz: fuzzDoc(),
        'other CPUs': crossDoc(),
        autobahn: autobahnDoc(),
        ...portDoc(),
      }),
    ],
    ['docs/performance.md', filled('docs/performance.md', { results: RESULTS.map(resultDoc).join('\n\n'), memory: memoryDoc(laglab) })],
  ]);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const binary = process.env.LAGLAB_BIN ?? path.join(ROOT, 'build/laglab');
  for (const [file, text] of generate(binary)) {
    const before = existsSync(path.join(ROOT, file)) ? read(file) : '';
    mkdirSync(path.dirname(path.join(ROOT, file)), { recursive: true });
    if (before !== text) writeFileSync(path.join(ROOT, file), text);
    console.log(`${before === text ? 'as it was' : 'written  '}  ${file}`);
  }
}
