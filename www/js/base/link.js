// What the address says: scenario, changed parameters, seed, theme, and the session to join.

/** @typedef {string | number | boolean | object} Value */

/**
 * @typedef {object} Link
 * @property {string} scenario
 * @property {Record<string, Value>} set    changed parameters by dotted path
 * @property {number | null} seed
 * @property {string} theme       auto, light, dark or projector
 * @property {string} session     of the fragment; empty when the page makes its own
 * @property {string} key         of the fragment; removed from the address bar at once
 * @property {string | null} experiment  of `#experiments=ID`; empty for the view alone; null when a lab is wanted
 * @property {string[]} problems  what was ignored, in words
 */

export const THEMES = ['auto', 'light', 'dark', 'projector'];
export const FIRST_SCENARIO = 'race';
/** The labs, with the scenario that each opens: by its button, or by a short address such as `/#step`. Scenarios of the games and kinds
 * that it shows belong to it. @type {{id: string, name: string, scenario: string, shows: string[]}[]} */
export const LABS = [
  { id: 'race', name: 'Race', scenario: 'race', shows: ['race', 'gambetta'] },
  { id: 'cannon', name: 'Cannon', scenario: 'cannon', shows: ['cannon'] },
  { id: 'shoot', name: 'Shoot', scenario: 'rifle', shows: ['shooter'] },
  { id: 'crates', name: 'Crates', scenario: 'crates', shows: ['crates'] },
  { id: 'step', name: 'Step', scenario: 'motion/free_fall', shows: ['motion'] },
  { id: 'collide', name: 'Collide', scenario: 'rigid/pyramid', shows: ['rigid'] },
  { id: 'fluid', name: 'Fluid', scenario: 'fluid/cylinder', shows: ['fluid', 'sea', 'dam'] },
];

/** @param {string} text @returns {Value} */
function toValue(text) {
  if (text === 'true' || text === 'false') return text === 'true';
  if (/^[[{]/.test(text)) {
    try {
      return JSON.parse(text);
    } catch {
      /* then it is a text */
    }
  }
  const number = Number(text);
  return text.trim() !== '' && Number.isFinite(number) ? number : text;
}

/** @param {string} hash @returns {string | null} */
export function readExperiment(hash) {
  const found = /^#experiments(?:=([A-Za-z0-9_-]{1,64}))?$/.exec(hash);
  return found ? (found[1] ?? '') : null;
}

/** @param {string} search @param {string} hash @returns {Link} */
export function readLink(search, hash) {
  const query = new URLSearchParams(search);
  const fragment = new URLSearchParams(hash.replace(/^#/, ''));
  /** @type {Link} */
  const link = {
    scenario: FIRST_SCENARIO,
    set: {},
    seed: null,
    theme: 'auto',
    session: '',
    key: '',
    experiment: readExperiment(hash),
    problems: [],
  };

  const scenario = query.get('scenario');
  if (scenario === null) link.scenario = LABS.find((lab) => lab.id === hash.slice(1))?.scenario ?? FIRST_SCENARIO;
  if (scenario !== null && /^[a-z0-9_/-]{1,64}$/.test(scenario)) link.scenario = scenario;
  else if (scenario !== null) link.problems.push(`scenario=${scenario} ignored, using ${FIRST_SCENARIO}`);

  for (const item of query.getAll('set')) {
    const cut = item.indexOf(':');
    const path = item.slice(0, cut);
    if (cut > 0 && /^[a-z0-9_.]{1,96}$/.test(path)) link.set[path] = toValue(item.slice(cut + 1));
    else link.problems.push(`set=${item} ignored: write set=path:value`);
  }

  const seed = query.get('seed');
  if (seed !== null && /^[0-9]{1,15}$/.test(seed)) link.seed = Number(seed);
  else if (seed !== null) link.problems.push(`seed=${seed} ignored: a seed is a whole number, using the scenario's`);

  const theme = query.get('theme');
  if (theme !== null && THEMES.includes(theme)) link.theme = theme;
  else if (theme !== null) link.problems.push(`theme=${theme} ignored: it is one of ${THEMES.join(', ')}`);

  const session = fragment.get('s') ?? '';
  if (/^[A-Za-z0-9_-]{1,64}$/.test(session)) {
    link.session = session;
    link.key = fragment.get('k') ?? '';
  } else if (session !== '') {
    link.problems.push('The session in the address is not an id; a new one was created');
  }
  return link;
}

/** The query that gives the same set-up elsewhere: only what differs from the scenario.
 * @param {Pick<Link, 'scenario' | 'set' | 'seed' | 'theme'>} link @returns {string} */
export function writeQuery(link) {
  const parts = [];
  if (link.scenario !== FIRST_SCENARIO || Object.keys(link.set).length > 0) parts.push(`scenario=${link.scenario}`);
  for (const [path, value] of Object.entries(link.set))
    parts.push(`set=${path}:${encodeURIComponent(typeof value === 'object' ? JSON.stringify(value) : String(value))}`);
  if (link.seed !== null) parts.push(`seed=${link.seed}`);
  if (link.theme !== 'auto') parts.push(`theme=${link.theme}`);
  return parts.length > 0 ? `?${parts.join('&')}` : '';
}
