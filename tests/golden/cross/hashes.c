/* Lines of tests/golden/hashes.csv, made anew: `hashes ID...`. Its own main, as cmocka is not there for every
 * CPU. */
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
