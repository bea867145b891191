// Files of the page: next to the scripts, whose address has the digest of all and is kept by browsers forever.

/** @param {string} path below www/ @returns {URL} */
export const placeOf = (path) => new URL(`../${path}`, import.meta.url); /* the build puts every script into js/ */

/** @type {Map<string, Promise<any>>} */
const reading = new Map();

/** A file as JSON, which is read once. @param {string} path below www/ @returns {Promise<any>} it is asked for again after a failure */
export function file(path) {
  const now =
    reading.get(path) ??
    fetch(placeOf(path)).then((answer) => {
      if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
      return answer.json();
    });
  reading.set(path, now);
  now.catch(() => reading.delete(path));
  return now;
}
