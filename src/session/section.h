/* Sections of frames; for frame.c only. */
#pragma once

#include "session/frame.h"

/* Owns the rows; one reference. NULL without memory. */
ll_section *ll_section_new(ll_rows *rows, uint32_t seq);

/* The section's part of a message, as a delta against `base` (of the same record and stream) or whole. The
 * section owns it, and makes each encoding once. NULL without memory. */
const ll_buffer *ll_section_encode(ll_section *section, const ll_section *base, ll_frame_format format);
