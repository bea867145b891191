/* What a scenario configures: the system, the methods' control, and the time scale. */
#include "sim/motion/motion.h"

const char *const ll_motion_step_names[] = {"fixed", "frame", "accumulator", NULL};
const char *const ll_motion_clock_names[] = {"exact", "float", "compensated", NULL};
const char *const ll_motion_precision_names[] = {"double", "float", NULL};
const char *const ll_motion_frame_names[] = {"alternating", "random", NULL};

double ll_motion_end(const ll_motion_config *c)
{
    return c->reverse ? c->head.duration_s / 2 : c->head.duration_s;
}

double ll_motion_moment(const ll_motion_config *c, double t)
{
    return t <= ll_motion_end(c) ? t : c->head.duration_s - t;
}

double ll_motion_time(const ll_motion *m, int i)
{
    const ll_motion_method *method = &m->config.methods[i];
    return method->clock == LL_MOTION_EXACT ? ll_motion_run(m, i)->t
                                            : (double)m->drive[i].ticks * method->dt_s;
}

double ll_motion_clock_error(const ll_motion *m, int i)
{
    return ll_motion_run(m, i)->t - ll_motion_time(m, i);
}

ll_ode ll_motion_system(ll_motion_config *config)
{
    const ll_ode_problem *problem = ll_motion_problem(config);
    ll_ode ode;
    if (problem->prepare)
        problem->prepare(config->params);
    problem->system(config->params, &ode);
    return ode;
}

ll_ode_control ll_motion_control(const ll_motion_config *config, int i)
{
    const ll_motion_method *method = &config->methods[i];
    return (ll_ode_control){.t_end = ll_motion_end(config),
                            .dt = method->steps == LL_MOTION_FRAME ? config->frame_s : method->dt_s,
                            .tolerance = config->methods[i].tolerance,
                            .max_steps = LL_MOTION_STEPS_MAX};
}
