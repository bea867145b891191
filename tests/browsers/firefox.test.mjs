// The page in Debian's Firefox.
import { launchFirefox, missingFirefox } from './browsers.mjs';
import { journeys } from './journeys.mjs';

journeys(launchFirefox, { size: { width: 820, height: 1180 }, lang: 'de' }, missingFirefox());
