#include "base/utf8.h"

#include <stdbool.h>

static bool is_continuation(unsigned char byte)
{
    return (byte & 0xc0) == 0x80;
}

/* Stops at the terminating NUL, which is not a continuation byte. */
int ll_utf8_printable(const char *text)
{
    const unsigned char *s = (const unsigned char *)text;
    if (s[0] < 0x80)
        return s[0] >= 0x20 && s[0] != 0x7f ? 1 : 0;
    int length = s[0] >= 0xf0 ? 4 : s[0] >= 0xe0 ? 3 : 2;
    if (s[0] < 0xc2 || s[0] > 0xf4) /* a continuation byte, overlong, or beyond U+10FFFF */
        return 0;
    for (int i = 1; i < length; i++)
        if (!is_continuation(s[i]))
            return 0;
    switch (s[0]) {
    case 0xc2:
        return s[1] < 0xa0 ? 0 : length; /* controls U+0080 to U+009F */
    case 0xe0:
        return s[1] < 0xa0 ? 0 : length; /* overlong */
    case 0xed:
        return s[1] >= 0xa0 ? 0 : length; /* surrogates */
    case 0xf0:
        return s[1] < 0x90 ? 0 : length; /* overlong */
    case 0xf4:
        return s[1] >= 0x90 ? 0 : length; /* beyond U+10FFFF */
    default:
        return length;
    }
}
