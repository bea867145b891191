// A metric against another.
function scatterView(body, controls) {
  controls.append(
    metricPicker('Across', 'cost'),
    metricPicker('Up', 'metric'),
    dimensionPicker('One colour per', 'colour', [...dimensions.keys()], 'one colour'),
  );
  const xs = column(state.cost, 'mean'),
    ys = column(state.metric, 'mean'),
    front = columns.get('front 0'),
    whole = head.front.length === 2 && head.front.includes(state.cost) && head.front.includes(state.metric),
    colouring = colours(state.colour),
    pick = (from) => Float64Array.from(shown, (i) => from[i]),
    across = axisOf(pick(xs), state.logX, metrics[state.cost]),
    up = axisOf(pick(ys), state.logY, metrics[state.metric]);
  controls.append(
    flag('log x', 'log-x', across.log, (logX) => set({ logX })),
    flag('log y', 'log-y', up.log, (logY) => set({ logY })),
  );
  const c = chart('scatter', 460, `${up.title} against ${across.title}: ${counted(shown.length)} points`);
  c.take = take;
  show(body, c, () => {
    const f = frame(c, {
        titleX: across.title,
        titleY: up.title,
        x: (from, to) => scale(across.low, across.high, across.log, from, to, (to - from) / 80),
        y: (from, to) => scale(up.low, up.high, up.log, from, to, (from - to) / 45),
      }),
      { g } = f,
      many = shown.length > 4000;
    c.marks = [];
    const kept = [];
    for (const i of shown) {
      const px = f.X.at(across.value(xs[i])),
        py = f.Y.at(up.value(ys[i]));
      if (!Number.isFinite(px) || !Number.isFinite(py)) continue;
      const k = colouring.at(i);
      g.fillStyle = colouring.of(k);
      g.globalAlpha = many ? 0.5 : 0.85;
      if (many) g.fillRect(px - 1, py - 1, 2.2, 2.2);
      else {
        mark(g, shapeOf(colouring, k), px, py, shown.length > 400 ? 2.6 : 4);
        g.fill();
      }
      c.marks.push({
        x: px,
        y: py,
        row: i,
        text: () =>
          `${pointName(i)}: ${metrics[state.cost]} ${figure(xs[i])}, ${metrics[state.metric]} ${figure(ys[i])}` +
          (whole && front[i] ? '; on the front' : ''),
      });
      if (whole && front[i]) kept.push([px, py]);
    }
    g.globalAlpha = 1;
    kept.sort((a, b) => a[0] - b[0] || b[1] - a[1]);
    for (const [px, py] of kept) ring(g, px, py, 5.5, palette.front);
    g.beginPath();
    kept.forEach(([px, py], n) => (n ? g.lineTo(px, py) : g.moveTo(px, py)));
    g.stroke();
    c.marks.sort((a, b) => a.x - b.x || a.y - b.y);
  });
  body.append(legend(colouring, dimensions[state.colour]));
  said(
    body,
    'Each mark is a point, by the means of its runs. ' +
      (whole ? 'Rings are the Pareto front of all points: no other is as good in both and better in one. ' : '') +
      across.note +
      up.note,
  );
}
