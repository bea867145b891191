#include "daemon/support/keys.h"

#include <string.h>
#include <sys/random.h>

#include "daemon/support/digest.h"

static const char base32[] = "abcdefghijklmnopqrstuvwxyz234567";
static const char code_letters[] = "23456789ABCDEFGHJKMNPQRSTUVWXYZ"; /* without 0 O 1 I L */

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
        for (size_t i = 0; i < sizeof bytes && n < length; i++) {
            if (bytes[i] < bound)
                text[n++] = alphabet[bytes[i] % letters];
        }
    }
    text[length] = '\0';
    return true;
}

bool ll_new_id(char text[LL_ID_LENGTH + 1])
{
    return random_text(text, LL_ID_LENGTH, base32, 32);
}

bool ll_new_key(char text[LL_KEY_LENGTH + 1])
{
    return random_text(text, LL_KEY_LENGTH, base32, 32);
}

bool ll_new_code(char text[LL_CODE_LENGTH + 1])
{
    return random_text(text, LL_CODE_LENGTH, code_letters, sizeof code_letters - 1);
}

bool ll_is_id(const char *text)
{
    return strlen(text) == LL_ID_LENGTH && strspn(text, base32) == LL_ID_LENGTH;
}

bool ll_is_code(const char *text)
{
    return strlen(text) == LL_CODE_LENGTH && strspn(text, code_letters) == LL_CODE_LENGTH;
}

bool ll_code_read(const char *text, char code[LL_CODE_LENGTH + 1])
{
    if (strlen(text) != LL_CODE_LENGTH)
        return false;
    for (int i = 0; i <= LL_CODE_LENGTH; i++)
        code[i] = text[i] >= 'a' && text[i] <= 'z' ? (char)(text[i] - 'a' + 'A') : text[i];
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
    if (!ll_digest(hash->bytes, LL_KEY_SALT, key, length, digest))
        return false;
    unsigned difference = 0;
    for (size_t i = 0; i < LL_DIGEST_SIZE; i++)
        difference |= (unsigned)(digest[i] ^ hash->bytes[LL_KEY_SALT + i]);
    return difference == 0;
}
