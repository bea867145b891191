/* A workload: what persons do at their controls over a session, to be given to other sessions.
 *
 * It is taken from the log of a session, recorded from people or from scripts, and holds the inputs alone:
 * parameters are what the session says that it is given to. An input is stamped by time, so that it falls on
 * the same moment where ticks are of another length. As in a log it counts from its tick on, until the next
 * of the same player; who is driven by a script does not take it. */
#pragma once

#include "session/session.h"

enum { LL_WORKLOAD_MAX = 1000000 }; /* inputs */

typedef struct ll_workload ll_workload;

/* From {"tick_hz":60,"inputs":[{"tick":0,"player":0,"axes":[1,0],"buttons":0}]}, in the order of ticks;
 * `buttons` may be left out. Or a text: the lines of a log. Errors name the field below `workload`, or the
 * line, its range and the value. */
ll_status ll_workload_parse(const struct cJSON *json, ll_workload **workload);
void ll_workload_free(ll_workload *workload);

/* The same as an object, whatever it was read from. Caller deletes; NULL without memory. */
struct cJSON *ll_workload_write(const ll_workload *workload);

/* LL_BAD_INPUT: the scenario has not all its players, or none at all. LL_CONFLICT: by this configuration none
 * of them takes inputs. */
ll_status ll_workload_check(const ll_workload *workload, const ll_sim_kind *kind, const void *config);

/* Checks, and puts the inputs into the log of a session that is at tick 0 and has none; what lies behind its
 * end is left out. The head is then that of a session that was played so far, and a command drops what the
 * log says after it. */
ll_status ll_session_load(ll_session *session, const ll_workload *workload);

/* Runs a session from tick 0 to its end and emits a log of what drove its players, scripts too: the scenario
 * with everybody's control `person`, the inputs, the head. What a client did in a frame is stamped with the
 * tick before it; of two frames within a tick the later counts. LL_CONFLICT: nobody can drive in it. */
ll_status ll_session_record(ll_session *session, ll_log_line *line, void *context);
