/* The list of bodies that are awake. */
#include "rigid/body/world_state.h"

void ll_put_in_awake_list(ll_rigid *w, int32_t body)
{
    ll_bodys(w)[body].awake = w->awake;
    ll_awakes(w)[w->awake++] = body;
}

void ll_take_from_awake_list(ll_rigid *w, int32_t body)
{
    int32_t *list = ll_awakes(w), last = list[--w->awake], place = ll_bodys(w)[body].awake;
    list[place] = last;
    ll_bodys(w)[last].awake = place;
    ll_bodys(w)[body].awake = LL_NONE;
}
