/* Boost.Odeint: its controlled steppers on arrays of a size known to the compiler, as its documentation advises for
 * speed; Rosenbrock's method on uBLAS, the only one it has for stiff systems. */
extern "C" {
#include "integrators/solver.h"
}

#include <algorithm>
#include <array>
#include <boost/numeric/odeint.hpp>
#include <new>
#include <vector>

namespace odeint = boost::numeric::odeint;
namespace ublas = boost::numeric::ublas;

namespace {

struct system_of { /* dy/dt, as the other libraries have it */
    const ll_ode *ode;
    counts *count;
    template <class State> void operator()(const State &y, State &dy, double t) const
    {
        count->evaluations++;
        ll_ode_eval(ode, t, &y[0], &dy[0]);
    }
};

struct jacobian_of { /* with the derivative by t, by a difference where the system depends on t */
    const task *job;
    counts *count;
    void operator()(const ublas::vector<double> &y, ublas::matrix<double> &j, double t,
                    ublas::vector<double> &dfdt) const
    {
        const ll_ode *ode = &job->ode;
        count->jacobians++;
        ode->jacobian(ode->params, t, &y[0], &j(0, 0));
        std::fill(dfdt.begin(), dfdt.end(), 0.0);
        if (ode->autonomous)
            return;
        double h = 1e-7 * job->duration, before[LL_ODE_DIM_MAX];
        ll_ode_eval(ode, t, &y[0], before);
        ll_ode_eval(ode, t + h, &y[0], &dfdt[0]);
        count->evaluations += 2;
        for (int i = 0; i < ode->dim; i++)
            dfdt[i] = (dfdt[i] - before[i]) / h;
    }
};

/* The loop of odeint::integrate_adaptive, with a limit of steps. */
template <class Stepper, class System, class State>
bool to_the_end(Stepper &stepper, System system, State &y, const task *job, counts *count)
{
    double t = 0, dt = job->first_step;
    while (t < job->duration) {
        dt = std::min(dt, job->duration - t);
        for (int tries = 0; stepper.try_step(system, y, t, dt) == odeint::fail;)
            if (++tries == 500)
                return false;
        if (++count->steps > SOLVER_STEPS_MAX)
            return false;
    }
    for (double value : y)
        if (!(value - value == 0))
            return false;
    return true;
}

struct stepper_base { /* of one stepper: what is called through the table */
    const task *job;
    counts count;
    virtual bool run(double *y) = 0;
    virtual ~stepper_base() = default;
};

template <class Stepper, class State> struct explicit_stepper : stepper_base {
    Stepper stepper;
    State y;
    explicit explicit_stepper(const Stepper &made) : stepper(made) {}
    bool run(double *result) override
    {
        std::copy(job->start, job->start + job->ode.dim, y.begin());
        Stepper fresh = stepper; /* nothing is left of the run before */
        bool ok = to_the_end(fresh, system_of{&job->ode, &count}, y, job, &count);
        std::copy(y.begin(), y.end(), result);
        return ok;
    }
};

struct rosenbrock_stepper : stepper_base {
    bool run(double *result) override
    {
        ublas::vector<double> y(job->ode.dim);
        std::copy(job->start, job->start + job->ode.dim, y.begin());
        auto stepper = odeint::make_controlled(job->absolute, job->relative, odeint::rosenbrock4<double>());
        bool ok = to_the_end(stepper, std::make_pair(system_of{&job->ode, &count}, jacobian_of{job, &count}),
                             y, job, &count);
        std::copy(y.begin(), y.end(), result);
        return ok;
    }
};

template <template <class...> class Method, class State> stepper_base *controlled(const task *t)
{
    auto stepper = odeint::make_controlled(t->absolute, t->relative, Method<State>());
    return new (std::nothrow) explicit_stepper<decltype(stepper), State>(stepper);
}

template <class State> stepper_base *bulirsch_stoer(const task *t)
{
    odeint::bulirsch_stoer<State> stepper(t->absolute, t->relative);
    return new (std::nothrow) explicit_stepper<decltype(stepper), State>(stepper);
}

enum method { CASH_KARP54, DOPRI5, FEHLBERG78, BULIRSCH_STOER, ROSENBROCK4, METHODS };

template <std::size_t Dim> stepper_base *make(method by, const task *t)
{
    typedef std::array<double, Dim> state;
    switch (by) {
    case CASH_KARP54: return controlled<odeint::runge_kutta_cash_karp54, state>(t);
    case DOPRI5: return controlled<odeint::runge_kutta_dopri5, state>(t);
    case FEHLBERG78: return controlled<odeint::runge_kutta_fehlberg78, state>(t);
    case BULIRSCH_STOER: return bulirsch_stoer<state>(t);
    default: return new (std::nothrow) rosenbrock_stepper;
    }
}

/* NULL: none of the reference problems has so many components. */
stepper_base *make_for(method by, const task *t)
{
    switch (t->ode.dim) {
    case 2: return make<2>(by, t);
    case 3: return make<3>(by, t);
    case 4: return make<4>(by, t);
    case 8: return make<8>(by, t);
    case 12: return make<12>(by, t);
    case 28: return make<28>(by, t);
    case 32: return make<32>(by, t);
    default: return nullptr;
    }
}

struct row {
    method by;
    const char *name;
};
const row rows[METHODS] = {{CASH_KARP54, "cash_karp54"},
                           {DOPRI5, "dopri5"},
                           {FEHLBERG78, "fehlberg78"},
                           {BULIRSCH_STOER, "bulirsch_stoer"},
                           {ROSENBROCK4, "rosenbrock4"}};

void *open_stepper(const solver *by, const task *t)
{
    stepper_base *s = make_for(static_cast<const row *>(by->kind)->by, t);
    if (s != nullptr)
        s->job = t;
    return s;
}

bool run(void *state, double *y)
{
    stepper_base *s = static_cast<stepper_base *>(state);
    s->count = counts{};
    try {
        return s->run(y);
    } catch (const std::exception &) { /* a singular matrix, a step that underflows */
        return false;
    }
}

counts count_run(const void *state)
{
    return static_cast<const stepper_base *>(state)->count;
}

void close_stepper(void *state)
{
    delete static_cast<stepper_base *>(state);
}

} // namespace

extern "C" int odeint_solvers(solver *list, int count)
{
    for (const row &r : rows)
        list[count++] =
            solver{"Odeint", r.name, r.by == ROSENBROCK4, &r, open_stepper, run, count_run, close_stepper};
    return count;
}
