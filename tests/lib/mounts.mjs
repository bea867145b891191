// Commands with mounts of their own, which the machine does not see: in front of a command as startDaemon's `before`. Root needs no more
// than unshare; others need user namespaces. In a chroot, whose root is no mount and so cannot be made private, all that is there is
// mounted once more, below a mount that can.
import { spawnSync } from 'node:child_process';

const PRIVATE = `mount --make-rprivate / 2>/dev/null && exec "$@"
set -e
mount --make-private /proc
mount -t tmpfs none /proc
mkdir /proc/root
mount --rbind / /proc/root
mount --make-rprivate /proc/root
mount -t proc proc /proc/root/proc
exec chroot /proc/root sh -c 'cd "$0" && exec "$@"' "$PWD" "$@"`;

export const OWN_MOUNTS = [
  ...['unshare', ...(process.getuid?.() === 0 ? [] : ['--user', '--map-root-user']), '--mount', '--propagation', 'unchanged'],
  ...['sh', '-c', PRIVATE, 'sh'],
];

/** @type {string | false | undefined} */ let reason;
/** Why there can be none here; false: there can. */
export function noMounts() {
  if (reason !== undefined) return reason;
  const [command, ...words] = [...OWN_MOUNTS, 'mount', '-t', 'tmpfs', 'none', '/tmp'];
  const { status, error, stderr } = spawnSync(command, words, { encoding: 'utf8' });
  reason = status !== 0 && `no mounts of its own here: ${error?.message ?? stderr.trim().split('\n')[0]}`;
  return reason;
}
