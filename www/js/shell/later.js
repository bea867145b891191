// What loads after the first frame: the dialogs, and the rest of the lab.
import { complete } from '../session/labs.js';
import * as dialogs from './dialogs.js';

dialogs.listen();
complete();
