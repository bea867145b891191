/* Traces of links as files have them. */
#pragma once

#include "link/profile/profile.h"

/* Sets `params` to the defaults with the samples of the text of a file: a trace of Mahimahi, a whole number
 * of ms per line, or CSV with the header `t_ms,delay_ms,lost`. LL_BAD_INPUT names `name`, the line and the
 * field. */
ll_status ll_trace_read(const char *name, const char *text, ll_profile_params *params);
