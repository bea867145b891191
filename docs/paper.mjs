// docs/paper.md: where laglab shows what the paper says, from the table below, the scenarios, the lessons and the words of the page.
import { readFileSync, readdirSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '..');
const read = (/** @type {string} */ name) => JSON.parse(readFileSync(path.join(ROOT, name), 'utf8'));

/** What the paper says, in its order. places: all scenarios and lessons of these figures and sections that no row names; scenarios,
 * lessons: these, too; coming: scenarios that belong here once they are there; see: where on the page it is seen.
 * @typedef {{says: string, places?: string[], scenarios?: string[], lessons?: string[], coming?: string[], see: string}} Row */

/** @type {Row[]} */
export const ROWS = [
  {
    says: 'Figures 1 to 3: a program and its output',
    places: ['Figure 1', 'Figure 2', 'Figure 3'],
    see: 'Table below the plots: error at the end; *Paper says / lab shows*',
  },
  { says: 'Figure 4: displacement for four steps', places: ['Figure 4'], see: 'Plot *Error against step*' },
  {
    says: 'Explicit, implicit and semi-implicit Euler, Verlet, reversibility',
    scenarios: ['motion/free_fall', 'motion/spring', 'motion/two_orbits', 'motion/backwards'],
    lessons: ['keeps_energy'],
    see: 'Plots of error and energy',
  },
  {
    says: '30 to 60 frames a second, platforms of different capability',
    scenarios: ['frame_rates', 'motion/accumulator', 'motion/variable_steps'],
    see: '*Input latency* of the players; *Frames* of a motion',
  },
  { says: 'Delays of keyboard, mouse and display', scenarios: ['device_delays'], see: '*Input latency* of the players; *Packet*' },
  {
    says: 'Figure 5: bounding volumes',
    places: ['Figure 5'],
    scenarios: ['rigid/pixel_imperfect'],
    see: 'The volumes, and the table of false hits',
  },
  {
    says: 'Collisions: pairs, two phases, discrete and continuous, glitches, stacks, added energy',
    places: ['Collisions'],
    scenarios: ['rigid/rain', 'rigid/three_bullets', 'rigid/bullets', 'rigid/rugged_wall', 'rigid/ghost_bumps', 'rigid/collapsing_stack'],
    lessons: ['bullet_through', 'falling_stack', 'how_many_sweeps'],
    see: 'Phases of a step drawn over the bodies; plot of energy',
  },
  {
    says: 'Fluids as particles, and on cells by the Navier-Stokes equations',
    scenarios: ['fluid/dam_break', 'fluid/hydrostatic', 'fluid/cavity', 'fluid/taylor_green', 'fluid/rotation'],
    lessons: ['vanishing_smoke'],
    see: 'Numbers next to the field, each with its reference',
  },
  {
    says: 'Sprites for oceans',
    places: ['Fluid Motion'],
    scenarios: ['fluid/sea'],
    see: '*Share of the sea shown*, and heights, against the method spectrum',
  },
  {
    says: 'Network physics: coast to coast, wireless, congestion',
    places: ['Network Physics'],
    scenarios: ['link_distance', 'link_shared', 'link_capacity'],
    see: 'Lower panel *Traffic*: round trip, losses',
  },
  {
    says: 'Authoritative server: a speed that the game forbids',
    places: ['Authoritative Server'],
    scenarios: ['cheat_speed', 'cheat_lag_switch', 'cheat_view_time', 'rifle_trust'],
    see: 'Lower panel *Inputs*: refused ones',
  },
  {
    says: 'Figures 6 and 7: client loop, server loop, shared buffer',
    places: ['Figure 6', 'Figure 7'],
    see: '*Packet* (key N): one input through both loops and the buffers',
  },
  {
    says: 'The client sends its *position*, and the server validates it',
    coming: ['position_reports', 'reports'],
    see: 'All other scenarios send controls, which the server validates',
  },
  {
    says: 'Lockstep: a client sends inputs and waits for the state',
    places: ['Figure 10', 'Figure 11'],
    scenarios: ['lockstep_pipelined'],
    see: 'Messages; lower panel *Waits and desyncs*',
  },
  { says: 'Figure 8: turn-based game, constant lag', places: ['Figure 8'], see: 'Dots of arrivals in both views' },
  {
    says: 'Figure 9: random lag of 10 to 500 ms; de-jitter buffer',
    places: ['Figure 9', 'Dejittering Buffer'],
    see: 'Dots of arrivals; lower panel *Buffers*',
  },
  {
    says: 'Figure 12: prediction, correction, replayed inputs',
    places: ['Figure 12'],
    lessons: ['jump_back'],
    see: 'Lower panel *Inputs*',
  },
  {
    says: 'States that are close already change nothing',
    places: ['Client Side Prediction (with reconciliation)'],
    see: '*Corrections* of A and B; *Tolerance of reconciliation* among the settings of B',
  },
  {
    says: 'Figure 13: own car ahead, others late; interpolation; a server that is down',
    places: ['Figure 13', 'Interpolation', 'Interpolation: when the server is down', 'Snapshot Interpolation'],
    lessons: ['in_the_past', 'empty_buffer'],
    see: 'Dashed marks: where the server has it; lower panel *Buffers*',
  },
  {
    says: 'Deterministic lockstep: its bandwidth, and worlds that drift apart',
    places: ['Deterministic Lockstep'],
    lessons: ['who_waits'],
    see: 'Lower panels *Traffic* (bytes by type of message) and *Waits and desyncs*',
  },
  { says: 'Lost packets are ignored, and the game moves on', coming: ['bucket'], see: '`who_waits` shows the other choice: all wait' },
  {
    says: 'Rifle: the server traces back. Cannon: into the past, then in the present',
    places: ['More Challenges'],
    lessons: ['behind_wall'],
    see: 'Lower panel *Shots*: as seen, now, rewound',
  },
  { says: 'Air resistance of shells ignored', scenarios: ['motion/cannon'], coming: ['cannon_drag'], see: 'Impact with and without drag' },
  {
    says: 'Peers that share all inputs',
    scenarios: ['rollback', 'rollback_loss', 'rollback_shooter'],
    lessons: ['rollback_cost'],
    coming: ['mesh'],
    see: 'Lower panel *Waits and desyncs*',
  },
];

/** @typedef {{id: string, paper?: string, title: any}} Named */

/** @param {string} folder @param {string} [at] @returns {Named[]} */
function scenariosIn(folder, at = '') {
  return readdirSync(path.join(ROOT, folder, at), { withFileTypes: true }).flatMap((entry) => {
    const name = at ? `${at}/${entry.name}` : entry.name;
    if (entry.isDirectory()) return entry.name === 'experiments' ? [] : scenariosIn(folder, name);
    return name.endsWith('.json') ? [{ id: name.slice(0, -5), ...read(`${folder}/${name}`) }] : [];
  });
}

/** Figures in the order of their numbers. @param {Named} a @param {Named} b */
const inOrder = (a, b) => a.id.localeCompare(b.id, 'en', { numeric: true });

export const library = () => ({
  scenarios: scenariosIn('scenarios').sort(inOrder),
  lessons: readdirSync(path.join(ROOT, 'www/lessons'))
    .filter((name) => name.endsWith('.json'))
    .map((name) => ({ id: name.slice(0, -5), ...read(`www/lessons/${name}`) }))
    .sort((a, b) => a.order - b.order),
});

/** What a row shows: those that it names, which must exist, then those of its places. @param {Row} row
 * @param {'scenarios' | 'lessons'} kind @param {Named[]} all @returns {Named[]} */
export function shown(row, kind, all) {
  const named = new Set(ROWS.flatMap((one) => [...(one[kind] ?? []), ...(one.coming ?? [])]));
  const own = (row[kind] ?? []).map((id) => {
    const found = all.find((one) => one.id === id);
    if (!found) throw new Error(`docs/paper.mjs: there is no ${kind.slice(0, -1)} ${id}`);
    return found;
  });
  const coming = kind === 'scenarios' ? all.filter(({ id }) => row.coming?.includes(id)) : [];
  return [...all.filter(({ id, paper }) => !named.has(id) && row.places?.includes(paper ?? '')), ...own, ...coming];
}

const cell = (/** @type {string} */ text) => text.replaceAll('|', '\\|');
const line = (/** @type {string[]} */ cells) => `| ${cells.map(cell).join(' | ')} |`;

/** @param {string[]} head @param {string[][]} rows */
const table = (head, rows) => [line(head), line(head.map(() => '---')), ...rows.map(line)].join('\n');

function coverage() {
  const { scenarios, lessons } = library();
  return table(
    ['', 'In the paper', 'Scenarios', 'Lessons', 'Where to look'],
    ROWS.map((row, i) => {
      const these = shown(row, 'scenarios', scenarios);
      return [
        String(i + 1),
        row.says,
        these.length > 0 ? these.map(({ id }) => `\`${id}\``).join(', ') : 'not yet',
        shown(row, 'lessons', lessons)
          .map(({ id, title }) => `[${title.en}](../www/lessons/${id}.json)`)
          .join(' '),
        row.see,
      ];
    }),
  );
}

/** What the page says where the paper is wrong or says two things. */
function errata() {
  const { motion, netgame_more: netgame } = read('www/words/en.json');
  const rows = Object.entries({ ...motion, ...netgame }).flatMap(([key, says]) => {
    const [, part, name] = /^(\w+)\.paper_says\.(\w+)$/.exec(key) ?? [];
    return part ? [[says, { motion, netgame_more: netgame }[part][`${part}.lab_shows.${name}`]]] : [];
  });
  return table(['The paper says', 'The lab shows'], rows);
}

export const paperDoc =
  () => `<!-- Written by docs/generate.mjs from docs/paper.mjs, scenarios/, www/lessons and www/words: change it there. -->

# The paper, place by place

laglab shows and measures what the paper says about physics in games, alone and over a network, in its text and 13 figures. This page is for
teachers who read the paper with a class: for each statement, the scenario that shows it, the lesson that asks about it, and where on the
page to look. Choose a scenario in the list at the top of the page, or open \`/?scenario=paper/fig08\`; a lesson opens by its card on the
first page, or \`/#lesson=figure_8\`.

${coverage()}

## Figures as text

\`laglab run SCENARIO --text\` prints what the paper prints, from the scenario's own numbers:

\`\`\`sh
build/laglab run paper/fig01 --text   # the program of Figure 1, and its output
build/laglab run paper/fig02 --text   # the lines of Figure 2, float for float; fig03: those of Figure 3
build/laglab run paper/fig04 --text   # the table of Figure 4, next to the digits that the paper prints
build/laglab run paper/fig06 --text   # the client loop; fig07: the server loop
build/laglab run paper/fig10 --text   # captions, and the events: 0, 150, 250, 283, 433, 533 ms
\`\`\`

For every netgame it prints the captions of the views (lag, techniques, updates per second), the way of each player's first input to the
server and back, when the first updates arrive, and the last acknowledged inputs. So \`fig08\` and \`fig09\` compare even and uneven
arrivals, \`fig11\` the order server, A, B.

## Errata

The page shows these next to the scenarios in which they arise, under *Paper says / lab shows*; some lessons say them with the explanation.

${errata()}
`;
