// The page in WebKit, which is the only engine of tablets and phones of one maker.
import { launchWebKit, missingWebKit } from './browsers.mjs';
import { journeys } from './journeys.mjs';

journeys(launchWebKit, { size: { width: 1600, height: 900 }, lang: 'en' }, missingWebKit());
