// A metric over two dimensions.
/** The index of a row on an axis of cells: its value's, or one of equal parts of a range. */
function binned(d) {
  if (d.size) return { names: d.numeric ? d.values.map(([v]) => figure(v, 4)) : d.names, at: (i) => d.index[i], numeric: d.numeric };
  const [low, high] = range(d.value),
    log = d.log && low > 0,
    at = (v) => (log ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low)),
    back = (p) => (log ? low * (high / low) ** p : low + (high - low) * p);
  return {
    numeric: true,
    names: Array.from({ length: BINS }, (_, k) => figure(back((k + 0.5) / BINS), 3)),
    at: (i) => Math.min(BINS - 1, Math.max(0, Math.floor(at(d.value[i]) * BINS))),
  };
}

function heatView(body, controls) {
  if (state.y === state.x) state.y = dimensions.findIndex((_, d) => d !== state.x);
  controls.append(
    metricPicker('Metric', 'metric'),
    dimensionPicker('Across', 'x', [...dimensions.keys()]),
    dimensionPicker(
      'Up',
      'y',
      [...dimensions.keys()].filter((d) => d !== state.x),
    ),
  );
  const x = binned(dimensions[state.x]),
    y = binned(dimensions[state.y]),
    columnsX = x.names.length,
    means = new Float64Array(columnsX * y.names.length),
    numbers = new Uint32Array(means.length),
    rows = new Int32Array(means.length),
    values = column(state.metric, 'mean');
  for (const i of shown) {
    if (!Number.isFinite(values[i])) continue;
    const at = y.at(i) * columnsX + x.at(i);
    means[at] += (values[i] - means[at]) / ++numbers[at];
    rows[at] = i;
  }
  const filled = means.filter((_, k) => numbers[k] > 0),
    axis = axisOf(filled, state.logY, metrics[state.metric]),
    part = (v) =>
      (axis.log ? Math.log(axis.value(v) / axis.low) / Math.log(axis.high / axis.low) : (v - axis.low) / (axis.high - axis.low)) || 0;
  controls.append(flag('log colours', 'log-y', axis.log, (logY) => set({ logY })));
  const height = Math.min(Math.max(260, 90 + 26 * y.names.length), 560),
    c = chart(
      'heat',
      height,
      `${metrics[state.metric]} over ${dimensions[state.x].title} and ${dimensions[state.y].title}: ` +
        `${counted(filled.length)} cells from ${figure(axis.low)} to ${figure(axis.high)}`,
    );
  c.take = take;
  show(body, c, () => {
    const f = frame(c, {
        titleX: dimensions[state.x].title,
        titleY: dimensions[state.y].title,
        x: (from, to) => slots(x.names, from, to, x.numeric),
        y: (from, to) => slots(y.names, from, to, y.numeric),
      }),
      { g } = f,
      wide = f.X.wide,
      high = Math.abs(f.Y.wide);
    c.marks = [];
    g.textAlign = 'center';
    g.textBaseline = 'middle';
    for (let k = 0; k < means.length; k++) {
      if (!numbers[k]) continue;
      const px = f.X.at(k % columnsX) - wide / 2,
        py = f.Y.at(Math.floor(k / columnsX)) - high / 2,
        p = part(means[k]);
      g.fillStyle = heatText(p);
      g.fillRect(Math.floor(px), Math.floor(py), Math.ceil(px + wide) - Math.floor(px), Math.ceil(py + high) - Math.floor(py));
      if (wide > 52 && high > 15) {
        const [r, gg, b] = heat(p);
        g.fillStyle = 0.299 * r + 0.587 * gg + 0.114 * b > 140 ? '#111' : '#fff';
        g.fillText(figure(means[k], 3), px + wide / 2, py + high / 2);
      }
      c.marks.push({
        x: px + wide / 2,
        y: py + high / 2,
        box: [px, py, wide, high],
        row: numbers[k] === 1 ? rows[k] : -1,
        text: () =>
          `${dimensions[state.x].title} ${x.names[k % columnsX]}, ${dimensions[state.y].title} ${y.names[Math.floor(k / columnsX)]}: ` +
          `${metrics[state.metric]} ${figure(means[k])}${numbers[k] > 1 ? `, mean over ${counted(numbers[k])} points` : ''}`,
      });
    }
    g.strokeStyle = palette.muted;
    g.strokeRect(f.left + 0.5, f.top + 0.5, f.right - f.left, f.bottom - f.top);
  });
  const bar = make('span', { class: 'bar' });
  bar.style.background = `linear-gradient(90deg,${[0, 0.25, 0.5, 0.75, 1].map(heatText).join(',')})`;
  body.append(
    make(
      'div',
      { class: 'legend' },
      make('span', {}, `${axis.title}: ${figure(axis.low)}`, bar, figure(axis.high), axis.log ? ' (logarithmic)' : ''),
    ),
  );
  const pooled = numbers.some((n) => n > 1);
  said(
    body,
    (pooled ? 'Cells with several points show their mean; choose single settings below. ' : 'Each cell is a point. ') +
      `Empty cells have no value. ${axis.note}`,
  );
}
