// What an address says. Types alone; no page loads this.

/**
 * @typedef {object} Link
 * @property {string} scenario  empty until `readScenario`
 * @property {string} first       the scenario where the address names none
 * @property {Record<string, string | number | boolean | object>} set    changed parameters by dotted path
 * @property {number | null} seed
 * @property {object | null} workload  inputs of players that a person steers, as a lesson has them
 * @property {string} theme       auto, light, dark or projector
 * @property {boolean} present  views and caption alone
 * @property {string} lang        en, de; empty where the address has none
 * @property {string} session     of the fragment; empty when the page makes its own
 * @property {string} key         of the fragment; removed from the address bar at once
 * @property {string | null} room  code of a class, of `#class=CODE`; empty where it is to be typed; null when none is wanted
 * @property {string} roomKey     the teacher's, of `&k=`; removed from the address bar at once
 * @property {string | null} experiment  of `#experiments=ID`; empty for the view alone; null when a lab is wanted
 * @property {string | null} tradeoff  `#tradeoff=FAMILY...`: speed against error; null when it is not wanted
 * @property {{id: string, step: number, lang: string} | null} lesson  the list of questions, or one of them; null when a lab is wanted
 * @property {string} second     of the fragment: `compare...`, a second run next to the first; empty for none
 * @property {boolean} embed   in a frame of a course page: the view alone
 * @property {[string, Record<string, string>][]} problems  what was ignored: keys of the page's words, and their values
 */

export {};
