#include "memory/state_memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

enum { BLOCKS = 300, ROUNDS = 2000 };

static size_t size_of(int n)
{
    static const size_t sizes[] = {1000, 65536, 70000, 475376, 262872, 3 << 20};
    return sizes[(size_t)n % (sizeof sizes / sizeof *sizes)] + (size_t)n % 7 * 8;
}

static void fill(uint64_t *block, int n)
{
    size_t count = size_of(n) / sizeof *block;
    block[0] = block[count / 2] = block[count - 1] = (uint64_t)n;
}

static bool is_intact(const uint64_t *block, int n)
{
    size_t count = size_of(n) / sizeof *block;
    return block[0] == (uint64_t)n && block[count / 2] == (uint64_t)n && block[count - 1] == (uint64_t)n;
}

static void blocks_do_not_overlap_whatever_is_freed_between(void **state)
{
    (void)state;
    uint64_t *block[BLOCKS] = {0};
    int number[BLOCKS];
    uint32_t random = 1;
    for (int i = 0; i < ROUNDS; i++) {
        random = random * 1664525 + 1013904223;
        int k = (int)(random >> 8) % BLOCKS;
        if (block[k] != NULL)
            assert_true(is_intact(block[k], number[k]));
        ll_state_memory_free(block[k]);
        number[k] = i;
        block[k] = ll_state_memory_new(size_of(i));
        assert_non_null(block[k]);
        assert_int_equal((uintptr_t)block[k] % 16, 0);
        fill(block[k], i);
    }
    for (int k = 0; k < BLOCKS; k++) {
        assert_true(block[k] == NULL || is_intact(block[k], number[k]));
        ll_state_memory_free(block[k]);
    }
}

static void a_block_larger_than_a_region_is_there_too(void **state)
{
    (void)state;
    size_t size = (size_t)200 << 20;
    char *block = ll_state_memory_new(size);
    assert_non_null(block);
    block[0] = block[size - 1] = 1;
    ll_state_memory_free(block);
    ll_state_memory_free(NULL);
}

/* Pages of address space of this process. */
static long pages_mapped(void)
{
    long pages = 0;
    FILE *f = fopen("/proc/self/statm", "r");
    assert_non_null(f);
    assert_int_equal(fscanf(f, "%ld", &pages), 1);
    fclose(f);
    return pages;
}

static void what_is_free_is_mapped_no_more(void **state)
{
    (void)state;
    enum { EACH = 3 << 20, COUNT = 400, PAGE = 4096 };
    static void *block[COUNT];
    long before = pages_mapped();
    for (int i = 0; i < COUNT; i++)
        assert_non_null(block[i] = ll_state_memory_new(EACH));
    assert_true(pages_mapped() - before >= (long)COUNT * (EACH / PAGE));
    for (int i = 0; i < COUNT; i++)
        ll_state_memory_free(block[i]);
    assert_true(pages_mapped() - before < (long)COUNT * (EACH / PAGE) / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_do_not_overlap_whatever_is_freed_between),
        cmocka_unit_test(a_block_larger_than_a_region_is_there_too),
        cmocka_unit_test(what_is_free_is_mapped_no_more),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
