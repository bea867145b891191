#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <stdlib.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "integrators/solver.h"

typedef struct state {
    const task *task;
    const struct module *module;
    SUNContext context;
    void *memory;
    N_Vector start, y;
    SUNMatrix matrix;
    SUNLinearSolver linear;
    SUNNonlinearSolver fixed_point;
    counts counts;
} state;

/* A method: how to set it up, and the same three calls of each of the packages. */
typedef struct module {
    const char *method;
    bool newton;
    bool (*open)(state *s);
    int (*again)(state *s);
    int (*evolve)(state *s, double *t);
    int (*steps)(void *memory, long *steps);
    void (*close)(void **memory);
    int table; /* of ARKODE's explicit methods */
} module;

static int f(realtype t, N_Vector y, N_Vector dy, void *state_)
{
    state *s = state_;
    s->counts.evaluations++;
    ll_ode_eval(&s->task->ode, t, NV_DATA_S(y), NV_DATA_S(dy));
    return 0;
}

/* Ours are row after row, theirs column after column. */
static int jacobian(realtype t, N_Vector y, N_Vector fy, SUNMatrix matrix, void *state_, N_Vector a,
                    N_Vector b, N_Vector c)
{
    (void)fy, (void)a, (void)b, (void)c;
    state *s = state_;
    const ll_ode *ode = &s->task->ode;
    double rows[LL_ODE_DIM_MAX * LL_ODE_DIM_MAX];
    s->counts.jacobians++;
    ode->jacobian(ode->params, t, NV_DATA_S(y), rows);
    for (int j = 0; j < ode->dim; j++)
        for (int i = 0; i < ode->dim; i++)
            SM_ELEMENT_D(matrix, i, j) = rows[i * ode->dim + j];
    return 0;
}

static void silent(int code, const char *package, const char *function, char *text, void *data)
{
    (void)code, (void)package, (void)function, (void)text, (void)data;
}

static void make_linear(state *s)
{
    sunindextype dim = s->task->ode.dim;
    s->matrix = SUNDenseMatrix(dim, dim, s->context);
    s->linear = SUNLinSol_Dense(s->y, s->matrix, s->context);
}

/* ---- CVODE ---- */

static bool open_cvode(state *s)
{
    s->memory = CVodeCreate(s->module->newton ? CV_BDF : CV_ADAMS, s->context);
    CVodeInit(s->memory, f, 0, s->start);
    CVodeSetErrHandlerFn(s->memory, silent, NULL);
    CVodeSetUserData(s->memory, s);
    CVodeSetMaxNumSteps(s->memory, SOLVER_STEPS_MAX);
    if (!s->module->newton) {
        s->fixed_point = SUNNonlinSol_FixedPoint(s->y, 0, s->context);
        return CVodeSetNonlinearSolver(s->memory, s->fixed_point) == 0 &&
               CVodeSStolerances(s->memory, s->task->relative, s->task->absolute) == 0;
    }
    make_linear(s);
    return CVodeSetLinearSolver(s->memory, s->linear, s->matrix) == 0 &&
           CVodeSetJacFn(s->memory, jacobian) == 0 &&
           CVodeSStolerances(s->memory, s->task->relative, s->task->absolute) == 0;
}

static int again_cvode(state *s)
{
    int flag = CVodeReInit(s->memory, 0, s->start);
    return flag != 0 ? flag : CVodeSetStopTime(s->memory, s->task->duration);
}

static int evolve_cvode(state *s, double *t)
{
    return CVode(s->memory, s->task->duration, s->y, t, CV_NORMAL);
}

/* ---- ARKODE ---- */

static bool open_erk(state *s)
{
    s->memory = ERKStepCreate(f, 0, s->start, s->context);
    ERKStepSetErrHandlerFn(s->memory, silent, NULL);
    ERKStepSetUserData(s->memory, s);
    ERKStepSetMaxNumSteps(s->memory, SOLVER_STEPS_MAX);
    return ERKStepSetTableNum(s->memory, (ARKODE_ERKTableID)s->module->table) == 0 &&
           ERKStepSStolerances(s->memory, s->task->relative, s->task->absolute) == 0;
}

static int again_erk(state *s)
{
    int flag = ERKStepReInit(s->memory, f, 0, s->start);
    return flag != 0 ? flag : ERKStepSetStopTime(s->memory, s->task->duration);
}

static int evolve_erk(state *s, double *t)
{
    return ERKStepEvolve(s->memory, s->task->duration, s->y, t, ARK_NORMAL);
}

static bool open_dirk(state *s)
{
    enum { HIGHEST = 5 };
    s->memory = ARKStepCreate(NULL, f, 0, s->start, s->context);
    ARKStepSetErrHandlerFn(s->memory, silent, NULL);
    ARKStepSetUserData(s->memory, s);
    ARKStepSetMaxNumSteps(s->memory, SOLVER_STEPS_MAX);
    make_linear(s);
    return ARKStepSetOrder(s->memory, HIGHEST) == 0 &&
           ARKStepSetLinearSolver(s->memory, s->linear, s->matrix) == 0 &&
           ARKStepSetJacFn(s->memory, jacobian) == 0 &&
           ARKStepSStolerances(s->memory, s->task->relative, s->task->absolute) == 0;
}

static int again_dirk(state *s)
{
    int flag = ARKStepReInit(s->memory, NULL, f, 0, s->start);
    return flag != 0 ? flag : ARKStepSetStopTime(s->memory, s->task->duration);
}

static int evolve_dirk(state *s, double *t)
{
    return ARKStepEvolve(s->memory, s->task->duration, s->y, t, ARK_NORMAL);
}

/* ---- either ---- */

static void close_state(void *state_)
{
    state *s = state_;
    s->module->close(&s->memory);
    if (s->fixed_point != NULL)
        SUNNonlinSolFree(s->fixed_point);
    if (s->linear != NULL) {
        SUNLinSolFree(s->linear);
        SUNMatDestroy(s->matrix);
    }
    N_VDestroy(s->start);
    N_VDestroy(s->y);
    SUNContext_Free(&s->context);
    free(s);
}

static void *open_state(const solver *by, const task *t)
{
    state *s = malloc(sizeof *s);
    *s = (state){.task = t, .module = by->kind};
    SUNContext_Create(NULL, &s->context);
    s->start = N_VNew_Serial(t->ode.dim, s->context);
    N_VEnableFusedOps_Serial(s->start, SUNTRUE); /* sums of stages in one loop: faster */
    s->y = N_VClone(s->start);
    memcpy(NV_DATA_S(s->start), t->start, (size_t)t->ode.dim * sizeof(double));
    if (s->module->open(s))
        return s;
    close_state(s);
    return NULL;
}

static bool run(void *state_, double *y)
{
    state *s = state_;
    double t = 0;
    s->counts = (counts){0};
    if (s->module->again(s) != 0 || s->module->evolve(s, &t) < 0)
        return false;
    memcpy(y, NV_DATA_S(s->y), (size_t)s->task->ode.dim * sizeof *y);
    return t == s->task->duration;
}

static counts count_run(const void *state_)
{
    const state *s = state_;
    counts c = s->counts;
    long steps = 0;
    s->module->steps(s->memory, &steps);
    c.steps = steps;
    return c;
}

#define CVODE(method_, newton_)                                                                              \
    {                                                                                                        \
        .method = (method_), .newton = (newton_), .open = open_cvode, .again = again_cvode,                  \
        .evolve = evolve_cvode, .steps = CVodeGetNumSteps, .close = CVodeFree                                \
    }
#define ERK(method_, table_)                                                                                 \
    {                                                                                                        \
        .method = (method_), .open = open_erk, .again = again_erk, .evolve = evolve_erk,                     \
        .steps = ERKStepGetNumSteps, .close = ERKStepFree, .table = (table_)                                 \
    }

int sundials_solvers(solver *list, int count)
{
    static const module modules[] = {
        ERK("erk5", ARKODE_DORMAND_PRINCE_7_4_5),
        ERK("erk8", ARKODE_FEHLBERG_13_7_8),
        CVODE("adams", false),
        CVODE("bdf", true),
        {.method = "dirk5",
         .newton = true,
         .open = open_dirk,
         .again = again_dirk,
         .evolve = evolve_dirk,
         .steps = ARKStepGetNumSteps,
         .close = ARKStepFree},
    };
    for (size_t i = 0; i < sizeof modules / sizeof modules[0]; i++)
        list[count++] = (solver){.library = "SUNDIALS",
                                 .method = modules[i].method,
                                 .newton = modules[i].newton,
                                 .kind = &modules[i],
                                 .open = open_state,
                                 .run = run,
                                 .count = count_run,
                                 .close = close_state};
    return count;
}
