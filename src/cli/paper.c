/* What the paper's Figures 6 to 13 print of a netgame: the loops of client and server, the captions of the
 * views, the first input of each player from its client to the server and back, and arrivals of updates. The
 * times are those of a run. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/paper.h"
#include "sim/netgame/netgame.h"

enum { ARRIVALS = 6, ARRIVALS_MAX = 128, LINES_MAX = 6 * LL_PLAYERS_MAX };

#define WATCHED (3 * LL_SECOND) /* the first input is back by then, unless links are very slow */

/* ---- the loops of Figures 6 and 7 ---- */

static const char client_loop[] = "Client Loop\n"
                                  "{\n"
                                  "    Initialize velocity and firing angle of the cannon.\n"
                                  "    do {\n"
                                  "        Compute (x,y) position of the cannon\n"
                                  "        msg_process_time = cur_timestamp + client_network_lag\n"
                                  "        Enqueue {msg_process_time, position(x,y)} to the shared buffer\n"
                                  "        Check for server world updates\n"
                                  "        Render world\n"
                                  "        sleep(x)\n"
                                  "    } until end\n"
                                  "}\n"
                                  "\n";

static const char server_loop[] = "Server Loop\n"
                                  "do {\n"
                                  "    For all clients {\n"
                                  "        Check for new inputs in the shared buffer\n"
                                  "        Process inputs if it is time (if cur_time >= process_time)\n"
                                  "        Validate inputs\n"
                                  "        Enqueue world state to all clients\n"
                                  "        Sleep until next refresh time\n"
                                  "    }\n"
                                  "} until end\n"
                                  "\n";

static void put_loop(FILE *to, const char *figure)
{
    if (strcmp(figure, "Figure 6") == 0)
        fputs(client_loop, to);
    if (strcmp(figure, "Figure 7") == 0)
        fputs(server_loop, to);
}

/* ---- captions ---- */

static void put_player(FILE *to, const ll_player_config *player)
{
    static const char *const box[] = {"[ ]", "[x]"};
    char text[200], lag[80];
    const ll_link_params *down = &player->link.down;
    if (down->jitter_ms > 0 && down->distribution == LL_DISTRIBUTION_UNIFORM)
        snprintf(lag, sizeof lag, "%g to %g ms", player->lag_ms - down->jitter_ms,
                 player->lag_ms + down->jitter_ms);
    else
        snprintf(lag, sizeof lag, "%g ms", player->lag_ms);
    snprintf(text, sizeof text,
             "PLAYER %s   Lag = %s   Prediction %s   Reconciliation %s   Interpolation %s\n", player->name,
             lag, box[player->prediction], box[player->reconciliation], box[player->interpolation]);
    fputs(text, to);
}

/* The server's between the first two players', as in the figures. */
static void put_captions(FILE *to, const ll_netgame_config *c)
{
    char text[80];
    snprintf(text, sizeof text, "Server view - Update %g times per second\n", c->server.update_hz);
    for (int i = 0; i < c->player_count; i++) {
        put_player(to, &c->players[i]);
        if (i == 0)
            fputs(text, to);
    }
    fputs("\n", to);
}

/* ---- the first input of each player ---- */

/* Of a player; LL_NEVER: not yet. */
typedef struct first_input {
    uint32_t number, step; /* step 0: applied with the step after its arrival */
    ll_time sent, arrives;
    uint32_t state; /* the step of the first state that includes it */
    ll_time state_sent, state_arrives;
    int arrivals; /* of updates */
    ll_time arrival[ARRIVALS_MAX];
} first_input;

typedef struct watch {
    int players;
    first_input of[LL_PLAYERS_MAX];
} watch;

static void watch_input(first_input *first, const ll_event *e)
{
    if (first->sent != LL_NEVER)
        return;
    first->number = e->number;
    first->step = e->tick;
    first->sent = e->begin;
    first->arrives = e->end;
}

static void watch_update(first_input *first, const ll_event *e)
{
    if (first->arrivals < ARRIVALS_MAX)
        first->arrival[first->arrivals++] = e->end;
    bool includes = first->sent != LL_NEVER && e->begin >= first->arrives && e->number >= first->step;
    if (first->state_sent != LL_NEVER || !includes)
        return;
    first->state = e->number;
    first->state_sent = e->begin;
    first->state_arrives = e->end;
}

static void record(void *context, const void *row)
{
    watch *w = context;
    const ll_event *e = row;
    if (e->begin < 0 || e->fate != LL_FATE_DELIVERED || e->player >= w->players)
        return; /* the lobby, or lost */
    if (e->type == LL_EVENT_INPUT)
        watch_input(&w->of[e->player], e);
    if (e->type == LL_EVENT_SNAPSHOT || e->type == LL_EVENT_RELAY)
        watch_update(&w->of[e->player], e);
}

typedef struct text_line {
    ll_time at;
    char text[120];
} text_line;

typedef struct text_lines {
    int count;
    text_line line[LINES_MAX];
} text_lines;

/* In the order of time; a second line of the same words is left out. */
static void add_line(text_lines *lines, ll_time at, const char *text)
{
    int i = lines->count;
    for (int k = 0; k < i; k++)
        if (lines->line[k].at == at && strcmp(lines->line[k].text, text) == 0)
            return;
    for (; i > 0 && lines->line[i - 1].at > at; i--)
        lines->line[i] = lines->line[i - 1];
    lines->line[i].at = at;
    snprintf(lines->line[i].text, sizeof lines->line[i].text, "%s", text);
    lines->count++;
}

static void add_first(text_lines *lines, const ll_player_config *player, const first_input *first)
{
    char text[120];
    if (first->sent == LL_NEVER)
        return;
    snprintf(text, sizeof text, "%s sends input %u%s", player->name, first->number,
             player->prediction ? " and renders it at once" : "");
    add_line(lines, first->sent, text);
    snprintf(text, sizeof text, "input %u of %s arrives at the server", first->number, player->name);
    add_line(lines, first->arrives, text);
    if (first->state_sent == LL_NEVER)
        return;
    snprintf(text, sizeof text, "the server sends the world state of step %u", first->state);
    add_line(lines, first->state_sent, text);
    snprintf(text, sizeof text, "the world state of step %u arrives at %s", first->state, player->name);
    add_line(lines, first->state_arrives, text);
}

static void put_first(FILE *to, const ll_netgame_config *c, const watch *w, text_lines *lines)
{
    lines->count = 0;
    for (int i = 0; i < c->player_count; i++)
        add_first(lines, &c->players[i], &w->of[i]);
    for (int i = 0; i < lines->count; i++) {
        char text[160];
        snprintf(text, sizeof text, "%5.0f ms   %s\n", ll_to_ms(lines->line[i].at), lines->line[i].text);
        fputs(text, to);
    }
    fputs("\n", to);
}

/* ---- arrivals of updates, the dots of Figures 8 and 9 ---- */

static int by_time(const void *a, const void *b)
{
    ll_time x = *(const ll_time *)a, y = *(const ll_time *)b;
    return (x > y) - (x < y);
}

static void put_arrivals(FILE *to, const char *name, first_input *first)
{
    char text[80];
    qsort(first->arrival, (size_t)first->arrivals, sizeof first->arrival[0], by_time);
    snprintf(text, sizeof text, "Updates arrive at %s (ms):", name);
    fputs(text, to);
    for (int i = 0; i < first->arrivals && i < ARRIVALS; i++) {
        snprintf(text, sizeof text, " %.0f", ll_to_ms(first->arrival[i]));
        fputs(text, to);
    }
    fputs("\n", to);
}

/* As below the server's view of Figure 9. */
static void put_acknowledged(FILE *to, const ll_netgame *g)
{
    char text[80];
    snprintf(text, sizeof text, "Last acknowledged input after %g s:", ll_to_s(g->now));
    fputs(text, to);
    for (int i = 0; i < g->config.player_count; i++) {
        snprintf(text, sizeof text, "%s Player %d: #%u", i > 0 ? "," : "", i,
                 ll_netgame_client(g, i)->inputs.acked);
        fputs(text, to);
    }
    fputs("\n", to);
}

/* ---- all ---- */

typedef struct watched {
    watch watch;
    text_lines lines;
} watched;

static ll_status run_and_put(FILE *to, const ll_scenario *scenario, ll_netgame *g, watched *work)
{
    const ll_netgame_config *c = scenario->config;
    const ll_recorder recorder = {.record = record, .context = &work->watch};
    ll_time end = (ll_time)(c->head.duration_s * 1e9);
    work->watch.players = c->player_count;
    for (int i = 0; i < c->player_count; i++)
        work->watch.of[i].sent = work->watch.of[i].state_sent = LL_NEVER;
    LL_TRY(scenario->kind->init(g, c));
    LL_TRY(scenario->kind->advance(g, end < WATCHED ? end : WATCHED, &recorder, NULL, NULL, NULL));
    LL_TRY(scenario->kind->advance(g, end, NULL, NULL, NULL, NULL));
    put_loop(to, c->head.paper);
    put_captions(to, c);
    put_first(to, c, &work->watch, &work->lines);
    for (int i = 0; i < c->player_count; i++)
        put_arrivals(to, c->players[i].name, &work->watch.of[i]);
    put_acknowledged(to, g);
    return ll_ok();
}

ll_status ll_paper_netgame(const ll_scenario *scenario, FILE *to)
{
    ll_netgame *g = malloc(scenario->kind->size(scenario->config));
    watched *work = calloc(1, sizeof *work);
    ll_status status =
        g && work ? run_and_put(to, scenario, g, work) : ll_error(LL_NO_MEMORY, "out of memory: text");
    free(work);
    free(g);
    return status;
}
