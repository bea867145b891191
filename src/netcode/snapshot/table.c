#include "netcode/snapshot/snapshot.h"

const ll_codec *const ll_codecs[] = {&ll_codec_full,
                                     &ll_codec_quantised,
                                     &ll_codec_delta,
                                     &ll_codec_partial,
                                     &ll_codec_partial_delta,
                                     &ll_codec_interest,
                                     NULL};

/* In the order of ll_codecs; a test compares both. */
const char *const ll_codec_names[] = {"full",          "quantised", "delta", "partial",
                                      "partial_delta", "interest",  NULL};

int ll_codec_index(const ll_codec *codec)
{
    int i = 0;
    while (ll_codecs[i] != codec)
        i++;
    return i;
}

const ll_codec *ll_codec_at(int index)
{
    for (int i = 0; ll_codecs[i] != NULL; i++)
        if (i == index)
            return ll_codecs[i];
    return NULL;
}
