// Each block of commands of docs/deploy.md and docs/scale.md is run as it stands, or has the nearest check that can be made here. A block
// or a section that nothing claims fails.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { existsSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { BINARY } from '../lib/daemon.mjs';
import { blocksOf, MARK, marked, ROOT, workplace } from '../lib/operator.mjs';

const CLASS_KEY = 'autumn-7b-lab'; // of the page

/** What stands around the commands: a page's line that serves goes on in the background, until it is ended. */
const PRELUDE = `
export PATH=$PWD/bin:$PATH:/usr/sbin:/sbin HOME=$PWD/over/home
ip addr add 192.168.7.9/32 dev lo
for i in 1 2 9; do ip addr add 10.0.0.$i/32 dev lo; done
J='Content-Type: application/json' H=http://127.0.0.1:8080 RACE='{"scenario":"race"}'
ready() { for i in $(seq 1200); do curl -sfo /dev/null "http://\${1:-127.0.0.1:8080}/readyz" && return; sleep 0.05; done
  cat err >&2; exit 1; }
code() { curl -s -o /dev/null -w '%{http_code} ' "$@"; }
field() { sed 's/.*"'$1'":"\\([^"]*\\)".*/\\1/'; }
end() { kill $(pidof laglab); while pidof laglab >/dev/null; do sleep 0.02; done; }
${MARK}`;

/** In the background, as a service runs. @param {string} block */
const serving = (block, at = '') =>
  `( ${block.trim().split('\n').at(-1)} ) >out 2>err & subshell=$!\n${block.includes('laglab serve') ? `ready ${at}` : ''}\n`;
const before_last = (/** @type {string} */ block) => block.trim().split('\n').slice(0, -1).join('\n');

/** @typedef {{run?: (block: string) => string, expected?: string | RegExp, check?: (block: string) => void, by?: string}} Claim */

/** The options after the image's name are those of the program. @param {string} block */
function container(block) {
  const lines = block
    .replace(/\\\n\s*/g, '')
    .trim()
    .split('\n');
  const served = lines.flatMap((line) => /^docker run .* laglab (serve .*)$/.exec(line)?.[1] ?? []);
  for (const options of served) {
    const { status, stderr } = spawnSync(BINARY, [...options.split(' '), '--help'], { encoding: 'utf8' });
    assert.equal(status, 0, stderr);
    const dockerfile = readFileSync(path.join(ROOT, 'Dockerfile'), 'utf8'),
      usual = JSON.parse(/^CMD (.*)$/m.exec(dockerfile)?.[1] ?? '[]').join(' ');
    assert.ok(options.startsWith(usual), `${options} repeats the default command of the image, ${usual}`);
  }
  for (const line of lines) if (line.startsWith('deploy/')) assert.equal(spawnSync('bash', ['-n', path.join(ROOT, line)]).status, 0, line);
}

/** By section, in the order of its blocks. `by`: the test that holds a section without commands.
 * @type {Record<string, Record<string, Claim[]>>} */
const CLAIMS = {
  'docs/deploy.md': {
    'On a machine': [
      {
        run: (block) => `${serving(block)}
head -1 out | sed 's/.*\\(listening on http:\\S*\\).*/\\1/'
build/laglab serve --listen 127.0.0.1:8081 --data /var/lib/laglab 2>second && exit 1
grep -c 'in use\\|another' second
stat -c '%a %n' /var/lib/laglab /var/lib/laglab/laglab.db
kill $(pidof laglab); wait $subshell && echo ended with 0
grep -v '^{.*}$' err | wc -l`,
        expected: 'listening on http://127.0.0.1:8080/\n1\n700 /var/lib/laglab\n600 /var/lib/laglab/laglab.db\nended with 0\n0',
      },
      {
        run: (block) => `${serving(block)}
code http://192.168.7.9:8080/ -H 'Accept: text/html'; code -H 'Host: localhost:8080' http://192.168.7.9:8080/healthz
code -H 'Host: lab.example.org' http://192.168.7.9:8080/healthz; end`,
        expected: '200 200 421',
      },
      {
        run: (block) => `${serving(block)}
code -H 'Host: lab.example.org' http://192.168.7.9:8080/healthz; code -H 'Host: evil.example' http://192.168.7.9:8080/healthz; end`,
        expected: '200 421',
      },
    ],
    'Access control': [
      {
        run: (block) => `umask 077
${before_last(block)}
${serving(block)}
stat -c %a /etc/laglab/class.key; tr '\\0' ' ' < /proc/$(pidof laglab)/cmdline | grep -c '${CLASS_KEY}' || true
code -H "$J" -d "$RACE" $H/api/v1/sessions
curl -s -H "$J" -H 'Authorization: Bearer ${CLASS_KEY}' -d "$RACE" $H/api/v1/sessions > made
curl -s -H "$J" -H 'Authorization: Bearer ${CLASS_KEY}' \\
  -d '{"scenario":"race","set":{"duration_s":0.1},"repeats":1,"metrics":["players.0.remote_error_m.mean"]}' \\
  $H/api/v1/experiments > experiment
code $H/api/v1/sessions/$(field id <made)`,
        expected: /^600\n0\n401 200$/,
      },
      {
        // The daemon of the block before; the ids are those of what was made there.
        run: (
          block,
        ) => `${block.replace('sessions/ID', 'sessions/$(field id <made)').replace('experiments/ID', 'experiments/$(field id <experiment)')}
code $H/api/v1/sessions/$(field id <made); code -H "$J" -H 'Authorization: Bearer ${CLASS_KEY}' -d "$RACE" $U/sessions; end`,
        expected: /^\{"sessions":\[\{"id":"[\s\S]*\{"experiments":\[\{[\s\S]*\{"creation":"operator"\}404 403$/,
      },
      {
        run: (block) => `cat > /etc/laglab/class.key <<'KEYS'
${block}KEYS
${serving('build/laglab serve --operator-key-file /etc/laglab/operator.key --class-key-file /etc/laglab/class.key')}
grep -o '"class keys".*' err | grep -o 'north, south'; grep -c 'Tulip-42-river' err || true
curl -s -H "$J" -H 'Authorization: Bearer Tulip-42-river' -d "$RACE" $H/api/v1/sessions > made
curl -s $H/metrics | grep '^laglab_class_key_sessions'`,
        expected: 'north, south\n0\nlaglab_class_key_sessions{name="north"} 1\nlaglab_class_key_sessions{name="south"} 0',
      },
      {
        run: (block) => `${block.trim()} | grep -o '"name":"[a-z]*","used":{"classes":0,"sessions":.'; end`,
        expected: /"north","used":\{"classes":0,"sessions":1\n.*"south".*:0/,
      },
    ],
    'In a course page': [
      {
        run: (block) => `${serving(block)}
policy() { curl -s -o /dev/null -D - "http://127.0.0.1:8080/$1" | grep -io 'frame-ancestors [^;]*' | tr -d '\\r'; }
policy '?scenario=race&embed=1'; policy '?embed=1'; policy ''; end`,
        expected: "frame-ancestors https://course.example\nframe-ancestors https://course.example\nframe-ancestors 'none'",
      },
      {
        check: (block) =>
          assert.match(block, /^<iframe title="[^"]+" .*src="https:\/\/lab\.example\.org\/\?scenario=race&embed=1"><\/iframe>$/m),
      },
    ],
    // No container runs in this test: tests/container runs these lines (./dev container-test).
    Container: [{ check: container }, { check: container }, { check: container }],
    'Behind a proxy': [
      {
        run: (block) => `${serving(block)}
C=http://127.0.0.1:8080/api/v1
join() { curl -s -X POST -H Host:lab.example.org -H X-Forwarded-Proto:https "$@" $C/classes | grep -o '"urls":\\["[^"]*/'; }
join; join -H X-Forwarded-Host:evil.example; join --interface 192.168.7.9
for i in $(seq 70); do code -H "X-Forwarded-For: 192.0.2.1" -H "Authorization: Bearer nobodys" $C/sessions; done | grep -o '429 $'
code -H "X-Forwarded-For: 192.0.2.1, 192.0.2.2" $C/codes/2222; end`,
        expected: '"urls":["https://lab.example.org/\n"urls":["https://lab.example.org/\n"urls":["http://lab.example.org/\n429 \n404',
      },
    ],
    // Run as a whole, with nginx and with HAProxy. A certificate of an authority is one of openssl's there, systemd is a stand-in that
    // reads the unit (systemd-analyze checks it), packages are those that the machine has.
    'A public server': Array(6).fill({ by: 'tests/daemon/public.test.mjs' }),
    // Kubernetes and Compose do not run here: their files are compared with Kubernetes' types and with each other.
    'Several machines': [{ by: 'tests/daemon/deploy.test.mjs' }],
    'Health and metrics': [
      {
        run: (block) => `${serving('build/laglab serve --listen 127.0.0.1:8080 --data memory')}
${block}
echo healthy; code $H/healthz; code -H 'X-Forwarded-For: 192.0.2.1' $H/metrics
code -H 'Forwarded: for=192.0.2.1' $H/metrics
end; build/laglab healthcheck http://127.0.0.1:8080/ 2>/dev/null || echo $?`,
        expected: /^\{[\s\S]*\}\s*laglab_sessions 0\nhealthy\n200 404 404 1$/,
      },
    ],
    'Long requests': [{ by: 'tests/daemon/hostile.test.mjs' }],
    'Data and backup': [
      {
        run: (block) => `mkdir -p /backup
${serving('build/laglab serve --listen 127.0.0.1:8080 --data /var/lib/laglab')}
curl -s -H "$J" -d "$RACE" $H/api/v1/sessions > made
${block}
curl -s $H/api/v1/sessions/$(field id <made)/log > log; build/laglab replay log >/dev/null && echo replayed
curl -s -X DELETE -H "Authorization: Bearer $(field owner_key <made)" $H/api/v1/sessions/$(field id <made); end
rm -f /var/lib/laglab/laglab.db-wal /var/lib/laglab/laglab.db-shm; cp /backup/laglab.db /var/lib/laglab/laglab.db
${serving('build/laglab serve --listen 127.0.0.1:8080 --data /var/lib/laglab')}
code $H/api/v1/sessions/$(field id <made); end`,
        expected: 'replayed\n200',
      },
    ],
    'Important limits': [{ by: 'tests/daemon/quotas.test.mjs' }],
    Options: [{ by: 'tests/api/cli.test.mjs' }],
  },
  'docs/scale.md': {
    'One daemon': [{ by: 'bench/capacity.mjs' }],
    Shards: [
      {
        // Each of the first lines is a machine, and has a folder of its own.
        run(block) {
          const [s0, s1, check] = block.trim().split('\n');
          // A process here may have few descriptors, and the shards have the port of the proxy.
          return `for i in 0 1 2; do echo "10.0.0.$((i + 1)) laglab-$i.laglab" >> /etc/hosts; done
${serving(s0, '10.0.0.1:8080')}
${serving(s1.replace('/var/lib/laglab', '/var/lib/laglab1'), '10.0.0.2:8080')}
${check} >/dev/null && echo valid
sed 's/maxconn 20000/maxconn 4096/; s/bind :8080/bind 10.0.0.9:8080/' deploy/shards/haproxy.cfg > shards.cfg
haproxy -D -f shards.cfg
for i in 1 2 3 4; do
  curl -s -H "$J" -H Host:lab.example.org -d "$RACE" http://10.0.0.9:8080/api/v1/sessions | field id | cut -c1-3
done | sort -u
kill $(pidof haproxy); end`;
        },
        expected: 'valid\ns0-\ns1-',
      },
    ],
    Experiments: [{ by: 'tests/api/cli.test.mjs' }],
  },
};

/** @type {ReturnType<typeof workplace>} */ let place;
before(() => {
  place = workplace();
});
after(() => place.end());

for (const [page, sections] of Object.entries(CLAIMS)) {
  const blocks = blocksOf(page);

  test(`each section and block of ${page} is claimed`, () => {
    const counts = /** @type {Record<string, number>} */ ({});
    for (const { heading } of blocks) counts[heading] = (counts[heading] ?? 0) + 1;
    assert.deepEqual(counts, Object.fromEntries(Object.entries(sections).map(([heading, claims]) => [heading, claims.length])));
    for (const { by } of Object.values(sections).flat()) if (by) assert.ok(existsSync(path.join(ROOT, by)), by);
  });

  for (const [heading, claims] of Object.entries(sections)) {
    const own = blocks.filter((block) => block.heading === heading).map(({ text }) => text);
    claims.forEach(({ check }, i) => {
      if (check) test(`${page}, ${heading}: block ${i + 1}`, () => check(own[i] ?? ''));
    });
    if (claims.some(({ run }) => run))
      test(`${page}, ${heading}: run`, { timeout: 600000 }, (t) => {
        if (place.skip) return t.skip(place.skip);
        const script = claims.map(({ run }, i) => (run ? `mark ${i}\n${run(own[i] ?? '')}\n` : '')).join('');
        const result = place.sealed(`${PRELUDE}${script}`);
        assert.equal(result.status, 0, `exit ${result.status}: ${result.stderr.slice(-2000)}\n${result.stdout.slice(-2000)}`);
        const said = marked(result.stdout);
        claims.forEach(({ run, expected = '' }, i) => {
          if (!run) return;
          if (typeof expected === 'string') assert.equal(said[i].trim(), expected.trim(), `block ${i + 1}`);
          else assert.match(said[i].trim(), expected, `block ${i + 1}`);
        });
      });
  }
}
