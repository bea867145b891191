/* What a key permits on a session. */
#include "daemon/hosting/session_entry.h"
#include "daemon/support/access.h"

int ll_session_entry_find_role(const ll_session_entry *session_entry, const char *key, size_t length,
                               bool *guest)
{
    int role = LL_ROLE_NONE;
    const ll_host *host = session_entry->host;
    *guest = false;
    for (int i = 0; i < session_entry->identity.key_count; i++) { /* constant time: compares every key */
        if (ll_key_matches(&session_entry->identity.keys[i], key, length))
            role = i - 1;
    }
    if (ll_access_is_operator(host->config.access, key, length))
        role = LL_ROLE_OWNER;
    if (role != LL_ROLE_NONE || !host->guest_role)
        return role;
    *guest = true;
    return host->guest_role(host->guest_context, session_entry->identity.id, key, length);
}

int ll_session_entry_role(const ll_session_entry *session_entry, const char *key, size_t length)
{
    bool guest;
    return ll_session_entry_find_role(session_entry, key, length, &guest);
}

void ll_host_set_guests(ll_host *host, ll_host_guest_role *role, void *context)
{
    host->guest_role = role;
    host->guest_context = context;
}
