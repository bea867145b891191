// A public server, set up by the commands of docs/deploy.md and nothing else, behind nginx and behind HAProxy with TLS: what a visitor
// without a key, the class and the operator can do with it. It runs in namespaces of its own: /etc, /opt and /var are laid over, the
// network has nothing but itself. systemd does not run there: a stand-in for systemctl starts what the unit's lines say, as the unit's
// user.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { BINARY } from '../lib/daemon.mjs';

const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const NAME = 'lab.example.org';
const read = (/** @type {string} */ name) => readFileSync(path.join(ROOT, name), 'utf8');

/** The blocks of commands of a part of the page. */
function blocks(/** @type {string} */ heading) {
  const text = read('docs/deploy.md'),
    from = text.indexOf(`\n## ${heading}\n`);
  assert.ok(from >= 0, heading);
  const end = text.indexOf('\n## ', from + 5);
  return [...text.slice(from, end).matchAll(/^```console\n([\s\S]*?)^```$/gm)].map(([, commands]) => commands);
}

/** Keeps the machine as it is: what is written goes to memory, and is gone with the namespaces. */
const SEALED = `set -eu
mount --make-rprivate /
work=$PWD/over; mkdir -p $work; mount -t tmpfs none $work
for d in etc opt var; do
  mkdir -p $work/$d $work/$d.work
  mount -t overlay overlay -o lowerdir=/$d,upperdir=$work/$d,workdir=$work/$d.work /$d
done
mount -t tmpfs none /run
ip link set lo up
`;

const PRELUDE = `
export PATH=$PWD/bin:$PATH:/usr/sbin:/sbin
hostname lab 2>/dev/null || true
printf '127.0.0.1 localhost\\n127.0.0.1 ${NAME}\\n' > /etc/hosts
mkdir -p /etc/ssl/private /var/log/nginx /var/lib/nginx
openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=${NAME} -addext subjectAltName=DNS:${NAME} \
  -keyout /etc/ssl/private/${NAME}.key -out /etc/ssl/${NAME}.pem 2>/dev/null
export CURL_CA_BUNDLE=/etc/ssl/${NAME}.pem NODE_EXTRA_CA_CERTS=/etc/ssl/${NAME}.pem
`;

/* What the machine does not have, or must not do again. */
const STANDINS = {
  'apt-get': 'for p in "$@"; do case $p in nginx*) command -v nginx;; haproxy) command -v haproxy;; esac; done >/dev/null',
  systemctl: `unit=/etc/systemd/system/laglab.service
value() { sed -n "s/^$1=//p" $unit; }
case "$*" in
daemon-reload) ;;
"enable --now laglab")
  install -d -m "$(value StateDirectoryMode)" -o "$(value User)" -g "$(value Group)" "/var/lib/$(value StateDirectory)"
  umask "$(value UMask)"
  setpriv --reuid="$(value User)" --regid="$(value Group)" --init-groups --bounding-set=-all --inh-caps=-all --no-new-privs \
    prlimit --nofile="$(value LimitNOFILE)" $(value ExecStart) >/var/log/laglab.log 2>&1 & ;;
"restart nginx") nginx ;;
"restart haproxy") haproxy -D -f /etc/haproxy/haproxy.cfg ;;
*) echo "systemctl $*?" >&2; exit 1 ;;
esac`,
};

let folder,
  skip = /** @type {string | false} */ (false);
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'laglab-public-'));
  mkdirSync(path.join(folder, 'bin'));
  for (const [name, text] of Object.entries(STANDINS))
    writeFileSync(path.join(folder, 'bin', name), `#!/bin/bash\n${text}\n`, { mode: 0o755 });
  writeFileSync(path.join(folder, 'dev'), '#!/bin/sh\n[ "$1" = build ] # it was\n', { mode: 0o755 });
  symlinkSync(path.dirname(BINARY), path.join(folder, 'build'));
  for (const name of ['deploy', 'LICENSE']) symlinkSync(path.join(ROOT, name), path.join(folder, name));
  const probe = sealed('true');
  if (probe.status !== 0) skip = `no namespaces or overlays here: ${probe.stderr.trim().slice(0, 200)}`;
});
after(() => rmSync(folder, { recursive: true, force: true }));

function sealed(/** @type {string} */ script) {
  return spawnSync(
    'unshare',
    ['--mount', '--net', '--uts', '--pid', '--fork', '--kill-child', '--mount-proc', 'bash', '-c', SEALED + script],
    { cwd: folder, encoding: 'utf8', timeout: 120000, maxBuffer: 1 << 24 },
  );
}

const OTHER = { nginx: 'haproxy', haproxy: 'nginx' };

for (const proxy of /** @type {('nginx' | 'haproxy')[]} */ (['nginx', 'haproxy'])) {
  test(`as an operator sets it up behind ${proxy}`, { timeout: 130000 }, (t) => {
    if (skip) return t.skip(skip);
    const commands = blocks('A public server').filter((block) => !block.includes(`restart ${OTHER[proxy]}`));
    assert.equal(commands.length, 5, 'program, keys, service, proxy, trial');
    const trial = /** @type {string} */ (commands.pop());
    // Like a person: each line is a command of its own, and one that fails ends it.
    const result = sealed(`${PRELUDE}
{ ${commands.join('\n')} } >&2
mark() { printf '\\n@@%s\\n' "$1"; }
mark trial
${trial}
mark session
curl -s -H "$J" -H "Authorization: Bearer $(cat /etc/laglab/class.key)" -d '{"scenario":"race"}' $U/sessions > session.json
cat session.json
mark visitor
node ${path.join(ROOT, 'tests/lib/visitor.mjs')} https://${NAME} session.json
mark forged
for i in 1 2 3 4; do
  curl -s -o /dev/null -w '%{http_code} ' --interface 127.0.0.2 -H "X-Forwarded-For: 10.9.8.$i" \\
    -H "Authorization: Bearer wrong-key-$i-of-some-length" $U/sessions
done
mark limits
seq 300 | while read i; do
  code=$(curl -s -o /dev/null -w '%{http_code}' --interface 127.0.0.3 -H "X-Forwarded-For: 10.1.1.$i" \\
    -H 'Authorization: Bearer another-wrong-key-1' $U/sessions)
  echo $code
  [ $code != 429 ] || break
done
mark neighbour
curl -s -o /dev/null -w '%{http_code}' --interface 127.0.0.4 -H 'Authorization: Bearer another-wrong-key-1' $U/sessions
mark name
curl -s -o /dev/null -w '%{http_code}' -H 'Host: evil.example' https://${NAME}/api/v1/creation
mark operator
K="Authorization: Bearer $(cat /etc/laglab/operator.key)"
curl -s -o /dev/null -w '%{http_code} ' -H "$K" -H "$J" -X PUT -d '{"creation":"operator"}' $U/creation
curl -s -o /dev/null -w '%{http_code} ' -H "$J" -H "Authorization: Bearer $(cat /etc/laglab/class.key)" -d '{"scenario":"race"}' $U/sessions
curl -s -o /dev/null -w '%{http_code}' -H "$K" -X DELETE $U/sessions/$(sed 's/.*"id":"\\([^"]*\\)".*/\\1/' session.json)
mark modes
stat -c '%a %U %G %n' /var/lib/laglab /var/lib/laglab/laglab.db /etc/laglab/class.key /etc/laglab/operator.key
ps -o user= -C laglab
mark listening
ss -Hltn | awk '{print $4}' | sort -u | tr '\\n' ' '
mark log
cat /var/log/laglab.log
`);
    assert.equal(result.status, 0, `exit ${result.status}: ${result.stderr.slice(-2000)}\n${result.stdout.slice(-2000)}`);
    const parts = Object.fromEntries(
      result.stdout
        .split('\n@@')
        .slice(1)
        .map((part) => [part.slice(0, part.indexOf('\n')), part.slice(part.indexOf('\n') + 1)]),
    );

    const lines = parts.trial
      .replace(/\}(?=[\d{])/g, '}\n')
      .replace(/^(\d{3})(?=\{)/gm, '$1\n')
      .split('\n')
      .filter(Boolean);
    assert.deepEqual(JSON.parse(lines[0]), { creation: 'class' });
    assert.equal(lines[1], '401');
    const made = JSON.parse(lines[2]);
    assert.ok(made.id && made.owner_key, 'who has the class key makes a session');
    assert.equal(lines[3], '404');
    assert.deepEqual(
      JSON.parse(lines[4]).sessions.map((/** @type {any} */ one) => one.id),
      [made.id],
      'the operator lists it',
    );

    const session = JSON.parse(parts.session),
      visitor = JSON.parse(parts.visitor);
    assert.deepEqual(visitor, {
      page: 200,
      title: visitor.title,
      hsts: 'max-age=31536000',
      session: 200,
      'session/state': 200,
      'session/metrics': 200,
      'session/trace': 200,
      'session/log': 200,
      code: 200,
      by_code: 'the session',
      'stream bin: command': '403',
      'stream json: command': '403',
      create: 401,
      fork: 401,
      experiment: 401,
      'dry run': 401,
      advise: 401,
      control: 401,
      change: 401,
      input: 401,
      delete: 401,
      list: 401,
      'list of experiments': 401,
      'close creation': 401,
      figures: 404,
      'guessed id': 404,
      'without TLS': 301,
      redirected: `https://${NAME}/some?thing=1`,
    });
    assert.match(visitor.title, /laglab/i);
    assert.equal(parts.forged.trim(), '403 403 403 403');
    const wrong = parts.limits.trim().split('\n');
    assert.deepEqual(
      [wrong[0], wrong.at(-1), parts.neighbour.trim()],
      ['403', '429', '403'],
      'each client has limits of its own, which a forged header does not widen',
    );
    assert.equal(parts.name.trim(), '421');
    assert.equal(parts.operator.trim(), '200 403 204');
    assert.deepEqual(parts.modes.trim().split('\n'), [
      '700 laglab laglab /var/lib/laglab',
      '600 laglab laglab /var/lib/laglab/laglab.db',
      '640 root laglab /etc/laglab/class.key',
      '640 root laglab /etc/laglab/operator.key',
      'laglab',
    ]);
    assert.equal(parts.listening.trim(), '0.0.0.0:443 0.0.0.0:80 127.0.0.1:8080');
    assert.ok(!parts.log.includes(session.owner_key) && !parts.log.includes(made.owner_key), 'no key is in the log');
  });
}

test('the unit is one that systemd takes, and leaves the daemon little', (t) => {
  const verify = spawnSync('systemd-analyze', ['verify', '--man=no', path.join(ROOT, 'deploy/laglab.service')], { encoding: 'utf8' });
  if (verify.error) return t.skip('systemd-analyze is not installed');
  const said = verify.stderr
    .split('\n')
    .filter((line) => line.includes('laglab.service') && !line.includes('/opt/laglab/laglab is not executable'));
  assert.deepEqual(said, []);
  const security = spawnSync('systemd-analyze', ['security', '--offline=true', '--no-pager', path.join(ROOT, 'deploy/laglab.service')], {
    encoding: 'utf8',
  });
  const level = Number(/exposure level for laglab\.service: ([\d.]+)/.exec(security.stdout)?.[1]);
  assert.ok(level <= 1.5, `exposure ${level}: ${security.stderr}`);
});
