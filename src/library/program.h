/* Location of the program. */
#pragma once

#include <stddef.h>

/* Path of `name` in the folder of the running program; `name` itself if that is unknown or too long. */
void ll_program_sibling(const char *name, char *path, size_t size);
