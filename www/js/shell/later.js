// Modules that load after the first frame: dialogs, inspectors, the library of the curves.
import * as dialogs from './dialogs.js';
import { INSPECTORS } from '../labs/netgame/inspectors/inspectors.js';
import { plotBy } from '../labs/netgame/lab/side.js';
import { inspectors } from '../session/state.js';
import { Chart } from '../labs/netgame/views/chart.js';

const sheet = document.createElement('link');
sheet.rel = 'stylesheet';
sheet.href = new URL('../../vendor/uplot.css', import.meta.url).href;
document.head.append(sheet);

dialogs.listen();
plotBy(Chart);
inspectors.value = INSPECTORS;
