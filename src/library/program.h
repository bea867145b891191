/* The program's own place. */
#pragma once

#include <stddef.h>

/* Path of `name` beside the running program; `name` itself where that is unknown or too long. */
void ll_beside_program(const char *name, char *path, size_t size);
