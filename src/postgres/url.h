/* URLs of databases: scheme://user:password@host/database?parameters. */
#pragma once

#include <stddef.h>

#include "base/status.h"

/* The URL without secrets: of the part before the last @ only the user's name, and no query. Needs no libpq.
 */
void ll_pg_name_url(const char *url, char *name, size_t size);

/* LL_BAD_INPUT, of field "store", if libpq cannot read it. The message has `name` and no part of the URL. */
ll_status ll_pg_check_url(const char *url, const char *name);
