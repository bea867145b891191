/* The order in which values are set does not matter: every permutation leads to the same object, or to an
 * error. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "param/sample.h"

enum { SETS_MAX = 6 };

typedef struct list {
    const char *sets[SETS_MAX];
} list;

static int count_of(const list *l)
{
    int n = 0;
    while (n < SETS_MAX && l->sets[n])
        n++;
    return n;
}

/* The next permutation of indices, in the order of the alphabet; false behind the last. */
static bool permute(int *order, int n)
{
    int i = n - 2, j = n - 1;
    while (i >= 0 && order[i] > order[i + 1])
        i--;
    if (i < 0)
        return false;
    while (order[j] < order[i])
        j--;
    int swap = order[i];
    order[i] = order[j];
    order[j] = swap;
    for (int a = i + 1, b = n - 1; a < b; a++, b--) {
        swap = order[a];
        order[a] = order[b];
        order[b] = swap;
    }
    return true;
}

typedef ll_status apply(sample *s, const char *const *sets, int count);

static ll_status by_put(sample *s, const char *const *sets, int count)
{
    ll_status status = ll_param_put(&sample_table, s, sets, count);
    return ll_failed(&status) ? status : ll_param_check(&sample_table, s);
}

static cJSON *patch_of(const char *const *sets, int count)
{
    cJSON *patch = cJSON_CreateObject();
    for (int i = 0; i < count; i++) {
        char path[64];
        const char *equals = strchr(sets[i], '=');
        snprintf(path, sizeof path, "%.*s", (int)(equals - sets[i]), sets[i]);
        cJSON *value = cJSON_Parse(equals + 1);
        cJSON_AddItemToObject(patch, path, value ? value : cJSON_CreateString(equals + 1));
    }
    return patch;
}

static ll_status by_merge(sample *s, const char *const *sets, int count)
{
    cJSON *patch = patch_of(sets, count);
    ll_status status = ll_param_merge(&sample_table, patch, s);
    cJSON_Delete(patch);
    return status;
}

static ll_status by_patch(sample *s, const char *const *sets, int count)
{
    cJSON *patch = patch_of(sets, count);
    ll_status status = ll_param_patch(&sample_table, patch, s, NULL, NULL);
    cJSON_Delete(patch);
    return status;
}

/* What the first order leads to; all others lead there too. */
static ll_status permutations(const list *l, apply *how, sample *result)
{
    int n = count_of(l), order[SETS_MAX], tried = 0;
    ll_status first = ll_ok();
    for (int i = 0; i < n; i++)
        order[i] = i;
    do {
        const char *sets[SETS_MAX];
        sample s;
        memset(&s, 0, sizeof s);
        sample_two(&s);
        for (int i = 0; i < n; i++)
            sets[i] = l->sets[order[i]];
        ll_status status = how(&s, sets, n);
        if (tried++ == 0) {
            first = status;
            *result = s;
        }
        assert_int_equal(status.code, first.code);
        if (memcmp(&s, result, sizeof s) != 0)
            fail_msg("%s first: not as %s first", sets[0], l->sets[0]);
    } while (permute(order, n));
    return first;
}

static void assert_all(const list *l, int live, sample *result)
{
    sample others;
    assert_string_equal(permutations(l, by_put, result).text, "");
    assert_string_equal(permutations(l, by_merge, &others).text, "");
    assert_memory_equal(result, &others, sizeof others);
    if (live) {
        assert_string_equal(permutations(l, by_patch, &others).text, "");
        assert_memory_equal(result, &others, sizeof others);
    }
}

/* A member's jitter is at most its lag, 10 and 20 ms before. */
static void rules_hold_for_all_together(void **state)
{
    (void)state;
    sample s;
    const list both = {{"members.0.up.jitter_ms=300", "members.0.lag_ms=400", "members.1.up.jitter_ms=15"}};
    assert_all(&both, 1, &s);
    assert_true(s.members[0].up.jitter_ms == 300 && s.members[0].lag_ms == 400);
    const list less = {{"members.1.lag_ms=3", "members.1.up.jitter_ms=2", "members.1.tries=4", "level=0.5"}};
    assert_all(&less, 1, &s);
    assert_true(s.members[1].lag_ms == 3);
    const list broken = {{"members.0.up.jitter_ms=300", "members.0.lag_ms=299", "level=0.6"}};
    assert_string_equal(permutations(&broken, by_put, &s).field, "members.0.up.jitter_ms");
    assert_string_equal(permutations(&broken, by_merge, &s).field, "members.0.up.jitter_ms");
    assert_string_equal(permutations(&broken, by_patch, &s).field, "members.0.up.jitter_ms");
}

static void choices_come_before_what_depends_on_them(void **state)
{
    (void)state;
    sample s;
    const list boxed = {{"params.width_m=5", "shape=box", "params.height_m=1.5", "ratio=2"}};
    assert_all(&boxed, 1, &s);
    assert_true(s.shape == 1 && s.params.box.width == 5 && s.params.box.height == 1.5);
    const list whole = {{"params={\"height_m\":4}", "shape=box", "members.0.ready=false"}};
    assert_all(&whole, 1, &s);
    assert_true(s.params.box.width == 2 && s.params.box.height == 4 && !s.members[0].ready);
}

/* An array is replaced before anything is said of its elements. */
static void arrays_come_before_their_elements(void **state)
{
    (void)state;
    sample s;
    const list new = {{"members.2.lag_ms=7", "members=[{\"lag_ms\":1},{\"lag_ms\":2},{\"lag_ms\":3}]",
                       "members.2.up={\"jitter_ms\":6}", "members.0.tries=5", "members.2.name=\"7\""}};
    assert_all(&new, 0, &s);
    assert_true(s.count == 3 && s.members[2].lag_ms == 7 && s.members[2].up.jitter_ms == 6);
    assert_true(s.members[1].lag_ms == 2 && s.members[0].tries == 5);
    assert_string_equal(s.members[2].name, "7");
}

/* A text is read by the row that it is for, which may be one that another set makes. */
static void texts_are_read_by_their_rows(void **state)
{
    (void)state;
    sample s;
    const list bare = {{"members.2.name=12", "members=[{\"lag_ms\":1},{\"lag_ms\":2},{\"lag_ms\":3}]",
                        "members.2.up.order=unordered", "seed=12"}};
    assert_string_equal(permutations(&bare, by_put, &s).text, "");
    assert_string_equal(s.members[2].name, "12");
    assert_true(s.seed == 12 && s.members[2].up.order == 0);
}

static void of_one_path_the_later_counts(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    const char *const sets[] = {"level=0.2", "members.0.lag_ms=5", "level=0.7", "members.0.lag_ms=900"};
    assert_status(ll_param_put(&sample_table, &s, sets, 4), LL_OK, "", "");
    assert_true(s.level == 0.7 && s.members[0].lag_ms == 900);
    const char *const twice[] = {"members.0={\"lag_ms\":5}", "members.0.lag_ms=6"};
    assert_status(ll_param_put(&sample_table, &s, twice, 2), LL_BAD_INPUT, "members.0.lag_ms",
                  "members.0.lag_ms is given twice");
    assert_true(s.members[0].lag_ms == 900);
}

static void what_is_wrong_leaves_the_object(void **state)
{
    (void)state;
    static const struct {
        const char *set, *field, *text;
    } cases[] = {
        {"level", "", "--set takes path=value; got level"},
        {"=3", "", "--set takes path=value; got =3"},
        {"level=2", "level", "level: must be 0.1 to 0.9; got 2"},
        {"members.5.lag_ms=2", "members.5", NULL},
        {"shape=", "shape", "shape: must be one of circle, box, point; got \"\""},
    };
    sample s, before;
    memset(&s, 0, sizeof s);
    sample_two(&s);
    before = s;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        for (int first = 0; first < 2; first++) {
            const char *const sets[] = {first ? cases[i].set : "ratio=3", first ? "ratio=3" : cases[i].set};
            ll_status status = ll_param_put(&sample_table, &s, sets, 2);
            assert_int_equal(status.code, LL_BAD_INPUT);
            assert_string_equal(status.field, cases[i].field);
            if (cases[i].text)
                assert_string_equal(status.text, cases[i].text);
            assert_memory_equal(&s, &before, sizeof s);
        }
    assert_status(ll_param_put(&sample_table, &s, NULL, 0), LL_OK, "", "");
    assert_memory_equal(&s, &before, sizeof s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rules_hold_for_all_together),
        cmocka_unit_test(choices_come_before_what_depends_on_them),
        cmocka_unit_test(arrays_come_before_their_elements),
        cmocka_unit_test(texts_are_read_by_their_rows),
        cmocka_unit_test(of_one_path_the_later_counts),
        cmocka_unit_test(what_is_wrong_leaves_the_object),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
