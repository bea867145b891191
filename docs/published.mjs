// docs/published.md: results of three papers next to those of laglab, from what `bench/run published` measured.
import { existsSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '..');

/** @typedef {Record<string, string>} Row */

const INTRODUCTION = `# Published results, made again

Three papers on lag, a figure of each made again with laglab alone. Each is a scenario of the library, to watch, and an experiment, whose
rows are the figure. None of the three gives its game or its recordings, so scripted players move here, in laglab's own games. What carries
over is a law or a ratio, not a trace; each section says what differs and why.

\`bench/run published\` makes all figures and tables of this page again.
`;

const number = (/** @type {string} */ text) => Number(text);
const digits = (/** @type {number} */ value, n = 3) =>
  Math.abs(value) >= 1000 ? Math.round(value).toLocaleString('en') : String(Number(value.toPrecision(n)));
const sum = (/** @type {Row[]} */ rows, /** @type {string} */ name) => rows.reduce((total, row) => total + number(row[name]), 0);
const range = (/** @type {number[]} */ values) => {
  const [low, high] = [digits(Math.min(...values)), digits(Math.max(...values))];
  return low === high ? low : `${low} to ${high}`;
};
const numbers = (/** @type {Row[]} */ rows, /** @type {string} */ name) => rows.map((row) => number(row[name]));
const unique = (/** @type {Row[]} */ rows, /** @type {string} */ name) => [...new Set(rows.map((row) => row[name]))];

/** @param {string[]} head @param {string[][]} rows */
const table = (head, rows) => [head, head.map(() => '---'), ...rows].map((cells) => `| ${cells.join(' | ')} |`).join('\n');

const command = (/** @type {string} */ name) => `\`\`\`console
$ build/laglab sweep experiments/published_${name} --points --out ${name}.csv --report ${name}.html
\`\`\``;

// ---- Bettner and Terrano, 2001 ----

const MODEM_BYTES_PER_S = 3600;

/** @param {Row[]} rows */
function archers(rows) {
  const at = (/** @type {string} */ way, /** @type {number} */ units, name = 'down_bytes_per_s') =>
    number(rows.find((row) => row.way === way && number(row.units) === units)?.[name] ?? 'NaN');
  const most = Math.max(...rows.map((row) => number(row.units))),
    orders = rows.filter((row) => row.way === 'orders'),
    ways = unique(rows, 'way').filter((way) => way !== 'orders');
  const slope = (/** @type {string} */ way) => (at(way, most) - at(way, 0)) / most,
    hz = (/** @type {string} */ way) => at(way, 0, 'update_hz');
  const levels = unique(rows, 'units');
  const down = orders.map((row) => number(row.down_bytes_per_s));
  const fits = (/** @type {string} */ way) => Math.floor((MODEM_BYTES_PER_S - at(way, 0)) / slope(way));
  return [
    table(
      ['', 'Published', 'laglab'],
      [
        [
          'Units whose positions fit a modem of 28.8 kbit/s',
          'at most 250',
          `${ways.map((way) => `${digits(fits(way))} (${way.replace('snapshots, ', '')})`).join(', ')}, at ${hz(ways[0])} updates a second`,
        ],
        [
          'Bytes of a unit in a message',
          'six values',
          ways.map((way) => `${digits(slope(way) / hz(way))} (${way.replace('snapshots, ', '')})`).join(', '),
        ],
        [
          'Orders, and how their traffic grows with the units',
          'eight players on such modems, “1500 archers”',
          `${range(down)} bytes/s down and ${range(orders.map((row) => number(row.up_bytes_per_s)))} up for 0 to ${digits(most)} units`,
        ],
        [
          'From an order to its effect',
          'two turns of 200 ms: an order of turn 1000 takes effect in turn 1002',
          `${range(numbers(orders, 'input_latency_ms'))} ms, at ${range(numbers(orders, 'steps_per_s'))} of 15 steps a second`,
        ],
      ],
    ),
    table(
      ['Bytes/s to a player', ...levels.map((units) => `${digits(number(units))} units`)],
      unique(rows, 'way').map((way) => [way, ...levels.map((units) => digits(at(way, number(units))))]),
    ),
  ].join('\n\n');
}

// ---- Lee and Chang, 2018 ----

/** @param {Row[]} rows */
function shotBehindCover(rows) {
  const of = (/** @type {string} */ policy, grace = '') => rows.filter((row) => row.policy === policy && row.grace_ms === grace),
    graces = unique(
      rows.filter((row) => row.policy === 'victim_veto'),
      'grace_ms',
    ),
    lags = unique(rows, 'lag_ms'),
    rewind = of('rewind');
  const fewer = (/** @type {Row[]} */ list, at = rewind) => 100 * (1 - sum(list, 'behind_cover') / sum(at, 'behind_cover'));
  const fair = (/** @type {Row[]} */ list) => sum(list, 'hits') - sum(list, 'behind_cover');
  const here = (/** @type {(list: Row[]) => string} */ value) =>
    graces.map((grace) => `${value(of('victim_veto', grace))} (grace ${grace} ms)`).join(', ');
  const all = /** @type {[string, Row[]][]} */ ([
    ['`rewind`', rewind],
    ...graces.map((grace) => [`\`victim_veto\`, grace ${grace} ms`, of('victim_veto', grace)]),
    ['`none`', of('none')],
  ]);
  return [
    table(
      ['', 'Published', 'laglab'],
      [
        ['Fewer shots behind cover than with the traditional way', '94.1 %', here((list) => `${digits(fewer(list))} %`)],
        [
          'The same by the lag of the shooters, without grace',
          'not stated',
          lags
            .map((lag, i) => {
              const one = of('victim_veto', '0').filter((row) => row.lag_ms === lag);
              return `${digits(fewer(one, [rewind[i]]))} % (${lag} ms)`;
            })
            .join(', '),
        ],
        [
          'Accuracy of hits',
          'no significant difference (p = 0.158 and 0.18)',
          `of the hits that were not behind cover there remain ${here((list) => `${digits((100 * fair(list)) / fair(rewind))} %`)}`,
        ],
        [
          'Hits that the shooter saw and that count',
          'not stated',
          `${digits(100 * (1 - sum(rewind, 'denied') / sum(rewind, 'seen_hits')))} % with \`rewind\`; ${here(
            (list) => `${digits(100 * (1 - sum(list, 'denied') / sum(list, 'seen_hits')))} %`,
          )}`,
        ],
      ],
    ),
    table(
      ['Shots behind cover, of all hits', ...lags.map((lag) => `shooters have ${lag} ms`)],
      all.map(([name, list]) => [name, ...list.map((row) => `${row.behind_cover} of ${row.hits}`)]),
    ),
  ].join('\n\n');
}

// ---- Griwodz and Halvorsen, 2006 ----

const SHOWN_MS = '100'; // the round trip of the image

/** @param {Row[]} rows */
function thinStreams(rows) {
  const trips = unique(rows, 'rtt_ms'),
    rates = unique(rows, 'update_hz');
  const shown = rows.filter((row) => row.rtt_ms === SHOWN_MS),
    listed = (/** @type {Row[]} */ list) =>
      list
        .map((row) => {
          const [extra, timer, fast] = [row.extra_ms, row.timer_ms, row.fast_ms].map((ms) => digits(number(ms)));
          return `${extra} (timer ${timer}, fast ${fast}) with ${digits(number(row.in_timer), 2)}`;
        })
        .join('; ');
  const late = (/** @type {string | undefined} */ hz) =>
    range(rows.filter((row) => row.update_hz === hz).map((row) => number(row.max_ms) - number(row.rtt_ms) / 2));
  const cells = (/** @type {(row: Row) => string} */ value) =>
    trips.map((rtt) => [
      `round trip ${rtt} ms`,
      ...rates.map((hz) => rows.filter((row) => row.rtt_ms === rtt && row.update_hz === hz).map(value)[0] ?? ''),
    ]);
  const head = rates.map((hz) => {
    const row = rows.find((one) => one.update_hz === hz);
    return `${hz} updates/s, ${digits(number(row?.in_timer ?? ''), 2)} packets`;
  });
  return [
    table(
      ['', 'Published', 'laglab, round trip 100 ms: extra latency in ms by packets in the time of the timer'],
      [
        [
          'Fewer than 4 packets in flight',
          'fast retransmit cannot be triggered: lost ones wait for the timer',
          listed(shown.filter((row) => number(row.in_timer) < 4)),
        ],
        ['4 packets in flight and more', 'fast retransmit repairs', listed(shown.filter((row) => number(row.in_timer) >= 4))],
        [
          'What ruins the game',
          'almost only repeated time-outs',
          `the latest message of all runs is late by ${late(rates[0])} ms at ${rates[0]} updates a second, ` +
            `which is more than one timer of 200 ms; by ${late(rates.at(-1))} ms at ${rates.at(-1)}`,
        ],
      ],
    ),
    table(
      ['Mean extra latency, ms (timer; fast retransmit)', ...head],
      cells((row) => `${digits(number(row.extra_ms))} (${digits(number(row.timer_ms))}; ${digits(number(row.fast_ms))})`),
    ),
    table(
      ['Time-outs per loss', ...head],
      cells((row) => digits(number(row.timeouts_per_loss), 2)),
    ),
    table(
      ['Latency of a message, ms: 99th percentile, longest', ...head],
      cells((row) => ['p99_ms', 'max_ms'].map((name) => digits(number(row[name]))).join(', ')),
    ),
  ].join('\n\n');
}

// ---- the page ----

/** @type {{name: string, heading: string, before: string, body: (rows: Row[]) => string, after: string}[]} */
const PAPERS = [
  {
    name: 'archers',
    heading: 'Orders or positions: Bettner and Terrano, 2001',
    before: `P. Bettner, M. Terrano: *1500 Archers on a 28.8: Network Programming in Age of Empires and Beyond*. Game Developers Conference
2001; online at
[gamedeveloper.com](https://www.gamedeveloper.com/programming/1500-archers-on-a-28-8-network-programming-in-age-of-empires-and-beyond).

The paper says why Age of Empires sends no positions: x, y, status, action, facing and damage of each unit would limit it to 250 moving
units. All machines move all units instead, and only orders travel, for eight players on modems of 28.8 kbit/s (3600 bytes/s). The price is
a delay: turns are typically 200 ms long, and an order takes effect two turns later. Players did not notice 250 ms, and found up to 500 ms
very playable.

The figure is that statement as curves: bytes a second against the number of units. The scenario is \`published/archers\`: eight players,
deterministic lockstep at 15 steps a second, the frame rate that the paper aimed at, messages every 200 ms, and an input delay that gives
400 ms.`,
    body: archers,
    after: `What differs:

- The paper states 250 units, not how many bytes a unit takes nor how often it would be sent. With one byte for each of the six values 250
  units fill the modem at 2.4 updates a second; so the experiment sends 2.4 snapshots a second. At 10 a second a quarter as many units fit.
- laglab's units have a position, a velocity, an angle and its rate. \`full\` is the state as it lies in memory, 56 bytes; \`quantised\`
  rounds positions to 0.1 m in a field of 200 m; \`delta\` sends differences from what the player has acknowledged, which the paper does not
  consider.
- The engine limits deterministic lockstep to 255 entities, so the curves end at 240 units and eight players; 1500 archers have no room.
  Orders do not grow up to there, to the byte.
- Headers of IPv4 and UDP, pings and their answers count here, also with 0 units.
- laglab sends each input until it is acknowledged, with a hash of the world for each step, over a relay; Age of Empires sent orders from
  each player to each other. Its orders took effect at the start of the turn after the next one, 200 to 400 ms later; here each takes 400
  ms.`,
  },
  {
    name: 'shot_behind_cover',
    heading: 'Shot behind cover: Lee and Chang, 2018',
    before: `S. W. K. Lee, R. K. C. Chang: *Enhancing the Experience of Multiplayer Shooter Games via Advanced Lag Compensation*. ACM
Multimedia Systems Conference (MMSys) 2018, [doi:10.1145/3204949.3204971](https://doi.org/10.1145/3204949.3204971).

Traditional lag compensation rewinds the targets to what the shooter saw, so players with little lag are hit behind cover by those with
much. The paper's advanced lag compensation asks the victim: its client denies a hit if the victim was in cover, unless the victim has so
long a lag that its answer comes too late ([described by D. Jiménez
Morales](https://danieljimenezmorales.github.io/2023-10-29-the-art-of-hit-registration/)). In matches of persons in a shooter of their own
the authors counted 94.1 % fewer shots behind cover, while the accuracy of hits and the responsiveness did not differ significantly.

The scenario is \`published/shot_behind_cover\`: four scripted players come out of cover, react after 180 to 300 ms and hide again. B and D
have lag, A and C have 5 ms; only hits on A and C are counted. \`rewind\` is the traditional way. \`victim_veto\` is the policy of laglab
that is nearest to the advanced one: a hit counts only if the shooter was in sight in the victim's own view within the last
\`veto_grace_ms\`.`,
    body: shotBehindCover,
    after: `What differs:

- Of the paper only its abstract and that description were at hand, not its figures. There the victim's client answers, which takes a round
  trip; \`victim_veto\` judges at once, by the view of the victim that the server reconstructs. There a victim with too much lag cannot
  deny; here every victim can. The grace has no counterpart in the abstract, so three are shown; 0 is nearest to a client that denies each
  hit in cover.
- The abstract does not state the lags. The reduction grows with the lag of the shooters here, since the rest, which no veto takes away, is
  what the victim's screen shows later than the server judges: the server cannot know how the victim will have moved by then.
- Scripts that hide every 2.4 s are shot behind cover often, as the first row of the table shows. The veto takes away nearly all of these
  hits and hardly any other; but the shooter saw them, so here it misses much of what it saw hit. How many of all hits were behind cover in
  the paper's matches is not in the abstract; the fewer, the less a shooter notices.`,
  },
  {
    name: 'thin_streams',
    heading: 'Thin streams over TCP: Griwodz and Halvorsen, 2006',
    before: `C. Griwodz, P. Halvorsen: *The Fun of using TCP for an MMORPG*. Network and Operating System Support for Digital Audio and
Video (NOSSDAV) 2006, pages 1 to 7. The law in numbers is that of the same group's [documentation of thin streams in
Linux](https://docs.kernel.org/networking/tcp-thin.html): with fewer than 4 packets in flight fast retransmit cannot be triggered. K.-T.
Chen et al., *An Empirical Evaluation of TCP Performance in Online Games* (ACE 2006), measured 8 packets a second from clients of such a
game.

A game sends small messages, and few of them. TCP learns of a loss at once only by three acknowledgements for later packets; where too few
are in flight, it waits for its retransmission timer, and twice as long if the same message is lost again. The authors found that almost
only repeated time-outs ruin the game.

The scenario is \`published/thin_streams\`: a race over TCP, 1 % of the packets to A are lost. The experiment varies the round trip and the
rate of snapshots. Packets in flight are all that are not acknowledged, also those sent after the lost one until the timer ends: with a
timer of 200 ms and n packets a second these are n / 5. The two closed forms are the mean extra latency if each loss is repaired by the
timer, or each by fast retransmit ([Head-of-line blocking](transports.md#head-of-line-blocking)): what laglab measures follows the one or
the other.`,
    body: thinStreams,
    after: `What differs:

- The paper has traces of Anarchy Online; here a race sends snapshots at a constant rate, and losses are independent. So repeated time-outs
  are rarer than on a congested path, and the longest latency is that of ten-minute runs, not of a day.
- The least timer is 200 ms in all here, while Linux adds at least 200 ms to the round trip. Where the timer is shorter than a round trip
  and four intervals between packets, it also ends after fast retransmit, before the packet that was sent again is acknowledged: so
  time-outs per loss fall later than the extra latency. From a round trip of 200 ms on, without jitter, that happens at any rate; such round
  trips are not in the figure.
- The closed forms are of first order, of packets at equal distances. Answers to pings make the distances unequal, so near 4 packets some
  losses are repaired in the one way and some in the other.
- Answers to pings, four a second, travel in the same stream and count as packets in flight. Time-outs per loss are per 1 % of the packets
  with messages.`,
  },
];

/** @param {(text: string) => {comments: [string, string][], rows: Row[]}} parse
 * @param {(name: string, head: Map<string, string>) => string} age */
export function publishedDoc(parse, age) {
  const sections = PAPERS.map(({ name, heading, before, body, after }) => {
    const result = `published/${name}`,
      file = path.join(ROOT, `bench/results/${result}.csv`);
    if (!existsSync(file))
      return `## ${heading}\n\n${before}\n\n${command(name)}\n\nNo figures yet: \`bench/run published\` measures them.\n\n${after}`;
    const { comments, rows } = parse(readFileSync(file, 'utf8')),
      head = new Map(comments);
    return [
      `## ${heading}`,
      before,
      command(name),
      `![${heading}](../bench/results/${result}.svg)`,
      body(rows),
      `${age(result, head)} [All rows](../bench/results/${result}.csv).`,
      after,
    ].join('\n\n');
  });
  return `${[INTRODUCTION.trimEnd(), ...sections].join('\n\n')}\n`;
}
