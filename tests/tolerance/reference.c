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
#include <stdlib.h>
#include <string.h>

/* What the tool has left behind, for a revolution that meets it again: heights at the start and the nodes of each step. */
struct Left {
    double start, length, height[1 + STAGES_OF_RADAU];
};

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
    /* a delay of the sensors: the next row whose late outputs are due; frozen: nothing but sensors moves */
    int late_row, frozen, of_sensor[MOST_STATES];
    /* a revolution of the work: its time, 0: none meets itself again; turns completed */
    double turn;
    int turns;
    struct Left *left;
    int64_t left_count, left_room;
    /* means over windows of this length, 0: none; windows that have ended; the integrals when the present one began */
    double window, opened[MOST_INTEGRALS], mean[MOST_INTEGRALS];
    int64_t windows;
    int moved; /* forces, or a solution for the slip, move the tool: the times of all events hang on states */
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

static double named(const struct Course *c, const char *name)
{
    for (int n = 0; n < kernel_variable_count(); ++n)
        if (!strcmp(kernel_variable(n)->name, name))
            return parameter(c, n);
    return NAN;
}

/* On the polynomial through the heights of one step. */
static double within(const struct Course *c, const struct Left *left, double t)
{
    double place[1 + STAGES_OF_RADAU] = {0}, sum = 0;
    const double at = (t - left->start) / left->length;
    memcpy(place + 1, c->radau.c, sizeof c->radau.c);
    for (int k = 0; k <= STAGES_OF_RADAU; ++k) {
        double share = left->height[k];
        for (int m = 0; m <= STAGES_OF_RADAU; ++m)
            share *= m == k ? 1 : (at - place[m]) / (place[k] - place[m]);
        sum += share;
    }
    return sum;
}

/* The surface that was left one turn before t. The first turn meets the nominal one. */
static double met(const struct Course *c, double t)
{
    const double before = fmax(t - c->turn, c->motion->times[0] + (c->turns - 1) * c->turn);
    int64_t low = 0, high = c->left_count - 1;
    if (c->turns == 0)
        return 0;
    while (low < high) {
        const int64_t half = (low + high + 1) / 2;
        if (c->left[half].start <= before)
            low = half;
        else
            high = half - 1;
    }
    return within(c, &c->left[low], before);
}

/* The kernel looks its own surface up between two heights: both are the right one. */
static void meet(struct Course *c, double t)
{
    if (!(c->turn > 0))
        return;
    c->contact->surface_count[0] = c->turns > 0 ? 2 : 0;
    for (int n = 0; n < 2; ++n) {
        c->contact->surface_time[n][0] = t - c->turn + (n ? 1 : -1) * 1e-6 * c->turn;
        c->contact->surface_height[n][0] = met(c, t);
    }
}

static void put(struct Course *c, double t, const double *y)
{
    set_inputs(c, c->frozen ? c->motion->times[0] : t);
    meet(c, t);
    for (int i = 0; i < c->radau.states; ++i)
        c->contact->value[c->state[i]][0] = y[i];
}

/* The height that the tool leaves at the contact's present time, over the nominal surface. */
static double leaves(const struct Course *c)
{
    const double t = parameter(c, TIME);
    double tool = 0;
    if ((int)parameter(c, KINEMATICS) == KINEMATICS_COMBINED)
        tool += parameter(c, TOOL_DISPLACEMENT_Y);
    if (named(c, "holder_compliance") != 0)
        tool += named(c, "holder_compliance.displacement_y");
    if (named(c, "run_out") != 0)
        tool -= named(c, "run_out.amplitude") *
                sin(6.283185307179586 * named(c, "run_out.spindle_frequency") * t + named(c, "run_out.phase"));
    return fmin(tool, named(c, "regenerative.share") * met(c, t) + parameter(c, FEED));
}

static void leave(struct Course *c, double h, const struct Step *step)
{
    if (!(c->turn > 0))
        return;
    if (c->left_count == c->left_room) {
        c->left_room = 2 * c->left_room + 64;
        c->left = realloc(c->left, (size_t)c->left_room * sizeof *c->left);
    }
    struct Left *const left = &c->left[c->left_count++];
    left->start = c->t;
    left->length = h;
    for (int k = 0; k <= STAGES_OF_RADAU; ++k) {
        put(c, k ? c->t + c->radau.c[k - 1] * h : c->t, k ? step->node[k - 1] : c->y);
        left->height[k] = leaves(c);
    }
}

static int rates(void *what, double t, const double *y, double *f, double *g)
{
    struct Course *c = what;
    put(c, t, y);
    c->found->evaluations += 1;
    if (kernel_evaluate(c->contact) != KERNEL_OK)
        return 1;
    for (int i = 0; i < c->radau.states; ++i)
        f[i] = c->frozen && !c->of_sensor[i] ? 0 : c->contact->value[c->rate[i]][0];
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
        if ((k == AT_CONTACT || c->contact->sign[AT_CONTACT][0] > 0) && indicator[k][0] * c->contact->sign[k][0] < 0)
            return k; /* out of contact only the contact counts, and the others show 1 */
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

/* Each mean, and the integrand it is the mean of. */
static const int means[][2] = {
    {MEAN_FRICTION_FORCE, FRICTION_FORCE}, {MEAN_PRINCIPAL_FORCE, PRINCIPAL_FORCE}, {MEAN_FEED_FORCE, FEED_FORCE},
    {MEAN_NORMAL_FORCE, NORMAL_FORCE}, {MEAN_MEASURED_FRICTION_FORCE, MEASURED_FRICTION_FORCE},
    {MEAN_MEASURED_PRINCIPAL_FORCE, MEASURED_PRINCIPAL_FORCE}, {MEAN_MEASURED_FEED_FORCE, MEASURED_FEED_FORCE},
};

static double shown(const struct Course *c, int index)
{
    for (size_t n = 0; n < sizeof means / sizeof means[0] && c->window > 0; ++n)
        for (int q = 0; q < c->radau.integrals && means[n][0] == index; ++q)
            if (c->integrand[q] == means[n][1])
                return c->mean[q];
    return parameter(c, index);
}

static void show(const struct Course *c, double *row)
{
    for (int j = 0; j < c->motion->outputs; ++j)
        row[j] = shown(c, c->motion->output_index[j]);
}

static double patience(const struct Course *c)
{
    if ((int)parameter(c, KINEMATICS) != KINEMATICS_EXTERNAL)
        return 0.159 / parameter(c, VIBRATION_FREQUENCY);
    return fmax(parameter(c, F_C), parameter(c, F_S)) / parameter(c, SIGMA0) / fmax(fabs(parameter(c, SLIP_VELOCITY_USED)), 1e-12);
}

static void note_jump(struct Course *c, double in_time)
{
    struct Jump *const jump = &c->found->jumps[c->found->jump_count];
    jump->time = c->t;
    jump->first = c->found->jump_count++ * 2;
    jump->patience = in_time;
}

static double *sides(const struct Course *c, int after)
{
    return c->found->sides + ((int64_t)c->found->jump_count * 2 + after) * c->motion->outputs;
}

/* A host that ramps slip or thickness to 0 by its slope lands a rounding error beside it, on either side. */
static void note_both_sides(struct Course *c)
{
    const struct Motion *m = c->motion;
    for (int j = 0; j < m->inputs && m->rounds; ++j) {
        const double u_0 = m->begin[c->segment * m->inputs + j], u_1 = m->end[c->segment * m->inputs + j];
        const int index = m->input_index[j], matters = index == SLIP_VELOCITY || index == UNCUT_THICKNESS;
        if (!matters || u_1 != 0 || u_0 == 0 || c->found->jump_count == c->found->jump_room)
            continue;
        for (int after = 0; after < 2; ++after) {
            c->contact->value[index][0] = (after ? 1e-15 : -1e-15) * u_0;
            kernel_evaluate(c->contact);
            show(c, sides(c, after));
        }
        c->contact->value[index][0] = u_1;
        note_jump(c, 1e-12 * m->times[m->segments]);
    }
}

/* At the present time: sides anew, and a note of what has jumped where the time of it hangs on a state. */
static int act(struct Course *c, int hangs_on_state)
{
    const int noted = hangs_on_state && c->found->jump_count < c->found->jump_room;
    if (!look(c))
        return 0;
    if (noted)
        show(c, sides(c, 0));
    if (kernel_event(c->contact) != KERNEL_OK)
        return 0;
    take_from_contact(c);
    if (!look(c))
        return 0;
    if (!noted)
        return 1;
    show(c, sides(c, 1));
    for (int j = 0; j < c->motion->outputs; ++j)
        if (fabs(sides(c, 1)[j] - sides(c, 0)[j]) > 1e-9 * (fabs(sides(c, 1)[j]) + fabs(sides(c, 0)[j]))) {
            note_jump(c, patience(c));
            break;
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
    leave(c, t - c->t, step);
    c->t = t;
    memcpy(c->y, step->node[STAGES_OF_RADAU - 1], sizeof c->y);
    for (int q = 0; q < c->radau.integrals; ++q)
        c->sums[q] += step->gain[q];
    c->steps += 1;
}

/* ---- from stop to stop ---- */

/* A step too short for anything but its start to matter. */
static void straight(const struct Course *c, double h, struct Step *step)
{
    step->error = 0;
    for (int q = 0; q < c->radau.integrals; ++q)
        step->gain[q] = h * c->g[q];
    for (int k = 0; k < STAGES_OF_RADAU; ++k)
        for (int i = 0; i < c->radau.states; ++i)
            step->node[k][i] = c->y[i] + c->radau.c[k] * h * c->f[i];
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
        if (solved && (step.error <= 1 || h <= ahead(c)))
            break;
        h *= solved ? fmax(0.1, 0.8 * pow(step.error, -1. / (STAGES_OF_RADAU + 1))) : 0.25;
        if (h > ahead(c))
            continue;
        /* rates jump here: where slip is given the kernel shows a point beyond an event on its new side, and no stage lies before it */
        h = fmin(left, 8 * ahead(c));
        straight(c, h, &step);
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
        c->found->events += acted;
        *blind = 0;
        return (acted ? act(c, c->moved) : look(c)) ? DONE : NO_RATES;
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
    if (!act(c, c->moved || which == AT_LAW))
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
    int on[STATES], sensor[STATES] = {0};
    for (int place = 0; place < kernel_state_count(); ++place)
        on[place] = place < BASE_STATES;
    for (int n = 0, place = BASE_STATES; n < kernel_effect_count(); ++n)
        for (int k = 0; k < kernel_effect(n)->states; ++k)
            sensor[place] = kernel_effect(n)->driver == DRIVEN_BY_SENSOR, on[place++] = c->contact->value[kernel_effect_switch(n)][0] != 0;
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
            c->of_sensor[r->states] = sensor[place];
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

/* What is shown at the present time; `late` outputs, or the others. */
static void note(struct Course *c, int row, int late)
{
    const struct Motion *m = c->motion;
    for (int j = 0; j < m->outputs; ++j)
        if (!(m->late > 0) || late == m->lags[j])
            c->found->rows[(int64_t)row * m->outputs + j] = shown(c, m->output_index[j]);
}

static double next_late(const struct Course *c)
{
    const int due = c->motion->late > 0 && c->late_row <= c->motion->segments;
    return due ? c->motion->times[c->late_row] - c->motion->late : INFINITY;
}

static void note_late(struct Course *c)
{
    while (next_late(c) <= c->t)
        note(c, c->late_row++, 1);
}

static double next_turn(const struct Course *c)
{
    return c->turn > 0 ? c->motion->times[0] + (c->turns + 1) * c->turn : INFINITY;
}

/* Before the start the sensors have heard the first force all along, as long as they are late. */
static enum Verdict wait(struct Course *c)
{
    const double end = c->motion->times[0];
    struct Step step;
    c->frozen = 1;
    c->t = end - c->motion->late;
    c->next = 1e-3 * c->motion->late;
    if (!look(c))
        return NO_RATES;
    note_late(c);
    while (c->t < end) {
        const double stop = fmin(end, next_late(c));
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
        if (!look(c))
            return NO_RATES;
        note_late(c);
    }
    c->frozen = 0;
    c->next = 1e-3 * (c->motion->times[1] - end);
    return look(c) ? DONE : NO_RATES;
}

static double window_end(const struct Course *c)
{
    return c->window > 0 ? c->motion->times[0] + (double)(c->windows + 1) * c->window : INFINITY;
}

static void close_window(struct Course *c)
{
    for (int q = 0; q < c->radau.integrals; ++q) {
        c->mean[q] = (c->sums[q] - c->opened[q]) / c->window;
        c->opened[q] = c->sums[q];
    }
    c->windows += 1;
}

/* The next corner of the motion, end of an averaging window, late output or turn of the work. */
static double next_stop(const struct Course *c)
{
    return fmax(fmin(fmin(c->motion->times[c->segment + 1], window_end(c)), fmin(next_late(c), next_turn(c))), c->t);
}

static int inputs_jump(const struct Course *c)
{
    const struct Motion *m = c->motion;
    for (int j = 0; j < m->inputs && c->segment > 0; ++j)
        if (m->end[(c->segment - 1) * m->inputs + j] != m->begin[c->segment * m->inputs + j])
            return 1;
    return 0;
}

static enum Verdict run_segment(struct Course *c)
{
    const double end = c->motion->times[c->segment + 1];
    if (!(inputs_jump(c) ? act(c, 0) : look(c)))
        return NO_RATES;
    c->next = fmin(c->next, 0.1 * (end - c->t));
    while (c->t < end) {
        const double stop = next_stop(c);
        const enum Verdict verdict = stop > c->t ? run_to(c, stop) : DONE;
        if (verdict != DONE)
            return verdict;
        note_late(c);
        if (c->t >= window_end(c))
            close_window(c);
        if (c->t < next_turn(c))
            continue;
        c->turns += 1;
        if (!act(c, 0))
            return NO_RATES;
    }
    note(c, c->segment + 1, 0);
    note_both_sides(c);
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
    c.turn = named(&c, "regenerative") != 0 ? named(&c, "regenerative.revolution_time") : 0;
    c.radau.tolerance = care->tolerance;
    c.radau.rates = rates;
    c.radau.what = &c;
    radau_begin(&c.radau);
    set_inputs(&c, c.t);
    for (int j = 0; j < motion->inputs; ++j)
        contact->slope[motion->input_index[j] - INPUT_FIRST][0] = 0;
    if (kernel_start(contact, c.t) != KERNEL_OK)
        return NO_RATES;
    sort_states(&c);
    take_from_contact(&c);
    for (int q = 0; q < c.radau.integrals; ++q)
        c.sums[q] = c.opened[q] = contact->value[c.integral[q]][0];
    c.moved = (int)parameter(&c, CHIP_FLOW_ANGLE) == CURRENT_ANGLE || c.turn > 0;
    for (int n = 0; n < kernel_effect_count(); ++n)
        c.moved |= contact->value[kernel_effect_switch(n)][0] != 0 && kernel_effect(n)->driver == DRIVEN_BY_FORCE;
    c.window = parameter(&c, AVERAGING_WINDOW);
    if (!(c.window > 0) && (int)parameter(&c, KINEMATICS) != KINEMATICS_EXTERNAL)
        c.window = 1 / parameter(&c, VIBRATION_FREQUENCY);
    if (!look(&c))
        return NO_RATES;
    note(&c, 0, 0);
    if (motion->late > 0)
        verdict = wait(&c);
    for (c.segment = 0; c.segment < motion->segments && verdict == DONE; c.segment += verdict == DONE)
        verdict = run_segment(&c);
    found->steps = c.steps;
    found->failed_at = c.t;
    free(c.left);
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
