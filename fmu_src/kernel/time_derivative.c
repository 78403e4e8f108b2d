/* How fast does what the contact shows change? Time derivatives along the inputs' slopes, for a master that
 * extrapolates.
 *
 * On the straight line through the present point on which inputs go by their slopes and states by their rates, the
 * derivative is the true one: so differences of second order along it, on the sides of the events that are held. Their
 * step balances rounding and truncation, as in kernel_derivatives. Where outputs are means over the last step: from
 * them to the means of another such step.
 */
#include "shared.h"
#include "stages.h"

#include <math.h>

#define DIFFERENCE_SHARE                                                                                               \
    6e-6 /* of the time in which anything changes, that a difference takes: the third root of rounding */
#define LONGEST_SCALE 1e-3 /* [s] where nothing moves by itself */

/* A state that moves, and its rate. */
struct Moving {
    int state;
    lanes from, rate;
};
struct Line {
    const struct Contact *contact; /* the present point */
    int count;
    struct Moving moving[BASE_STATES + EFFECT_STATES];
};

static void add_state(struct Line *line, int state, const lanes rate)
{
    struct Moving *const m = &line->moving[line->count++];
    m->state = state;
    EACH_LANE {
        m->from[i] = line->contact->value[state][i];
        m->rate[i] = rate[i];
    }
}

/* From the rates that are shown. */
static void find_line(struct Line *line, const struct Contact *shown, const struct Configuration *w)
{
    line->count = 0;
    for (int index = 0; index < BASE_COUNT; ++index)
        if (base_variables[index].derivative_of)
            add_state(line, base_variables[index].derivative_of, shown->value[index]);
    for (int n = 0; n < w->on_count; ++n)
        for (int k = 0, first = w->on_value[n], states = w->on[n]->states; k < states; ++k)
            add_state(line, first + k, shown->value[first + states + k]);
}

/* Integrals move, but nothing hangs on them; on the distance effects may. */
static int is_idle(const struct Configuration *w, int state)
{
    return state < BASE_COUNT && state != VAR_BRISTLE_DEFLECTION && !(state == VAR_SLIDING_DISTANCE && w->on_count);
}

static double nominal_of(const struct Variable *variable) { return variable->nominal > 0 ? variable->nominal : 1; }

/* In which time anything changes by itself or by its nominal value; of inputs, which laws may see far below theirs, by
 * a hundredth of it. */
static double time_scale(const struct Line *line, const struct Configuration *w)
{
    double scale = smaller(LONGEST_SCALE, w->longest[0]);
    for (int k = INPUT_FIRST; k < INPUT_END; ++k) {
        const double slope = fabs(line->contact->slope[k - INPUT_FIRST][0]),
                     value = larger(fabs(line->contact->value[k][0]), 1e-2 * nominal_of(&base_variables[k]));
        scale = slope > 0 ? smaller(scale, value / slope) : scale;
    }
    for (int n = 0; n < line->count; ++n) {
        const struct Moving *const m = &line->moving[n];
        const double value = larger(fabs(m->from[0]), nominal_of(kernel_variable(m->state))), rate = fabs(m->rate[0]);
        scale = rate > 0 && !is_idle(w, m->state) ? smaller(scale, value / rate) : scale;
    }
    return scale;
}

/* Show the contact `ahead` seconds on along the line. Returns whether an event lies between, in lane 0. */
static int show_at(const struct Line *line, const struct Configuration *w, double ahead, struct Contact *room)
{
    struct Point x;
    lanes tau, indicator[INDICATORS];
    int across = 0;
    EACH_LANE
        tau[i] = ahead;
    for (int n = 0; n < line->count; ++n)
        EACH_LANE {
            room->value[line->moving[n].state][i] = line->moving[n].from[i] + ahead * line->moving[n].rate[i];
            follow_recent(room, line->moving[n].state, i);
        }
    point_at(room, w, tau, &x);
    show_outputs(room, w, &x, 1);
    indicators(w, &x, indicator);
    for (int k = 0; k < INDICATORS; ++k)
        across |= watched(room, k, 0) && indicator[k][0] * room->sign[k][0] < 0;
    return across;
}

/* Would an input be outside its bounds `ahead` seconds on? */
static int leaves_bounds(const struct Contact *contact, double ahead)
{
    int outside = 0;
    for (int k = INPUT_FIRST; k < INPUT_END; ++k) {
        const double there = input_at(contact, k, 0, ahead);
        outside |=
            contact->slope[k - INPUT_FIRST][0] != 0 && (there < base_variables[k].min || there > base_variables[k].max);
    }
    return outside;
}

static enum Status of_a_point(const struct Contact *contact, struct Contact *room, int count, const int *index,
                              double *derivatives)
{
    enum Sides { BOTH, AHEAD, BEHIND }; /* not at the point itself, where a slip of just 0 has a force of its own */
    static const double place[3][3] = {{-1, 1, 0}, {1, 2, 3}, {-1, -2, -3}},
                        weight[3][3] = {{0, 0.5, 0}, {0, 4, -1.5}, {0, -4, 1.5}}; /* of the change from the first */
    static const lanes here;
    static const int none[LANES] = {0};
    const struct Configuration w = wire(room);
    struct Line line = {.contact = contact};
    struct Point x;
    const enum Status felt = w.delays ? feel_slip_now(room, &w) : STATUS_OK;
    if (felt != STATUS_OK)
        return felt;
    if (w.kinematics == KINEMATICS_EXTERNAL) /* as show_here: inputs may jump without an event */
        settle_sides(room, &w, here, here, none, &x);
    else
        point_at(room, &w, here, &x);
    show_outputs(room, &w, &x, 1);
    find_line(&line, room, &w);
    const double h = DIFFERENCE_SHARE * time_scale(&line, &w);
    enum Sides sides = leaves_bounds(contact, -h) ? AHEAD : leaves_bounds(contact, h) ? BEHIND : BOTH;
    double first[DERIVATIVES_AT_ONCE];
    for (int n = 0; n < 3; ++n) {
        if (n == 2 && sides == BOTH)
            break;
        if (show_at(&line, &w, place[sides][n] * h, room) && sides == BOTH) { /* anew, on the other side */
            sides = place[sides][n] < 0 ? AHEAD : BEHIND;
            n = -1;
            continue;
        }
        for (int j = 0; j < count; ++j)
            if (n == 0) {
                first[j] = room->value[index[j]][0];
                derivatives[j] = 0;
            } else
                derivatives[j] += weight[sides][n] * (room->value[index[j]][0] - first[j]) / h;
    }
    for (int j = 0; j < count; ++j)
        for (int n = 0; n < line.count; ++n)
            if (line.moving[n].state == recent_of(index[j]))
                derivatives[j] = line.moving[n].rate[0];
    return STATUS_OK;
}

/* The means of the last step stand at its middle. Before the first there are those of a cycle at the start. */
static enum Status of_means(const struct Contact *contact, struct Contact *room, int count, const int *index,
                            double *derivatives)
{
    const double now = contact->value[VAR_TIME][0], half = now - contact->earlier_time[0][0];
    const double step = half > 0 ? 2 * half : 1 / contact->value[VAR_VIBRATION_FREQUENCY][0];
    const enum Status status = average_step(room, step);
    for (int j = 0; j < count && status == STATUS_OK; ++j) {
        derivatives[j] = (room->value[index[j]][0] - contact->value[index[j]][0]) / (half + 0.5 * step);
        for (int n = 0; n < BASE_COUNT; ++n)
            if (base_variables[n].derivative_of == recent_of(index[j]) && index[j] != VAR_BRISTLE_DEFLECTION)
                derivatives[j] = contact->value[n][0];
    }
    return status;
}

enum Status kernel_time_derivatives(const struct Contact *contact, struct Contact *room, int count, const int *index,
                                    double *derivatives)
{
    if (!ordered_temperatures(contact))
        return STATUS_TEMPERATURES;
    *room = *contact;
    return kernel_averages(contact) ? of_means(contact, room, count, index, derivatives)
                                    : of_a_point(contact, room, count, index, derivatives);
}
