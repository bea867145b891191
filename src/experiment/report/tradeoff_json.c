#include "experiment/report/tradeoff_json.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "param/param.h"

/* ---- addresses ---- */

typedef struct text_end {
    char *text;
    int size, used;
} text_end;

static void add(text_end *t, const char *text)
{
    for (; *text && t->used + 1 < t->size; text++)
        t->text[t->used++] = *text;
    t->text[t->used] = '\0';
}

/* As encodeURIComponent, so that the page reads what it writes itself. */
static void add_encoded(text_end *t, const char *text, int length)
{
    static const char hex[] = "0123456789ABCDEF", plain[] = "-_.!~*'()";
    for (int i = 0; i < length; i++) {
        unsigned char c = (unsigned char)text[i];
        bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
        char code[] = {'%', hex[c >> 4], hex[c & 15], '\0'}, one[] = {(char)c, '\0'};
        add(t, letter || (c && strchr(plain, c)) ? one : code);
    }
}

void ll_tradeoff_address(const ll_tradeoff *tradeoff, const ll_tradeoff_row *row, const char *page,
                         char *text, int size)
{
    text_end t = {text, size, 0};
    add(&t, page);
    add(&t, "?scenario=");
    add(&t, tradeoff->family->problems[row->problem].scenario);
    for (const char *pair = row->sets; *pair;) {
        int length = (int)strcspn(pair, " "), name = (int)strcspn(pair, "=");
        add(&t, "&set=");
        add_encoded(&t, pair, name);
        add(&t, ":");
        add_encoded(&t, pair + name + 1, length - name - 1);
        pair += length + (pair[length] == ' ');
    }
    if (row->random) {
        char seed[32];
        snprintf(seed, sizeof seed, "&seed=%lld", (long long)row->values.seed);
        add(&t, seed);
    }
}

/* ---- families ---- */

/* Names that are separated by commas, with or without a space. */
static cJSON *names_json(const char *names)
{
    cJSON *list = cJSON_CreateArray();
    char name[sizeof((ll_tradeoff_choice *)0)->tied];
    while (*names) {
        size_t length = strcspn(names, ",");
        memcpy(name, names, length);
        name[length] = '\0';
        cJSON_AddItemToArray(list, cJSON_CreateString(name));
        names += length;
        names += strspn(names, ", ");
    }
    return list;
}

static cJSON *family_json(const ll_tradeoff_family *f)
{
    cJSON *family = cJSON_CreateObject();
    cJSON_AddStringToObject(family, "name", f->name);
    cJSON_AddStringToObject(family, "title", f->title);
    cJSON_AddStringToObject(family, "text", f->text);
    cJSON_AddItemToObject(family, "first", names_json(f->first));
    cJSON *problems = cJSON_AddArrayToObject(family, "problems");
    for (int p = 0; p < ll_tradeoff_problem_count(f); p++) {
        cJSON *problem = cJSON_CreateObject();
        cJSON_AddStringToObject(problem, "scenario", f->problems[p].scenario);
        cJSON_AddStringToObject(problem, "error", f->problems[p].error);
        cJSON_AddStringToObject(problem, "title", f->problems[p].title);
        cJSON_AddItemToArray(problems, problem);
    }
    cJSON *costs = cJSON_AddArrayToObject(family, "costs");
    for (int c = 0; c < ll_tradeoff_cost_count(f); c++) {
        cJSON *cost = cJSON_CreateObject();
        cJSON_AddStringToObject(cost, "path", f->costs[c].path);
        cJSON_AddStringToObject(cost, "title", f->costs[c].title);
        cJSON_AddItemToArray(costs, cost);
    }
    return family;
}

cJSON *ll_tradeoff_families_json(void)
{
    cJSON *list = cJSON_CreateArray();
    for (const ll_tradeoff_family *f = ll_tradeoff_families; f->name; f++)
        cJSON_AddItemToArray(list, family_json(f));
    return list;
}

/* ---- rows ---- */

static cJSON *measured(const ll_measured *m)
{
    cJSON *list = cJSON_CreateArray();
    cJSON_AddItemToArray(list, ll_param_number(m->value));
    cJSON_AddItemToArray(list, ll_param_number(m->low));
    cJSON_AddItemToArray(list, ll_param_number(m->high));
    return list;
}

static void add_values(cJSON *to, const ll_tradeoff_values *v, int cost_count)
{
    cJSON_AddItemToObject(to, "error", measured(&v->error));
    cJSON *costs = cJSON_AddArrayToObject(to, "costs");
    for (int c = 0; c < cost_count; c++)
        cJSON_AddItemToArray(costs, measured(&v->costs[c]));
    cJSON_AddItemToObject(to, "cpu_median_s", ll_param_number(v->cpu_median_s));
    cJSON_AddNumberToObject(to, "runs", v->runs);
    cJSON_AddNumberToObject(to, "seed", (double)v->seed);
    cJSON_AddNumberToObject(to, "seeds", v->seeds);
}

static cJSON *row_json(const ll_tradeoff *t, const ll_tradeoff_row *row)
{
    int cost_count = ll_tradeoff_cost_count(t->family);
    char link[1500];
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "problem", row->problem);
    cJSON_AddStringToObject(json, "by", row->by);
    cJSON_AddStringToObject(json, "method", row->method);
    cJSON_AddStringToObject(json, "setting", row->setting);
    cJSON_AddItemToObject(json, "value", ll_param_number(strtod(row->value, NULL)));
    cJSON_AddStringToObject(json, "status", row->diverged ? "diverged" : "ok");
    cJSON_AddBoolToObject(json, "random", row->random);
    add_values(json, &row->values, cost_count);
    cJSON *front = cJSON_AddArrayToObject(json, "front");
    for (int c = 0; c < cost_count; c++)
        cJSON_AddItemToArray(front, cJSON_CreateBool(row->front[c]));
    if (row->again.seeds > 0)
        add_values(cJSON_AddObjectToObject(json, "check"), &row->again, cost_count);
    else
        cJSON_AddNullToObject(json, "check");
    cJSON_AddStringToObject(json, "set", row->sets);
    ll_tradeoff_address(t, row, "", link, sizeof link);
    cJSON_AddStringToObject(json, "link", link);
    return json;
}

/* ---- choices ---- */

static void add_place(cJSON *to, const char *name, int row)
{
    if (row < 0)
        cJSON_AddNullToObject(to, name);
    else
        cJSON_AddNumberToObject(to, name, row);
}

static cJSON *choice_json(const ll_tradeoff_choice *choice)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "problem", choice->problem);
    cJSON_AddNumberToObject(json, "cost", choice->cost);
    cJSON_AddItemToObject(json, "level", ll_param_number(choice->level));
    add_place(json, "row", choice->row);
    cJSON_AddStringToObject(json, "outcome", ll_tradeoff_verdict(choice));
    cJSON_AddStringToObject(json, "figures", choice->why);
    add_place(json, "check_cheapest", choice->checked ? choice->cheapest_again : -1);
    cJSON_AddItemToObject(json, "as_cheap", names_json(choice->tied));
    return json;
}

cJSON *ll_tradeoff_json(const ll_tradeoff *t)
{
    cJSON *json = family_json(t->family);
    cJSON *rows = cJSON_AddArrayToObject(json, "rows"), *choices = cJSON_AddArrayToObject(json, "choices");
    for (int i = 0; i < t->count; i++)
        cJSON_AddItemToArray(rows, row_json(t, &t->rows[i]));
    for (int i = 0; i < t->choice_count; i++)
        cJSON_AddItemToArray(choices, choice_json(&t->choices[i]));
    return json;
}
