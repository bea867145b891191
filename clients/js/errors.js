/** What laglab refuses, and why: a sentence such as `duration_s: must be 0.01 to 3600 s; got -5`. */
export class LaglabError extends Error {
  /** @param {string} sentence
   * @param {{status?: number, fields?: Record<string, string>, retryAfterS?: number | null}} [more] */
  constructor(sentence, { status = 0, fields = {}, retryAfterS = null } = {}) {
    super(sentence);
    this.name = 'LaglabError';
    /** The HTTP status; 0: no answer. */
    this.status = status;
    /** The refused fields with a sentence for each, as far as they are known. */
    this.fields = fields;
    /** When a request can be made again; null: unknown. */
    this.retryAfterS = retryAfterS;
  }
}
