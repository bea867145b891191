// The numbers of a plot as a table.

/** @typedef {import('../session/lab.js').Table} Table */

/** `energy since the start (J)` as name and unit. @param {string} label */
export function column(label) {
  const [, name = label, unit = ''] = /^(.*?)\s*\(([^()]*)\)$/.exec(label) ?? [];
  return { name, unit };
}

/** A line without the gaps at which it breaks. @param {import('../draw/plot.js').Plot['lines'][number]} line */
function whole(line) {
  const at = [...line.xs.keys()].filter((k) => Number.isFinite(line.xs[k]) && Number.isFinite(line.ys[k]));
  return { ...line, xs: at.map((k) => line.xs[k] ?? 0), ys: at.map((k) => line.ys[k] ?? 0) };
}

/** A column per line where they share an axis that only grows; else a row per point, with the name of its line.
 * @param {import('../draw/plot.js').Plot} plot @returns {Table} */
export function tableOfPlot(plot) {
  const named = plot.lines.filter((line) => line.name !== undefined),
    lines = (named.length > 0 ? named : plot.lines).map(whole);
  const keys = named.map((line) => ({ name: line.name ?? '', colour: line.colour, ...(line.dash ? { dash: line.dash } : {}) }));
  const x = column(plot.x),
    y = column(plot.y);
  const nameOf = (/** @type {number} */ i) => lines[i]?.name ?? '';
  if (lines.every(({ xs }) => xs.every((value, k) => k === 0 || value > (xs[k - 1] ?? -Infinity)))) {
    const places = lines.map(({ xs, ys }) => new Map(xs.map((value, k) => [value, ys[k] ?? Number.NaN])));
    const all = [...new Set(lines.flatMap(({ xs }) => xs))].sort((a, b) => a - b);
    return {
      columns: [
        x,
        ...lines.map((_, i) => ({ name: [nameOf(i), y.name].filter((text) => text !== '').join(': ') || 'value', unit: y.unit })),
      ],
      rows: all.map((value) => [value, ...places.map((place) => place.get(value) ?? null)]),
      lines: keys,
    };
  }
  return {
    columns: [{ name: 'series', unit: '' }, x, y],
    rows: lines.flatMap(({ xs, ys }, i) => xs.map((value, k) => [nameOf(i) || String(i + 1), value, ys[k] ?? null])),
    lines: keys,
  };
}
