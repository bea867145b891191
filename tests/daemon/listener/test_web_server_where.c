/* Which thread a handler runs on: by its route, the size of its body and its own wish; and requests of the
 * thread pool never wait for tasks. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "daemon/support/tasks.h"
#include "support/server_fixture.h"

enum { SHORT_BODY = 4096, LONG_BODY = 65536, CLIENTS = 8 };

static ll_web_server *server;
static ll_tasks *tasks;
static atomic_bool released;
static atomic_int entered;

/* ---- handlers ---- */

static void say_thread(void *context, const ll_http_request *request, ll_http_response *response)
{
    char name[16] = "";
    (void)context;
    pthread_getname_np(pthread_self(), name, sizeof name);
    ll_http_printf(response, "%s begun %u", name, request->begun);
}

static void become_task(void *context, const ll_http_request *request, ll_http_response *response)
{
    response->begun = 7;
    if (!ll_http_become_task(request, response))
        say_thread(context, request, response);
}

/* A task that yields, but does not end before it is released. */
static void hold(void *context, const ll_http_request *request, ll_http_response *response)
{
    atomic_fetch_add(&entered, 1);
    while (!atomic_load(&released) && ll_task_yield(request->task))
        test_sleep(0.001);
    say_thread(context, request, response);
}

static const ll_http_route routes[] = {
    {.method = "POST", .pattern = "/inline", .handler = say_thread, .body_limit = LONG_BODY},
    {.method = "POST",
     .pattern = "/pool",
     .handler = say_thread,
     .body_limit = LONG_BODY,
     .run_on = LL_HTTP_POOL},
    {.method = "POST",
     .pattern = "/task",
     .handler = say_thread,
     .body_limit = LONG_BODY,
     .run_on = LL_HTTP_TASK},
    {.method = "POST",
     .pattern = "/becomes",
     .handler = become_task,
     .body_limit = LONG_BODY,
     .run_on = LL_HTTP_POOL},
    {.method = "GET", .pattern = "/hold", .handler = hold, .run_on = LL_HTTP_TASK},
};

static int set_up(void **state)
{
    (void)state;
    ll_web_server_config config;
    ll_param_defaults(&ll_web_server_table, &config);
    snprintf(config.listen, sizeof config.listen, "127.0.0.1:0");
    ll_status status = ll_tasks_start(2, &tasks);
    assert_false(ll_failed(&status));
    ll_http_app app = {.routes = routes, .route_count = sizeof routes / sizeof *routes, .tasks = tasks};
    status = ll_web_server_open(&config, &app, &server);
    assert_false(ll_failed(&status));
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    ll_web_server_drain(server);
    ll_web_server_close(server);
    ll_tasks_free(tasks);
    return 0;
}

/* ---- tests ---- */

/* The thread that answers a body of `size` bytes. */
static void expect_thread(const char *path, size_t size, const char *thread)
{
    static char request[LONG_BODY + 200], answer[4096];
    int head = snprintf(request, sizeof request,
                        "POST %s HTTP/1.1\r\nHost: localhost\r\nContent-Length: %zu\r\n\r\n", path, size);
    memset(request + head, 'x', size);
    request[(size_t)head + size] = '\0';
    assert_int_equal(net_ask(ll_web_server_port(server), request, answer, sizeof answer), 200);
    const char *body = strstr(answer, "\r\n\r\n");
    assert_non_null(body);
    assert_string_equal(body + 4, thread);
}

static void test_thread_by_route_and_body(void **state)
{
    (void)state;
    for (int i = 0; i < 20; i++) {
        expect_thread("/inline", 0, "MHD-worker begun 0");
        expect_thread("/pool", 0, "control begun 0");
        expect_thread("/pool", SHORT_BODY, "control begun 0");
        expect_thread("/pool", SHORT_BODY + 1, "task begun 0");
        expect_thread("/pool", LONG_BODY, "task begun 0");
        expect_thread("/task", 0, "task begun 0");
        expect_thread("/task", 1, "task begun 0");
        expect_thread("/task", LONG_BODY, "task begun 0");
    }
}

static void test_second_call_as_a_task(void **state)
{
    (void)state;
    expect_thread("/becomes", 10, "task begun 7");
    expect_thread("/becomes", LONG_BODY, "task begun 0"); /* it is one from the start */
}

static void test_others_do_not_wait_for_tasks_of_one_kind(void **state)
{
    (void)state;
    static char answer[4096];
    int fd[CLIENTS];
    for (int i = 0; i < CLIENTS; i++) {
        fd[i] = net_connect(ll_web_server_port(server));
        assert_true(net_send(fd[i], "GET /hold HTTP/1.1\r\nHost: localhost\r\n\r\n"));
    }
    while (atomic_load(&entered) < 2) /* as many as there are turns */
        test_sleep(0.001);
    for (int i = 0; i < 50; i++)
        expect_thread("/pool", 0, "control begun 0");
    expect_thread("/task", 0, "task begun 0"); /* of another kind, which has its own turns */
    assert_false(atomic_load(&released));
    atomic_store(&released, true);
    for (int i = 0; i < CLIENTS; i++) {
        net_read(fd[i], answer, sizeof answer, "task begun 0", LIMIT_S);
        assert_non_null(strstr(answer, "task begun 0"));
        close(fd[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_thread_by_route_and_body),
        cmocka_unit_test(test_second_call_as_a_task),
        cmocka_unit_test(test_others_do_not_wait_for_tasks_of_one_kind),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
