/* The tables as JSON: what a decoder that was made before, or elsewhere, reads the stream by. */
#pragma once

#include "record/record.h"

struct cJSON;

/* {"protocol","records":[{"id","name","channel","form","keys","help","fields":[{"name","type","coding",
 * "bits","unit","names","flags","help"}]}]}, in the order given; what is empty is left out. Caller deletes;
 * NULL without memory. */
struct cJSON *ll_record_schema(const ll_record *const *records);

/* Of the schema as it is printed without spaces: two programs with the same one read each other. */
uint64_t ll_record_schema_hash(const ll_record *const *records);
