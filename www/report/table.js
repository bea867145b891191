// The points, a page at a time.
function table(heads, rows, name = 'table') {
  const left = (k) => (heads[k] instanceof Element ? heads[k].className || null : heads[k].startsWith('l ') ? 'l' : null),
    line = make('tr');
  heads.forEach((text, k) =>
    line.append(text instanceof Element ? text : make('th', { scope: 'col', class: left(k) }, text.replace(/^l /, ''))),
  );
  const body = make('tbody');
  for (const { cells, mark: marked, chosen } of rows) {
    const tr = make('tr', { class: [marked ? 'on' : '', chosen ? 'chosen' : ''].join(' ').trim() || null });
    cells.forEach((cell, k) => tr.append(make('td', { class: left(k) }, cell)));
    body.append(tr);
  }
  return make(
    'div',
    { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': name },
    make('table', {}, make('thead', {}, line), body),
  );
}

function pages(all) {
  const last = Math.max(0, Math.ceil(all / PAGE_ROWS) - 1);
  if (state.page > last) state.page = last;
  const go = (label, id, to) =>
    make('button', { type: 'button', id, disabled: to < 0 || to > last || to === state.page, onclick: () => set({ page: to }) }, label);
  return make(
    'div',
    { class: 'pages' },
    go('First', 'page-first', 0),
    go('Previous', 'page-previous', state.page - 1),
    make(
      'span',
      {},
      all ? `${counted(state.page * PAGE_ROWS + 1)} to ${counted(Math.min(all, (state.page + 1) * PAGE_ROWS))} of ${counted(all)}` : 'none',
    ),
    go('Next', 'page-next', state.page + 1),
    go('Last', 'page-last', last),
  );
}

const DETAILED = [
  ['mean', 'mean'],
  ['low', '95 % from'],
  ['high', 'to'],
  ['sd', 'SD'],
  ['p25', '25 %'],
  ['p50', 'median'],
  ['p75', '75 %'],
];

function tableView(body, controls) {
  const fields = [{ id: 'point', title: 'Point', of: number }];
  for (const [d, dimension] of dimensions.entries())
    fields.push({
      id: `d${d}`,
      title: dimension.title,
      of: (i) => dimension.value[i],
      text: (i) => (dimension.size ? dimension.names[dimension.index[i]] : dimension.sampled(i).map(valueText).join(', ')),
    });
  const failed = columns.get('failed 0');
  if (head.repeats > 1) fields.push({ id: 'runs', title: 'Runs', of: (i) => columns.get('runs 0')[i] });
  if (failed.some((n) => n > 0)) fields.push({ id: 'failed', title: 'Failed', of: (i) => failed[i] });
  for (let m = 0; m < metrics.length; m++) {
    const part = m === state.metric && head.repeats > 1 ? DETAILED.filter(([name]) => column(m, name)) : [DETAILED[0]];
    for (const [name, title] of part)
      fields.push({ id: `m${m}${name}`, title: name === 'mean' ? metrics[m] : title, of: (i) => column(m, name)[i] });
  }
  controls.append(
    metricPicker('All statistics of', 'metric'),
    field('Find in settings', 'find', 'text', state.find, (find) => set({ find, page: 0 }), { placeholder: 'such as rk4' }),
  );
  const words = state.find.toLowerCase().split(/\s+/).filter(Boolean);
  let rows = words.length ? shown.filter((i) => words.every((word) => pointName(i).toLowerCase().includes(word))) : shown;
  const by = fields.find((f) => f.id === state.sort);
  if (by) {
    const key = Float64Array.from({ length: count }, (_, i) => {
      const v = by.of(i);
      return Number.isFinite(v) ? (state.down ? -v : v) : Infinity;
    });
    rows = Uint32Array.from(rows).sort((a, b) => key[a] - key[b] || a - b);
  }
  const bar = pages(rows.length),
    front = columns.get('front 0'),
    heads = fields.map((f) =>
      make(
        'th',
        {
          scope: 'col',
          class: f.text ? 'l' : null,
          'aria-sort': f.id === state.sort ? (state.down ? 'descending' : 'ascending') : 'none',
        },
        make(
          'button',
          { type: 'button', id: `sort-${f.id}`, onclick: () => set({ sort: f.id, down: f.id === state.sort && !state.down, page: 0 }) },
          f.title,
        ),
      ),
    );
  body.append(
    table(
      heads,
      [...rows.slice(state.page * PAGE_ROWS, (state.page + 1) * PAGE_ROWS)].map((i) => ({
        cells: [
          make(
            'button',
            { type: 'button', id: `row-${number(i)}`, 'aria-label': `Details of point ${number(i)}`, onclick: () => set({ chosen: i }) },
            String(number(i)),
          ),
          ...fields.slice(1).map((f) => (f.text ? f.text(i) : figure(f.of(i), f.id.startsWith('m') ? digits : 12))),
        ],
        mark: front[i],
        chosen: i === state.chosen,
      })),
    ),
    bar,
  );
  const covers = head.covers.map((text, k) => text && `${head.texts[k]}: ${text}`).filter(Boolean);
  said(body, covers.length ? `How often intervals contain the mean: ${covers.join('; ')}.` : '');
  said(body, head.front.length ? `Coloured rows are on the Pareto front of ${head.front.map((m) => metrics[m]).join(', ')}.` : '');
}
