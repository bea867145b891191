/* The families, a row each. */
#include <string.h>

#include "experiment/advise/tradeoff.h"

#define CPU                                                                                                  \
    {                                                                                                        \
        "cpu_s", "CPU time of a run, minimum, s"                                                             \
    }
#define MEMORY                                                                                               \
    {                                                                                                        \
        "cost.block_bytes", "memory of the simulation, bytes"                                                \
    }

const ll_tradeoff_family ll_tradeoff_families[] = {
    {"integrators",
     "Integrators",
     "Every integrator by its step or tolerance, on an orbit of eccentricity 0.9 and on Robertson's stiff "
     "reaction.",
     "explicit_euler,velocity_verlet,rk4,dopri5,dop853,radau5",
     {{"motion/orbit", "methods.0.e_max_weighted", "error of an eccentric orbit"},
      {"motion/stiff_reaction", "methods.0.e_max_weighted", "error of a stiff reaction"}},
     {CPU, {"methods.0.evaluations", "evaluations of f"}}},
    {"contact_solvers",
     "Contact solvers",
     "Each contact solver by its substeps: how far a column sags, and how far a box of a pyramid drifts.",
     "soft_step,tgs_sticky,xpbd,avbd",
     {{"rigid/column", "sag_m", "sag of a column of 20 boxes, m"},
      {"rigid/pyramid", "drift_worst_m", "largest drift in a pyramid, m"}},
     {CPU, {"passes_per_s", "passes over the contacts per simulated second"}}},
    {"pressure_solvers",
     "Pressure solvers",
     "Each pressure solver of a grid by its sweeps: the divergence that remains in a driven cavity.",
     "jacobi,gauss_seidel,sor,pcg,multigrid",
     {{"fluid/cavity", "divergence_max", "largest divergence, 1/s"}},
     {CPU, {"cell_visits", "visits of cells"}, MEMORY}},
    {"particles",
     "Particles",
     "Methods of particles by their number and by the iterations of the pressure solver: pressure at rest, "
     "and the profile of a channel.",
     "wcsph,pbf,dfsph",
     {{"fluid/hydrostatic", "pressure_error_rms", "error of the pressure at rest"},
      {"fluid/poiseuille", "velocity_error_rms", "error of a channel's velocity"}},
     {CPU, {"cell_visits", "visits of particles"}, MEMORY}},
    {"oceans",
     "Oceans",
     "A spectrum by its points, a repeated tile by its points, and a sum of Gerstner's waves by their "
     "number: the wave height against that of the sea that the wind raises, and how far the heights are from "
     "the normal distribution that many independent waves have.",
     "spectrum,tiled,gerstner",
     {{"fluid/sea", "height_error", "error of the wave height"},
      {"fluid/sea", "excess_kurtosis", "excess kurtosis of the heights"}},
     {CPU, MEMORY}},
    {"snapshots",
     "Snapshots",
     "Encodings of snapshots by the update rate or by the bytes of a snapshot, with thirty crates and with a "
     "swarm of 200; and the curves between snapshots.",
     "full,delta,partial_delta,interest,linear,hermite",
     {{"crates_delta", "players.0.remote_error_m.mean", "error of the others, m"},
      {"swarm_interest", "players.0.selection.near_error_m", "error of near ones, m"},
      {"hermite", "players.0.timeline_error_m.mean", "error of interpolation, m"}},
     {CPU,
      {"players.0.bandwidth.down_bytes_per_s", "bytes/s to a player"},
      {"players.0.view_age_ms.mean", "age of the others as drawn, ms"},
      MEMORY}},
    {"synchronisation",
     "Synchronisation",
     "Ways to keep server and clients in step by the update rate, the playout delay or the input delay: "
     "three cars, one of them on a link with jitter and loss. While the server waits the game stands still, "
     "which makes errors and costs per second smaller: compare the time that it waited.",
     "free,lockstep,lockstep_pipelined,deterministic,rollback,bucket",
     {{"deterministic", "players.0.remote_error_m.mean", "error of the others, m"}},
     {CPU,
      {"players.0.bandwidth.down_bytes_per_s", "bytes/s to a player"},
      {"players.0.input_latency_ms.mean", "input latency, ms"},
      {"server.stalled_s", "time that the server waited, s"}}},
    {"lag_compensation",
     "Lag compensation",
     "Policies of lag compensation by their limits: shots that hit in the shooter's view and do not count, "
     "against hits on a player who was behind cover in its own. client_authoritative believes every "
     "client.",
     "none,rewind,client_authoritative,hybrid,victim_veto",
     {{"behind_cover", "players.1.shots.hitscan.false_misses", "hits seen that did not count"}},
     {CPU,
      {"players.1.shots.hitscan.shot_behind_cover", "hits behind cover"},
      {"players.1.bandwidth.down_bytes_per_s", "bytes/s to the shooter"},
      MEMORY}},
    {0},
};

const ll_tradeoff_family *ll_tradeoff_family_find(const char *name)
{
    for (const ll_tradeoff_family *f = ll_tradeoff_families; f->name; f++)
        if (strcmp(f->name, name) == 0)
            return f;
    return NULL;
}

int ll_tradeoff_problem_count(const ll_tradeoff_family *family)
{
    int n = 0;
    while (n < LL_TRADEOFF_PROBLEMS_MAX && family->problems[n].scenario)
        n++;
    return n;
}

int ll_tradeoff_cost_count(const ll_tradeoff_family *family)
{
    int n = 0;
    while (n < LL_TRADEOFF_COSTS_MAX && family->costs[n].path)
        n++;
    return n;
}
