#include "daemon/support/keys.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "daemon/support/digest.h"

static const char base32[] = "abcdefghijklmnopqrstuvwxyz234567";
static const char code_letters[] = "23456789ABCDEFGHJKMNPQRSTUVWXYZ"; /* without 0 O 1 I L */
/* Of a shard's name, which is a part of codes: without I, L and O, which are read for 1 and 0. */
static const char shard_letters[] = "0123456789abcdefghjkmnpqrstuvwxyz";
static const char shard_capitals[] = "0123456789ABCDEFGHJKMNPQRSTUVWXYZ";

static bool random_text(char *text, size_t length, const char *alphabet, unsigned letters)
{
    /* Discards bytes beyond the last whole multiple of the alphabet's length, so that all letters are equally
     * likely. */
    unsigned bound = 256 / letters * letters;
    size_t n = 0;
    while (n < length) {
        unsigned char bytes[64];
        if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
            return false;
        for (size_t i = 0; i < sizeof bytes && n < length; i++)
            if (bytes[i] < bound)
                text[n++] = alphabet[bytes[i] % letters];
    }
    text[length] = '\0';
    return true;
}

static void to_capitals(char *text)
{
    for (; *text; text++)
        *text = *text >= 'a' && *text <= 'z' ? (char)(*text - 'a' + 'A') : *text;
}

/* Where the random part of a name begins. */
static char *begin_name(char *text, const char *shard)
{
    size_t length = strlen(shard);
    memcpy(text, shard, length);
    if (length > 0)
        text[length++] = '-';
    text[length] = '\0';
    return text + length;
}

bool ll_new_id(const char *shard, char text[LL_ID_LENGTH + 1])
{
    return random_text(begin_name(text, shard), LL_ID_RANDOM, base32, 32);
}

bool ll_new_key(char text[LL_KEY_LENGTH + 1])
{
    return random_text(text, LL_KEY_LENGTH, base32, 32);
}

bool ll_new_code(const char *shard, char text[LL_CODE_LENGTH + 1])
{
    char *at = begin_name(text, shard);
    to_capitals(text);
    return random_text(at, LL_CODE_RANDOM, code_letters, sizeof code_letters - 1);
}

ll_status ll_shard_check(const char *name)
{
    size_t length = strlen(name);
    if (length <= LL_SHARD_LENGTH && strspn(name, shard_letters) == length)
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, "shard",
                          "shard: must be 1 to %d of a-z and 0-9 without i, l and o; got \"%.40s\"",
                          LL_SHARD_LENGTH, name);
}

/* Whether `text` is `count` letters, which may stand after a shard's name. */
static bool is_name(const char *text, const char *of_shard, const char *letters, size_t count)
{
    size_t name = strcspn(text, "-");
    if (text[name] == '-') {
        if (name == 0 || name > LL_SHARD_LENGTH || strspn(text, of_shard) != name)
            return false;
        text += name + 1;
    }
    return strlen(text) == count && strspn(text, letters) == count;
}

bool ll_is_id(const char *text)
{
    return is_name(text, shard_letters, base32, LL_ID_RANDOM);
}

bool ll_is_code(const char *text)
{
    return is_name(text, shard_capitals, code_letters, LL_CODE_RANDOM);
}

bool ll_code_read(const char *text, char code[LL_CODE_LENGTH + 1])
{
    size_t length = strlen(text);
    if (length > LL_CODE_LENGTH)
        return false;
    memcpy(code, text, length + 1);
    to_capitals(code);
    return ll_is_code(code);
}

bool ll_key_hash_make(const char *key, ll_key_hash *hash)
{
    if (getrandom(hash->bytes, LL_KEY_SALT, 0) != LL_KEY_SALT)
        return false;
    return ll_digest(hash->bytes, LL_KEY_SALT, key, strlen(key), hash->bytes + LL_KEY_SALT);
}

bool ll_key_matches(const ll_key_hash *hash, const char *key, size_t length)
{
    unsigned char digest[LL_DIGEST_SIZE];
    return ll_digest(hash->bytes, LL_KEY_SALT, key, length, digest) &&
           ll_digest_equal(digest, hash->bytes + LL_KEY_SALT);
}

void ll_key_hash_write(const ll_key_hash *hash, char text[LL_KEY_HASH_TEXT + 1])
{
    for (size_t i = 0; i < sizeof hash->bytes; i++)
        snprintf(text + 2 * i, 3, "%02x", hash->bytes[i]);
}

bool ll_key_hash_read(const char *text, ll_key_hash *hash)
{
    if (!text || strlen(text) != LL_KEY_HASH_TEXT || strspn(text, "0123456789abcdef") != LL_KEY_HASH_TEXT)
        return false;
    for (size_t i = 0; i < sizeof hash->bytes; i++) {
        char pair[3] = {text[2 * i], text[2 * i + 1], '\0'};
        hash->bytes[i] = (unsigned char)strtoul(pair, NULL, 16);
    }
    return true;
}
