/* Version of laglab: its release, and a fingerprint of all its sources and library scenarios, as
 * 0.2.0+3f2a9c1b4d5e. Builds of one version give the same results; those of different versions may not. */
#pragma once

enum { LL_VERSION_MAX = 40 };

extern const char ll_version[];

/* The engine alone, 12 hexadecimal digits: a fingerprint of the sources of the rooms of
 * cmake/engine_rooms.cmake, whose functions a session's states are. Builds that differ in the daemon, the
 * page or the command line only have the same one, and continue each other's sessions. */
extern const char ll_engine[];
