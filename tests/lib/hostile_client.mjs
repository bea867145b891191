// One hostile client, as a process of its own: node hostile_client.mjs URL NAME PLACE. It sends the heaviest requests of its kind, the next
// as soon as one is answered, until it is killed, and sends its parent a message when it begins, and the status of each answer. PLACE is
// JSON of what prepare() made.
import { client } from './client.mjs';

const [url, name, json] = process.argv.slice(2);
const place = JSON.parse(json),
  c = client(url),
  X = '/api/v1/experiments';
const S = (session, rest) => `/api/v1/sessions/${session.id}${rest}`;
const long = { timeout: 600000 };
const POOL = { kind: 'fluid', scene: 'pool', params: { size: 400 }, duration_s: 600 };
const METRICS = ['kinetic_energy', 'density_error_mean'];
let turn = 0;

/** @type {Record<string, () => Promise<any>>} */
const attacks = {
  seek: () =>
    c.call('POST', S(place.pool, '/control'), {
      key: place.pool.owner_key,
      body: { op: 'seek', time_s: turn++ % 2 ? 3600 : 1800 },
      ...long,
    }),
  look: () => c.get(S(place.slow, ''), long),
  dry_run: () => c.call('POST', `${X}?dry_run=true`, { body: { scenario: POOL, metrics: METRICS }, ...long }),
  advise: () =>
    c.call('POST', '/api/v1/advise', {
      body: {
        max_error: 1e-3,
        runs: 2000,
        experiment: {
          scenario: { ...POOL, duration_s: 60 },
          metrics: METRICS,
          axes: [{ path: 'params.size', from: 200, to: 400, count: 50 }],
          repeats: 50,
          error: METRICS[1],
          cost: METRICS[0],
        },
      },
      ...long,
    }),
  state_at: () => c.get(S(place.old, `/state?tick=${90000 - (turn++ % 7)}`), long),
  trace: () => c.get(S(place.old, '/trace?from_s=0&to_s=1500'), long),
  set_many: () =>
    c.call('POST', '/api/v1/sessions', {
      body: `{"scenario":"race","set":{${Array.from({ length: 50000 }, () => '"duration_s":9').join()}}}`,
      ...long,
    }),
  results: () => c.get(`${X}/${place.experiment.id}/results?format=${['csv', 'json', 'sqlite'][turn++ % 3]}`, long),
  report: () => c.get(`${X}/${place.experiment.id}/report`, long),
  fork: () => c.call('POST', S(place.old, '/fork'), { body: {}, ...long }),
  heavy_create: () => c.call('POST', '/api/v1/sessions', { body: { scenario: POOL }, ...long }),
  heavy_state: () => c.get(S(place.slow, '/state'), long),
};

process.on('disconnect', () => process.exit(1));
process.send?.('begun');
for (;;) {
  try {
    const answer = await attacks[name]();
    process.send?.(answer.status);
    if (answer.status === 429 || answer.status === 503) await new Promise((resolve) => setTimeout(resolve, 10));
  } catch {
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}
