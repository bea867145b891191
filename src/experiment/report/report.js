// The views of a report: reads the data that the page holds, and draws what is chosen. Classic script without modules, since browsers
// load no modules from files.
(() => {
  const byId = (/** @type {string} */ id) => document.getElementById(id);
  const views = byId('views');
  const head = JSON.parse(byId('head').textContent);
  const PAGE_ROWS = 25,
    COLOURS = 8,
    LISTED = 300,
    BINS = 24;

  // ---- data ----

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

  // ---- numbers ----

  const digits = head.planes <= 3 ? 4 : 6;

  function figure(x, precision = digits) {
    if (x === null || x === undefined || !Number.isFinite(x)) return '–';
    const size = Math.abs(x);
    if (size !== 0 && (size < 1e-4 || size >= 1e9))
      return x
        .toExponential(precision - 1)
        .replace(/\.?0+e/, 'e')
        .replace('-', '−')
        .replace('e+', 'e');
    const text = String(Number(x.toPrecision(size >= 1e6 ? Math.max(precision, 9) : precision)));
    return text.replace('-', '−');
  }

  const counted = (n) => Math.round(n).toLocaleString('en');

  /** Of sorted values, interpolated (Hyndman and Fan's type 7), as in the engine. */
  function quantile(sorted, p) {
    const at = (sorted.length - 1) * p,
      k = Math.floor(at);
    return k + 1 < sorted.length ? sorted[k] + (at - k) * (sorted[k + 1] - sorted[k]) : sorted[sorted.length - 1];
  }

  function range(values) {
    let low = Infinity,
      high = -Infinity;
    for (const v of values)
      if (Number.isFinite(v)) {
        if (v < low) low = v;
        if (v > high) high = v;
      }
    return [low, high];
  }

  // ---- state ----

  const state = {
    view: 'series',
    metric: 0,
    cost: 0,
    x: 0,
    y: 0,
    by: 0,
    colour: -1,
    logX: null,
    logY: null,
    only: {},
    low: '',
    high: '',
    dimension: 0,
    from: 0,
    of: 1,
    page: 0,
    sort: '',
    down: false,
    find: '',
    chosen: -1,
    box: -1,
    site: '',
  };
  const titles = {
    series: 'Series',
    scatter: 'Metric against metric',
    heat: 'Heat map',
    spread: 'Distribution',
    differences: 'Differences',
    table: 'Points',
  };

  /** Numbers of rows that the filter lets through. */
  let shown = new Uint32Array(0);

  function passes(d, wish, i) {
    if (d.size) return d.index[i] === wish;
    return !(d.value[i] < wish[0]) && !(d.value[i] > wish[1]);
  }

  function choose() {
    const wishes = Object.entries(state.only).map(([d, wish]) => [dimensions[d], wish]),
      values = column(state.metric, 'mean'),
      low = state.low === '' ? -Infinity : Number(state.low),
      high = state.high === '' ? Infinity : Number(state.high),
      bounded = state.low !== '' || state.high !== '',
      list = [];
    for (let i = 0; i < count; i++) {
      let fits = !bounded || (values[i] >= low && values[i] <= high);
      for (let k = 0; k < wishes.length && fits; k++) fits = passes(wishes[k][0], wishes[k][1], i);
      if (fits) list.push(i);
    }
    shown = Uint32Array.from(list);
  }

  /** The address keeps what was chosen. */
  function remember() {
    try {
      history.replaceState(null, '', `#${encodeURIComponent(JSON.stringify({ ...state, chosen: -1 }))}`);
    } catch {
      /* pages in a sandbox have no address of their own */
    }
  }

  function recall() {
    try {
      const kept = JSON.parse(decodeURIComponent(location.hash.slice(1)));
      const index = (value, size) => Number.isInteger(value) && value >= 0 && value < size;
      for (const key of Object.keys(state))
        if (typeof kept[key] === typeof state[key] || state[key] === null) state[key] = kept[key] ?? state[key];
      if (!titles[state.view]) state.view = 'series';
      for (const key of ['metric', 'cost']) if (!index(state[key], metrics.length)) state[key] = 0;
      for (const key of ['x', 'y', 'by', 'dimension']) if (!index(state[key], dimensions.length)) state[key] = 0;
      for (const d of Object.keys(state.only))
        if (!dimensions[d] || (dimensions[d].size ? !index(state.only[d], dimensions[d].size) : !Array.isArray(state.only[d])))
          delete state.only[d];
    } catch {
      /* no address, or one of another page */
    }
  }

  // ---- elements ----

  /** @param {string} tag @param {Record<string, any>} [wish] @param {...any} inside */
  function make(tag, wish = {}, ...inside) {
    const element = document.createElement(tag);
    for (const [key, value] of Object.entries(wish))
      if (key.startsWith('on')) element.addEventListener(key.slice(2), value);
      else if (value === true) element.setAttribute(key, '');
      else if (value !== false && value !== null && value !== undefined) element.setAttribute(key, value);
    element.append(...inside.filter((item) => item !== null && item !== undefined));
    return element;
  }

  function picker(label, id, options, value, take) {
    const select = make('select', { id, onchange: () => take(Number(select.value)) });
    for (const [key, text] of options) select.append(make('option', { value: key, selected: key === value }, text));
    return make('label', {}, label, select);
  }

  function flag(label, id, value, take) {
    const box = make('input', { type: 'checkbox', id, checked: value, onchange: () => take(box.checked) });
    return make('label', { class: 'flag' }, box, label);
  }

  function field(label, id, type, value, take, wish = {}) {
    const input = make('input', { type, id, value, step: 'any', ...wish, onchange: () => take(input.value) });
    return make('label', {}, label, input);
  }

  const set = (changes) => {
    Object.assign(state, changes);
    render();
  };

  const metricPicker = (label, key) =>
    picker(
      label,
      `pick-${key}`,
      metrics.map((name, m) => [m, name]),
      state[key],
      (value) => set({ [key]: value, logX: null, logY: null, page: 0 }),
    );

  const dimensionPicker = (label, key, list, none) =>
    picker(label, `pick-${key}`, [...(none ? [[-1, none]] : []), ...list.map((d) => [d, dimensions[d].title])], state[key], (value) =>
      set({ [key]: value, logX: null, box: -1, page: 0 }),
    );

  // ---- drawing ----

  let palette = {};

  function readPalette() {
    const style = getComputedStyle(document.documentElement),
      of = (name) => style.getPropertyValue(`--${name}`).trim();
    palette = { fg: of('fg'), bg: of('bg'), muted: of('muted'), line: of('line'), front: of('front'), accent: of('accent') };
    palette.series = Array.from({ length: COLOURS }, (_, k) => of(`c${k}`));
  }

  const HEAT = [
    [68, 1, 84],
    [59, 82, 139],
    [33, 145, 140],
    [94, 201, 98],
    [253, 231, 37],
  ];

  function heat(part) {
    const at = Math.min(Math.max(part, 0), 1) * (HEAT.length - 1),
      k = Math.min(Math.floor(at), HEAT.length - 2);
    return HEAT[k].map((c, i) => Math.round(c + (at - k) * (HEAT[k + 1][i] - c)));
  }

  const heatText = (part) => `rgb(${heat(part).join(',')})`;

  /** Few named values have colours of their own; many, and numbers of a range, a scale. */
  function colours(d) {
    if (d < 0) return { of: () => palette.series[0], at: () => 0, size: 1, names: [] };
    const dimension = dimensions[d];
    if (dimension.size && dimension.size <= 2 * COLOURS && !(dimension.numeric && dimension.size > COLOURS))
      return { of: (k) => palette.series[k % COLOURS], at: (i) => dimension.index[i], size: dimension.size, names: dimension.names };
    const [low, high] = range(dimension.value),
      log = dimension.log && low > 0,
      part = (v) => (high > low ? (log ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low)) : 0);
    if (dimension.size) {
      const value = (k) => (dimension.numeric ? dimension.values[k][0] : k);
      return {
        of: (k) => heatText(part(value(k))),
        at: (i) => dimension.index[i],
        size: dimension.size,
        names: dimension.names,
        low,
        high,
        scale: true,
      };
    }
    return {
      of: (k) => heatText(k / (BINS - 1)),
      at: (i) => Math.round(part(dimension.value[i]) * (BINS - 1)),
      size: BINS,
      names: [],
      low,
      high,
      scale: true,
    };
  }

  function niceStep(span, wanted) {
    const rough = span / Math.max(wanted, 1),
      power = 10 ** Math.floor(Math.log10(rough));
    return [1, 2, 5, 10].map((k) => k * power).find((step) => step >= rough * 0.999) ?? 10 * power;
  }

  /** @returns {{min: number, max: number, log: boolean, at: (v: number) => number, ticks: [number, string][], part?: (v: number) => number}} */
  function scale(low, high, log, from, to, wanted) {
    if (!(low <= high)) [low, high] = log ? [1, 10] : [0, 1];
    if (low === high) [low, high] = log ? [low / 2, high * 2] : low === 0 ? [-1, 1] : [low - Math.abs(low) / 2, high + Math.abs(high) / 2];
    if (log) {
      const a = Math.log10(low),
        b = Math.log10(high),
        rest = (b - a) * 0.04,
        at = (v) => from + ((Math.log10(v) - a + rest) / (b - a + 2 * rest)) * (to - from),
        every = Math.max(1, Math.ceil((b - a) / wanted)),
        ticks = [];
      for (let p = Math.floor(a - rest); p <= b + rest; p++)
        for (const m of b - a < 1.5 ? [1, 2, 5] : [1]) {
          const v = m * 10 ** p;
          if (Math.log10(v) >= a - rest && Math.log10(v) <= b + rest && p % every === 0) ticks.push([v, figure(v, 4)]);
        }
      return { min: low, max: high, log, at, ticks };
    }
    const rest = (high - low) * 0.04,
      at = (v) => from + ((v - low + rest) / (high - low + 2 * rest)) * (to - from),
      step = niceStep(high - low, wanted),
      ticks = [];
    for (let k = Math.ceil((low - rest) / step); k * step <= high + rest; k++)
      ticks.push([k * step, figure(Number((k * step).toPrecision(12)))]);
    return { min: low, max: high, log, at, ticks };
  }

  /** A scale of named values: each has a slot. */
  function slots(names, from, to, numeric = false) {
    const wide = (to - from) / names.length;
    return { names, numeric, log: false, at: (k) => from + (k + 0.5) * wide, wide, ticks: names.map((name, k) => [k, name]) };
  }

  /** Two canvases, one over the other for the mark that is pointed at, and a line of text that tells it. */
  function chart(id, height, words) {
    const canvas = make('canvas', { tabindex: 0, role: 'img', id, 'aria-label': words }),
      over = make('canvas', { 'aria-hidden': 'true' }),
      tip = make('p', { class: 'tip', 'aria-live': 'polite' }),
      box = make('div', { class: 'chart' }, canvas, over);
    canvas.style.height = over.style.height = `${height}px`;
    /** @type {{x: number, y: number, row: number, text: () => string, box?: number[]}[] | null} */
    const c = { canvas, over, tip, box, height, marks: [], at: -1, take: null, draw: null };
    canvas.addEventListener('pointermove', (event) => point(c, nearest(c, event)));
    canvas.addEventListener('pointerleave', () => point(c, -1));
    canvas.addEventListener('click', (event) => {
      point(c, nearest(c, event));
      if (c.at >= 0 && c.take) c.take(c.marks[c.at]);
    });
    canvas.addEventListener('keydown', (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1, PageDown: 10, PageUp: -10 }[event.key];
      if (step && c.marks.length) {
        point(c, c.at < 0 ? 0 : Math.min(Math.max(c.at + step, 0), c.marks.length - 1));
        event.preventDefault();
      } else if (event.key === 'Enter' && c.at >= 0 && c.take) c.take(c.marks[c.at]);
    });
    return c;
  }

  function context(canvas, height) {
    const dense = window.devicePixelRatio || 1,
      width = canvas.clientWidth || 600;
    canvas.width = Math.round(width * dense);
    canvas.height = Math.round(height * dense);
    const g = canvas.getContext('2d');
    g.scale(dense, dense);
    g.font = '12px system-ui, sans-serif';
    return { g, width };
  }

  function nearest(c, event) {
    const x = event.offsetX,
      y = event.offsetY;
    let best = -1,
      least = 24 * 24;
    for (let k = 0; k < c.marks.length; k++) {
      const m = c.marks[k];
      if (m.box) {
        if (x >= m.box[0] && x < m.box[0] + m.box[2] && y >= m.box[1] && y < m.box[1] + m.box[3]) return k;
        continue;
      }
      const far = (m.x - x) ** 2 + (m.y - y) ** 2;
      if (far < least) {
        least = far;
        best = k;
      }
    }
    return best;
  }

  function point(c, k) {
    if (c.at === k) return;
    c.at = k;
    const { g } = context(c.over, c.height),
      m = c.marks[k];
    c.tip.textContent = m ? m.text() : '';
    if (!m) return;
    g.strokeStyle = palette.fg;
    g.lineWidth = 2;
    g.beginPath();
    if (m.box) g.rect(...m.box);
    else g.arc(m.x, m.y, 7, 0, 2 * Math.PI);
    g.stroke();
  }

  function shortened(g, text, most) {
    if (g.measureText(text).width <= most) return text;
    let length = text.length;
    while (length > 1 && g.measureText(`${text.slice(0, length)}…`).width > most) length--;
    return `${text.slice(0, length)}…`;
  }

  /** Axes, grid and titles; `x` and `y` make the scales of a place. */
  function frame(c, { x, y, titleX, titleY }) {
    const { g, width } = context(c.canvas, c.height);
    let bottom = 44,
      slant = false;
    const high = (to) => y(to, 20),
      trial = high(c.height - bottom),
      labels = trial.names
        ? Math.min(Math.max(...trial.names.map((n) => g.measureText(n).width)), width * 0.3)
        : Math.max(0, ...trial.ticks.map(([, t]) => g.measureText(t).width)),
      left = Math.ceil(labels) + 14,
      across = x(left, width - 10);
    if (across.names) {
      const widest = Math.max(...across.names.map((n) => g.measureText(n).width));
      slant = !across.numeric && widest > across.wide - 6;
      if (slant) bottom = 44 + Math.min(widest, 130) * 0.6;
    }
    const X = across,
      Y = high(c.height - bottom);
    g.strokeStyle = palette.line;
    g.fillStyle = palette.fg;
    g.lineWidth = 1;
    const wide = left < width ? width - 10 : width;
    const skipY = Y.names ? Math.ceil(14 / Math.abs(Y.wide)) : 1;
    Y.ticks.forEach(([v, text], k) => {
      const at = Math.round(Y.at(v)) + 0.5;
      if (!Y.names) {
        g.beginPath();
        g.moveTo(left, at);
        g.lineTo(wide, at);
        g.stroke();
      }
      g.textAlign = 'right';
      g.textBaseline = 'middle';
      if (k % skipY === 0) g.fillText(Y.names ? shortened(g, text, labels) : text, left - 6, at);
    });
    g.textBaseline = 'top';
    const skip = X.names ? Math.ceil(15 / X.wide) : 1;
    let last = -Infinity;
    X.ticks.forEach(([v, text], k) => {
      const at = Math.round(X.at(v)) + 0.5;
      if (!X.names) {
        g.beginPath();
        g.moveTo(at, 20);
        g.lineTo(at, c.height - bottom);
        g.stroke();
      }
      if (slant && k % skip === 0) {
        g.save();
        g.translate(at, c.height - bottom + 6);
        g.rotate(-0.6);
        g.textAlign = 'right';
        g.fillText(shortened(g, text, 130), 0, 0);
        g.restore();
      } else if (!slant) {
        const half = g.measureText(text).width / 2;
        if (at - half < last + 6) return;
        g.textAlign = 'center';
        g.fillText(text, Math.min(at, width - half - 1), c.height - bottom + 6);
        last = at + half;
      }
    });
    g.strokeStyle = palette.muted;
    g.strokeRect(left + 0.5, 20.5, width - 10 - left, c.height - bottom - 20);
    g.fillStyle = palette.muted;
    g.textAlign = 'center';
    g.textBaseline = 'bottom';
    g.fillText(shortened(g, titleX, width - left), (left + width - 10) / 2, c.height - 4);
    g.textAlign = 'left';
    g.textBaseline = 'top';
    g.fillText(shortened(g, titleY, width - 4), 2, 2);
    return { g, X, Y, left, right: width - 10, top: 20, bottom: c.height - bottom };
  }

  /** Shapes tell what colours alone would not. */
  function mark(g, shape, x, y, r) {
    g.beginPath();
    if (shape === 0) g.arc(x, y, r, 0, 2 * Math.PI);
    else if (shape === 1) g.rect(x - r, y - r, 2 * r, 2 * r);
    else if (shape === 2) {
      g.moveTo(x, y - r * 1.3);
      g.lineTo(x + r * 1.2, y + r);
      g.lineTo(x - r * 1.2, y + r);
      g.closePath();
    } else {
      g.moveTo(x, y - r * 1.4);
      g.lineTo(x + r * 1.4, y);
      g.lineTo(x, y + r * 1.4);
      g.lineTo(x - r * 1.4, y);
      g.closePath();
    }
  }

  const shapeOf = (colouring, k) => (colouring.scale ? 0 : k % 4);

  function legend(colouring, d) {
    const box = make('div', { class: 'legend' });
    if (d < 0) return box;
    box.append(make('span', { class: 'said' }, `${dimensions[d].title}:`));
    if (colouring.scale) {
      const bar = make('span', { class: 'bar' });
      bar.style.background = `linear-gradient(90deg,${[0, 0.25, 0.5, 0.75, 1].map(heatText).join(',')})`;
      const named = dimensions[d].names;
      const numeric = dimensions[d].numeric;
      box.append(
        make('span', {}, numeric ? figure(colouring.low) : named[0], bar, numeric ? figure(colouring.high) : named[named.length - 1]),
      );
      return box;
    }
    colouring.names.forEach((name, k) => {
      const canvas = make('canvas', { width: 28, height: 28, 'aria-hidden': 'true' });
      canvas.style.cssText = 'width:14px;height:14px;display:inline-block;vertical-align:-2px;margin-right:.35rem';
      const g = canvas.getContext('2d');
      g.scale(2, 2);
      g.fillStyle = colouring.of(k);
      mark(g, shapeOf(colouring, k), 7, 7, 4.2);
      g.fill();
      box.append(make('span', {}, canvas, name));
    });
    return box;
  }

  const drawings = [];

  /** Adds a chart to the page and draws it when it has its size. */
  function show(parent, c, draw) {
    parent.append(c.box, c.tip);
    c.draw = draw;
    drawings.push(c);
  }

  /** Whether an axis is logarithmic: as chosen, or where values differ by more than fifty times. */
  const useLog = (chosen, low, high) => low > 0 && (chosen ?? high / low > 50);

  /** Magnitudes are drawn on a logarithmic scale, as they are compared. */
  function sizes(values) {
    let low = Infinity,
      high = 0,
      signed = false,
      none = 0;
    for (const v of values) {
      const size = Math.abs(v);
      if (!Number.isFinite(size)) continue;
      if (v < 0) signed = true;
      if (size === 0) none++;
      else if (size < low) low = size;
      if (size > high) high = size;
    }
    return { low, high, signed, none };
  }

  function axisOf(values, chosen, title) {
    const { low, high, signed, none } = sizes(values),
      log = low <= high && useLog(chosen, low, high),
      [least, most] = log ? [low, high] : range(values);
    return {
      log,
      low: least,
      high: most,
      title: log && signed ? `|${title}|` : title,
      value: (v) => (log ? (v === 0 ? NaN : Math.abs(v)) : v),
      note: log && none ? `${counted(none)} values that are 0 are not on the logarithmic scale. ` : '',
    };
  }

  const take = (m) => {
    if (m.row >= 0) set({ chosen: m.row });
  };

  // ---- view: series ----

  /** Means by the value of the x dimension and of the colour: over the settings that are not chosen. */
  function grouped(x, colouring) {
    const values = column(state.metric, 'mean'),
      low = column(state.metric, 'low'),
      high = column(state.metric, 'high'),
      groups = new Map();
    for (const i of shown) {
      if (!Number.isFinite(values[i])) continue;
      const k = colouring.at(i),
        key = k * x.size + x.index[i],
        group = groups.get(key);
      if (!group) groups.set(key, { k, index: x.index[i], x: x.value[i], y: values[i], n: 1, row: i, low: low?.[i], high: high?.[i] });
      else {
        group.n++;
        group.y += (values[i] - group.y) / group.n;
        group.low = group.high = NaN;
        group.row = -1;
      }
    }
    return [...groups.values()].sort((a, b) => a.k - b.k || a.x - b.x);
  }

  function scattered(x, colouring) {
    const values = column(state.metric, 'mean');
    return [...shown]
      .filter((i) => Number.isFinite(values[i]))
      .map((i) => ({
        k: colouring.at(i),
        index: 0,
        x: x.value[i],
        y: values[i],
        n: 1,
        row: i,
        low: column(state.metric, 'low')?.[i],
        high: column(state.metric, 'high')?.[i],
      }));
  }

  function seriesView(body, controls) {
    const x = dimensions[state.x];
    if (state.colour === state.x) state.colour = -1;
    controls.append(
      metricPicker('Metric', 'metric'),
      dimensionPicker('Along', 'x', [...dimensions.keys()]),
      dimensionPicker(
        'One colour per',
        'colour',
        [...dimensions.keys()].filter((d) => d !== state.x),
        'one colour',
      ),
    );
    const colouring = colours(state.colour),
      list = x.size ? grouped(x, colouring) : scattered(x, colouring),
      axis = axisOf(
        list.map((p) => p.y),
        state.logY,
        metrics[state.metric],
      ),
      along = axisOf(
        list.map((p) => p.x),
        state.logX ?? (x.log ? true : null),
        x.title,
      );
    controls.append(
      flag('log y', 'log-y', axis.log, (logY) => set({ logY })),
      x.numeric ? flag('log x', 'log-x', along.log, (logX) => set({ logX })) : '',
    );
    const pooled = list.filter((p) => p.n > 1).length,
      most = list.reduce((n, p) => Math.max(n, p.n), 0);
    const c = chart('series', 420, `${metrics[state.metric]} along ${x.title}: ${counted(list.length)} marks`);
    c.take = take;
    const bounds = list.filter((p) => Number.isFinite(p.low) && Number.isFinite(p.high) && list.length <= 600);
    const [low, high] = axis.log ? [axis.low, axis.high] : range([axis.low, axis.high, ...bounds.flatMap((p) => [p.low, p.high])]);
    show(body, c, () => {
      const f = frame(c, {
        titleX: along.title,
        titleY: axis.title,
        x: (from, to) => (x.numeric ? scale(along.low, along.high, along.log, from, to, (to - from) / 80) : slots(x.names, from, to)),
        y: (from, to) => scale(low, high, axis.log, from, to, (from - to) / 45),
      });
      const across = (p) =>
        x.numeric
          ? f.X.at(along.value(p.x))
          : f.X.at(p.index) +
            (colouring.size > 1 && colouring.size <= 16 ? ((p.k + 0.5) / colouring.size - 0.5) * Math.min(f.X.wide * 0.7, 90) : 0);
      drawSeries(f, c, list, colouring, across, (v) => f.Y.at(axis.value(v)), x, axis);
    });
    body.append(legend(colouring, state.colour));
    said(
      body,
      (pooled ? `Marks are means over up to ${counted(most)} settings each; choose single settings below to see intervals. ` : '') +
        (bounds.length ? 'Lines through marks are 95 % intervals of the mean. ' : '') +
        axis.note,
    );
  }

  function drawSeries(f, c, list, colouring, across, up, x, axis) {
    const { g } = f,
      joined = x.numeric && x.size > 0,
      small = list.length > 3000;
    c.marks = [];
    g.save();
    g.beginPath();
    g.rect(f.left, f.top, f.right - f.left, f.bottom - f.top);
    g.clip();
    let before = null;
    for (const p of list) {
      const px = across(p),
        py = up(p.y);
      if (!Number.isFinite(px) || !Number.isFinite(py)) continue;
      g.strokeStyle = g.fillStyle = colouring.of(p.k);
      if (joined && before && before.k === p.k) {
        g.globalAlpha = small ? 0.3 : 0.75;
        g.lineWidth = 1.5;
        g.beginPath();
        g.moveTo(before.px, before.py);
        g.lineTo(px, py);
        g.stroke();
      }
      before = { k: p.k, px, py };
      if (!small && p.low <= p.high) {
        g.globalAlpha = 0.6;
        g.lineWidth = 1.5;
        const to = axis.log && !(p.low > 0) ? f.bottom : up(p.low);
        g.beginPath();
        g.moveTo(px, Math.min(to, f.bottom));
        g.lineTo(px, Math.max(up(p.high), f.top) || f.top);
        g.stroke();
      }
      g.globalAlpha = small ? 0.5 : 1;
      if (list.length > 20000) g.fillRect(px - 1, py - 1, 2, 2);
      else {
        mark(g, shapeOf(colouring, p.k), px, py, list.length > 600 ? 1.8 : list.length > 150 ? 2.6 : 4);
        g.fill();
      }
      c.marks.push({ x: px, y: py, row: p.row, text: () => seriesText(p, x, colouring) });
    }
    g.restore();
  }

  function seriesText(p, x, colouring) {
    if (p.row >= 0)
      return `${pointName(p.row)}: ${metrics[state.metric]} ${figure(p.y)}${p.low <= p.high ? ` (95 % from ${figure(p.low)} to ${figure(p.high)})` : ''}`;
    const series = state.colour >= 0 && colouring.names[p.k] ? `, ${dimensions[state.colour].title} ${colouring.names[p.k]}` : '';
    return `${x.title} ${x.names[p.index]}${series}: mean of ${metrics[state.metric]} over ${counted(p.n)} settings ${figure(p.y)}`;
  }

  // ---- view: metric against metric ----

  function scatterView(body, controls) {
    controls.append(
      metricPicker('Across', 'cost'),
      metricPicker('Up', 'metric'),
      dimensionPicker('One colour per', 'colour', [...dimensions.keys()], 'one colour'),
    );
    const xs = column(state.cost, 'mean'),
      ys = column(state.metric, 'mean'),
      front = columns.get('front 0'),
      whole = head.front.length === 2 && head.front.includes(state.cost) && head.front.includes(state.metric),
      colouring = colours(state.colour),
      pick = (from) => Float64Array.from(shown, (i) => from[i]),
      across = axisOf(pick(xs), state.logX, metrics[state.cost]),
      up = axisOf(pick(ys), state.logY, metrics[state.metric]);
    controls.append(
      flag('log x', 'log-x', across.log, (logX) => set({ logX })),
      flag('log y', 'log-y', up.log, (logY) => set({ logY })),
    );
    const c = chart('scatter', 460, `${up.title} against ${across.title}: ${counted(shown.length)} points`);
    c.take = take;
    show(body, c, () => {
      const f = frame(c, {
          titleX: across.title,
          titleY: up.title,
          x: (from, to) => scale(across.low, across.high, across.log, from, to, (to - from) / 80),
          y: (from, to) => scale(up.low, up.high, up.log, from, to, (from - to) / 45),
        }),
        { g } = f,
        many = shown.length > 4000;
      c.marks = [];
      const kept = [];
      for (const i of shown) {
        const px = f.X.at(across.value(xs[i])),
          py = f.Y.at(up.value(ys[i]));
        if (!Number.isFinite(px) || !Number.isFinite(py)) continue;
        const k = colouring.at(i);
        g.fillStyle = colouring.of(k);
        g.globalAlpha = many ? 0.5 : 0.85;
        if (many) g.fillRect(px - 1, py - 1, 2.2, 2.2);
        else {
          mark(g, shapeOf(colouring, k), px, py, shown.length > 400 ? 2.6 : 4);
          g.fill();
        }
        c.marks.push({
          x: px,
          y: py,
          row: i,
          text: () =>
            `${pointName(i)}: ${metrics[state.cost]} ${figure(xs[i])}, ${metrics[state.metric]} ${figure(ys[i])}${whole && front[i] ? '; on the front' : ''}`,
        });
        if (whole && front[i]) kept.push([px, py]);
      }
      g.globalAlpha = 1;
      g.strokeStyle = palette.front;
      g.lineWidth = 1.5;
      kept.sort((a, b) => a[0] - b[0] || b[1] - a[1]);
      for (const [px, py] of kept) {
        mark(g, 0, px, py, 5.5);
        g.stroke();
      }
      g.beginPath();
      kept.forEach(([px, py], n) => (n ? g.lineTo(px, py) : g.moveTo(px, py)));
      g.stroke();
      c.marks.sort((a, b) => a.x - b.x || a.y - b.y);
    });
    body.append(legend(colouring, state.colour));
    said(
      body,
      `Each mark is a point, by the means of its runs. ${whole ? 'Rings are the Pareto front of all points: none is as good in both and better in one. ' : ''}${across.note}${up.note}`,
    );
  }

  // ---- view: heat map ----

  /** The index of a row on an axis of cells: its value's, or one of equal parts of a range. */
  function binned(d) {
    if (d.size) return { names: d.numeric ? d.values.map(([v]) => figure(v, 4)) : d.names, at: (i) => d.index[i], numeric: d.numeric };
    const [low, high] = range(d.value),
      log = d.log && low > 0,
      at = (v) => (log ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low)),
      back = (p) => (log ? low * (high / low) ** p : low + (high - low) * p);
    return {
      numeric: true,
      names: Array.from({ length: BINS }, (_, k) => figure(back((k + 0.5) / BINS), 3)),
      at: (i) => Math.min(BINS - 1, Math.max(0, Math.floor(at(d.value[i]) * BINS))),
    };
  }

  function heatView(body, controls) {
    if (state.y === state.x) state.y = dimensions.findIndex((_, d) => d !== state.x);
    controls.append(
      metricPicker('Metric', 'metric'),
      dimensionPicker('Across', 'x', [...dimensions.keys()]),
      dimensionPicker(
        'Up',
        'y',
        [...dimensions.keys()].filter((d) => d !== state.x),
      ),
    );
    const x = binned(dimensions[state.x]),
      y = binned(dimensions[state.y]),
      columnsX = x.names.length,
      means = new Float64Array(columnsX * y.names.length),
      numbers = new Uint32Array(means.length),
      rows = new Int32Array(means.length),
      values = column(state.metric, 'mean');
    for (const i of shown) {
      if (!Number.isFinite(values[i])) continue;
      const at = y.at(i) * columnsX + x.at(i);
      means[at] += (values[i] - means[at]) / ++numbers[at];
      rows[at] = i;
    }
    const filled = means.filter((_, k) => numbers[k] > 0),
      axis = axisOf(filled, state.logY, metrics[state.metric]),
      part = (v) =>
        (axis.log ? Math.log(axis.value(v) / axis.low) / Math.log(axis.high / axis.low) : (v - axis.low) / (axis.high - axis.low)) || 0;
    controls.append(flag('log colours', 'log-y', axis.log, (logY) => set({ logY })));
    const height = Math.min(Math.max(260, 90 + 26 * y.names.length), 560),
      c = chart(
        'heat',
        height,
        `${metrics[state.metric]} over ${dimensions[state.x].title} and ${dimensions[state.y].title}: ${counted(filled.length)} cells from ${figure(axis.low)} to ${figure(axis.high)}`,
      );
    c.take = take;
    show(body, c, () => {
      const f = frame(c, {
          titleX: dimensions[state.x].title,
          titleY: dimensions[state.y].title,
          x: (from, to) => slots(x.names, from, to, x.numeric),
          y: (from, to) => slots(y.names, from, to, y.numeric),
        }),
        { g } = f,
        wide = f.X.wide,
        high = Math.abs(f.Y.wide);
      c.marks = [];
      g.textAlign = 'center';
      g.textBaseline = 'middle';
      for (let k = 0; k < means.length; k++) {
        if (!numbers[k]) continue;
        const px = f.X.at(k % columnsX) - wide / 2,
          py = f.Y.at(Math.floor(k / columnsX)) - high / 2,
          p = part(means[k]);
        g.fillStyle = heatText(p);
        g.fillRect(Math.floor(px), Math.floor(py), Math.ceil(px + wide) - Math.floor(px), Math.ceil(py + high) - Math.floor(py));
        if (wide > 52 && high > 15) {
          const [r, gg, b] = heat(p);
          g.fillStyle = 0.299 * r + 0.587 * gg + 0.114 * b > 140 ? '#111' : '#fff';
          g.fillText(figure(means[k], 3), px + wide / 2, py + high / 2);
        }
        c.marks.push({
          x: px + wide / 2,
          y: py + high / 2,
          box: [px, py, wide, high],
          row: numbers[k] === 1 ? rows[k] : -1,
          text: () =>
            `${dimensions[state.x].title} ${x.names[k % columnsX]}, ${dimensions[state.y].title} ${y.names[Math.floor(k / columnsX)]}: ${metrics[state.metric]} ${figure(means[k])}${numbers[k] > 1 ? `, mean over ${counted(numbers[k])} points` : ''}`,
        });
      }
      g.strokeStyle = palette.muted;
      g.strokeRect(f.left + 0.5, f.top + 0.5, f.right - f.left, f.bottom - f.top);
    });
    const bar = make('span', { class: 'bar' });
    bar.style.background = `linear-gradient(90deg,${[0, 0.25, 0.5, 0.75, 1].map(heatText).join(',')})`;
    body.append(
      make(
        'div',
        { class: 'legend' },
        make('span', {}, `${axis.title}: ${figure(axis.low)}`, bar, figure(axis.high), axis.log ? ' (logarithmic)' : ''),
      ),
    );
    const pooled = numbers.some((n) => n > 1);
    said(
      body,
      `${pooled ? 'Cells with several points show their mean; choose single settings below. ' : 'Each cell is a point. '}Empty cells have no value. ${axis.note}`,
    );
  }

  // ---- view: distribution ----

  /** The runs of a point that the page holds, or its mean. */
  function valuesOf(i, metric, to) {
    if (!runs.length) {
      const v = column(metric, 'mean')[i];
      if (Number.isFinite(v)) to.push(v);
      return;
    }
    const from = runs[metric],
      kept = head.kept;
    for (let r = i * kept; r < (i + 1) * kept; r++) if (Number.isFinite(from[r])) to.push(from[r]);
  }

  function boxOf(group) {
    const sorted = Float64Array.from(group.values).sort(),
      single = group.rows.length === 1 && head.repeats > 1 && column(state.metric, 'p50');
    const [p25, p50, p75] = single
      ? ['p25', 'p50', 'p75'].map((name) => column(state.metric, name)[group.rows[0]])
      : [0.25, 0.5, 0.75].map((p) => quantile(sorted, p));
    return { ...group, sorted, p25, p50, p75, low: sorted[0], high: sorted[sorted.length - 1] };
  }

  function spreadView(body, controls) {
    const x = dimensions.length ? dimensions[state.by] : null;
    controls.append(metricPicker('Metric', 'metric'), x ? dimensionPicker('A box per', 'by', [...dimensions.keys()]) : '');
    const bins = x ? binned(x) : { names: ['all'], at: () => 0, numeric: false },
      groups = bins.names.map((name, k) => ({ name, k, rows: [], values: [] }));
    for (const i of shown) {
      const group = groups[bins.at(i)];
      group.rows.push(i);
      valuesOf(i, state.metric, group.values);
    }
    const boxes = groups.filter((group) => group.values.length > 0).map(boxOf),
      axis = axisOf(
        boxes.flatMap((b) => [b.low, b.high, b.p50]),
        state.logY,
        metrics[state.metric],
      );
    controls.append(flag('log', 'log-y', axis.log, (logY) => set({ logY })));
    const what = runs.length ? 'runs' : 'points',
      c = chart('boxes', 360, `${metrics[state.metric]}: ${boxes.length} boxes`);
    c.take = (m) => set({ box: m.k });
    show(body, c, () => drawBoxes(c, boxes, bins, x?.title ?? '', axis, what));
    said(
      body,
      `${runs.length ? `Values are runs${head.kept < head.repeats ? `, the first ${counted(head.kept)} of ${counted(head.repeats)} of each point` : ''}` : head.repeats > 1 ? 'Values are means of points: the page has no single runs' : 'Values are points of one run each'}. Boxes are quartiles and median, whiskers the least and the largest value. Choose a box to see its histogram. ${axis.note}`,
    );
    const chosen = boxes.find((b) => b.k === state.box);
    histogram(body, chosen ? [chosen] : boxes, chosen ? `${x.title} ${chosen.name}` : 'all that are chosen', axis, what);
  }

  function drawBoxes(c, boxes, bins, title, axis, what) {
    const f = frame(c, {
        titleX: title,
        titleY: axis.title,
        x: (from, to) => slots(bins.names, from, to, bins.numeric),
        y: (from, to) => scale(axis.low, axis.high, axis.log, from, to, (from - to) / 45),
      }),
      { g } = f,
      up = (v) => f.Y.at(axis.value(v)),
      wide = Math.max(1.5, Math.min(f.X.wide * 0.6, 46));
    c.marks = [];
    for (const b of boxes) {
      const at = f.X.at(b.k),
        [top, bottom] = [up(b.p75), up(b.p25)].sort((a, z) => a - z);
      g.strokeStyle = palette.series[0];
      g.lineWidth = 1.5;
      g.beginPath();
      g.moveTo(at, up(b.low));
      g.lineTo(at, bottom);
      g.moveTo(at, top);
      g.lineTo(at, up(b.high));
      g.stroke();
      g.fillStyle = b.k === state.box ? palette.front : palette.series[0];
      g.globalAlpha = 0.35;
      g.fillRect(at - wide / 2, top, wide, bottom - top);
      g.globalAlpha = 1;
      g.strokeRect(at - wide / 2, top, wide, bottom - top);
      g.lineWidth = 2.5;
      g.beginPath();
      g.moveTo(at - wide / 2, up(b.p50));
      g.lineTo(at + wide / 2, up(b.p50));
      g.stroke();
      c.marks.push({
        x: at,
        y: up(b.p50),
        box: [at - f.X.wide / 2, f.top, f.X.wide, f.bottom - f.top],
        row: -1,
        k: b.k,
        text: () =>
          `${title} ${b.name}: ${counted(b.sorted.length)} ${what} of ${counted(b.rows.length)} points; least ${figure(b.low)}, quartiles ${figure(b.p25)}, ${figure(b.p50)}, ${figure(b.p75)}, largest ${figure(b.high)}`,
      });
    }
  }

  function histogram(parent, boxes, name, axis, what) {
    const all = boxes.reduce((n, b) => n + b.sorted.length, 0);
    if (!all) return;
    const low = Math.min(...boxes.map((b) => (axis.log ? (b.sorted.find((v) => v > 0) ?? Infinity) : b.low))),
      high = Math.max(...boxes.map((b) => b.high)),
      log = axis.log && low > 0 && low < high,
      BARS = Math.max(8, Math.min(60, Math.ceil(2 * Math.cbrt(all)))),
      edge = (k) => (log ? low * (high / low) ** (k / BARS) : low + ((high - low) * k) / BARS),
      bars = new Uint32Array(BARS);
    for (const b of boxes)
      for (const v of b.sorted) {
        const part = high > low ? (log ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low)) : 0;
        if (part >= 0 && part <= 1) bars[Math.min(BARS - 1, Math.floor(part * BARS))]++;
      }
    const most = Math.max(...bars),
      c = chart('histogram', 230, `Histogram of ${metrics[state.metric]}, ${name}: ${counted(all)} ${what}`);
    parent.append(make('h2', {}, `Histogram: ${name}`));
    show(parent, c, () => {
      const f = frame(c, {
        titleX: metrics[state.metric],
        titleY: what,
        x: (from, to) => scale(low, high, log, from, to, (to - from) / 80),
        y: (from, to) => scale(0, most, false, from, to, (from - to) / 40),
      });
      c.marks = [];
      f.g.fillStyle = palette.series[0];
      for (let k = 0; k < BARS; k++) {
        const left = high > low ? f.X.at(edge(k)) : f.left + 20,
          right = high > low ? f.X.at(edge(k + 1)) : f.right - 20,
          top = f.Y.at(bars[k]),
          box = [left, top, Math.max(1, right - left - 1), f.Y.at(0) - top];
        f.g.fillRect(...box);
        c.marks.push({
          x: (left + right) / 2,
          y: top,
          box: [left, f.top, right - left, f.bottom - f.top],
          row: -1,
          text: () => `from ${figure(edge(k))} to ${figure(edge(k + 1))}: ${counted(bars[k])} ${what}`,
        });
        if (high === low) break;
      }
    });
  }

  // ---- view: differences ----

  const compared = () => [...new Set(head.differences.map((d) => d.dimension))].sort((a, b) => a - b);

  /** The settings of the other dimensions, in the order of the engine. */
  function settingRow(d, k, value) {
    const { stride, size } = dimensions[d];
    return Math.floor(k / stride) * stride * size + value * stride + (k % stride);
  }

  function settingName(d, k) {
    const point = settingRow(d, k, 0);
    return dimensions
      .filter((_, other) => other !== d)
      .map((other) => `${other.title} ${other.names[Math.floor(point / other.stride) % other.size]}`)
      .join(', ');
  }

  function differencesView(body, controls) {
    const list = compared();
    if (list.length === 0) {
      said(
        body,
        head.grid
          ? 'No dimension has from 2 to 16 values whose runs could be paired in this page.'
          : 'The points are a sample: no two of them differ by one setting alone.',
      );
      return;
    }
    if (!list.includes(state.dimension)) Object.assign(state, { dimension: list[0], from: 0, of: 1 });
    const d = dimensions[state.dimension];
    if (state.from >= d.size) state.from = 0;
    if (state.of >= d.size || state.of === state.from) state.of = state.from === 0 ? 1 : 0;
    const values = d.names.map((name, k) => [k, name]);
    controls.append(
      metricPicker('Metric', 'metric'),
      picker(
        'Of',
        'pick-dimension',
        list.map((k) => [k, dimensions[k].title]),
        state.dimension,
        (dimension) => set({ dimension, from: 0, of: 1, page: 0 }),
      ),
      picker(
        'Value',
        'pick-of',
        values.filter(([k]) => k !== state.from),
        state.of,
        (of) => set({ of, page: 0 }),
      ),
      picker('minus', 'pick-from', values, state.from, (from) => set({ from, of: from === state.of ? state.from : state.of, page: 0 })),
    );
    const turned = state.from > state.of,
      from = Math.min(state.from, state.of),
      of = Math.max(state.from, state.of),
      at = head.differences.findIndex(
        (e) => e.dimension === state.dimension && e.metric === state.metric && e.from === from && e.of === of,
      ),
      found = head.differences[at];
    if (!found) return said(body, 'These values are not compared in this page.');
    const turn = ([mean, low, high, method]) =>
      turned ? [mean === null ? null : -mean, high === null ? null : -high, low === null ? null : -low, method] : [mean, low, high, method];
    const [mean, low, high, method] = turn(found.all),
      bare = low === null && high === null;
    body.append(
      make(
        'p',
        { id: 'overall' },
        make('strong', {}, `${d.names[state.of]} minus ${d.names[state.from]}: ${figure(mean)}`),
        bare
          ? `; no interval: ${(head.texts[method] ?? '').replace(/^none: /, '')}`
          : ` (95 % from ${figure(low)} to ${figure(high)}; ${head.texts[method] ?? ''})`,
        found.settings > 1
          ? `. Mean over ${counted(found.complete)} of ${counted(found.settings)} settings of the other axes${found.complete < found.settings ? ', those where all runs have the metric' : ''}${bare ? '' : '; the interval is over seeds, each with its mean over these settings'}.`
          : '.',
        head.covers[method] ? ` Such intervals contain the mean so often: ${head.covers[method]}.` : '',
      ),
    );
    const part = (name) => differenceColumns.get(`${name} ${at}`);
    if (!part('mean')) {
      const axis = d.axes.map((a, k) => `${a.path}=${d.values[state.from][k]}`).join(',');
      body.append(
        make(
          'p',
          { class: 'said' },
          'The differences at single settings are left out for size. This writes those from a point: ',
          make('code', {}, `laglab sweep experiment.json --points --compare ${axis}`),
        ),
      );
      return;
    }
    const fits = (k) =>
        Object.entries(state.only).every(
          ([other, wish]) =>
            Number(other) === state.dimension ||
            Math.floor(settingRow(state.dimension, k, 0) / dimensions[other].stride) % dimensions[other].size === wish,
        ),
      rows = Array.from({ length: found.settings }, (_, k) => k)
        .filter(fits)
        .map((k) => [k, ...turn([part('mean')[k], part('low')[k], part('high')[k], part('method')[k]])]),
      page = rows.slice(state.page * PAGE_ROWS, (state.page + 1) * PAGE_ROWS),
      c = chart('forest', 60 + 24 * Math.max(page.length, 2), `Differences at ${rows.length} settings`);
    const [least, largest] = range([0, ...rows.flatMap(([, m, a, b]) => [m, a, b])]);
    c.take = ({ row }) => row >= 0 && set({ chosen: row });
    show(body, c, () => {
      const f = frame(c, {
          titleX: `${metrics[state.metric]}: ${d.names[state.of]} minus ${d.names[state.from]}`,
          titleY: dimensions.length > 1 ? 'other settings' : '',
          x: (a, b) => scale(least, largest, false, a, b, (b - a) / 80),
          y: (bottom, top) =>
            slots(
              page.map(([k]) => settingName(state.dimension, k) || 'all'),
              top,
              bottom,
            ),
        }),
        { g } = f;
      c.marks = [];
      g.strokeStyle = palette.muted;
      g.setLineDash([4, 3]);
      g.beginPath();
      g.moveTo(f.X.at(0), f.top);
      g.lineTo(f.X.at(0), f.bottom);
      g.stroke();
      g.setLineDash([]);
      page.forEach(([k, m, a, b], row) => {
        if (!Number.isFinite(m)) return;
        const py = f.Y.at(row),
          clear = a > 0 || b < 0;
        g.strokeStyle = g.fillStyle = clear ? palette.series[0] : palette.muted;
        g.lineWidth = 2;
        if (Number.isFinite(a) || Number.isFinite(b)) {
          g.beginPath();
          g.moveTo(Number.isFinite(a) ? f.X.at(a) : f.left, py);
          g.lineTo(Number.isFinite(b) ? f.X.at(b) : f.right, py);
          g.stroke();
        }
        mark(g, clear ? 0 : 3, f.X.at(m), py, 4);
        g.fill();
        c.marks.push({
          x: f.X.at(m),
          y: py,
          box: [f.left, py - 11, f.right - f.left, 22],
          row: settingRow(state.dimension, k, state.of),
          text: () => `${settingName(state.dimension, k)}: ${figure(m)} (95 % from ${figure(a)} to ${figure(b)})`,
        });
      });
    });
    said(body, 'Differences of runs with the same seed and otherwise the same settings. Grey: the interval contains 0, or there is none.');
    body.append(
      table(
        ['l Other settings', 'Difference', '95 % from', 'to', 'l by'],
        page.map(([k, m, a, b, by]) => ({
          cells: [settingName(state.dimension, k) || 'all', figure(m), figure(a), figure(b), head.texts[by] ?? ''],
        })),
      ),
      pages(rows.length),
    );
  }

  // ---- view: points ----

  function table(heads, rows) {
    const left = (k) => (heads[k] instanceof Element ? heads[k].className || null : heads[k].startsWith('l ') ? 'l' : null),
      line = make('tr');
    heads.forEach((text, k) =>
      line.append(text instanceof Element ? text : make('th', { scope: 'col', class: left(k) }, text.replace(/^l /, ''))),
    );
    const body = make('tbody');
    for (const { cells, mark: marked, chosen } of rows) {
      const tr = make('tr', { class: [marked ? 'on' : '', chosen ? 'chosen' : ''].join(' ').trim() || null });
      cells.forEach((cell, k) => tr.append(make('td', { class: left(k) }, cell)));
      body.append(tr);
    }
    return make(
      'div',
      { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'table' },
      make('table', {}, make('thead', {}, line), body),
    );
  }

  function pages(all) {
    const last = Math.max(0, Math.ceil(all / PAGE_ROWS) - 1);
    if (state.page > last) state.page = last;
    const go = (label, id, to) =>
      make('button', { type: 'button', id, disabled: to < 0 || to > last || to === state.page, onclick: () => set({ page: to }) }, label);
    return make(
      'div',
      { class: 'pages' },
      go('First', 'page-first', 0),
      go('Previous', 'page-previous', state.page - 1),
      make(
        'span',
        {},
        all
          ? `${counted(state.page * PAGE_ROWS + 1)} to ${counted(Math.min(all, (state.page + 1) * PAGE_ROWS))} of ${counted(all)}`
          : 'none',
      ),
      go('Next', 'page-next', state.page + 1),
      go('Last', 'page-last', last),
    );
  }

  const DETAILED = [
    ['mean', 'mean'],
    ['low', '95 % from'],
    ['high', 'to'],
    ['sd', 'SD'],
    ['p25', '25 %'],
    ['p50', 'median'],
    ['p75', '75 %'],
  ];

  function tableView(body, controls) {
    const fields = [{ id: 'point', title: 'Point', of: number }];
    for (const [d, dimension] of dimensions.entries())
      fields.push({
        id: `d${d}`,
        title: dimension.title,
        of: (i) => dimension.value[i],
        text: (i) => (dimension.size ? dimension.names[dimension.index[i]] : dimension.sampled(i).map(valueText).join(', ')),
      });
    const failed = columns.get('failed 0');
    if (head.repeats > 1) fields.push({ id: 'runs', title: 'Runs', of: (i) => columns.get('runs 0')[i] });
    if (failed.some((n) => n > 0)) fields.push({ id: 'failed', title: 'Failed', of: (i) => failed[i] });
    for (let m = 0; m < metrics.length; m++) {
      const part = m === state.metric && head.repeats > 1 ? DETAILED.filter(([name]) => column(m, name)) : [DETAILED[0]];
      for (const [name, title] of part)
        fields.push({ id: `m${m}${name}`, title: name === 'mean' ? metrics[m] : title, of: (i) => column(m, name)[i] });
    }
    controls.append(
      metricPicker('All statistics of', 'metric'),
      field('Find in settings', 'find', 'text', state.find, (find) => set({ find, page: 0 }), { placeholder: 'such as rk4' }),
    );
    const words = state.find.toLowerCase().split(/\s+/).filter(Boolean);
    let rows = words.length ? shown.filter((i) => words.every((word) => pointName(i).toLowerCase().includes(word))) : shown;
    const by = fields.find((f) => f.id === state.sort);
    if (by) {
      const key = Float64Array.from({ length: count }, (_, i) => {
        const v = by.of(i);
        return Number.isFinite(v) ? (state.down ? -v : v) : Infinity;
      });
      rows = Uint32Array.from(rows).sort((a, b) => key[a] - key[b] || a - b);
    }
    const bar = pages(rows.length),
      front = columns.get('front 0'),
      heads = fields.map((f) =>
        make(
          'th',
          {
            scope: 'col',
            class: f.text ? 'l' : null,
            'aria-sort': f.id === state.sort ? (state.down ? 'descending' : 'ascending') : 'none',
          },
          make(
            'button',
            { type: 'button', id: `sort-${f.id}`, onclick: () => set({ sort: f.id, down: f.id === state.sort && !state.down, page: 0 }) },
            f.title,
          ),
        ),
      );
    body.append(
      table(
        heads,
        [...rows.slice(state.page * PAGE_ROWS, (state.page + 1) * PAGE_ROWS)].map((i) => ({
          cells: [
            make(
              'button',
              { type: 'button', id: `row-${number(i)}`, 'aria-label': `Details of point ${number(i)}`, onclick: () => set({ chosen: i }) },
              String(number(i)),
            ),
            ...fields.slice(1).map((f) => (f.text ? f.text(i) : figure(f.of(i), f.id.startsWith('m') ? digits : 12))),
          ],
          mark: front[i],
          chosen: i === state.chosen,
        })),
      ),
      bar,
    );
    said(body, head.front.length ? `Coloured rows are on the Pareto front of ${head.front.map((m) => metrics[m]).join(', ')}.` : '');
  }

  // ---- a point ----

  /** A value of the scenario in an address or a command. */
  const plain = (value) => (typeof value === 'object' ? JSON.stringify(value) : String(value));

  function wholeSettings(i) {
    const varied = settings(i).map(([path, , value]) => [path, value]),
      paths = new Set(varied.map(([path]) => path));
    return [...Object.entries(head.set).filter(([path]) => !paths.has(path)), ...varied];
  }

  const servedBy = () => /^https?:$/.test(location.protocol);

  function liveAddress(i) {
    const site = state.site || (servedBy() ? `${location.origin}/` : 'http://127.0.0.1:8080/');
    return `${site}?scenario=${head.scenario}${wholeSettings(i)
      .map(([path, value]) => `&set=${encodeURIComponent(path)}:${encodeURIComponent(plain(value))}`)
      .join('')}&seed=${head.seed}`;
  }

  function command(i) {
    const sets = wholeSettings(i).map(([path, value]) => ` --set '${path}=${plain(value).replaceAll("'", "'\\''")}'`);
    return `laglab run ${head.scenario || 'scenario.json'} --seed ${head.seed}${sets.join('')}`;
  }

  function detail(i) {
    const box = make('section', { class: 'detail', id: 'detail', 'aria-label': 'Chosen point' }),
      known = DETAILED.filter(([name]) => metrics.some((_, m) => column(m, name))),
      acts = make('div', { class: 'acts' });
    if (head.scenario)
      acts.append(
        make('a', { href: liveAddress(i), target: '_blank', rel: 'noopener', id: 'live' }, 'Open live'),
        servedBy()
          ? ''
          : field('of the laglab at', 'site', 'text', state.site || 'http://127.0.0.1:8080/', (site) =>
              set({ site: /^https?:\/\//.test(site) ? site.replace(/[?#].*$/, '') : '' }),
            ),
      );
    acts.append(make('button', { type: 'button', id: 'close', onclick: () => set({ chosen: -1 }) }, 'Close'));
    const fronted = columns.get('front 0')[i] ? '; on the Pareto front' : '';
    box.append(
      make('h2', {}, `Point ${number(i)}: ${pointName(i)}`),
      make(
        'p',
        { class: 'said' },
        `Runs that ended well: ${counted(columns.get('runs 0')[i])}, others: ${counted(columns.get('failed 0')[i])}${fronted}.`,
      ),
      acts,
      table(
        ['l Metric', ...known.map(([, title]) => title), head.repeats > 1 ? 'l by' : 'l '],
        metrics.map((name, m) => ({
          cells: [name, ...known.map(([key]) => figure(column(m, key)?.[i])), head.texts[column(m, 'method')?.[i]] ?? ''],
        })),
      ),
      make('p', { class: 'said' }, 'Its first run, on the command line: ', make('code', {}, command(i))),
    );
    return box;
  }

  // ---- the page ----

  const said = (parent, text) => {
    if (text) parent.append(make('p', { class: 'said note' }, text));
  };

  function filters() {
    const box = make('div', { class: 'controls' });
    dimensions.forEach((d, k) => {
      if (d.size)
        box.append(
          picker(
            d.title,
            `only-${k}`,
            [[-1, `all ${counted(d.size)}`], ...d.names.map((name, v) => [v, name])],
            state.only[k] ?? -1,
            (value) => {
              const { [k]: _, ...only } = state.only;
              set({ only: value < 0 ? only : { ...only, [k]: value }, page: 0 });
            },
          ),
        );
      else {
        const [low, high] = range(d.value),
          wish = state.only[k] ?? [low, high],
          bound = (side) => (value) => {
            const next = [...wish];
            next[side] = value === '' ? [low, high][side] : Number(value);
            set({ only: { ...state.only, [k]: next }, page: 0 });
          };
        box.append(field(`${d.title} from`, `from-${k}`, 'number', wish[0], bound(0)), field('to', `to-${k}`, 'number', wish[1], bound(1)));
      }
    });
    box.append(
      field(`${metrics[state.metric]} from`, 'metric-low', 'number', state.low, (low) => set({ low, page: 0 })),
      field('to', 'metric-high', 'number', state.high, (high) => set({ high, page: 0 })),
      make('button', { type: 'button', id: 'all', onclick: () => set({ only: {}, low: '', high: '', find: '', page: 0 }) }, 'Show all'),
    );
    const summary = make('summary', {}, `Choose settings: ${counted(shown.length)} of ${counted(count)} points are shown`);
    return make(
      'details',
      { class: 'only', open: filtersOpen, id: 'only', ontoggle: (event) => (filtersOpen = event.target.open) },
      summary,
      box,
    );
  }

  let filtersOpen = true;

  function tabs() {
    const bar = make('div', { class: 'tabs', role: 'tablist', 'aria-label': 'Views' }),
      names = Object.keys(titles)
        .filter((name) => dimensions.length > 1 || name !== 'heat')
        .filter((name) => dimensions.length > 0 || name === 'spread' || name === 'table'),
      go = (name) => {
        set({ view: name, page: 0, logX: null, logY: null });
        byId(`tab-${name}`)?.focus();
      };
    for (const name of names)
      bar.append(
        make(
          'button',
          {
            type: 'button',
            role: 'tab',
            id: `tab-${name}`,
            'aria-selected': String(name === state.view),
            'aria-controls': 'view',
            tabindex: name === state.view ? 0 : -1,
            onclick: () => go(name),
          },
          titles[name],
        ),
      );
    bar.addEventListener('keydown', (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (step) go(names[(names.indexOf(state.view) + step + names.length) % names.length]);
    });
    return bar;
  }

  /** What the page lacks, and where it is. */
  function about() {
    const parts = [];
    const points = head.points;
    if (count < points)
      parts.push(
        `${counted(count)} of ${counted(points)} points are in this page${count < points ? ', or have been run: a random sample' : ''}.`,
      );
    else parts.push(`All ${counted(points)} points are in this page.`);
    parts.push(
      head.planes === 8
        ? 'Their values are exact.'
        : head.planes > 4
          ? 'Their values are rounded to 8 digits.'
          : head.planes === 4
            ? 'Their values are rounded to 6 digits.'
            : 'Their values are rounded to 4 digits.',
    );
    if (head.repeats > 1) {
      if (!columns.has('p50 0')) parts.push('Of the statistics only means and their intervals are here.');
      if (!runs.length) parts.push('Single runs are left out.');
      else if (head.kept < head.repeats)
        parts.push(`Of the runs the first ${counted(head.kept)} of ${counted(head.repeats)} of each point are here.`);
      else
        parts.push(
          `All ${counted(head.runs)} runs are here${head.run_planes < 8 ? `, rounded to ${head.run_planes === 3 ? 3 : head.run_planes === 4 ? 6 : 8} digits` : ''}.`,
        );
    }
    return make('p', { class: 'note', id: 'about' }, parts.join(' '));
  }

  const draws = {
    series: seriesView,
    scatter: scatterView,
    heat: heatView,
    spread: spreadView,
    differences: differencesView,
    table: tableView,
  };

  function drawAll() {
    readPalette();
    for (const c of drawings) {
      c.at = -1;
      context(c.over, c.height);
      c.draw();
    }
  }

  function render() {
    const focus = document.activeElement?.id;
    readPalette();
    choose();
    drawings.length = 0;
    const body = make('div', { role: 'tabpanel', id: 'view', 'aria-labelledby': `tab-${state.view}` }),
      controls = make('div', { class: 'controls' }),
      bar = tabs();
    if (!bar.querySelector(`#tab-${state.view}`)) {
      state.view = bar.firstElementChild.id.slice(4);
      return render();
    }
    body.append(controls);
    draws[state.view](body, controls);
    views.replaceChildren(about(), bar, body, filters(), state.chosen >= 0 ? detail(state.chosen) : '');
    drawAll();
    if (focus) byId(focus)?.focus({ preventScroll: true });
    remember();
  }

  async function start() {
    const [points, differences, run] = await Promise.all(['point-data', 'difference-data', 'run-data'].map(inflate));
    columns = unpackAll(points, head.point_columns);
    differenceColumns = unpackAll(differences, head.difference_columns);
    count = head.shown;
    const numbers = columns.get('point 0');
    number = numbers ? (i) => numbers[i] : (i) => i;
    if (head.kept > 0) {
      const each = count * head.kept;
      runs = metrics.map((_, m) => unpack(run, m * each * head.run_planes, each, head.run_planes));
    }
    dimensions = makeDimensions();
    begin();
    recall();
    render();
    addEventListener('resize', drawAll);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', render);
    const print = (on) => {
      document.documentElement.toggleAttribute('data-print', on);
      drawAll();
    };
    addEventListener('beforeprint', () => print(true));
    addEventListener('afterprint', () => print(false));
  }

  /** What is shown first: the error, along the first range, one colour per technique. */
  function begin() {
    state.metric = head.error;
    state.cost = head.cost >= 0 ? head.cost : metrics.length > 1 ? (head.error === 0 ? 1 : 0) : 0;
    const all = [...dimensions.keys()],
      best = all.filter((d) => dimensions[d].numeric).sort((a, b) => (dimensions[b].size || 1e9) - (dimensions[a].size || 1e9))[0] ?? 0,
      few = all.filter((d) => d !== best && dimensions[d].size && dimensions[d].size <= COLOURS);
    state.x = best;
    state.colour = few.find((d) => !dimensions[d].numeric) ?? few[0] ?? -1;
    state.y = all.filter((d) => d !== best).sort((a, b) => Number(dimensions[b].numeric) - Number(dimensions[a].numeric))[0] ?? 0;
    state.by = state.colour >= 0 ? state.colour : best;
    state.dimension = compared().find((d) => !dimensions[d].numeric) ?? compared()[0] ?? 0;
  }

  byId('static').remove();
  start().catch((error) => views.append(make('p', { role: 'alert' }, `The data of this page cannot be read: ${error.message}`)));
  // For the console and for tests: the data of the page.
  Object.assign(window, {
    report: {
      head,
      column: (metric, name) => column(metric, name),
      run: (metric) => runs[metric],
      settings: (i) => settings(i),
      difference: (k, name) => differenceColumns.get(`${name} ${k}`),
    },
  });
})();
