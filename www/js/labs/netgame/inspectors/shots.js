// A shot three times over: what the shooter saw, what the server has now, and what the server looked back at.
import { bodiesOf, NOBODY, NOT_YET, PROJECTILE, S_BEHIND_COVER, S_CLAMPED, S_DISTRUSTED } from '../core/frame.js';
import { fixed, letter } from '../../../base/format.js';
import { t } from '../../../base/words.js';
import { paintOf } from '../../../draw/palette.js';
import { drawText } from '../../../draw/marks.js';

/** @typedef {import('../core/inspector.js').InspectorContext} InspectorContext */
/** @typedef {import('../core/frame.js').Shot} Shot */
/** @typedef {'seen' | 'now' | 'looked'} When */

/** The last shot of the chosen player. @param {InspectorContext} at @returns {Shot | undefined} */
const lastOf = ({ frame, player }) =>
  frame.shots.filter((shot) => shot.player === player).sort((a, b) => b.evaluated_at_s - a.evaluated_at_s)[0];

/** @param {number} hit @param {InspectorContext} at @returns {string} */
const bodyOf = (hit, at) => {
  if (hit === NOBODY) return t('netgame_more.shots.miss');
  if (hit === NOT_YET) return t('netgame_more.shots.in_flight');
  const players = at.layout.players.length;
  return t('netgame_more.shots.hits', { body: hit < players ? letter(hit) : t('netgame_more.shots.target', { n: hit - players + 1 }) });
};

/** @param {Shot} shot */
const weaponOf = (shot) => t(shot.weapon === PROJECTILE ? 'netgame_more.shots.cannon' : 'netgame_more.shots.rifle');

/** Fixed scenery of the layout, if the game has any. @param {InspectorContext} at
 * @returns {{x: number, y: number, width_m: number, height_m: number}[]} */
const coverOf = (at) => /** @type {any} */ (at.layout).fixed ?? [];

/** Lines of a title that are no wider than `width`. @param {InspectorContext} at @param {string} title @param {number} width */
function linesOf({ pen, colours }, title, width) {
  pen.font = `700 ${colours.text}px ${colours.font}`;
  /** @type {string[]} */ const lines = [];
  for (const word of title.split(' ')) {
    const longer = `${lines.at(-1)} ${word}`;
    if (lines.length > 0 && pen.measureText(longer).width <= width) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines;
}

/** One panel; `rows`: lines that are kept free for titles. @param {InspectorContext & {rows: number}} at @param {Shot} shot
 * @param {When} when @param {number} left @param {number} width @param {string[]} title @param {number} hit */
function panel(at, shot, when, left, width, title, hit) {
  const { pen, colours, height, layout } = at;
  const { x_min: x0, x_max: x1, y_min: y0, y_max: y1 } = layout.scene;
  const head = colours.text * (1.5 + 1.2 * at.rows),
    scale = Math.min((width - 12) / Math.max(1e-6, x1 - x0), (height - head - 6) / Math.max(1e-6, y1 - y0));
  const x = (/** @type {number} */ m) => left + width / 2 + (m - (x0 + x1) / 2) * scale;
  const y = (/** @type {number} */ m) => head + (height - head) / 2 - (m - (y0 + y1) / 2) * scale;
  pen.setLineDash([]);
  pen.strokeStyle = colours.grid;
  pen.lineWidth = 1;
  pen.strokeRect(left + 0.5, 0.5, width - 1, height - 1);
  title.forEach((line, i) => drawText(pen, colours, line, left + 6, colours.text * (0.8 + 1.2 * i), { bold: true }));
  drawText(pen, colours, bodyOf(hit, at), left + 6, head - colours.text * 0.7, {
    colour: hit >= 0 ? colours.snap : colours.faint,
    bold: hit >= 0,
  });
  pen.save();
  pen.beginPath();
  pen.rect(left + 1, head, width - 2, height - head - 1);
  pen.clip();
  pen.fillStyle = colours.grid;
  for (const one of coverOf(at))
    pen.fillRect(x(one.x - one.width_m / 2), y(one.y + one.height_m / 2), one.width_m * scale, one.height_m * scale);
  const [mx, my] = when === 'seen' ? [shot.x, shot.y] : [shot.server_x, shot.server_y];
  if (shot.weapon !== PROJECTILE) {
    /* a ray; a shell flies on in the views */
    pen.strokeStyle = colours.ink;
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.moveTo(x(mx), y(my));
    pen.lineTo(x(mx + shot.dx * (x1 - x0) * 2), y(my + shot.dy * (x1 - x0) * 2));
    pen.stroke();
  }
  bodiesOf(at.frame, shot).forEach((body, i) => {
    const [bx, by] =
      when === 'seen' ? [body.seen_x, body.seen_y] : when === 'now' ? [body.now_x, body.now_y] : [body.looked_x, body.looked_y];
    const r = Math.max(4, scale * 0.6);
    pen.setLineDash(when === 'seen' ? [4, 3] : []);
    pen.lineWidth = i === hit ? colours.line + 1 : 1.5;
    pen.strokeStyle = when === 'seen' ? colours.accent : when === 'now' ? colours.edge : colours.snap;
    pen.fillStyle = i < layout.players.length ? paintOf(colours, i).fill : colours.paper;
    pen.beginPath();
    pen.arc(x(bx), y(by), r, 0, 2 * Math.PI);
    pen.globalAlpha = 0.55;
    pen.fill();
    pen.globalAlpha = 1;
    pen.stroke();
  });
  pen.restore();
}

/** @param {Shot} shot */
const notesOf = (shot) =>
  [
    shot.flags & S_CLAMPED ? t('netgame_more.shots.clamped') : '',
    shot.flags & S_DISTRUSTED ? t('netgame_more.shots.distrusted') : '',
    shot.flags & S_BEHIND_COVER ? t('netgame_more.shots.behind_cover') : '',
  ].filter((note) => note !== '');

/** The farthest that a body has moved since the view that the shooter saw. @param {import('../core/frame.js').Frame} frame
 * @param {Shot} shot */
const movedOf = (frame, shot) =>
  Math.max(
    0,
    ...bodiesOf(frame, shot)
      .filter((_, i) => i !== shot.player)
      .map((b) => Math.hypot(b.now_x - b.seen_x, b.now_y - b.seen_y)),
  );

/** @param {InspectorContext} at @param {Shot} shot @returns {string} */
function resultText(at, shot) {
  const says = t('netgame_more.shots.says', {
    name: letter(shot.player),
    weapon: weaponOf(shot),
    rule: bodyOf(shot.compensated_hit, at),
    present: bodyOf(shot.server_now_hit, at),
    age: fixed((shot.evaluated_at_s - shot.view_time_s) * 1000, 0),
    back: fixed((shot.evaluated_at_s - shot.rewound_to_s) * 1000, 0),
    moved: fixed(movedOf(at.frame, shot), 2),
  });
  return [says, ...notesOf(shot)].join(' · ');
}

/** @type {import('../core/inspector.js').Inspector} */
export const shots = {
  id: 'shots',
  players: true,
  fits: (frame) => frame.shots.length > 0,
  draw(at) {
    const shot = lastOf(at),
      { pen, colours, width } = at;
    if (!shot) {
      drawText(pen, colours, t('netgame_more.shots.none', { name: letter(at.player) }), 8, at.height / 2, { colour: colours.faint });
      return;
    }
    const line = colours.text * 1.5,
      third = width / 3;
    const saw = fixed((shot.evaluated_at_s - shot.view_time_s) * 1000, 0),
      back = fixed((shot.evaluated_at_s - shot.rewound_to_s) * 1000, 0);
    const titles = [
      t('netgame_more.shots.saw', { ms: saw }),
      t('netgame_more.shots.now'),
      t('netgame_more.shots.rewound', { ms: back }),
    ].map((title) => linesOf(at, title, third - 12));
    const inner = { ...at, height: at.height - line, rows: Math.max(...titles.map((lines) => lines.length)) };
    panel(inner, shot, 'seen', 0, third, titles[0], shot.client_view_hit);
    panel(inner, shot, 'now', third, third, titles[1], shot.server_now_hit);
    panel(inner, shot, 'looked', 2 * third, third, titles[2], shot.compensated_hit);
    const facts = t('netgame_more.shots.line', {
      name: letter(shot.player),
      weapon: weaponOf(shot),
      rule: bodyOf(shot.compensated_hit, at),
      present: bodyOf(shot.server_now_hit, at),
      moved: fixed(movedOf(at.frame, shot), 2),
    });
    drawText(pen, colours, [facts, ...notesOf(shot)].join(' · '), 6, at.height - line / 2);
  },
  words(at) {
    const shot = lastOf(at);
    return shot ? resultText(at, shot) : t('netgame_more.shots.none', { name: letter(at.player) });
  },
};
