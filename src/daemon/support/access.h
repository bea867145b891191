/* Permissions: the operator's key (may list and delete everything and close creation) and class keys (may
 * create: class_keys.h). Without keys a daemon is open: every client may create, and there is no operator.
 *
 * Keys come from files or from the environment (LAGLAB_OPERATOR_KEY, LAGLAB_CLASS_KEY), which is cleared
 * after reading. Only salted hashes are kept, and compared in constant time. Any thread. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>

#include "base/status.h"
#include "daemon/support/class_keys.h"
#include "daemon/support/keys.h"
#include "param/param.h"

/* Who may create sessions, forks, experiments and searches for advice. */
typedef enum ll_creation { LL_CREATION_OPEN, LL_CREATION_CLASS, LL_CREATION_OPERATOR } ll_creation;

extern const char *const ll_creation_names[]; /* NULL-terminated */

/* Rows of ll_access_table. */
typedef struct ll_access_config {
    char operator_key_file[512], class_key_file[512];
    char creation[16]; /* one of ll_creation_names; empty: class if there is a class key, else open */
} ll_access_config;

extern const ll_param_table ll_access_table;

typedef struct ll_access {
    bool has_operator, has_class;
    ll_key_hash operator_key;
    ll_class_keys class_keys;
    atomic_int creation; /* an ll_creation */
} ll_access;

/* Reads the keys. LL_BAD_INPUT: a file that cannot be read or has no key, or a `creation` whose key is
 * missing. To be closed also then. */
ll_status ll_access_open(const ll_access_config *config, ll_access *access);
void ll_access_close(ll_access *access);

bool ll_access_is_operator(const ll_access *access, const char *key, size_t length);
bool ll_access_may_create(const ll_access *access, const char *key, size_t length);
/* The class key with a name that this is, whose quotas count; NULL: it is none. */
ll_class_key *ll_access_class_key(const ll_access *access, const char *key, size_t length);
ll_class_key *ll_access_named_key(const ll_access *access, const char *name); /* NULL: there is none */

/* LL_BAD_INPUT: unknown name, or `class` without a class key. */
ll_status ll_access_set_creation(ll_access *access, const char *name);
