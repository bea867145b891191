/* Rewind (C), what the paper describes: the flight begins at the time that the shooter saw. The server looks
 * into the past, where shell and targets go together record by record up to now, and then stays in the
 * present. The impact is that of a server without lag. Cost: one stretch of flight per record of the way. */
#include "game/weapons/policies.h"

static ll_meeting launch(const ll_field *field, const ll_shot *shot, const ll_flight *flight, ll_time *start)
{
    *start = shot->seen;
    ll_flight traced = ll_traced(field->past, flight, ll_to_s(shot->now - shot->seen));
    return ll_flight_through(field->arena, field->past->history, shot->shooter, &traced, shot->seen,
                             shot->seen, shot->now);
}

const ll_shell_family ll_shell_rewind = {
    .name = "rewind",
    .help = "C: shell and targets go together from the time that the shooter saw, then on in the present.",
    .rewinds = true,
    .looks_back = true,
    .launch = launch};
