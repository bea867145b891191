/* Plain files in one file: ustar (POSIX.1-2017, pax), without folders, links, owners and times, so that the
 * same files give the same bytes. By libarchive. */
#pragma once

#include <stdint.h>
#include <stdio.h>

#include "base/status.h"

enum { LL_TAR_BLOCK = 512, LL_TAR_NAME_MAX = 99, LL_TAR_MEMBERS_MAX = 16 };

typedef struct ll_tar_member {
    char name[LL_TAR_NAME_MAX + 1];
    int64_t offset, size; /* of its bytes in the archive */
} ll_tar_member;

/* Writes an archive of all of these files, each from its beginning, under names without `/`. */
ll_status ll_tar_write(FILE *archive, const char *const *names, FILE *const *contents, int count);

/* Lists the members. Reads nothing beyond the file, for any size that it claims, and refuses everything but
 * plain files with plain names, damaged headers, and bytes that no member has. LL_BAD_INPUT says what and
 * where. */
ll_status ll_tar_list(FILE *archive, ll_tar_member members[LL_TAR_MEMBERS_MAX], int *count);
