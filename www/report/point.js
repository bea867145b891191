// One point: all that is known of it, and where it opens live.
/** A value of the scenario in an address or a command. */
const plain = (value) => (typeof value === 'object' ? JSON.stringify(value) : String(value));

function wholeSettings(i) {
  const varied = settings(i).map(([path, , value]) => [path, value]),
    paths = new Set(varied.map(([path]) => path));
  return [...Object.entries(head.set).filter(([path]) => !paths.has(path)), ...varied];
}

const servedBy = () => /^https?:$/.test(location.protocol);

function liveAddress(i) {
  const site = state.site || (servedBy() ? `${location.origin}/` : 'http://127.0.0.1:8080/');
  return `${site}?scenario=${head.scenario}${wholeSettings(i)
    .map(([path, value]) => `&set=${encodeURIComponent(path)}:${encodeURIComponent(plain(value))}`)
    .join('')}&seed=${head.seed}`;
}

function command(i) {
  const sets = wholeSettings(i).map(([path, value]) => ` --set '${path}=${plain(value).replaceAll("'", "'\\''")}'`);
  return `laglab run ${head.scenario || 'scenario.json'} --seed ${head.seed}${sets.join('')}`;
}

function detail(i) {
  const box = make('section', { class: 'detail', id: 'detail', 'aria-label': 'Chosen point' }),
    known = DETAILED.filter(([name]) => metrics.some((_, m) => column(m, name))),
    acts = make('div', { class: 'acts' });
  if (head.scenario)
    acts.append(
      make('a', { href: liveAddress(i), target: '_blank', rel: 'noopener', id: 'live' }, 'Open live'),
      servedBy()
        ? ''
        : field('of the laglab at', 'site', 'text', state.site || 'http://127.0.0.1:8080/', (site) =>
            set({ site: /^https?:\/\//.test(site) ? site.replace(/[?#].*$/, '') : '' }),
          ),
    );
  acts.append(make('button', { type: 'button', id: 'close', onclick: () => set({ chosen: -1 }) }, 'Close'));
  const fronted = columns.get('front 0')[i] ? '; on the Pareto front' : '';
  box.append(
    make('h2', {}, `Point ${number(i)}: ${pointName(i)}`),
    make(
      'p',
      { class: 'said' },
      `Runs that ended well: ${counted(columns.get('runs 0')[i])}, others: ${counted(columns.get('failed 0')[i])}${fronted}.`,
    ),
    acts,
    table(
      ['l Metric', ...known.map(([, title]) => title), head.repeats > 1 ? 'l by' : 'l '],
      metrics.map((name, m) => ({
        cells: [name, ...known.map(([key]) => figure(column(m, key)?.[i])), head.texts[column(m, 'method')?.[i]] ?? ''],
      })),
    ),
    make('p', { class: 'said' }, 'Its first run, on the command line: ', make('code', {}, command(i))),
  );
  return box;
}
