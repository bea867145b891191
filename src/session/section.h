/* Sections of frames; for frame.c. */
#pragma once

#include "session/frame.h"

/* Takes the rows; one reference. NULL without memory. */
ll_section *ll_section_new(ll_rows *rows, uint32_t seq);

/* Its part of a message: against `base`, of the same record and stream, or whole. Of the section's own: made
 * once. NULL without memory. */
const ll_buffer *ll_section_encode(ll_section *section, const ll_section *base, ll_frame_format format);
