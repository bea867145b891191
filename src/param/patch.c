/* A patch is walked four times, by one walker:
 *   1. set the choices that other values depend on; errors wait,
 *   2. set everything, then check the rules between values,
 *   3. and 4. report the changes, those choices first: applied one by one, they give the same object.
 * Values are set in the order of the rows, since a value may depend on earlier rows, and an array before
 * changes of its elements: the order of the document does not matter. All of it works on a copy, which
 * replaces the object at the end. */
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "param/internal.h"

typedef enum pass { SET_GOVERNING, SET_ALL, TELL_GOVERNING, TELL_REST } pass;

typedef struct walk {
    pass pass;
    const ll_patch_options *options;
    char *object;  /* the copy */
    char *touched; /* flags by offset of the values set: a value may be given in several ways */
    char *fresh;   /* flags by offset of the arrays replaced since the first walk */
    ll_path path;
} walk;

static ll_status patch_place(walk *w, const ll_json_location *place, const cJSON *json);

static ll_status tell(walk *w, const ll_json_location *place)
{
    if (w->options->change == NULL)
        return ll_ok();
    cJSON *value = ll_write_value(place->row, place->member);
    char *text = value == NULL ? NULL : cJSON_PrintUnformatted(value);
    cJSON_Delete(value);
    if (text == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory");
    ll_status status = w->options->change(w->options->context, w->path.text, text);
    cJSON_free(text);
    return status;
}

static ll_status set_value(walk *w, const ll_json_location *place, const cJSON *json)
{
    char *mark = &w->touched[place->member - w->object];
    if (*mark)
        return ll_field_error(LL_BAD_INPUT, w->path.text, "%s is given twice", w->path.text);
    *mark = 1;
    if (w->options->live_only && !place->live)
        return ll_field_error(LL_CONFLICT, w->path.text, "%s cannot be changed while a session runs",
                              w->path.text);
    return ll_value_set(place, json, &w->path);
}

static ll_status set_governing(walk *w, const ll_json_location *place, const cJSON *json)
{
    int32_t before, after;
    memcpy(&before, place->member, sizeof before);
    ll_status status = ll_value_set(place, json, &w->path);
    memcpy(&after, place->member, sizeof after);
    if (!ll_failed(&status))
        ll_value_follow(place, after != before);
    return status;
}

/* A choice in a new element lost its effects of the first walk. */
static ll_status set_again(walk *w, const ll_json_location *place, const cJSON *json)
{
    ll_status status = set_value(w, place, json);
    if (!ll_failed(&status) && w->fresh[place->member - w->object])
        ll_value_follow(place, true);
    return status;
}

static ll_status patch_value(walk *w, const ll_json_location *place, const cJSON *json)
{
    bool governs = ll_row_governs(place->home_table, place->row);
    switch (w->pass) {
    case SET_GOVERNING:
        return governs ? set_governing(w, place, json) : ll_ok();
    case SET_ALL:
        return governs ? set_again(w, place, json) : set_value(w, place, json);
    case TELL_GOVERNING:
        return governs ? tell(w, place) : ll_ok();
    default:
        return governs ? ll_ok() : tell(w, place);
    }
}

static bool is_repeated(const cJSON *json, const cJSON *item)
{
    for (const cJSON *other = json->child; other != item; other = other->next)
        if (strcmp(other->string, item->string) == 0)
            return true;
    return false;
}

/* A command-line item is text; its row says how to read it. */
static ll_status patch_item(walk *w, const ll_json_location *place, const cJSON *item, bool text)
{
    if (!text)
        return patch_place(w, place, item);
    cJSON *json = ll_read_text(place->row, item->valuestring);
    ll_status status = json == NULL ? ll_error(LL_NO_MEMORY, "out of memory") : patch_place(w, place, json);
    cJSON_Delete(json);
    return status;
}

/* Follows the names in the key of `item`, which may be dotted, from `place`. */
static ll_status patch_member(walk *w, const ll_json_location *place, const cJSON *item)
{
    ll_json_location at = *place;
    const char *name = item->string;
    for (;;) {
        size_t length = strcspn(name, ".");
        ll_json_location next = at;
        if (!ll_json_location_step(&next, name, length)) {
            if (w->pass == SET_GOVERNING) /* it may belong to a variant that is not chosen yet */
                return ll_ok();
            return ll_unknown_name(&w->path, &at, name, length);
        }
        ll_path_push(&w->path, name, length);
        at = next;
        if (name[length] == '\0')
            return patch_item(w, &at, item, w->options->texts && place->row == NULL);
        name += length + 1;
    }
}

/* ---- the order in which members are set ---- */

#define LEVELS_MAX 8 /* names in a key that count for its rank; real paths have fewer */

typedef struct member {
    const cJSON *item;
    int32_t index;            /* in the document */
    int32_t rank[LEVELS_MAX]; /* per name: that of its row or element; -1 after the last */
} member;

/* Rank of the name that leads from `place` to `next`. */
static int32_t rank_of(const ll_json_location *place, const ll_json_location *next)
{
    if (place->kind == LL_LOCATION_ARRAY)
        return (int32_t)((size_t)(next->member - place->member) / next->table->size);
    return (int32_t)(next->row - place->table->rows);
}

/* Names that do not exist come last: they may be in a variant or an element that is not there yet. */
static member ranked(const ll_json_location *place, const cJSON *item, int32_t index)
{
    member m = {.item = item, .index = index};
    ll_json_location at = *place;
    const char *name = item->string;
    for (int level = 0; level < LEVELS_MAX; level++) {
        size_t length = name == NULL ? 0 : strcspn(name, ".");
        ll_json_location next = at;
        if (name == NULL) {
            m.rank[level] = -1;
        } else if (!ll_json_location_step(&next, name, length)) {
            m.rank[level] = INT32_MAX;
            name = NULL;
        } else {
            m.rank[level] = rank_of(&at, &next);
            at = next;
            name = name[length] == '\0' ? NULL : name + length + 1;
        }
    }
    return m;
}

static int by_rank(const void *left, const void *right)
{
    const member *a = left, *b = right;
    for (int level = 0; level < LEVELS_MAX; level++)
        if (a->rank[level] != b->rank[level])
            return a->rank[level] < b->rank[level] ? -1 : 1;
    return a->index < b->index ? -1 : 1;
}

static ll_status patch_one(walk *w, const ll_json_location *place, const cJSON *json, const cJSON *item)
{
    int before = w->path.length;
    if (w->pass == SET_ALL && is_repeated(json, item)) {
        ll_path_push(&w->path, item->string, strlen(item->string));
        return ll_field_error(LL_BAD_INPUT, w->path.text, "%s is given twice", w->path.text);
    }
    ll_status status = patch_member(w, place, item);
    ll_path_pop(&w->path, before);
    return w->pass == SET_GOVERNING ? ll_ok() : status; /* the next pass tries again */
}

static ll_status set_members(walk *w, const ll_json_location *place, const cJSON *json)
{
    int count = cJSON_GetArraySize(json);
    member *members = count > 0 ? malloc((size_t)count * sizeof *members) : NULL;
    if (count > 0 && members == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory");
    int32_t n = 0;
    for (const cJSON *item = json->child; item != NULL; item = item->next, n++)
        members[n] = ranked(place, item, n);
    if (n > 1)
        qsort(members, (size_t)n, sizeof *members, by_rank);
    ll_status status = ll_ok();
    for (int32_t i = 0; i < n && !ll_failed(&status); i++)
        status = patch_one(w, place, json, members[i].item);
    free(members);
    return status;
}

static ll_status patch_members(walk *w, const ll_json_location *place, const cJSON *json)
{
    if (w->pass == SET_GOVERNING || w->pass == SET_ALL)
        return set_members(w, place, json);
    ll_status status = ll_ok();
    for (const cJSON *item = json->child; item != NULL && !ll_failed(&status); item = item->next)
        status = patch_one(w, place, json, item);
    return status;
}

/* ---- arrays ---- */

static ll_status replace_array(walk *w, const ll_json_location *place, const cJSON *json)
{
    if (w->pass > SET_ALL)
        return ll_ok();
    memset(w->fresh + (place->member - w->object), w->pass == SET_ALL,
           (size_t)place->row->max * place->row->child->size);
    return ll_parse_array(place, json, &w->path);
}

static ll_status patch_elements(walk *w, const ll_json_location *place, const cJSON *json)
{
    int count = ll_count_of(place->row, place->home);
    int given = cJSON_GetArraySize(json);
    if (given != count)
        return ll_field_error(LL_BAD_INPUT, w->path.text,
                              "%s has %d elements and a patch must give as many; got %d", w->path.text, count,
                              given);
    ll_status status = ll_ok();
    int index = 0;
    for (const cJSON *item = json->child; item != NULL && !ll_failed(&status); item = item->next, index++) {
        ll_json_location element = ll_json_location_of_element(place, index);
        int before = ll_path_push_index(&w->path, index);
        status = patch_place(w, &element, item);
        ll_path_pop(&w->path, before);
    }
    return status;
}

static ll_status patch_place(walk *w, const ll_json_location *place, const cJSON *json)
{
    if (cJSON_IsNull(json))
        return ll_field_error(LL_BAD_INPUT, w->path.text, "%s cannot be removed; got null",
                              ll_path_subject(&w->path));
    if (place->kind == LL_LOCATION_VALUE)
        return patch_value(w, place, json);
    if (place->kind == LL_LOCATION_ARRAY && cJSON_IsArray(json)) {
        if (w->options->live_only)
            return patch_elements(w, place, json);
        return replace_array(w, place, json);
    }
    if (!cJSON_IsObject(json))
        return ll_wrong_type(&w->path,
                             place->kind == LL_LOCATION_ARRAY ? "an array or an object" : "an object", json);
    return patch_members(w, place, json);
}

static ll_status run(walk *w, const ll_param_table *table, const cJSON *patch)
{
    ll_json_location root = ll_json_location_root(table, w->object);
    ll_status status = ll_ok();
    for (pass p = SET_GOVERNING; p <= TELL_REST && !ll_failed(&status); p++) {
        w->pass = p;
        w->path = ll_path_root(table);
        status = patch_place(w, &root, patch);
        if (p == SET_GOVERNING)
            status = ll_ok();
        if (p == SET_ALL && !w->options->unchecked && !ll_failed(&status))
            status = ll_run_checks(table, w->object);
    }
    return status;
}

ll_status ll_patch_apply(const ll_param_table *table, const cJSON *patch, void *object,
                         const ll_patch_options *options)
{
    size_t size = ll_param_clone_size(table, object, patch);
    walk w = {.options = options,
              .object = ll_param_clone(table, object, patch),
              .touched = calloc(size, 1),
              .fresh = calloc(size, 1)};
    ll_status status = ll_error(LL_NO_MEMORY, "out of memory");
    if (w.object != NULL && w.touched != NULL && w.fresh != NULL) {
        status = run(&w, table, patch);
        if (!ll_failed(&status))
            ll_param_copy(table, object, w.object);
    }
    free(w.object);
    free(w.touched);
    free(w.fresh);
    return status;
}

ll_status ll_param_patch(const ll_param_table *table, const cJSON *patch, void *object,
                         ll_param_change *change, void *context)
{
    ll_patch_options options = {.live_only = true, .change = change, .context = context};
    return ll_patch_apply(table, patch, object, &options);
}

ll_status ll_param_merge(const ll_param_table *table, const cJSON *patch, void *object)
{
    return ll_patch_apply(table, patch, object, &(ll_patch_options){.live_only = false});
}
