/* The main of a room's tests: `test_ROOM GROUP [ARGUMENTS]` runs the group of tests/ROOM/test_GROUP.c,
 * `test_ROOM` all, each in a process of its own, so that limits, handlers and static data of one do not reach
 * the next. */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define GROUP(name) int test_group_##name(int count, char **arguments);
#include GROUPS
#undef GROUP

typedef struct group {
    const char *name;
    int (*run)(int count, char **arguments);
} group;

static const group groups[] = {
#define GROUP(name) {#name, test_group_##name},
#include GROUPS
};

enum { GROUP_COUNT = sizeof groups / sizeof *groups };

static bool passes_alone(const group *g)
{
    char name[64];
    snprintf(name, sizeof name, "%s", g->name);
    fflush(NULL);
    pid_t child = fork();
    if (child == 0)
        exit(g->run(1, (char *[]){name, NULL}));
    int status = 1;
    return child > 0 && waitpid(child, &status, 0) == child && status == 0;
}

static int run_all(void)
{
    int failed = 0;
    for (int i = 0; i < GROUP_COUNT; i++) {
        if (!passes_alone(&groups[i])) {
            fprintf(stderr, "%s failed\n", groups[i].name);
            failed++;
        }
    }
    printf("%d of %d groups passed\n", GROUP_COUNT - failed, GROUP_COUNT);
    return failed > 0;
}

int main(int argc, char **argv)
{
    if (argc == 1)
        return run_all();
    for (int i = 0; i < GROUP_COUNT; i++) {
        if (strcmp(groups[i].name, argv[1]) == 0)
            return groups[i].run(argc - 1, argv + 1);
    }
    fprintf(stderr, "no group \"%s\"; there are:", argv[1]);
    for (int i = 0; i < GROUP_COUNT; i++)
        fprintf(stderr, " %s", groups[i].name);
    fputc('\n', stderr);
    return 2;
}
