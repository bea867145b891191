/* 64-bit hash of state: the same on every machine and compiler. Not cryptographic. */
#pragma once

#include <stddef.h>
#include <stdint.h>

uint64_t ll_hash(uint64_t seed, const void *bytes, size_t size);
uint64_t ll_hash_u64(uint64_t seed, uint64_t value);
