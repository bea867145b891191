// What loads after the first frame: the rest of the lab; and when that is done, or a dialog is asked for, what is used later.
import { effect } from '../../vendor/signals-core.js';
import { part } from '../base/api.js';
import { prepare } from '../base/messages.js';
import { complete } from '../session/labs.js';
import { dialog } from '../workbench/dialog.js';

const REST_MS = 1500;

complete();
prepare();
let asked = false;
const stop = effect(() => {
  if (dialog.value !== null) read();
});
setTimeout(read, REST_MS);

function read() {
  if (asked) return;
  asked = true;
  queueMicrotask(() => stop());
  part(() => import('./last.js'));
}
