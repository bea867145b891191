#include "link/dejitter/policy.h"

ll_time ll_dejitter_approach(const ll_dejitter_history *h, const ll_dejitter_arrival *packet, double want_ms,
                             double up, double down)
{
    double passed = (double)(packet->arrived - h->arrived);
    ll_time want = ll_ms(want_ms), most = h->delay + (ll_time)(up * passed),
            least = h->delay - (ll_time)(down * passed);
    return want > most ? most : want < least ? least : want;
}
