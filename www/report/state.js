// What is chosen, and the points that it leaves.
const state = {
  view: 'series',
  metric: 0,
  cost: 0,
  x: 0,
  y: 0,
  by: 0,
  colour: -1,
  logX: null,
  logY: null,
  only: {},
  low: '',
  high: '',
  dimension: 0,
  from: 0,
  of: 1,
  page: 0,
  sort: '',
  down: false,
  find: '',
  chosen: -1,
  box: -1,
  site: '',
};
const titles = {
  series: 'Series',
  scatter: 'Metric against metric',
  heat: 'Heat map',
  spread: 'Distribution',
  differences: 'Differences',
  table: 'Points',
};

/** Numbers of rows that the filter lets through. */
let shown = new Uint32Array(0);

function passes(d, wish, i) {
  if (d.size) return d.index[i] === wish;
  return !(d.value[i] < wish[0]) && !(d.value[i] > wish[1]);
}

function choose() {
  const wishes = Object.entries(state.only).map(([d, wish]) => [dimensions[d], wish]),
    values = column(state.metric, 'mean'),
    low = state.low === '' ? -Infinity : Number(state.low),
    high = state.high === '' ? Infinity : Number(state.high),
    bounded = state.low !== '' || state.high !== '',
    list = [];
  for (let i = 0; i < count; i++) {
    let fits = !bounded || (values[i] >= low && values[i] <= high);
    for (let k = 0; k < wishes.length && fits; k++) fits = passes(wishes[k][0], wishes[k][1], i);
    if (fits) list.push(i);
  }
  shown = Uint32Array.from(list);
}

/** The address keeps what was chosen. */
function remember() {
  try {
    history.replaceState(null, '', `#${encodeURIComponent(JSON.stringify({ ...state, chosen: -1 }))}`);
  } catch {
    /* pages in a sandbox have no address of their own */
  }
}

function recall() {
  try {
    const kept = JSON.parse(decodeURIComponent(location.hash.slice(1)));
    const index = (value, size) => Number.isInteger(value) && value >= 0 && value < size;
    for (const key of Object.keys(state))
      if (typeof kept[key] === typeof state[key] || state[key] === null) state[key] = kept[key] ?? state[key];
    if (!titles[state.view]) state.view = 'series';
    for (const key of ['metric', 'cost']) if (!index(state[key], metrics.length)) state[key] = 0;
    for (const key of ['x', 'y', 'by', 'dimension']) if (!index(state[key], dimensions.length)) state[key] = 0;
    for (const d of Object.keys(state.only))
      if (!dimensions[d] || (dimensions[d].size ? !index(state.only[d], dimensions[d].size) : !Array.isArray(state.only[d])))
        delete state.only[d];
  } catch {
    /* no address, or one of another page */
  }
}
