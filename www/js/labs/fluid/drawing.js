// Draws a fluid: its field as an image of cells, its points, and the legend of the colours.
import { localized } from '../../base/format.js';
import { drawText, widthOf } from '../../draw/marks.js';
import { place, shows } from '../../draw/shown.js';
import { css, isDark, mapsOf } from './colours.js';
import { drawRelief } from './relief.js';

/** @typedef {import('../../draw/palette.js').Palette} Palette */
/** @typedef {import('./decode.js').Field} Field */
/** @typedef {import('./decode.js').Points} Points */
/** @typedef {import('./scale.js').Scale} Scale */
/** From px to m: x = left + px / scale, y = top - py / scale. @typedef {{left: number, top: number, scale: number}} Camera */
/**
 * @typedef
 *  {{view: number[], field: Field | null, points: {of: Points, columns: string[], line: boolean}[], scale: Scale | null, word: string,
 *   water: boolean, cells: boolean, relief: boolean, hand: {x: number, y: number, held: boolean} | null, note: string,
 *   still: boolean, first?: Field | null}} Shown  first: of a lesson's first run; still: no frame follows soon; word: what colours stand
 *   for; water: they are heights of it; note: text over the drawing */

const EMPTY = 255; /* the byte of a cell without fluid */

/** One for each size: fluids side by side may have several.
 * @type {Map<string, {cells: HTMLCanvasElement, pen: CanvasRenderingContext2D, image: ImageData}>} */
const sheets = new Map();

/** @param {number} width @param {number} height */
function sheetOf(width, height) {
  const known = sheets.get(`${width}x${height}`);
  if (known) return known;
  if (sheets.size >= 8) sheets.clear(); /* of sizes that were tried before */
  const cells = Object.assign(document.createElement('canvas'), { width, height }),
    pen = /** @type {CanvasRenderingContext2D} */ (cells.getContext('2d'));
  const made = { cells, pen, image: pen.createImageData(width, height) };
  sheets.set(`${width}x${height}`, made);
  return made;
}

/** The colour of each byte of a field. @param {Field} field @param {number[]} range @param {Uint32Array} map @param {number} none */
function lookUp(field, [low = 0, high = 1], map, none) {
  const table = new Uint32Array(256),
    step = (field.high - field.low) / 254,
    top = map.length - 1;
  for (let i = 0; i < 255; i++) {
    const share = (field.low + i * step - low) / (high - low);
    table[i] = map[Math.max(0, Math.min(top, Math.round(share * top)))] ?? 0;
  }
  table[255] = none;
  return table;
}

/** @param {Field} field @param {Uint32Array} table @returns {HTMLCanvasElement} */
function paint(field, table) {
  const { width, height, bytes } = field,
    { cells, pen, image } = sheetOf(width, height);
  const out = new Uint32Array(image.data.buffer);
  for (let j = 0, k = 0; j < height; j++) {
    /* rows of an image go down */
    for (let at = (height - 1 - j) * width, end = at + width; at < end; at++) out[at] = table[bytes[k++] ?? 255] ?? 0;
  }
  pen.putImageData(image, 0, 0);
  return cells;
}

const RELIEF_PX = 256; /* of a relief's longer side, at most: the screen's own smoothing does the rest */

/** @param {Field} field @param {number[]} range @param {Uint32Array} map @param {number} none @param {boolean} sharp one pixel for a cell
 * @returns {HTMLCanvasElement} */
function paintRelief(field, range, map, none, sharp) {
  const factor = sharp ? 1 : Math.max(1, Math.floor(RELIEF_PX / Math.max(field.width, field.height)));
  const { cells, pen, image } = sheetOf(field.width * factor, field.height * factor);
  drawRelief(field, range, map, none, factor, new Uint32Array(image.data.buffer));
  pen.putImageData(image, 0, 0);
  return cells;
}

const HUES = 32;

const CROWD = 3000; /* particles: more are written as pixels, which costs a third of filling paths */

/** The colours of particles from slow to fast: the least must be seen on paper. @param {Uint32Array} map */
const huesOf = (map) => Array.from({ length: HUES }, (_, i) => map[Math.round((map.length - 1) * (0.15 + (0.85 * i) / (HUES - 1)))] ?? 0);

/** Squares that look like discs, each in the colour of its speed. @param {CanvasRenderingContext2D} on @param {Camera} at
 * @param {Shown['points'][0]} list @param {Uint32Array} map @param {number[]} range
 * @param {{left: number, top: number, w: number, h: number}} box */
function discs(on, at, { of, columns }, map, [low = 0, high = 1], box) {
  const x = columns.indexOf('x_m'),
    y = columns.indexOf('y_m'),
    hue = columns.findIndex((name) => /speed|mps$/.test(name)),
    { values, count } = of;
  const size = Math.max(1.5, Math.min(9, 0.7 * Math.sqrt((box.w * box.h) / 2 / Math.max(1, count)))),
    hues = huesOf(map);
  const put = count > CROWD ? pixels(on, box, size, hues) : paths(on, size, hues);
  for (let i = 0, k = 0; i < count; i++, k += of.columns) {
    const share = hue < 0 ? 1 : ((values[k + hue] ?? 0) - low) / (high - low);
    put.one(
      ((values[k + x] ?? 0) - at.left) * at.scale,
      (at.top - (values[k + y] ?? 0)) * at.scale,
      Math.max(0, Math.min(HUES - 1, Math.floor(share * HUES))),
    );
  }
  put.all();
}

/** As many strokes as colours. @param {CanvasRenderingContext2D} on @param {number} size @param {number[]} hues */
function paths(on, size, hues) {
  const bins = hues.map(() => new Path2D());
  return {
    one: (/** @type {number} */ px, /** @type {number} */ py, /** @type {number} */ hue) =>
      bins[hue]?.rect(px - size / 2, py - size / 2, size, size),
    all: () =>
      bins.forEach((path, i) => {
        on.fillStyle = css(hues[i] ?? 0);
        on.fill(path);
      }),
  };
}

/** Every pixel of the screen that a square touches: rounded to the nearest, gaps would run through the crowd.
 * @param {CanvasRenderingContext2D} on @param {{left: number, top: number, w: number, h: number}} box
 * @param {number} size @param {number[]} hues */
function pixels(on, { left, top, w, h }, size, hues) {
  const ratio = on.getTransform().a,
    { cells, pen, image } = sheetOf(Math.max(1, Math.round(w * ratio)), Math.max(1, Math.round(h * ratio)));
  const out = new Uint32Array(image.data.buffer),
    { width, height } = image;
  out.fill(0);
  return {
    one: (/** @type {number} */ px, /** @type {number} */ py, /** @type {number} */ hue) => {
      const x0 = Math.max(0, Math.floor((px - left - size / 2) * ratio)),
        x1 = Math.min(width, Math.ceil((px - left + size / 2) * ratio));
      const y0 = Math.max(0, Math.floor((py - top - size / 2) * ratio)),
        y1 = Math.min(height, Math.ceil((py - top + size / 2) * ratio));
      for (let j = y0; j < y1; j++) for (let i = x0; i < x1; i++) out[j * width + i] = hues[hue] ?? 0;
    },
    all: () => {
      pen.putImageData(image, 0, 0);
      on.imageSmoothingEnabled = false;
      on.drawImage(cells, left, top, w, h);
    },
  };
}

/** A surface seen from the side. @param {CanvasRenderingContext2D} on @param {Camera} at @param {Shown['points'][0]} list
 * @param {Palette} colours */
function line(on, at, { of, columns }, colours) {
  const x = columns.indexOf('x_m'),
    y = columns.findIndex((name) => name === 'y_m' || name === 'height_m');
  on.beginPath();
  for (let i = 0, k = 0; i < of.count; i++, k += of.columns) {
    on.lineTo(((of.values[k + x] ?? 0) - at.left) * at.scale, (at.top - (of.values[k + y] ?? 0)) * at.scale);
  }
  on.setLineDash([]);
  on.lineWidth = colours.line;
  on.strokeStyle = colours.accent;
  on.stroke();
}

/** Bodies: rectangles with a place, an angle and two sides. @param {CanvasRenderingContext2D} on @param {Camera} at
 * @param {Shown['points'][0]} list @param {Palette} colours */
function boxes(on, at, { of, columns }, colours) {
  const place = (/** @type {string} */ name) => columns.indexOf(name);
  const value = (/** @type {number} */ i, /** @type {string} */ name) => of.values[i * of.columns + place(name)] ?? 0;
  for (let i = 0; i < of.count; i++) {
    const w = value(i, 'width_m') * at.scale,
      h = value(i, 'height_m') * at.scale;
    on.save();
    on.translate((value(i, 'x_m') - at.left) * at.scale, (at.top - value(i, 'y_m')) * at.scale);
    on.rotate(-value(i, 'angle_rad'));
    on.fillStyle = colours.buffer;
    on.strokeStyle = colours.truth;
    on.lineWidth = colours.line;
    on.fillRect(-w / 2, -h / 2, w, h);
    on.strokeRect(-w / 2, -h / 2, w, h);
    on.restore();
  }
}

/** What floats, seen from above. @param {CanvasRenderingContext2D} on @param {Camera} at @param {Shown['points'][0]} list
 * @param {Palette} colours */
function fromAbove(on, at, { of, columns }, colours) {
  const x = columns.indexOf('x_m'),
    z = columns.indexOf('z_m');
  on.fillStyle = colours.buffer;
  on.strokeStyle = colours.onFill;
  on.lineWidth = colours.line;
  on.setLineDash([]);
  for (let i = 0, k = 0; i < of.count; i++, k += of.columns) {
    on.beginPath();
    on.arc(
      ((of.values[k + x] ?? 0) - at.left) * at.scale,
      (at.top - (of.values[k + z] ?? 0)) * at.scale,
      colours.marker / 3,
      0,
      2 * Math.PI,
    );
    on.fill();
    on.stroke();
  }
}

/** @param {number} value */
export const brief = (value) =>
  localized(
    value === 0 ? '0' : Math.abs(value) < 1e-3 || Math.abs(value) >= 1e4 ? value.toExponential(0) : String(Number(value.toPrecision(3))),
  );

/** @type {WeakMap<Uint32Array, HTMLCanvasElement>} */
const strips = new WeakMap();

/** A map's colours from left to right. @param {Uint32Array} map */
function stripOf(map) {
  const known = strips.get(map);
  if (known) return known;
  const canvas = Object.assign(document.createElement('canvas'), { width: map.length, height: 1 }),
    pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext('2d')),
    image = pen.createImageData(map.length, 1);
  new Uint32Array(image.data.buffer).set(map);
  pen.putImageData(image, 0, 0);
  strips.set(map, canvas);
  return canvas;
}

/** The largest value of a field. @param {Field} field */
function peakOf({ low, high, bytes }) {
  let most = 0;
  for (const byte of bytes) if (byte < EMPTY && byte > most) most = byte;
  return low + (most / (EMPTY - 1)) * (high - low);
}

/** Where on the legend the densest cell is, for a lesson: `densest`, `densest.first` in the first run, and `full` at its end.
 * @param {CanvasRenderingContext2D} on @param {Palette} colours @param {Shown} of @param {(value: number) => number} x px
 * @param {number} top of the legend */
function densest(on, colours, of, x, top) {
  const now = shows.value;
  if (!of.field || now === null) return;
  const values = { densest: peakOf(of.field), 'densest.first': of.first ? peakOf(of.first) : NaN, full: of.scale?.range()[1] ?? 1 };
  for (const [name, value] of Object.entries(values))
    if (Number.isFinite(value)) place(on.canvas, name, x(value), top + colours.text / 2, 100 * value);
  const [from, to] = [now.from, now.to].map((name) => x(values[/** @type {keyof values} */ (name)] ?? NaN)),
    level = top - colours.text;
  on.fillStyle = colours.mark;
  on.fillRect(Math.min(from, to), level - 7, Math.abs(to - from), 14);
  on.strokeStyle = colours.markLine;
  on.lineWidth = 2.5;
  on.setLineDash([]);
  on.beginPath();
  for (const end of [from, to]) {
    on.moveTo(end, level - 12);
    on.lineTo(end, top + colours.text);
  }
  on.moveTo(from, level);
  on.lineTo(to, level);
  on.stroke();
  drawText(on, colours, now.label, (from + to) / 2, level - colours.text * 1.3, { align: 'center', bold: true, colour: colours.markText });
}

/** The legend of the colours, along the lower edge. @param {CanvasRenderingContext2D} on @param {Palette} colours
 * @param {Uint32Array} map @param {Shown} of @param {{left: number, right: number, bottom: number}} box */
function legend(on, colours, map, of, box) {
  const [low = 0, high = 1] = of.scale?.range() ?? [0, 1],
    text = colours.text;
  const ticks = of.scale?.signed ? [low, low / 2, 0, high / 2, high] : [0, high / 4, high / 2, (3 * high) / 4, high];
  const left = box.left + widthOf(on, colours, of.word, true) + 1.6 * text,
    right = box.right - 2.4 * text,
    top = box.bottom - 2.3 * text;
  drawText(on, colours, of.word, box.left, top + text * 0.5, { bold: true });
  const width = right - left;
  if (width < 6 * text) return;
  if (shows.value?.view === on.canvas.id) densest(on, colours, of, (value) => left + ((value - low) / (high - low)) * width, top);
  on.imageSmoothingEnabled = true;
  on.drawImage(stripOf(map), left, top, width, text);
  on.strokeStyle = colours.edge;
  on.lineWidth = 1;
  on.setLineDash([]);
  on.strokeRect(left, top, width, text);
  const shown = width < 22 * text ? ticks.filter((_, i) => i % 2 === 0) : ticks;
  for (const tick of shown) {
    drawText(on, colours, brief(tick), left + ((tick - low) / (high - low)) * width, top + 1.75 * text, {
      align: 'center',
      colour: colours.faint,
    });
  }
}

/** @param {CanvasRenderingContext2D} on @param {Palette} colours @param {Camera} at @param {{x: number, y: number, held: boolean}} hand */
function reticle(on, colours, at, hand) {
  const x = (hand.x - at.left) * at.scale,
    y = (at.top - hand.y) * at.scale;
  for (const [width, colour] of /** @type {[number, string][]} */ ([
    [5, colours.paper],
    [2, colours.ink],
  ])) {
    on.lineWidth = width;
    on.strokeStyle = colour;
    on.setLineDash([]);
    on.beginPath();
    on.arc(x, y, 9, 0, 2 * Math.PI);
    for (const [dx, dy] of [
      [1, 0],
      [-1, 0],
      [0, 1],
      [0, -1],
    ]) {
      on.moveTo(x + 5 * (dx ?? 0), y + 5 * (dy ?? 0));
      on.lineTo(x + 14 * (dx ?? 0), y + 14 * (dy ?? 0));
    }
    on.stroke();
  }
  if (!hand.held) return;
  on.fillStyle = colours.accent;
  on.beginPath();
  on.arc(x, y, 5, 0, 2 * Math.PI);
  on.fill();
}

/** @param {{pen: CanvasRenderingContext2D, width: number, height: number}} surface @param {Palette} colours @param {Shown} of
 * @returns {Camera} */
export function drawScene(surface, colours, of) {
  const { pen: on, width, height } = surface,
    {
      view: [x0 = 0, x1 = 1, y0 = 0, y1 = 1],
    } = of;
  const foot = of.scale ? colours.text * 3.2 : 6;
  const scale = Math.min((width - 12) / (x1 - x0), (height - foot - 6) / (y1 - y0));
  const w = scale * (x1 - x0),
    h = scale * (y1 - y0),
    left = (width - w) / 2,
    top = (height - foot - h) / 2;
  /** @type {Camera} */
  const at = { left: x0 - left / scale, top: y1 + top / scale, scale };
  const maps = mapsOf(isDark(colours.paper)),
    map = of.water ? maps.water : of.scale?.signed ? maps.signed : maps.even;
  if (of.field && of.scale) {
    const range = of.scale.range(),
      none = grey(colours.edge);
    const cells = of.relief ? paintRelief(of.field, range, map, none, of.cells) : paint(of.field, lookUp(of.field, range, map, none));
    on.imageSmoothingEnabled = !of.cells;
    on.imageSmoothingQuality = of.still ? 'high' : 'low'; /* the high one takes ten times as long */
    on.drawImage(cells, left, top, w, h);
  }
  on.strokeStyle = colours.edge;
  on.lineWidth = 1;
  on.setLineDash([]);
  on.strokeRect(left - 0.5, top - 0.5, w + 1, h + 1);
  on.save();
  on.beginPath();
  on.rect(left, top, w, h);
  on.clip();
  for (const list of of.points) {
    if (list.columns.includes('width_m')) boxes(on, at, list, colours);
    else if (list.columns.includes('z_m')) fromAbove(on, at, list, colours);
    else if (list.line) line(on, at, list, colours);
    else discs(on, at, list, of.field ? maps.even : map, of.scale?.range() ?? [0, 1], { left, top, w, h });
  }
  on.restore();
  const spare = Math.max(0, (width - Math.max(w, 40 * colours.text)) / 2);
  if (of.scale) legend(on, colours, map, of, { left: Math.max(10, spare), right: width - Math.max(4, spare), bottom: height - 2 });
  if (of.note) drawText(on, colours, of.note, width / 2, top + h / 2, { align: 'center', bold: true, colour: colours.snap });
  if (of.hand) reticle(on, colours, at, of.hand);
  return at;
}

/** @param {string} hex of six digits @returns {number} as an ImageData has it */
function grey(hex) {
  const [r = 0, g = 0, b = 0] = [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
  return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
}
