// Asks again until it is answered: a page without its controls or its words would be of no use.

/** @template T @param {() => Promise<T>} ask @returns {Promise<T>} */
export async function insist(ask) {
  for (let wait = 500; ; wait = Math.min(4000, 2 * wait)) {
    try {
      return await ask();
    } catch {
      await new Promise((done) => setTimeout(done, wait));
    }
  }
}
