// Asks for the class key, which some daemons require for creating sessions. Loaded when required.
import { t } from './words.js';

/** @param {string} tag @param {Record<string, string>} [attributes] @param {(string | Node)[]} [inside] @returns {HTMLElement} */
function element(tag, attributes = {}, inside = []) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...inside);
  return made;
}

/** @param {boolean} wrong whether the one before was refused @returns {Promise<string>} empty when none is given */
function ask(wrong) {
  const input = /** @type {HTMLInputElement} */ (
    element('input', {
      id: 'class-key',
      type: 'password',
      autocomplete: 'off',
      autocapitalize: 'off',
      spellcheck: 'false',
      required: '',
      ...(wrong ? { 'aria-invalid': 'true', 'aria-describedby': 'class-key-told' } : {}),
    })
  );
  const text = wrong ? t('base.key_wrong') : t('base.key_where');
  const cancel = element('button', { type: 'button' }, [t('base.cancel')]);
  const form = element('form', { method: 'dialog', class: 'body' }, [
    element('p', {}, [t('base.key_why')]),
    element('label', { class: 'address', for: 'class-key' }, [element('span', {}, [t('base.key')]), input]),
    element('p', { id: 'class-key-told', role: 'status', ...(wrong ? { class: 'reason' } : {}) }, [text]),
    element('div', { class: 'choices' }, [cancel, element('button', { class: 'main' }, [t('base.continue')])]),
  ]);
  const dialog = /** @type {HTMLDialogElement} */ (
    element('dialog', { class: 'small', 'aria-labelledby': 'class-key-title' }, [
      element('header', {}, [element('h2', { id: 'class-key-title' }, [t('base.key')])]),
      form,
    ])
  );
  return new Promise((resolve) => {
    let given = '';
    form.addEventListener('submit', () => {
      given = input.value.trim();
    });
    cancel.addEventListener('click', () => dialog.close());
    dialog.addEventListener('keydown', (event) => event.stopPropagation()); // no shortcuts of the page
    dialog.addEventListener('close', () => {
      dialog.remove();
      resolve(given);
    });
    document.body.append(dialog);
    dialog.showModal();
    input.focus();
  });
}

/** @type {Promise<unknown>} */
let last = Promise.resolve();

/** Asks until `use` takes what is given, or the person gives none; several requests are asked one after the other.
 * @template T @param {(key: string) => Promise<T>} use @param {(error: unknown) => boolean} refused whether `use` failed by the key
 * @param {boolean} wrong whether a key that was kept is refused @param {unknown} none what is thrown when none is given
 * @returns {Promise<T>} */
export function withKey(use, refused, wrong, none) {
  const asked = last.then(async () => {
    for (let again = wrong; ; again = true) {
      const key = await ask(again);
      if (!key) throw none;
      try {
        return await use(key);
      } catch (error) {
        if (!refused(error)) throw error;
      }
    }
  });
  last = asked.catch(() => {});
  return asked;
}
