// What this browser remembers of its classes: the key or token never stands in an address that is requested. A member's token is the
// browser's, so that another tab is the same member; the teacher's key, and what is shown, are the tab's.

const KEPT = 'laglab.class',
  TOKENS = 'laglab.members',
  MOST = 8; /* classes whose tokens are kept */

/** secret: the teacher's key or the member's token. @typedef {{id: string, secret: string, teacher: boolean, shows: string}} Kept */

/** @param {Storage} storage @param {string} name @returns {any} null: nothing, or storage is forbidden */
function read(storage, name) {
  try {
    return JSON.parse(storage.getItem(name) ?? 'null');
  } catch {
    return null;
  }
}

/** Tokens by the class's id, the last one last. @returns {[string, string][]} */
const tokens = () => Object.entries(read(localStorage, TOKENS) ?? {}).filter(([, token]) => typeof token === 'string');

/** @param {string} id of the class @returns {Kept | null} */
export function kept(id) {
  const value = read(sessionStorage, KEPT),
    own = value?.id === id && typeof value.secret === 'string' ? value : null;
  if (own?.teacher) return own;
  const secret = tokens().find(([of]) => of === id)?.[1];
  return secret === undefined ? null : { id, secret, teacher: false, shows: own?.shows ?? 'board' };
}

/** @param {Kept} value */
export function keepClass(value) {
  try {
    sessionStorage.setItem(KEPT, JSON.stringify(value));
    if (!value.teacher) keepToken(value.id, value.secret);
  } catch {
    /* storage may be forbidden: then a reload joins again */
  }
}

/** @param {string} id of the class @param {string} token */
function keepToken(id, token) {
  const others = tokens().filter(([of]) => of !== id);
  localStorage.setItem(TOKENS, JSON.stringify(Object.fromEntries([...others, [id, token]].slice(-MOST))));
}

/** @param {string} id of the class */
export function forgetClass(id) {
  try {
    sessionStorage.removeItem(KEPT);
    localStorage.setItem(TOKENS, JSON.stringify(Object.fromEntries(tokens().filter(([of]) => of !== id))));
  } catch {
    /* as above */
  }
}
