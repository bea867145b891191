/* Files of class keys: which keys they have, with which quotas. Files that are refused: class_keys.test.mjs.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "daemon/support/class_keys.h"

static ll_class_keys read_file(const char *content)
{
    char text[400];
    ll_class_keys keys;
    assert_true(strlen(content) < sizeof text);
    strcpy(text, content);
    ll_status status = ll_class_keys_read(&keys, "test", text);
    if (ll_failed(&status))
        fail_msg("%s", status.text);
    return keys;
}

static ll_class_key *find(const ll_class_keys *keys, const char *key)
{
    return ll_class_keys_find(keys, key, strlen(key));
}

static void a_line_without_a_space_is_a_key(void **state)
{
    (void)state;
    static const char *const files[] = {"autumn-7b-lab", "autumn-7b-lab\n", "autumn-7b-lab\r\n\n"};
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        ll_class_keys keys = read_file(files[i]);
        const ll_class_key *key = find(&keys, "autumn-7b-lab");
        assert_int_equal(keys.count, 1);
        assert_non_null(key);
        assert_string_equal(key->name, "");
        assert_null(find(&keys, "autumn-7b-la"));
        assert_null(find(&keys, "autumn-7b-lab\n"));
        assert_null(ll_class_keys_named(&keys, ""));
        ll_class_keys_free(&keys);
    }
    ll_class_keys keys = read_file("#autumn=7b");
    assert_non_null(find(&keys, "#autumn=7b"));
    ll_class_keys_free(&keys);
}

static void lines_have_names_and_quotas(void **state)
{
    (void)state;
    ll_class_keys keys = read_file("north key-of-the-north\n"
                                   "\n # a remark that has=no effect\r\n"
                                   "\tsouth  key=south sessions=4 logs_mib=2\tclasses=0 \r\n"
                                   "east #key-of-east new_sessions_per_min=30 experiments=1");
    const ll_class_key *north = ll_class_keys_named(&keys, "north"), *south = find(&keys, "key=south"),
                       *east = find(&keys, "#key-of-east");
    assert_int_equal(keys.count, 3);
    char list[64];
    ll_class_keys_list(&keys, list, sizeof list);
    assert_string_equal(list, "north, south, east");
    ll_class_keys_list(&keys, list, 45);
    assert_string_equal(list, "north, south, ...");
    assert_ptr_equal(north, find(&keys, "key-of-the-north"));
    assert_ptr_equal(south, ll_class_keys_named(&keys, "south"));
    for (int i = 0; i < LL_KEY_QUOTAS; i++)
        assert_int_equal(north->most[i], -1);
    assert_int_equal(south->most[LL_KEY_SESSIONS], 4);
    assert_int_equal(south->most[LL_KEY_LOGS], 2 << 20);
    assert_int_equal(south->most[LL_KEY_CLASSES], 0);
    assert_int_equal(south->most[LL_KEY_EXPERIMENTS], -1);
    assert_int_equal(east->most[LL_KEY_RATE], 30);
    assert_int_equal(east->most[LL_KEY_EXPERIMENTS], 1);
    assert_null(find(&keys, "key-of-the-south"));
    assert_null(ll_class_keys_named(&keys, "West"));
    ll_class_keys_free(&keys);
}

static void a_quota_gives_as_many_as_it_has(void **state)
{
    (void)state;
    ll_class_keys keys = read_file("north key-of-the-north sessions=2");
    ll_class_key *key = &keys.keys[0];
    assert_true(ll_class_key_take(key, LL_KEY_SESSIONS) && ll_class_key_take(key, LL_KEY_SESSIONS));
    assert_true(ll_class_key_is_full(key, LL_KEY_SESSIONS));
    assert_false(ll_class_key_take(key, LL_KEY_SESSIONS));
    assert_int_equal(key->used[LL_KEY_SESSIONS], 2);
    atomic_fetch_sub(&key->used[LL_KEY_SESSIONS], 1);
    assert_true(ll_class_key_take(key, LL_KEY_SESSIONS));
    assert_true(ll_class_key_take(key, LL_KEY_CLASSES) && !ll_class_key_is_full(key, LL_KEY_CLASSES));
    ll_class_keys_free(&keys);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_without_a_space_is_a_key),
        cmocka_unit_test(lines_have_names_and_quotas),
        cmocka_unit_test(a_quota_gives_as_many_as_it_has),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
