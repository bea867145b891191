// Places labels next to marks without overlaps; a label without room is left out.
import { drawText, widthOf } from '../../../draw/marks.js';

/** @typedef {import('./scene.js').DrawContext} DrawContext */

export class Labels {
  /** @param {DrawContext} at */
  constructor(at) {
    this.at = at;
    /** @type {[number, number, number, number][]} left, top, right, bottom */
    this.taken = [];
  }

  /** Keeps a place free. @param {number} x @param {number} y centre @param {number} width @param {number} height */
  block(x, y, width, height) {
    this.taken.push([x - width / 2, y - height / 2, x + width / 2, y + height / 2]);
  }

  /** @param {string} text @param {number} left @param {number} right ends of the thing to label @param {number} y its level
   * @param {number} size its height @param {{colour: string, bold?: boolean}} look */
  put(text, left, right, y, size, look) {
    if (text === '') return;
    const { pen, colours, width, height } = this.at;
    const w = widthOf(pen, colours, text, look.bold),
      h = colours.text * 1.15,
      middle = (left + right) / 2;
    const bound = (/** @type {number} */ x) => Math.max(4, Math.min(width - 4 - w, x));
    const beyond = size / 2 + h * 0.6;
    for (const [x, level] of /** @type {[number, number][]} */ ([
      [right + 8, y],
      [left - 8 - w, y],
      [bound(middle - w / 2), y - beyond],
      [bound(middle - w / 2), y + beyond],
      [bound(right), y - beyond],
      [bound(right), y + beyond],
    ])) {
      const box = /** @type {[number, number, number, number]} */ ([x - 2, level - h / 2, x + w + 2, level + h / 2]);
      const inside = x >= 2 && x + w <= width - 2 && box[1] >= 0 && box[3] <= height;
      if (!inside || this.taken.some((t) => t[0] < box[2] && box[0] < t[2] && t[1] < box[3] && box[1] < t[3])) continue;
      this.taken.push(box);
      drawText(pen, colours, text, x, level, look);
      return;
    }
  }
}
