// What the address says: scenario, changed parameters, seed, theme, language, whether it is presented, the session to join, or a lesson.

/** @typedef {string | number | boolean | object} Value */

/** @typedef {import('./address.js').Link} Link */

/** Their key and its values. @typedef {[string, Record<string, string>]} Ignored */

/** A place among the lessons: id is empty for the list of questions; step 1 to 5; lang is empty where the address has none.
 * @typedef {{id: string, step: number, lang: string}} LessonAt */

export const LESSON_STEPS = 5;
export const THEMES = ['auto', 'light', 'dark', 'projector'];
/** A short address such as `/#step`, and the scenario that it opens. @typedef {{id: string, scenario: string}} Short */

/** @param {string} text @returns {Value} */
export function toValue(text) {
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

/** Speed against error: `#tradeoff=FAMILY&error=N&cost=PATH&budget=X&enough=Y`. @param {string} hash @returns {string | null} all of it */
export const readTradeoff = (hash) => (/^#tradeoff(?:[=&]|$)/.test(hash) ? hash : null);

/** @param {string} hash @returns {string | null} empty also for speed against error, which shows no session either */
export function readExperiment(hash) {
  const found = /^#experiments(?:=([A-Za-z0-9_-]{1,64}))?$/.exec(hash);
  return found ? (found[1] ?? '') : readTradeoff(hash) && '';
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
    workload: null,
    theme: 'auto',
    lang: query.get('lang') ?? '',
    present: query.get('present') === 'yes',
    session: '',
    key: '',
    room: fragment.get('class'),
    roomKey: fragment.has('class') ? (fragment.get('k') ?? '') : '',
    experiment: readExperiment(hash),
    tradeoff: readTradeoff(hash),
    lesson: readLesson(search, hash),
    second: /[#&](compare\b.*)/.exec(hash)?.[1] ?? '',
    embed: query.get('embed') === '1',
    problems: [],
  };

  for (const item of query.getAll('set')) {
    const cut = item.indexOf(':');
    const path = item.slice(0, cut);
    if (cut > 0 && /^[a-z0-9_.]{1,96}$/.test(path)) link.set[path] = toValue(item.slice(cut + 1));
    else link.problems.push(['base.bad_set', { item }]);
  }

  const seed = query.get('seed');
  if (seed !== null && /^[0-9]{1,15}$/.test(seed)) link.seed = Number(seed);
  else if (seed !== null) link.problems.push(['base.bad_seed', { seed }]);

  const workload = query.get('workload');
  if (workload !== null) {
    const value = toValue(workload);
    if (typeof value === 'object') link.workload = value;
    else link.problems.push(['base.bad_workload', {}]);
  }

  const theme = query.get('theme');
  if (theme !== null && THEMES.includes(theme)) link.theme = theme;
  else if (theme !== null) link.problems.push(['base.bad_theme', { theme, themes: THEMES.join(', ') }]);

  const present = query.get('present');
  if (present !== null && !link.present) link.problems.push(['base.bad_present', { present }]);

  const session = fragment.get('s') ?? '';
  if (/^[A-Za-z0-9_-]{1,64}$/.test(session)) {
    link.session = session;
    link.key = fragment.get('k') ?? '';
  } else if (session !== '') {
    link.problems.push(['base.bad_session', {}]);
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
  link.problems.unshift(['base.bad_scenario', { scenario: String(asked), first }]);
  link.scenario = first;
}

/** How the page looks, as items of a query. @param {Pick<Link, 'theme' | 'lang' | 'present' | 'embed'>} link @returns {string[]} */
export function lookOf({ theme, lang, present, embed }) {
  return [
    ...(theme === 'auto' ? [] : [`theme=${theme}`]),
    ...(lang === '' ? [] : [`lang=${lang}`]),
    ...(present ? ['present=yes'] : []),
    ...(embed ? ['embed=1'] : []),
  ];
}

/** The query that gives the same set-up elsewhere: only what differs from the scenario.
 * @param {Pick<Link, 'scenario' | 'set' | 'seed' | 'workload' | 'theme' | 'lang' | 'embed' | 'present'>} link @returns {string} */
export function writeQuery(link) {
  const parts = [`scenario=${link.scenario}`];
  for (const [path, value] of Object.entries(link.set))
    parts.push(`set=${path}:${encodeURIComponent(typeof value === 'object' ? JSON.stringify(value) : String(value))}`);
  if (link.seed !== null) parts.push(`seed=${link.seed}`);
  if (link.workload !== null) parts.push(`workload=${encodeURIComponent(JSON.stringify(link.workload))}`);
  parts.push(...lookOf(link));
  return `?${parts.join('&')}`;
}
