/* A scenario of the library, ready to be stepped by a test. Tests run in the root of the repository. */
#pragma once

#include <string.h>

#include "session/scenario.h"
#include "sim/netgame/netgame.h"

/* The configuration that a block contains; what a block has by itself, or by default, is all zero. */
static inline ll_netgame_config scene_config(const ll_netgame *game)
{
    ll_netgame_config config = {0};
    memcpy(&config, &game->config, ll_netgame_config_size(&game->config));
    return config;
}

typedef struct scene {
    ll_scenario scenario;
    ll_netgame *game; /* the block */
} scene;

/* Loads `id`, applies NULL-terminated "path=value" pairs, and starts it. Fails the test on any error. */
scene scene_open(const char *id, const char *const *sets);
scene scene_make(const char *json, const char *const *sets); /* the same for a scenario's text */
void scene_run(scene *s, double until_s, const ll_recorder *recorder);
void scene_run_whole(scene *s); /* to its end, with its timeline */
void scene_close(scene *s);

/* All events of a run. */
typedef struct tape {
    ll_event *events;
    size_t count, capacity;
} tape;

ll_recorder tape_recorder(tape *t);
void tape_free(tape *t);
