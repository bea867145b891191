// What the address says: scenario, changed parameters, seed, theme, whether it is presented, the session to join, or a lesson.

/** @typedef {string | number | boolean | object} Value */

/**
 * @typedef {object} Link
 * @property {string} scenario  empty until `readScenario`
 * @property {string} first       the scenario where the address names none
 * @property {Record<string, Value>} set    changed parameters by dotted path
 * @property {number | null} seed
 * @property {string} theme       auto, light, dark or projector
 * @property {boolean} present      views and caption alone
 * @property {string} session     of the fragment; empty when the page makes its own
 * @property {string} key         of the fragment; removed from the address bar at once
 * @property {string | null} room  code of a class, of `#class=CODE`; empty where it is to be typed; null when none is wanted
 * @property {string} roomKey     the teacher's, of `&k=`; removed from the address bar at once
 * @property {string | null} experiment  of `#experiments=ID`; empty for the view alone; null when a lab is wanted
 * @property {LessonAt | null} lesson  the list of questions, or one of them; null when a lab is wanted
 * @property {string[]} problems  what was ignored, in words
 */

/** A place among the lessons: id is empty for the list of questions; step 1 to 5; lang is empty where the address has none.
 * @typedef {{id: string, step: number, lang: string}} LessonAt */

export const LESSON_STEPS = 5;
export const THEMES = ['auto', 'light', 'dark', 'projector'];
/** A short address such as `/#step`, and the scenario that it opens. @typedef {{id: string, scenario: string}} Short */

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

/** `#questions` and `#lesson=ID&step=N&lang=de`. An address that asks for nothing has the list of questions.
 * @param {string} search @param {string} hash @returns {LessonAt | null} */
export function readLesson(search, hash) {
  const fragment = new URLSearchParams(hash.replace(/^#/, '')),
    query = new URLSearchParams(search);
  const id = fragment.get('lesson') ?? '',
    step = Number(fragment.get('step')),
    lang = fragment.get('lang') ?? '';
  const bare = hash.replace(/^#/, '') === '' && !['scenario', 'set', 'seed'].some((name) => query.has(name));
  if (!/^[a-z0-9_]{1,64}$/.test(id) && !fragment.has('questions') && !bare) return null;
  return {
    id: /^[a-z0-9_]{1,64}$/.test(id) ? id : '',
    step: Number.isInteger(step) && step >= 1 && step <= LESSON_STEPS ? step : 1,
    lang: /^[a-z]{2}$/.test(lang) ? lang : '',
  };
}

/** @param {LessonAt} at @returns {string} the fragment */
export function writeLesson({ id, step, lang }) {
  const language = lang === '' ? '' : `&lang=${lang}`;
  return id === '' ? `#questions${language}` : `#lesson=${id}&step=${step}${language}`;
}

/** @param {string} search @param {string} hash @returns {Link} */
export function readLink(search, hash) {
  const query = new URLSearchParams(search);
  const fragment = new URLSearchParams(hash.replace(/^#/, ''));
  /** @type {Link} */
  const link = {
    scenario: '',
    first: '',
    set: {},
    seed: null,
    theme: 'auto',
    present: query.get('present') === 'yes',
    session: '',
    key: '',
    room: fragment.get('class'),
    roomKey: fragment.has('class') ? (fragment.get('k') ?? '') : '',
    experiment: readExperiment(hash),
    lesson: readLesson(search, hash),
    problems: [],
  };

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

  const present = query.get('present');
  if (present !== null && !link.present) link.problems.push(`present=${present} ignored: it is yes, or not there`);

  const session = fragment.get('s') ?? '';
  if (/^[A-Za-z0-9_-]{1,64}$/.test(session)) {
    link.session = session;
    link.key = fragment.get('k') ?? '';
  } else if (session !== '') {
    link.problems.push('The session in the address is not an id; a new one was created');
  }
  return link;
}

/** The scenario: that of the query or of a short address; the first of these where the address names none.
 * @param {Link} link @param {string} search @param {string} hash @param {Short[]} shorts */
export function readScenario(link, search, hash, shorts) {
  const asked = new URLSearchParams(search).get('scenario'),
    first = shorts[0]?.scenario ?? '';
  link.first = first;
  link.scenario = asked ?? shorts.find(({ id }) => id === hash.slice(1))?.scenario ?? first;
  if (/^[a-z0-9_/-]{1,64}$/.test(link.scenario)) return;
  link.problems.unshift(`scenario=${asked} ignored, using ${first}`);
  link.scenario = first;
}

/** How the page looks, as items of a query. @param {Pick<Link, 'theme' | 'present'>} link @returns {string[]} */
export function lookOf({ theme, present }) {
  return [...(theme === 'auto' ? [] : [`theme=${theme}`]), ...(present ? ['present=yes'] : [])];
}

/** The query that gives the same set-up elsewhere: only what differs from the scenario.
 * @param {Pick<Link, 'scenario' | 'set' | 'seed' | 'theme' | 'present'>} link @returns {string} */
export function writeQuery(link) {
  const parts = [`scenario=${link.scenario}`];
  for (const [path, value] of Object.entries(link.set))
    parts.push(`set=${path}:${encodeURIComponent(typeof value === 'object' ? JSON.stringify(value) : String(value))}`);
  if (link.seed !== null) parts.push(`seed=${link.seed}`);
  parts.push(...lookOf(link));
  return `?${parts.join('&')}`;
}
