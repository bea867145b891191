/* Sessions and classes of a folder, copied into a store that daemons share: for who began with one daemon. */
#pragma once

#include <stdint.h>

#include "base/status.h"

typedef struct ll_imported {
    int64_t sessions, lines, bytes; /* bytes: of the lines */
    int64_t classes;
    int64_t boards;   /* classes whose board was made for itself: they have none any more */
    int64_t left_out; /* sessions without a log or a key, which a daemon of the folder leaves out too */
} ll_imported;

/* Copies all of them, or nothing. Names, keys, codes, clocks, logs and the time since the last use stay; they
 * have no owner, and are of this build's engine. The folder stays as it is. LL_IO: a daemon uses it, or it
 * cannot be read. LL_NOT_FOUND: it has no database. LL_CONFLICT: the message names a session, a class or a
 * code that is in the store already. */
ll_status ll_store_import(const char *directory, const char *url, ll_imported *imported);
