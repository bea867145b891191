// Curves over time by uPlot.
import './language_tag.js';
import uPlot from '../../../../vendor/uplot.js';
import { localized } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { palette, paletteVersion, paintOf } from '../../../draw/palette.js';
import { boxOf } from '../../../draw/surface.js';

/** @typedef {import('../core/memory.js').Memory} Memory */
/** @typedef {import('./curves.js').Curve} Curve */

const SPAN_S = 12;
const NOTICED_MS = 100;

export class Chart {
  /** @param {HTMLElement} box @param {[number, number]} empty the range when all is zero @param {() => Curve[]} curves */
  constructor(box, empty, curves) {
    this.box = box;
    this.empty = empty;
    this.curves = curves;
    /** @type {uPlot | null} */
    this.plot = null;
    this.made = '';
  }

  /** Created again when players, colours or size class change. @param {Curve[]} curves @param {number} width @param {number} height */
  make(curves, width, height) {
    this.end();
    const colours = palette();
    const axis = {
      stroke: () => palette().faint,
      font: `${colours.text}px ${colours.font}`,
      grid: { stroke: () => palette().grid, width: 1 },
      ticks: { stroke: () => palette().grid, width: 1, size: 4 },
      gap: 3,
    };
    this.plot = new uPlot(
      {
        width,
        height,
        legend: { show: false },
        cursor: { points: { show: false }, drag: { setScale: false } },
        padding: [6, 16, 0, 0],
        scales: {
          x: { time: false, range: (_, __, max) => [Math.max(0, max - SPAN_S), Math.max(SPAN_S, max)] },
          y: { range: (_, min, max) => padded(min, max, this.empty) },
        },
        axes: [
          { ...axis, size: colours.text + 12, space: 50, values: (_, ticks) => ticks.map((tick) => `${localized(String(tick))} s`) },
          { ...axis, size: colours.text * 3.4, space: 26, values: (_, ticks) => ticks.map((tick) => localized(String(tick))) },
        ],
        hooks: { draw: [(plot) => this.threshold(plot)] },
        series: [
          {},
          ...curves.map((curve) => ({
            label: `${curve.name} (${curve.unit})`,
            stroke: () => paintOf(palette(), curve.player).text,
            width: curve.dotted || this.empty[0] === 0 ? Math.max(1, colours.line - 1) : colours.line - 0.5,
            dash: curve.dotted ? [1.5, 3] : paintOf(colours, curve.player).dash,
            points: { show: false },
          })),
        ],
      },
      [[], ...curves.map(() => [])],
      this.box,
    );
    for (const part of this.box.querySelectorAll('canvas')) part.setAttribute('aria-hidden', 'true');
  }

  /** Without this the library keeps a plot, with the page around it. */
  end() {
    this.plot?.destroy();
    this.plot = null;
  }

  /** In ms: where people begin to notice. @param {uPlot} plot */
  threshold(plot) {
    if (!this.made.includes('(ms)') || this.empty[0] === 0) return;
    const y = plot.valToPos(NOTICED_MS, 'y', true),
      { left, top, width, height } = plot.bbox;
    if (y < top || y > top + height) return;
    const { ctx } = plot;
    ctx.save();
    ctx.strokeStyle = palette().snap;
    ctx.fillStyle = palette().snap;
    ctx.lineWidth = devicePixelRatio;
    ctx.beginPath();
    ctx.moveTo(left, y);
    ctx.lineTo(left + width, y);
    ctx.stroke();
    ctx.textAlign = 'right';
    ctx.fillText(t('netgame.chart.noticed'), left + width, y - 4 * devicePixelRatio);
    ctx.restore();
  }

  /** @param {Memory} memory */
  draw(memory) {
    const { width, height, seen } = boxOf(this.box);
    if (width < 40 || height < 40 || !seen) return;
    const curves = this.curves();
    const key = `${curves.map((c) => `${c.name} (${c.unit})`).join()}|${paletteVersion()}`;
    if (key !== this.made) {
      this.make(curves, width, height);
      this.made = key;
    }
    const plot = this.plot;
    if (!plot) return;
    if (plot.width !== width || plot.height !== height) plot.setSize({ width, height });
    const end = memory.times[memory.times.length - 1] ?? 0;
    let from = memory.times.length;
    while (from > 0 && (memory.times[from - 1] ?? 0) > end - SPAN_S) from--;
    const curvesNow = curves.map((curve) => (curve.values(memory) ?? []).slice(from).map((v) => (v === null ? null : v * curve.scale)));
    plot.batch(() => plot.setData([memory.times.slice(from), ...curvesNow])); /* drawn before it returns: the panel's cost is measured */
  }
}

/** @param {number | null} min @param {number | null} max @param {[number, number]} empty @returns {[number, number]} */
function padded(min, max, empty) {
  const low = Math.min(0, min ?? 0),
    high = Math.max(0, max ?? 0);
  const room = Math.max(1e-3, high - low) * 0.08;
  return high - low < 1e-9 ? empty : [low < 0 ? low - room : 0, high > 0 ? high + room : 0];
}
