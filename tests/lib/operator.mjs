// The commands of a page, run as an operator would in namespaces that leave the machine as it is.
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { BINARY } from './daemon.mjs';
import { OWN_MOUNTS } from './mounts.mjs';

export const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');

/** The blocks of a page in their order, with the section (##) of each. @param {string} page */
export function blocksOf(page) {
  return readFileSync(path.join(ROOT, page), 'utf8')
    .split(/^## /m)
    .slice(1)
    .flatMap((section) => {
      const heading = section.slice(0, section.indexOf('\n'));
      const found = [...section.matchAll(/^```(\w+)\n([\s\S]*?)^```$/gm)];
      return found.length > 0 ? found.map(([, language, text]) => ({ heading, language, text })) : [{ heading, language: '', text: '' }];
    });
}

const NAMESPACES = ['unshare', '--mount', '--net', '--uts', '--pid', '--fork', '--kill-child', '--mount-proc'];
/**
 * Keeps the machine as it is: what is written goes to memory, and is gone with the namespaces.
 * Others may read what root writes, as on a new Debian.
 */
const SEALED = `set -eu
umask 022
mount --make-rprivate /
work=$PWD/over; mkdir -p "$work"; mount -t tmpfs none "$work"
for d in etc opt var; do
  mkdir -p "$work/$d" "$work/$d.work"
  mount -t overlay overlay -o "lowerdir=/$d,upperdir=$work/$d,workdir=$work/$d.work" /$d
done
mount -t tmpfs none /run
ip link set lo up
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
"restart laglab")
  kill $(pidof laglab); while pidof laglab >/dev/null; do sleep 0.05; done
  "$0" enable --now laglab ;;
"restart nginx") nginx ;;
"restart haproxy") haproxy -D -f /etc/haproxy/haproxy.cfg ;;
*) echo "systemctl $*?" >&2; exit 1 ;;
esac`,
};

/** A folder with what `./dev build` made, and where commands are run. */
export function workplace() {
  const folder = mkdtempSync(path.join(tmpdir(), 'laglab-operator-'));
  mkdirSync(path.join(folder, 'bin'));
  for (const [name, text] of Object.entries(STANDINS))
    writeFileSync(path.join(folder, 'bin', name), `#!/bin/bash\n${text}\n`, { mode: 0o755 });
  writeFileSync(path.join(folder, 'dev'), '#!/bin/sh\n[ "$1" = build ] # it was\n', { mode: 0o755 });
  symlinkSync(path.dirname(BINARY), path.join(folder, 'build'));
  for (const name of ['deploy', 'LICENSE']) symlinkSync(path.join(ROOT, name), path.join(folder, name));
  const sealed = (/** @type {string} */ script) =>
    spawnSync(OWN_MOUNTS[0], [...OWN_MOUNTS.slice(1), ...NAMESPACES, 'bash', '-c', SEALED + script], {
      cwd: folder,
      encoding: 'utf8',
      timeout: 600000,
      maxBuffer: 1 << 24,
    });
  const probe = sealed('touch /etc/hosts /var/lib/laglab-probe && ip addr add 10.0.0.1/32 dev lo && install -d -o daemon probe');
  return {
    sealed,
    /** Why nothing can be run here; false: it can. @type {string | false} */
    skip:
      probe.status !== 0 && `no namespaces, overlays or root's rights here: ${probe.error?.message ?? probe.stderr.trim().split('\n')[0]}`,
    end: () => rmSync(folder, { recursive: true, force: true }),
  };
}

/** What was printed, by the marks before it. @param {string} text */
export const marked = (text) =>
  Object.fromEntries(
    text
      .split('\n@@')
      .slice(1)
      .map((part) => [part.slice(0, part.indexOf('\n')), part.slice(part.indexOf('\n') + 1)]),
  );
export const MARK = `mark() { printf '\\n@@%s\\n' "$1"; }\n`;
