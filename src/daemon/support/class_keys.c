#include "daemon/support/class_keys.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SHORTEST = 8, LONGEST = 256, WORDS_MAX = 2 + LL_KEY_QUOTAS };

const char *const ll_key_quota_names[LL_KEY_QUOTAS] = {[LL_KEY_CLASSES] = "classes",
                                                       [LL_KEY_SESSIONS] = "sessions",
                                                       [LL_KEY_EXPERIMENTS] = "experiments",
                                                       [LL_KEY_LOGS] = "logs_mib",
                                                       [LL_KEY_RATE] = "new_sessions_per_min"};

static const struct {
    int64_t least, most, unit;
} ranges[LL_KEY_QUOTAS] = {[LL_KEY_CLASSES] = {0, 10000, 1},
                           [LL_KEY_SESSIONS] = {0, 1000000, 1},
                           [LL_KEY_EXPERIMENTS] = {0, 1000000, 1},
                           [LL_KEY_LOGS] = {1, 16777216, 1 << 20},
                           [LL_KEY_RATE] = {1, 1000000, 1}};

ll_status ll_key_check(const char *from, const char *text, size_t shortest)
{
    size_t length = strlen(text);
    for (size_t i = 0; i < length; i++)
        if (text[i] <= ' ' || text[i] > '~')
            return ll_error(LL_BAD_INPUT, "key of %.220s: must be visible ASCII without spaces", from);
    if (length < shortest || length > LONGEST)
        return ll_error(LL_BAD_INPUT,
                        "key of %.220s: must be visible ASCII without spaces, %zu to %d characters; got %zu",
                        from, shortest, LONGEST, length);
    return ll_ok();
}

/* ---- a line ---- */

static ll_status read_quota(const char *from, char *word, ll_class_key *key)
{
    char *value = strchr(word, '='), *end = NULL;
    int quota = 0;
    if (value)
        *value++ = '\0';
    while (quota < LL_KEY_QUOTAS && (!value || strcmp(word, ll_key_quota_names[quota]) != 0))
        quota++;
    if (quota == LL_KEY_QUOTAS) /* the word may be a part of a key: it is not repeated */
        return ll_error(
            LL_BAD_INPUT,
            "%.220s: after NAME and KEY (visible ASCII without spaces) only classes=N, sessions=N, "
            "experiments=N, logs_mib=N and new_sessions_per_min=N may follow",
            from);
    int64_t number = strtoll(value, &end, 10);
    if (value[0] < '0' || value[0] > '9' || *end || number < ranges[quota].least ||
        number > ranges[quota].most)
        return ll_error(LL_BAD_INPUT, "%.220s: %s: must be a whole number from %lld to %lld", from,
                        ll_key_quota_names[quota], (long long)ranges[quota].least,
                        (long long)ranges[quota].most);
    if (key->most[quota] >= 0)
        return ll_error(LL_BAD_INPUT, "%.220s: %s: is given twice", from, ll_key_quota_names[quota]);
    key->most[quota] = number * ranges[quota].unit;
    return ll_ok();
}

/* A name becomes a label of a metric and a part of messages. */
static bool is_name(const char *text)
{
    size_t length = strlen(text);
    return length <= LL_KEY_NAME_MAX &&
           strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-") == length;
}

static ll_status add_key(ll_class_keys *keys, const char *from, const char *name, const char *text)
{
    ll_class_key *all =
        keys->count < LL_CLASS_KEYS_MAX ? realloc(keys->keys, (size_t)(keys->count + 1) * sizeof *all) : NULL;
    if (keys->count == LL_CLASS_KEYS_MAX)
        return ll_error(LL_BAD_INPUT, "%.220s: must be at most %d keys", from, LL_CLASS_KEYS_MAX);
    if (!all)
        return ll_error(LL_NO_MEMORY, "out of memory: keys");
    keys->keys = all;
    ll_class_key *key = &all[keys->count];
    memset(key, 0, sizeof *key);
    snprintf(key->name, sizeof key->name, "%s", name);
    for (int i = 0; i < LL_KEY_QUOTAS; i++)
        key->most[i] = -1;
    LL_TRY(ll_key_check(from, text, SHORTEST));
    if (ll_class_keys_find(keys, text, strlen(text)))
        return ll_error(LL_BAD_INPUT, "%.220s: the key is that of an earlier line", from);
    if (!ll_key_hash_make(text, &key->hash))
        return ll_error(LL_NO_MEMORY, "Random numbers for keys not available.");
    keys->count++;
    return ll_ok();
}

static ll_status read_line(ll_class_keys *keys, const char *from, char *line)
{
    char *words[WORDS_MAX + 1], *rest = NULL;
    int count = 0;
    for (char *word = strtok_r(line, " \t\r", &rest); word && count <= WORDS_MAX;
         word = strtok_r(NULL, " \t\r", &rest))
        words[count++] = word;
    if (count == 0 || words[0][0] == '#')
        return ll_ok();
    if (count == 1)
        return ll_error(LL_BAD_INPUT,
                        "%.220s: must be NAME KEY and quotas; a key without a name must be the only one, and "
                        "its file must have one line",
                        from);
    if (!is_name(words[0]))
        return ll_error(LL_BAD_INPUT, "%.220s: the name must be 1 to %d of a-z A-Z 0-9 . _ -", from,
                        LL_KEY_NAME_MAX);
    if (ll_class_keys_named(keys, words[0]))
        return ll_error(LL_BAD_INPUT, "%.220s: the name %s is that of an earlier line", from, words[0]);
    LL_TRY(add_key(keys, from, words[0], words[1]));
    for (int i = 2; i < count; i++)
        LL_TRY(read_quota(from, words[i], &keys->keys[keys->count - 1]));
    return ll_ok();
}

/* ---- a file ---- */

/* Also when it is empty, so that the message says what is missing. */
static bool is_single(const char *text)
{
    size_t length = strcspn(text, "\r\n");
    return text[length + strspn(text + length, "\r\n")] == '\0' && memchr(text, ' ', length) == NULL &&
           memchr(text, '\t', length) == NULL;
}

ll_status ll_class_keys_read(ll_class_keys *keys, const char *from, char *text)
{
    *keys = (ll_class_keys){0};
    if (is_single(text)) {
        text[strcspn(text, "\r\n")] = '\0';
        return add_key(keys, from, "", text);
    }
    int number = 0;
    ll_status status = ll_ok();
    for (char *line = text; line && !ll_failed(&status);) {
        char where[256], *next = strchr(line, '\n');
        if (next)
            *next++ = '\0';
        snprintf(where, sizeof where, "%.200s, line %d", from, ++number);
        status = read_line(keys, where, line);
        line = next;
    }
    return !ll_failed(&status) && keys->count == 0 ? ll_error(LL_BAD_INPUT, "%.220s: has no key", from)
                                                   : status;
}

void ll_class_keys_free(ll_class_keys *keys)
{
    free(keys->keys);
    *keys = (ll_class_keys){0};
}

/* ---- using them ---- */

/* How many there are is no secret, which of them it is would be: none is left out. */
ll_class_key *ll_class_keys_find(const ll_class_keys *keys, const char *key, size_t length)
{
    ll_class_key *found = NULL;
    for (int i = 0; i < keys->count; i++)
        if (ll_key_matches(&keys->keys[i].hash, key, length))
            found = &keys->keys[i];
    return found;
}

ll_class_key *ll_class_keys_named(const ll_class_keys *keys, const char *name)
{
    for (int i = 0; i < keys->count; i++)
        if (name[0] && strcmp(keys->keys[i].name, name) == 0)
            return &keys->keys[i];
    return NULL;
}

void ll_class_keys_list(const ll_class_keys *keys, char *text, size_t size)
{
    size_t length = 0;
    text[0] = '\0';
    for (int i = 0; i < keys->count && keys->keys[i].name[0]; i++) {
        bool fits = length + LL_KEY_NAME_MAX + sizeof ", , ..." <= size;
        length += (size_t)snprintf(text + length, size - length, "%s%s", i > 0 ? ", " : "",
                                   fits ? keys->keys[i].name : "...");
        if (!fits)
            return;
    }
}

bool ll_class_key_take(ll_class_key *key, ll_key_quota quota)
{
    int64_t before = atomic_fetch_add(&key->used[quota], 1);
    if (key->most[quota] < 0 || before < key->most[quota])
        return true;
    atomic_fetch_sub(&key->used[quota], 1);
    return false;
}

bool ll_class_key_is_full(const ll_class_key *key, ll_key_quota quota)
{
    return key->most[quota] >= 0 && atomic_load(&key->used[quota]) >= key->most[quota];
}
