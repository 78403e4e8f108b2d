/* What is the right answer of a contact to a motion? Takes from the kernel what a host of model exchange takes: rates, event indicators and
 * what happens at an event. Steps, their length and the search for events are this file's and radau.c's own.
 *
 * A step ends where anything happens: at the corners of the motion, at the ends of averaging windows and, by bisection, just before an
 * indicator changes its sign. Within a step everything is smooth, but for kinks, which the error estimate sees. Where rates are next to
 * nothing the estimate sees nothing, so the step is bounded by the motion as well: in slip by shares of the speed and of the Stribeck
 * velocity, in a vibration by shares of its period.
 */
#include "reference.h"
#include "radau.h"

#include <math.h>
#include <string.h>

struct Course {
    struct Contact *contact;
    const struct Motion *motion;
    const struct Care *care;
    struct Found *found;
    struct Radau radau;
    int segment;
    int state[MOST_STATES], rate[MOST_STATES];
    int integral[MOST_INTEGRALS], integrand[MOST_INTEGRALS];
    double t, y[MOST_STATES], f[MOST_STATES], g[MOST_INTEGRALS], sums[MOST_INTEGRALS];
    double next; /* length of the next step by the last one's error */
    int64_t steps;
};

static double parameter(const struct Course *c, int index) { return c->contact->value[index][0]; }

/* ---- the contact at one time ---- */

static void set_inputs(struct Course *c, double t)
{
    const struct Motion *m = c->motion;
    const double t_0 = m->times[c->segment], length = m->times[c->segment + 1] - t_0, share = (t - t_0) / length;
    for (int j = 0; j < m->inputs; ++j) {
        const double u_0 = m->begin[c->segment * m->inputs + j], u_1 = m->end[c->segment * m->inputs + j];
        c->contact->value[m->input_index[j]][0] = share >= 1 ? u_1 : u_0 + share * (u_1 - u_0);
        c->contact->slope[m->input_index[j] - INPUT_FIRST][0] = (u_1 - u_0) / length;
    }
    c->contact->value[TIME][0] = t;
}

static void put(struct Course *c, double t, const double *y)
{
    set_inputs(c, t);
    for (int i = 0; i < c->radau.states; ++i)
        c->contact->value[c->state[i]][0] = y[i];
}

static int rates(void *what, double t, const double *y, double *f, double *g)
{
    struct Course *c = what;
    put(c, t, y);
    c->found->evaluations += 1;
    if (kernel_evaluate(c->contact) != KERNEL_OK)
        return 1;
    for (int i = 0; i < c->radau.states; ++i)
        f[i] = c->contact->value[c->rate[i]][0];
    for (int q = 0; q < c->radau.integrals; ++q)
        g[q] = c->contact->value[c->integrand[q]][0];
    return 0;
}

/* The course's own present state and rates, and how large they have been. */
static int look(struct Course *c)
{
    for (int q = 0; q < c->radau.integrals; ++q)
        c->contact->value[c->integral[q]][0] = c->sums[q];
    if (rates(c, c->t, c->y, c->f, c->g))
        return 0;
    for (int i = 0; i < c->radau.states; ++i)
        c->radau.scale[i] = fmax(c->radau.scale[i], fabs(c->y[i]));
    for (int q = 0; q < c->radau.integrals; ++q)
        c->radau.integral_scale[q] = fmax(c->radau.integral_scale[q], fabs(c->g[q]));
    return 1;
}

static void take_from_contact(struct Course *c)
{
    for (int i = 0; i < c->radau.states; ++i)
        c->y[i] = c->contact->value[c->state[i]][0];
}

/* The indicators at this state, and which of them has the wrong sign; -1: none. */
static int past_event(struct Course *c, double t, const double *y, lanes indicator[INDICATORS])
{
    put(c, t, y);
    kernel_indicators(c->contact, indicator);
    for (int k = 0; k < INDICATORS; ++k)
        if (indicator[k][0] * c->contact->sign[k][0] < 0)
            return k;
    return -1;
}

/* ---- how far a step may go ---- */

static double motion_bound(const struct Course *c)
{
    const struct Motion *m = c->motion;
    const double length = m->times[c->segment + 1] - m->times[c->segment];
    double bound = INFINITY;
    for (int j = 0; j < m->inputs; ++j) {
        const double change = m->end[c->segment * m->inputs + j] - m->begin[c->segment * m->inputs + j];
        const double slope = fabs(change) / length, now = fabs(parameter(c, m->input_index[j]));
        const double least = m->input_index[j] == SLIP_VELOCITY ? 0.1 * parameter(c, V_S) : 0.02 * fabs(change);
        if (slope > 0)
            bound = fmin(bound, fmax(0.3 * now, least) / slope);
    }
    if ((int)parameter(c, KINEMATICS) != KINEMATICS_EXTERNAL)
        bound = fmin(bound, 1 / (parameter(c, VIBRATION_FREQUENCY) * (parameter(c, IN_CONTACT) > 0 ? 40 : 150)));
    for (int n = 0; n < kernel_effect_count(); ++n) {
        const int at = kernel_effect_switch(n);
        if (c->contact->value[at][0] != 0 && kernel_effect(n)->longest_step)
            bound = fmin(bound, kernel_effect(n)->longest_step((const lanes *)c->contact->value + at, 0));
    }
    return bound * c->care->span;
}

/* ---- events ---- */

static void show(const struct Course *c, double *row)
{
    for (int j = 0; j < c->motion->outputs; ++j)
        row[j] = parameter(c, c->motion->output_index[j]);
}

static double patience(const struct Course *c)
{
    if ((int)parameter(c, KINEMATICS) != KINEMATICS_EXTERNAL)
        return 0.159 / parameter(c, VIBRATION_FREQUENCY);
    return fmax(parameter(c, F_C), parameter(c, F_S)) / parameter(c, SIGMA0) / fmax(fabs(parameter(c, SLIP_VELOCITY_USED)), 1e-12);
}

/* At the present time: sides anew, and a note of what has jumped. */
static int act(struct Course *c, int noted)
{
    struct Found *found = c->found;
    const int room = noted && found->jump_count < found->jump_room, outputs = c->motion->outputs;
    double *before = found->sides + (int64_t)found->jump_count * 2 * outputs, *after = before + outputs;
    if (!look(c))
        return 0;
    if (room)
        show(c, before);
    if (kernel_event(c->contact) != KERNEL_OK)
        return 0;
    take_from_contact(c);
    if (!look(c))
        return 0;
    if (!room)
        return 1;
    show(c, after);
    int jumped = 0;
    for (int j = 0; j < outputs; ++j)
        jumped |= fabs(after[j] - before[j]) > 1e-9 * (fabs(after[j]) + fabs(before[j]));
    if (jumped) {
        found->jumps[found->jump_count].time = c->t;
        found->jumps[found->jump_count].first = found->jump_count * 2;
        found->jumps[found->jump_count].patience = patience(c);
        found->jump_count += 1;
    }
    return 1;
}

/* kernel_event looks so far ahead. */
static double ahead(const struct Course *c) { return 1e-9 / parameter(c, VIBRATION_FREQUENCY) + 1e-12 * fabs(c->t); }

/* Two steps, one before and one past an event, and the indicator that says so of each. */
struct Bracket {
    double low, high, at_low, at_high;
};

/* The longest step before the event, by regula falsi with halved ends (Illinois) and by halves where that is slow. */
static void close_in(struct Course *c, struct Bracket *b, int which, struct Step *step)
{
    const double close = 1e-3 * ahead(c);
    struct Step trial;
    lanes indicator[INDICATORS];
    for (int n = 0; b->high - b->low > close; ++n) {
        const double share = n % 4 < 3 && b->at_low != b->at_high ? b->at_low / (b->at_low - b->at_high) : 0.5;
        const double h = fmin(fmax(b->low + share * (b->high - b->low), b->low + 0.5 * close), b->high - 0.5 * close);
        if (!(h > b->low && h < b->high))
            break;
        const int solved = radau_step(&c->radau, c->t, h, c->y, c->f, c->g, &trial);
        const int past = solved ? past_event(c, c->t + h, trial.node[STAGES_OF_RADAU - 1], indicator) : which;
        if (past < 0) {
            b->low = h;
            b->at_low = indicator[which][0];
            b->at_high *= 0.5;
            *step = trial;
            continue;
        }
        b->high = h;
        b->at_high = solved ? indicator[which = past][0] : b->at_high;
        b->at_low *= 0.5;
    }
}

static void take(struct Course *c, double t, const struct Step *step)
{
    c->t = t;
    memcpy(c->y, step->node[STAGES_OF_RADAU - 1], sizeof c->y);
    for (int q = 0; q < c->radau.integrals; ++q)
        c->sums[q] += step->gain[q];
    c->steps += 1;
}

/* ---- from stop to stop ---- */

/* One step towards `stop`, up to an event. */
static enum Verdict advance(struct Course *c, double stop, int *blind)
{
    const double left = stop - c->t, *const node = c->radau.c;
    struct Step step, shorter;
    double h = fmin(fmin(c->next, motion_bound(c)), left);
    if (*blind)
        h = fmin(left, 8 * ahead(c));
    else if (left < 2 * h)
        h = left <= h ? left : 0.5 * left;
    for (;;) {
        const int solved = radau_step(&c->radau, c->t, h, c->y, c->f, c->g, &step);
        if (solved && (step.error <= 1 || h <= ahead(c)))
            break;
        h *= solved ? fmax(0.1, 0.8 * pow(step.error, -1. / (STAGES_OF_RADAU + 1))) : 0.25;
        if (c->t + h == c->t)
            return NO_STEP;
    }
    const double longer = fmin(5, 0.8 * pow(fmax(step.error, 1e-10), -1. / (STAGES_OF_RADAU + 1)));
    lanes indicator[INDICATORS], earlier[INDICATORS] = {{0}};
    int first = 0, which = -1;
    while (!*blind && first < STAGES_OF_RADAU) {
        which = past_event(c, c->t + node[first] * h, step.node[first], indicator);
        if (which >= 0)
            break;
        memcpy(earlier, indicator, sizeof earlier);
        ++first;
    }
    if (which < 0) {
        c->next = h * longer;
        take(c, h == left ? stop : c->t + h, &step);
        const int acted = *blind;
        *blind = 0;
        return (acted ? act(c, 1) : look(c)) ? DONE : NO_RATES;
    }
    struct Bracket b = {first > 0 ? node[first - 1] * h : 0, node[first] * h, earlier[which][0], indicator[which][0]};
    if (first > 0 && !radau_step(&c->radau, c->t, b.low, c->y, c->f, c->g, &shorter))
        return NO_STEP;
    close_in(c, &b, which, &shorter);
    if (b.low > 0)
        take(c, c->t + b.low, &shorter);
    double sign[INDICATORS];
    for (int k = 0; k < INDICATORS; ++k)
        sign[k] = c->contact->sign[k][0];
    if (!act(c, 1))
        return NO_RATES;
    int turned = 0;
    for (int k = 0; k < INDICATORS; ++k)
        turned |= sign[k] != c->contact->sign[k][0];
    *blind = !turned && b.low <= 0; /* nothing has happened: across it */
    c->found->events += 1;
    c->next = fmax(1e-3 * h, 100 * ahead(c));
    return DONE;
}

static enum Verdict run_to(struct Course *c, double stop)
{
    int blind = 0;
    while (c->t < stop) {
        const enum Verdict verdict = advance(c, stop, &blind);
        if (verdict != DONE)
            return verdict;
        if (c->steps > c->care->most_steps)
            return TOO_MANY_STEPS;
        if (c->found->events > c->care->most_events)
            return TOO_MANY_EVENTS;
    }
    return DONE;
}

/* ---- the whole motion ---- */

/* Which states move others, and which only sum up. */
static void sort_states(struct Course *c)
{
    struct Radau *r = &c->radau;
    const double reach = fmax(parameter(c, F_C), parameter(c, F_S)) / parameter(c, SIGMA0);
    int on[STATES];
    for (int place = 0; place < kernel_state_count(); ++place)
        on[place] = place < BASE_STATES;
    for (int n = 0, place = BASE_STATES; n < kernel_effect_count(); ++n)
        for (int k = 0; k < kernel_effect(n)->states; ++k)
            on[place++] = c->contact->value[kernel_effect_switch(n)][0] != 0;
    const int contact_effects = c->contact->effects_on != 0; /* only they ask how far it has slid */
    r->states = r->integrals = 0;
    for (int place = 0; place < kernel_state_count(); ++place) {
        const int index = kernel_state(place);
        int rate = 0;
        while (on[place] && (kernel_derivative_of(rate) != index))
            ++rate;
        if (!on[place])
            continue;
        if (place >= BASE_STATES || index == BRISTLE_DEFLECTION || (index == SLIDING_DISTANCE && contact_effects)) {
            const double nominal = kernel_variable(index)->nominal;
            c->state[r->states] = index;
            c->rate[r->states] = rate;
            r->scale[r->states++] = index == BRISTLE_DEFLECTION ? reach : 1e-3 * (nominal > 0 ? nominal : 1);
        } else {
            c->integral[r->integrals] = index;
            c->integrand[r->integrals] = rate;
            r->integral_scale[r->integrals++] = rate == CONTACT_RATE ? 1 : fmax(parameter(c, F_C), parameter(c, F_S));
        }
    }
}

/* The next corner of the motion or end of an averaging window. */
static double next_stop(const struct Course *c)
{
    return fmin(c->motion->times[c->segment + 1], kernel_next_event(c->contact));
}

static enum Verdict run_segment(struct Course *c, double *row)
{
    const double end = c->motion->times[c->segment + 1];
    if (!act(c, 1)) /* inputs may have jumped */
        return NO_RATES;
    c->next = fmin(c->next, 0.1 * (end - c->t));
    while (c->t < end) {
        const double stop = fmax(next_stop(c), c->t);
        const enum Verdict verdict = stop > c->t ? run_to(c, stop) : DONE;
        if (verdict != DONE)
            return verdict;
        if (stop < end && !act(c, 0))
            return NO_RATES;
    }
    show(c, row);
    return DONE;
}

enum Verdict reference_run(struct Contact *contact, const struct Motion *motion, const struct Care *care, struct Found *found)
{
    struct Course c = {.contact = contact, .motion = motion, .care = care, .found = found};
    enum Verdict verdict = DONE;
    found->steps = found->events = found->evaluations = 0;
    found->jump_count = 0;
    c.t = motion->times[0];
    c.next = motion->times[1] - c.t;
    c.radau.tolerance = care->tolerance;
    c.radau.rates = rates;
    c.radau.what = &c;
    radau_begin(&c.radau);
    set_inputs(&c, c.t);
    if (kernel_start(contact, c.t) != KERNEL_OK)
        return NO_RATES;
    sort_states(&c);
    take_from_contact(&c);
    for (int q = 0; q < c.radau.integrals; ++q)
        c.sums[q] = contact->value[c.integral[q]][0];
    if (!look(&c))
        return NO_RATES;
    show(&c, found->rows);
    for (c.segment = 0; c.segment < motion->segments && verdict == DONE; ++c.segment)
        verdict = run_segment(&c, found->rows + (int64_t)(c.segment + 1) * motion->outputs);
    found->steps = c.steps;
    found->failed_at = c.t;
    return verdict;
}

/* ---- the kernel's own stepping ---- */

enum Status stepped_run(struct Contact *contact, const struct Motion *m, double *rows)
{
    for (int n = -1; n < m->segments; ++n) {
        enum Status status;
        double taken;
        const int now = n < 0 ? 0 : n;
        const double length = m->times[now + 1] - m->times[now];
        for (int j = 0; j < m->inputs; ++j) {
            const double u_0 = m->begin[now * m->inputs + j], u_1 = m->end[now * m->inputs + j];
            contact->value[m->input_index[j]][0] = u_0;
            contact->slope[m->input_index[j] - INPUT_FIRST][0] = n < 0 ? 0 : (u_1 - u_0) / length;
        }
        status = n < 0 ? kernel_start(contact, m->times[0]) : kernel_advance(contact, length, 0, &taken);
        if (status == KERNEL_OK)
            status = kernel_evaluate(contact);
        if (status != KERNEL_OK)
            return status;
        for (int j = 0; j < m->outputs; ++j)
            rows[(int64_t)(n + 1) * m->outputs + j] = contact->value[m->output_index[j]][0];
    }
    return KERNEL_OK;
}
