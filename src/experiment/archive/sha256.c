#include "experiment/archive/sha256.h"

#include <openssl/evp.h>

static ll_status digest(EVP_MD_CTX *context, FILE *file, int64_t size, unsigned char *bytes)
{
    unsigned char buffer[1 << 15];
    if (!context || !EVP_DigestInit_ex(context, EVP_sha256(), NULL))
        return ll_error(LL_NO_MEMORY, "out of memory: digest");
    while (size > 0) {
        size_t wanted = size < (int64_t)sizeof buffer ? (size_t)size : sizeof buffer;
        if (fread(buffer, 1, wanted, file) != wanted)
            return ll_error(LL_IO, "cannot read the file to its end");
        if (!EVP_DigestUpdate(context, buffer, wanted))
            return ll_error(LL_NO_MEMORY, "out of memory: digest");
        size -= (int64_t)wanted;
    }
    return EVP_DigestFinal_ex(context, bytes, NULL) ? ll_ok()
                                                    : ll_error(LL_NO_MEMORY, "out of memory: digest");
}

ll_status ll_sha256_file(FILE *file, int64_t offset, int64_t size, char hex[LL_SHA256_HEX + 1])
{
    unsigned char bytes[EVP_MAX_MD_SIZE] = {0};
    if (fseeko(file, offset, SEEK_SET) != 0)
        return ll_error(LL_IO, "cannot read the file");
    EVP_MD_CTX *context = EVP_MD_CTX_new();
    ll_status status = digest(context, file, size, bytes);
    EVP_MD_CTX_free(context);
    for (size_t i = 0; i < LL_SHA256_HEX / 2; i++)
        snprintf(hex + 2 * i, 3, "%02x", bytes[i]);
    return status;
}
