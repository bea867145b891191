// What loads after the first frame: dialogs, inspectors, the library of the curves.
import { inspectors } from '../core/inspector.js';
import { INSPECTORS } from '../inspectors/inspectors.js';
import { Chart } from '../views/chart.js';
import { dialogs, help } from './dialogs.js';
import { plotBy } from './side.js';

const sheet = document.createElement('link');
sheet.rel = 'stylesheet';
sheet.href = new URL('../../../../vendor/uplot.css', import.meta.url).href;
document.head.append(sheet);

plotBy(Chart);
inspectors.value = INSPECTORS;

/** @type {Partial<import('../../../session/lab.js').Lab>} */
export const rest = { dialogs, help, tables: () => import('./tables.js').then(({ tables }) => tables) };
