// The distribution of a metric: boxes and a histogram.
/** The runs of a point that the page holds, or its mean. */
function valuesOf(i, metric, to) {
  if (!runs.length) {
    const v = column(metric, 'mean')[i];
    if (Number.isFinite(v)) to.push(v);
    return;
  }
  const from = runs[metric],
    kept = head.kept;
  for (let r = i * kept; r < (i + 1) * kept; r++) if (Number.isFinite(from[r])) to.push(from[r]);
}

function boxOf(group) {
  const sorted = Float64Array.from(group.values).sort(),
    single = group.rows.length === 1 && head.repeats > 1 && column(state.metric, 'p50');
  const [p25, p50, p75] = single
    ? ['p25', 'p50', 'p75'].map((name) => column(state.metric, name)[group.rows[0]])
    : [0.25, 0.5, 0.75].map((p) => quantile(sorted, p));
  return { ...group, sorted, p25, p50, p75, low: sorted[0], high: sorted[sorted.length - 1] };
}

function valuesAre() {
  const part = head.kept < head.repeats ? `, the first ${counted(head.kept)} of ${counted(head.repeats)} of each point` : '';
  if (runs.length) return `Values are runs${part}`;
  return head.repeats > 1 ? 'Values are means of points: the page has no single runs' : 'Values are points of one run each';
}

function spreadView(body, controls) {
  const x = dimensions.length ? dimensions[state.by] : null;
  controls.append(metricPicker('Metric', 'metric'), x ? dimensionPicker('A box per', 'by', [...dimensions.keys()]) : '');
  const bins = x ? binned(x) : { names: ['all'], at: () => 0, numeric: false },
    groups = bins.names.map((name, k) => ({ name, k, rows: [], values: [] }));
  for (const i of shown) {
    const group = groups[bins.at(i)];
    group.rows.push(i);
    valuesOf(i, state.metric, group.values);
  }
  const boxes = groups.filter((group) => group.values.length > 0).map(boxOf),
    axis = axisOf(
      boxes.flatMap((b) => [b.low, b.high, b.p50]),
      state.logY,
      metrics[state.metric],
    );
  controls.append(flag('log', 'log-y', axis.log, (logY) => set({ logY })));
  const what = runs.length ? 'runs' : 'points',
    c = chart('boxes', 360, `${metrics[state.metric]}: ${boxes.length} boxes`);
  c.take = (m) => set({ box: m.k });
  show(body, c, () => drawBoxes(c, boxes, bins, x?.title ?? '', axis, what));
  said(
    body,
    `${valuesAre()}. Boxes are quartiles and median, whiskers the least and the largest value. ` +
      `Choose a box to see its histogram. ${axis.note}`,
  );
  const chosen = boxes.find((b) => b.k === state.box);
  histogram(body, chosen ? [chosen] : boxes, chosen ? `${x.title} ${chosen.name}` : 'all that are chosen', axis, what);
}

function drawBoxes(c, boxes, bins, title, axis, what) {
  const f = frame(c, {
      titleX: title,
      titleY: axis.title,
      x: (from, to) => slots(bins.names, from, to, bins.numeric),
      y: (from, to) => scale(axis.low, axis.high, axis.log, from, to, (from - to) / 45),
    }),
    { g } = f,
    up = (v) => f.Y.at(axis.value(v)),
    wide = Math.max(1.5, Math.min(f.X.wide * 0.6, 46));
  c.marks = [];
  for (const b of boxes) {
    const at = f.X.at(b.k),
      [top, bottom] = [up(b.p75), up(b.p25)].sort((a, z) => a - z);
    g.strokeStyle = palette.series[0];
    g.lineWidth = 1.5;
    g.beginPath();
    g.moveTo(at, up(b.low));
    g.lineTo(at, bottom);
    g.moveTo(at, top);
    g.lineTo(at, up(b.high));
    g.stroke();
    g.fillStyle = b.k === state.box ? palette.front : palette.series[0];
    g.globalAlpha = 0.35;
    g.fillRect(at - wide / 2, top, wide, bottom - top);
    g.globalAlpha = 1;
    g.strokeRect(at - wide / 2, top, wide, bottom - top);
    g.lineWidth = 2.5;
    g.beginPath();
    g.moveTo(at - wide / 2, up(b.p50));
    g.lineTo(at + wide / 2, up(b.p50));
    g.stroke();
    c.marks.push({
      x: at,
      y: up(b.p50),
      box: [at - f.X.wide / 2, f.top, f.X.wide, f.bottom - f.top],
      row: -1,
      k: b.k,
      text: () =>
        `${title} ${b.name}: ${counted(b.sorted.length)} ${what} of ${counted(b.rows.length)} points; least ${figure(b.low)}, ` +
        `quartiles ${figure(b.p25)}, ${figure(b.p50)}, ${figure(b.p75)}, largest ${figure(b.high)}`,
    });
  }
}

function histogram(parent, boxes, name, axis, what) {
  const all = boxes.reduce((n, b) => n + b.sorted.length, 0);
  if (!all) return;
  const low = Math.min(...boxes.map((b) => (axis.log ? (b.sorted.find((v) => v > 0) ?? Infinity) : b.low))),
    high = Math.max(...boxes.map((b) => b.high)),
    log = axis.log && low > 0 && low < high,
    BARS = Math.max(8, Math.min(60, Math.ceil(2 * Math.cbrt(all)))),
    edge = (k) => (log ? low * (high / low) ** (k / BARS) : low + ((high - low) * k) / BARS),
    bars = new Uint32Array(BARS);
  for (const b of boxes)
    for (const v of b.sorted) {
      const part = high > low ? (log ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low)) : 0;
      if (part >= 0 && part <= 1) bars[Math.min(BARS - 1, Math.floor(part * BARS))]++;
    }
  const most = Math.max(...bars),
    c = chart('histogram', 230, `Histogram of ${metrics[state.metric]}, ${name}: ${counted(all)} ${what}`);
  parent.append(make('h2', {}, `Histogram: ${name}`));
  show(parent, c, () => {
    const f = frame(c, {
      titleX: metrics[state.metric],
      titleY: what,
      x: (from, to) => scale(low, high, log, from, to, (to - from) / 80),
      y: (from, to) => scale(0, most, false, from, to, (from - to) / 40),
    });
    c.marks = [];
    f.g.fillStyle = palette.series[0];
    for (let k = 0; k < BARS; k++) {
      const left = high > low ? f.X.at(edge(k)) : f.left + 20,
        right = high > low ? f.X.at(edge(k + 1)) : f.right - 20,
        top = f.Y.at(bars[k]),
        box = [left, top, Math.max(1, right - left - 1), f.Y.at(0) - top];
      f.g.fillRect(...box);
      c.marks.push({
        x: (left + right) / 2,
        y: top,
        box: [left, f.top, right - left, f.bottom - f.top],
        row: -1,
        text: () => `from ${figure(edge(k))} to ${figure(edge(k + 1))}: ${counted(bars[k])} ${what}`,
      });
      if (high === low) break;
    }
  });
}
