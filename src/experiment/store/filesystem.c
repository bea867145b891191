#include "experiment/store/filesystem.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

/* A line of /proc/self/mountinfo: ID PARENT MAJOR:MINOR ROOT POINT OPTIONS [MORE...] - TYPE SOURCE OPTIONS.
 */
static bool read_line(const char *line, dev_t device, char *type, size_t size)
{
    unsigned int high, low;
    const char *dash = strstr(line, " - ");
    if (!dash || sscanf(line, "%*s %*s %u:%u", &high, &low) != 2 || makedev(high, low) != device)
        return false;
    snprintf(type, size, "%.*s", (int)strcspn(dash + 3, " "), dash + 3);
    return true;
}

void ll_filesystem_type(const char *folder, char *type, size_t size)
{
    struct stat file;
    char *line = NULL;
    size_t capacity = 0;
    FILE *mounts = fopen("/proc/self/mountinfo", "re");
    bool found = !mounts || stat(folder, &file) != 0;
    type[0] = '\0';
    while (!found && getline(&line, &capacity, mounts) > 0)
        found = read_line(line, file.st_dev, type, size);
    free(line);
    if (mounts)
        fclose(mounts);
}

bool ll_filesystem_is_remote(const char *type)
{
    static const char *const remote[] = {
        "nfs",         "nfs4",   "cifs",      "smb3",           "afs",         "ceph",           "lustre",
        "gpfs",        "beegfs", "pvfs2",     "coda",           "fuse.sshfs",  "fuse.glusterfs", "fuse.s3fs",
        "fuse.rclone", "ncpfs",  "fuse.ceph", "fuse.ceph-fuse", "fuse.gcsfuse"};
    for (size_t i = 0; i < sizeof remote / sizeof remote[0]; i++)
        if (strcmp(type, remote[i]) == 0)
            return true;
    return false;
}
