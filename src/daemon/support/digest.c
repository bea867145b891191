#include "daemon/support/digest.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>

bool ll_digest(const void *a, size_t a_size, const void *b, size_t b_size,
               unsigned char digest[LL_DIGEST_SIZE])
{
    EVP_MD_CTX *context = EVP_MD_CTX_new();
    bool done = context && EVP_DigestInit_ex(context, EVP_sha256(), NULL) &&
                EVP_DigestUpdate(context, a, a_size) && EVP_DigestUpdate(context, b, b_size) &&
                EVP_DigestFinal_ex(context, digest, NULL);
    EVP_MD_CTX_free(context);
    return done;
}

bool ll_digest_equal(const unsigned char a[LL_DIGEST_SIZE], const unsigned char b[LL_DIGEST_SIZE])
{
    return CRYPTO_memcmp(a, b, LL_DIGEST_SIZE) == 0;
}
