// A network of the test's own: a daemon in a namespace, with an address that is no loopback address, and all bytes that pass counted.
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';

const run = (/** @type {string[]} */ [command, ...words]) => execFileSync(command, words, { stdio: ['ignore', 'pipe', 'pipe'] });
const ip = (/** @type {string[]} */ ...words) => run(['ip', ...words]);

/** Needs root. `listen` and `before` are for startDaemon; `net` is the first three numbers of the addresses; `bytes` are those of both
 * directions so far, headers included. */
export function openLan() {
  const name = `laglab-${process.pid}`,
    outer = `ll${process.pid}a`.slice(0, 15),
    inner = `ll${process.pid}b`.slice(0, 15),
    net = `10.${200 + (process.pid % 50)}.${(process.pid >> 6) % 250}`;
  /* Not by `ip -n` and `ip netns exec`: these remount `/`, which in a chroot is not a mount point. */
  const before = ['nsenter', `--net=/run/netns/${name}`];
  const ip_inside = (/** @type {string[]} */ ...words) => run([...before, 'ip', ...words]);
  const close = () => {
    try {
      ip('netns', 'del', name); /* takes the pair with it */
    } catch {
      /* it was never made */
    }
  };
  try {
    ip('netns', 'add', name);
    ip('link', 'add', outer, 'type', 'veth', 'peer', 'name', inner, 'netns', name);
    ip('addr', 'add', `${net}.1/24`, 'dev', outer);
    ip('link', 'set', outer, 'addrgenmode', 'none'); /* an address that comes later would announce another network to the browser */
    ip('link', 'set', outer, 'up');
    ip_inside('addr', 'add', `${net}.2/24`, 'dev', inner);
    ip_inside('link', 'set', inner, 'addrgenmode', 'none');
    ip_inside('link', 'set', inner, 'up');
    ip_inside('link', 'set', 'lo', 'up');
  } catch (error) {
    close();
    throw error;
  }
  const count = (/** @type {string} */ what) => Number(readFileSync(`/sys/class/net/${outer}/statistics/${what}_bytes`, 'utf8'));
  return { net, listen: `${net}.2:0`, before, close, bytes: () => count('rx') + count('tx') };
}
