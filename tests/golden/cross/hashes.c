/* Writes lines of tests/golden/hashes.csv: `hashes ID...`. It has its own main, because cmocka is not
 * available for every CPU. */
#include <stdio.h>

#include "base/version.h"
#include "support/golden.h"

const char ll_version[] = "cross";

int main(int argc, char **argv)
{
    int failed = 0;
    for (int i = 1; i < argc; i++) {
        char line[GOLDEN_LINE_MAX];
        ll_status status = golden_line(argv[i], line);
        if (ll_failed(&status)) {
            fprintf(stderr, "%s: %s\n", argv[i], status.text);
            failed++;
        } else {
            puts(line);
            fflush(stdout);
        }
    }
    return failed > 0;
}
