/* A program of two loops for the test of the guard: trace_rows has a quarter of the instructions, carry_rows
 * the rest. With -DAGAIN=n each n-th row of trace_rows is computed twice, to the same result; -DINLINED=1
 * leaves the compiler free to inline it. selftest TURNS */
#include <stdio.h>
#include <stdlib.h>

enum { ROWS = 200, COLUMNS = 50 };

#if INLINED
#define CALLED
#else
#define CALLED __attribute__((noinline))
#endif

static unsigned field[ROWS][COLUMNS];

static void trace_row(unsigned *row)
{
    for (int i = 1; i < COLUMNS; i++)
        row[i] = (row[i] & 1) + (row[0] ^ (unsigned)i);
}

static CALLED void trace_rows(void)
{
    for (int j = 0; j < ROWS; j++) {
        trace_row(field[j]);
#ifdef AGAIN
        if (j % AGAIN == 0)
            trace_row(field[j]);
#endif
    }
}

static __attribute__((noinline)) unsigned carry_rows(unsigned seed)
{
    for (int j = 0; j < ROWS; j++)
        for (int i = 0; i < COLUMNS; i++)
            for (int k = 0; k < 4; k++)
                seed = (seed ^ field[j][i]) * 2654435761U + (seed >> 15);
    return seed;
}

int main(int argc, char **argv)
{
    unsigned seed = 1;
    for (int turn = argc == 2 ? atoi(argv[1]) : 0; turn > 0; turn--) {
        trace_rows();
        seed = carry_rows(seed);
    }
    printf("%u\n", seed);
    return 0;
}
