// Where a file of the page is: next to the scripts, whose address has the digest of all and is kept by browsers forever.

/** @param {string} path below www/ @returns {URL} */
export const placeOf = (path) => new URL(`../${path}`, import.meta.url); /* the build puts every script into js/ */
