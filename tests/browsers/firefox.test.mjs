// The page in Debian's Firefox.
import { launchFirefox, missingFirefox } from './browsers.mjs';
import { journeys } from './journeys.mjs';

journeys(launchFirefox, missingFirefox());
