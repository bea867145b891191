// Pages of error against cost: of families of methods (`laglab tradeoff`) and of levels of refinement (`laglab work-precision`).
/** @typedef {{x: number, y: number, low: number, high: number, k: number, line: number, name: string, link?: string, front: boolean,
 * chosen?: boolean}} ErrorPoint */

const known = (value) => value ?? NaN; // null: none, or not finite

/** Colours by name, in the order in which the names occur. */
function namedColours(all) {
  const names = [...new Set(all)];
  return { names, of: (k) => palette.series[k % COLOURS] };
}

const linked = (point) => (point?.link ? make('a', { href: point.link, target: '_blank', rel: 'noopener' }, point.name) : point?.name);

/** Points as rows of a table, which is made when it is opened.
 * @param {ErrorPoint[]} points */
function pointTable(points, titleX, titleY, name) {
  const rows = () =>
    [...points]
      .sort((a, b) => a.x - b.x || a.y - b.y)
      .map((p) => ({ cells: [linked(p), ...[p.x, p.y, p.low, p.high].map((v) => figure(v))], mark: p.front }));
  return make(
    'details',
    {
      class: 'only',
      ontoggle: ({ target }) =>
        target.open && !target.querySelector('table') && target.append(table(['l Point', titleX, titleY, '95 % from', 'to'], rows(), name)),
    },
    make('summary', {}, `${counted(points.length)} points as a table`),
  );
}

/** Error against a cost. Points of a line are joined in their order.
 * @param {Element} parent
 * @param {{title: string, titleX: string, titleY: string, colouring: any, points: ErrorPoint[], levels?: number[]}} wish */
function errorPlot(parent, { title, titleX, titleY, colouring, points, levels = [] }) {
  const box = make('section', {}, make(head.kind === 'tradeoff' ? 'h4' : 'h3', {}, title)),
    drawn = points.filter((p) => Number.isFinite(p.x) && Number.isFinite(p.y)).sort((a, b) => a.k - b.k || a.line - b.line),
    axis = (values, name) =>
      axisOf(
        values,
        values.every((v) => v > 0),
        name,
      ),
    across = axis(
      drawn.map((p) => p.x),
      titleX,
    ),
    up = axis([...drawn.map((p) => p.y), ...levels], titleY),
    [low, high] = up.log ? [up.low, up.high] : range([up.low, up.high, ...drawn.flatMap((p) => [p.low, p.high])]),
    text = (p) =>
      `${p.name}: ${titleX} ${figure(p.x)}, ${titleY} ${figure(p.y)}${between(p.low, p.high)}${p.front ? '; on the front' : ''}`,
    name = `plot-${drawings.length}`,
    c = chart(name, 340, `${titleY} against ${titleX}: ${counted(drawn.length)} points`);
  c.take = (m) => m.of.link && open(m.of.link, '_blank', 'noopener');
  parent.append(box);
  if (drawn.length)
    show(box, c, () => {
      const f = frame(c, {
          titleX: across.log ? `${titleX} (log)` : titleX,
          titleY: up.log ? `${titleY} (log)` : titleY,
          x: (from, to) => scale(across.low, across.high, across.log, from, to, (to - from) / 80),
          y: (from, to) => scale(low, high, up.log, from, to, (from - to) / 45),
        }),
        { g } = f;
      g.strokeStyle = g.fillStyle = palette.muted;
      g.lineWidth = 1;
      g.setLineDash([5, 3]);
      g.textAlign = 'right';
      g.textBaseline = 'bottom';
      for (const level of levels) {
        g.beginPath();
        g.moveTo(f.left, f.Y.at(level));
        g.lineTo(f.right, f.Y.at(level));
        g.stroke();
        g.fillText(figure(level, 2), f.right - 2, f.Y.at(level) - 1);
      }
      g.setLineDash([]);
      drawSeries(
        f,
        c,
        drawn,
        colouring,
        (p) => f.X.at(p.x),
        (v) => f.Y.at(v),
        { joined: true, log: up.log, text },
      ); // prettier-ignore
      for (const { x, y, of } of c.marks) {
        if (of.front) ring(g, x, y, 5.5, palette.front);
        if (of.chosen) ring(g, x, y, 8.5, palette.fg);
      }
      c.marks.sort((a, b) => a.x - b.x || a.y - b.y);
    });
  else said(box, 'No values to draw.');
  box.append(pointTable(points, titleX, titleY, `points of ${name}`));
}

/** A legend and plots next to each other. */
function plotGroup(colouring, title, plots) {
  const grid = make('div', { class: 'plots' });
  views.append(legend(colouring, { title }), grid);
  for (const wish of plots) errorPlot(grid, { colouring, ...wish });
}

// ---- families of methods ----

function choiceTable(family, choices, named) {
  return table(
    ['l Cost', 'Error at most', 'l Cheapest', 'Its error', '95 % to', 'Its cost', 'l Measured again', 'l Figures', 'l As cheap'],
    choices.map((choice) => {
      const row = family.rows[choice.row];
      return {
        cells: [
          family.costs[choice.cost].title,
          figure(choice.level, 2),
          row ? linked(named(row)) : 'none',
          ...(row ? [row.error[0], row.error[2], row.costs[choice.cost][0]].map((v) => figure(v, 4)) : ['', '', '']),
          choice.outcome,
          choice.figures,
          choice.as_cheap.join(', '),
        ],
      };
    }),
    `choices, ${family.problems[choices[0]?.problem]?.title}`,
  );
}

/** A problem of a family: the choices, and a plot for each cost. */
function drawProblem(family, problem, at) {
  const rows = family.rows.map((row, i) => ({ row, i })).filter(({ row }) => row.problem === at),
    choices = family.choices.filter((choice) => choice.problem === at),
    named = (row) => ({
      name: `${row.method}, ${row.setting.slice(row.setting.lastIndexOf('.') + 1)} ${figure(row.value)}`,
      link: head.address + row.link,
    }),
    colouring = namedColours(rows.map(({ row }) => row.method));
  views.append(make('h3', {}, `${problem.scenario}: ${problem.title}`), choiceTable(family, choices, named));
  plotGroup(
    colouring,
    'method',
    family.costs.map(({ title }, cost) => {
      const own = choices.filter((choice) => choice.cost === cost);
      let line = 0; // one for each setting that is varied
      const points = rows.map(({ row, i }, n) => {
        if (n > 0 && row.setting !== rows[n - 1].row.setting) line++;
        // Means over seeds may be 0. A single error of 0 would make an axis of many decades linear, and is not drawn.
        return {
          ...named(row),
          x: known(row.costs[cost][0]),
          y: row.error[0] > 0 || row.random ? known(row.error[0]) : NaN,
          low: row.random ? known(row.error[1]) : NaN,
          high: row.random ? known(row.error[2]) : NaN,
          k: colouring.names.indexOf(row.method),
          line,
          front: row.front[cost],
          chosen: own.some((choice) => choice.row === i),
          listed: row.error[0] !== null && row.costs[cost][0] !== null,
        };
      });
      return {
        title,
        titleX: title,
        titleY: problem.title,
        points: points.filter((p) => p.listed),
        levels: own.map((choice) => choice.level),
      };
    }),
  );
}

function drawTradeoff() {
  said(
    views,
    'Left is cheap, low is accurate. Marked points are the Pareto front: no other point is better in both. Dashed lines are three ' +
      'levels of error, in equal steps on a logarithmic scale between the least and the largest upper bound on the fronts of the ' +
      'counted costs, rounded up. A ring is the cheapest setting whose 95 % interval ends within a level. Then every setting was ' +
      'measured again, those with randomness on fresh seeds: a choice holds if it is within the level again and nothing else within ' +
      'it is cheaper beyond the intervals of both. Costs of what is as cheap do not differ certainly. A point leads to a live ' +
      'session. Times are of this machine.',
  );
  for (const family of head.families) {
    views.append(make('h2', { id: family.name }, family.title), make('p', {}, family.text));
    family.problems.forEach((problem, at) => drawProblem(family, problem, at));
  }
}

// ---- levels of refinement ----

/** No other is as good in both and better in one. @param {{x: number, y: number}[]} all @param {{x: number, y: number}} p */
const onFront = (all, p) => Number.isFinite(p.x + p.y) && !all.some((o) => o.x <= p.x && o.y <= p.y && (o.x < p.x || o.y < p.y));

function drawRefinement() {
  said(
    views,
    'Left is cheap, low is accurate; each line is a method whose setting is varied. Marked points are the Pareto front: no other ' +
      'point is better in both. Failed runs and runs without a known error are not drawn. Times are of this machine.',
  );
  for (const at of new Set(head.levels.map((level) => level.of))) {
    const levels = head.levels.filter((level) => level.of === at),
      { title, setting, counter, error } = levels[0],
      colouring = namedColours(levels.map((level) => level.series));
    const pointsAt = (cost) => {
      const places = levels.map((level) => ({ x: Math.abs(known(level[cost])), y: known(level.y) }));
      return levels.map((level, i) => ({
        ...places[i],
        low: known(level.low),
        high: known(level.high),
        k: colouring.names.indexOf(level.series),
        line: 0,
        name: `${level.series}, ${setting} ${figure(level.value)}`,
        front: onFront(places, places[i]),
      }));
    };
    views.append(make('h2', {}, `${title} by ${setting}`));
    plotGroup(colouring, title, [
      { title: 'Error against processor time', titleX: 'CPU time of a run, minimum, s', titleY: error, points: pointsAt('cpu_s') },
      { title: 'Error against counted cost', titleX: counter, titleY: error, points: pointsAt('count') },
    ]);
  }
}
