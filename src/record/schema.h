/* The tables as JSON, for decoders in other programs or versions. */
#pragma once

#include "record/record.h"

struct cJSON;

/* {"protocol","records":[{"id","name","channel","form","keys","help","fields":[{"name","type","coding",
 * "bits","unit","names","flags","help"}]}]}, in the given order, without empty members. Caller deletes; NULL
 * without memory. */
struct cJSON *ll_record_schema(const ll_record *const *records);

/* Hash of the schema, printed without spaces: programs with equal hashes can read each other's streams. */
uint64_t ll_record_schema_hash(const ll_record *const *records);
