/* A workload: recorded inputs of players over a session, which can drive other sessions.
 *
 * It is made from the log of a session with persons or scripts, and contains only the inputs: the session
 * that it drives has its own parameters. Inputs are matched by time, so that they act at the same moment when
 * ticks have another length. As in a log, an input holds from its tick until the next input of the same
 * player. Players with a script ignore it. */
#pragma once

#include "session/session.h"

enum { LL_WORKLOAD_MAX = 1000000 }; /* inputs */

typedef struct ll_workload ll_workload;

/* Parses {"tick_hz":60,"inputs":[{"tick":0,"player":0,"axes":[1,0],"buttons":0}]}, ascending by tick,
 * `buttons` optional; or a string with the lines of a log. Errors name the field below `workload`, or the
 * line, its range and the value. */
ll_status ll_workload_parse(const struct cJSON *json, ll_workload **workload);
void ll_workload_free(ll_workload *workload);

/* As an object, also when it was parsed from a log. Caller deletes; NULL without memory. */
struct cJSON *ll_workload_write(const ll_workload *workload);

/* LL_BAD_INPUT: the scenario lacks a player of the workload, or has no players. LL_CONFLICT: no player takes
 * inputs in this configuration. */
ll_status ll_workload_check(const ll_workload *workload, const ll_sim_kind *kind, const void *config);

/* Checks the workload and puts its inputs into the log of a session that is at tick 0 and has none. Inputs
 * after the session's end are left out. The head is then that of a session that was played; a command drops
 * the inputs after it. */
ll_status ll_session_load(ll_session *session, const ll_workload *workload);

/* Runs a session from tick 0 to its end and emits a log of all players' inputs, scripts included: the
 * scenario with every control set to `person`, the inputs, the head. The input of a client's frame gets the
 * tick before the frame; of two frames within one tick the later counts. LL_CONFLICT: the kind has no players
 * that take inputs. */
ll_status ll_session_record(ll_session *session, ll_log_line *line, void *context);
