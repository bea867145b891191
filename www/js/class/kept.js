// What this tab remembers of its class, so that a reload changes nothing: the key or token never stands in an address that is requested.

const KEPT = 'laglab.class';

/** secret: the teacher's key or the member's token. @typedef {{id: string, secret: string, teacher: boolean, shows: string}} Kept */

/** @param {string} id of the class @returns {Kept | null} */
export function kept(id) {
  try {
    const value = JSON.parse(sessionStorage.getItem(KEPT) ?? 'null');
    return value?.id === id && typeof value.secret === 'string' ? value : null;
  } catch {
    return null; /* storage may be forbidden: then a reload joins again */
  }
}

/** @param {Kept | null} value null: forget it */
export function keepClass(value) {
  try {
    if (value === null) sessionStorage.removeItem(KEPT);
    else sessionStorage.setItem(KEPT, JSON.stringify(value));
  } catch {
    /* as above */
  }
}
