// Grid lines.

/** A round step for grid lines about `wanted` px apart. @param {number} perMetre @param {number} wanted @returns {number} */
export function gridStep(perMetre, wanted) {
  const raw = wanted / perMetre;
  const power = 10 ** Math.floor(Math.log10(raw));
  const lead = raw / power;
  return (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10) * power;
}
