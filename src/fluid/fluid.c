#include <string.h>

#include "fluid/grid.h"

const ll_fluid_scene *const ll_fluid_scenes[] = {&ll_fluid_cavity, &ll_fluid_taylor_green, &ll_fluid_cylinder,
                                                 &ll_fluid_rotation, NULL};

const ll_fluid_scene *ll_fluid_scene_find(const char *name)
{
    for (int i = 0; ll_fluid_scenes[i]; i++)
        if (strcmp(ll_fluid_scenes[i]->name, name) == 0)
            return ll_fluid_scenes[i];
    return NULL;
}

ll_status ll_fluid_check_bytes(const char *field, const char *what, int64_t bytes)
{
    const double mebi = 1 << 20;
    if (bytes <= LL_FLUID_BYTES_MAX)
        return ll_ok();
    return ll_field_error(LL_LIMIT, field, "%s: %s would take %.0f MiB; the limit is %.0f MiB", field, what,
                          (double)bytes / mebi, (double)LL_FLUID_BYTES_MAX / mebi);
}
