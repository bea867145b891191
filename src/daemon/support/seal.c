#include "daemon/support/seal.h"

#include <limits.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <openssl/evp.h>
#include <openssl/rand.h>

enum { NONCE = 12, TAG = 16 }; /* before the sealed text, and after it */

static bool encrypt(const unsigned char *key, const char *text, size_t size, unsigned char *bytes)
{
    EVP_CIPHER_CTX *context = EVP_CIPHER_CTX_new();
    unsigned char *body = bytes + NONCE;
    int written = 0, rest = 0;
    bool done = context && RAND_bytes(bytes, NONCE) == 1 &&
                EVP_EncryptInit_ex(context, EVP_aes_256_gcm(), NULL, key, bytes) &&
                EVP_EncryptUpdate(context, body, &written, (const unsigned char *)text, (int)size) &&
                EVP_EncryptFinal_ex(context, body + written, &rest) &&
                EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_GCM_GET_TAG, TAG, body + size);
    EVP_CIPHER_CTX_free(context);
    return done;
}

static bool decrypt(const unsigned char *key, unsigned char *bytes, size_t size, char *text)
{
    EVP_CIPHER_CTX *context = EVP_CIPHER_CTX_new();
    unsigned char *body = bytes + NONCE, *to = (unsigned char *)text;
    int written = 0, rest = 0;
    bool done = context && EVP_DecryptInit_ex(context, EVP_aes_256_gcm(), NULL, key, bytes) &&
                EVP_DecryptUpdate(context, to, &written, body, (int)size) &&
                EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_GCM_SET_TAG, TAG, body + size) &&
                EVP_DecryptFinal_ex(context, to + written, &rest) > 0;
    EVP_CIPHER_CTX_free(context);
    return done;
}

char *ll_seal(const unsigned char key[LL_DIGEST_SIZE], const char *text)
{
    static const char digits[] = "0123456789abcdef";
    size_t size = strlen(text), whole = NONCE + size + TAG;
    unsigned char *bytes = size <= INT_MAX ? malloc(whole) : NULL;
    char *sealed = bytes ? malloc(2 * whole + 1) : NULL;
    if (sealed && encrypt(key, text, size, bytes)) {
        for (size_t i = 0; i < whole; i++) {
            sealed[2 * i] = digits[bytes[i] >> 4];
            sealed[2 * i + 1] = digits[bytes[i] & 15];
        }
        sealed[2 * whole] = '\0';
    } else {
        free(sealed);
        sealed = NULL;
    }
    free(bytes);
    return sealed;
}

char *ll_unseal(const unsigned char key[LL_DIGEST_SIZE], const char *sealed)
{
    size_t length = strlen(sealed), whole = length / 2;
    if (length % 2 || whole < NONCE + TAG || whole > INT_MAX || strspn(sealed, "0123456789abcdef") != length)
        return NULL;
    size_t size = whole - NONCE - TAG;
    unsigned char *bytes = malloc(whole);
    char *text = bytes ? malloc(size + 1) : NULL;
    for (size_t i = 0; text && i < whole; i++) {
        char pair[3] = {sealed[2 * i], sealed[2 * i + 1], '\0'};
        bytes[i] = (unsigned char)strtoul(pair, NULL, 16);
    }
    if (text && decrypt(key, bytes, size, text)) {
        text[size] = '\0';
    } else {
        free(text);
        text = NULL;
    }
    free(bytes);
    return text;
}
