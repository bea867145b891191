/* Untrusted text. */
#pragma once

/* Length of the UTF-8 sequence at `text`; 0 if it is invalid or a control character. */
int ll_utf8_printable(const char *text);
