/* The head of a request as the acceptor reads it, while it grows: a longer piece decides, and every shorter
 * one must have been incomplete. Of a long input only some shorter ones are read: those of up to 128 bytes,
 * the 16 longest, and a part of those between. */
#include "check.h"

#include "daemon/net/upgrade.h"

#define LONG 1024
#define EVERY 128
#define LAST 16

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static bool inside(ll_text text, const char *bytes, size_t size)
{
    return text.at == NULL ? text.size == 0 : text.at >= bytes && text.at + text.size <= bytes + size;
}

static void look_at_parts(const ll_head *head, const char *bytes, size_t size)
{
    const ll_text parts[] = {head->method,  head->target, head->host,  head->key,
                             head->version, head->origin, head->length};
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
        FUZZ_CHECK(inside(parts[i], bytes, size));
    FUZZ_CHECK(head->size > 0 && head->size <= size && bytes[head->size - 1] == '\n');
    FUZZ_CHECK(head->method.size > 0 && head->target.size > 0);
    for (int f = 0; f < LL_STREAM_PROTOCOLS; f++)
        FUZZ_CHECK(head->protocol_at[f] >= 0 && head->protocol_at[f] <= head->protocols);
}

static void check_upgrade(const ll_head *head, const ll_allow *allow)
{
    static const int refusals[] = {400, 403, 404, 405, 421, 426};
    ll_upgrade upgrade;
    int http_status = 0;
    ll_status status = ll_upgrade_check(head, allow, &upgrade, &http_status);
    if (fuzz_failed(&status)) {
        bool known = false;
        for (size_t i = 0; i < sizeof refusals / sizeof refusals[0]; i++)
            known = known || http_status == refusals[i];
        FUZZ_CHECK(known);
        return;
    }
    FUZZ_CHECK(http_status == 101);
    FUZZ_CHECK(strlen(upgrade.key) == 24 && upgrade.key[23] == '=');
    size_t id = strlen(upgrade.id);
    FUZZ_CHECK(id >= 1 && id <= 64);
    FUZZ_CHECK(strspn(upgrade.id, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_") == id);
    FUZZ_CHECK(ll_allow_host(allow, head->host) && ll_allow_origin(allow, head->origin, head->host));
    FUZZ_CHECK(head->http11 && head->twice == NULL && !head->encoded);
}

static size_t next_shorter(size_t n, size_t whole)
{
    if (n < EVERY || n + LAST >= whole)
        return n + 1;
    size_t next = n + n / 16;
    return next + LAST < whole ? next : whole - LAST;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const ll_allow allows[] = {
        {NULL, NULL}, {"", ""}, {"lab.example, a", "https://lab.example,,http://a:8080"}};
    if (size > LONG)
        return 0;
    /* An exact allocation, so that an over-read is detected. */
    char *bytes = malloc(size > 0 ? size : 1);
    FUZZ_CHECK(bytes != NULL);
    memcpy(bytes, data, size);
    ll_head head, shorter;
    ll_head_state state = ll_head_parse(bytes, size, &head);
    if (state == LL_HEAD_WHOLE) {
        look_at_parts(&head, bytes, size);
        for (size_t i = 0; i < sizeof allows / sizeof allows[0]; i++)
            check_upgrade(&head, &allows[i]);
    }
    size_t whole = state == LL_HEAD_WHOLE ? head.size : size;
    for (size_t n = 0; n < whole; n = next_shorter(n, whole)) {
        ll_head_state before = ll_head_parse(bytes, n, &shorter);
        if (state == LL_HEAD_WHOLE || state == LL_HEAD_PARTIAL)
            FUZZ_CHECK(before == LL_HEAD_PARTIAL);
        else
            FUZZ_CHECK(before == LL_HEAD_PARTIAL || before == state);
    }
    free(bytes);
    return 0;
}
