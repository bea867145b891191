// WebKit by classic WebDriver (W3C): Debian's WebKitWebDriver steers a MiniBrowser of webkit2gtk, in a display in memory. A driver has one
// session, so each visitor has a driver of its own.
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, readdirSync, rmSync } from 'node:fs';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { setTimeout as wait } from 'node:timers/promises';

const START_MS = 120000; /* ends what hangs */
/** The driver has no command for a page's console: the page notes what comes after it has loaded. */
const LISTEN = `() => {
  const list = (globalThis.complaints = []);
  for (const name of ['error', 'warn']) {
    const own = console[name];
    console[name] = (...words) => { list.push(name + ': ' + words.join(' ')); own.apply(console, words); };
  }
  addEventListener('error', (event) => list.push('error: ' + (event.message ?? event.target?.outerHTML)), true);
  addEventListener('unhandledrejection', (event) => list.push('rejected: ' + event.reason));
}`;
const ELEMENT = 'element-6066-11e4-a52e-4f735466cecf'; /* W3C's name of a reference to an element */
/** As W3C has them. @type {Record<string, string>} */
const KEYS = { Enter: '\uE007', ArrowLeft: '\uE012', ArrowUp: '\uE013', ArrowRight: '\uE014', ArrowDown: '\uE015', Escape: '\uE00C' };

/** The newest MiniBrowser; empty without one. @returns {string} */
function miniBrowser() {
  const found = readdirSync('/usr/lib', { withFileTypes: true })
    .filter((entry) => entry.isDirectory())
    .flatMap(({ name }) => ['webkit2gtk-4.1', 'webkit2gtk-4.0'].map((one) => `/usr/lib/${name}/${one}/MiniBrowser`));
  return found.find((file) => existsSync(file)) ?? '';
}

/** What is not installed; empty where all is there. @returns {string} */
export function missing() {
  const absent = ['/usr/bin/WebKitWebDriver', '/usr/bin/Xvfb'].filter((file) => !existsSync(file));
  return [...absent, ...(miniBrowser() === '' ? ['MiniBrowser'] : [])].join(', ');
}

/** @returns {Promise<number>} a port that was free */
function freePort() {
  return new Promise((resolve, reject) => {
    const server = createServer();
    server.on('error', reject);
    server.listen(0, '127.0.0.1', () => {
      const { port } = /** @type {import('node:net').AddressInfo} */ (server.address());
      server.close(() => resolve(port));
    });
  });
}

/** @param {import('node:child_process').ChildProcess} child */
async function ended(child) {
  if (child.exitCode !== null || child.signalCode !== null) return;
  const gone = new Promise((resolve) => child.once('exit', resolve));
  child.kill('SIGTERM');
  const timer = setTimeout(() => child.kill('SIGKILL'), 4000);
  await gone;
  clearTimeout(timer);
}

/** A process that dies with this one. @param {string} command @param {string[]} args @param {any} more */
function begin(command, args, more) {
  const child = spawn(command, args, more);
  const die = () => child.kill('SIGKILL');
  process.once('exit', die);
  child.once('exit', () => process.off('exit', die));
  return child;
}

/** A display in memory; it names its own number. */
async function display() {
  const child = begin('Xvfb', ['-displayfd', '3', '-screen', '0', '1600x1000x24', '-nolisten', 'tcp'], {
    stdio: ['ignore', 'ignore', 'ignore', 'pipe'],
  });
  const number = await new Promise((resolve, reject) => {
    child.once('exit', () => reject(new Error('Xvfb ended')));
    /** @type {import('node:stream').Readable} */ (child.stdio[3]).once('data', (text) => resolve(String(text).trim()));
  });
  return { name: `:${number}`, close: () => ended(child) };
}

/** @returns {Promise<import('./browsers.mjs').Browser>} */
export async function launchWebKit() {
  const screen = await display();
  /** @type {Set<() => Promise<void>>} */
  const open = new Set();
  return {
    name: 'WebKit',
    visit: async (url, size) => {
      const visitor = await visit(screen.name, url, size);
      open.add(visitor.close);
      return visitor;
    },
    close: async () => {
      await Promise.all([...open].map((close) => close()));
      await screen.close();
    },
  };
}

/** @param {string} screen @param {string} url @param {{width: number, height: number}} size
 * @returns {Promise<import('./browsers.mjs').Visitor>} */
async function visit(screen, url, { width, height }) {
  const port = await freePort(),
    home = mkdtempSync(path.join(tmpdir(), 'laglab-webkit-'));
  const driver = begin('WebKitWebDriver', [`--port=${port}`], {
    stdio: 'ignore',
    env: {
      ...process.env,
      LANG: 'C' /* then a page's language is "C" */,
      DISPLAY: screen,
      HOME: home,
      XDG_RUNTIME_DIR: home,
      GDK_BACKEND: 'x11',
      LIBGL_ALWAYS_SOFTWARE: '1',
      WEBKIT_DISABLE_DMABUF_RENDERER: '1',
      NO_AT_BRIDGE: '1',
    },
  });
  /** @param {string} method @param {string} at @param {any} [body] @returns {Promise<any>} */
  const ask = async (method, at, body) => {
    const answer = await fetch(`http://127.0.0.1:${port}${at}`, {
      method,
      ...(method === 'POST' ? { body: JSON.stringify(body ?? {}) } : {}),
    });
    const { value } = await answer.json();
    if (!answer.ok) throw new Error(`${method} ${at}: ${value?.error} ${value?.message}`);
    return value;
  };
  const end = performance.now() + START_MS;
  while (
    !(await ask('GET', '/status').then(
      () => true,
      () => false,
    ))
  ) {
    if (performance.now() > end) throw new Error('WebKitWebDriver does not answer');
    await wait(50);
  }
  const { sessionId } = await ask('POST', '/session', {
    capabilities: {
      alwaysMatch: {
        'webkitgtk:browserOptions': {
          binary: miniBrowser(),
          args: ['--automation'],
        },
      },
    },
  });
  const at = `/session/${sessionId}`;
  await ask('POST', `${at}/window/rect`, { x: 0, y: 0, width, height });
  const evaluate = (/** @type {Function | string} */ what, /** @type {any} */ arg) =>
    ask('POST', `${at}/execute/sync`, { script: `return (${what})(arguments[0])`, args: [arg ?? null] });
  const press = (/** @type {string} */ key, /** @type {string[]} */ types) =>
    ask('POST', `${at}/actions`, {
      actions: [{ type: 'key', id: 'keyboard', actions: types.map((type) => ({ type, value: KEYS[key] ?? key })) }],
    });
  const listen = () => evaluate(LISTEN);
  await ask('POST', `${at}/url`, { url });
  await listen();
  let closed = false;
  return {
    complaints: async () => (await evaluate('() => globalThis.complaints')) ?? ['the page was loaded again'],
    listen,
    evaluate,
    click: async (find, arg) => {
      const element = await evaluate(find, arg);
      await ask('POST', `${at}/element/${element[ELEMENT]}/click`);
    },
    press: (key) => press(key, ['keyDown', 'keyUp']),
    down: (key) => press(key, ['keyDown']),
    up: (key) => press(key, ['keyUp']),
    screenshot: async () => Buffer.from(await ask('GET', `${at}/screenshot`), 'base64'),
    close: async () => {
      if (closed) return;
      closed = true;
      await ask('DELETE', at).catch(() => {}); /* it may have crashed: its driver ends all the same */
      await ended(driver);
      rmSync(home, { recursive: true, force: true });
    },
  };
}
