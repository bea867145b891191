// Finds the row of a parameter in the daemon's JSON Schema: its type, range, unit and help.
import { inputOf, t } from './words.js';

/**
 * @typedef {object} Row
 * @property {string} name
 * @property {'number' | 'integer' | 'boolean' | 'choice' | 'text'} type
 * @property {number} min
 * @property {number} max
 * @property {string[]} choices
 * @property {string} unit
 * @property {string} help
 * @property {boolean} live
 * @property {any} byDefault  value where none is given; undefined where there is none
 */

/** Follows references and picks the branch of a union that has the key wanted.
 * @param {any} root @param {any} node @param {string} [key] @returns {any} */
export function open(root, node, key) {
  let at = node;
  for (let hops = 0; at && typeof at.$ref === 'string' && hops < 16; hops++) {
    at = at.$ref
      .split('/')
      .slice(1)
      .reduce((/** @type {any} */ place, /** @type {string} */ part) => place?.[part.replaceAll('~1', '/').replaceAll('~0', '~')], root);
  }
  if (!at) return undefined;
  const branches = [...(at.oneOf ?? []), ...(at.anyOf ?? []), ...(at.allOf ?? [])];
  if (branches.length > 0 && (key === undefined || !at.properties?.[key])) {
    for (const branch of branches) {
      const found = open(root, branch, key);
      if (found && (key === undefined || found.properties?.[key])) return found;
    }
  }
  return at;
}

/** @param {any} root @param {string} path such as players.0.link.up.jitter_ms @returns {any} the schema of the value */
function nodeOf(root, path) {
  let at = root;
  for (const part of path.split('.')) {
    if (/^[0-9]+$/.test(part)) {
      const list = open(root, at);
      at = list?.prefixItems?.[Number(part)] ?? list?.items;
    } else {
      at = open(root, at, part)?.properties?.[part];
    }
    if (!at) return undefined;
  }
  return at;
}

/** @param {string} name @param {any} node its own words @param {any} type the place with its type @returns {Row} */
export function rowOf(name, node, type) {
  const choices = node.enum ?? type.enum;
  const kind = choices
    ? 'choice'
    : type.type === 'boolean'
      ? 'boolean'
      : type.type === 'integer'
        ? 'integer'
        : type.type === 'number'
          ? 'number'
          : 'text';
  return {
    name,
    type: kind,
    min: node.minimum ?? type.minimum ?? 0,
    max: node.maximum ?? type.maximum ?? 1,
    choices: (choices ?? []).map(String),
    unit: node['x-unit'] ?? type['x-unit'] ?? '',
    help: node.description ?? type.description ?? '',
    live: (node['x-live'] ?? type['x-live'] ?? false) === true,
    byDefault: node.default ?? type.default,
  };
}

/** @param {any} root @param {string} path @returns {Row | null} */
export function find(root, path) {
  const node = root && nodeOf(root, path);
  if (!node) return null;
  return rowOf(path.slice(path.lastIndexOf('.') + 1), node, open(root, node));
}

/** Every value below a path that can change during a run, in the tables' order; with `all` also those that are set before it.
 * @param {any} root @param {string} path @param {boolean} [all] @returns {string[]} */
export function livePaths(root, path, all = false) {
  const object = root && open(root, nodeOf(root, path));
  /** @type {string[]} */
  const paths = [];
  for (const [name, node] of Object.entries(object?.properties ?? {})) {
    const inner = open(root, node);
    if (inner?.properties) paths.push(...livePaths(root, `${path}.${name}`, all));
    else if (inner && (all || rowOf(name, node, inner).live)) paths.push(`${path}.${name}`);
  }
  return paths;
}

/** The visible name of a parameter. @param {string} kind of the scenario @param {string} path @returns {string} */
export function labelOf(kind, path) {
  const name = path.slice(path.lastIndexOf('.') + 1);
  const words = inputOf(kind, path)?.label ?? name.replace(/_(ms|s|hz|pct|m|mps|mps2|per_s)$/, '').replaceAll('_', ' ');
  const direction = path.includes('.link.up.') ? ` ${t('base.up')}` : path.includes('.link.down.') ? ` ${t('base.down')}` : '';
  return words.charAt(0).toUpperCase() + words.slice(1) + direction;
}

/** Groups of rows, by table; rows without a group come last.
 * @type {Record<string, [string, RegExp][]>} */
const GROUPS = {
  player: [
    ['link', /^(lag_ms|link\.preset)$/],
    ['prediction', /^(prediction|reconciliation|ack$|interpolation|extrapolation|time_scale|correction|jitter_margin|dejitter)/],
    ['control', /^(control|authority|script|cheat|lane|slack_ticks|input_delay_ticks|time_dilation|redundancy)$/],
    ['clock', /^(timer_|clock_|drift_|send_hz|display_|input_hz|input_device|float_mode)/],
    ['link_up', /^link\.up\./],
    ['link_down', /^link\.down\./],
  ],
  server: [
    ['rate', /^(update_hz|sync|bucket_|timeout_s|max_rollback)/],
    ['transport', /^(transport|delivery|congestion|nagle)$/],
    ['inputs', /^(validation|detection|refused|starved)/],
    ['shots', /^(hitscan|projectile|max_rewind|rewind_)/],
    ['snapshots', /^(snapshot|quantum_|interest_)/],
  ],
  peers: [['peers', /./]],
};

/** @param {string} at players.0, server, peers, params @param {string[]} paths below it @returns {{title: string, paths: string[]}[]} */
export function grouped(at, paths) {
  const table = GROUPS[/^players\./.test(at) ? 'player' : at] ?? [];
  const place = (/** @type {string} */ path) =>
    (table.findIndex(([, names]) => names.test(path.startsWith(`${at}.`) ? path.slice(at.length + 1) : path)) + table.length + 1) %
    (table.length + 1);
  return [...table.map(([title]) => title), table.length > 0 ? 'more' : 'game']
    .map((title, i) => ({ title: t(`base.group.${title}`), paths: paths.filter((path) => place(path) === i) }))
    .filter((group) => group.paths.length > 0);
}

/** The value at a path. @param {any} object @param {string} path @returns {any} */
export function valueAt(object, path) {
  return path.split('.').reduce((at, part) => at?.[part], object);
}

/** Whether a rule of a schema is for this scenario. @param {any} test its `if` @param {any} scenario @returns {boolean} */
const isFor = (test, scenario) =>
  Object.entries(test.properties).every(([key, { const: value }]) =>
    scenario[key] === undefined ? !test.required?.includes(key) : scenario[key] === value,
  );

/** A scenario's properties: those that depend on its game, problem or scene as the rules of the schema have them, and of those side by side
 * each with its own. @param {any} all @param {any} object @param {any} scenario @returns {any} */
function propertiesOf(all, object, scenario) {
  const found = { ...object.properties };
  for (const rule of object.allOf ?? []) {
    if (!rule.if || !isFor(rule.if, scenario)) continue;
    for (const [key, node] of Object.entries(rule.then.properties)) found[key] = { ...found[key], anyOf: undefined, ...node };
  }
  if (!found.side_by_side) return found;
  const beside = all.$defs[found.side_by_side.items.$ref.split('/').pop()];
  const list = (scenario.side_by_side ?? []).map((/** @type {any} */ one) => ({ properties: propertiesOf(all, beside, one) }));
  return { ...found, side_by_side: { ...found.side_by_side, prefixItems: list } };
}

/** The schema of a scenario. @param {any} all of its kind @param {any} scenario @returns {any} null until it is there */
export function schemaOf(all, scenario) {
  const kind = all?.oneOf[0];
  return kind ? { ...kind, properties: propertiesOf(all, kind, scenario), $defs: all.$defs } : null;
}
