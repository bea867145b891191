// What a lab is: what differs between labs goes through this interface. Types alone; no page loads this.

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('../stream/frame.js').Frame} Frame */
/** A key of the keyboard; everywhere: also where no session is shown.
 * @typedef {{code: string, alt?: boolean, shift?: boolean, repeat?: boolean, everywhere?: boolean, shown: string, help: string,
 *   run: () => void}} Key */
/** What a dialog is about: `kind` says who shows it. @typedef {{kind: string, of?: any}} Dialog */

/** A button in the head of the page, `name` is the key of its words: `/#ID` opens the same scenario. Scenarios of the games or kinds that
 * it shows belong to it.
 * @typedef {{id: string, name: string, scenario: string, shows: string[]}} Tab */

/** What happens too fast to be seen is shown slowly: between these times, s.
 * @typedef {{speed: number, from_s: number, until_s: number}} Slow */

/** Experiments of a kind. A work-precision diagram has groups of axes, each with values that go together: a path and its values, all
 * choices where there are none; paths that a scenario lacks are left out. errors: metrics of the error, the best first; brief_s: what makes
 * a first experiment last seconds.
 * @typedef {{axes: [string, string][][], errors: RegExp, more: string[], repeats: string, brief_s?: number}} Study */

/** @typedef {{scenario: string, set: Record<string, import('../base/link.js').Value>, seed: number}} Start */

/**
 * What is known of a lab before it is read.
 * @typedef {object} About
 * @property {string} kind   of the scenarios that it shows
 * @property {boolean} [sessionless]  the Experiments view, or speed against error: it shows no session
 * @property {string} group  their heading in the list of scenarios: key of its words
 * @property {Tab[]} tabs
 * @property {Record<string, string[]>} [elsewhere]  by the id of another lab's tab: what belongs to it all the same
 * @property {Record<string, number>} rates  of the channels to subscribe to, Hz
 * @property {Record<string, Slow>} [slow]  by scenario
 * @property {Study} [study]
 * @property {Start} [start]  the first page alone: of what it makes a session of its own
 * @property {() => Promise<Lab>} load
 */

/**
 * A lab. All but the template may be missing.
 * @typedef {object} Lab
 * @property {() => Template} template  what stands below the head of the page
 * @property {() => void} [rendered]    the template has been rendered
 * @property {(fresh: boolean) => void} [begin]  the stream has begun, and `layout` says of what; fresh: nothing of the session was drawn
 *  yet
 * @property {(frame: Frame) => void} [take]     a frame has come; not each is drawn
 * @property {(frame: Frame, settled: boolean, name: boolean) => void} [draw]  settled: no frame follows soon, so draw all of it; name: the
 *   drawings get their descriptions
 * @property {() => Record<string, number>} [rates]  other than those it begins with; 0 for a channel that is not wanted
 * @property {(now: any, before: any, asked: Record<string, unknown>) => string[]} [followed]  parameters that changed with those asked for
 * @property {() => PropertyDescriptorMap} [facts]  of window.laglab
 * @property {() => void} [end]  it is left: what it has made lets go of the page
 * @property {() => string} [hint]  what can be done here: the end of a key of the page's words; empty for nothing
 * @property {Key[]} [keys]
 * @property {(event: KeyboardEvent) => boolean} [press]  a key that is none of `keys`: whether it was one of the lab's
 * @property {(event: KeyboardEvent) => void} [release]
 * @property {() => Template} [help]  of the keys and views
 * @property {Record<string, (of: any) => [string, Template]>} [dialogs]  title and content, by kind
 * @property {() => Promise<Tables>} [tables]  what charts show, by the ids of their boxes, where `drawPlot` does not know it
 * @property {() => {title: string, settings: string, moment: string, version: string}} [about]  of what is shown, where that is no session
 * @property {() => Promise<Partial<Lab>>} [later]  reads what can wait until the first frame is drawn
 */

/** What a chart shows. lines: how its columns are drawn
 * @typedef {{columns: {name: string, unit: string}[], rows: (number | string | boolean | null)[][], lines?: {name: string, colour: string,
 * dash?: number[]}[]}} Table */

/** @typedef {Record<string, () => Table | null>} Tables */

/** What a class says of this page. at: what its address has behind #; empty for what the session says; hz: the most frames a second that
 * are asked for, 0 for as many as a lab wants; seat: the only player that may be driven, -1 for none, null for all whose session may be
 * changed; reason: why nothing else may be changed; empty where it may; frozen: not even driven; board: this page is the teacher's, shown
 * to a class; staged: views alone, around which the class has its texts.
 * @typedef {{at: string, hz: number, seat: number | null, reason: string, frozen: boolean, board?: boolean, staged?: boolean}} Place */

export {};
