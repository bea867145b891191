// The page in Debian's Chromium, with all that the engine alone leaves out.
import { launchChromium } from './browsers.mjs';
import { journeys } from './journeys.mjs';

journeys(launchChromium);
