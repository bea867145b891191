/* The block of fluids side by side, at the start. */
#include <stdio.h>
#include <string.h>

#include "sim/fluid/fluid.h"

static int64_t head_size(void)
{
    return ((int64_t)sizeof(ll_fluid_sim) + 63) & ~INT64_C(63);
}

ll_fluid_setup ll_fluid_sim_setup(const ll_fluid_config *c, int i)
{
    ll_fluid_setup setup = i == 0 ? c->setup : c->side_by_side[i - 1];
    setup.hz = c->setup.hz;
    setup.place = (int16_t)i;
    setup.following = (int16_t)(c->side_by_side_count - i);
    return setup;
}

static int64_t size_of(const ll_fluid_setup *setup)
{
    return head_size() + (int64_t)ll_fluid_sim_scene(setup)->size(setup->params, setup->solver);
}

size_t ll_fluid_sim_size(const void *config)
{
    const ll_fluid_config *c = config;
    int64_t end = 0;
    for (int i = 0; i <= c->side_by_side_count; i++) {
        ll_fluid_setup setup = ll_fluid_sim_setup(c, i);
        end = ((end + 63) & ~INT64_C(63)) + size_of(&setup);
    }
    return (size_t)end;
}

ll_status ll_fluid_sim_init(void *block, const void *config)
{
    ll_fluid_sim *s = block;
    for (int i = 0; s != NULL; i++, s = ll_fluid_sim_next(s)) {
        memset(s, 0, (size_t)head_size());
        s->setup = ll_fluid_sim_setup(config, i);
        s->size = size_of(&s->setup);
        s->fluid = head_size();
        ll_fluid_sim_scene(&s->setup)->init(ll_fluid_sim_block(s), s->setup.params, s->setup.solver);
    }
    return ll_ok();
}

int ll_fluid_sim_numbers(const ll_fluid_sim *s, ll_fluid_number *out)
{
    const ll_fluid_scene *scene = ll_fluid_sim_scene(&s->setup);
    int count = scene->method->numbers(ll_fluid_sim_block(s), out);
    return scene->numbers ? count + scene->numbers(ll_fluid_sim_block(s), out + count) : count;
}
