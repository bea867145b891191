// Values that a seed determines: numbers, and JSON that schemas describe, or nearly.

/** Numbers in [0, 1) (mulberry32). @param {number} seed */
export function random(seed) {
  let state = seed | 0;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let x = Math.imul(state ^ (state >>> 15), 1 | state);
    x = (x + Math.imul(x ^ (x >>> 7), 61 | x)) ^ x;
    return ((x ^ (x >>> 14)) >>> 0) / 4294967296;
  };
}

/** One seed of several numbers. @param {...number} numbers */
export const seedOf = (...numbers) => numbers.reduce((seed, n) => Math.floor(random(seed ^ Math.imul(n + 1, 0x9e3779b1))() * 2 ** 32), 1);

const deep = (n) => '['.repeat(n) + ']'.repeat(n);
const JUNK = [
  null,
  true,
  false,
  '',
  'x',
  '0',
  'race',
  -1,
  0,
  1,
  2,
  0.5,
  63,
  64,
  65,
  1e-320,
  1e308,
  -1e308,
  1e16,
  -5,
  2 ** 31,
  2 ** 32,
  2 ** 53 + 2,
  -(2 ** 63),
].concat(
  /** @type {any[]} */ ([
    [],
    {},
    [[]],
    [1, 2],
    [null],
    { x: 1 },
    { 0: {} },
    { '': 1 },
    JSON.parse(deep(40)),
    'y'.repeat(3000),
    '\u0000',
    '\ud800',
    'ä→😀',
    '-1',
    '1e999',
    '../..',
    '%00',
  ]),
);

/** @param {() => number} next @param {{resolve: (node: any, root: any) => [any, any]}} of */
export function drawer(next, of) {
  const chance = (p) => next() < p,
    below = (n) => Math.floor(next() * n),
    pick = (list) => list[below(list.length)];

  /** A number of the schema's range: often an end of it, sometimes beyond it. */
  function number(schema, whole) {
    const low = schema.minimum ?? schema.exclusiveMinimum ?? (schema.maximum < 0 ? 10 * schema.maximum : 0),
      high = schema.maximum ?? schema.exclusiveMaximum ?? (low > 0 ? 1000 * low : 1000);
    const which = next();
    let x = low + (high - low) * next();
    if (which < 0.2 && typeof schema.default === 'number') x = schema.default * (chance(0.5) ? 1 : 2 * next());
    else if (which < 0.4 && high > 0)
      x = Math.max(low, high * 10 ** (-8 * next())); // small ones as often
    else if (which < 0.5) x = low;
    else if (which < 0.6) x = high;
    else if (which < 0.63) x = low + pick([1e-300, 1e-9 * (high - low)]);
    else if (which < 0.65) x = high * 1.0001 + 1;
    else if (which < 0.67) x = low - 1e-6 - Math.abs(low) * 1e-6;
    else if (which < 0.7) x = pick([0, 1, -1, 0.1]);
    return whole ? Math.floor(x) : x;
  }

  function text(schema) {
    const room = schema.maxLength ?? 40;
    return pick([
      '',
      'x',
      'race',
      'A',
      'players.0.lag_ms',
      'ü'.repeat(Math.min(room, 30)),
      'm'.repeat(room),
      'm'.repeat(Math.min(room + 1, 5000)),
      'a b"\\',
      '<b>',
    ]);
  }

  /** The schemas of an object's members, with what follows from values that it has (`if` and `then`). */
  function narrowed(schema, value) {
    const properties = { ...schema.properties };
    for (const { if: when, then } of schema.allOf ?? []) {
      const [[name, is]] = /** @type {[string, any][]} */ (Object.entries(when?.properties ?? { '': {} }));
      if (is.const !== undefined && (value?.[name] ?? schema.properties[name]?.default) === is.const)
        Object.assign(properties, then.properties);
    }
    return properties;
  }

  /** @returns {any} */
  function make(node, root, depth = 0) {
    const [schema, at] = of.resolve(node, root);
    if (schema.const !== undefined) return schema.const;
    if (schema.enum) return pick(schema.enum);
    const branch = schema.oneOf ?? schema.anyOf;
    if (branch) return make(pick(branch), at, depth);
    if (schema.allOf && !schema.properties) return Object.assign({}, ...schema.allOf.map((one) => make(one, at, depth)));
    const type = Array.isArray(schema.type) ? pick(schema.type) : (schema.type ?? (schema.properties ? 'object' : undefined));
    switch (type) {
      case 'number':
        return number(schema, false);
      case 'integer':
        return number(schema, true);
      case 'boolean':
        return chance(0.5);
      case 'string':
        return text(schema);
      case 'null':
        return null;
      case 'array': {
        const low = schema.minItems ?? 0,
          count = chance(0.05) ? Math.min(schema.maxItems ?? 5, 70) : Math.min(schema.maxItems ?? 9, low + below(depth > 3 ? 2 : 4));
        return Array.from({ length: count }, () => make(schema.items ?? {}, at, depth + 1));
      }
      case 'object': {
        const made = {},
          wanted = (/** @type {[string, any]} */ [name]) => schema.required?.includes(name) || chance(depth > 2 ? 0.1 : 0.25);
        for (const [name, one] of Object.entries(schema.properties ?? {}).filter(wanted))
          made[name] = make(narrowed(schema, made)[name] ?? one, at, depth + 1);
        return made;
      }
      default:
        return pick(JUNK);
    }
  }

  /** The same with one thing wrong. */
  function corrupt(value) {
    if (value === null || typeof value !== 'object' || chance(0.1)) return pick(JUNK);
    const keys = Object.keys(value);
    if (keys.length === 0 || chance(0.1))
      return Array.isArray(value) ? [...value, pick(JUNK)] : { ...value, [pick(['x', '', '0', 'kind', '__proto__', 'a.b'])]: pick(JUNK) };
    const key = pick(keys),
      copy = Array.isArray(value) ? [...value] : { ...value };
    if (chance(0.15)) {
      if (Array.isArray(copy)) copy.splice(Number(key), 1);
      else delete copy[key];
    } else copy[key] = corrupt(copy[key]);
    return copy;
  }

  /** JSON, sometimes damaged as a text. */
  function written(value) {
    const json = JSON.stringify(value) ?? 'null';
    if (!chance(0.06)) return json;
    const at = below(json.length);
    return pick([
      () => json.slice(0, at),
      () => json.slice(0, at) + String.fromCharCode(below(128)) + json.slice(at + 1),
      () => `${json}${json}`,
      () => `\ufeff${json}`,
      () => json.replace(/\d+/, '1e999'),
      () => json.replace(/\d+/, 'NaN'),
      () => json.replace('{', '{"x":1,"x":2,'),
      () => deep(5000),
      () => '',
    ])();
  }

  /** Paths of a value's leaves that the schema has, with their schemas: [path, schema, root, value]. */
  function leaves(node, root, value, path = '', found = /** @type {[string, any, any, any][]} */ ([])) {
    let [schema, at] = of.resolve(node, root);
    const branches = schema.oneOf ?? schema.anyOf;
    if (branches) {
      for (const one of branches) {
        const [inner, where] = of.resolve(one, at);
        if (inner.properties && value && typeof value === 'object' && Object.keys(value).every((key) => key in inner.properties)) {
          const kind = inner.properties.kind?.const;
          if (kind !== undefined && kind !== value.kind) continue;
          [schema, at] = [inner, where];
          break;
        }
      }
    }
    const join = (key) => (path ? `${path}.${key}` : key);
    if (schema.properties) {
      for (const [key, one] of Object.entries(narrowed(schema, value))) leaves(one, at, value?.[key], join(key), found);
    } else if (schema.type === 'array') {
      if (Array.isArray(value)) for (let i = 0; i < value.length && i < 4; i++) leaves(schema.items, at, value[i], join(String(i)), found);
      found.push([path, schema, at, value]);
    } else if (path) found.push([path, schema, at, value]);
    return found;
  }

  return { next, chance, below, pick, make, corrupt, written, leaves, junk: () => pick(JUNK) };
}
