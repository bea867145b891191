#include "library/program.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

void ll_program_sibling(const char *name, char *path, size_t size)
{
    char program[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    program[length > 0 ? length : 0] = '\0';
    char *slash = strrchr(program, '/');
    if (slash)
        *slash = '\0';
    int written = slash ? snprintf(path, size, "%s/%s", program, name) : -1;
    if (written < 0 || (size_t)written >= size)
        snprintf(path, size, "%s", name);
}
