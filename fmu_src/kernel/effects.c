/* How do the effects that are on take part in a point and in a step? In the order of the registry, whatever the order
 * of switching. */
#include "stages.h"

#include <math.h>

INLINED void act(const struct Configuration *w, enum Stage stage, struct Point *x)
{
    if (!(w->stages >> stage & 1))
        return;
    for (int n = 0; n < w->on_count; ++n)
        if (w->on[n]->stage == stage && w->on[n]->act)
            w->on[n]->act(w->on_p[n], x->state + w->on_state[n], x);
}

static void move_one(const struct Configuration *w, int n, const lanes h, const struct Point *start,
                     struct Point *middle, struct Point *end)
{
    const int at = w->on_state[n];
    w->on[n]->move(w->on_p[n], h, start, middle, end, start->state + at, middle->state + at, end->state + at);
}

/* Where the slip is solved for, all of the motion waits for the forces. */
enum Driver driver_of(const struct Configuration *w, const struct Effect *effect)
{
    return effect->driver == DRIVEN_BY_APPROACH && w->current_angle ? DRIVEN_BY_FORCE : effect->driver;
}

void move_states(const struct Configuration *w, enum Driver driver, const lanes h, const struct Point *start,
                 struct Point *middle, struct Point *end)
{
    for (int n = 0; n < w->on_count && w->drivers >> driver & 1; ++n)
        if (driver_of(w, w->on[n]) == driver)
            move_one(w, n, h, start, middle, end);
}

void open_measured(struct Point *x)
{
    EACH_LANE {
        x->measured[0][i] = x->F[i];
        x->measured[1][i] = x->F_p[i];
        x->measured[2][i] = x->F_f[i];
    }
}

void measure(const struct Contact *contact, const struct Configuration *w, struct Point *x)
{
    const struct Past past = {.contact = contact, .w = w};
    open_measured(x);
    x->past = &past;
    act(w, STAGE_MEASUREMENT, x);
    x->past = NULL;
}

/* The states of one driver, straight on at the rates of x, by `ahead`. */
void lead_states(const struct Configuration *w, enum Driver driver, const lanes ahead, struct Point *x)
{
    for (int n = 0; n < w->on_count; ++n) {
        const struct Effect *effect = w->on[n];
        lanes rate[EFFECT_STATES];
        if (driver_of(w, effect) != driver)
            continue;
        effect->rate(w->on_p[n], x, x->state + w->on_state[n], rate);
        for (int k = 0; k < effect->states; ++k)
            EACH_LANE
                x->state[w->on_state[n] + k][i] += ahead[i] * rate[k][i];
    }
}

/* Each effect of the chain hears what the one before it shows, over the whole step. */
void measure_step(const struct Contact *contact, const struct Configuration *w, const lanes h,
                  const struct Point *start, struct Point *middle, struct Point *end)
{
    open_measured(middle);
    open_measured(end);
    if (!measures(w))
        return;
    struct Point heard;
    const struct Past past = {contact, w, start, middle, end};
    middle->past = end->past = &past;
    if (w->sensors) {
        heard = *start; /* start->measured has passed the whole chain already */
        heard.past = &past;
        open_measured(&heard);
    }
    for (int n = 0; n < w->on_count; ++n) {
        const struct Effect *effect = w->on[n];
        if (effect->stage != STAGE_MEASUREMENT)
            continue;
        if (effect->driver == DRIVEN_BY_SENSOR)
            move_one(w, n, h, &heard, middle, end);
        if (w->sensors)
            effect->act(w->on_p[n], heard.state + w->on_state[n], &heard);
        effect->act(w->on_p[n], middle->state + w->on_state[n], middle);
        effect->act(w->on_p[n], end->state + w->on_state[n], end);
    }
    middle->past = end->past = NULL;
}

void load_states(const struct Contact *contact, const struct Configuration *w, struct Point *x)
{
    for (int n = 0; n < w->on_count; ++n)
        for (int k = 0; k < w->on[n]->states; ++k)
            EACH_LANE
                x->state[w->on_state[n] + k][i] = contact->value[w->on_value[n] + k][i];
}

void store_state_of(struct Contact *contact, const struct Configuration *w, const struct Point *x, int lane)
{
    for (int n = 0; n < w->on_count; ++n)
        for (int k = 0; k < w->on[n]->states; ++k)
            contact->value[w->on_value[n] + k][lane] = x->state[w->on_state[n] + k][lane];
}

void store_states(struct Contact *contact, const struct Configuration *w, const struct Point *x)
{
    for (int i = 0; i < LANES; ++i)
        store_state_of(contact, w, x, i);
}

/* The drive of a sensor's state is what the chain shows before it, so the chain is run once more. */
void show_rates(struct Contact *contact, const struct Configuration *w, const struct Point *x)
{
    const struct Past past = {.contact = contact, .w = w};
    struct Point heard = *x;
    heard.past = &past;
    open_measured(&heard);
    for (int n = 0; n < w->on_count; ++n) {
        const struct Effect *effect = w->on[n];
        if (effect->rate)
            effect->rate(w->on_p[n], &heard, heard.state + w->on_state[n],
                         contact->value + w->on_value[n] + effect->states);
        if (effect->stage == STAGE_MEASUREMENT)
            effect->act(w->on_p[n], heard.state + w->on_state[n], &heard);
    }
}

void forget_states(struct Contact *contact, const struct Configuration *w, int lane)
{
    for (int n = 0; n < w->on_count; ++n)
        for (int k = 0; w->on[n]->forgets && k < w->on[n]->states; ++k)
            contact->value[w->on_value[n] + k][lane] = 0;
}

void resolving_step(const struct Configuration *w, lanes longest)
{
    for (int n = 0; n < w->on_count; ++n)
        for (int i = 0; i < LANES && w->on[n]->longest_step; ++i)
            longest[i] = smaller(longest[i], w->on[n]->longest_step(w->on_p[n], i));
}

double look_back(const struct Configuration *w, int lane)
{
    double furthest = 0;
    for (int n = 0; n < w->on_count; ++n)
        if (w->on[n]->looks_back)
            furthest = larger(furthest, w->on[n]->looks_back(w->on_p[n], lane));
    return furthest;
}

double periods_between(const struct Configuration *w, int lane, const struct Point *from, const struct Point *to)
{
    double most = 0;
    for (int n = 0; n < w->on_count; ++n)
        if (w->on[n]->periods)
            most = larger(
                most, w->on[n]->periods(w->on_p[n], from->state + w->on_state[n], to->state + w->on_state[n], lane));
    return most;
}

int sensors_that_remember(const struct Configuration *w, int lane)
{
    int count = 0;
    for (int n = 0; n < w->on_count; ++n)
        count += w->on[n]->remembers && w->on[n]->remembers(w->on_p[n], lane);
    return count;
}

double meeting_time(const struct Configuration *w, int lane)
{
    for (int n = 0; n < w->on_count; ++n)
        if (w->on[n]->meets_again)
            return w->on[n]->meets_again(w->on_p[n], lane);
    return 0;
}

/* Not at a jump at t + `jump`, but just before it; and from there just across. */
static double until(double jump, double close, double h)
{
    return smaller(h, jump > 2 * close ? jump - close : jump + close);
}

/* What is recalled jumps where the forces did, and what is met where the surface does: the step ends just before, and a
 * next one, too short to matter, leads across. */
double until_late_jump(const struct Contact *contact, const struct Configuration *w, int lane, double t, double h,
                       const struct Point *start)
{
    for (int n = 0; n < w->on_count; ++n) {
        if (!w->on[n]->looks_back)
            continue;
        const double late = w->on[n]->looks_back(w->on_p[n], lane), close = 1e-13 * (fabs(t) + late);
        const double jump =
            late > 0 ? recall_jump(contact, w, lane, start, t - late, t - late + h) - (t - late) : INFINITY;
        h = until(jump, close, h);
    }
    const double turn = meeting_time(w, lane), close = 1e-13 * (fabs(t) + turn);
    return turn > 0 ? until(surface_jump(contact, w, lane, t - turn, t - turn + h) - (t - turn), close, h) : h;
}

/* How much what is recalled bends over the step; but for a step that leads across a jump. */
double late_bend(const struct Contact *contact, const struct Configuration *w, int lane, const struct Point *a,
                 const struct Point *m, const struct Point *b)
{
    const struct Past past = {contact, w, a, m, b};
    const struct Point *const at[3] = {a, m, b};
    double worst = 0;
    for (int n = 0; n < w->on_count; ++n) {
        if (!w->on[n]->looks_back)
            continue;
        const double late = w->on[n]->looks_back(w->on_p[n], lane);
        double u[3][CHANNELS];
        if (!(b->t[lane] - a->t[lane] > 1e-12 * (fabs(b->t[lane]) + late)))
            continue;
        for (int j = 0; j < 3; ++j)
            recall(&past, at[j], lane, at[j]->t[lane] - late, u[j]);
        for (int k = 0; k < CHANNELS; ++k) {
            const double force = larger(larger(fabs(u[0][k]), fabs(u[2][k])), larger(b->F_C[lane], b->F_S[lane]));
            if (force > 0) /* a law whose level is the load's may have none at both ends, and then nothing bends */
                worst = larger(worst, fabs(u[0][k] - 2 * u[1][k] + u[2][k]) / (3 * force));
        }
    }
    return worst;
}

/* Is `name` one of the comma-separated names of the list? */
static int names(const char *list, const char *name)
{
    while (list && *list) {
        while (*list == ' ' || *list == ',')
            ++list;
        int n = 0;
        while (name[n] && list[n] == name[n])
            ++n;
        if (!name[n] && (list[n] == ',' || !list[n]))
            return 1;
        while (*list && *list != ',')
            ++list;
    }
    return 0;
}

int rivals_among(uint64_t on, int pair[2])
{
    for (int n = 0; n < EFFECT_COUNT; ++n)
        for (int m = 0; m < EFFECT_COUNT && on >> n & 1; ++m)
            if (on >> m & 1 && names(kernel_effect(n)->rivals, kernel_effect(m)->variables[0].name)) {
                pair[0] = n;
                pair[1] = m;
                return 1;
            }
    return 0;
}
