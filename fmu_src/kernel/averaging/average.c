/* What does a machine see of a contact that vibrates far faster than the machine moves? One cycle, which stands for all
 * of a step's, or a few where effects go by the time itself.
 *
 * Every cycle that is run begins where the tool stands highest: there it is out of the material if it ever is, and has
 * forgotten the cycle before. It runs with the inputs of the step's middle, held, in the middle of the step to within
 * half a cycle. How the others go on: cycles.c; states of effects: slow_states.c. Averaging: Kryloff and Bogoliuboff
 * 1947; whole steps from one cycle: Petzold 1981.
 */
#include "cycles.h"

#include <math.h>
#include <string.h>

/* What shows as the mean rate of each integral. */
static const int rate_of[INTEGRALS] = {VAR_SLIDING_SPEED,
                                       VAR_DISSIPATED_POWER,
                                       VAR_SHEAR_POWER,
                                       VAR_FRICTION_FORCE,
                                       VAR_PRINCIPAL_FORCE,
                                       VAR_FEED_FORCE,
                                       VAR_NORMAL_FORCE,
                                       VAR_CONTACT_RATE,
                                       VAR_MEASURED_FRICTION_FORCE,
                                       VAR_MEASURED_PRINCIPAL_FORCE,
                                       VAR_MEASURED_FEED_FORCE};

/* Start of that cycle, of those that begin with the tool at its highest, whose middle is nearest to t. */
static void cycle_at(const struct Contact *contact, const struct Configuration *w, const lanes t, lanes begin)
{
    static const lanes here;
    struct Point x; /* effects may turn the phase */
    load_states(contact, w, &x);
    path_at(contact, w, here, &x);
    EACH_LANE {
        const double f = contact->value[VAR_VIBRATION_FREQUENCY][i], top = -x.phase_y[i] / (2 * PI);
        begin[i] = (floor(f * t[i] - top) + top) / f;
    }
}

/* Outputs as they are at the instant that the contact stands at. */
static void show_instant(struct Contact *contact, const struct Configuration *w)
{
    static const lanes here;
    struct Point x;
    point_at(contact, w, here, &x);
    show_outputs(contact, w, &x, 1);
}

static void show_means(struct Contact *contact, lanes mean[INTEGRALS])
{
    for (int n = 0; n < INTEGRALS; ++n)
        EACH_LANE {
            contact->value[rate_of[n]][i] = mean[n][i];
            if (n >= FIRST_MEAN && !(contact->value[VAR_AVERAGING_WINDOW][i] >= NO_WINDOW))
                contact->value[mean_of[n - FIRST_MEAN]][i] = mean[n][i];
        }
    EACH_LANE {
        contact->value[VAR_TOOL_FORCE_X][i] = -mean[FIRST_FORCE + 1][i];
        contact->value[VAR_TOOL_FORCE_Y][i] = mean[FIRST_FORCE + 2][i];
        contact->value[VAR_IN_CONTACT][i] = mean[DUTY][i] > 0;
    }
}

/* Run cycles around t with the inputs as they stand; sensors are left out. Leaves the contact at the end of the last
 * one. */
static enum Status look(struct Contact *contact, const lanes t, double cycles, struct Configuration *w,
                        struct CycleSums *seen, lanes mean[INTEGRALS])
{
    const uint64_t all = contact->effects_on;
    lanes closed, begin;
    EACH_LANE {
        closed[i] = contact->window[i];
        contact->window[i] = 1e300; /* no window ends within these cycles */
    }
    contact->effects_on = all & ~sensors_on(contact);
    *w = wire(contact);
    cycle_at(contact, w, t, begin);
    const enum Status status = run_cycles(contact, w, begin, cycles, seen);
    if (status == STATUS_OK)
        go_on(contact, seen, cycles, mean);
    contact->effects_on = all;
    EACH_LANE
        contact->window[i] = closed[i];
    return status;
}

/* ---- effects that go by the time itself ---- */

/* A rise and fall that a step passes on more than a part of has a mean over the step which its middle does not show:
 * one cycle is run at each of so many places in it. Of a sine over its whole turns their mean is exact, over a part of
 * one off by a hundredth of what it goes up and down. */
#define PER_PLACE 2.0 /* of the steps that resolve it: ten places in a turn of run-out */
enum { MOST_PLACES = 40 };
#define OF_SPREAD 0.01
#define OF_SPREAD_IN_FEW 0.5 /* where there are too few of them for all turns */

struct Places {
    lanes count, missing; /* 1: the middle alone; whether more are wanted */
    lanes spread[CHANNELS]; /* of the mean forces at them [N] */
};

static void choose_places(const struct Configuration *w, double step, double period, struct Places *places)
{
    for (int i = 0; i < LANES; ++i) {
        double longest = INFINITY;
        for (int n = 0; n < w->on_count; ++n)
            if (w->on[n]->unsteady && w->on[n]->longest_step && w->on[n]->stage != STAGE_MEASUREMENT)
                longest = smaller(longest, w->on[n]->longest_step(w->on_p[n], i));
        const double wanted = ceil(step / (PER_PLACE * longest)), most = smaller(floor(step / period), MOST_PLACES);
        places->count[i] = larger(smaller(wanted, most), 1);
        places->missing[i] = wanted > places->count[i];
        for (int k = 0; k < CHANNELS; ++k)
            places->spread[k][i] = 0;
    }
}

/* In the n-th of equal parts of a step, as a share of it: the middle, or where turns are too many for that to be told
 * from others, anywhere. */
static double place_of(const struct Places *places, int n, int i)
{
    const double golden = n * 0.61803398874989485, within = places->missing[i] != 0 ? golden - floor(golden) : 0.5;
    return (n + within) / places->count[i];
}

/* The means, and what slow states strive to, over all places in place of those at the middle, which contact has come to
 * from `begun`. */
static enum Status look_around(struct Contact *contact, const struct Contact *begun, double start, double step,
                               struct Places *places, lanes mean[INTEGRALS], lanes at_first[INTEGRALS])
{
    lanes sum[INTEGRALS] = {{0}}, steady[EFFECT_STATES] = {{0}}, lowest[CHANNELS], highest[CHANNELS];
    double most = 1;
    EACH_LANE
        most = larger(most, places->count[i]);
    for (int n = 0; n < most && most > 1; ++n) {
        struct Contact probe = *begun;
        struct Configuration w;
        struct CycleSums seen;
        lanes there[INTEGRALS], t;
        EACH_LANE
            t[i] = start + step * (n < places->count[i] ? place_of(places, n, i) : 0.5);
        const enum Status status = look(&probe, t, step / period_of(contact), &w, &seen, there);
        if (status != STATUS_OK)
            return status;
        for (int i = 0; i < LANES; ++i) {
            if (n >= places->count[i] || !(places->count[i] > 1))
                continue;
            for (int k = 0; k < INTEGRALS; ++k)
                sum[k][i] += there[k][i] / places->count[i];
            for (int k = 0; k < EFFECT_STATES; ++k)
                steady[k][i] += probe.steady_state[k][i] / places->count[i];
            for (int k = 0; k < CHANNELS; ++k) {
                const double force = there[FIRST_FORCE + k][i];
                lowest[k][i] = n == 0 ? force : smaller(lowest[k][i], force);
                highest[k][i] = n == 0 ? force : larger(highest[k][i], force);
            }
            for (int index = VAR_CLAMPED_COUNT; index <= VAR_STEP_COUNT; ++index)
                contact->value[index][i] += probe.value[index][i] - begun->value[index][i];
        }
        contact->warnings |= probe.warnings;
    }
    for (int i = 0; i < LANES; ++i) {
        if (!(places->count[i] > 1))
            continue;
        for (int k = 0; k < CHANNELS; ++k)
            places->spread[k][i] = highest[k][i] - lowest[k][i];
        for (int k = 0; k < INTEGRALS; ++k) {
            at_first[k][i] += sum[k][i] - mean[k][i];
            mean[k][i] = sum[k][i];
        }
        for (int k = 0; k < EFFECT_STATES; ++k)
            contact->steady_state[k][i] = steady[k][i];
    }
    return STATUS_OK;
}

/* A quotient of differences; 0 where rounding has left no time between. */
static double per(double change, double time) { return time > 0 ? change / time : 0; }

#define OF_LEAVING 0.2 /* of a force: it falls as the root of how far the speed ratio is below 1 */

/* Where inputs and states stand. */
static void speed_ratio_here(const struct Contact *contact, const struct Configuration *w, lanes ratio)
{
    static const lanes here;
    struct Point x;
    point_at(contact, w, here, &x);
    EACH_LANE
        ratio[i] = x.speed_ratio[i];
}

/* Does the tool begin to leave the chip within a step, or cease to, which its middle does not show? The speed ratio
 * goes with the cutting speed, and with amplitudes that slow states take from. */
static int begins_to_leave(double ratio_before, double ratio_after)
{
    return (ratio_before - 1) * (ratio_after - 1) < 0;
}

/* How far the lane's mean forces over a step of h around t may be from those of the resolved run: what was left of the
 * cycle before; a bristle that starts as set, which the first cycle begins otherwise; cycles that were not alike; the
 * remainder of the midpoint rule, h^2/24 times the second derivative; a cycle that lies half a cycle beside the middle;
 * a broken number of cycles, of which the piece may hold all of a cycle's force or none; a law with events, whose
 * bristles stand nobody knows where after more cycles than were run; states that drift on and may come to an end, as of
 * a gap, in a cycle that begins elsewhere; a tool that begins to leave the chip; places between those that were looked
 * at of what goes by the time; slow states that strive to what the step before has shown, and then to what this one
 * has; and the tolerance of both runs. Differences pass through 0 where what they stand for does not, so the error
 * before is forgotten by halves. */
static double error_of(const struct Contact *contact, const struct CycleSums *seen, lanes mean[INTEGRALS], double t,
                       double h, int leaves, int slow, lanes at_first[INTEGRALS], const struct Places *places, int i)
{
    const double period = period_of(contact), whole = larger(h, period),
                 at[2] = {contact->earlier_time[0][i], contact->earlier_time[1][i]};
    const double loaded = stated_level(contact->value, i) * mean[DUTY][i];
    const int first = at[1] == -INFINITY, as_set = chosen(contact->value, VAR_INITIAL_STATE, i) != PERIODIC;
    const double cycles = h / period, beside = fabs(cycles - floor(cycles + 0.5)), piece = beside < 1e-6 ? 0 : beside;
    const double pieces = piece > 0 ? smaller(1, 3 * piece / mean[DUTY][i]) / cycles : 0; /* 3: peak over mean */
    const double unknown = stand_for(seen, cycles, i) && !seen->drifts[i] ? 0 : loaded;
    double largest = 0.5 * contact->value[VAR_AVERAGING_ERROR][i];
    for (int k = 0; k < CHANNELS; ++k) {
        const double now = mean[FIRST_FORCE + k][i], was = contact->earlier_force[0][k][i],
                     had = contact->earlier_force[1][k][i];
        const double last = seen->last[FIRST_FORCE + k][i],
                     before = seen->cycles[i] > 1 ? seen->before[FIRST_FORCE + k][i] : last;
        const double rate = per(now - was, t - at[0]);
        const double bend = first ? fabs(rate) / h : per(fabs(rate - per(was - had, at[0] - at[1])), t - at[1]);
        const double unlike =
            (fabs(last - before) + fabs(seen->next[FIRST_FORCE + k][i])) / (seen->periodic[i] ? whole : period);
        const double errors = contact->value[VAR_SIGMA0][i] * fabs(seen->departure[i]) * mean[DUTY][i] +
                              (first && as_set ? loaded * period / whole : 0) + unlike + unknown +
                              pieces * larger(fabs(now), loaded) + h * h / 12 * bend + 0.5 * period * fabs(rate) +
                              (slow ? 0.15 * fabs(now - was) + fabs(now - at_first[FIRST_FORCE + k][i]) : 0) +
                              (places->missing[i] != 0 ? OF_SPREAD_IN_FEW : OF_SPREAD) * places->spread[k][i] +
                              (leaves ? larger(loaded, OF_LEAVING * fabs(now)) : 0) +
                              contact->value[VAR_RELATIVE_TOLERANCE][i] * fabs(now);
        largest = larger(largest, errors);
    }
    return largest;
}

static void keep_for_error(struct Contact *contact, lanes mean[INTEGRALS], double t)
{
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE {
            contact->earlier_force[1][k][i] = contact->earlier_force[0][k][i];
            contact->earlier_force[0][k][i] = mean[FIRST_FORCE + k][i];
        }
    EACH_LANE {
        contact->earlier_time[1][i] = contact->earlier_time[0][i];
        contact->earlier_time[0][i] = t;
    }
}

static int adds_up(int index)
{
    for (int n = 0; n < INTEGRALS; ++n)
        if (integral_of[n] == index)
            return 1;
    for (int n = 0; n < kernel_state_count(); ++n)
        if (kernel_state(n) == index)
            return 1;
    return 0;
}

/* Means as the present inputs and slow states would make them. */
static enum Status look_here(struct Contact *contact, lanes mean[INTEGRALS])
{
    struct Contact probe = *contact;
    struct Configuration w;
    struct CycleSums seen;
    const enum Status status = look(&probe, contact->value[VAR_TIME], 1e9, &w, &seen, mean);
    if (status != STATUS_OK)
        return status;
    measured_now(contact, (const lanes *)mean + FIRST_FORCE, mean + FIRST_MEASURED);
    show_instant(&probe, &w);
    show_means(&probe, mean);
    for (int index = 0; index < kernel_variable_count(); ++index) {
        const enum Causality role = kernel_variable(index)->causality;
        const int shown = (role == OUTPUT || role == LOCAL) && index != VAR_STEP_COUNT &&
                          index != VAR_CLAMPED_COUNT; /* a look is no step */
        for (int i = 0; i < LANES && shown && !adds_up(index); ++i)
            contact->value[index][i] = probe.value[index][i];
    }
    memcpy(contact->steady_state, probe.steady_state, sizeof contact->steady_state);
    contact->warnings |= probe.warnings;
    return STATUS_OK;
}

enum Status average_here(struct Contact *contact)
{
    lanes mean[INTEGRALS];
    return look_here(contact, mean);
}

enum Status average_start(struct Contact *contact)
{
    const double start = contact->value[VAR_TIME][0];
    const int periodic = chosen(contact->value, VAR_INITIAL_STATE, 0) == PERIODIC;
    const uint64_t all = contact->effects_on;
    lanes mean[INTEGRALS], begin;
    contact->effects_on = all & ~sensors_on(contact);
    const struct Configuration w = wire(contact);
    cycle_at(contact, &w, contact->value[VAR_TIME], begin);
    EACH_LANE {
        contact->value[VAR_TIME][i] = begin[i];
        contact->value[VAR_AVERAGING][i] = RESOLVED; /* as each cycle is */
        contact->earlier_time[0][i] = contact->earlier_time[1][i] = -INFINITY;
        contact->served[i] = MOST_SERVED;
    }
    enum Status status = kernel_event(contact);
    if (status == STATUS_OK && periodic)
        status = find_periodic(contact);
    if (status == STATUS_OK && periodic)
        status = kernel_event(contact);
    EACH_LANE {
        contact->value[VAR_TIME][i] = start;
        contact->value[VAR_AVERAGING][i] = CYCLE;
    }
    contact->effects_on = all;
    if (status == STATUS_OK)
        status = look_here(contact, mean);
    if (status == STATUS_OK && chosen(contact->value, VAR_INITIAL_STATE, 0) != AT_REST && sensors_on(contact)) {
        settle_sensors(contact, period_of(contact), (const lanes *)mean + FIRST_FORCE);
        status = look_here(contact, mean);
    }
    if (status == STATUS_OK)
        keep_for_error(contact, mean, start);
    EACH_LANE
        open_window(contact, i);
    return status;
}

/* The middle of a step, `from` whose start slow states strive to what the step before has shown, and then to what that
 * has shown at first: where a force that grows takes from the amplitude, and so makes itself grow, the first may be far
 * off. */
static enum Status look_at_step(struct Contact *contact, double start, double step, int slow, const lanes *from,
                                struct Configuration *w, struct CycleSums *seen, struct Places *places,
                                lanes mean[INTEGRALS], lanes at_first[INTEGRALS])
{
    const double cycles = step / period_of(contact);
    struct Contact begun = *contact;
    lanes halfway[EFFECT_STATES], middle;
    EACH_LANE
        middle[i] = start + 0.5 * step;
    choose_places(w, step, period_of(contact), places);
    enum Status status = look(contact, middle, cycles, w, seen, mean);
    memcpy(at_first, mean, INTEGRALS * sizeof *mean);
    if (status == STATUS_OK && slow) {
        memcpy(begun.steady_state, contact->steady_state, sizeof begun.steady_state);
        *contact = begun;
        slow_states_after(contact, w, 0.5 * step, from, halfway);
        set_slow_states(contact, w, (const lanes *)halfway);
        begun = *contact;
        status = look(contact, middle, cycles, w, seen, mean);
    }
    return status == STATUS_OK ? look_around(contact, &begun, start, step, places, mean, at_first) : status;
}

enum Status average_step(struct Contact *contact, double step)
{
    const double start = contact->value[VAR_TIME][0], end = start + step, middle = start + 0.5 * step;
    lanes before[OWN_ROWS], mean[INTEGRALS], at_first[INTEGRALS], from[EFFECT_STATES], halfway[EFFECT_STATES];
    const lanes *const value = (const lanes *)before, *const slope =
                                                          value + offsetof(struct Contact, slope) / sizeof(lanes);
    struct Configuration w;
    struct CycleSums seen;
    struct Places places;
    if (step < NO_STEP) {
        lanes s;
        EACH_LANE
            s[i] = step;
        move_on(contact, s);
        return STATUS_OK;
    }
    memcpy(before, contact, sizeof before);
    memset(contact->slope, 0, sizeof contact->slope);
    w = wire(contact);
    const int slow = get_slow_states(contact, &w, from);
    lanes ratio_before, ratio_after;
    speed_ratio_here(contact, &w, ratio_before);
    slow_states_after(contact, &w, 0.5 * step, (const lanes *)from, halfway);
    set_slow_states(contact, &w, (const lanes *)halfway);
    EACH_LANE {
        for (int k = INPUT_FIRST; k < INPUT_END; ++k)
            contact->value[k][i] += 0.5 * step * slope[k - INPUT_FIRST][i];
        contact->value[VAR_SLIDING_DISTANCE][i] += 0.5 * step * value[VAR_SLIDING_SPEED][i];
    }
    enum Status status =
        look_at_step(contact, start, step, slow, (const lanes *)from, &w, &seen, &places, mean, at_first);
    if (status == STATUS_OK) {
        show_instant(contact, &w);
        slow_states_after(contact, &w, step, (const lanes *)from, halfway);
        set_slow_states(contact, &w, (const lanes *)halfway);
        speed_ratio_here(contact, &w, ratio_after);
        EACH_LANE {
            const double speed = contact->value[VAR_CUTTING_SPEED][i],
                         ends_at = 2 * speed - value[VAR_CUTTING_SPEED][i];
            ratio_after[i] *= speed > 0 ? ends_at / speed : 1;
            contact->value[VAR_TIME][i] = start;
        }
        status = measure_means(contact, step, (const lanes *)mean + FIRST_FORCE, mean + FIRST_MEASURED);
        for (int n = 0; n < INTEGRALS; ++n)
            EACH_LANE
                status = fabs(mean[n][i]) < INFINITY ? status : STATUS_DIVERGED;
    }
    if (status != STATUS_OK) {
        memcpy(contact, before, sizeof before);
        return status;
    }
    memcpy(contact->slope, slope, sizeof contact->slope);
    show_means(contact, mean);
    for (int k = INPUT_FIRST; k < INPUT_END; ++k)
        EACH_LANE
            contact->value[k][i] = value[k][i] + step * slope[k - INPUT_FIRST][i];
    for (int n = 0; n < INTEGRALS; ++n)
        EACH_LANE
            contact->value[integral_of[n]][i] = value[integral_of[n]][i] + step * mean[n][i];
    for (int i = 0; i < LANES; ++i) {
        double rates[MEANS];
        for (int n = 0; n < MEANS; ++n)
            rates[n] = mean[FIRST_MEAN + n][i];
        contact->value[VAR_TIME][i] = end;
        contact->value[VAR_AVERAGING_ERROR][i] =
            error_of(contact, &seen, mean, middle, step, begins_to_leave(ratio_before[i], ratio_after[i]), slow,
                     at_first, &places, i);
        if (contact->value[VAR_AVERAGING_WINDOW][i] >= NO_WINDOW)
            pass_windows(contact, i, start, rates);
    }
    show_recent(contact);
    keep_for_error(contact, mean, middle);
    return STATUS_OK;
}
