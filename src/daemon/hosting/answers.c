/* Requests that may be repeated, at any daemon of a shared store. */
#include "daemon/hosting/session_entry.h"

enum { ATTEMPTS = 3 };

ll_status ll_host_claim_answer(ll_host *host, ll_answer_key *key, ll_answer_claim *claim)
{
    bool gone = true;
    for (int attempt = 0; attempt < ATTEMPTS && gone; attempt++) {
        LL_TRY(ll_store_check_lease(host->store));
        LL_TRY(ll_store_claim_answer(host->store, key, claim));
        if (claim->state != LL_ANSWER_BUSY || claim->owner == key->daemon)
            return ll_ok();
        LL_TRY(ll_neighbour_judge(host->store, claim->owner, claim->url, claim->over, &gone));
    }
    return ll_ok();
}
