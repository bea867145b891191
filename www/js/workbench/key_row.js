// A key and what it does, in a table of the help.
import { html } from '../../vendor/lit-html.js';

/** @param {{shown: string, help: string}} key */
export const keyRow = ({ shown, help }) => html`<tr><th scope="row"><kbd>${shown}</kbd></th><td>${help}</td></tr>`;
