/* For the files of this room. */
#pragma once

#include "experiment/archive/archive.h"
#include "experiment/archive/sha256.h"
#include "experiment/archive/tar.h"
#include "experiment/format/table.h"

#define LL_ARCHIVE_FORMAT "laglab-archive"
#define LL_ARCHIVE_FORMAT_VERSION 1

typedef struct ll_archive_entry {
    int64_t size;
    char sha256[LL_SHA256_HEX + 1];
} ll_archive_entry;

/* What the manifest says, apart from what follows from the specification. */
typedef struct ll_archive_about {
    const char *version, *container; /* container empty: unknown */
    const ll_archive_entry *entries; /* by ll_archive_file */
} ll_archive_about;

/* The manifest of these files, the text of a version's CITATION.cff, and the list of digests. */
ll_status ll_archive_put_manifest(const ll_experiment *experiment, const ll_archive_about *about, FILE *file);
void ll_archive_put_citation(const char *version, FILE *file);
void ll_archive_put_digests(const ll_archive_entry *entries, FILE *file);

/* A file that follows from the rows, of any source of these. */
typedef ll_status ll_archive_put(const ll_experiment *experiment, const char *version, ll_row_source *source,
                                 void *context, FILE *file);
ll_archive_put ll_archive_put_csv, ll_archive_put_report;
