// The page on a slow machine: Chromium with a processor six times slower. What it reads until a lab shows its first frame and in the
// seconds after it, when that frame stands, how many frames it draws a second, and the script of each.
//   bench/run page [--quick] [--rate=6] [--labs=race,fluid]      --rate: how many times slower
import { digits, interleave, median, pause, printTable, say, writeCsv } from './lib.mjs';
import { startDaemon } from '../tests/lib/daemon.mjs';
import { launch } from '../tests/page/lib.mjs';

const quick = process.argv.includes('--quick'),
  rate = Number(process.argv.find((word) => word.startsWith('--rate='))?.slice(7) ?? 6),
  only = process.argv
    .find((word) => word.startsWith('--labs='))
    ?.slice(7)
    .split(',');
const ROUNDS = quick ? 1 : 3,
  SETTLE_MS = quick ? 3000 : 5000 /* the daemon finds the rate that the page keeps up with */,
  WATCH_MS = quick ? 3000 : 6000,
  LONG_MS = 60000;
const LEAST_FPS = 30,
  FIRST_MS = 1000,
  FIRST_BYTES = 150 * 1024;
const SIZE = { width: 1366, height: 768 };

/** Scenes that move during the whole measurement; the first page has nothing to draw. */
const LABS = [
  { lab: 'questions', at: '' },
  { lab: 'race', at: '#race' },
  { lab: 'eight', at: '?scenario=eight' },
  { lab: 'shooter', at: '?scenario=rifle' },
  { lab: 'crates', at: '?scenario=crates' },
  { lab: 'methods', at: '?scenario=motion/two_orbits&set=duration_s:60' },
  { lab: 'collide', at: '?scenario=rigid/tumbler&set=duration_s:60' },
  { lab: 'fluid', at: '?scenario=fluid/two_discs&set=duration_s:60' },
];

const daemon = await startDaemon(),
  browser = await launch({ whole: true });

/** Bytes over the wire and requests, until now. @param {import('playwright-core').CDPSession} devtools */
async function counted(devtools) {
  const sum = { bytes: 0, requests: 0 };
  devtools.on('Network.responseReceived', () => sum.requests++);
  devtools.on('Network.loadingFinished', ({ encodedDataLength }) => (sum.bytes += encodedDataLength));
  await devtools.send('Network.enable');
  return sum;
}

const countsOf = (page) => page.evaluate(() => ({ ms: performance.now(), ...globalThis.laglab().counts }));

/** Opens a lab with nothing kept, and watches it. */
async function measure({ at }) {
  const context = await browser.newContext({ viewport: SIZE }),
    page = await context.newPage(),
    devtools = await context.newCDPSession(page);
  const read = await counted(devtools);
  await devtools.send('Emulation.setCPUThrottlingRate', { rate });
  await page.goto(daemon.url + at);
  const first = await page.waitForFunction(
    (door) =>
      door
        ? document.querySelector('.cards a, .cards button, .door a') !== null && performance.now()
        : performance.getEntriesByName('laglab-first-frame')[0]?.startTime,
    at === '',
    { timeout: LONG_MS },
  );
  const early = { ...read },
    first_ms = await first.jsonValue();
  await pause(SETTLE_MS);
  const row = { first_ms, first_bytes: early.bytes, first_requests: early.requests, bytes: read.bytes, requests: read.requests };
  if (at !== '') {
    const from = await countsOf(page);
    await pause(WATCH_MS);
    const to = await countsOf(page),
      costs = await page.evaluate(() => [...globalThis.laglab.costs]);
    Object.assign(row, { fps: ((to.drawn - from.drawn) * 1000) / (to.ms - from.ms), script_ms: median(costs) });
  }
  await context.close();
  return row;
}

const measured = await interleave(
  ROUNDS,
  LABS.filter(({ lab }) => only?.includes(lab) ?? true),
  measure,
);
await browser.close();
await daemon.stop();

const rows = [...measured].flatMap(([{ lab }, list]) => list.map((one, round) => ({ lab, round, ...one })));
const middle = (list, name) => digits(median(list.map((one) => one[name] ?? NaN)));
printTable(
  `Chromium, processor ${rate} times slower, ${SIZE.width} x ${SIZE.height}, median of ${ROUNDS}`,
  [...measured].map(([{ lab }, list]) => ({
    lab,
    'frames/s': middle(list, 'fps'),
    'script (ms)': middle(list, 'script_ms'),
    'first frame (ms)': middle(list, 'first_ms'),
    'bytes until then': Math.round(median(list.map((one) => one.first_bytes))),
    requests: median(list.map((one) => one.first_requests)),
    'bytes in all': Math.round(median(list.map((one) => one.bytes))),
    'requests in all': median(list.map((one) => one.requests)),
  })),
);
const slow = [...measured]
  .filter(([{ at }, list]) => at !== '' && median(list.map((one) => one.fps)) < LEAST_FPS - 1)
  .map(([{ lab }]) => lab);
say(
  `goals: ${LEAST_FPS} frames/s${slow.length > 0 ? `, missed by ${slow.join(', ')}` : ''}; ` +
    `first frame ${FIRST_MS} ms; ${FIRST_BYTES} bytes for the first lab`,
);
writeCsv(
  'page',
  `bench/run page${process.argv
    .slice(2)
    .map((word) => ` ${word}`)
    .join('')}`,
  {
    lab: 'what is opened; questions: the first page',
    round: 'interleaved over the labs',
    fps: 'frames drawn a second, after the first seconds; empty where nothing is drawn',
    script_ms: 'median of the script of a drawing, with the slower processor',
    first_ms: 'from the navigation to the first frame, or to the cards of the first page',
    first_bytes: 'over the wire until then, heads included',
    first_requests: 'answered until then, without the WebSocket',
    bytes: 'over the wire until some seconds after the first frame',
    requests: 'answered until then',
  },
  rows.map((row) => ({ ...row, fps: row.fps?.toFixed(1), script_ms: row.script_ms?.toFixed(2), first_ms: row.first_ms.toFixed(0) })),
);
