/** Those of the axes whose values are settings with names. @param {Wish['axes']} axes @returns {Record<string, Settings>} */
export function namedAxes(axes: Wish["axes"]): Record<string, Settings>;
/** An experiment as laglab reads it. @param {Scenario} scenario @param {Wish} wish @returns {Record<string, any>} */
export function specification(scenario: Scenario, { axes, ...more }: Wish): Record<string, any>;
/** Rows with a column for each named axis, before the first of its paths.
 * @param {Record<string, any>[]} rows @param {Record<string, Settings>} named @returns {Record<string, any>[]} */
export function withNames(rows: Record<string, any>[], named: Record<string, Settings>): Record<string, any>[];
/**
 * An id of the library, or a whole scenario.
 */
export type Scenario = string | Record<string, any>;
/**
 * Of each name the values of the same paths.
 */
export type Settings = Record<string, Record<string, any>>;
/**
 * An experiment: api/openapi.yaml has all members.
 */
export type Wish = {
    /**
     * by path its values, or by a name settings with names; or a list
     * as in the experiment's format
     */
    axes?: Record<string, any[] | Settings> | Record<string, any>[] | undefined;
    metrics?: string[] | undefined;
    /**
     * runs of each point, with seeds one after the other
     */
    repeats?: number | undefined;
    /**
     * values by path, before the axes
     */
    set?: Record<string, any> | undefined;
    until?: any;
    sample?: any;
    stop?: any;
    title?: string | undefined;
};
