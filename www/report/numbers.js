// Numbers as text.
const digits = head.planes <= 3 ? 4 : 6;

function figure(x, precision = digits) {
  if (x === null || x === undefined || !Number.isFinite(x)) return '–';
  const size = Math.abs(x);
  if (size !== 0 && (size < 1e-4 || size >= 1e9))
    return x
      .toExponential(precision - 1)
      .replace(/\.?0+e/, 'e')
      .replace('-', '−')
      .replace('e+', 'e');
  const text = String(Number(x.toPrecision(size >= 1e6 ? Math.max(precision, 9) : precision)));
  return text.replace('-', '−');
}

const counted = (n) => Math.round(n).toLocaleString('en');

/** Of sorted values, interpolated (Hyndman and Fan's type 7), as in the engine. */
function quantile(sorted, p) {
  const at = (sorted.length - 1) * p,
    k = Math.floor(at);
  return k + 1 < sorted.length ? sorted[k] + (at - k) * (sorted[k + 1] - sorted[k]) : sorted[sorted.length - 1];
}

function range(values) {
  let low = Infinity,
    high = -Infinity;
  for (const v of values)
    if (Number.isFinite(v)) {
      if (v < low) low = v;
      if (v > high) high = v;
    }
  return [low, high];
}
