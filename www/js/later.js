// What no first picture waits for: dialogs, the closer looks, the library of the curves.
import * as dialogs from './dialogs.js';
import { LENSES } from './lenses/lenses.js';
import { plotBy } from './side.js';
import { lenses } from './state.js';
import { Chart } from './views/chart.js';

const sheet = document.createElement('link');
sheet.rel = 'stylesheet';
sheet.href = new URL('../vendor/uplot.css', import.meta.url).href;
document.head.append(sheet);

dialogs.listen();
plotBy(Chart);
lenses.value = LENSES;
