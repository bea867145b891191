/** The value at a path such as `players.0.remote_error_m.mean`. Throws where there is none: the error names what is there instead.
 * @param {any} tree @param {string} path @returns {any} */
export function valueAt(tree: any, path: string): any;
/** Every value of a tree with its path. @param {any} tree @param {string} [before] @returns {Generator<[string, any]>} */
export function leaves(tree: any, before?: string): Generator<[string, any]>;
