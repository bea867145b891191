/* Version of laglab: its release, and a fingerprint of all its sources and library scenarios, as
 * 0.2.0+3f2a9c1b4d5e. Builds of one version give the same results; those of different versions may not. */
#pragma once

enum { LL_VERSION_MAX = 40 };

extern const char ll_version[];
