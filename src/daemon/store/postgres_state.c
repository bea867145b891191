/* States of the store in PostgreSQL: the newest that was saved of each session. Written by postgres_commit.c.
 */
#include <stdlib.h>

#include "daemon/store/postgres.h"

static int digit(char c)
{
    return c >= 'a' ? c - 'a' + 10 : c - '0';
}

/* Of hexadecimal digits as the database writes them. */
static char *bytes_of(const char *hex, size_t size)
{
    char *bytes = malloc(size + 1);
    for (size_t i = 0; bytes && i < size; i++)
        bytes[i] = (char)(digit(hex[2 * i]) << 4 | digit(hex[2 * i + 1]));
    return bytes;
}

ll_status ll_pg_read_state(ll_store *store, int64_t number, ll_stored_state *state)
{
    postgres_store *s = (postgres_store *)store;
    pg_link *link = &s->reader;
    *state = (ll_stored_state){0};
    ll_pg_enter(s, link);
    ll_status status = ll_ok();
    if (!ll_pg_query(link, "SELECT encode(body,'hex') FROM state WHERE session=$1::bigint", "i", number)) {
        status = ll_pg_failure(s, link, "Reading a state");
    } else if (PQntuples(link->result) > 0) {
        state->size = (size_t)PQgetlength(link->result, 0, 0) / 2;
        state->bytes = bytes_of(ll_pg_text(link, 0, 0), state->size);
        if (!state->bytes)
            status = ll_error(LL_NO_MEMORY, "out of memory: state of a stored session");
    }
    return ll_pg_leave(link, status);
}
