// Colours, columns of numbers, ticks, and the values of curves.

const root = document.documentElement;
const DASHES = { dash: [7, 4], dot: [2, 3], dashdot: [7, 3, 2, 3] };
// Of the parts of a curve's time, so many of the highest may lie beyond the axis if they dwarf the rest.
const PARTS = 240;
const PARTS_BEYOND = 6;
let colors = {};
let zoomed = null;

function color(name) {
  if (!(name in colors)) colors[name] = getComputedStyle(root).getPropertyValue('--' + name).trim() || name;
  return colors[name];
}

function column(given) {
  if (Array.isArray(given)) return Float64Array.from(given, (value) => (value === null ? NaN : value));
  const text = atob(given.u16 || given.f32);
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  if (given.f32) return new Float32Array(bytes.buffer);
  return Float64Array.from(new Uint16Array(bytes.buffer), (value) => given.from + value * given.step);
}

function ticks(low, high, most) {
  const least = (high - low) / Math.max(most, 1);
  if (!(least > 0)) return { values: [low], show: String };
  const power = Math.pow(10, Math.floor(Math.log10(least)));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= least * 0.999);
  const values = [];
  for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; k++) values.push(k * step);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const plain = decimals <= 5 && Math.max(Math.abs(low), Math.abs(high)) < 1e6;
  return { values, show: (value) => (plain ? value.toFixed(decimals) : value.toExponential(1)).replace('-', '−') };
}

// A threshold or a limit: constant over the whole run.
function isLevel({ x, y }) {
  return x.length === 2 && y[0] === y[1];
}

// Where the last value lies that is not later; the columns of curves over time rise.
function before(x, t) {
  let low = 0;
  let high = x.length - 1;
  if (high < 0 || t < x[0]) return -1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (x[middle] <= t) low = middle; else high = middle - 1;
  }
  return low;
}

// The value of a curve over time at an instant.
function valueAt(curve, t) {
  const k = before(curve.x, t);
  if (k < 0 || t > curve.x[curve.x.length - 1] + 1e-9) return NaN;
  const next = Math.min(k + 1, curve.x.length - 1);
  const span = curve.x[next] - curve.x[k];
  if (curve.kind === 'steps' || !(span > 0)) return curve.own[k];
  return curve.own[k] + (curve.own[next] - curve.own[k]) * (t - curve.x[k]) / span;
}

function readable(value) {
  if (!Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  const text = size >= 1000 ? value.toFixed(0) : size >= 100 ? value.toFixed(1) : size >= 1 ? value.toFixed(2)
    : size >= 0.001 || size === 0 ? value.toFixed(4) : size < 1e-6 ? '0' : value.toExponential(1);
  return text.replace('-', '−');
}
