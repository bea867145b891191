// A plot of work against precision as SVG: error across, time up, both logarithmic. Readable on light and dark ground.

const WIDTH = 600,
  HEIGHT = 340,
  LEFT = 62,
  RIGHT = 470,
  TOP = 30,
  BOTTOM = 292;
const DASHES = ['', '7 3', '2 3', '9 3 2 3', '1 5'];

const escaped = (text) => String(text).replaceAll('&', '&amp;').replaceAll('<', '&lt;');
const power = (k) => `10<tspan dy="-5" font-size="8">${k}</tspan>`;
const time = (k) => ['1 ns', '10 ns', '100 ns', '1 µs', '10 µs', '100 µs', '1 ms', '10 ms', '100 ms', '1 s', '10 s'][k + 9] ?? power(k);

/** A scale that puts whole powers of ten from `low` to `high` between two pixels. */
function scale(values, from, to) {
  const logs = values.map(Math.log10);
  const low = Math.floor(Math.min(...logs)),
    high = Math.max(low + 1, Math.ceil(Math.max(...logs)));
  return { low, high, at: (log) => from + ((log - low) / (high - low)) * (to - from) };
}

/** @param {{title: string, across?: string, what?: string, lines: {group: string, name: string, points: {x: number, y: number}[]}[]}} plot
 * y in seconds; groups at most four, of which the names of laglab and of the peers are left out */
export function workPrecision({ title, across = 'relative error at the end', what = 'CPU time against relative error', lines }) {
  const groups = [...new Set(lines.map((line) => line.group))];
  const points = lines.flatMap((line) => line.points);
  const x = scale(
      points.map((p) => p.x),
      LEFT,
      RIGHT,
    ),
    y = scale(
      points.map((p) => p.y),
      BOTTOM,
      TOP,
    );
  const out = [];
  const step = Math.ceil((x.high - x.low) / 9);
  for (let k = x.low; k <= x.high; k += step) {
    out.push(
      `<path class="grid" d="M${x.at(k).toFixed(1)} ${TOP}V${BOTTOM}"/>`,
      `<text x="${x.at(k).toFixed(1)}" y="${BOTTOM + 18}" text-anchor="middle">${power(k)}</text>`,
    );
  }
  for (let k = y.low; k <= y.high; k++) {
    out.push(
      `<path class="grid" d="M${LEFT} ${y.at(k).toFixed(1)}H${RIGHT}"/>`,
      `<text x="${LEFT - 6}" y="${(y.at(k) + 4).toFixed(1)}" text-anchor="end">${time(k)}</text>`,
    );
  }
  lines.forEach((line, i) => {
    const of = groups.indexOf(line.group),
      nth = lines.slice(0, i).filter((other) => other.group === line.group).length;
    const place = line.points.map((p) => [x.at(Math.log10(p.x)).toFixed(1), y.at(Math.log10(p.y)).toFixed(1)]);
    const dash = DASHES[nth % DASHES.length],
      at = TOP + 10 + 17 * i;
    const label = ['laglab', 'peers'].includes(line.group) ? line.name : `${line.group} ${line.name}`;
    out.push(
      `<g class="g${of}"><path d="M${place.map((p) => p.join(' ')).join('L')}" stroke-dasharray="${dash}"/>`,
      ...place.map(([px, py]) => `<circle cx="${px}" cy="${py}" r="2.2"/>`),
      `<path d="M${RIGHT + 8} ${at - 4}h24" stroke-dasharray="${dash}"/></g>`,
      `<text x="${RIGHT + 36}" y="${at}">${escaped(label)}</text>`,
    );
  });
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${HEIGHT}" width="${WIDTH}" height="${HEIGHT}" role="img">
<title>${escaped(title)}: ${escaped(what)}</title>
<style>
text { font: 11px sans-serif; fill: #222 } .grid { stroke: #8884 } path { fill: none; stroke-width: 1.6 }
.g0 { stroke: #0060b0; fill: #0060b0 } .g1 { stroke: #b85000; fill: #b85000 } .g2 { stroke: #007a55; fill: #007a55 }
.g3 { stroke: #8a3fb0; fill: #8a3fb0 }
svg { background: #fff }
@media (prefers-color-scheme: dark) {
svg { background: #101418 } text { fill: #ddd }
.g0 { stroke: #6bb6ff; fill: #6bb6ff } .g1 { stroke: #f0a050; fill: #f0a050 } .g2 { stroke: #3ccb9a; fill: #3ccb9a }
.g3 { stroke: #cf9cf0; fill: #cf9cf0 } }
</style>
<text x="${LEFT}" y="18" style="font-weight: bold">${escaped(title)}</text>
${out.join('\n')}
<text x="${(LEFT + RIGHT) / 2}" y="${BOTTOM + 38}" text-anchor="middle">${escaped(across)}</text>
</svg>
`;
}
