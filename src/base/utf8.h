/* Text from strangers. */
#pragma once

/* Length of the UTF-8 sequence at `text`: 0 when it is none, or a control character. */
int ll_utf8_printable(const char *text);
