/* Which laglab this is: its release, and a fingerprint of the sources that rows depend on (the engine's rooms
 * and experiment/), as 0.1.0+3f2a9c1b4d5e. Builds of one version give the same rows; of two others need not.
 */
#pragma once

enum { LL_VERSION_MAX = 40 };

extern const char ll_version[];
