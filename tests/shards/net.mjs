// Machines of a cluster as network namespaces that a bridge joins: each has an address of its own, and its cable can be pulled.
import { execFileSync, spawnSync } from 'node:child_process';

const env = { ...process.env, PATH: `${process.env.PATH}:/usr/sbin:/sbin` }; // where Debian keeps ip and nsenter's friends
const run = (/** @type {string[]} */ [command, ...words]) => execFileSync(command, words, { stdio: ['ignore', 'pipe', 'pipe'], env });

/** Why there can be no namespaces here; empty where there can. */
export function noNamespaces() {
  if (process.getuid?.() !== 0) return 'network namespaces need root';
  const name = `llc${process.pid}try`,
    made = spawnSync('ip', ['netns', 'add', name], { encoding: 'utf8', env });
  if (made.error) return 'ip is not installed (Debian: iproute2)';
  if (made.status !== 0) return `no network namespaces here: ${made.stderr.trim()}`;
  const bridge = spawnSync('nsenter', [`--net=/run/netns/${name}`, 'ip', 'link', 'add', 'bridge0', 'type', 'bridge'], {
    encoding: 'utf8',
    env,
  });
  spawnSync('ip', ['netns', 'del', name], { env });
  return bridge.status === 0 ? '' : `no bridges here: ${bridge.stderr?.trim()}`;
}

/**
 * Needs root. Nothing but these machines can reach them: the bridge has a namespace of its own, too.
 * @param {string[]} names at most 7 letters each, the first has the address .1
 */
export function openNet(names) {
  const base = `llc${process.pid}`,
    wire = `${base}-wire`,
    made = /** @type {string[]} */ ([]);
  /* Not by `ip -n` and `ip netns exec`: these remount `/`, which in a chroot is not a mount point. */
  const inside = (/** @type {string} */ space) => ['nsenter', `--net=/run/netns/${space}`];
  const space = (/** @type {string} */ name) => `${base}-${name}`;
  const close = () => {
    for (const each of made.splice(0)) {
      try {
        run(['ip', 'netns', 'del', each]);
      } catch {
        /* it was never whole */
      }
    }
  };
  const add = (/** @type {string} */ each) => {
    made.push(each);
    run(['ip', 'netns', 'add', each]);
    run([...inside(each), 'ip', 'link', 'set', 'lo', 'up']);
  };
  try {
    add(wire);
    run([...inside(wire), 'ip', 'link', 'add', 'bridge', 'type', 'bridge']);
    run([...inside(wire), 'ip', 'link', 'set', 'bridge', 'up']);
    names.forEach((name, i) => {
      add(space(name));
      run([...inside(wire), 'ip', 'link', 'add', name, 'type', 'veth', 'peer', 'name', 'eth0', 'netns', space(name)]);
      run([...inside(wire), 'ip', 'link', 'set', name, 'master', 'bridge', 'up']);
      run([...inside(space(name)), 'ip', 'addr', 'add', `10.77.0.${i + 1}/24`, 'dev', 'eth0']);
      run([...inside(space(name)), 'ip', 'link', 'set', 'eth0', 'up']);
    });
  } catch (error) {
    close();
    throw error;
  }
  const cable = (/** @type {string} */ name, /** @type {string} */ state) => run([...inside(wire), 'ip', 'link', 'set', name, state]);
  return {
    close,
    address: (/** @type {string} */ name) => `10.77.0.${names.indexOf(name) + 1}`,
    /** What a command begins with that runs on the machine. */
    before: (/** @type {string} */ name) => inside(space(name)),
    cut: (/** @type {string} */ name) => cable(name, 'down'),
    heal: (/** @type {string} */ name) => cable(name, 'up'),
  };
}
