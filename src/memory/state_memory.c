#define _DEFAULT_SOURCE /* madvise; NOLINT(bugprone-reserved-identifier) */
#include "memory/state_memory.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>

#include "base/assert.h"

enum {
    PAGE = 4096,
    HUGE = 2 << 20,
    REGION = 64 << 20, /* address space that is reserved at a time */
    PAGES = REGION / PAGE,
    LEAST = 16 << 10, /* smaller blocks are malloc's */
    HEAD = 64,        /* before each block; keeps its alignment */
};

/* A run of pages, all used or all free; neighbours of a free one are used. */
typedef struct span {
    struct span *next, *previous; /* in the region, by address */
    int first, count;
    bool used;
} span;

typedef struct region {
    struct region *next;
    char *pages;
    span *spans;
} region;

typedef struct head {
    region *of; /* NULL: malloc's */
    span *at;
} head;

_Static_assert(sizeof(head) <= HEAD, "a head fits before its block");

/* Address sanitizer sees the bounds of malloc's blocks only. */
#if defined(__SANITIZE_ADDRESS__)
static const bool separately = true;
#else
static const bool separately = false;
#endif

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static region *regions;

static void *block_at(void *at, region *of, span *pages)
{
    if (at == NULL)
        return NULL;
    *(head *)at = (head){of, pages};
    return (char *)at + HEAD;
}

/* ---- regions: locked ---- */

static region *add_region(void)
{
    region *r = calloc(1, sizeof *r);
    span *all = calloc(1, sizeof *all);
    char *at = r && all ? mmap(NULL, REGION + HUGE, PROT_READ | PROT_WRITE,
                               MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0)
                        : MAP_FAILED;
    if (at == MAP_FAILED) {
        free(r);
        free(all);
        return NULL;
    }
    size_t before = (HUGE - (uintptr_t)at % HUGE) % HUGE;
    if (before > 0)
        munmap(at, before);
    munmap(at + before + REGION, HUGE - before);
    madvise(at + before, REGION, MADV_HUGEPAGE); /* small pages do too */
    *all = (span){.count = PAGES};
    *r = (region){.next = regions, .pages = at + before, .spans = all};
    return regions = r;
}

/* Uses the first pages of a free span; the others become a span of their own. False without memory. */
static bool use(span *s, int pages)
{
    if (s->count > pages) {
        span *rest = malloc(sizeof *rest);
        if (rest == NULL)
            return false;
        *rest = (span){s->next, s, s->first + pages, s->count - pages, false};
        if (s->next != NULL)
            s->next->previous = rest;
        s->next = rest;
        s->count = pages;
    }
    s->used = true;
    return true;
}

static span *take_from(const region *r, int pages)
{
    for (span *s = r->spans; s != NULL; s = s->next)
        if (!s->used && s->count >= pages)
            return use(s, pages) ? s : NULL;
    return NULL;
}

/* The second of two neighbours goes into the first. */
static void join(span *first)
{
    span *second = first->next;
    LL_ASSERT(first->first + first->count == second->first);
    first->count += second->count;
    first->next = second->next;
    if (second->next != NULL)
        second->next->previous = first;
    free(second);
}

/* Gives the huge pages back that have become free with the pages from `first` on. */
static void give_back(const region *r, const span *free_now, int first, int count)
{
    enum { EACH = HUGE / PAGE };
    int from = first / EACH * EACH, to = (first + count + EACH - 1) / EACH * EACH;
    int least = (free_now->first + EACH - 1) / EACH * EACH,
        most = (free_now->first + free_now->count) / EACH * EACH;
    from = from > least ? from : least;
    to = to < most ? to : most;
    if (from < to)
        madvise(r->pages + (size_t)from * PAGE, (size_t)(to - from) * PAGE, MADV_DONTNEED);
}

/* A region of which nothing is used. */
static void drop_region(region *r)
{
    region **at = &regions;
    while (*at != r)
        at = &(*at)->next;
    *at = r->next;
    munmap(r->pages, REGION);
    free(r->spans);
    free(r);
}

static void free_span(region *r, span *s)
{
    int first = s->first, count = s->count;
    LL_ASSERT(s->used);
    s->used = false;
    if (s->next != NULL && !s->next->used)
        join(s);
    if (s->previous != NULL && !s->previous->used) {
        s = s->previous;
        join(s);
    }
    if (s->count == PAGES)
        drop_region(r);
    else
        give_back(r, s, first, count);
}

/* ---- for any thread ---- */

/* Of what no region can hold. */
static void *large_block(size_t size)
{
    void *at = aligned_alloc(HUGE, (size + HEAD + HUGE - 1) / HUGE * HUGE);
    if (at != NULL)
        madvise(at, size + HEAD, MADV_HUGEPAGE); /* a wish: nothing depends on it */
    return block_at(at, NULL, NULL);
}

void *ll_state_memory_new(size_t size)
{
    return size < LEAST ? block_at(malloc(size + HEAD), NULL, NULL) : ll_state_memory_new_pages(size);
}

void *ll_state_memory_new_pages(size_t size)
{
    size_t wanted = (size + HEAD + PAGE - 1) / PAGE;
    if (separately)
        return block_at(malloc(size + HEAD), NULL, NULL);
    if (wanted > PAGES)
        return large_block(size);
    int pages = (int)wanted;
    pthread_mutex_lock(&lock);
    region *r = regions;
    span *s = NULL;
    while (r != NULL && (s = take_from(r, pages)) == NULL)
        r = r->next;
    if (s == NULL && (r = add_region()) != NULL)
        s = take_from(r, pages);
    pthread_mutex_unlock(&lock);
    return s == NULL ? block_at(malloc(size + HEAD), NULL, NULL)
                     : block_at(r->pages + (size_t)s->first * PAGE, r, s);
}

void ll_state_memory_free(void *block)
{
    if (block == NULL)
        return;
    void *at = (char *)block - HEAD;
    head h = *(head *)at;
    if (h.of == NULL) {
        free(at);
        return;
    }
    pthread_mutex_lock(&lock);
    free_span(h.of, h.at);
    pthread_mutex_unlock(&lock);
}
