// How much denser than at rest particles in a tank are, from their places alone, so that every library is held by one measure: the sum
// of laglab's kernel (Wendland C2, h = 1.3 spacings) over the neighbours and over a lattice that the walls are made of, three layers thick,
// relative to a square lattice. Expansion is not counted.

/**
 * @param {{width: number, height: number}} tank its floor and its two sides are walls
 * @param {number} spacing of the lattice at rest, m
 * @param {ArrayLike<number>} places x, y of each particle, m
 */
export function compression(tank, spacing, places) {
  const h = 1.3 * spacing,
    support = 2 * h,
    count = places.length / 2;
  const kernel = (/** @type {number} */ x, /** @type {number} */ y) => {
    const q = Math.hypot(x, y) / h,
      s = Math.max(0, 1 - q / 2);
    return s ** 4 * (2 * q + 1);
  };
  let rest = 0;
  for (let i = -3; i <= 3; i++) for (let j = -3; j <= 3; j++) rest += kernel(i * spacing, j * spacing);

  const columns = Math.round(tank.width / spacing),
    rows = Math.round(tank.height / spacing);
  const all = Array.from(places);
  for (let row = -3; row < rows; row++)
    for (let column = -3; column < columns + 3; column++)
      if (row < 0 || column < 0 || column >= columns) all.push((column + 0.5) * spacing, (row + 0.5) * spacing);

  /** @type {Map<number, number[]>} */
  const cells = new Map();
  const cell = (/** @type {number} */ at) => Math.floor(at / support);
  const key = (/** @type {number} */ i, /** @type {number} */ j) => i * 65536 + j;
  for (let k = 0; k < all.length; k += 2) {
    const of = key(cell(all[k]), cell(all[k + 1])),
      there = cells.get(of);
    if (there) there.push(k);
    else cells.set(of, [k]);
  }
  let sum = 0,
    max = 0;
  for (let a = 0; a < 2 * count; a += 2) {
    let density = 0;
    for (let i = -1; i <= 1; i++)
      for (let j = -1; j <= 1; j++)
        for (const b of cells.get(key(cell(all[a]) + i, cell(all[a + 1]) + j)) ?? [])
          density += kernel(all[a] - all[b], all[a + 1] - all[b + 1]);
    const over = Math.max(0, density / rest - 1);
    sum += over;
    max = Math.max(max, over);
  }
  return { mean: sum / count, max };
}
