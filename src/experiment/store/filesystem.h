/* On what kind of file system a folder is. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* The kernel's name of it, such as `ext4`, `nfs4` or `fuse.sshfs`; empty where it tells none. */
void ll_place_type(const char *folder, char *type, size_t size);

/* Whether such files are on another machine, whose locks and shared memory no database of one machine can
 * trust. */
bool ll_place_is_remote(const char *type);
