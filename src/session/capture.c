/* Packets of a session as a capture file. Every player and the server is an interface of it, so that a packet
 * that arrives is in the file twice: where it was sent, and where and when it was received. A packet that was
 * lost was only sent. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "capture/wire/wire_image.h"
#include "session/internal.h"

enum { EPOCH_S = 946684800 }; /* 2000-01-01T00:00:00Z: the time of a capture at virtual time 0 */

/* A packet that is still on its way. */
typedef struct arrival {
    ll_time due;
    uint64_t order; /* of packets due at the same time */
    int32_t player;
    bool up, intact;
    int32_t transport;   /* ll_transport_kind */
    ll_wire_image image; /* its bytes are owned */
} arrival;

typedef struct ll_capture {
    ll_pcapng file;
    int players; /* interfaces 0 to players - 1; the server's is the next */
    arrival *heap;
    size_t count, capacity;
    uint64_t order;
    int interface; /* that is written; LL_ALL_INTERFACES */
    ll_time from;  /* what is before is not written */
    ll_wire *wire;
    ll_status status;
} ll_capture;

static bool comes_before(const arrival *a, const arrival *b)
{
    return a->due != b->due ? a->due < b->due : a->order < b->order;
}

static void swap(arrival *a, arrival *b)
{
    arrival c = *a;
    *a = *b;
    *b = c;
}

static void push(ll_capture *c, const arrival *a)
{
    if (c->count == c->capacity) {
        size_t capacity = c->capacity ? 2 * c->capacity : 64;
        arrival *heap = realloc(c->heap, capacity * sizeof *heap);
        if (!heap) {
            free(a->image.bytes);
            c->status = ll_error(LL_NO_MEMORY, "out of memory: packets of a capture");
            return;
        }
        c->heap = heap;
        c->capacity = capacity;
    }
    size_t i = c->count++;
    c->heap[i] = *a;
    for (; i > 0 && comes_before(&c->heap[i], &c->heap[(i - 1) / 2]); i = (i - 1) / 2)
        swap(&c->heap[i], &c->heap[(i - 1) / 2]);
}

static arrival pop(ll_capture *c)
{
    arrival first = c->heap[0];
    c->heap[0] = c->heap[--c->count];
    for (size_t i = 0, least; 2 * i + 1 < c->count; i = least) {
        least = 2 * i + 1;
        if (least + 1 < c->count && comes_before(&c->heap[least + 1], &c->heap[least]))
            least++;
        if (!comes_before(&c->heap[least], &c->heap[i]))
            break;
        swap(&c->heap[i], &c->heap[least]);
    }
    return first;
}

static uint64_t time_of(ll_time t)
{
    return (uint64_t)(EPOCH_S * (int64_t)LL_SECOND + t);
}

/* At the interface of its sender, or of its receiver. */
static void write_packet(const ll_capture *c, const arrival *a, ll_time time, bool received)
{
    int interface = a->up == received ? c->players : a->player;
    if (time < c->from || (c->interface != LL_ALL_INTERFACES && c->interface != interface))
        return;
    ll_pcapng_packet_write(&c->file, &(ll_pcapng_packet){.interface = (uint32_t)interface,
                                                         .inbound = received,
                                                         .time_ns = time_of(time),
                                                         .bytes = a->image.bytes,
                                                         .size = a->image.size,
                                                         .comment = a->image.comment});
}

/* Writes what has arrived up to `until`. */
static void write_arrivals(ll_capture *c, ll_time until)
{
    while (c->count > 0 && c->heap[0].due <= until) {
        arrival a = pop(c);
        write_packet(c, &a, a.due, true);
        if (a.intact)
            ll_wire_arrived(c->wire, a.transport, a.player, a.up, a.image.bytes);
        free(a.image.bytes);
    }
}

static void receive(ll_capture *c, const arrival *sent, ll_fate fate, ll_time due, const char *remark)
{
    if (fate != LL_FATE_DELIVERED && fate != LL_FATE_CORRUPTED)
        return;
    arrival a = *sent;
    ll_wire_image *image = &a.image;
    a.due = due;
    a.order = c->order++;
    a.intact = fate == LL_FATE_DELIVERED;
    image->bytes = malloc(image->size);
    if (!image->bytes) {
        c->status = ll_error(LL_NO_MEMORY, "out of memory: packets of a capture");
        return;
    }
    memcpy(image->bytes, sent->image.bytes, image->size);
    if (!a.intact)
        image->bytes[image->size - 1] ^= 1; /* the checksum no longer holds */
    snprintf(image->comment, sizeof image->comment, "%.*s%s", LL_PCAPNG_COMMENT_MAX - 32, sent->image.comment,
             remark);
    push(c, &a);
}

/* An ll_recorder function; the context is the session. */
static void capture_packet(void *context, const void *row)
{
    ll_capture *c = ((ll_session *)context)->capture;
    const ll_packet *p = row;
    const ll_link_packet *l = p->on_link;
    arrival sent = {.player = p->player, .up = p->up, .transport = p->transport};
    write_arrivals(c, p->sent);
    if (ll_failed(&c->status))
        return;
    c->status = ll_wire_image_of(c->wire, p, &sent.image);
    if (ll_failed(&c->status))
        return;
    write_packet(c, &sent, p->sent, false);
    receive(c, &sent, l->fate, l->due, "");
    if (l->duplicated)
        receive(c, &sent, l->copy_fate, l->copy_due, "; duplicate");
    free(sent.image.bytes);
}

int ll_session_players(const ll_session *s)
{
    const ll_sim_kind *kind = s->scenario.kind;
    int players = 0;
    while (kind->player_name && kind->player_name(s->config, players))
        players++;
    return players;
}

ll_status ll_session_interface(const ll_session *s, const char *name, int *interface)
{
    int players = ll_session_players(s);
    char known[256] = "server";
    *interface = LL_ALL_INTERFACES;
    if (!name || !*name)
        return ll_ok();
    for (int i = 0; i < players; i++) {
        const char *player = s->scenario.kind->player_name(s->config, i);
        size_t length = strlen(known);
        if (strcmp(name, player) == 0)
            *interface = i;
        snprintf(known + length, sizeof known - length, ", %s", player);
    }
    if (strcmp(name, "server") == 0)
        *interface = players;
    if (*interface == LL_ALL_INTERFACES)
        return ll_field_error(LL_BAD_INPUT, "at", "at: must be one of %s; got `%.40s`", known, name);
    return ll_ok();
}

static void begin(ll_capture *c, const ll_session *s)
{
    const ll_scenario_head *head = ll_session_head(s);
    char application[LL_VERSION_MAX + 16], comment[LL_PCAPNG_COMMENT_MAX];
    snprintf(application, sizeof application, "laglab %s", ll_version);
    snprintf(comment, sizeof comment, "%s; seed %" PRId64 "; virtual time 0 is 2000-01-01 00:00:00 UTC",
             head->title, head->seed);
    ll_pcapng_begin(&c->file, application, comment);
    c->players = ll_session_players(s);
    for (int i = 0; i < c->players; i++) {
        char interface[LL_TITLE_MAX];
        snprintf(interface, sizeof interface, "player %s", s->scenario.kind->player_name(s->config, i));
        ll_pcapng_interface(&c->file, interface);
    }
    ll_pcapng_interface(&c->file, "server");
}

ll_status ll_session_write_capture(ll_session *copy, const ll_capture_range *range,
                                   const ll_interrupt *interrupt,
                                   void (*write)(void *context, const char *bytes, size_t length),
                                   void *context)
{
    ll_capture capture = {.file = {write, context},
                          .interface = range->interface,
                          .from = ll_tick_time(range->from, copy->freq)};
    int64_t to = range->to;
    ll_piece piece = {1, 0};
    ll_status status = ll_ok();
    if (!copy->scenario.kind->player_name)
        return ll_error(LL_CONFLICT, "packets: the kind must be netgame; got %s", copy->scenario.kind->name);
    capture.wire = ll_wire_new();
    if (!capture.wire)
        return ll_error(LL_NO_MEMORY, "out of memory: packets of a capture");
    copy->capture = &capture;
    copy->on_packet = capture_packet;
    begin(&capture, copy);
    LL_THEN(status, ll_session_wake(copy)); /* packets of time 0 are sent while it wakes */
    for (int64_t tick = 0, stop = 0; tick <= to && !ll_failed(&status); tick++) {
        if (tick >= stop) {
            if (!ll_next_piece(&piece, interrupt))
                status = ll_error(LL_INTERRUPTED, "interrupted at tick %" PRId64 " of %" PRId64, tick, to);
            stop = tick + piece.size;
        }
        LL_THEN(status, ll_session_run_to(copy, tick));
        LL_THEN(status, capture.status);
    }
    if (!ll_failed(&status))
        write_arrivals(&capture, ll_tick_time(to, copy->freq));
    copy->capture = NULL;
    copy->on_packet = NULL;
    for (size_t i = 0; i < capture.count; i++)
        free(capture.heap[i].image.bytes);
    free(capture.heap);
    ll_wire_free(capture.wire);
    return status;
}

ll_status ll_session_capture(ll_session *s, const ll_capture_range *range,
                             void (*write)(void *context, const char *bytes, size_t length), void *context)
{
    ll_session *scratch;
    int64_t from = range->from, to = range->to;
    if (from < 0 || from > to || to > s->head)
        return ll_field_error(LL_BAD_INPUT, "to_s",
                              "from, to: must be in order from 0 to %" PRId64 "; got %" PRId64 " to %" PRId64,
                              s->head, from, to);
    LL_TRY(ll_session_copy(s, to, &scratch));
    ll_status status = ll_session_write_capture(scratch, range, NULL, write, context);
    ll_session_account_copy(s, scratch);
    ll_session_destroy(scratch);
    return status;
}
