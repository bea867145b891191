// An address as a QR code: dark on white in every theme, with the quiet zone of four modules that readers need.
import { html, nothing } from '../../vendor/lit-html.js';
import { generate } from '../../vendor/lean-qr.js';
import { t } from '../base/words.js';

const QUIET = 4;

/** @param {string} text @returns {string} the dark modules as the data of a path, one unit each */
export function modules(text) {
  const code = generate(text);
  let path = '';
  for (let y = 0; y < code.size; y++) for (let x = 0; x < code.size; x++) if (code.get(x, y)) path += `M${x + QUIET} ${y + QUIET}h1v1h-1z`;
  return path;
}

/** @param {string} text */
export function qr(text) {
  if (text === '') return nothing;
  const side = generate(text).size + 2 * QUIET;
  return html`<svg class="qr" viewBox=${`0 0 ${side} ${side}`} role="img" aria-label=${t('workbench.qr', { address: text })}
    shape-rendering="crispEdges"><path fill="#fff" d=${`M0 0h${side}v${side}H0z`}></path><path
    fill="#101418" d=${modules(text)}></path></svg>`;
}
