/* An experiment as one file, which another machine verifies.
 *
 * A tar file with the members of `ll_archive_names`, in this order: the manifest (format, version with the
 * fingerprint of the sources, counts, container, and size and SHA-256 of each file), the specification with
 * its scenario, the rows as CSV and with all bits (rows.h), the report, how to cite, and the digests of all
 * of these for `sha256sum -c`. Equal rows give equal bytes: nothing in it depends on time, machine or user.
 */
#pragma once

#include <stdio.h>

#include "base/interrupt.h"
#include "base/version.h"
#include "experiment/store/result_store.h"

enum { LL_CONTAINER_MAX = 160 };

typedef enum ll_archive_file {
    LL_ARCHIVE_MANIFEST,
    LL_ARCHIVE_SPECIFICATION,
    LL_ARCHIVE_CSV,
    LL_ARCHIVE_ROWS,
    LL_ARCHIVE_REPORT,
    LL_ARCHIVE_CITATION,
    LL_ARCHIVE_DIGESTS,
    LL_ARCHIVE_FILES
} ll_archive_file;

extern const char *const ll_archive_names[LL_ARCHIVE_FILES];

typedef struct ll_archive_wish {
    const char *container; /* digest of the image that made the rows, as sha256: and 64 hexadecimal digits;
                              NULL: unknown */
    const char *folder;    /* for temporary files; in memory where it cannot be written */
    const ll_interrupt *interrupt; /* NULL: none */
} ll_archive_wish;

/* Writes the experiment `id` of a store, all of whose rows must be there, to the end of an open file. */
ll_status ll_archive_write_to(ll_result_store *store, const char *id, const ll_archive_wish *wish,
                              FILE *file);

/* The same as the file `path`, under a temporary name until it is complete. */
ll_status ll_archive_write(ll_result_store *store, const char *id, const char *container, const char *path);

/* LL_BAD_INPUT: not such a digest. */
ll_status ll_archive_container(const char *field, const char *container);

typedef struct ll_archive_check {
    int64_t rows;                                        /* to run again, chosen at random; 0: all */
    uint64_t seed;                                       /* of the choice */
    bool any_version;                                    /* another version is no difference */
    void (*tell)(void *context, const char *difference); /* a sentence for each */
    void *context;
} ll_archive_check;

typedef struct ll_archive_result {
    char version[LL_VERSION_MAX + 1],
        container[LL_CONTAINER_MAX + 1];              /* of the archive; container empty: unknown */
    int64_t rows, compared, equal, skipped, measured; /* skipped: of those chosen, rows that `until` left out.
                                                         measured: metrics that differ each time */
    bool report_compared;                             /* only a report of the same version */
    int differences;                                  /* that were reported */
} ll_archive_result;

/* Checks the file, its digests and its version, that CSV and report are those of the rows, and runs rows
 * again. Writes no file. LL_BAD_INPUT: the archive is damaged or no archive, and nothing of it was run.
 * Differences of a sound archive are reported and counted. */
ll_status ll_archive_verify(const char *path, const ll_archive_check *check, ll_archive_result *result);
