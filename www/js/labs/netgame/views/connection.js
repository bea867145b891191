// State of a player's connection over its view: nothing while it plays; a disconnected view is faded.
import { CONNECTING, CONNECTIONS, DISCONNECTED, E_AWAY, IS_PLAYING } from '../core/frame.js';
import { drawText } from '../../../draw/marks.js';
import { t } from '../../../base/words.js';

/** @typedef {import('./scene.js').DrawContext} DrawContext */

export const FADED = 0.35; /* opacity of a player who is not connected */

/** Whether the player of an entity is not connected. @param {import('../core/frame.js').Entity} entity @returns {boolean} */
export const isAway = (entity) => (entity.flags & E_AWAY) !== 0;

/** Connection state in words; empty while it plays. @param {import('../core/frame.js').View} view @returns {string} */
export function connectionWords(view) {
  const state = view.connection === IS_PLAYING ? '' : t(`netgame.connection.${CONNECTIONS[view.connection] ?? ''}`);
  if (view.connected || view.connection === DISCONNECTED || view.connection === CONNECTING) return state;
  return [state, t('netgame.connection.dropped')].filter((text) => text !== '').join(' · ');
}

/** @param {DrawContext} at */
export function drawConnection(at) {
  const view = at.frame.views[at.view];
  const words = view ? connectionWords(view) : '';
  if (!view || words === '') return;
  const { pen, colours, width, height } = at;
  if (view.connection === DISCONNECTED || view.connection === CONNECTING) {
    pen.globalAlpha = 0.6;
    pen.fillStyle = colours.paper;
    pen.fillRect(0, 0, width, height);
    pen.globalAlpha = 1;
  }
  pen.font = `700 ${colours.text}px ${colours.font}`;
  const wide = pen.measureText(words).width + 2 * colours.text,
    high = colours.text * 1.8,
    top = 2; /* over the axis: what is drawn stays free */
  pen.beginPath();
  pen.roundRect((width - wide) / 2, top, wide, high, high / 2);
  pen.setLineDash([]);
  pen.fillStyle = colours.paper;
  pen.fill();
  pen.lineWidth = colours.line;
  pen.strokeStyle = colours.snap;
  pen.stroke();
  drawText(pen, colours, words, width / 2, top + high / 2 + 1, { align: 'center', bold: true, colour: colours.snap });
}
