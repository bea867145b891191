// Which metrics an experiment keeps, of whole runs and in its windows.
import { draft, write } from './draft.js';
import { bareOf } from './parts.js';

/** Other metrics; what named one that is gone names none. @param {string[]} next */
function keep(next) {
  const d = draft.value,
    left = (/** @type {string} */ one) => (next.includes(one) ? one : '');
  write({
    metrics: next,
    error: left(d.error),
    cost: left(d.cost),
    front: d.front.filter((one) => next.includes(one)),
    until: { ...d.until, metric: left(d.until.metric) },
  });
}

/** @param {string} path */
export function toggleMetric(path) {
  const { metrics: now } = draft.value;
  keep(now.includes(path) ? now.filter((one) => one !== path) : [...now, path]);
}

/** Another window, with these metrics in it. @param {import('./parts.js').Part} part @param {string[]} paths */
export function addPart(part, paths) {
  write({ parts: [...draft.value.parts, part], metrics: [...draft.value.metrics, ...paths.map((path) => `${path}@${part.name}`)] });
}

/** @param {number} index */
export function removePart(index) {
  const { parts, metrics: now } = draft.value;
  write({ parts: parts.filter((_, i) => i !== index) });
  keep(now.filter((one) => !one.endsWith(`@${parts[index]?.name}`)));
}

/** Its metrics follow its name. @param {number} index @param {Partial<import('./parts.js').Part>} change */
export function changePart(index, change) {
  const d = draft.value,
    before = d.parts[index]?.name,
    after = change.name ?? before;
  const moved = (/** @type {string} */ one) => (one.endsWith(`@${before}`) ? `${bareOf(one)}@${after}` : one);
  write({
    parts: d.parts.map((part, i) => (i === index ? { ...part, ...change } : part)),
    ...(after !== before
      ? {
          metrics: d.metrics.map(moved),
          error: moved(d.error),
          cost: moved(d.cost),
          front: d.front.map(moved),
          until: { ...d.until, metric: moved(d.until.metric) },
        }
      : {}),
  });
}
