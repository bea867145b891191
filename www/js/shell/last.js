// What is used later: the dialogs, and the buttons that save images and data.
import * as buttons from '../takeaway/buttons.js';
import * as dialogs from './dialogs.js';

dialogs.listen();
buttons.listen();
