// Scales, axes, marks and canvases.
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

/** @returns {[number, string][]} */
function even(low, high, wanted, span = high - low) {
  const step = niceStep(span, wanted),
    /** @type {[number, string][]} */ ticks = [];
  for (let k = Math.ceil(low / step); k * step <= high; k++) ticks.push([k * step, figure(Number((k * step).toPrecision(12)))]);
  return ticks;
}

/** @returns {{log: boolean, at: (v: number) => number, ticks: [number, string][]}} */
function scale(low, high, log, from, to, wanted) {
  if (!(low <= high)) [low, high] = log ? [1, 10] : [0, 1];
  if (low === high) [low, high] = log ? [low / 2, high * 2] : low === 0 ? [-1, 1] : [low - Math.abs(low) / 2, high + Math.abs(high) / 2];
  if (log) {
    const a = Math.log10(low),
      b = Math.log10(high),
      rest = (b - a) * 0.04,
      at = (v) => from + ((Math.log10(v) - a + rest) / (b - a + 2 * rest)) * (to - from),
      every = Math.max(1, Math.ceil((b - a) / wanted)),
      /** @type {[number, string][]} */ ticks = [];
    for (let p = Math.floor(a - rest); p <= b + rest; p++)
      for (const m of b - a < 3 && every === 1 ? [1, 2, 5] : [1]) {
        const v = m * 10 ** p;
        if (Math.log10(v) >= a - rest && Math.log10(v) <= b + rest && p % every === 0) ticks.push([v, figure(v, 4)]);
      }
    return { log, at, ticks: ticks.length > 1 ? ticks : even(low, high, wanted) };
  }
  const rest = (high - low) * 0.04,
    at = (v) => from + ((v - low + rest) / (high - low + 2 * rest)) * (to - from);
  return { log, at, ticks: even(low - rest, high + rest, wanted, high - low) };
}

/** A scale of named values: each has a slot. */
function slots(names, from, to, numeric = false) {
  const wide = (to - from) / names.length;
  return { names, numeric, log: false, at: (k) => from + (k + 0.5) * wide, wide, ticks: names.map((name, k) => [k, name]) };
}

/** Two canvases, one over the other for the mark that is pointed at, and a line of text that describes it. */
function chart(id, height, words) {
  const canvas = make('canvas', { tabindex: 0, role: 'img', id, 'aria-label': words }),
    over = make('canvas', { 'aria-hidden': 'true' }),
    tip = make('p', { class: 'tip', 'aria-live': 'polite' }),
    box = make('div', { class: 'chart' }, canvas, over);
  canvas.style.height = over.style.height = `${height}px`;
  /** @type {any} marks: {x, y, text, row?, box?}[] */
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

/** Shapes distinguish series whose colours look alike. */
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

function ring(g, x, y, r, colour) {
  g.strokeStyle = colour;
  g.lineWidth = 1.5;
  mark(g, 0, x, y, r);
  g.stroke();
}

/** Colour and shape together are of one series among 32. */
const shapeOf = (colouring, k) => (colouring.scale ? 0 : (k + Math.floor(k / COLOURS)) % 4);

/** @param {any} colouring @param {any} dimension what has the colours */
function legend(colouring, dimension) {
  const box = make('div', { class: 'legend' });
  if (!dimension) return box;
  box.append(make('span', { class: 'said' }, `${dimension.title}:`));
  if (colouring.scale) {
    const bar = make('span', { class: 'bar' });
    bar.style.background = `linear-gradient(90deg,${[0, 0.25, 0.5, 0.75, 1].map(heatText).join(',')})`;
    const { names: named, numeric } = dimension;
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
