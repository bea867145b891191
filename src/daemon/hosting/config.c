#include "daemon/hosting/host.h"

#define ROW(name_, type_) LL_PARAM_ROW(#name_, type_, ll_host_config, name_)

static const ll_param rows[] = {
    {ROW(data, TEXT), .max = 511,
     .help = "Folder of the sessions' database; `memory`: not stored. Empty: $XDG_STATE_HOME/laglab or "
             "~/.local/state/laglab."},
    {ROW(shard, TEXT), .max = LL_SHARD_LENGTH,
     .help = "Name of this daemon among several behind one proxy, 1 to 4 of a-z and 0-9 without i, l and o: "
             "its ids, codes and links begin with it. Empty: it is alone."},
    {ROW(scenarios, TEXT), .max = 511,
     .help = "Folder of the scenarios; empty: `scenarios` next to the program."},
    {ROW(api, TEXT), .max = 511,
     .help = "Folder of openapi.yaml and asyncapi.yaml; empty: `api` next to the program."},
    {ROW(threads, INT), .min = 0, .max = 256, .default_value = 0,
     .help = "Threads that step sessions; 0: one per core."},
    {ROW(work_threads, INT), .min = 0, .max = 256, .default_value = 0,
     .help = "Long requests (seeks, traces, results, advice) that run at once; 0: one per core. Others wait "
             "for their turns."},
    {ROW(max_sessions, INT), .min = 1, .max = 1000000, .default_value = 2000,
     .help = "Maximum number of sessions."},
    {ROW(max_memory_mib, INT), .min = 0, .max = 16777216, .default_value = 0, .unit = "MiB",
     .help = "Memory of all sessions that are awake, with their checkpoints; 0: three quarters of the "
             "machine's or the container's."},
    {ROW(max_state_mib, INT), .min = 1, .max = 16777216, .default_value = 64, .unit = "MiB",
     .help = "Maximum state size of a session, or of a run that a request asks for. Larger ones are refused, "
             "since one of their ticks may take long and cannot be interrupted."},
    {ROW(max_new_sessions_per_min, REAL), .min = 1, .max = 1e6, .default_value = 120, .unit = "1/min",
     .help = "Sessions that one address may create, sustained and as a burst."},
    {ROW(max_code_lookups_per_min, REAL), .min = 1, .max = 1e6, .default_value = 60, .unit = "1/min",
     .help = "Join codes that one address may look up."},
    {ROW(max_commands_per_s, REAL), .min = 1, .max = 1e6, .default_value = 200, .unit = "1/s",
     .help = "Commands and inputs to one session, sustained; twice that in a burst."},
    {ROW(max_experiments, INT), .min = 1, .max = 1000000, .default_value = 200,
     .help = "Maximum number of experiments, finished ones included."},
    {ROW(max_client_experiments, INT), .min = 1, .max = 1000000, .default_value = 50,
     .help = "Maximum number of experiments of one address since the daemon's start."},
    {ROW(max_experiment_runs, INT), .min = 1, .max = 10000000, .default_value = 1000000,
     .help = "Maximum runs of one experiment."},
    {ROW(experiment_ttl_s, REAL), .min = 1, .max = 1e9, .default_value = 2592000, .unit = "s",
     .help = "Age at which an experiment that is neither running nor paused is deleted, at the next start or "
             "when the next is created."},
    {ROW(experiment_run_ttl_s, REAL), .min = 1, .max = 1e9, .default_value = 604800, .unit = "s",
     .help = "Age at which an unfinished experiment is cancelled."},
    {ROW(max_log_mib, INT), .min = 0, .max = 1048576, .default_value = 64, .unit = "MiB",
     .help = "Maximum log size of one session; its changes are refused with 507 beyond it. 0: no limit."},
    {ROW(max_logs_mib, INT), .min = 0, .max = 16777216, .default_value = 8192, .unit = "MiB",
     .help = "Maximum log size of all sessions on disk; changes and new sessions are refused with 507 beyond "
             "it. 0: no limit."},
    {ROW(max_client_logs_mib, INT), .min = 0, .max = 16777216, .default_value = 2048, .unit = "MiB",
     .help =
         "Maximum log size of all sessions that one address created since the daemon's start. 0: no limit."},
    {ROW(max_results_mib, INT), .min = 0, .max = 16777216, .default_value = 8192, .unit = "MiB",
     .help = "Maximum size of all results of experiments; one that would exceed it is refused "
             "with 507. 0: no limit."},
    {ROW(job_cpu_s, REAL), .min = 0.01, .max = 1e6, .default_value = 600, .unit = "s",
     .help = "Maximum processor time of one search for advice, and of each thread of a measurement."},
    {ROW(job_idle_s, REAL), .min = 0.1, .max = 86400, .default_value = 10, .unit = "s",
     .help = "A search for advice is cancelled after this time without a request."},
    {ROW(max_body_bytes, INT), .min = 1024, .max = 67108864, .default_value = 1048576, .unit = "B",
     .help = "Maximum size of a request body."},
    {ROW(park_after_s, REAL), .min = 0, .max = 86400, .default_value = 5, .unit = "s",
     .help = "A session is parked after this time without viewers and requests; sooner when more than half "
             "of max_memory_mib is used, at once above three quarters."},
    {ROW(session_ttl_s, REAL), .min = 1, .max = 1e9, .default_value = 86400, .unit = "s",
     .help = "A session is deleted after this time without viewers and requests."},
    {ROW(save_every_s, REAL), .min = 0.1, .max = 3600, .default_value = 2, .unit = "s",
     .help = "Interval at which the clock of a playing session is stored."},
};

const ll_param_table ll_host_table = {
    .name = "hosting", .help = "Hosting of sessions.", LL_PARAM_ROWS(rows, ll_host_config)};
