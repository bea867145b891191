#include "fluid/core/fluid.h"

ll_status ll_fluid_check_bytes(const char *field, const char *what, int64_t bytes)
{
    const double mebi = 1 << 20;
    if (bytes <= LL_FLUID_BYTES_MAX)
        return ll_ok();
    return ll_field_error(LL_BAD_INPUT, field, "%s: %s would take %.0f MiB; the limit is %.0f MiB", field,
                          what, (double)bytes / mebi, (double)LL_FLUID_BYTES_MAX / mebi);
}
