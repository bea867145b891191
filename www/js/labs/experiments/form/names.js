// What parameters and metrics are called: by the kind of their scenario, with whose they are and their units. Paths stand in tooltips.
import { language, choiceOf, nameOf, need, t, unitName } from '../../../base/words.js';
import { labelOf } from '../../../base/schema.js';
import { LENGTH } from './parts.js';

/** Of a path. @typedef {(path: string) => string | undefined} UnitOf */

/** Parts of the words that have the names of a kind. @param {string} kind @returns {Promise<unknown>} when they are there */
export const needKind = (kind) => Promise.all((kind === 'netgame' ? ['netgame_more', 'netgame_metrics'] : [kind]).map(need));

/** @param {number} n @param {any} scenario */
const playerOf = (n, scenario) => t('experiments.player', { name: scenario?.players?.[n]?.name || String.fromCharCode(65 + n) });

/** Whose a value is. @param {string[]} names of a path @param {any} scenario */
function ownerOf(names, scenario) {
  const [first = '', index = ''] = names,
    n = Number(index);
  if (first === 'players' && Number.isInteger(n)) return playerOf(n, scenario);
  if (first === 'methods' && Number.isInteger(n)) return t('experiments.method', { n: n + 1 });
  return first === 'side_by_side' ? t('experiments.side_n', { n: n + 2 }) : '';
}

/** @param {string} path @param {any} scenario @returns {string} of the part of the scenario that has the parameter, such as Player A ›
 * link */
export function placeOf(path, scenario) {
  const names = path.split('.').slice(0, -1),
    owner = ownerOf(names, scenario);
  if (names.length === 0) return t('experiments.scenario');
  const rest = (owner === '' ? names : names.slice(2)).map((name) =>
    /^\d+$/.test(name) ? String(Number(name) + 1) : t(`experiments.place.${name}`) || name.replaceAll('_', ' '),
  );
  return [owner, ...rest].filter((text) => text !== '').join(' › ');
}

/** With its unit, where the name does not have it already. @param {string} name @param {string | undefined} unit */
const inUnit = (name, unit) => (!unit || (unit === '1/s' && name.endsWith(unitName(unit))) ? name : `${name} (${unitName(unit)})`);

/** @param {string} path @param {string | undefined} unit @param {any} scenario */
export const inputName = (path, unit, scenario) => inUnit(labelOf(scenario?.kind ?? '', path), unit);

/** The same, and whose it is. @param {string} path @param {string | undefined} unit @param {any} scenario */
export function wholeName(path, unit, scenario) {
  const owner = ownerOf(path.split('.'), scenario),
    name = inputName(path, unit, scenario);
  return owner === '' ? name : `${owner}: ${name}`;
}

/** A value as a person reads it. @param {string} path @param {unknown} value @param {any} scenario
 * @returns {string | undefined} of a choice */
export function chosenName(path, value, scenario) {
  if (typeof value === 'boolean' || value === 'true' || value === 'false')
    return t(String(value) === 'true' ? 'experiments.on' : 'experiments.off');
  if (typeof value !== 'string') return undefined;
  return choiceOf(scenario?.kind ?? '', path, value);
}

/** A row of the table of metrics that a path leads into: its name, what stands for a name in it, and which part of its value is meant.
 * @param {string} kind @param {string[]} names @returns {{label: string, tip: string, of: string, part: string} | undefined} */
function rowOf(kind, names) {
  for (let n = names.length; n > 0; n--) {
    const key = names.slice(0, n).map((name) => (/^\d+$/.test(name) ? '*' : name)),
      part = names.slice(n).join('.');
    const known = nameOf(kind, 'metrics', key.join('.'));
    if (known) return { ...known, of: '', part };
    for (let i = 1; i < n; i++) {
      const found = nameOf(kind, 'metrics', key.map((name, k) => (k === i ? '*' : name)).join('.'));
      if (found) return { ...found, of: names[i] ?? '', part };
    }
  }
  return undefined;
}

/** Of what a metric is one of several: a measure, a cause. @param {string} kind @param {string} name */
const partName = (kind, name) =>
  nameOf(kind, 'metrics', `players.*.${name}`)?.label ?? (t(`experiments.part.${name}`) || name.replaceAll('_', ' '));

const COST = 'cost.ns_per_sim_s';

/** Of a column of the trace, in a window. @param {string} path @param {any} scenario */
function columnStatistic(path, scenario) {
  const [, column = '', part = ''] = /^([a-z0-9_]+)\.([a-z0-9]+)$/.exec(path) ?? [],
    said = column === '' ? '' : t(`experiments.part.${part}`);
  return said === '' ? undefined : `${columnOwner(column, scenario)}: ${columnName(column, scenario, () => undefined)}, ${said}`;
}

/** Whose a column of the trace is: that of a player, a method or a body. @param {string} column @param {any} scenario */
export function columnOwner(column, scenario) {
  const [, side = '', rest = column] = /^side_by_side(\d+)_(.*)$/.exec(column) ?? [],
    [, of, index = ''] = /^(player_|server_|)(\d+)_/.exec(rest) ?? [],
    n = Number(index);
  const own =
    of === undefined
      ? ''
      : of !== ''
        ? playerOf(n, scenario)
        : scenario?.kind === 'motion'
          ? t('experiments.method', { n: n + 1 })
          : `${t('experiments.place.bodies')} ${n + 1}`;
  return (
    [side === '' ? '' : t('experiments.side_n', { n: Number(side) + 2 }), own].filter(Boolean).join(' › ') || t('experiments.scenario')
  );
}

/** A column of the trace without its owner. @param {string} column @param {any} scenario @param {UnitOf} unitOf of a metric */
export function columnName(column, scenario, unitOf) {
  const kind = scenario?.kind ?? '',
    [, of = '', name = ''] = /^(?:side_by_side\d+_)?(?:(player_|server_|)\d+_)?(.*)$/.exec(column) ?? [];
  const path = of === 'player_' ? `players.*.${name}` : name,
    known = of === 'server_' ? undefined : nameOf(kind, 'metrics', path),
    here = t(`experiments.tick.${name}`) || name.replaceAll('_', ' ');
  if (known) return inUnit(known.label, unitOf(path.replace('*', '0')));
  return of === 'server_' ? t('experiments.tick.at_server', { name: here }) : here;
}

/** Of one in a window, as `PATH@WINDOW`, with its name. @param {string} path @param {string | undefined} unit @param {any} scenario
 * @returns {string} */
export function metricName(path, unit, scenario) {
  if (path === COST) return t('experiments.cost_metric');
  const [bare = '', window = ''] = path.split('@');
  if (window !== '') return t('experiments.in_window', { metric: metricName(bare, unit, scenario), name: window });
  if (bare === LENGTH) return t('experiments.window.length');
  const names = path.split('.'),
    kind = scenario?.kind ?? '',
    owner = ownerOf(names, scenario);
  const row = rowOf(kind, names[0] === 'side_by_side' ? names.slice(2) : names);
  if (!row) return columnStatistic(path, scenario) ?? path;
  const of = row.of === '' ? '' : `, ${partName(kind, row.of)}`,
    part = row.part === '' ? '' : `, ${t(`experiments.part.${row.part}`) || row.part.replaceAll('_', ' ')}`;
  return inUnit(`${owner === '' ? '' : `${owner}: `}${row.label}${of}${part}`, /^(count|lost_ratio)$/.test(row.part) ? '' : unit);
}

/** What a metric is, in the language of the page: the daemon's own help is English. @param {string} path @param {string} help
 * @param {any} scenario */
export function metricTip(path, help, scenario) {
  if (language.value === 'en' || path === COST) return language.value === 'en' ? help : t('experiments.cost_tip');
  return rowOf(scenario?.kind ?? '', path.split('.'))?.tip ?? '';
}

/** Of an experiment. @param {string} state */
export const stateOf = (state) => t(`experiments.state.${state}`) || state;
