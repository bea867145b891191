/* The list of bodies that are awake. */
#include "rigid/body/world_state.h"

void ll_put_in_awake_list(ll_rigid *w, int32_t body)
{
    ll_bodies(w)[body].awake = w->awake;
    ll_awake_bodies(w)[w->awake++] = body;
}

void ll_take_from_awake_list(ll_rigid *w, int32_t body)
{
    int32_t *list = ll_awake_bodies(w), last = list[--w->awake], place = ll_bodies(w)[body].awake;
    list[place] = last;
    ll_bodies(w)[last].awake = place;
    ll_bodies(w)[body].awake = LL_NONE;
}
