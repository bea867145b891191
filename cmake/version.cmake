# Writes OUTPUT, which defines ll_version: RELEASE and a fingerprint of the files that LIST names, a line each, below SOURCE;
# and ll_engine, a fingerprint of those of them that are in the engine's rooms.
# Run with cmake -DRELEASE=... -DSOURCE=... -DLIST=... -DOUTPUT=... -P version.cmake

file(STRINGS ${LIST} files)
include(${SOURCE}/cmake/engine_rooms.cmake)
list(JOIN engine_rooms "|" rooms)
set(all "")
set(of_engine "")
foreach(name IN LISTS files)
    file(SHA256 ${SOURCE}/${name} digest)
    string(APPEND all "${name} ${digest}\n")
    if(name MATCHES "^src/(${rooms})/")
        string(APPEND of_engine "${name} ${digest}\n")
    endif()
endforeach()
string(SHA256 fingerprint "${all}")
string(SUBSTRING ${fingerprint} 0 12 fingerprint)
string(SHA256 engine "${of_engine}")
string(SUBSTRING ${engine} 0 12 engine)
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[#include "base/version.h"

const char ll_version[] = "@RELEASE@+@fingerprint@";
const char ll_engine[] = "@engine@";
]] @ONLY)
