/* The name of a database. */
#include <stdio.h>
#include <string.h>

#include "postgres/url.h"

void ll_pg_name_url(const char *url, char *name, size_t size)
{
    const char *slashes = strstr(url, "://"), *begin = slashes ? slashes + 3 : url;
    size_t whole = strcspn(begin, "?");
    const char *at = memrchr(begin, '@', whole), *rest = at ? at : begin;
    size_t user = at ? strcspn(begin, ":@") : 0;
    snprintf(name, size, "%.*s%.*s%.*s", (int)(begin - url), url, (int)user, begin,
             (int)(begin + whole - rest), rest);
}
