// A public server, set up by the commands of docs/deploy.md and nothing else, behind nginx and behind HAProxy with TLS: what a visitor
// without a key, the class and the operator can do with it. It runs in namespaces of its own: /etc, /opt and /var are laid over, the
// network has nothing but itself. systemd does not run there: a stand-in for systemctl starts what the unit's lines say, as the unit's
// user.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { blocksOf, MARK, marked, ROOT, workplace } from '../lib/operator.mjs';

const NAME = 'lab.example.org';

const PRELUDE = `
export PATH=$PWD/bin:$PATH:/usr/sbin:/sbin
hostname lab 2>/dev/null || true
printf '127.0.0.1 localhost\\n127.0.0.1 ${NAME}\\n' > /etc/hosts
mkdir -p /etc/ssl/private /var/log/nginx /var/lib/nginx
openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=${NAME} -addext subjectAltName=DNS:${NAME} \
  -keyout /etc/ssl/private/${NAME}.key -out /etc/ssl/${NAME}.pem 2>/dev/null
export CURL_CA_BUNDLE=/etc/ssl/${NAME}.pem NODE_EXTRA_CA_CERTS=/etc/ssl/${NAME}.pem
`;

/** @type {ReturnType<typeof workplace>} */ let place;
before(() => {
  place = workplace();
});
after(() => place.end());

const OTHER = { nginx: 'haproxy', haproxy: 'nginx' };

for (const proxy of /** @type {('nginx' | 'haproxy')[]} */ (['nginx', 'haproxy'])) {
  test(`as an operator sets it up behind ${proxy}`, { timeout: 600000 }, (t) => {
    if (place.skip) return t.skip(place.skip);
    const commands = blocksOf('docs/deploy.md')
      .filter(({ heading, text }) => heading === 'A public server' && !text.includes(`restart ${OTHER[proxy]}`))
      .map(({ text }) => text);
    assert.equal(commands.length, 5, 'program, keys, service, proxy, trial');
    const trial = /** @type {string} */ (commands.pop());
    // Like a person: each line is a command of its own, and one that fails ends it.
    const result = place.sealed(`${PRELUDE}${MARK}
{ ${commands.join('\n')} } >&2
mark trial
${trial}
mark session
curl -s -H "$J" -H "Authorization: Bearer $(cat /etc/laglab/class.key)" -d '{"scenario":"race"}' $U/sessions > session.json
cat session.json
mark visitor
node '${path.join(ROOT, 'tests/lib/visitor.mjs')}' https://${NAME} session.json
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
mark inside
for at in /metrics /%6detrics /metric%73? //metrics; do curl -s -o /dev/null -w '%{http_code} ' --path-as-is https://${NAME}$at; done
curl -s -o /dev/null -w '%{http_code}' http://127.0.0.1:8080/metrics
mark link
curl -s -X POST -H "Authorization: Bearer $(cat /etc/laglab/class.key)" \\
  -H 'X-Forwarded-Host: evil.example' -H 'X-Forwarded-Proto: http' $U/classes
KEPT=$(curl -s -H "$J" -H "Authorization: Bearer $(cat /etc/laglab/class.key)" -d '{"scenario":"race"}' $U/sessions)
FIRST=$(cat /etc/laglab/class.key)
mark operator
K="Authorization: Bearer $(cat /etc/laglab/operator.key)"
curl -s -o /dev/null -w '%{http_code} ' -H "$K" -H "$J" -X PUT -d '{"creation":"operator"}' $U/creation
curl -s -o /dev/null -w '%{http_code} ' -H "$J" -H "Authorization: Bearer $(cat /etc/laglab/class.key)" -d '{"scenario":"race"}' $U/sessions
curl -s -o /dev/null -w '%{http_code}' -H "$K" -X DELETE $U/sessions/$(sed 's/.*"id":"\\([^"]*\\)".*/\\1/' session.json)
mark again
( ${commands[0].split('\n').find((line) => line.startsWith('cp '))} ) # while it runs
echo another-class-key > /etc/laglab/class.key
systemctl restart laglab
curl -s --retry 10 --retry-connrefused http://127.0.0.1:8080/readyz >/dev/null
curl -s -o /dev/null -w '%{http_code} ' $U/sessions/$(printf '%s' "$KEPT" | sed 's/.*"id":"\\([^"]*\\)".*/\\1/')
for key in another-class-key "$FIRST"; do
  curl -s -o /dev/null -w '%{http_code} ' -H "$J" -H "Authorization: Bearer $key" -d '{"scenario":"race"}' $U/sessions
done
mark modes
stat -c '%a %U %G %n' /var/lib/laglab /var/lib/laglab/laglab.db /etc/laglab/class.key /etc/laglab/operator.key
ps -o user= -C laglab
mark listening
ss -Hltn | awk '{print $4}' | sort -u | tr '\\n' ' '
mark log
cat /var/log/laglab.log
`);
    assert.equal(result.status, 0, `exit ${result.status}: ${result.stderr.slice(-2000)}\n${result.stdout.slice(-2000)}`);
    const parts = marked(result.stdout);

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
    assert.equal(parts.inside.trim(), '404 404 404 404 200');
    const room = JSON.parse(parts.link);
    assert.deepEqual(room.join.urls, [`https://${NAME}/${room.code}`]);
    assert.equal(parts.operator.trim(), '200 403 204');
    assert.equal(parts.again.trim(), '200 201 403', 'the session goes on, the key is another one');
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
