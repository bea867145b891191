// A metric along a dimension, one colour per value of another.
/** Means by the value of the x dimension and of the colour: over the settings that are not chosen. */
function grouped(x, colouring) {
  const values = column(state.metric, 'mean'),
    low = column(state.metric, 'low'),
    high = column(state.metric, 'high'),
    groups = new Map();
  for (const i of shown) {
    if (!Number.isFinite(values[i])) continue;
    const k = colouring.at(i),
      key = k * x.size + x.index[i],
      group = groups.get(key);
    if (!group) groups.set(key, { k, index: x.index[i], x: x.value[i], y: values[i], n: 1, row: i, low: low?.[i], high: high?.[i] });
    else {
      group.n++;
      group.y += (values[i] - group.y) / group.n;
      group.low = group.high = NaN;
      group.row = -1;
    }
  }
  return [...groups.values()].sort((a, b) => a.k - b.k || a.x - b.x);
}

function scattered(x, colouring) {
  const values = column(state.metric, 'mean');
  return [...shown]
    .filter((i) => Number.isFinite(values[i]))
    .map((i) => ({
      k: colouring.at(i),
      index: 0,
      x: x.value[i],
      y: values[i],
      n: 1,
      row: i,
      low: column(state.metric, 'low')?.[i],
      high: column(state.metric, 'high')?.[i],
    }));
}

function seriesView(body, controls) {
  const x = dimensions[state.x];
  if (state.colour === state.x) state.colour = -1;
  controls.append(
    metricPicker('Metric', 'metric'),
    dimensionPicker('Along', 'x', [...dimensions.keys()]),
    dimensionPicker(
      'One colour per',
      'colour',
      [...dimensions.keys()].filter((d) => d !== state.x),
      'one colour',
    ),
  );
  const colouring = colours(state.colour),
    list = x.size ? grouped(x, colouring) : scattered(x, colouring),
    axis = axisOf(
      list.map((p) => p.y),
      state.logY,
      metrics[state.metric],
    ),
    along = axisOf(
      list.map((p) => p.x),
      state.logX ?? (x.log ? true : null),
      x.title,
    );
  controls.append(
    flag('log y', 'log-y', axis.log, (logY) => set({ logY })),
    x.numeric ? flag('log x', 'log-x', along.log, (logX) => set({ logX })) : '',
  );
  const pooled = list.filter((p) => p.n > 1).length,
    most = list.reduce((n, p) => Math.max(n, p.n), 0);
  const c = chart('series', 420, `${metrics[state.metric]} along ${x.title}: ${counted(list.length)} marks`);
  c.take = take;
  const bounds = list.filter((p) => Number.isFinite(p.low) && Number.isFinite(p.high) && list.length <= 600);
  const [low, high] = axis.log ? [axis.low, axis.high] : range([axis.low, axis.high, ...bounds.flatMap((p) => [p.low, p.high])]);
  show(body, c, () => {
    const f = frame(c, {
      titleX: along.title,
      titleY: axis.title,
      x: (from, to) => (x.numeric ? scale(along.low, along.high, along.log, from, to, (to - from) / 80) : slots(x.names, from, to)),
      y: (from, to) => scale(low, high, axis.log, from, to, (from - to) / 45),
    });
    const across = (p) =>
      x.numeric
        ? f.X.at(along.value(p.x))
        : f.X.at(p.index) +
          (colouring.size > 1 && colouring.size <= 16 ? ((p.k + 0.5) / colouring.size - 0.5) * Math.min(f.X.wide * 0.7, 90) : 0);
    drawSeries(f, c, list, colouring, across, (v) => f.Y.at(axis.value(v)), {
      joined: x.numeric && x.size > 0,
      log: axis.log,
      text: (p) => seriesText(p, x, colouring),
    });
  });
  body.append(legend(colouring, dimensions[state.colour]));
  said(
    body,
    (pooled ? `Marks are means over up to ${counted(most)} settings each; choose single settings below to see intervals. ` : '') +
      (bounds.length ? 'Lines through marks are 95 % intervals of the mean. ' : '') +
      axis.note,
  );
}

/** Marks with intervals, those of a line joined. */
function drawSeries(f, c, list, colouring, across, up, { joined, log, text }) {
  const { g } = f,
    small = list.length > 3000;
  c.marks = [];
  g.save();
  g.beginPath();
  g.rect(f.left, f.top, f.right - f.left, f.bottom - f.top);
  g.clip();
  let before = null;
  for (const p of list) {
    const px = across(p),
      py = up(p.y);
    if (!Number.isFinite(px) || !Number.isFinite(py)) continue;
    g.strokeStyle = g.fillStyle = colouring.of(p.k);
    if (joined && before && before.k === p.k && before.line === p.line) {
      g.globalAlpha = small ? 0.3 : 0.75;
      g.lineWidth = 1.5;
      g.beginPath();
      g.moveTo(before.px, before.py);
      g.lineTo(px, py);
      g.stroke();
    }
    before = { k: p.k, line: p.line, px, py };
    if (!small && p.low <= p.high) {
      g.globalAlpha = 0.6;
      g.lineWidth = 1.5;
      const to = log && !(p.low > 0) ? f.bottom : up(p.low);
      g.beginPath();
      g.moveTo(px, Math.min(to, f.bottom));
      g.lineTo(px, Math.max(up(p.high), f.top) || f.top);
      g.stroke();
    }
    g.globalAlpha = small ? 0.5 : 1;
    if (list.length > 20000) g.fillRect(px - 1, py - 1, 2, 2);
    else {
      mark(g, shapeOf(colouring, p.k), px, py, list.length > 600 ? 1.8 : list.length > 150 ? 2.6 : 4);
      g.fill();
    }
    c.marks.push({ x: px, y: py, row: p.row, of: p, text: () => text(p) });
  }
  g.restore();
}

const between = (low, high) => (low <= high ? ` (95 % from ${figure(low)} to ${figure(high)})` : '');

function seriesText(p, x, colouring) {
  if (p.row >= 0) return `${pointName(p.row)}: ${metrics[state.metric]} ${figure(p.y)}${between(p.low, p.high)}`;
  const series = state.colour >= 0 && colouring.names[p.k] ? `, ${dimensions[state.colour].title} ${colouring.names[p.k]}` : '';
  return `${x.title} ${x.names[p.index]}${series}: mean of ${metrics[state.metric]} over ${counted(p.n)} settings ${figure(p.y)}`;
}
