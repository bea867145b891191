/* Sections of frames; for frame.c only. */
#pragma once

#include "session/frame.h"

/* Copies the rows; one reference. NULL without memory. */
ll_section *ll_section_new(const ll_rows *rows, uint32_t seq);

/* Appends the section's part of a message, as a delta against `base` (of the same record and stream) or
 * whole. `shared`: keeps the encoding for the next viewer that wants the same. Sets out->failed without
 * memory. */
void ll_section_write(ll_section *section, const ll_section *base, ll_frame_format format, bool shared,
                      ll_buffer *out);
