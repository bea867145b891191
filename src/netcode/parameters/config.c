#include "netcode/protocol/config.h"

#include "link/transport/transport.h"
#include "netcode/protocol/sync.h"
#include "netcode/reckoning/reckoning.h"
#include "netcode/server/starve.h"
#include "netcode/snapshot/snapshot.h"

static const char *const refusals[] = {"neutral", "previous", NULL};

static const ll_param server_rows[] = {
    {LL_PARAM_ROW("update_hz", REAL, ll_server_config, update_hz), .min = 1, .max = 128, .default_value = 30,
     .unit = "Hz", .live = true,
     .help = "How often the server sends to every client: snapshots, or with deterministic and rollback the "
             "other players' inputs. In lockstep also how often it steps."},
    {LL_PARAM_ROW("sync", CHOICE, ll_server_config, sync), .choices = ll_sync_mode_names, .live = true,
     .help =
         "How server and clients keep in step. free: the server runs on its own clock. lockstep: every "
         "client sends an input and waits for the snapshot. lockstep_pipelined: clients do not wait, the "
         "server does. gambetta: the server applies all queued inputs at each update, as the live demo does. "
         "deterministic and rollback: only inputs are sent, and every client steps the whole world itself. "
         "bucket: no client waits; an input counts bucket_delay_ms after its interval of update_hz, and one "
         "that arrives later is ignored."},
    {LL_PARAM_ROW("transport", CHOICE, ll_server_config, transport), .choices = ll_transport_names,
     .help =
         "How messages travel, both ways. udp: each by itself, once. tcp: in one reliable ordered stream, "
         "where one lost packet holds up all later messages. quic: in streams side by side, reliable, by "
         "default one for each type of message. webrtc: on a data channel, by default unreliable. Each "
         "with its headers, acknowledgements and congestion window."},
    {LL_PARAM_ROW("delivery", CHOICE, ll_server_config, delivery), .choices = ll_delivery_names,
     .help =
         "How quic and webrtc deliver messages. usual: quic reliable_ordered_by_type, webrtc unreliable. "
         "unreliable: nothing is sent again. sequenced: neither, and a message older than the last of its "
         "type is dropped. reliable_unordered: lost messages are sent again and no other waits for them. "
         "reliable_ordered_by_type: those of the same type wait. reliable_ordered: all wait, as in tcp."},
    {LL_PARAM_ROW("congestion", CHOICE, ll_server_config, congestion), .choices = ll_congestion_names,
     .help =
         "Congestion control of tcp, quic and webrtc. reno: half the window after a loss, then one packet "
         "more per round trip. cubic: 0.7 of it, then a cubic function of time."},
    {LL_PARAM_ROW("nagle", BOOL, ll_server_config, nagle),
     .help = "With tcp: small messages wait until all before are acknowledged, to share a packet. Games "
             "switch it off (TCP_NODELAY)."},
    {LL_PARAM_ROW("timeout_s", REAL, ll_server_config, timeout_s), .max = 600, .default_value = 5,
     .unit = "s", .live = true,
     .help = "A connection without packets for this long ends on both sides; the client connects again when "
             "it can. 0 disables the timeout."},
    {LL_PARAM_ROW("validation", BOOL, ll_server_config, validation), .default_value = 1, .live = true,
     .help = "The server refuses inputs that are too large, too many, or for more time than has passed. Off: "
             "it accepts every input, which shows the effect of a cheat."},
    {LL_PARAM_ROW("detection", BOOL, ll_server_config, detection),
     .help =
         "The server watches every player for cheats by statistics: the rate of inputs, and in games with "
         "weapons reactions below 100 ms to what comes in sight, and aims that snap onto a target. It only "
         "raises alarms."},
    {LL_PARAM_ROW("refused", CHOICE, ll_server_config, refused), .choices = refusals, .live = true,
     .help = "What replaces a refused input. neutral: no control touched. previous: the input before it, "
             "which a cheat can exploit."},
    {LL_PARAM_ROW("starved", CHOICE, ll_server_config, starved), .choices = ll_starve_names, .live = true,
     .help = "With sync free and bucket, what replaces an input that has not arrived at its step. decay: the "
             "axes of "
             "the last applied input go to zero within starved_tau_ms. repeat: they are kept. repeat_n: they "
             "are kept for starved_ticks. neutral: they are zero at once. Presses are never repeated."},
    {LL_PARAM_ROW("starved_tau_ms", REAL, ll_server_config, starved_tau_ms), .min = 1, .max = 10000,
     .default_value = 250, .unit = "ms", .live = true,
     .help = "Time in which decay brings the axes to zero."},
    {LL_PARAM_ROW("starved_ticks", INT, ll_server_config, starved_ticks), .max = 1000, .default_value = 12,
     .unit = "ticks", .live = true, .help = "Number of ticks for which repeat_n repeats."},
    {LL_PARAM_ROW("hitscan", CHOICE, ll_server_config, compensation.hitscan), .choices = ll_hitscan_names,
     .default_value = 1, .live = true,
     .help =
         "How hitscan shots are judged. none: against the server's present. rewind: against the targets "
         "where the shooter saw them. client_authoritative: as the client claims (insecure). hybrid: as "
         "rewind for young views, less for older ones. victim_veto: as rewind, unless the victim had hidden "
         "from the shooter. Their parameters are those of policies."},
    {LL_PARAM_ROW("projectile", CHOICE, ll_server_config, compensation.projectile),
     .choices = ll_projectile_names, .default_value = 2, .live = true,
     .help =
         "How projectiles are judged. none (A): they start in the server's present. fast_forward (B): they "
         "start where the shooter draws them, among the targets of the present. rewind (C): projectile and "
         "targets start together at the time that the shooter saw. partial (D): fast-forwarded by at most "
         "projectile_forward_ms. client_authoritative: as the client claims (insecure)."},
    {LL_PARAM_ROW("projectile_trace", CHOICE, ll_server_config, compensation.projectile_trace),
     .choices = ll_trace_names, .live = true,
     .help = "How each part of a projectile's path is tested for hits. parabola: along the flight itself, "
             "with its drag. straight: along the straight line between its ends. drag_neglected: the past "
             "part along a parabola as if there were no drag."},
    {LL_PARAM_ROW("max_rewind_ms", REAL, ll_server_config, compensation.max_rewind_ms), .max = 1000,
     .default_value = 250, .unit = "ms", .live = true,
     .help = "Maximum rewind for any age of the shooter's view."},
    {LL_PARAM_ROW("rewind_tolerance_ms", REAL, ll_server_config, compensation.rewind_tolerance_ms),
     .max = 10000, .default_value = 200, .unit = "ms", .live = true,
     .help = "Tolerance for the view age that a client states. A client draws its newest snapshot, whose age "
             "the server measures, or up to two updates before it. If the stated age exceeds that by more "
             "than the tolerance, the measured age counts."},
    {LL_PARAM_ROW("projectile_forward_ms", REAL, ll_server_config, compensation.projectile_forward_ms),
     .max = 1000, .default_value = 100, .unit = "ms", .live = true,
     .help = "Longest time by which the projectile policy partial fast-forwards."},
    {LL_PARAM_ROW("snapshot_encoding", CHOICE, ll_server_config, snapshot), .choices = ll_codec_names,
     .live = true,
     .help =
         "How a snapshot is encoded. full: as it lies in memory. quantised: rounded to a grid. delta: "
         "only the differences on that grid from the newest snapshot that the client has acknowledged "
         "(of the last 32). partial: of the changed entities those of the largest accumulated priority "
         "that fit snapshot_bytes. partial_delta: the same, each entity as its differences from its newest "
         "acknowledged state. interest: the same, only entities within interest_radius_m. These three "
         "cannot be changed to the others, or from them, in a running session."},
    {LL_PARAM_ROW("snapshot_bytes", INT, ll_server_config, selection.bytes), .max = 60000, .unit = "B",
     .help = "With partial, partial_delta and interest: largest size of a snapshot's world, without its "
             "header and the game's own state; 0: no limit. The player's own entity is always sent."},
    {LL_PARAM_ROW("interest_radius_m", REAL, ll_server_config, selection.radius_m), .max = 100000,
     .unit = "m", .live = true,
     .help = "With interest: radius of the area around a player's entity whose entities it is sent; 0: "
             "everything. With partial, partial_delta and interest priority is 1 up to a quarter of it and "
             "falls as 1 / distance beyond; 0: all the same."},
    {LL_PARAM_ROW("interest_margin_m", REAL, ll_server_config, selection.margin_m), .max = 100000,
     .unit = "m", .live = true,
     .help = "With interest: an entity leaves the area this much farther away than it enters. At least twice "
             "the highest speed times the delay keeps one at the edge from coming and going."},
    {LL_PARAM_ROW("quantum_m", REAL, ll_server_config, quantum_m), .min = 0.0001, .max = 10,
     .default_value = 0.002, .unit = "m", .live = true,
     .help =
         "Grid step of positions: a sent position of another entity is off by at most half of it per axis."},
    {LL_PARAM_ROW("quantum_mps", REAL, ll_server_config, quantum_mps), .min = 0.0001, .max = 10,
     .default_value = 0.02, .unit = "m/s", .live = true, .help = "Grid step of velocities."},
    {LL_PARAM_ROW("quantum_rad", REAL, ll_server_config, quantum_rad), .min = 0.0001, .max = 1,
     .default_value = 0.005, .unit = "rad", .live = true, .help = "Grid step of angles."},
    {LL_PARAM_ROW("quantum_radps", REAL, ll_server_config, quantum_radps), .min = 0.0001, .max = 10,
     .default_value = 0.05, .unit = "rad/s", .live = true, .help = "Grid step of angular velocities."},
    {LL_PARAM_ROW("max_rollback_ticks", INT, ll_server_config, max_rollback_ticks), .max = LL_ROLLBACK_MAX,
     .default_value = 8, .unit = "ticks", .live = true,
     .help = "Rollback: prediction window; a client steps at most this many ticks with guessed inputs before "
             "it waits."},
    {LL_PARAM_ROW("sync_test_ticks", INT, ll_server_config, sync_test_ticks), .max = LL_SYNC_TEST_MAX,
     .unit = "ticks", .live = true,
     .help = "Sync test with deterministic and rollback: every frame a client rolls back this many ticks, "
             "resimulates and compares; 0: off."},
};

const ll_param_table ll_server_table = {
    .name = "server", .help = "The authoritative server.", LL_PARAM_ROWS(server_rows, ll_server_config)};

enum { HYBRID_FULL_MS = 150, HYBRID_NONE_MS = 350, VETO_GRACE_MS = 100 };

const ll_policy_params ll_policy_defaults = {HYBRID_FULL_MS, HYBRID_NONE_MS, VETO_GRACE_MS};

static const ll_param policy_rows[] = {
    {LL_PARAM_ROW("hybrid_full_ms", REAL, ll_policy_params, hybrid_full_ms), .max = 1000,
     .default_value = HYBRID_FULL_MS, .unit = "ms",
     .help = "With server.hitscan hybrid, oldest view that is rewound whole."},
    {LL_PARAM_ROW("hybrid_none_ms", REAL, ll_policy_params, hybrid_none_ms), .max = 1000,
     .default_value = HYBRID_NONE_MS, .unit = "ms",
     .help =
         "With server.hitscan hybrid, age of a view from which on nothing is rewound. From hybrid_full_ms "
         "to here the rewound share falls linearly. Not above hybrid_full_ms: it ends there at once."},
    {LL_PARAM_ROW("veto_grace_ms", REAL, ll_policy_params, veto_grace_ms), .max = 1000,
     .default_value = VETO_GRACE_MS, .unit = "ms",
     .help = "With server.hitscan victim_veto, time after which a player who has hidden from the shooter in "
             "its own view is no longer hit, as far as the server knows that view."},
};

const ll_param_table ll_policy_table = {.name = "policies",
                                        .help = "Parameters of single policies of lag compensation.",
                                        LL_PARAM_ROWS(policy_rows, ll_policy_params)};

static const ll_param reckoning_rows[] = {
    {LL_PARAM_ROW("model", CHOICE, ll_reckoning_params, model), .choices = ll_reckoning_names,
     .help = "Model by which server and clients move the entities of others that are not sent. none: no dead "
             "reckoning. static: they stay. velocity: they go on, without turning. velocity_spin: and they "
             "turn on. acceleration: with the acceleration that they had when they were sent."},
    {LL_PARAM_ROW("threshold_m", REAL, ll_reckoning_params, threshold_m), .max = 100, .default_value = 1,
     .unit = "m", .help = "An entity is sent when it is farther than this from where the model has it."},
    {LL_PARAM_ROW("threshold_deg", REAL, ll_reckoning_params, threshold_deg), .max = 360, .default_value = 3,
     .unit = "deg", .help = "Or when it has turned more than this from the model."},
    {LL_PARAM_ROW("heartbeat_s", REAL, ll_reckoning_params, heartbeat_s), .max = 60, .default_value = 5,
     .unit = "s", .help = "Or this long after it was last sent, which makes up for lost packets. 0: never."},
    {LL_PARAM_ROW("convergence", CHOICE, ll_reckoning_params, convergence), .choices = ll_convergence_names,
     .default_value = 1,
     .help = "How the drawn entity gets from the old model to the new one. snap: at once. linear: the "
             "difference shrinks evenly. cubic: without a jump of the velocity. projective: old and new "
             "motion continue and are blended."},
    {LL_PARAM_ROW("tau_s", REAL, ll_reckoning_params, tau_s), .min = 0.01, .max = 5, .default_value = 0.3,
     .unit = "s", .help = "Duration of convergence."},
};

const ll_param_table ll_reckoning_table = {
    .name = "reckoning",
    .help = "Dead reckoning with send thresholds, in place of snapshots of all entities. Others are then "
            "drawn at the server's present: interpolation and extrapolation have no effect.",
    LL_PARAM_ROWS(reckoning_rows, ll_reckoning_params)};
