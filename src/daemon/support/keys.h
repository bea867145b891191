/* Random names: ids, keys and join codes. Those of a daemon with a shard's name begin with it, and a `-`: an
 * id `a-`, a code `A-`, by which a proxy finds the daemon.
 *
 * A key is shown once, to the client that created the session. Only a salted hash of it is kept
 * (ll_key_hash), and compared in constant time. Any thread; the kernel's random numbers. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

#define LL_SHARD_LENGTH 4 /* at most: it stands in every code */
#define LL_ID_RANDOM 26   /* letters: 130 bits */
#define LL_CODE_RANDOM 4  /* short enough to say aloud; short-lived and rate-limited, never a secret */
#define LL_ID_LENGTH (LL_SHARD_LENGTH + 1 + LL_ID_RANDOM)     /* at most */
#define LL_CODE_LENGTH (LL_SHARD_LENGTH + 1 + LL_CODE_RANDOM) /* at most */
#define LL_STEM_LENGTH 10 /* of an id: sessions that were made for a class begin as its id does */
#define LL_KEY_LENGTH 32  /* 160 bits */
#define LL_KEY_SALT 16
#define LL_KEY_RECORD (LL_KEY_SALT + 32)

typedef struct ll_key_hash {
    unsigned char bytes[LL_KEY_RECORD]; /* salt, then SHA-256 of salt and key */
} ll_key_hash;

/* Fill `text` (length + 1 bytes). `shard`: of this daemon; empty: it has no name. False when the kernel has
 * no random numbers. */
bool ll_new_id(const char *shard, char text[LL_ID_LENGTH + 1]);
bool ll_new_key(char text[LL_KEY_LENGTH + 1]);
bool ll_new_code(const char *shard, char text[LL_CODE_LENGTH + 1]);

/* Whether `name` may be a shard's: empty, or a few letters and digits. */
ll_status ll_shard_check(const char *name);

/* With or without the name of any shard. */
bool ll_is_id(const char *text);
bool ll_is_code(const char *text);
/* A code as a person types it, in letters of either case. False: it is none. */
bool ll_code_read(const char *text, char code[LL_CODE_LENGTH + 1]);

bool ll_key_hash_make(const char *key, ll_key_hash *hash);
bool ll_key_matches(const ll_key_hash *hash, const char *key, size_t length);

/* As text, for storing. `text` of reading may be NULL; false: it is none. */
#define LL_KEY_HASH_TEXT (2 * LL_KEY_RECORD)
void ll_key_hash_write(const ll_key_hash *hash, char text[LL_KEY_HASH_TEXT + 1]);
bool ll_key_hash_read(const char *text, ll_key_hash *hash);
