/* Which laglab this is: its release, and a fingerprint of everything that it is built from and of the
 * scenarios that it names, as 0.1.0+3f2a9c1b4d5e. Builds of one version give the same rows; of two others
 * need not. */
#pragma once

enum { LL_VERSION_MAX = 40 };

extern const char ll_version[];
