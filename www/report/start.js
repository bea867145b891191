// The page around the views.
const said = (parent, text) => {
  if (text) parent.append(make('p', { class: 'said note' }, text));
};

function filters() {
  const box = make('div', { class: 'controls' });
  dimensions.forEach((d, k) => {
    if (d.size)
      box.append(
        picker(
          d.title,
          `only-${k}`,
          [[-1, `all ${counted(d.size)}`], ...d.names.map((name, v) => [v, name])],
          state.only[k] ?? -1,
          (value) => {
            const { [k]: _, ...only } = state.only;
            set({ only: value < 0 ? only : { ...only, [k]: value }, page: 0 });
          },
        ),
      );
    else {
      const [low, high] = range(d.value),
        wish = state.only[k] ?? [low, high],
        bound = (side) => (value) => {
          const next = [...wish];
          next[side] = value === '' ? [low, high][side] : Number(value);
          set({ only: { ...state.only, [k]: next }, page: 0 });
        };
      box.append(field(`${d.title} from`, `from-${k}`, 'number', wish[0], bound(0)), field('to', `to-${k}`, 'number', wish[1], bound(1)));
    }
  });
  box.append(
    field(`${metrics[state.metric]} from`, 'metric-low', 'number', state.low, (low) => set({ low, page: 0 })),
    field('to', 'metric-high', 'number', state.high, (high) => set({ high, page: 0 })),
    make('button', { type: 'button', id: 'all', onclick: () => set({ only: {}, low: '', high: '', find: '', page: 0 }) }, 'Show all'),
  );
  const summary = make('summary', {}, `Choose settings: ${counted(shown.length)} of ${counted(count)} points are shown`);
  return make(
    'details',
    { class: 'only', open: filtersOpen, id: 'only', ontoggle: (event) => (filtersOpen = event.target.open) },
    summary,
    box,
  );
}

let filtersOpen = true;

function tabs() {
  const bar = make('div', { class: 'tabs', role: 'tablist', 'aria-label': 'Views' }),
    names = Object.keys(titles)
      .filter((name) => dimensions.length > 1 || name !== 'heat')
      .filter((name) => dimensions.length > 0 || name === 'spread' || name === 'table'),
    go = (name) => {
      set({ view: name, page: 0, logX: null, logY: null });
      byId(`tab-${name}`)?.focus();
    };
  for (const name of names)
    bar.append(
      make(
        'button',
        {
          type: 'button',
          role: 'tab',
          id: `tab-${name}`,
          'aria-selected': String(name === state.view),
          'aria-controls': 'view',
          tabindex: name === state.view ? 0 : -1,
          onclick: () => go(name),
        },
        titles[name],
      ),
    );
  bar.addEventListener('keydown', (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (step) go(names[(names.indexOf(state.view) + step + names.length) % names.length]);
  });
  return bar;
}

const RUN_DIGITS = { 3: 4, 4: 6, 5: 8 };

/** What the page lacks, and where it is. */
function about() {
  const parts = [],
    points = head.points;
  if (count < points) parts.push(`${counted(count)} of ${counted(points)} points are in this page, or have been run: a random sample.`);
  else parts.push(`All ${counted(points)} points are in this page.`);
  parts.push(
    head.planes === 8
      ? 'Their values are exact.'
      : head.planes > 4
        ? 'Their values are rounded to 8 digits.'
        : head.planes === 4
          ? 'Their values are rounded to 6 digits.'
          : 'Their values are rounded to about 4 digits.',
  );
  if (head.repeats > 1) {
    if (!columns.has('p50 0')) parts.push('Of the statistics only means and their intervals are here.');
    if (!runs.length) parts.push('Single runs are left out.');
    else if (head.kept < head.repeats)
      parts.push(`Of the runs the first ${counted(head.kept)} of ${counted(head.repeats)} of each point are here.`);
    else
      parts.push(
        `All ${counted(head.runs)} runs are here${head.run_planes < 8 ? `, rounded to ${RUN_DIGITS[head.run_planes]} digits` : ''}.`,
      );
  }
  const chosen = Object.entries(state.only).map(([d, wish]) =>
    dimensions[d].size
      ? `${dimensions[d].title} ${dimensions[d].names[wish]}`
      : `${dimensions[d].title} ${figure(wish[0])} to ${figure(wish[1])}`,
  );
  if (shown.length < count) parts.push(`Shown are ${counted(shown.length)} points${chosen.length ? `, of ${chosen.join(', ')}` : ''}.`);
  return make('p', { class: 'note', id: 'about' }, parts.join(' '));
}

const draws = {
  series: seriesView,
  scatter: scatterView,
  heat: heatView,
  spread: spreadView,
  differences: differencesView,
  table: tableView,
};

function drawAll() {
  readPalette();
  for (const c of drawings) {
    c.at = -1;
    context(c.over, c.height);
    c.draw();
  }
}

function render() {
  const focus = document.activeElement?.id;
  readPalette();
  choose();
  drawings.length = 0;
  const body = make('div', { role: 'tabpanel', id: 'view', 'aria-labelledby': `tab-${state.view}` }),
    controls = make('div', { class: 'controls' }),
    bar = tabs();
  if (!bar.querySelector(`#tab-${state.view}`)) {
    state.view = bar.firstElementChild.id.slice(4);
    return render();
  }
  body.append(controls);
  draws[state.view](body, controls);
  views.replaceChildren(about(), bar, body, filters(), state.chosen >= 0 ? detail(state.chosen) : '');
  drawAll();
  if (focus) byId(focus)?.focus({ preventScroll: true });
  remember();
}

/** Draws again for another size or other colours, and for paper. */
function watch(again) {
  addEventListener('resize', drawAll);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', again);
  const print = (on) => {
    document.documentElement.toggleAttribute('data-print', on);
    again();
  };
  addEventListener('beforeprint', () => print(true));
  addEventListener('afterprint', () => print(false));
}

/** A page that has only plots. */
async function startPlots(build) {
  const all = () => {
    readPalette();
    drawings.length = 0;
    views.replaceChildren();
    build();
    drawAll();
  };
  all();
  watch(all);
}

async function start() {
  const [points, differences, run] = await Promise.all(['point-data', 'difference-data', 'run-data'].map(inflate));
  columns = unpackAll(points, head.point_columns);
  differenceColumns = unpackAll(differences, head.difference_columns);
  count = head.shown;
  const numbers = columns.get('point 0');
  number = numbers ? (i) => numbers[i] : (i) => i;
  if (head.kept > 0) {
    const each = count * head.kept;
    runs = metrics.map((_, m) => unpack(run, m * each * head.run_planes, each, head.run_planes));
  }
  dimensions = makeDimensions();
  begin();
  recall();
  render();
  watch(render);
}

/** What is shown first: the error, along the first range, one colour per technique. */
function begin() {
  state.metric = head.error;
  state.cost = head.cost >= 0 ? head.cost : metrics.length > 1 ? (head.error === 0 ? 1 : 0) : 0;
  const all = [...dimensions.keys()],
    best = all.filter((d) => dimensions[d].numeric).sort((a, b) => (dimensions[b].size || 1e9) - (dimensions[a].size || 1e9))[0] ?? 0,
    few = all.filter((d) => d !== best && dimensions[d].size && dimensions[d].size <= COLOURS);
  state.x = best;
  state.colour = few.find((d) => !dimensions[d].numeric) ?? few[0] ?? -1;
  state.y = all.filter((d) => d !== best).sort((a, b) => Number(dimensions[b].numeric) - Number(dimensions[a].numeric))[0] ?? 0;
  state.by = state.colour >= 0 ? state.colour : best;
  state.dimension = compared().find((d) => !dimensions[d].numeric) ?? compared()[0] ?? 0;
}

const begun = head.kind === 'tradeoff' ? startPlots(drawTradeoff) : head.kind === 'work-precision' ? startPlots(drawRefinement) : start();
begun.catch((error) => views.append(make('p', { role: 'alert' }, `The data of this page cannot be read: ${error.message}`)));
// For the console and for tests: the data of the page.
Object.assign(window, {
  report: {
    head,
    drawings,
    column: (metric, name) => column(metric, name),
    run: (metric) => runs[metric],
    settings: (i) => settings(i),
    difference: (k, name) => differenceColumns.get(`${name} ${k}`),
  },
});
