#include "netcode/metrics/behind_cover.h"

#include <string.h>

size_t ll_behind_cover_size(int players)
{
    return sizeof(ll_behind_cover) + (size_t)players * sizeof(ll_behind_cover_player);
}

void ll_behind_cover_init(ll_behind_cover *cover, int players, ll_time from)
{
    memset(cover, 0, ll_behind_cover_size(players));
    cover->from = from;
    cover->players = players;
    for (int i = 0; i < players; i++)
        ll_histogram_init(&cover->player[i].shown, 0.1);
}

void ll_behind_cover_judge(ll_behind_cover *cover, const ll_hit_result *j, int64_t step)
{
    ll_behind_cover_player *shooter = &cover->player[j->shooter];
    if (j->kind != LL_HIT_RESULT_HITSCAN || j->shot->now < cover->from)
        return;
    shooter->vetoed += j->vetoed;
    if (j->body == LL_NOBODY || j->body >= cover->players)
        return;
    ll_awaited_hit *hit = &shooter->hits[shooter->judged++ & (LL_HITS_AWAITED - 1)];
    shooter->awaited += hit->step == 0;
    *hit = (ll_awaited_hit){step, j->body};
}

static void show_hits(ll_behind_cover_player *shooter, int victim, int64_t known, double hidden_ms)
{
    for (int i = 0; i < LL_HITS_AWAITED && shooter->awaited > 0; i++) {
        ll_awaited_hit *hit = &shooter->hits[i];
        if (hit->step == 0 || hit->victim != victim || hit->step > known)
            continue;
        *hit = (ll_awaited_hit){0};
        shooter->awaited--;
        if (hidden_ms >= 0)
            ll_histogram_add(&shooter->shown, hidden_ms);
    }
}

void ll_behind_cover_frame(ll_behind_cover *cover, const ll_shots *shots, int self, int64_t known,
                           ll_time now)
{
    ll_behind_cover_player *own = &cover->player[self];
    const uint32_t sees = shots->shot_stats[self].sees, closed = own->seen & ~sees;
    own->seen = sees;
    for (int i = 0; i < cover->players; i++) {
        if (closed >> i & 1)
            own->closed[i] = now;
        if (cover->player[i].awaited == 0)
            continue;
        bool hidden = !(sees >> i & 1) && own->closed[i] > 0;
        show_hits(&cover->player[i], self, known, hidden ? ll_to_ms(now - own->closed[i]) : -1);
    }
}
