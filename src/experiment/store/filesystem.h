/* Type of a folder's file system. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

/* The kernel's name, such as `ext4`, `nfs4` or `fuse.sshfs`; empty if unknown. */
void ll_filesystem_type(const char *folder, char *type, size_t size);

/* Whether files of this type are on another machine: then a database cannot rely on locks and shared
 * memory. */
bool ll_filesystem_is_remote(const char *type);
