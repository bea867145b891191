#include <stdio.h>
#include <string.h>

#include "param/internal.h"

#define NAME_SHOWN 48 /* bytes of a name in messages; real names are shorter */

ll_path ll_path_root(const ll_param_table *table)
{
    return (ll_path){.root = table->name};
}

int ll_path_push(ll_path *path, const char *name, size_t length)
{
    int before = path->length;
    ll_writer writer = {path->text, sizeof path->text, (size_t)path->length};
    if (before > 0)
        ll_append(&writer, ".");
    ll_append_printable(&writer, name, length, NAME_SHOWN);
    path->length = (int)writer.used;
    return before;
}

int ll_path_push_index(ll_path *path, int index)
{
    char name[16];
    snprintf(name, sizeof name, "%d", index);
    return ll_path_push(path, name, strlen(name));
}

void ll_path_pop(ll_path *path, int length)
{
    path->length = length;
    path->text[length] = '\0';
}

const char *ll_path_subject(const ll_path *path)
{
    return path->length > 0 ? path->text : path->root;
}
