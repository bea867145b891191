// The data of a report, which the page holds, read into columns. The files of this folder are joined into one script, in the
// order of CMakeLists.txt: browsers load no modules from files.
const byId = (/** @type {string} */ id) => document.getElementById(id);
const views = byId('views');
const head = JSON.parse(byId('head').textContent);
const PAGE_ROWS = 25,
  COLOURS = 8,
  LISTED = 300,
  BINS = 24;

/** The bytes of a base64 text that was deflated. @param {string} id @returns {Promise<Uint8Array>} */
async function inflate(id) {
  const text = atob(byId(id).textContent);
  if (text.length === 0) return new Uint8Array(0);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** A column as pack.c wrote it: leading bytes of doubles, plane by plane, each value combined with the one before. */
function unpack(bytes, at, count, planes) {
  const values = new Float64Array(count),
    words = new Uint32Array(values.buffer);
  let high = 0,
    low = 0;
  for (let k = 0; k < count; k++) {
    for (let b = 0, from = at + k; b < planes; b++, from += count) {
      if (b < 4) high ^= bytes[from] << (24 - 8 * b);
      else low ^= bytes[from] << (56 - 8 * b);
    }
    words[2 * k + 1] = high;
    words[2 * k] = low;
  }
  return values;
}

/** Columns by name and what they are of. */
function unpackAll(bytes, list) {
  const columns = new Map();
  let at = 0;
  for (const { name, of, planes, count } of list) {
    columns.set(`${name} ${of}`, unpack(bytes, at, count, planes));
    at += planes * count;
  }
  return columns;
}

/** @type {Map<string, Float64Array>} */ let columns, differenceColumns;
/** @type {Float64Array[]} by metric: the first runs of each point, one after the other */ let runs = [];
let count = 0; // points in the page
let number; // (row) => number of the point
let dimensions = [];
const metrics = head.metrics;

/** A statistic of a metric; of a point with one run all of them are its value. */
const column = (metric, name) =>
  columns.get(`${name} ${metric}`) ?? (head.repeats === 1 && /^p\d/.test(name) ? columns.get(`mean ${metric}`) : undefined);

const valueText = (value) =>
  typeof value === 'number' ? figure(value) : typeof value === 'boolean' ? (value ? 'on' : 'off') : String(value);

/** Values of axes that vary together; what is on or off by its name. */
const nameOf = (axes, list) =>
  list
    .map((value, a) => {
      const short = axes[a].path.slice(axes[a].path.lastIndexOf('.') + 1).replaceAll('_', ' ');
      return typeof value === 'boolean' && axes.length > 1 ? (value ? short : `no ${short}`) : valueText(value);
    })
    .join(', ');

/** A dimension of the grid: the index of its value at each point follows from the point's number. */
function gridDimension(axes, stride) {
  const size = axes[0].values.length,
    index = new Uint32Array(count),
    value = new Float64Array(count),
    numeric = axes.length === 1 && axes[0].numeric;
  for (let i = 0; i < count; i++) {
    index[i] = Math.floor(number(i) / stride) % size;
    value[i] = numeric ? axes[0].values[index[i]] : index[i];
  }
  return {
    axes,
    stride,
    size,
    index,
    value,
    numeric,
    values: axes[0].values.map((_, k) => axes.map((axis) => axis.values[k])),
  };
}

/** A sampled dimension: values that occur, if they are few; any in a range otherwise. */
function sampledDimension(axes, first) {
  const places = axes.map((_, a) => columns.get(`place ${first + a}`)),
    numeric = axes.length === 1 && axes[0].numeric,
    found = new Map(),
    of = (i) => axes.map((axis, a) => (axis.numeric ? places[a][i] : axis.values[places[a][i]]));
  for (let i = 0; i < count && found.size <= LISTED; i++) {
    const key = places.map((place) => place[i]).join(' ');
    if (!found.has(key)) found.set(key, of(i));
  }
  const whole = { axes, value: places[0], numeric: axes[0].numeric, sampled: of };
  if (found.size > LISTED) return { ...whole, size: 0 };
  const keys = [...found.keys()].sort((a, b) => parseFloat(a) - parseFloat(b)),
    rank = new Map(keys.map((key, k) => [key, k])),
    index = Uint32Array.from({ length: count }, (_, i) => rank.get(places.map((place) => place[i]).join(' ')));
  return {
    ...whole,
    numeric,
    size: keys.length,
    index,
    value: numeric ? places[0] : Float64Array.from(index),
    values: keys.map((k) => found.get(k)),
  };
}

function makeDimensions() {
  let stride = 1,
    first = 0;
  const firsts = head.dimensions.map((axes) => (first += axes.length) - axes.length);
  const made = [];
  for (let d = head.dimensions.length - 1; d >= 0; d--) {
    const axes = head.dimensions[d];
    /** @type {any} */
    const one = head.grid ? gridDimension(axes, stride) : sampledDimension(axes, firsts[d]);
    one.title = axes.map((axis) => axis.name).join(', ');
    one.names = one.size ? one.values.map((list) => nameOf(axes, list)) : [];
    one.log = axes[0].log && one.numeric;
    made[d] = one;
    stride *= one.size || 1;
  }
  return made;
}

/** Values of the axes at a point, by path. */
function settings(i) {
  const pairs = [];
  for (const d of dimensions) {
    const list = d.size ? d.values[d.index[i]] : d.sampled(i);
    d.axes.forEach((axis, a) => pairs.push([axis.path, axis.name, list[a]]));
  }
  return pairs;
}

const pointName = (i) =>
  settings(i)
    .map(([, name, value]) => `${name} ${valueText(value)}`)
    .join(', ') || `point ${number(i)}`;
