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
export type Scenario = string | import("../../api.js").components["schemas"]["Scenario"] | Record<string, any>;
/**
 * Of each name the values of the same paths.
 */
export type Settings = Record<string, Record<string, any>>;
/**
 * An experiment as api/openapi.yaml has it.
 */
export type Specification = import("../../api.js").components["schemas"]["Experiment"];
/**
 * What is special to this client.
 */
export type Axes = {
    /**
     * by path its values, or by a name settings with names; or a
     * list as in the experiment's format
     */
    axes?: Record<string, any[] | Settings> | Record<string, any>[] | undefined;
};
/**
 * An experiment's other members, each as the API has it.
 */
export type Wish = Omit<Partial<Specification>, "scenario" | "axes"> & Axes;
