// The lessons: a list of questions, and each with its steps next to a lab. What the rest of the page uses of them.
import { effect } from '../../vendor/signals-core.js';
import { lesson } from '../session/state.js';
import { choice, choose, listen, opened } from './steps.js';
import { language, word } from './words.js';

export { light } from './controls.js';
export { door } from './door.js';
export { caption, page } from './rail.js';

/** Keys 1 to 5 choose an answer. @param {KeyboardEvent} event @returns {boolean} whether it was one */
export function press(event) {
  const now = opened.value,
    number = /^(?:Digit|Numpad)([1-5])$/.exec(event.code)?.[1];
  if (now === null || number === undefined || lesson.value?.step !== 1) return false;
  if (event.altKey || event.ctrlKey || event.metaKey || event.shiftKey) return false;
  const at = event.target instanceof HTMLElement ? event.target : null;
  if (at?.closest('dialog, select, textarea, input:not([type="radio"])')) return false;
  const index = Number(number) - 1;
  if (index >= now.choices.length) return false;
  choose(index);
  /** @type {HTMLElement | null} */ (document.querySelector(`.option input[value="${index}"]`))?.focus();
  return choice.value === index;
}

effect(() => {
  if (lesson.value === null) return;
  document.title = word('session.title', { name: opened.value?.title[language.value] ?? word('shell.questions') });
});
listen();
