// The page in Debian's Chromium, with all that the engine alone leaves out.
import { launchChromium } from './browsers.mjs';
import { journeys } from './journeys.mjs';

journeys(launchChromium, { size: { width: 1024, height: 768 }, lang: 'en' });
