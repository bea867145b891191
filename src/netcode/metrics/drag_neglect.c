#include "netcode/metrics/drag_neglect.h"

#include <string.h>

#include "base/detmath.h"

size_t ll_drag_neglect_size(int players)
{
    return sizeof(ll_drag_neglect) + (size_t)players * sizeof(ll_drag_neglect_player);
}

void ll_drag_neglect_init(ll_drag_neglect *neglect, int players, ll_time from)
{
    memset(neglect, 0, ll_drag_neglect_size(players));
    neglect->from = from;
    neglect->players = players;
    for (int i = 0; i < players; i++) {
        ll_histogram_init(&neglect->player[i].past, 0.0001);
        ll_histogram_init(&neglect->player[i].end, 0.0001);
    }
}

static ll_flight flight_of(const ll_drag_launch *launch, const ll_arena *arena)
{
    return (ll_flight){launch->from, launch->velocity, arena->gravity, arena->projectile_drag};
}

/* Between the flight and the same launch without drag, after `s` seconds. */
static double distance(const ll_flight *flight, double s)
{
    ll_flight neglected = *flight;
    neglected.drag = 0;
    ll_point a = ll_flight_at(flight, s), b = ll_flight_at(&neglected, s);
    return ll_sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

/* What the past part hits by one of the traces. */
static int past_hit(const ll_field *field, const ll_shot *shot, const ll_flight *flight, ll_trace trace)
{
    ll_compensation rules = *field->past->rules;
    ll_past past = *field->past;
    ll_field traced = *field;
    ll_time start;
    rules.projectile_trace = (int32_t)trace;
    past.rules = &rules;
    traced.past = &past;
    return ll_projectile_families[rules.projectile].launch(&traced, shot, flight, &start).body;
}

static void judge_past(ll_drag_neglect_player *player, const ll_field *field, const ll_hit_result *j,
                       const ll_flight *flight)
{
    int hit = past_hit(field, j->shot, flight, LL_TRACE_PARABOLA),
        neglected = past_hit(field, j->shot, flight, LL_TRACE_DRAG_NEGLECTED);
    player->traced++;
    player->differing += hit != neglected;
    player->false_hits += neglected != LL_NOBODY && hit != neglected;
    player->false_misses += hit != LL_NOBODY && hit != neglected;
    ll_histogram_add(&player->past, distance(flight, ll_to_s(j->shot->now - j->start)));
}

static void judge_launch(ll_drag_neglect *neglect, const ll_field *field, const ll_hit_result *j)
{
    ll_drag_neglect_player *player = &neglect->player[j->shooter];
    ll_drag_launch *launch = &player->launches[j->number % LL_PROJECTILES];
    double speed = field->arena->projectile_speed;
    *launch = (ll_drag_launch){.from = j->shot->from,
                               .velocity = {speed * j->shot->direction.x, speed * j->shot->direction.y},
                               .number = j->number,
                               .counts = j->shot->now >= neglect->from};
    const ll_flight flight = flight_of(launch, field->arena);
    if (launch->counts && j->start < j->shot->now)
        judge_past(player, field, j, &flight);
}

static void judge_impact(ll_drag_neglect *neglect, const ll_field *field, const ll_hit_result *j)
{
    ll_drag_neglect_player *player = &neglect->player[j->shooter];
    const ll_drag_launch *launch = &player->launches[j->number % LL_PROJECTILES];
    if (launch->number != j->number || !launch->counts)
        return;
    const ll_flight flight = flight_of(launch, field->arena);
    ll_histogram_add(&player->end, distance(&flight, ll_to_s(j->end - j->start)));
}

void ll_drag_neglect_judge(ll_drag_neglect *neglect, const ll_field *field, const ll_hit_result *j)
{
    if (j->kind == LL_HIT_RESULT_LAUNCH)
        judge_launch(neglect, field, j);
    else if (j->kind == LL_HIT_RESULT_IMPACT)
        judge_impact(neglect, field, j);
}
