# Writes OUTPUT, which defines ll_version: RELEASE and a fingerprint of the files that LIST names, a line each, below SOURCE.
# Run with cmake -DRELEASE=... -DSOURCE=... -DLIST=... -DOUTPUT=... -P version.cmake

file(STRINGS ${LIST} files)
set(all "")
foreach(name IN LISTS files)
    file(SHA256 ${SOURCE}/${name} digest)
    string(APPEND all "${name} ${digest}\n")
endforeach()
string(SHA256 fingerprint "${all}")
string(SUBSTRING ${fingerprint} 0 12 fingerprint)
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[#include "base/version.h"

const char ll_version[] = "@RELEASE@+@fingerprint@";
]] @ONLY)
