/* How does the reference get from one stop to the next? In steps that end where anything happens.
 *
 * * An event is a change of sign of an indicator: the step is shortened until it ends just before. Within a step
 * everything is smooth, but for kinks, which the error estimate sees. Where rates are next to nothing the estimate
 * sees nothing, so the step is bounded by the motion as well: in slip by shares of the speed and of the Stribeck
 * velocity, in a vibration by shares of its period.
 */
#include "course.h"

#include <math.h>
#include <string.h>

/* Of an effect that comes back with its states, which go on at their rates. */
static double periods_a_second(const struct Course *c, int n)
{
    const struct Effect *const effect = kernel_effect(n);
    const lanes *const own = (const lanes *)c->contact->value + kernel_effect_switch(n),
                       *const state = own + effect->count - 2 * effect->states, *const rate = state + effect->states;
    lanes later[STATES];
    for (int k = 0; k < effect->states; ++k)
        later[k][0] = state[k][0] + rate[k][0];
    return effect->periods(own, state, (const lanes *)later, 0);
}

static double motion_bound(const struct Course *c)
{
    const struct Motion *m = c->motion;
    const double length = m->times[c->segment + 1] - m->times[c->segment];
    double bound = INFINITY;
    for (int j = 0; j < m->inputs; ++j) {
        const double change = m->end[c->segment * m->inputs + j] - m->begin[c->segment * m->inputs + j];
        const double slope = fabs(change) / length, now = fabs(parameter(c, m->input_index[j]));
        const double least = m->input_index[j] == VAR_SLIP_VELOCITY ? c->slow : 0.02 * fabs(change);
        if (slope > 0)
            bound = fmin(bound, fmax(0.3 * now, least) / slope);
    }
    if ((int)parameter(c, VAR_KINEMATICS) != KINEMATICS_EXTERNAL)
        bound =
            fmin(bound, 1 / (parameter(c, VAR_VIBRATION_FREQUENCY) * (parameter(c, VAR_IN_CONTACT) > 0 ? 40 : 150)));
    for (int n = 0; n < kernel_effect_count(); ++n) {
        const int at = kernel_effect_switch(n);
        if (c->contact->value[at][0] != 0 && kernel_effect(n)->periods)
            bound = fmin(bound, 0.1 / fmax(periods_a_second(c, n), 1e-300));
        if (c->contact->value[at][0] != 0 && kernel_effect(n)->longest_step)
            bound = fmin(bound, kernel_effect(n)->longest_step((const lanes *)c->contact->value + at, 0));
    }
    return bound * c->care->span;
}

/* kernel_event looks so far ahead. */
static double ahead(const struct Course *c)
{
    return 1e-9 / parameter(c, VAR_VIBRATION_FREQUENCY) + 1e-12 * fabs(c->t);
}

/* A step so short that no integral feels it, in which a force may jump: its states count as long as rates that only
 * change fast, as of a bristle whose limit grows from nothing with the chip, can be told from rates that jump. */
static int short_enough(const struct Course *c, double h, const struct Step *step)
{
    return h <= ahead(c) && (step->of_states <= 1 || h <= 1e-3 * ahead(c));
}

/* The indicators at this state, and which of them has the wrong sign; -1: none. */
static int past_event(struct Course *c, double t, const double *y, lanes indicator[INDICATORS])
{
    course_put(c, t, y);
    kernel_indicators(c->contact, indicator);
    for (int k = 0; k < INDICATORS; ++k)
        if ((k == AT_CONTACT || c->contact->sign[AT_CONTACT][0] > 0) && indicator[k][0] * c->contact->sign[k][0] < 0)
            return k; /* out of contact only the contact counts, and the others show 1 */
    return -1;
}

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
    surface_leave(c, t - c->t, step);
    c->t = t;
    memcpy(c->y, step->node[STAGES_OF_RADAU - 1], sizeof c->y);
    for (int q = 0; q < c->radau.integrals; ++q)
        c->sums[q] += step->gain[q];
    c->outcome->steps += 1;
    if (!c->care->branches || !(parameter(c, VAR_IN_CONTACT) > 0))
        return;
    course_put(c, c->t, c->y);
    const int branches = branches_at(c->contact);
    c->outcome->branches = branches > c->outcome->branches ? branches : c->outcome->branches;
}

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
        if (solved && (step.error <= 1 || short_enough(c, h, &step)))
            break;
        h *= solved ? fmax(0.1, 0.8 * pow(step.error, -1. / (STAGES_OF_RADAU + 1))) : 0.25;
        if (h > ahead(c) || (solved && step.of_states > 1 && h > 1e-3 * ahead(c)))
            continue;
        /* rates jump here: where slip is given the kernel shows a point beyond an event on its new side, and no stage
         * lies before it */
        h = fmin(left, 8 * ahead(c));
        if (!radau_straight(&c->radau, c->t, h, c->y, c->f, c->g, &step))
            return NO_RATES;
        *blind = 1;
        break;
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
        c->outcome->events += acted;
        *blind = 0;
        return (acted ? notes_event(c, c->moved) : course_look(c)) ? DONE : NO_RATES;
    }
    struct Bracket b = {first > 0 ? node[first - 1] * h : 0, node[first] * h, earlier[which][0], indicator[which][0]};
    if (first > 0 && !radau_step(&c->radau, c->t, b.low, c->y, c->f, c->g, &shorter))
        b.low = 0;
    close_in(c, &b, which, &shorter);
    if (b.low > 0)
        take(c, c->t + b.low, &shorter);
    double sign[INDICATORS];
    for (int k = 0; k < INDICATORS; ++k)
        sign[k] = c->contact->sign[k][0];
    if (!notes_event(c, c->moved || which == AT_LAW))
        return NO_RATES;
    int turned = 0;
    for (int k = 0; k < INDICATORS; ++k)
        turned |= sign[k] != c->contact->sign[k][0];
    *blind = !turned && b.low <= 0; /* nothing has happened: across it */
    c->outcome->events += 1;
    c->next = fmax(1e-3 * h, 100 * ahead(c));
    return DONE;
}

/* Does it slide along an event, over and over in next to no time? */
static int chatters(struct Course *c)
{
    const double whole = c->motion->times[c->motion->segments] - c->motion->times[0];
    if (c->outcome->events < c->counted_events + 300)
        return 0;
    const int stands = c->t - c->counted_at < 1e-3 * whole;
    c->counted_events = c->outcome->events;
    c->counted_at = c->t;
    return stands;
}

enum Verdict walk_to(struct Course *c, double stop)
{
    int blind = 0;
    while (c->t < stop) {
        const enum Verdict verdict = advance(c, stop, &blind);
        if (verdict != DONE)
            return verdict;
        if (c->outcome->steps > c->care->most_steps)
            return TOO_MANY_STEPS;
        if (c->outcome->events > c->care->most_events || chatters(c))
            return TOO_MANY_EVENTS;
    }
    return DONE;
}

/* Before the start the sensors have heard the first force all along, as long as they are late. */
enum Verdict walk_sensors(struct Course *c)
{
    const double end = c->motion->times[0];
    struct Step step;
    c->frozen = 1;
    c->t = end - c->motion->late;
    c->next = 1e-3 * c->motion->late;
    if (!course_look(c))
        return NO_RATES;
    notes_late(c);
    while (c->t < end) {
        const double stop = fmin(end, notes_next_late(c));
        const double h = fmin(c->next, stop - c->t);
        const int solved = radau_step(&c->radau, c->t, h, c->y, c->f, c->g, &step);
        c->next = solved ? h * fmin(5, 0.8 * pow(fmax(step.error, 1e-10), -1. / (STAGES_OF_RADAU + 1))) : 0.25 * h;
        if (!solved || step.error > 1) {
            if (c->t + c->next == c->t)
                return NO_STEP;
            continue;
        }
        memset(step.gain, 0, sizeof step.gain);
        c->t = h < stop - c->t ? c->t + h : stop;
        memcpy(c->y, step.node[STAGES_OF_RADAU - 1], sizeof c->y);
        if (!course_look(c))
            return NO_RATES;
        notes_late(c);
    }
    c->frozen = 0;
    c->next = 1e-3 * (c->motion->times[1] - end);
    return course_look(c) ? DONE : NO_RATES;
}
