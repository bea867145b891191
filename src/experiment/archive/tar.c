#include "experiment/archive/tar.h"

#include <inttypes.h>
#include <stdbool.h>
#include <string.h>

#define SIZE_MAX_BYTES INT64_C(077777777777) /* eleven octal digits */

/* Offsets and lengths of a header's fields. */
enum {
    NAME = 0,
    MODE = 100,
    UID = 108,
    GID = 116,
    SIZE = 124,
    SIZE_DIGITS = 11,
    MTIME = 136,
    CHECKSUM = 148,
    CHECKSUM_LENGTH = 8,
    TYPE = 156,
    MAGIC = 257,
    DEVICES = 329,
    PREFIX = 345,
    PREFIX_LENGTH = 155
};

static const char magic[] = "ustar\00000"; /* ustar, NUL, version 00 */

static unsigned sum_of(const unsigned char block[LL_TAR_BLOCK])
{
    unsigned sum = 0;
    for (int i = 0; i < LL_TAR_BLOCK; i++)
        sum += i >= CHECKSUM && i < CHECKSUM + CHECKSUM_LENGTH ? ' ' : block[i];
    return sum;
}

static void put_checksum(unsigned char block[LL_TAR_BLOCK])
{
    char text[12];
    snprintf(text, sizeof text, "%06o", sum_of(block));
    memcpy(block + CHECKSUM, text, 7); /* with its NUL */
    block[CHECKSUM + 7] = ' ';
}

static void put(unsigned char *block, int at, const char *text)
{
    memcpy(block + at, text, strlen(text));
}

/* ---- writing ---- */

static void make_header(unsigned char block[LL_TAR_BLOCK], const char *name, int64_t size)
{
    char text[24];
    memset(block, 0, LL_TAR_BLOCK);
    put(block, NAME, name);
    put(block, MODE, "0000644");
    put(block, UID, "0000000");
    put(block, GID, "0000000");
    snprintf(text, sizeof text, "%011" PRIo64, size);
    put(block, SIZE, text);
    put(block, MTIME, "00000000000");
    block[TYPE] = '0';
    memcpy(block + MAGIC, magic, sizeof magic - 1);
    put(block, DEVICES, "0000000");
    put(block, DEVICES + 8, "0000000");
    put_checksum(block);
}

static ll_status cannot_write(void)
{
    return ll_error(LL_IO, "cannot write the archive: the disk is full");
}

static ll_status copy(FILE *archive, FILE *content, int64_t size)
{
    unsigned char buffer[LL_TAR_BLOCK * 64];
    rewind(content);
    while (size > 0) {
        size_t wanted = size < (int64_t)sizeof buffer ? (size_t)size : sizeof buffer;
        size_t padded = (wanted + LL_TAR_BLOCK - 1) / LL_TAR_BLOCK * LL_TAR_BLOCK;
        if (fread(buffer, 1, wanted, content) != wanted)
            return ll_error(LL_IO, "cannot read a temporary file");
        memset(buffer + wanted, 0, padded - wanted);
        if (fwrite(buffer, 1, padded, archive) != padded)
            return cannot_write();
        size -= (int64_t)wanted;
    }
    return ll_ok();
}

ll_status ll_tar_add(FILE *archive, const char *name, FILE *content)
{
    unsigned char block[LL_TAR_BLOCK];
    int64_t size = fflush(content) == 0 && fseeko(content, 0, SEEK_END) == 0 ? ftello(content) : -1;
    if (size < 0)
        return ll_error(LL_IO, "cannot write a temporary file: the disk is full");
    if (size > SIZE_MAX_BYTES)
        return ll_error(LL_LIMIT, "%s: must have at most %" PRId64 " bytes in an archive; has %" PRId64, name,
                        SIZE_MAX_BYTES, size);
    make_header(block, name, size);
    return fwrite(block, 1, sizeof block, archive) == sizeof block ? copy(archive, content, size)
                                                                   : cannot_write();
}

ll_status ll_tar_end(FILE *archive)
{
    static const unsigned char zeros[2 * LL_TAR_BLOCK] = {0};
    bool good = fwrite(zeros, 1, sizeof zeros, archive) == sizeof zeros && fflush(archive) == 0;
    return good ? ll_ok() : cannot_write();
}

/* ---- reading ---- */

static ll_status damaged(int64_t at, const char *what)
{
    return ll_error(LL_BAD_INPUT, "archive: %s, at byte %" PRId64, what, at);
}

/* A whole number of exactly `digits` octal digits, then a NUL or a space; -1: it is none. */
static int64_t octal(const unsigned char *text, int digits)
{
    int64_t value = 0;
    for (int i = 0; i < digits; i++) {
        if (text[i] < '0' || text[i] > '7')
            return -1;
        value = value * 8 + (text[i] - '0');
    }
    return text[digits] == '\0' || text[digits] == ' ' ? value : -1;
}

static bool is_zero(const unsigned char *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++)
        if (bytes[i] != 0)
            return false;
    return true;
}

/* Letters, digits, `_`, `-` and dots, first a letter: no path, and nothing that a terminal would act on. */
static bool is_plain(const char *name)
{
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
    size_t length = strlen(name);
    return length > 0 && strspn(name, letters) > 0 &&
           strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.-") == length;
}

static bool is_sound(const unsigned char block[LL_TAR_BLOCK])
{
    unsigned char right[LL_TAR_BLOCK];
    memcpy(right, block, sizeof right);
    put_checksum(right);
    return memcmp(right, block, sizeof right) == 0;
}

static ll_status read_header(const unsigned char block[LL_TAR_BLOCK], int64_t at, ll_tar_member *member)
{
    if (!is_sound(block))
        return damaged(at, "a header is damaged, or this is no tar file");
    if (memcmp(block + MAGIC, magic, sizeof magic - 1) != 0)
        return damaged(at, "a header must be of the format ustar");
    if (block[TYPE] != '0')
        return damaged(at, "a member must be a plain file");
    if (!is_zero(block + PREFIX, PREFIX_LENGTH) || memchr(block + NAME, '\0', LL_TAR_NAME_MAX + 1) == NULL)
        return damaged(at, "a member must have a short name without a path");
    memcpy(member->name, block + NAME, sizeof member->name); /* with its NUL */
    if (!is_plain(member->name))
        return damaged(at, "a member's name must be letters, digits, _, - and dots, first a letter");
    member->offset = at + LL_TAR_BLOCK;
    member->size = octal(block + SIZE, SIZE_DIGITS);
    return member->size < 0 ? damaged(at, "a member must have its size in octal digits") : ll_ok();
}

/* Only zeros up to the end of the file. */
static ll_status read_end(FILE *archive, int64_t at, int64_t size)
{
    unsigned char block[LL_TAR_BLOCK];
    if (size - at < 2 * LL_TAR_BLOCK)
        return damaged(at, "it must end with two blocks of zeros; it is cut off");
    if (fseeko(archive, at, SEEK_SET) != 0)
        return ll_error(LL_IO, "cannot read the archive");
    while (at < size) {
        size_t wanted = size - at < LL_TAR_BLOCK ? (size_t)(size - at) : LL_TAR_BLOCK;
        if (fread(block, 1, wanted, archive) != wanted)
            return ll_error(LL_IO, "cannot read the archive");
        if (!is_zero(block, wanted))
            return damaged(at, "there must be only zeros behind the last member");
        at += LL_TAR_BLOCK;
    }
    return ll_ok();
}

/* What fills the member's last block. */
static ll_status check_padding(FILE *archive, const ll_tar_member *member, int64_t next)
{
    unsigned char block[LL_TAR_BLOCK];
    int64_t end = member->offset + member->size;
    size_t wanted = (size_t)(next - end);
    if (fseeko(archive, end, SEEK_SET) != 0 || fread(block, 1, wanted, archive) != wanted)
        return ll_error(LL_IO, "cannot read the archive");
    return is_zero(block, wanted) ? ll_ok() : damaged(end, "there must be zeros behind a member");
}

static ll_status check_name(const ll_tar_member *members, int count)
{
    for (int i = 0; i < count; i++)
        if (strcmp(members[i].name, members[count].name) == 0)
            return ll_error(LL_BAD_INPUT, "archive: has %s twice", members[i].name);
    return ll_ok();
}

/* Reads a member at `*at`, and moves that behind it. */
static ll_status read_member(FILE *archive, const unsigned char *block, int64_t size, ll_tar_member *members,
                             int count, int64_t *at)
{
    if (count == LL_TAR_MEMBERS_MAX)
        return damaged(*at, "it has too many members");
    ll_tar_member *member = &members[count];
    LL_TRY(read_header(block, *at, member));
    LL_TRY(check_name(members, count));
    int64_t blocks = member->size / LL_TAR_BLOCK + (member->size % LL_TAR_BLOCK != 0);
    int64_t next = member->offset + blocks * LL_TAR_BLOCK;
    if (next > size)
        return ll_error(LL_BAD_INPUT,
                        "archive: %s should have %" PRId64 " bytes, but the file ends before: it is cut off",
                        member->name, member->size);
    *at = next;
    return check_padding(archive, member, next);
}

ll_status ll_tar_list(FILE *archive, ll_tar_member members[LL_TAR_MEMBERS_MAX], int *count)
{
    unsigned char block[LL_TAR_BLOCK];
    int64_t size = fseeko(archive, 0, SEEK_END) == 0 ? ftello(archive) : -1;
    *count = 0;
    if (size < 0)
        return ll_error(LL_BAD_INPUT, "archive: must be a file, not a stream");
    for (int64_t at = 0;;) {
        if (size - at < LL_TAR_BLOCK)
            return damaged(at, size == 0 ? "it is empty" : "it is cut off");
        if (fseeko(archive, at, SEEK_SET) != 0 || fread(block, 1, sizeof block, archive) != sizeof block)
            return ll_error(LL_IO, "cannot read the archive");
        if (is_zero(block, sizeof block))
            return read_end(archive, at, size);
        LL_TRY(read_member(archive, block, size, members, *count, &at));
        ++*count;
    }
}
