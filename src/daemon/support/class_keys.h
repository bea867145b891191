/* Class keys, which permit creating: one without a name, or several with names and quotas of their own.
 *
 * A file of one line without a space is a key. Any other file has a line for each key, `NAME KEY` and its
 * quotas (`sessions=40`); empty lines and those that begin with # do not count. What a client creates with a
 * named key counts against the key's quotas in place of the address's. A quota that is not given is no limit.
 *
 * Only salted hashes are kept. Every key is compared in constant time, and always all of them. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "daemon/support/keys.h"

enum { LL_CLASS_KEYS_MAX = 256, LL_KEY_NAME_MAX = 32 };

typedef enum ll_key_quota {
    LL_KEY_CLASSES, /* open at once */
    LL_KEY_SESSIONS,
    LL_KEY_EXPERIMENTS,
    LL_KEY_LOGS,               /* bytes; MiB in the file */
    LL_KEY_USES,               /* those above are used up, and become free again */
    LL_KEY_RATE = LL_KEY_USES, /* new sessions, 1/min */
    LL_KEY_QUOTAS
} ll_key_quota;

extern const char *const ll_key_quota_names[LL_KEY_QUOTAS]; /* in the file */

typedef struct ll_class_key {
    char name[LL_KEY_NAME_MAX + 1]; /* empty: it has none, and no quotas */
    ll_key_hash hash;
    int64_t most[LL_KEY_QUOTAS];       /* -1: no limit */
    _Atomic int64_t used[LL_KEY_USES]; /* with a store that daemons share: by all, as last counted */
    _Atomic uint64_t refused;          /* requests, by a quota */
} ll_class_key;

typedef struct ll_class_keys {
    ll_class_key *keys; /* owned */
    int count;
} ll_class_keys;

/* `from` names the text in messages, which also name the line and never contain a key. The text is changed.
 * LL_BAD_INPUT. */
ll_status ll_class_keys_read(ll_class_keys *keys, const char *from, char *text);
void ll_class_keys_free(ll_class_keys *keys);

ll_class_key *ll_class_keys_find(const ll_class_keys *keys, const char *key, size_t length); /* NULL: none */
ll_class_key *ll_class_keys_named(const ll_class_keys *keys, const char *name);              /* NULL: none */

/* "north, south"; "..." for those that do not fit. Empty: there are no names. */
void ll_class_keys_list(const ll_class_keys *keys, char *text, size_t size);

/* Takes one of a quota, unless all are used: for counts of this daemon alone. */
bool ll_class_key_take(ll_class_key *key, ll_key_quota quota);
bool ll_class_key_is_full(const ll_class_key *key, ll_key_quota quota);

/* Checks one key of a file: visible ASCII of `shortest` characters or more. `from` begins the message. */
ll_status ll_key_check(const char *from, const char *text, size_t shortest);
