/* Sections of frames; for frame.c only. */
#pragma once

#include "session/frame.h"

/* Copies the rows; one reference. NULL without memory. */
ll_section *ll_section_new(const ll_rows *rows, uint32_t seq);

/* The same in memory of the frame `home`, of ll_section_bytes; without a reference. */
size_t ll_section_bytes(const ll_rows *rows);
ll_section *ll_section_put(void *memory, ll_frame *home, const ll_rows *rows, uint32_t seq);
void ll_section_drop_encodings(ll_section *section);

/* Appends a section's part of a binary message. */
void ll_section_encode(const ll_rows *rows, const ll_rows *base, ll_buffer *out);

/* Appends the section's part of a message, as a delta against `base` (of the same record and stream) or
 * whole. `shared`: keeps the encoding for the next viewer that wants the same. Sets out->failed without
 * memory. */
void ll_section_write(ll_section *section, const ll_section *base, ll_frame_format format, bool shared,
                      ll_buffer *out);
