/* Errors, time, changes and every document of the C library: prints a line of JSON for each. */
#include <inttypes.h>
#include <laglab.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* As its bits: printf would write it in the locale. */
static uint64_t bits(double number)
{
    uint64_t same;
    memcpy(&same, &number, sizeof same);
    return same;
}

static void say(const char *name, laglab_run *run, laglab_code code)
{
    printf("{\"name\":\"%s\",\"code\":%d,\"field\":\"%s\",\"error\":\"%s\"}\n", name, code,
           laglab_error_field(run), laglab_error(run));
}

static void place(const char *name, laglab_run *run)
{
    printf("{\"name\":\"%s\",\"tick\":%" PRId64 ",\"time_s\":\"%016" PRIx64 "\",\"hash\":\"%016" PRIx64
           "\"}\n",
           name, laglab_tick(run), bits(laglab_time_s(run)), laglab_hash(run));
}

static void document(const char *name, laglab_run *run, laglab_document which)
{
    char *text = laglab_json(run, which);
    printf("{\"name\":\"%s\",\"document\":%s}\n", name, text);
    laglab_free(text);
}

static void open_badly(const char *name, const char *json, const char *const *sets)
{
    laglab_run *run;
    laglab_code code = laglab_open(json, sets, &run);
    say(name, run, code);
    double value;
    if (laglab_run_to(run, 1) != LAGLAB_CONFLICT || laglab_metric(run, "x", &value) != LAGLAB_CONFLICT ||
        !isnan(value) || laglab_hash(run) != 0 || laglab_metric_count(run) != 0 ||
        laglab_json(run, LAGLAB_STATE) != NULL)
        printf("a run that could not be opened does something\n");
    laglab_close(run);
}

int main(int argc, char **argv)
{
    (void)argc;
    laglab_run *run;
    double value;
    const char *text;
    setlocale(LC_ALL, "");
    printf("{\"name\":\"point\",\"point\":\"%s\"}\n", localeconv()->decimal_point);
    printf("{\"name\":\"version\",\"version\":\"%s\"}\n", laglab_version());
    open_badly("syntax", "{", NULL);
    open_badly("kind", "{\"kind\":\"magnetism\"}", NULL);
    const char *const long_run[] = {"duration_s=-3", NULL};
    open_badly("range", "{\"kind\":\"motion\",\"problem\":\"kepler\",\"methods\":[{\"method\":\"rk4\"}]}",
               long_run);
    laglab_code code = laglab_open_named(argv[1], "nothing", NULL, &run);
    say("unknown", run, code);
    laglab_close(run);
    code = laglab_open_named(argv[2], "folder", NULL, &run); /* a file that cannot be read */
    say("unreadable", run, code);
    laglab_close(run);
    laglab_close(NULL);

    const char *const sets[] = {"players.0.control=person", "duration_s=6", "seed=9", NULL};
    code = laglab_open_named(argv[1], "race", sets, &run);
    say("open", run, code);
    say("run", run, laglab_run_to(run, 120));
    place("at 120", run);
    say("input", run, laglab_input(run, 0, 1, 0, 0));
    say("set", run, laglab_set(run, "players.1.lag_ms=40"));
    say("not live", run, laglab_set(run, "players.0.name=C"));
    say("bad input", run, laglab_input(run, 0, 2, 0, 0));
    say("no path", run, laglab_set(run, "players"));
    say("end", run, laglab_run_to(run, laglab_end_tick(run)));
    place("at end", run);
    say("back", run, laglab_run_to(run, 120));
    place("again at 120", run);
    say("forward", run, laglab_run_to(run, laglab_end_tick(run)));
    place("again at end", run);
    say("beyond", run, laglab_run_to(run, laglab_end_tick(run) + 1));
    say("metric", run, laglab_metric(run, "players.0.remote_error_m.mean", &value));
    printf("{\"name\":\"value\",\"value\":\"%016" PRIx64 "\"}\n", bits(value));
    say("no metric", run, laglab_metric(run, "players.0.remote_eror_m", &value));
    size_t count = laglab_metric_count(run), numbers = 0;
    for (size_t i = 0; i < count; i++)
        numbers += laglab_metric(run, laglab_metric_path(run, i), &value) == LAGLAB_OK;
    printf("{\"name\":\"paths\",\"count\":%zu,\"numbers\":%zu,\"beyond\":%d}\n", count, numbers,
           laglab_metric_path(run, count) == NULL);
    document("metrics", run, LAGLAB_METRICS);
    document("scenario", run, LAGLAB_SCENARIO);
    document("state", run, LAGLAB_STATE);
    laglab_close(run);

    const char kepler[] = "{\"kind\":\"motion\",\"problem\":\"kepler\",\"duration_s\":2,\"methods\":[{"
                          "\"method\":\"rk4\",\"dt_s\":0.01}]}";
    code = laglab_open(kepler, NULL, &run);
    say("motion", run, code);
    laglab_run_to(run, laglab_end_tick(run));
    say("text", run, laglab_metric_text(run, "methods.0.status", &text));
    printf("{\"name\":\"status\",\"text\":\"%s\"}\n", text);
    say("no text", run, laglab_metric_text(run, "methods.0.e_final", &text));
    laglab_close(run);
    return 0;
}
