// A lesson on paper: two A4 pages, the pupils' sheet and the teacher's. Read when it is to be printed.
import { html, nothing, render } from '../../vendor/lit-html.js';
import { call, styleSheet } from '../base/api.js';
import { writeLesson } from '../base/link.js';
import { frame, layout, lesson, notify, session, theme } from '../session/state.js';
import { touch } from '../draw/redraw.js';
import { qr } from '../workbench/qr.js';
import { STEPS, drawn, go, opened, printing, startOf, textOf } from './steps.js';
import { amount, filled, language, word } from './words.js';

/** @typedef {import('lit-html').TemplateResult} Template */
/** @typedef {import('./steps.js').Lesson} Lesson */
/** @typedef {{text: string, ratio: number}} Image  text: as an address of data; ratio: width over height */

const styled = styleSheet('paper');

const CHANGE = STEPS.length;

/** What the lab's views show; the plots where it has no other. @returns {Image[]} */
function imagesNow() {
  const all = [...document.querySelectorAll('.teach > main canvas[role="img"]')].filter(
    (canvas) => canvas instanceof HTMLCanvasElement && canvas.clientWidth > 40 && canvas.clientHeight > 20,
  );
  const shown = ['0', String((opened.value?.look.player ?? 0) + 1)]; /* of a netgame's views: the server's and the one that is shown */
  const views = all.filter(
    (canvas) =>
      canvas.closest('.plotbox') === null &&
      (!(canvas instanceof HTMLCanvasElement) || canvas.dataset.view === undefined || shown.includes(canvas.dataset.view)),
  );
  return /** @type {HTMLCanvasElement[]} */ (views.length > 0 ? views : all).map((canvas) => ({
    text: canvas.toDataURL(),
    ratio: canvas.width / canvas.height,
  }));
}

/** Goes to a tick, also while time is held, and gives the images of it. @param {number} tick @returns {Promise<Image[]>} */
async function imagesAt(tick) {
  const now = session.value;
  if (now === null) return [];
  if (frame.value?.tick !== tick) {
    await call('POST', `sessions/${now.id}/control`, { body: { op: 'seek', tick }, key: now.key });
    await drawn(tick);
  }
  touch();
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  return imagesNow();
}

/** @param {Image[]} list @param {string} caption @returns {Template | typeof nothing} */
function figure(list, caption) {
  if (list.length === 0) return nothing;
  const below = layout.value?.kind === 'netgame';
  return html`<figure class=${below ? 'below' : 'beside'}><div>${list.map((one) => html`<img alt="" src=${one.text}>`)}</div>
    <figcaption>${caption}</figcaption></figure>`;
}

/** Where others find the lesson: none of their devices reaches a loopback address. @param {Lesson} of */
function addressOf(of) {
  if (/^(localhost|127\.|\[::1\])/.test(location.hostname)) return '';
  return `${location.origin}${location.pathname}${writeLesson({ id: of.id, step: 1, lang: language.value })}`;
}

/** @param {Lesson} of @param {number} page @param {string} version @returns {Template} */
const foot = (of, page, version) =>
  html`<footer><span>${addressOf(of) || word('paper.address')}</span>
    <span>${word('paper.seed', { seed: of.seed })} · ${version} · ${page}/2</span></footer>`;

/** @param {Lesson} of @param {import('./steps.js').Choice} one @returns {string} */
const labelOf = (of, one) => one.label?.[language.value] ?? amount(one.value, of.answer.unit);

/** @param {Lesson} of @param {Image[]} images @param {string} version @returns {Template} */
function pupils(of, images, version) {
  const at = addressOf(of),
    toFill = (/** @type {string} */ name) => html`<tr><td>${name}</td><td></td><td></td></tr>`;
  return html`<section class="a4"><header><div><p class="name">laglab · ${word('paper.name')} <i></i> ${word('paper.date')} <i></i></p>
      <h1>${of.title[language.value]}</h1><p class="ask">${textOf(of, 1)}</p></div>${at === '' ? nothing : qr(at)}</header>
    <h2>${word('steps.predict')}</h2><ul class="boxes">${of.choices.map((one) => html`<li><b></b>${labelOf(of, one)}</li>`)}</ul>
    <p class="because">${word('paper.because')}</p><hr><hr>
    ${figure(images, word('paper.start'))}
    <h2>${word('steps.observe')}</h2><hr><hr>
    <table><thead><tr><th>${word('paper.setting')}</th><th>${word('paper.predicted')}</th><th>${word('paper.seen')}</th></tr></thead>
      <tbody>${[word('paper.first'), word('steps.change'), '', ''].map(toFill)}</tbody></table>
    <h2>${word('steps.explain')}</h2><hr><hr><hr>
    ${foot(of, 1, version)}</section>`;
}

/** @param {Lesson} of @param {Image[]} images @param {string} version @returns {Template} */
function teachers(of, images, version) {
  const right = of.choices.find((one) => one.right),
    answer = `${right?.label ? `${right.label[language.value]}: ` : ''}${amount(of.answer.value, of.answer.unit)}`;
  const hooks = of.hooks.map((hook) => word(`hooks.${hook}`)).join(', '),
    amountOf = (/** @type {import('./steps.js').Answer} */ one) => amount(one.value, one.unit);
  return html`<section class="a4 teacher"><header><div>
      <p class="name">laglab · ${word('paper.teacher')}</p><h1>${of.title[language.value]}</h1>
      <p>${word('minutes')}: ${of.minutes} · ${word('age')}: ${of.age} · ${hooks}</p></div></header>
    <p class="answer">${word('paper.answer')} <b>${answer}</b></p>
    ${figure(images, word('paper.stop', { tick: of.stop_tick }))}
    <h2>${word('steps.observe')}</h2><p>${textOf(of, 3)}</p>
    <h2>${word('steps.explain')}</h2><p>${textOf(of, 4)}</p>
    ${of.erratum ? html`<p><b>${word('erratum')}</b> ${filled(of.erratum, of.numbers)}</p>` : nothing}
    <h2>${word('paper.choices')}</h2><table><tbody>${of.choices.map(
      (one) =>
        html`<tr class=${one.right ? 'right' : ''}><th>${one.right ? '✓ ' : ''}${labelOf(of, one)}</th>
          <td>${filled(one.why, of.numbers)}</td></tr>`,
    )}</tbody></table>
    <h2>${word('steps.change')}</h2><p>${textOf(of, CHANGE)}</p>
    <p>${word('change.before')}: <b>${amountOf(of.answer)}</b> · ${word('change.after')}: <b>${amountOf(of.change.answer)}</b></p>
    ${
      of.misconceptions.length === 0
        ? nothing
        : html`<h2>${word('misconceptions')}</h2><ul>${of.misconceptions.map((text) => html`<li>${text[language.value]}</li>`)}</ul>`
    }
    ${foot(of, 2, version)}</section>`;
}

/** The version of the daemon, from the first line of the session's log. */
async function versionNow() {
  const { versionOf } = await import('../workbench/version.js');
  return `laglab ${await versionOf(session.value?.id ?? '')}`;
}

const box = document.createElement('div');
box.id = 'paper';

/** Shows the sheets, and asks the browser to print them. */
export async function print() {
  const of = opened.value;
  if (of === null || printing.value) return;
  const colours = theme.value;
  printing.value = true;
  try {
    if (lesson.value?.step === CHANGE) await go(CHANGE - 1); /* the images are of the run without the change */
    const tick = frame.value?.tick ?? 0;
    theme.value = 'light';
    const version = versionNow();
    const [before, told] = [await imagesAt(startOf(of)), await imagesAt(of.stop_tick)];
    await Promise.all([styled, imagesAt(tick)]);
    box.lang = language.value;
    render(html`${pupils(of, before, await version)}${teachers(of, told, await version)}`, box);
    document.body.append(box);
    await Promise.all([...box.querySelectorAll('img')].map((image) => image.decode()));
  } catch (error) {
    notify(`${word('paper.failed')}: ${error instanceof Error ? error.message : ''}`);
    return;
  } finally {
    theme.value = colours;
    printing.value = false;
  }
  window.print();
}
