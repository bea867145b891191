// Saves the image of a view or chart, and its data, each with what it takes to make it again: settings, seed, time, version, address.
import { address } from '../base/api.js';
import { plots } from '../draw/plot.js';
import { palette } from '../draw/palette.js';
import { touch } from '../draw/redraw.js';
import { finest } from '../draw/surface.js';
import { lab } from '../session/labs.js';
import { experiment, frame, notify, params, session } from '../session/state.js';
import { SCHEMA } from '../stream/records.js';
import { versionOf } from '../workbench/version.js';
import { withTexts } from './png.js';
import { language as spoken, t } from '../base/words.js';
import { changedSettings, wordsOf } from './settings.js';
import { tableOfPlot } from './table.js';

/** @typedef {import('../session/lab.js').Table} Table */
/** name: of the view or chart; table: of its data, empty for that of the canvas, null for none
 * @typedef {{name: string, canvas: HTMLCanvasElement | null, table: string | null}} Taken */
/** Of what is shown, at that time. @typedef {{title: string, settings: string, moment: string, version: string, source: string}} Facts */

/** The address that shows the same; of a read-only session that of the session. */
const sourceOf = () => location.href.replace(/([#&])k=[^&]*/, '$1').replace(/&$/, '');

/** @returns {Promise<Facts>} of this moment: what may change meanwhile is read before anything is waited for */
async function factsNow() {
  const language = spoken.peek(),
    now = frame.value,
    known = experiment.value === null ? undefined : lab.value?.about?.(),
    id = session.value?.id ?? '',
    seed = params.value?.seed,
    title = String(known?.title ?? params.value?.title ?? ''),
    source = sourceOf();
  const words = await wordsOf(language),
    say = words.takeaway;
  if (known) return { title, settings: known.settings, moment: known.moment, version: `laglab ${known.version}`, source };
  const [changed, version] = await Promise.all([changedSettings(words, language), versionOf(id)]);
  const time = (now?.time_s ?? 0).toLocaleString(language, { minimumFractionDigits: 2, maximumFractionDigits: 2, useGrouping: false });
  return {
    title,
    settings: changed.length > 0 ? `${say.changed}: ${changed.join('; ')}` : (say.unchanged ?? ''),
    moment: `${say.seed} ${seed} · ${say.tick} ${now?.tick ?? 0} · ${time} s`,
    version: `laglab ${version} · ${say.schema} ${SCHEMA}`,
    source,
  };
}

/** @param {string} title @param {string} name @param {string} ending */
const fileOf = (title, name, ending) =>
  `laglab-${`${title}-${name}`
    .toLowerCase()
    .replace(/[^\p{L}\p{N}]+/gu, '-')
    .replace(/^-|-$/g, '')
    .slice(0, 80)}.${ending}`;

/** @param {Blob} blob @param {string} name */
function download(blob, name) {
  const at = URL.createObjectURL(blob),
    anchor = document.createElement('a');
  anchor.href = at;
  anchor.download = name;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(at), 10000);
}

// ---- images ----

/** @param {CanvasRenderingContext2D} pen @param {string} text @param {number} width @returns {string[]} lines; a long word is cut */
function wrapped(pen, text, width) {
  /** @type {string[]} */
  const lines = [];
  let line = '';
  for (let word of text.split(' ')) {
    while (pen.measureText(word).width > width) {
      let cut = word.length - 1;
      while (cut > 1 && pen.measureText(word.slice(0, cut)).width > width) cut--;
      if (line !== '') lines.push(line);
      lines.push(word.slice(0, cut));
      line = '';
      word = word.slice(cut);
    }
    const longer = line === '' ? word : `${line} ${word}`;
    if (pen.measureText(longer).width <= width) line = longer;
    else {
      lines.push(line);
      line = word;
    }
  }
  return line === '' ? lines : [...lines, line];
}

const SCALE = 2; /* device pixels per CSS px of an image, at least: it is for print and projectors */

/** What a canvas shows, drawn again where the screen is coarser than an image should be. @param {HTMLCanvasElement} canvas
 * @returns {Promise<ImageBitmap>} */
function taken(canvas) {
  finest.ratio = SCALE;
  try {
    if (frame.value !== null) lab.value?.draw?.(frame.value, true, false);
    return createImageBitmap(canvas);
  } finally {
    finest.ratio = 1;
    touch();
  }
}

const LEAST_PX = 640; /* CSS px: a narrower image would have a caption longer than itself */

/** The image above its caption. @param {{of: ImageBitmap, width: number, height: number}} image device pixels
 * @param {number} ratio device pixels per CSS px @param {string} name @param {Facts} facts @param {NonNullable<Table['lines']>} keys
 * @returns {HTMLCanvasElement} */
function composed(image, ratio, name, facts, keys) {
  const colours = palette(),
    size = 13 * ratio,
    gap = 10 * ratio,
    width = Math.max(image.width, LEAST_PX * ratio) + 2 * gap;
  const made = document.createElement('canvas'),
    pen = /** @type {CanvasRenderingContext2D} */ (made.getContext('2d'));
  const fontOf = (/** @type {boolean} */ bold) => `${bold ? 'bold ' : ''}${bold ? 1.25 * size : size}px ${colours.font}`;
  pen.font = fontOf(true);
  const head = wrapped(pen, name === '' || name === facts.title ? facts.title : `${facts.title} – ${name}`, width - 2 * gap);
  pen.font = fontOf(false);
  const strip = [facts.settings, facts.moment, facts.version, facts.source].flatMap((text) => wrapped(pen, text, width - 2 * gap));
  /** @type {{at: number, row: number, key: (typeof keys)[number]}[]} */
  const places = [];
  let at = gap,
    row = 0;
  for (const key of keys) {
    const wide = 3 * size + pen.measureText(key.name).width + 2 * gap;
    if (at > gap && at + wide > width) {
      at = gap;
      row++;
    }
    places.push({ at, row, key });
    at += wide;
  }
  const keyRows = keys.length > 0 ? row + 1 : 0,
    line = 1.45 * size,
    top = gap + head.length * 1.25 * line;
  made.width = Math.round(width);
  made.height = Math.round(top + image.height + keyRows * line + gap + strip.length * line + gap);
  pen.fillStyle = colours.paper;
  pen.fillRect(0, 0, made.width, made.height);
  pen.textBaseline = 'middle';
  pen.fillStyle = colours.ink;
  pen.font = fontOf(true);
  head.forEach((text, i) => pen.fillText(text, gap, gap + (i + 0.5) * 1.25 * line));
  pen.drawImage(image.of, gap, top, image.width, image.height);
  pen.strokeStyle = colours.grid;
  pen.lineWidth = ratio;
  pen.strokeRect(gap, top, image.width, image.height);
  pen.font = fontOf(false);
  for (const { at: x, row: r, key } of places) {
    const y = top + image.height + (r + 0.7) * line;
    pen.strokeStyle = key.colour;
    pen.lineWidth = colours.line * ratio;
    pen.setLineDash((key.dash ?? []).map((part) => part * ratio));
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(x + 2.4 * size, y);
    pen.stroke();
    pen.fillStyle = colours.ink;
    pen.fillText(key.name, x + 3 * size, y);
  }
  const from = top + image.height + keyRows * line + gap;
  strip.forEach((text, i) => pen.fillText(text, gap, from + (i + 0.5) * line));
  return made;
}

/** @param {Taken} of @returns {Promise<Table | null>} */
async function tableOf({ canvas, table }) {
  const plot = canvas && plots.get(canvas),
    own = (await lab.value?.tables?.())?.[table || (canvas?.id ?? '')]?.();
  if (own !== undefined) return own;
  return plot ? tableOfPlot(plot) : null;
}

/** @param {Taken} of */
export async function saveImage(of) {
  const { canvas, name } = of;
  if (canvas === null || canvas.width < 2) {
    notify(t('takeaway.nothing'));
    return;
  }
  const across = Math.max(1, canvas.clientWidth);
  try {
    const [image, facts, table] = await Promise.all([taken(canvas), factsNow(), tableOf(of)]);
    const keys = (table?.lines ?? []).filter((line) => line.name !== '');
    const ratio = Math.max(SCALE, image.width / across),
      times = (ratio * across) / image.width; /* a chart that cannot be drawn finer is enlarged */
    const made = composed({ of: image, width: image.width * times, height: image.height * times }, ratio, name, facts, keys);
    const blob = await new Promise((done) => made.toBlob(done, 'image/png'));
    const texts = {
      Title: `${facts.title} – ${name}`,
      Description: `${facts.settings}\n${facts.moment}`,
      Software: facts.version,
      Source: facts.source,
    };
    download(await withTexts(/** @type {Blob} */ (blob), texts), fileOf(facts.title, name, 'png'));
  } catch (error) {
    notify(t('takeaway.not_saved', { why: error instanceof Error ? error.message : t('takeaway.no_answer') }));
  }
}

// ---- data ----

/** As RFC 4180 has it. @param {unknown} value */
const cell = (value) => {
  const text = value === null || value === undefined || Number.isNaN(value) ? '' : String(value);
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

/** Where the page has no table of what is shown: the daemon's trace of the run. */
async function trace() {
  const answer = await fetch(address(`sessions/${session.value?.id ?? ''}/trace`));
  if (!answer.ok) throw new Error(t('takeaway.answered', { status: String(answer.status) }));
  return answer.text();
}

/** @param {Taken} of */
export async function saveData(of) {
  try {
    const reading = factsNow(),
      table = await tableOf(of);
    const [facts, body] = await Promise.all([
      reading,
      table === null
        ? trace()
        : [table.columns.map(({ name, unit }) => (unit ? `${name} (${unit})` : name)), ...table.rows]
            .map((row) => `${row.map(cell).join(',')}\r\n`)
            .join(''),
    ]);
    const head = [`${facts.title} – ${of.name}`, facts.settings, `${facts.moment} · ${facts.version}`, facts.source];
    const text = `${head.map((line) => `# ${line.replace(/[\r\n]+/g, ' ')}\r\n`).join('')}${body}`;
    download(new Blob([text], { type: 'text/csv;charset=utf-8' }), fileOf(facts.title, of.name, 'csv'));
  } catch (error) {
    notify(t('takeaway.not_saved', { why: error instanceof Error ? error.message : t('takeaway.no_answer') }));
  }
}
