// Elements of the page, and what controls share.
/** @param {string} tag @param {Record<string, any>} [wish] @param {...any} inside @returns {any} */
function make(tag, wish = {}, ...inside) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(wish))
    if (key.startsWith('on')) element.addEventListener(key.slice(2), value);
    else if (value === true) element.setAttribute(key, '');
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(key, value);
  element.append(...inside.filter((item) => item !== null && item !== undefined));
  return element;
}

function picker(label, id, options, value, take) {
  const select = make('select', { id, onchange: () => take(Number(select.value)) });
  for (const [key, text] of options) select.append(make('option', { value: key, selected: key === value }, text));
  return make('label', {}, label, select);
}

function flag(label, id, value, take) {
  const box = make('input', { type: 'checkbox', id, checked: value, onchange: () => take(box.checked) });
  return make('label', { class: 'flag' }, box, label);
}

function field(label, id, type, value, take, wish = {}) {
  const input = make('input', { type, id, value, step: 'any', ...wish, onchange: () => take(input.value) });
  return make('label', {}, label, input);
}

const set = (changes) => {
  Object.assign(state, changes);
  render();
};

const metricPicker = (label, key) =>
  picker(
    label,
    `pick-${key}`,
    metrics.map((name, m) => [m, name]),
    state[key],
    (value) => set({ [key]: value, logX: null, logY: null, page: 0 }),
  );

const dimensionPicker = (label, key, list, none) =>
  picker(label, `pick-${key}`, [...(none ? [[-1, none]] : []), ...list.map((d) => [d, dimensions[d].title])], state[key], (value) =>
    set({ [key]: value, logX: null, box: -1, page: 0 }),
  );
