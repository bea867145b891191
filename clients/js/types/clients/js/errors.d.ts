/** What laglab refuses, and why: a sentence such as `duration_s: must be 0.01 to 3600 s; got -5`. */
export class LaglabError extends Error {
    /** @param {string} sentence
     * @param {{status?: number, fields?: Record<string, string>, retryAfterS?: number | null}} [more] */
    constructor(sentence: string, { status, fields, retryAfterS }?: {
        status?: number;
        fields?: Record<string, string>;
        retryAfterS?: number | null;
    });
    /** The HTTP status; 0: no answer. */
    status: number;
    /** The refused fields with a sentence for each, as far as they are known. */
    fields: Record<string, string>;
    /** When a request can be made again; null: unknown. */
    retryAfterS: number | null;
}
