// Paired differences between two values of a dimension, as the engine computed them.
const compared = () => [...new Set(head.differences.map((d) => d.dimension))].sort((a, b) => a - b);

/** The settings of the other dimensions, in the order of the engine. */
function settingRow(d, k, value) {
  const { stride, size } = dimensions[d];
  return Math.floor(k / stride) * stride * size + value * stride + (k % stride);
}

function settingName(d, k) {
  const point = settingRow(d, k, 0);
  return dimensions
    .filter((_, other) => other !== d)
    .map((other) => `${other.title} ${other.names[Math.floor(point / other.stride) % other.size]}`)
    .join(', ');
}

function differencesView(body, controls) {
  const list = compared();
  if (list.length === 0) {
    said(
      body,
      head.grid
        ? 'No dimension has from 2 to 16 values whose runs could be paired in this page.'
        : 'The points are a sample: no two of them differ by one setting alone.',
    );
    return;
  }
  if (!list.includes(state.dimension)) Object.assign(state, { dimension: list[0], from: 0, of: 1 });
  const d = dimensions[state.dimension];
  if (state.from >= d.size) state.from = 0;
  if (state.of >= d.size || state.of === state.from) state.of = state.from === 0 ? 1 : 0;
  const values = d.names.map((name, k) => [k, name]);
  controls.append(
    metricPicker('Metric', 'metric'),
    picker(
      'Of',
      'pick-dimension',
      list.map((k) => [k, dimensions[k].title]),
      state.dimension,
      (dimension) => set({ dimension, from: 0, of: 1, page: 0 }),
    ),
    picker(
      'Value',
      'pick-of',
      values.filter(([k]) => k !== state.from),
      state.of,
      (of) => set({ of, page: 0 }),
    ),
    picker('minus', 'pick-from', values, state.from, (from) => set({ from, of: from === state.of ? state.from : state.of, page: 0 })),
  );
  const turned = state.from > state.of,
    from = Math.min(state.from, state.of),
    of = Math.max(state.from, state.of),
    at = head.differences.findIndex((e) => e.dimension === state.dimension && e.metric === state.metric && e.from === from && e.of === of),
    found = head.differences[at];
  if (!found) return said(body, 'These values are not compared in this page.');
  const turn = ([mean, low, high, method]) =>
    turned ? [mean === null ? null : -mean, high === null ? null : -high, low === null ? null : -low, method] : [mean, low, high, method];
  const [mean, low, high, method] = turn(found.all),
    bare = low === null && high === null;
  body.append(
    make(
      'p',
      { id: 'overall' },
      make('strong', {}, `${d.names[state.of]} minus ${d.names[state.from]}: ${figure(mean)}`),
      bare
        ? `; no interval: ${(head.texts[method] ?? '').replace(/^none: /, '')}`
        : ` (95 % from ${figure(low)} to ${figure(high)}; ${head.texts[method] ?? ''})`,
      found.settings > 1
        ? `. Mean over ${counted(found.complete)} of ${counted(found.settings)} settings of the other axes` +
            (found.complete < found.settings ? ', those where all runs have the metric' : '') +
            (bare ? '.' : '; the interval is over seeds, each with its mean over these settings.')
        : '.',
      head.covers[method] ? ` Such intervals contain the mean so often: ${head.covers[method]}.` : '',
    ),
  );
  const part = (name) => differenceColumns.get(`${name} ${at}`);
  if (!part('mean')) {
    const axis = d.axes.map((a, k) => `${a.path}=${d.values[state.from][k]}`).join(',');
    body.append(
      make(
        'p',
        { class: 'said' },
        'The differences at single settings are left out for size. This writes those from a point: ',
        make('code', {}, `laglab sweep experiment.json --points --compare ${axis}`),
      ),
    );
    return;
  }
  const fits = (k) =>
      Object.entries(state.only).every(
        ([other, wish]) =>
          Number(other) === state.dimension ||
          Math.floor(settingRow(state.dimension, k, 0) / dimensions[other].stride) % dimensions[other].size === wish,
      ),
    rows = Array.from({ length: found.settings }, (_, k) => k)
      .filter(fits)
      .map((k) => [k, ...turn([part('mean')[k], part('low')[k], part('high')[k], part('method')[k]])]),
    page = rows.slice(state.page * PAGE_ROWS, (state.page + 1) * PAGE_ROWS),
    c = chart('forest', 60 + 24 * Math.max(page.length, 2), `Differences at ${rows.length} settings`);
  const [least, largest] = range([0, ...rows.flatMap(([, m, a, b]) => [m, a, b])]);
  c.take = ({ row }) => row >= 0 && set({ chosen: row });
  show(body, c, () => {
    const f = frame(c, {
        titleX: `${metrics[state.metric]}: ${d.names[state.of]} minus ${d.names[state.from]}`,
        titleY: dimensions.length > 1 ? 'other settings' : '',
        x: (a, b) => scale(least, largest, false, a, b, (b - a) / 80),
        y: (bottom, top) =>
          slots(
            page.map(([k]) => settingName(state.dimension, k) || 'all'),
            top,
            bottom,
          ),
      }),
      { g } = f;
    c.marks = [];
    g.strokeStyle = palette.muted;
    g.setLineDash([4, 3]);
    g.beginPath();
    g.moveTo(f.X.at(0), f.top);
    g.lineTo(f.X.at(0), f.bottom);
    g.stroke();
    g.setLineDash([]);
    page.forEach(([k, m, a, b], row) => {
      if (!Number.isFinite(m)) return;
      const py = f.Y.at(row),
        clear = a > 0 || b < 0;
      g.strokeStyle = g.fillStyle = clear ? palette.series[0] : palette.muted;
      g.lineWidth = 2;
      if (Number.isFinite(a) || Number.isFinite(b)) {
        g.beginPath();
        g.moveTo(Number.isFinite(a) ? f.X.at(a) : f.left, py);
        g.lineTo(Number.isFinite(b) ? f.X.at(b) : f.right, py);
        g.stroke();
      }
      mark(g, clear ? 0 : 3, f.X.at(m), py, 4);
      g.fill();
      c.marks.push({
        x: f.X.at(m),
        y: py,
        box: [f.left, py - 11, f.right - f.left, 22],
        row: settingRow(state.dimension, k, state.of),
        text: () => `${settingName(state.dimension, k)}: ${figure(m)} (95 % from ${figure(a)} to ${figure(b)})`,
      });
    });
  });
  said(body, 'Differences of runs with the same seed and otherwise the same settings. Grey: the interval contains 0, or there is none.');
  body.append(
    table(
      ['l Other settings', 'Difference', '95 % from', 'to', 'l by'],
      page.map(([k, m, a, b, by]) => ({
        cells: [settingName(state.dimension, k) || 'all', figure(m), figure(a), figure(b), head.texts[by] ?? ''],
      })),
    ),
    pages(rows.length),
  );
}
