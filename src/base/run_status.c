#include "base/run_status.h"

#include <stddef.h>

const char *const ll_run_status_names[] = {"ok", "diverged", "off", "failed", NULL};
