/* Prediction smoothing: when the correct position jumps, the drawn one follows by halving the error every
 * half-life, at any frame rate (lightyear's VisualCorrection). Only the view is smoothed, never a state: the
 * error is stored apart from the worlds and added when they are drawn. */
#include <string.h>

#include "base/detmath.h"
#include "netcode/state/client.h"

#define LN2 0.69314718055994531
#define FORGET 1e-5 /* m, rad: invisible */

void ll_smooth_correct(ll_client *c, int entity, const ll_entity *drawn, const ll_entity *right)
{
    ll_view_error *e = &ll_client_errors(c)[entity];
    c->view.has_errors = 1;
    if ((drawn->flags ^ right->flags) & LL_ENTITY_ACTIVE) {
        *e = (ll_view_error){0}; /* a flight began or ended: another object is drawn */
        return;
    }
    e->x += drawn->x - right->x;
    e->y += drawn->y - right->y;
    e->angle += drawn->angle - right->angle;
}

static bool seen(const ll_view_error *e)
{
    return e->x > FORGET || e->x < -FORGET || e->y > FORGET || e->y < -FORGET || e->angle > FORGET ||
           e->angle < -FORGET;
}

/* Bitwise: a zero with a minus is taken for an error, and becomes zero. */
static bool is_none(const ll_view_error *e)
{
    uint64_t word[3];
    memcpy(word, e, sizeof word);
    return (word[0] | word[1] | word[2]) == 0;
}

static double speed_of(const ll_entity *e)
{
    return ll_sqrt(e->vx * e->vx + e->vy * e->vy);
}

void ll_smooth_draw(ll_client *c, const ll_client_setup *s, ll_time now)
{
    double worst = 0, keep = 0;
    ll_world *shown = ll_client_rendered(c);
    const bool counts = (s->client_metrics->observes & LL_OBSERVE_FRAMES) && now >= s->client_metrics->from;
    if (!c->view.has_errors) {
        if (counts)
            ll_histogram_add(&s->client_metrics->histogram[LL_METRIC_POP], 0);
        return;
    }
    if (s->config->correction == LL_CORRECTION_SMOOTH)
        keep = ll_exp(-ll_to_ms(c->displays.elapsed) / s->config->correction_half_life_ms * LN2);
    bool has_view_errors = false;
    for (int i = 0; i < shown->entities; i++) {
        ll_view_error *e = &ll_client_errors(c)[i];
        if (is_none(e))
            continue;
        double size = ll_sqrt(e->x * e->x + e->y * e->y), left = size > LL_SMOOTH_MAX_M ? 0 : keep;
        worst = size * (1 - left) > worst ? size * (1 - left) : worst;
        ll_client_metrics_moved(s->client_metrics, size * (1 - left),
                                speed_of(&shown->entity[i]) * ll_to_s(c->displays.elapsed));
        *e = (ll_view_error){e->x * left, e->y * left, e->angle * left};
        if (!seen(e)) {
            *e = (ll_view_error){0};
            continue;
        }
        shown->entity[i].x += e->x;
        shown->entity[i].y += e->y;
        shown->entity[i].angle += e->angle;
        has_view_errors = true;
    }
    c->view.has_errors = has_view_errors;
    if (counts)
        ll_histogram_add(&s->client_metrics->histogram[LL_METRIC_POP], worst);
}
