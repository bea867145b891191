/* Choices that stand for values of other rows: presets. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "param/sample.h"

/* A meal: a menu chooses a main dish and a drink, after a guest who keeps out of it. */
typedef struct dish {
    double portions;
    int32_t kind;
    int32_t reserved;
} dish;

typedef struct meal {
    double guests;
    int32_t menu;
    int32_t reserved;
    dish main;
    double drinks;
} meal;

typedef struct table_of_two {
    meal meals[2];
    int32_t count;
    int32_t reserved;
} table_of_two;

static const char *const kinds[] = {"soup", "pie", NULL};
static const char *const menus[] = {"a_la_carte", "small", "large", NULL};

static int calls;

static void choose(void *object, int choice)
{
    meal *m = object;
    calls++;
    if (choice == 0)
        return;
    m->main = (dish){.portions = choice == 1 ? 1 : 3, .kind = choice == 1 ? 0 : 1};
    m->drinks = choice == 1 ? 2 : 5;
}

static const ll_param dish_rows[] = {
    {.name = "portions",
     .type = LL_PARAM_REAL,
     .offset = offsetof(dish, portions),
     .max = 9,
     .live = true,
     .help = "h"},
    {.name = "kind",
     .type = LL_PARAM_CHOICE,
     .offset = offsetof(dish, kind),
     .choices = kinds,
     .live = true,
     .help = "h"},
};
static const ll_param_table dish_table = {
    .name = "dish", .help = "h", .rows = dish_rows, .count = 2, .size = sizeof(dish)};

#define GUESTS                                                                                               \
    {                                                                                                        \
        .name = "guests", .type = LL_PARAM_REAL, .offset = offsetof(meal, guests), .max = 9, .live = true,   \
        .help = "h"                                                                                          \
    }
#define MENU(CHOSEN)                                                                                         \
    {                                                                                                        \
        .name = "menu", .type = LL_PARAM_CHOICE, .offset = offsetof(meal, menu), .choices = menus,           \
        .live = true, .chosen = CHOSEN, .help = "h"                                                          \
    }
#define MAIN                                                                                                 \
    {                                                                                                        \
        .name = "main", .type = LL_PARAM_OBJECT, .offset = offsetof(meal, main), .child = &dish_table,       \
        .live = true, .help = "h"                                                                            \
    }
#define DRINKS(MAX)                                                                                          \
    {                                                                                                        \
        .name = "drinks", .type = LL_PARAM_REAL, .offset = offsetof(meal, drinks), .max = MAX, .live = true, \
        .help = "h"                                                                                          \
    }

static const ll_param meal_rows[] = {GUESTS, MENU(choose), MAIN, DRINKS(9)};
static const ll_param_table meal_table = {
    .name = "meal", .help = "h", .rows = meal_rows, .count = 4, .size = sizeof(meal)};

static const ll_param two_rows[] = {{.name = "meals",
                                     .type = LL_PARAM_ARRAY,
                                     .offset = offsetof(table_of_two, meals),
                                     .min = 1,
                                     .max = 2,
                                     .child = &meal_table,
                                     .count_offset = offsetof(table_of_two, count),
                                     .live = true,
                                     .help = "h"}};
static const ll_param_table two_table = {
    .name = "two", .help = "h", .rows = two_rows, .count = 1, .size = sizeof(table_of_two)};

static ll_status parse(const char *text, table_of_two *t)
{
    cJSON *json = cJSON_Parse(text);
    assert_non_null(json);
    ll_param_defaults(&two_table, t);
    ll_status status = ll_param_parse(&two_table, json, t);
    cJSON_Delete(json);
    return status;
}

static ll_status patch(const char *text, table_of_two *t, ll_param_change *change, void *context)
{
    cJSON *json = cJSON_Parse(text);
    assert_non_null(json);
    ll_status status = ll_param_patch(&two_table, json, t, change, context);
    cJSON_Delete(json);
    return status;
}

static void assert_meal(const meal *m, int menu, double portions, int kind, double drinks)
{
    assert_int_equal(m->menu, menu);
    assert_true(m->main.portions == portions && m->drinks == drinks);
    assert_int_equal(m->main.kind, kind);
}

static void the_table_is_sound(void **state)
{
    (void)state;
    assert_status(ll_param_table_valid(&two_table), LL_OK, "", "");
}

/* Whatever their order in the document: the choice first, then what is given beside it. */
static void a_choice_comes_before_the_rows_after_it(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "{\"meals\":[{\"menu\":\"large\",\"main\":{\"kind\":\"soup\"}},{\"menu\":\"small\",\"guests\":4}]}",
        "{\"meals\":[{\"main\":{\"kind\":\"soup\"},\"menu\":\"large\"},{\"guests\":4,\"menu\":\"small\"}]}"};
    for (int i = 0; i < 2; i++) {
        table_of_two t;
        assert_status(parse(texts[i], &t), LL_OK, "", "");
        assert_meal(&t.meals[0], 2, 3, 0, 5);
        assert_meal(&t.meals[1], 1, 1, 0, 2);
        assert_true(t.meals[1].guests == 4);
    }
}

static void a_patch_chooses_first_too(void **state)
{
    (void)state;
    static const char *const texts[] = {"{\"meals.0.drinks\":7,\"meals.0.menu\":\"large\"}",
                                        "{\"meals\":{\"0\":{\"drinks\":7,\"menu\":\"large\"}}}",
                                        "{\"meals\":[{\"drinks\":7},{}],\"meals.0.menu\":\"large\"}"};
    for (int i = 0; i < 3; i++) {
        table_of_two t;
        assert_status(parse("{\"meals\":[{\"menu\":\"small\"},{}]}", &t), LL_OK, "", "");
        assert_status(patch(texts[i], &t, NULL, NULL), LL_OK, "", "");
        assert_meal(&t.meals[0], 2, 3, 1, 7);
        assert_meal(&t.meals[1], 0, 0, 0, 0);
    }
}

/* A choice that is given again sets its values again; one that is not given leaves them. */
static void it_is_called_when_it_is_given(void **state)
{
    (void)state;
    table_of_two t;
    assert_status(parse("{\"meals\":[{\"menu\":\"small\",\"drinks\":8}]}", &t), LL_OK, "", "");
    assert_meal(&t.meals[0], 1, 1, 0, 8);
    assert_status(ll_param_set(&two_table, &t, "meals.0.main.portions", "4", true), LL_OK, "", "");
    assert_meal(&t.meals[0], 1, 4, 0, 8);
    assert_status(ll_param_set(&two_table, &t, "meals.0.menu", "small", true), LL_OK, "", "");
    assert_meal(&t.meals[0], 1, 1, 0, 2);
    assert_status(ll_param_set(&two_table, &t, "meals.0.menu", "a_la_carte", true), LL_OK, "", "");
    assert_meal(&t.meals[0], 0, 1, 0, 2);
}

static ll_status keep(void *context, const char *path, const char *value)
{
    char *text = context;
    sprintf(text + strlen(text), "%s=%s ", path, value);
    return ll_ok();
}

/* One by one, as a log keeps them, the changes lead to the same struct. */
static void changes_are_told_with_the_choice_first(void **state)
{
    (void)state;
    table_of_two t, one_by_one;
    char told[200] = "";
    parse("{\"meals\":[{}]}", &t);
    one_by_one = t;
    assert_status(patch("{\"meals\":{\"0\":{\"drinks\":7,\"menu\":\"large\"}}}", &t, keep, told), LL_OK, "",
                  "");
    assert_string_equal(told, "meals.0.menu=\"large\" meals.0.drinks=7 ");
    ll_param_set(&two_table, &one_by_one, "meals.0.menu", "\"large\"", true);
    ll_param_set(&two_table, &one_by_one, "meals.0.drinks", "7", true);
    assert_memory_equal(&t, &one_by_one, sizeof t);
}

static void errors_leave_the_object(void **state)
{
    (void)state;
    table_of_two t, before;
    parse("{\"meals\":[{\"menu\":\"small\",\"drinks\":8}]}", &t);
    before = t;
    calls = 0;
    assert_status(patch("{\"meals.0.menu\":\"large\",\"meals.0.drinks\":10}", &t, NULL, NULL), LL_BAD_INPUT,
                  "meals.0.drinks", "meals.0.drinks: must be 0 to 9; got 10");
    assert_status(patch("{\"meals.0.menu\":\"huge\"}", &t, NULL, NULL), LL_BAD_INPUT, "meals.0.menu",
                  "meals.0.menu: must be one of a_la_carte, small, large; got \"huge\"");
    assert_status(patch("{\"meals.0.menu\":\"large\",\"meals\":[{\"menu\":\"small\"}]}", &t, NULL, NULL),
                  LL_BAD_INPUT, "meals.0.menu", "meals.0.menu is given twice");
    assert_memory_equal(&t, &before, sizeof t);
    assert_true(calls > 0);
}

static void what_is_written_reads_back(void **state)
{
    (void)state;
    table_of_two t, again;
    parse("{\"meals\":[{\"menu\":\"large\",\"main\":{\"portions\":2},\"drinks\":0},{\"menu\":\"small\"}]}",
          &t);
    cJSON *json = ll_param_write(&two_table, &t);
    ll_param_defaults(&two_table, &again);
    assert_status(ll_param_parse(&two_table, json, &again), LL_OK, "", "");
    assert_memory_equal(&t, &again, sizeof t);
    cJSON_Delete(json);
}

/* ---- what an author can get wrong ---- */

static void changes_by_default(void *object, int choice)
{
    ((meal *)object)->drinks = choice + 1;
}

static void changes_a_row_before(void *object, int choice)
{
    ((meal *)object)->guests = choice;
}

static void changes_itself(void *object, int choice)
{
    ((meal *)object)->menu = choice > 0;
}

static void leaves_the_range(void *object, int choice)
{
    ((meal *)object)->drinks = choice * 5;
}

static void changes_the_shape(void *object, int choice)
{
    ((sample *)object)->shape = choice;
}

static void faults_are_named(void **state)
{
    (void)state;
    static const struct {
        ll_param rows[4];
        const char *text;
    } cases[] = {
        {{GUESTS, MENU(changes_by_default), MAIN, DRINKS(9)},
         "row 1 (menu) of t has a default that changes something"},
        {{GUESTS, MENU(changes_a_row_before), MAIN, DRINKS(9)},
         "row 1 (menu) of t changes a row that does not stand after it"},
        {{GUESTS, MENU(changes_itself), MAIN, DRINKS(9)},
         "row 1 (menu) of t changes a row that does not stand after it"},
        {{GUESTS, MENU(leaves_the_range), MAIN, DRINKS(9)},
         "row 1 (menu) of t has a choice whose values do not read back"},
        {{{.name = "x", .type = LL_PARAM_BOOL, .chosen = choose, .help = "h"}, MENU(choose), MAIN, DRINKS(9)},
         "row 0 (x) of t is no choice that could be chosen"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const ll_param_table table = {.name = "t", .rows = cases[i].rows, .count = 4, .size = sizeof(meal)};
        assert_string_equal(ll_param_table_valid(&table).text, cases[i].text);
    }
    const ll_param rows[] = {{.name = "menu",
                              .type = LL_PARAM_CHOICE,
                              .offset = offsetof(sample, loud) & ~(size_t)7,
                              .choices = sample_orders,
                              .chosen = changes_the_shape,
                              .help = "h"},
                             sample_rows[1],
                             sample_rows[2]};
    const ll_param_table table = {.name = "t", .rows = rows, .count = 3, .size = sizeof(sample)};
    assert_string_equal(ll_param_table_valid(&table).text,
                        "row 0 (menu) of t changes a choice that others depend on");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_table_is_sound),
        cmocka_unit_test(a_choice_comes_before_the_rows_after_it),
        cmocka_unit_test(a_patch_chooses_first_too),
        cmocka_unit_test(it_is_called_when_it_is_given),
        cmocka_unit_test(changes_are_told_with_the_choice_first),
        cmocka_unit_test(errors_leave_the_object),
        cmocka_unit_test(what_is_written_reads_back),
        cmocka_unit_test(faults_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
