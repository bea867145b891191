// Colour maps that are even to the eye: paths through OKLab (Ottosson 2020), cut into 255 steps of one length.

/** @typedef {number[]} Colour  three numbers: lightness, a, b of OKLab */
/** @typedef {{even: Uint32Array, signed: Uint32Array, water: Uint32Array}} Maps  255 colours each, as an ImageData has them; signed: the
 * middle
 *   is nothing; water: from troughs to crests, of little contrast, since a relief adds light and shade */

const STEPS = 255;

/** Red, green and blue from 0 to 1 as far as they can be shown. @param {Colour} colour @returns {number[]} */
function shown([L = 0, a = 0, b = 0]) {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (L - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const linear = [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
  return linear.map((v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
}

const inside = (/** @type {Colour} */ colour) => shown(colour).every((v) => v > -0.002 && v < 1.002);

/** The colour of that lightness and hue, as colourful as asked for and as a screen allows.
 * @param {number} L @param {number} chroma @param {number} hue degrees @returns {Colour} */
function at(L, chroma, hue) {
  const angle = (hue * Math.PI) / 180;
  for (let c = chroma; c > 0; c -= 0.002) {
    const colour = [L, c * Math.cos(angle), c * Math.sin(angle)];
    if (inside(colour)) return colour;
  }
  return [L, 0, 0];
}

/** @param {Colour} from @param {Colour} to */
const apart = (from, to) => Math.hypot(...from.map((v, i) => v - (to[i] ?? 0)));

/** @param {number[]} from @param {number[]} to @param {number} share */
const between = (from, to, share) => from.map((v, i) => v + ((to[i] ?? 0) - v) * share);

/** Equal steps along a path of stops in lightness, chroma and hue. @param {number[][]} stops @param {number} count @returns {Colour[]} */
function even(stops, count) {
  const fine = Array.from({ length: 1025 }, (_, i) => {
    const along = (i / 1024) * (stops.length - 1),
      k = Math.min(stops.length - 2, Math.floor(along));
    const [L = 0, chroma = 0, hue = 0] = between(stops[k] ?? [], stops[k + 1] ?? [], along - k);
    return at(L, chroma, hue);
  });
  const far = [0];
  for (let i = 1; i < fine.length; i++) far.push((far[i - 1] ?? 0) + apart(fine[i - 1] ?? [], fine[i] ?? []));
  const whole = far[far.length - 1] ?? 1;
  return Array.from({ length: count }, (_, i) => {
    const wanted = (i / (count - 1)) * whole;
    const k = Math.max(
      1,
      far.findIndex((v) => v >= wanted),
    );
    const low = far[k - 1] ?? 0,
      high = far[k] ?? 1;
    return between(fine[k - 1] ?? [], fine[k] ?? [], high > low ? (wanted - low) / (high - low) : 0);
  });
}

/** @param {Colour[]} path @returns {Uint32Array} */
function packed(path) {
  return Uint32Array.from(path, (colour) => {
    const [r = 0, g = 0, b = 0] = shown(colour).map((v) => Math.max(0, Math.min(255, Math.round(255 * v))));
    return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
  });
}

const WATER = [
  [0.36, 0.08, 258],
  [0.52, 0.1, 240],
  [0.7, 0.09, 215],
  [0.9, 0.045, 195],
];

/** No value has the colour of the paper; large values contrast most. */
const STOPS = {
  light: {
    even: [
      [0.97, 0.01, 190],
      [0.83, 0.09, 195],
      [0.66, 0.13, 230],
      [0.47, 0.16, 265],
      [0.26, 0.13, 290],
    ],
    less: [
      [0.97, 0, 250],
      [0.7, 0.12, 250],
      [0.42, 0.14, 258],
    ],
    more: [
      [0.97, 0, 50],
      [0.7, 0.13, 52],
      [0.42, 0.13, 40],
    ],
  },
  dark: {
    even: [
      [0.19, 0.02, 270],
      [0.38, 0.13, 280],
      [0.57, 0.14, 245],
      [0.77, 0.13, 185],
      [0.96, 0.12, 110],
    ],
    less: [
      [0.2, 0, 250],
      [0.5, 0.14, 250],
      [0.82, 0.1, 225],
    ],
    more: [
      [0.2, 0, 50],
      [0.5, 0.14, 45],
      [0.82, 0.13, 75],
    ],
  },
};

/** @type {Map<boolean, Maps>} */
const made = new Map();

/** @param {boolean} dark @returns {Maps} */
export function mapsOf(dark) {
  const known = made.get(dark);
  if (known) return known;
  const stops = dark ? STOPS.dark : STOPS.light;
  const less = even(stops.less, (STEPS + 1) / 2),
    more = even(stops.more, (STEPS + 1) / 2);
  const maps = {
    even: packed(even(stops.even, STEPS)),
    signed: packed([...less.reverse(), ...more.slice(1)]),
    water: packed(even(WATER, STEPS)),
  };
  made.set(dark, maps);
  return maps;
}

/** Whether a colour of the style sheet is dark. @param {string} hex such as #101418 or #fff */
export function isDark(hex) {
  const digits = hex.length === 4 ? [...hex.slice(1)].map((c) => c + c) : [hex.slice(1, 3), hex.slice(3, 5), hex.slice(5, 7)];
  return digits.reduce((sum, two) => sum + parseInt(two, 16), 0) < 384;
}

/** @param {number} packed @returns {string} for a canvas */
export const css = (packed) => `rgb(${packed & 255} ${(packed >> 8) & 255} ${(packed >> 16) & 255})`;
