#include "experiment/archive/tar.h"

#include <archive.h>
#include <archive_entry.h>
#include <inttypes.h>
#include <stdbool.h>
#include <string.h>

static int64_t up_to_block(int64_t bytes)
{
    return (bytes + LL_TAR_BLOCK - 1) / LL_TAR_BLOCK * LL_TAR_BLOCK;
}

/* ---- writing ---- */

static ll_status cannot_write(struct archive *a)
{
    const char *why = archive_error_string(a);
    return ll_error(LL_IO, "cannot write the archive: %.200s", why ? why : "the disk is full");
}

static ll_status put_bytes(struct archive *a, FILE *content, int64_t size)
{
    char buffer[LL_TAR_BLOCK * 64];
    rewind(content);
    while (size > 0) {
        size_t wanted = size < (int64_t)sizeof buffer ? (size_t)size : sizeof buffer;
        if (fread(buffer, 1, wanted, content) != wanted)
            return ll_error(LL_IO, "cannot read a temporary file");
        if (archive_write_data(a, buffer, wanted) != (la_ssize_t)wanted)
            return cannot_write(a);
        size -= (int64_t)wanted;
    }
    return ll_ok();
}

static ll_status put_member(struct archive *a, struct archive_entry *entry, const char *name, FILE *content)
{
    int64_t size = fflush(content) == 0 && fseeko(content, 0, SEEK_END) == 0 ? ftello(content) : -1;
    if (size < 0)
        return ll_error(LL_IO, "cannot write a temporary file: the disk is full");
    archive_entry_clear(entry);
    archive_entry_set_pathname(entry, name);
    archive_entry_set_filetype(entry, AE_IFREG);
    archive_entry_set_perm(entry, 0644);
    archive_entry_set_mtime(entry, 0, 0);
    archive_entry_set_size(entry, size);
    return archive_write_header(a, entry) == ARCHIVE_OK ? put_bytes(a, content, size) : cannot_write(a);
}

ll_status ll_tar_write(FILE *archive, const char *const *names, FILE *const *contents, int count)
{
    struct archive *a = archive_write_new();
    struct archive_entry *entry = archive_entry_new();
    ll_status status = a && entry ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: archive");
    if (!ll_failed(&status) && (archive_write_set_format_ustar(a) != ARCHIVE_OK ||
                                archive_write_set_bytes_in_last_block(a, 1) != ARCHIVE_OK ||
                                archive_write_open_FILE(a, archive) != ARCHIVE_OK))
        status = cannot_write(a);
    for (int i = 0; i < count; i++)
        LL_THEN(status, put_member(a, entry, names[i], contents[i]));
    if (!ll_failed(&status) && (archive_write_close(a) != ARCHIVE_OK || fflush(archive) != 0))
        status = cannot_write(a);
    archive_entry_free(entry);
    archive_write_free(a);
    return status;
}

/* ---- reading ---- */

static ll_status damaged(int64_t at, const char *what)
{
    return ll_error(LL_BAD_INPUT, "archive: %s, at byte %" PRId64, what, at);
}

/* Letters, digits, `_`, `-` and dots, first a letter: no path, and nothing that a terminal would act on. */
static bool is_plain(const char *name)
{
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
    size_t length = strlen(name);
    return length > 0 && length <= LL_TAR_NAME_MAX && strspn(name, letters) > 0 &&
           strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.-") == length;
}

/* Only zeros from `at` to `end`. */
static ll_status check_zeros(FILE *archive, int64_t at, int64_t end, const char *where)
{
    if (fseeko(archive, at, SEEK_SET) != 0)
        return ll_error(LL_IO, "cannot read the archive");
    for (; at < end; at++) {
        int byte = getc(archive);
        if (byte == EOF)
            return ll_error(LL_IO, "cannot read the archive");
        if (byte != 0)
            return ll_error(LL_BAD_INPUT, "archive: there must be only zeros behind %s, at byte %" PRId64,
                            where, at);
    }
    return ll_ok();
}

/* What fills the last block of each member, and the end. Nothing stands between two members. */
static ll_status check_rest(FILE *archive, const ll_tar_member *members, int count, int64_t size)
{
    int64_t at = 0;
    for (int i = 0; i < count; i++) {
        const ll_tar_member *m = &members[i];
        if (m->offset != at + LL_TAR_BLOCK)
            return damaged(at, "a member must have one header, and nothing before it");
        at = m->offset + up_to_block(m->size);
        LL_TRY(check_zeros(archive, m->offset + m->size, at, "a member"));
    }
    if (size - at < 2 * LL_TAR_BLOCK)
        return damaged(at, "it must end with two blocks of zeros; it is cut off");
    return check_zeros(archive, at, size, "the last member");
}

static ll_status read_entry(struct archive *a, struct archive_entry *entry, int64_t size,
                            ll_tar_member *members, int count)
{
    int64_t at = archive_read_header_position(a);
    const char *name = archive_entry_pathname(entry);
    if (count == LL_TAR_MEMBERS_MAX)
        return damaged(at, "it has too many members");
    if (archive_format(a) != ARCHIVE_FORMAT_TAR_USTAR)
        return damaged(at, "a header must be of the format ustar");
    if (archive_entry_filetype(entry) != AE_IFREG || archive_entry_hardlink(entry))
        return damaged(at, "a member must be a plain file");
    if (!name || !is_plain(name))
        return damaged(at, "a member's name must be letters, digits, _, - and dots, first a letter");
    for (int i = 0; i < count; i++)
        if (strcmp(members[i].name, name) == 0)
            return ll_error(LL_BAD_INPUT, "archive: has %s twice", name);
    ll_tar_member *member = &members[count];
    snprintf(member->name, sizeof member->name, "%s", name);
    member->offset = at + LL_TAR_BLOCK;
    member->size = archive_entry_size(entry);
    if (member->size >= 0 && member->size <= size && up_to_block(member->size) <= size - member->offset)
        return ll_ok();
    return ll_error(LL_BAD_INPUT,
                    "archive: %s should have %" PRId64 " bytes, but the file ends before: it is cut off",
                    name, member->size);
}

static ll_status no_tar(struct archive *a)
{
    const char *why = archive_error_string(a);
    return ll_error(LL_BAD_INPUT, "archive: it is damaged, cut off, or no tar file: %.200s",
                    why ? why : "libarchive does not say more");
}

static ll_status read_entries(struct archive *a, int64_t size, ll_tar_member *members, int *count)
{
    struct archive_entry *entry;
    for (;;) {
        int found = archive_read_next_header(a, &entry);
        if (found == ARCHIVE_EOF)
            return ll_ok();
        if (found != ARCHIVE_OK)
            return no_tar(a);
        LL_TRY(read_entry(a, entry, size, members, *count));
        ++*count;
    }
}

ll_status ll_tar_list(FILE *archive, ll_tar_member members[LL_TAR_MEMBERS_MAX], int *count)
{
    int64_t size = fseeko(archive, 0, SEEK_END) == 0 ? ftello(archive) : -1;
    *count = 0;
    if (size < 0)
        return ll_error(LL_BAD_INPUT, "archive: must be a file, not a stream");
    if (size == 0)
        return damaged(0, "it is empty");
    rewind(archive);
    struct archive *a = archive_read_new();
    ll_status status = a ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: archive");
    if (a && (archive_read_support_format_tar(a) != ARCHIVE_OK ||
              archive_read_open_FILE(a, archive) != ARCHIVE_OK))
        status = no_tar(a);
    LL_THEN(status, read_entries(a, size, members, count));
    archive_read_free(a);
    LL_THEN(status, check_rest(archive, members, *count, size));
    return status;
}
