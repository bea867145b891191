// The buttons next to a view or a chart: save its image, save its data. What they do is read when the first is pressed.
import { html, nothing, render } from '../../vendor/lit-html.js';
import { part } from '../base/api.js';
import { t } from '../base/words.js';

const ICONS = {
  image: 'M3 4h18v16H3zM5 6v9l4-4 4 4 2-2 4 4V6zM15 8h2v2h-2z',
  data: 'M3 4h18v16H3zM5 9v3h4V9zM11 9v3h8V9zM5 14v4h4v-4zM11 14v4h8v-4z',
};

/** `<take-away name="Error over time" of="ID" data="ID">`: name says what is saved; of: the box with its canvas, where that is not the
 * parent; data: there is a table too, of that name where it is not the canvas's id. */
class TakeAway extends HTMLElement {
  static observedAttributes = ['name'];

  connectedCallback() {
    this.show();
    /* a drawing around it is dragged, or has keys of its own */
    this.addEventListener('pointerdown', (event) => event.stopPropagation());
    this.addEventListener('keydown', (event) => {
      if (event.key === 'Enter') event.stopPropagation();
    });
  }

  attributeChangedCallback() {
    if (this.isConnected) this.show();
  }

  get source() {
    const of = this.getAttribute('of');
    return of === null ? this.parentElement : document.getElementById(of);
  }

  /** @returns {HTMLCanvasElement | null} */
  get canvas() {
    return this.source instanceof HTMLCanvasElement ? this.source : (this.source?.querySelector('canvas') ?? null);
  }

  show() {
    const name = this.getAttribute('name') ?? '';
    const button = (/** @type {'image' | 'data'} */ what, /** @type {string} */ text) => html`<button type="button" class="take"
      data-take=${what} aria-label=${text} title=${text} @click=${() => this.save(what)}><svg class="icon" viewBox="0 0 24 24"
      aria-hidden="true" focusable="false"><path fill-rule="evenodd" d=${ICONS[what]}></path></svg></button>`;
    const drawn = this.hasAttribute('of') || this.canvas;
    const image = drawn ? button('image', t('takeaway.save_image', { name })) : nothing,
      data = this.hasAttribute('data') ? button('data', t('takeaway.save_data', { name })) : nothing;
    render(html`${image}${data}`, this);
  }

  /** @param {'image' | 'data'} what */
  async save(what) {
    const of = {
      name: this.getAttribute('name') ?? '',
      canvas: this.canvas,
      table: this.getAttribute('data'),
    };
    const { saveData, saveImage } = await part(() => import('./save.js'));
    await (what === 'image' ? saveImage(of) : saveData(of));
  }
}

export const listen = () => customElements.define('take-away', TakeAway);
