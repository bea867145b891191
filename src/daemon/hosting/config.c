#include "daemon/hosting/host.h"

#define ROW(name_, type_) .name = #name_, .type = type_, .offset = offsetof(ll_host_config, name_)

static const ll_param rows[] = {
    {ROW(data, LL_PARAM_TEXT), .max = 511,
     .help = "Folder of the sessions' database; `memory` keeps them in memory only. Empty: "
             "$XDG_STATE_HOME/laglab or "
             "~/.local/state/laglab."},
    {ROW(store, LL_PARAM_TEXT), .max = 511,
     .help =
         "Where experiments are kept: sqlite:FILE or postgresql://USER@HOST/DATABASE, which `laglab worker` "
         "may share. Empty: $LAGLAB_STORE, or the folder of --data."},
    {ROW(scenarios, LL_PARAM_TEXT), .max = 511,
     .help = "Folder of the scenarios; empty: `scenarios` beside the program."},
    {ROW(api, LL_PARAM_TEXT), .max = 511,
     .help = "Folder of openapi.yaml and asyncapi.yaml; empty: `api` beside the program."},
    {ROW(threads, LL_PARAM_INT), .min = 0, .max = 256, .default_value = 0,
     .help = "Threads that step sessions; 0 is one per core."},
    {ROW(work_threads, LL_PARAM_INT), .min = 0, .max = 256, .default_value = 0,
     .help =
         "Requests that take long (seeks, traces, results, advice) that are worked on at once; 0 is one per "
         "core. The others wait for their turns, which go round."},
    {ROW(max_sessions, LL_PARAM_INT), .min = 1, .max = 1000000, .default_value = 2000,
     .help = "Sessions in total."},
    {ROW(max_memory_mib, LL_PARAM_INT), .min = 0, .max = 16777216, .default_value = 0, .unit = "MiB",
     .help = "Memory of all sessions that are awake, with the states that they keep; 0 is three quarters of "
             "the machine's or the container's."},
    {ROW(max_state_mib, LL_PARAM_INT), .min = 1, .max = 16777216, .default_value = 64, .unit = "MiB",
     .help = "State of one session, or of a run that a request asks for; a larger one is refused, since a "
             "tick of it may take long and cannot be broken off."},
    {ROW(max_new_sessions_per_min, LL_PARAM_REAL), .min = 1, .max = 1e6, .default_value = 120,
     .unit = "1/min", .help = "Sessions that one address may make, sustained; as many at once."},
    {ROW(max_code_lookups_per_min, LL_PARAM_REAL), .min = 1, .max = 1e6, .default_value = 60, .unit = "1/min",
     .help = "Class codes that one address may look up."},
    {ROW(max_commands_per_s, LL_PARAM_REAL), .min = 1, .max = 1e6, .default_value = 200, .unit = "1/s",
     .help = "Commands and inputs to one session, sustained; twice that in a burst."},
    {ROW(max_experiments, LL_PARAM_INT), .min = 1, .max = 1000000, .default_value = 200,
     .help = "Experiments in total, those that are done among them."},
    {ROW(max_client_experiments, LL_PARAM_INT), .min = 1, .max = 1000000, .default_value = 50,
     .help = "Of those, made by one address since the daemon's start."},
    {ROW(max_experiment_runs, LL_PARAM_INT), .min = 1, .max = 10000000, .default_value = 1000000,
     .help = "Runs of one experiment."},
    {ROW(experiment_ttl_s, LL_PARAM_REAL), .min = 1, .max = 1e9, .default_value = 2592000, .unit = "s",
     .help = "An experiment that was made so long ago and is neither running nor paused is deleted, at the "
             "next start or "
             "when the next is made."},
    {ROW(experiment_run_ttl_s, LL_PARAM_REAL), .min = 1, .max = 1e9, .default_value = 604800, .unit = "s",
     .help = "An experiment that was made so long ago and is not over is cancelled."},
    {ROW(max_log_mib, LL_PARAM_INT), .min = 0, .max = 1048576, .default_value = 64, .unit = "MiB",
     .help = "Log of one session; then its changes are refused with 507. 0 is no limit."},
    {ROW(max_logs_mib, LL_PARAM_INT), .min = 0, .max = 16777216, .default_value = 8192, .unit = "MiB",
     .help = "Logs of all sessions on the disk; then changes and new sessions are refused with 507. 0 is no "
             "limit."},
    {ROW(max_client_logs_mib, LL_PARAM_INT), .min = 0, .max = 16777216, .default_value = 2048, .unit = "MiB",
     .help = "Of those, of sessions that one address has made since the daemon's start. 0 is no limit."},
    {ROW(max_results_mib, LL_PARAM_INT), .min = 0, .max = 16777216, .default_value = 8192, .unit = "MiB",
     .help = "Results of all experiments in a store of SQLite's; one that would not fit is refused with 507. "
             "0 is no limit."},
    {ROW(job_cpu_s, LL_PARAM_REAL), .min = 0.01, .max = 1e6, .default_value = 600, .unit = "s",
     .help = "Processor time that one search for advice may use."},
    {ROW(job_idle_s, LL_PARAM_REAL), .min = 0.1, .max = 86400, .default_value = 10, .unit = "s",
     .help = "A search for advice that nobody has asked for in that time is cancelled."},
    {ROW(max_body_bytes, LL_PARAM_INT), .min = 1024, .max = 67108864, .default_value = 1048576, .unit = "B",
     .help = "Largest body of a request."},
    {ROW(park_after_s, LL_PARAM_REAL), .min = 0, .max = 86400, .default_value = 5, .unit = "s",
     .help = "A session without viewers and requests for that long is parked; sooner while more than half of "
             "max_memory_mib is taken, at once beyond three quarters."},
    {ROW(session_ttl_s, LL_PARAM_REAL), .min = 1, .max = 1e9, .default_value = 86400, .unit = "s",
     .help = "A session without viewers and requests for that long is deleted."},
    {ROW(save_every_s, LL_PARAM_REAL), .min = 0.1, .max = 3600, .default_value = 2, .unit = "s",
     .help = "How often the clock of a playing session is stored."},
};

const ll_param_table ll_host_table = {.name = "hosting",
                                      .help = "Hosting of sessions.",
                                      .rows = rows,
                                      .count = sizeof rows / sizeof rows[0],
                                      .size = sizeof(ll_host_config)};
