// What comes through the proxies of deploy/: no spelling of a path reaches the daemon's own figures, and the links of a class have the
// public scheme and host, and none that a client names.
import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';
import net from 'node:net';
import { client, raw } from '../lib/client.mjs';
import { startDaemon } from '../lib/daemon.mjs';
import { NAME, startPublic } from '../lib/public.mjs';
import { startShards } from '../lib/shards.mjs';

const FIGURES = /laglab_(sessions|build_info|class_key)/;
const OPERATOR = 'Sixteen-letters-or-more';
process.env.LAGLAB_OPERATOR_KEY = OPERATOR;

const hex = (/** @type {string} */ letter) => `%${letter.charCodeAt(0).toString(16)}`;
/** Each letter by itself, by its number, or by that of its number. */
function spelling(/** @type {number} */ seed) {
  let state = seed;
  return [...'/metrics']
    .map((letter, i) => {
      state = (Math.imul(state, 1103515245) + 12345) >>> 0;
      const how = (state >>> 16) % (i === 0 ? 1 : 7),
        code = hex(letter);
      return how < 3 ? letter : how < 5 ? code : how < 6 ? code.toUpperCase() : `%25${code.slice(1)}`;
    })
    .join('');
}

const SPELLINGS = [
  ...[
    '/metrics',
    '/metrics?',
    '/metrics?x=1',
    '/metrics;',
    '/metrics;x=1',
    '/metrics/',
    '/metrics/.',
    '/metrics#',
    '/metrics%23',
    '/metrics%3f',
  ],
  ...['//metrics', '///metrics', '/./metrics', '/x/../metrics', '/api/../metrics', '/%2e/metrics', '/x/%2e%2e/metrics', '/x/..%2fmetrics'],
  ...[
    '/%2fmetrics',
    '%2fmetrics',
    '/METRICS',
    '/Metrics',
    '/metrics%00',
    '/metrics%20',
    '/metrics+',
    '/metrics%',
    '/metrics%6',
    '/%zzmetrics',
  ],
  ...[
    '/%6detrics',
    '/metric%73',
    '/%6d%65%74%72%69%63%73',
    '/%6D%65trics?',
    '/%6detrics#x',
    '/%6detrics?x',
    '/%256detrics',
    '/%25%36%64etrics',
  ],
  ...[
    '/..%2fmetrics',
    '/\\metrics',
    '/%5cmetrics',
    '/metrics\\',
    '/.//metrics',
    '/metrics%0d%0a',
    '/m%e2%80%8betrics',
    '/%u006detrics',
    '/%c1%adetrics',
  ],
  ...['http', 'https', 'HTTP'].flatMap((scheme) =>
    ['/metrics', '/%6detrics', '//metrics', '/metrics?'].map((at) => `${scheme}://${NAME}${at}`),
  ),
  ...Array.from({ length: 60 }, (_, i) => spelling(i)),
];

/** @typedef {{connect: () => net.Socket, close: () => Promise<void>, figures: () => Promise<string>}} Site */
const alone = (/** @type {string} */ kind, /** @type {(text: string) => string} */ change) => async () => {
  const site = await startPublic(kind, { change });
  return { ...site, figures: async () => (await raw(site.daemon.port, 'GET /metrics HTTP/1.0\r\n\r\n')).text };
};
const shards = (/** @type {string} */ kind) => async () => {
  const site = await startShards(['a', 's0'], { proxy: kind, args: ['--allow-host', NAME] });
  const port = Number(new URL(site.url).port);
  const figures = async () => (await raw(site.shards.a.port, 'GET /metrics HTTP/1.0\r\n\r\n')).text;
  return { connect: () => net.connect(port, '127.0.0.1'), close: site.close, figures };
};
const as_it_is = (/** @type {string} */ text) => text;
/** @type {Record<string, () => Promise<Site>>} */
const SITES = {
  haproxy: alone('haproxy', as_it_is),
  nginx: alone('nginx', as_it_is),
  // The daemon itself refuses, where a proxy's file forgets to.
  'haproxy that denies nothing': alone('haproxy', (text) => text.replace(/^.*\/metrics.*$/m, '')),
  'nginx that denies nothing': alone('nginx', (text) => text.replace(/location = \/metrics \{[^}]*\}/, '')),
  'haproxy before shards': shards('haproxy'),
  'nginx before shards': shards('nginx'),
};

for (const [name, start] of Object.entries(SITES))
  describe(name, () => {
    /** @type {Site} */ let site;
    before(async () => {
      site = await start();
    });
    after(() => site?.close());

    const ask = async (/** @type {string} */ target, /** @type {string[]} */ ...headers) => {
      const head = [`GET ${target} HTTP/1.1`, `Host: ${NAME}`, 'Connection: close', ...headers];
      return (await raw(site.connect(), `${head.join('\r\n')}\r\n\r\n`)).text;
    };

    test('no spelling of /metrics is answered with figures, and the plain one is a 404', async () => {
      assert.match(await site.figures(), FIGURES);
      const answers = await Promise.all(SPELLINGS.map((target) => ask(target)));
      const key = `Authorization: Bearer ${OPERATOR}`;
      const found = (await Promise.all(SPELLINGS.map((target) => ask(target, key)))).filter((answer) => FIGURES.test(answer)).length;
      if (name.includes('denies nothing')) assert.ok(found > 10, `the operator gets the figures by ${found} spellings`);
      else assert.equal(found, 0, 'the file refuses each, which with this key the daemon would answer');
      SPELLINGS.forEach((target, i) => {
        assert.doesNotMatch(answers[i], FIGURES, target);
        assert.match(answers[i], /^HTTP\/1\.1 (30[12]|4\d\d) /, `${target}: ${answers[i].slice(0, 300)}`);
      });
      assert.match(answers[SPELLINGS.indexOf('/%6detrics')], /^HTTP\/1\.1 404 /);
      for (const wrong of [
        'X-Forwarded-For:',
        'Forwarded: for=127.0.0.1',
        'Connection: X-Forwarded-For',
        `Authorization: Bearer ${NAME}-wrong`,
      ])
        assert.doesNotMatch(await ask('/%6detrics', wrong), FIGURES, wrong);
    });

    test('links of a class have the public scheme and host, and none that a client names', async () => {
      const scheme = name.endsWith('shards') ? 'http' : 'https'; // where the proxy's file has TLS
      const forged = [
        'X-Forwarded-Host: evil.example',
        'X-Forwarded-Host: 203.0.113.9',
        'X-Forwarded-Proto: ftp',
        'x-forwarded-proto: gopher',
      ];
      forged.push(
        scheme === 'http' ? 'X-Forwarded-Proto: https' : 'X-Forwarded-Proto: http',
        'X-Forwarded-Port: 81',
        'X-Forwarded-Prefix: /evil',
      );
      forged.push(
        'Forwarded: for=203.0.113.9;host=evil.example;proto=https',
        'X_Forwarded_Host: evil.example',
        'X-Original-Host: evil.example',
      );
      for (const headers of [[], ...forged.map((one) => [one]), forged]) {
        const head = ['POST /api/v1/classes HTTP/1.1', `Host: ${NAME}`, 'Connection: close', 'Content-Length: 0', ...headers];
        const { text } = await raw(site.connect(), `${head.join('\r\n')}\r\n\r\n`);
        assert.match(text, /^HTTP\/1\.1 201 /);
        const { code, join } = JSON.parse(text.slice(text.indexOf('{'), text.lastIndexOf('}') + 1));
        assert.deepEqual(join, { urls: [`${scheme}://${NAME}/${code}`], local: false }, headers.join(', '));
      }
    });
  });

test('behind a proxy that passes all on, a host that may not be asked for gets into no link', async (t) => {
  const daemon = await startDaemon({ args: ['--trusted-proxy', '127.0.0.1', '--allow-host', `${NAME},other.example.org`] });
  t.after(() => daemon.stop());
  const c = client(daemon.url);
  t.after(() => c.close());
  const url = async (/** @type {Record<string, string>} */ headers) => {
    const { code, join } = (await c.call('POST', '/api/v1/classes', { headers: { host: NAME, ...headers } })).json;
    return join.urls.map((/** @type {string} */ at) => at.replace(`/${code}`, ''));
  };
  for (const host of [
    'evil.example',
    `${NAME}.evil.example`,
    `evil.example, ${NAME}`,
    `${NAME}@evil.example`,
    `${NAME}:80@evil.example`,
    '',
    'a"b',
  ])
    assert.deepEqual(await url({ 'x-forwarded-host': host, 'x-forwarded-proto': 'https' }), [`https://${NAME}`], host);
  assert.deepEqual(await url({ 'x-forwarded-host': 'Other.example.org:8443' }), ['http://Other.example.org:8443']);
  assert.deepEqual(await url({ 'x-forwarded-proto': 'javascript' }), [`http://${NAME}`]);
});

test('the operator gets the figures through a proxy, others are refused', async (t) => {
  const daemon = await startDaemon({ args: ['--trusted-proxy', '127.0.0.1', '--max-code-lookups-per-min', '3'] });
  t.after(() => daemon.stop());
  const c = client(daemon.url);
  t.after(() => c.close());
  const from = (/** @type {Record<string, string>} */ headers, /** @type {string} */ key) =>
    c.get('/metrics', { headers, ...(key && { key }) });
  assert.match((await from({}, '')).text, FIGURES, 'who reaches the daemon itself needs no key');
  for (const headers of /** @type {Record<string, string>[]} */ ([{ 'x-forwarded-for': '192.0.2.1' }, { forwarded: 'for=192.0.2.1' }])) {
    const refused = await from(headers, '');
    assert.deepEqual([refused.status, refused.json.status], [404, 404]);
    assert.match((await from(headers, OPERATOR)).text, FIGURES);
  }
  const tries = [];
  for (let i = 0; i < 6; i++) tries.push((await from({ 'x-forwarded-for': '192.0.2.2' }, `${OPERATOR}-${i}`)).status);
  assert.deepEqual([tries[0], tries.at(-1)], [403, 429], 'keys cannot be tried without limit');
});
