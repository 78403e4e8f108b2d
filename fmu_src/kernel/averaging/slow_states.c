/* What do the states of effects do while cycles pass that nobody runs?
 *
 * What moves them is linear in them: an effect's own `move` over any time is affine, state -> M state + c. States that
 * motion or forces drive: one cycle says where they strive to, and M over the step leads there. States of sensors:
 * their chain hears the mean forces. States that a separation resets, and the bristles, are not slow: the cycle itself
 * carries them.
 */
#include "../stages.h"

#include <math.h>
#include <string.h>

enum { SENSOR_STEPS = 16 }; /* in which filters and delays are taken through a communication step */
#define MOST_SENSOR_STEPS 4096 /* where a sensor asks for short ones: beyond, what it adds has no mean but rounding */

static const struct Point still; /* nothing drives */

static int is_sensor(const struct Effect *effect) { return effect->stage == STAGE_MEASUREMENT; }
static int is_slow(const struct Effect *effect) { return effect->states && !effect->forgets && !is_sensor(effect); }

uint64_t sensors_on(const struct Contact *contact)
{
    uint64_t sensors = 0;
    for (int n = 0; n < EFFECT_COUNT; ++n)
        sensors |= (uint64_t)is_sensor(kernel_effect(n)) << n;
    return sensors & contact->effects_on;
}

struct Affine {
    lanes M[EFFECT_STATES][EFFECT_STATES], c[EFFECT_STATES];
};

/* The n-th effect's move over h with a drive that does not change. */
static void affine_move(const struct Configuration *w, int n, double h, const struct Point *drive, struct Affine *move)
{
    const int count = w->on[n]->states;
    lanes length, from[EFFECT_STATES] = {{0}}, half[EFFECT_STATES], whole[EFFECT_STATES];
    EACH_LANE
        length[i] = h;
    w->on[n]->move(w->on_p[n], length, drive, drive, drive, (const lanes *)from, half, move->c);
    for (int k = 0; k < count; ++k) {
        EACH_LANE
            from[k][i] = 1;
        w->on[n]->move(w->on_p[n], length, drive, drive, drive, (const lanes *)from, half, whole);
        EACH_LANE
            from[k][i] = 0;
        for (int r = 0; r < count; ++r)
            EACH_LANE
                move->M[r][k][i] = whole[r][i] - move->c[r][i];
    }
}

void own_slopes(const struct Configuration *w, int n, double h, lanes M[EFFECT_STATES][EFFECT_STATES])
{
    struct Affine move;
    affine_move(w, n, h, &still, &move);
    memcpy(M, move.M, sizeof move.M);
}

/* The states that a move leaves as they are: (1 - M) x = c. */
static void rest_of(const struct Affine *move, int count, int lane, double x[UNKNOWNS])
{
    double A[UNKNOWNS][UNKNOWNS];
    for (int r = 0; r < count; ++r) {
        x[r] = move->c[r][lane];
        for (int k = 0; k < count; ++k)
            A[r][k] = (r == k) - move->M[r][k][lane];
    }
    solve_linear(count, A, x);
}

/* The states of the n-th effect that a drive which does not change leaves as they are: its own rate is linear in them
 * and 0 there. Its move over any time says less: one that vibrates without damping comes back after whole periods from
 * wherever it was. States that have no rate are what a move over h makes of them. */
static void rest_under(const struct Configuration *w, int n, double h, const struct Point *drive, lanes *state)
{
    const int count = w->on[n]->states;
    lanes length, none[EFFECT_STATES] = {{0}}, half[EFFECT_STATES], left[EFFECT_STATES], by[EFFECT_STATES],
                  slope[EFFECT_STATES][EFFECT_STATES];
    EACH_LANE
        length[i] = h;
    w->on[n]->move(w->on_p[n], length, drive, drive, drive, (const lanes *)none, half, state);
    w->on[n]->rate(w->on_p[n], drive, (const lanes *)state, left);
    for (int k = 0; k < count; ++k) {
        EACH_LANE
            none[k][i] = 1;
        w->on[n]->rate(w->on_p[n], &still, (const lanes *)none, by);
        EACH_LANE
            none[k][i] = 0;
        for (int r = 0; r < count; ++r)
            EACH_LANE
                slope[r][k][i] = by[r][i];
    }
    for (int i = 0; i < LANES; ++i) {
        double A[UNKNOWNS][UNKNOWNS], x[UNKNOWNS];
        for (int r = 0; r < count; ++r) {
            x[r] = -left[r][i];
            for (int k = 0; k < count; ++k)
                A[r][k] = slope[r][k][i];
        }
        solve_linear(count, A, x);
        for (int k = 0; k < count; ++k)
            state[k][i] += x[k];
    }
}

void slow_states_after(const struct Contact *contact, const struct Configuration *w, double h, const lanes *from,
                       lanes *to)
{
    for (int n = 0; n < w->on_count; ++n) {
        const int at = w->on_state[n], count = w->on[n]->states;
        struct Affine move;
        if (!is_slow(w->on[n]))
            continue;
        affine_move(w, n, h, &still, &move);
        for (int r = at; r < at + count; ++r)
            EACH_LANE {
                to[r][i] = contact->steady_state[r][i];
                for (int k = at; k < at + count; ++k)
                    to[r][i] += move.M[r - at][k - at][i] * (from[k][i] - contact->steady_state[k][i]);
            }
    }
}

void find_steady_states(struct Contact *contact, const struct Configuration *w, double period, const lanes *from,
                        const lanes *after)
{
    for (int n = 0; n < w->on_count; ++n) {
        const int at = w->on_state[n], count = w->on[n]->states;
        struct Affine move;
        if (!is_slow(w->on[n]))
            continue;
        affine_move(w, n, period, &still, &move);
        for (int i = 0; i < LANES; ++i) {
            double x[UNKNOWNS];
            for (int r = 0; r < count; ++r) {
                move.c[r][i] = after[at + r][i];
                for (int k = 0; k < count; ++k)
                    move.c[r][i] -= move.M[r][k][i] * from[at + k][i];
            }
            rest_of(&move, count, i, x);
            for (int r = 0; r < count; ++r)
                contact->steady_state[at + r][i] = x[r];
        }
    }
}

int get_slow_states(const struct Contact *contact, const struct Configuration *w, lanes *state)
{
    int count = 0;
    for (int n = 0; n < w->on_count; ++n)
        for (int k = 0; k < w->on[n]->states && is_slow(w->on[n]); ++k, ++count)
            EACH_LANE
                state[w->on_state[n] + k][i] = contact->value[w->on_value[n] + k][i];
    return count;
}

void set_slow_states(struct Contact *contact, const struct Configuration *w, const lanes *state)
{
    for (int n = 0; n < w->on_count; ++n)
        for (int k = 0; k < w->on[n]->states && is_slow(w->on[n]); ++k)
            EACH_LANE
                contact->value[w->on_value[n] + k][i] = state[w->on_state[n] + k][i];
}

/* ---- sensors ---- */

/* The chain of sensors alone. */
static struct Configuration wire_sensors(struct Contact *contact)
{
    const uint64_t all = contact->effects_on;
    contact->effects_on = sensors_on(contact);
    const struct Configuration w = wire(contact);
    contact->effects_on = all;
    return w;
}

/* A point whose forces are the means. */
static void mean_point(const struct Contact *contact, const struct Configuration *w, const lanes *force,
                       struct Point *x)
{
    *x = still;
    load_states(contact, w, x);
    EACH_LANE {
        x->t[i] = contact->value[VAR_TIME][i];
        x->F[i] = x->measured[0][i] = force[0][i];
        x->F_p[i] = x->measured[1][i] = force[1][i];
        x->F_f[i] = x->measured[2][i] = force[2][i];
        x->cutting[i] = x->direction[i] = 1;
    }
}

void settle_sensors(struct Contact *contact, double period, const lanes *force)
{
    const struct Configuration w = wire_sensors(contact);
    const struct Past past = {.contact = contact, .w = &w};
    struct Point x;
    mean_point(contact, &w, force, &x);
    x.past = &past;
    for (int n = 0; n < w.on_count; ++n) {
        lanes *const state = x.state + w.on_state[n];
        if (w.on[n]->states)
            rest_under(&w, n, period, &x, state);
        w.on[n]->act(w.on_p[n], (const lanes *)state, &x);
    }
    store_states(contact, &w, &x);
}

#define ANY_TIME 1.0 /* [s], after which what has settled is as it was */
#define SETTLING_TIME 1e6     /* [s], after which all has settled that does at the speed of the start */

enum Status settle_states(struct Contact *contact)
{
    const struct Configuration w = wire(contact);
    static const lanes now;
    lanes length, half[EFFECT_STATES], whole[EFFECT_STATES];
    struct Point x;
    EACH_LANE
        length[i] = SETTLING_TIME;
    for (int n = 0; n < w.on_count; ++n) {
        lanes *const state = x.state + w.on_state[n];
        if (!w.on[n]->settles)
            continue;
        point_at(contact, &w, now, &x); /* under the slip that those of earlier stages let through in the end */
        w.on[n]->move(w.on_p[n], length, &x, &x, &x, (const lanes *)state, half, whole);
        for (int k = 0; k < w.on[n]->states; ++k)
            EACH_LANE
                state[k][i] = whole[k][i];
        store_states(contact, &w, &x);
    }
    for (int i = 0; i < LANES; ++i)
        forget_past(contact, i); /* it knows of states that had not settled */
    enum Status status = kernel_event(contact); /* forces feel them */
    if (status == STATUS_OK && sensors_on(contact)) {
        lanes force[CHANNELS];
        EACH_LANE {
            force[0][i] = contact->value[VAR_FRICTION_FORCE][i];
            force[1][i] = contact->value[VAR_PRINCIPAL_FORCE][i];
            force[2][i] = contact->value[VAR_FEED_FORCE][i];
        }
        settle_sensors(contact, ANY_TIME, (const lanes *)force);
        status = kernel_event(contact);
    }
    return status;
}

/* Without sensors the forces are what is measured. */
static int measured_plainly(const struct Contact *contact, const lanes *force, lanes *measured)
{
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE
            measured[k][i] = force[k][i];
    return !sensors_on(contact);
}

void measured_now(struct Contact *contact, const lanes *force, lanes *measured)
{
    if (measured_plainly(contact, force, measured))
        return;
    const struct Configuration w = wire_sensors(contact);
    struct Point x;
    mean_point(contact, &w, force, &x);
    measure(contact, &w, &x);
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE
            measured[k][i] = x.measured[k][i];
}

enum Status measure_means(struct Contact *contact, double step, const lanes *force, lanes *measured)
{
    if (measured_plainly(contact, force, measured))
        return STATUS_OK;
    const struct Configuration w = wire_sensors(contact);
    struct Point a, m, b;
    lanes h, longest;
    EACH_LANE
        longest[i] = INFINITY;
    resolving_step(&w, longest);
    double parts = w.drivers || w.looks_back ? SENSOR_STEPS : 1;
    EACH_LANE
        parts = larger(parts, ceil(step / longest[i]));
    const int count = (int)smaller(parts, MOST_SENSOR_STEPS);
    EACH_LANE
        h[i] = step / count;
    mean_point(contact, &w, force, &a);
    measure(contact, &w, &a);
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE
            measured[k][i] = 0;
    for (int n = 0; n < count; ++n) {
        m = b = a;
        EACH_LANE {
            m.t[i] = a.t[i] + 0.5 * h[i];
            b.t[i] = a.t[i] + h[i];
        }
        measure_step(contact, &w, h, &a, &m, &b);
        for (int k = 0; k < CHANNELS; ++k)
            EACH_LANE
                measured[k][i] += (a.measured[k][i] + 4 * m.measured[k][i] + b.measured[k][i]) / (6 * count);
        for (int i = 0; i < LANES && w.looks_back; ++i) {
            remember(contact, &w, i, h[i], &a, &m, &b);
            if (!past_reaches(contact, &w, i, b.t[i]))
                return STATUS_HISTORY_SHORT;
        }
        a = b;
    }
    store_states(contact, &w, &b);
    return STATUS_OK;
}
