/* What the paper prints in its Figures 1 to 4: a program, the lines that it prints, and a table of steps. */
#include <stdio.h>
#include <string.h>

#include "ode/core/paper.h"
#include "sim/motion/motion.h"

typedef void write_text(void *context, const char *text, size_t length);

/* Where the text goes. */
typedef struct output {
    write_text *write;
    void *context;
} output;

static void put(const output *to, const char *text)
{
    to->write(to->context, text, strlen(text));
}

static bool is_listing(const ll_motion_config *c, int i)
{
    return strcmp(ll_motion_problem(c)->name, "free_fall") == 0 && c->methods[i].shown &&
           strcmp(ll_motion_method_of(c, i)->name, "semi_implicit_euler") == 0;
}

/* A number as C writes a double. */
typedef struct literal {
    char text[40];
} literal;

static literal literal_of(double value, int digits)
{
    literal l;
    snprintf(l.text, sizeof l.text - 2, "%.*g", digits, value);
    if (!strpbrk(l.text, ".en"))
        strcat(l.text, ".0");
    return l;
}

/* The program of Figure 1 with the scenario's numbers. */
static void put_program(const output *to, const ll_motion_config *c, int i, const ll_ode_listing *l)
{
    char text[1024];
    snprintf(
        text, sizeof text,
        "#include <stdio.h>\n"
        "\n"
        "float t = 0.0;\n"
        "float dt = %s; // timestep\n"
        "float velocity = %sf; // initial velocity\n"
        "float displacement = %sf; // initial displacement\n"
        "float acceleration = %sf;\n"
        "\n"
        "int main(int argc, char** argv)\n"
        "{\n"
        "    // compute for a journey time of %g seconds\n"
        "    while (t <= %s)\n"
        "    {\n"
        "        printf(\"t = %%f, velocity = %%f, displacement = %%f\\n\", t, velocity, displacement);\n"
        "        velocity = velocity + acceleration * dt;\n"
        "        displacement = displacement + velocity * dt;\n"
        "        t += dt;\n"
        "    }\n"
        "}\n",
        literal_of(c->methods[i].dt_s, 15).text, literal_of((double)l->velocity, 9).text,
        literal_of((double)l->displacement, 9).text, literal_of((double)l->acceleration, 9).text,
        c->head.duration_s, literal_of(c->head.duration_s, 15).text);
    put(to, text);
}

static void put_lines(const output *to, ll_ode_listing l, double duration)
{
    char line[160];
    while (ll_ode_listing_next(&l, duration, line, sizeof line))
        put(to, line);
}

/* ---- the table of Figure 4 ---- */

/* Its last column, which has lost digits in print. */
static const struct {
    double dt;
    const char *displacement;
} printed[] = {{0.5, "52.00"}, {0.3, "49.00"}, {0.1, "46.00"}, {0.033, "45.58"}};

static const char *printed_for(const ll_motion_config *c, int i, const ll_ode_listing *l)
{
    if (c->head.duration_s != 3 || l->acceleration != 10 || l->velocity != 0 || l->displacement != 0)
        return "";
    for (size_t k = 0; k < sizeof printed / sizeof printed[0]; k++)
        if (c->methods[i].dt_s == printed[k].dt)
            return printed[k].displacement;
    return "";
}

static double distance(double a, double b)
{
    return a < b ? b - a : a - b;
}

/* The line whose time is nearest to the duration: the last of the program's, or the one that would follow. */
static ll_ode_listing nearest(ll_ode_listing l, double duration)
{
    char line[160];
    ll_ode_listing best = l;
    do {
        if (distance((double)l.t, duration) <= distance((double)best.t, duration))
            best = l;
    } while (ll_ode_listing_next(&l, duration, line, sizeof line));
    return best;
}

static void put_row(const output *to, const ll_motion_config *c, int i, const ll_ode_listing *l)
{
    char line[160];
    ll_ode_listing at = nearest(*l, c->head.duration_s);
    snprintf(line, sizeof line, "%17.3f  %13.3f  %14.3f  %16.6f  %12s\n", (double)at.dt, (double)at.t,
             (double)at.velocity, (double)at.displacement, printed_for(c, i, l));
    put(to, line);
}

/* ---- all ---- */

static ll_ode_listing listing_of(ll_motion_config *c, int i)
{
    double start[LL_ODE_DIM_MAX], slope[LL_ODE_DIM_MAX];
    ll_ode ode = ll_motion_system(c);
    ll_motion_problem(c)->start(c->params, start);
    ll_ode_eval(&ode, 0, start, slope);
    return (ll_ode_listing){.dt = (float)c->methods[i].dt_s,
                            .acceleration = (float)slope[1],
                            .displacement = (float)start[0],
                            .velocity = (float)start[1]};
}

/* One step of the method: the program, for Figure 1, and its lines. Several steps: their table. */
ll_status ll_motion_text(const void *config, void (*write)(void *context, const char *text, size_t length),
                         void *context)
{
    ll_motion_config c = *(const ll_motion_config *)config;
    const output to = {write, context};
    int listings = 0, first = 0;
    for (int i = c.method_count - 1; i >= 0; i--)
        if (is_listing(&c, i)) {
            listings++;
            first = i;
        }
    if (listings == 0)
        return ll_error(LL_BAD_INPUT,
                        "the paper prints lines of free_fall with semi_implicit_euler; this is %s with %s",
                        ll_motion_problem(&c)->name, ll_motion_method_of(&c, 0)->name);
    if (listings > 1)
        put(&to, "Timestep (dt) (s)  Timestamp (s)  Velocity (m/s)  Displacement (m)  In the paper\n");
    for (int i = first; i < c.method_count; i++) {
        if (!is_listing(&c, i))
            continue;
        ll_ode_listing listing = listing_of(&c, i);
        if (listings > 1) {
            put_row(&to, &c, i, &listing);
            continue;
        }
        if (strcmp(c.head.paper, "Figure 1") == 0) {
            put_program(&to, &c, i, &listing);
            put(&to, "\n");
        }
        put_lines(&to, listing, c.head.duration_s);
    }
    return ll_ok();
}
