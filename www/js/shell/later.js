// What loads after the first frame: the rest of the lab; and a little later, or when a dialog is asked for, what is used later: the
// dialogs, and the buttons that save images and data.
import { effect } from '../../vendor/signals-core.js';
import { prepare } from '../base/messages.js';
import { complete } from '../session/labs.js';
import * as buttons from '../takeaway/buttons.js';
import { dialog } from '../workbench/dialog.js';
import * as dialogs from './dialogs.js';

const REST_MS = 1500;

complete();
prepare();
let listening = false;
const stop = effect(() => {
  if (dialog.value !== null) listen();
});
setTimeout(listen, REST_MS);

function listen() {
  if (listening) return;
  listening = true;
  queueMicrotask(() => stop());
  dialogs.listen();
  buttons.listen();
}
