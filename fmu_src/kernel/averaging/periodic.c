/* From which state does one vibration cycle come back to itself? */
#include "cycles.h"

#include <math.h>
#include <string.h>

/* Internal steps that a cycle, and all of the search for the periodic state, may take: an ellipse takes some 60 a
 * cycle, and 12 times the slopes of all states take 300 cycles. Where bonds break by thousands in a cycle, and at
 * random, there is nothing to find; where a holder swings a million times within one, it takes too long. */
#define MOST_STEPS 2e4

double most_steps_of_cycles(const struct Contact *contact)
{
    double tightest = 1;
    EACH_LANE
        tightest = smaller(tightest, contact->value[VAR_RELATIVE_TOLERANCE][i]);
    return MOST_STEPS * smaller(larger(1, sqrt(sqrt(1e-4 / tightest))), 10);
}

/* Through one vibration cycle, in so many steps at most. */
static enum Status pass_cycle(struct Contact *contact)
{
    const struct Configuration w = wire(contact);
    struct Course course;
    lanes s = {0};
    course.now = course.known = 0;
    course.guard.length = 0;
    course.most_steps = most_steps_of_cycles(contact);
    const enum Status status =
        advance_internal(contact, &w, 1 / contact->value[VAR_VIBRATION_FREQUENCY][0], 0, s, &course);
    move_on(contact, s);
    return status;
}

/* A position goes on from cycle to cycle: it begins where it is, and no state of it comes back, but where a separation
 * lets the contact begin anew. */
static int states_that_come_back(const struct Effect *effect)
{
    return effect->periods && !effect->forgets ? 0 : effect->states;
}

/* Which effect, by its place among those that are on, has the n-th unknown, and as the how many-th of its states? -1:
 * none has it. */
static int owner_of(const struct Configuration *w, int n, int *state)
{
    *state = n - 1;
    for (int k = 0; n > 0 && k < w->on_count; *state -= states_that_come_back(w->on[k++]))
        if (*state < states_that_come_back(w->on[k]))
            return k;
    return -1;
}

/* Does an unknown go on from cycle to cycle, so that a far one is no large one? */
static int is_position(const struct Configuration *w, int n)
{
    int state;
    const int owner = owner_of(w, n, &state);
    return owner >= 0 && w->on[owner]->periods != NULL;
}

/* Does anything go by a position? Then periods lie between places that are far apart. */
static int is_felt(const struct Configuration *w, int n, int i)
{
    static const lanes here[EFFECT_STATES];
    lanes there[EFFECT_STATES] = {{0}};
    int state;
    const int owner = owner_of(w, n, &state);
    for (int k = 0; k < EFFECT_STATES; ++k)
        there[k][i] = 1;
    return w->on[owner]->periods(w->on_p[owner], here, (const lanes *)there, i) > 0;
}

/* Is it left where it is in this lane: because no separation lets it begin anew, or because nothing goes by it? */
static int is_left(const struct Configuration *w, int n, int i)
{
    return is_position(w, n) && (w->p[VAR_RELEASE_TIME][i] >= NO_TIME || !is_felt(w, n, i));
}

/* How many are sought in the lane, of all or of some? */
static int unknowns_of(const struct Configuration *w, int used, const int *sought, int i)
{
    int count = 0;
    for (int n = 0; n < used; ++n)
        count += (!sought || sought[n]) && !is_left(w, n, i);
    return count;
}

int unknown_index(const struct Configuration *w, int n)
{
    int state;
    const int owner = owner_of(w, n, &state);
    return n == 0 ? VAR_BRISTLE_DEFLECTION : owner >= 0 ? w->on_value[owner] + state : -1;
}

/* A deflection that comes back to a hundredth of a tolerance may leave forces that do not, where damping answers it by
 * thousands of times the stiffness. A cycle has come back where the forces have, too; that is asked for in a few cycles
 * more, as forces may go by the steps that a cycle has taken. */
#define FORCES_COME_BACK 1e-2 /* tolerances */
#define MORE_CYCLES 3

/* Do the states `from` make the forces of a cycle's end, in its place? */
static int forces_came_back(const struct Contact *end, const struct Configuration *w, int count, const lanes *from,
                            int i)
{
    static const lanes here;
    const struct Configuration there = wire(end);
    struct Contact begun = *end;
    struct Point a, b;
    for (int n = 0; n < count; ++n)
        if (!is_left(w, n, i))
            begun.value[unknown_index(w, n)][i] = from[n][i];
    point_at(&begun, &there, here, &a);
    point_at(end, &there, here, &b);
    const double enough = FORCES_COME_BACK * w->p[VAR_RELATIVE_TOLERANCE][i], level = level_of(&there, &b, i);
    return fabs(b.F[i] - a.F[i]) <= enough * larger(level, fabs(b.F[i])) &&
           fabs(b.F_p[i] - a.F_p[i]) <= enough * larger(level, fabs(b.F_p[i]));
}

/* What a cycle of a search tells of the steps of the next, which begins at the same time. All cycles of a search are
 * one to the count of those that are alike. */
static void learn_steps(struct Contact *contact, const struct Contact *trial, const struct Configuration *w, int i)
{
    contact->next_step[i] = trial->next_step[i];
    copy_breakpoints(contact, trial, i);
    contact->breakpoints_from[i] += 1 / contact->value[VAR_VIBRATION_FREQUENCY][i];
    repeat_breakpoints(contact, w, i);
}

#define FAR                                                                                                            \
    30 /* a bristle's reach: bristles that heat has softened go beyond one, and a slope of roundings beyond all */

/* The bristle deflection that one vibration cycle brings back. For a law that is linear in z one cycle maps z to c + E
 * z, and two cycles give z_0 = c / (1 - E); otherwise the same secant is repeated. Where each cycle bends a bristle on
 * by as much as the one before, as one that holds until it slides, ever more cycles are passed at once, up to its
 * reach. */
static enum Status find_deflection(struct Contact *contact, const struct Configuration *w)
{
    const double start = contact->value[VAR_TIME][0];
    struct Contact trial = *contact;
    lanes z = {0}, miss = {0}, z_before, miss_before, at_once;
    EACH_LANE
        at_once[i] = 1;
    int converged = 0, done[LANES] = {0}, more[LANES] = {0}, given_up = 0;
    for (int n = 0; n < 20 && !converged; ++n) {
        EACH_LANE {
            trial.value[VAR_BRISTLE_DEFLECTION][i] = z[i];
            trial.value[VAR_TIME][i] = start;
            trial.value[VAR_SLIDING_DISTANCE][i] = contact->value[VAR_SLIDING_DISTANCE][i]; /* what goes by it stays */
            forget_past(&trial, i);
            trial.follows[i] = contact->follows[i];
            trial.followed_slip[i] = contact->followed_slip[i];
            trial.next_step[i] = contact->next_step[i];
            copy_breakpoints(&trial, contact, i);
            z_before[i] = n == 0 ? 0 : z_before[i];
            miss_before[i] = n == 0 ? 0 : miss_before[i];
        }
        const enum Status begun = kernel_event(&trial);
        const enum Status status = begun == STATUS_OK ? pass_cycle(&trial) : begun;
        if (status != STATUS_OK)
            return status;
        converged = 1;
        for (int i = 0; i < LANES; ++i) {
            const double reach = stated_level(trial.value, i) / trial.value[VAR_SIGMA0][i];
            miss[i] = trial.value[VAR_BRISTLE_DEFLECTION][i] - z[i];
            const int near = fabs(miss[i]) <= 1e-2 * trial.value[VAR_RELATIVE_TOLERANCE][i] * reach;
            done[i] =
                done[i] || (near && (forces_came_back(&trial, w, 1, (const lanes *)&z, i) || ++more[i] > MORE_CYCLES));
            const double steps =
                trial.value[VAR_STEP_COUNT][i] - contact->value[VAR_STEP_COUNT][i]; /* of all cycles so far */
            const int gives_up = !done[i] & (steps * (n + 2) > most_steps_of_cycles(contact) * (n + 1));
            given_up |= gives_up;
            const double slope = n > 0 && z[i] != z_before[i] ? (miss[i] - miss_before[i]) / (z[i] - z_before[i]) : -1;
            const double miss_was = miss_before[i];
            z_before[i] = z[i];
            miss_before[i] = miss[i];
            const int past = at_once[i] > 1 && miss[i] * miss_was < 0, /* it has come to what it strives for */
                secant = slope < 0 && fabs(miss[i]) <= -slope * FAR * reach && !past && !gives_up;
            at_once[i] = secant || past || n == 0 || gives_up ? 1 : 2 * at_once[i];
            const double on = secant ? -miss[i] / slope : at_once[i] * miss[i];
            z[i] = done[i] ? z[i] : at_once[i] > 1 ? larger(smaller(z[i] + on, reach), -reach) : z[i] + on;
            done[i] |= gives_up;
            converged &= done[i];
            if (n == 0 && !done[i])
                learn_steps(contact, &trial, w, i);
        }
    }
    EACH_LANE {
        contact->value[VAR_BRISTLE_DEFLECTION][i] = z[i];
        learn_steps(contact, &trial, w, i);
    }
    for (int n = 0; n < MEMORY; ++n)
        EACH_LANE
            contact->memory[n][i] = trial.memory[n][i];
    contact->warnings |= converged && !given_up ? 0u : WARN_NOT_PERIODIC;
    return STATUS_OK;
}

/* ---- with effects that have states of their own: Newton's method on all of them, by slopes that are taken by
 * differences and then follow Broyden's update (Dennis and Schnabel, chapter 8) for as long as steps go by them ---- */

/* A step that leaves more than this of what a cycle misses asks for slopes anew. */
#define SLOW_STEP 0.3
#define MOST_TRIES 30

/* A search that ends within this of a cycle leaves what is nearest to one, and one that has taken too long for a second
 * cycle what the first has made of a start at rest; else it has gone astray, and what it leaves says more of its
 * tolerance than of the contact, which then begins at rest. */
#define ASTRAY 0.1

/* Two cycles of a stiff resonance differ by the errors of their steps, which no slopes make smaller: a search that is
 * near and has not halved what a cycle misses in so many tries has come as near as it can. Within the tolerance that is
 * a state that comes back. */
#define MOST_IDLE 6

double scale_of(const struct Contact *contact, int index, int i)
{
    const double nominal = kernel_variable(index)->nominal,
                 reach = stated_level(contact->value, i) / contact->value[VAR_SIGMA0][i];
    return index == VAR_BRISTLE_DEFLECTION ? reach
                                           : larger(1e-3 * (nominal > 0 ? nominal : 1), fabs(contact->value[index][i]));
}

/* What one cycle makes of the states `from`. */
static enum Status cycle(const struct Contact *contact, const struct Configuration *w, int count, const lanes *from,
                         lanes *to, struct Contact *trial)
{
    *trial = *contact;
    EACH_LANE
        forget_past(trial, i);
    for (int n = 0; n < count; ++n)
        EACH_LANE
            trial->value[unknown_index(w, n)][i] = from[n][i];
    enum Status status = kernel_event(trial);
    if (status == STATUS_OK)
        status = pass_cycle(trial);
    for (int n = 0; n < count; ++n)
        for (int i = 0; i < LANES; ++i)
            to[n][i] = is_left(w, n, i) ? from[n][i] : trial->value[unknown_index(w, n)][i];
    return status;
}

/* A search for the states of a lane that a cycle brings back. */
struct Search {
    double miss[UNKNOWNS], scale[UNKNOWNS]; /* what a cycle adds to the states, and what is little of each */
    double slope[UNKNOWNS][UNKNOWNS]; /* of what a cycle makes of them */
    double step[UNKNOWNS], missed; /* the next one; the largest miss, by its scale */
    int went_far[UNKNOWNS]; /* beyond all that a state may come to: what is little of it is as it was before */
    double nearest[UNKNOWNS], least; /* what the cycle that missed least has come to, and what it missed */
    int knows_slopes, more, idle, done, lost;
    double steps; /* of the integration */
};

/* What a cycle has come to. `by_slopes`: from where they led, and not on from the cycle before. */
static void note_miss(struct Search *x, int count, const lanes *to, double missed, int by_slopes, int i)
{
    const int halves = !(missed > 0.5 * x->least);
    x->idle = halves ? 0 : x->idle + (by_slopes && x->least <= ASTRAY);
    for (int n = 0; n < count && missed <= x->least; ++n)
        x->nearest[n] = to[n][i];
    x->least = smaller(x->least, missed);
    x->missed = missed;
}

/* What a cycle missed after a step tells of the slopes along it. */
static void update_slopes(struct Search *x, int count, const double *miss)
{
    double square = 0;
    for (int n = 0; n < count; ++n)
        square += x->step[n] / x->scale[n] * (x->step[n] / x->scale[n]);
    for (int n = 0; n < count && square > 0; ++n) {
        double wrong = miss[n] - x->miss[n] + x->step[n]; /* of the end of a cycle, less what slopes say of it */
        for (int c = 0; c < count; ++c)
            wrong -= x->slope[n][c] * x->step[c];
        for (int c = 0; c < count; ++c)
            x->slope[n][c] += wrong * (x->step[c] / (x->scale[c] * x->scale[c])) / square;
    }
}

static void solve_step(struct Search *x, int count)
{
    double A[UNKNOWNS][UNKNOWNS];
    for (int n = 0; n < count; ++n) {
        x->step[n] = x->miss[n];
        for (int c = 0; c < count; ++c)
            A[n][c] = (n == c) - x->slope[n][c];
    }
    solve_linear(count, A, x->step);
}

/* A state that each cycle moves on by as much as the one before has a slope of 1 but for roundings, by which a step
 * leads anywhere, and to either side, or nowhere where there are none: it goes on as cycles do, beyond all that it may
 * come to. Not a position, which comes to no end. */
#define BEYOND_ALL 1e6 /* of what is little of a state */

static void turn_as_missed(struct Search *x, const struct Configuration *w, int count)
{
    for (int n = 0; n < count; ++n) {
        const int stays = x->slope[n][n] == 1 && x->step[n] == 0 && x->miss[n] != 0;
        if (!is_position(w, n) && (stays || fabs(x->step[n]) > BEYOND_ALL * x->scale[n])) {
            x->step[n] = copysign(stays ? BEYOND_ALL * x->scale[n] : x->step[n], x->miss[n]);
            x->went_far[n] = 1;
        }
    }
}

static double furthest(const double *miss, const double *scale, int count)
{
    double most = 0;
    for (int n = 0; n < count; ++n)
        most = larger(most, fabs(miss[n]) / scale[n]);
    return most;
}

static double enough_of(const struct Contact *contact, int i)
{
    return 1e-1 * contact->value[VAR_RELATIVE_TOLERANCE][i];
}

/* What is known of the slopes before a cycle is run: where forces move nothing, a separation forgets bristles and what
 * goes with them, and what a sensor does of itself is linear. The others are sought by differences. Where
 * there is no separation, or one sensor hears another, the next cycle shows that the slopes are others. */
static void foresee_slopes(const struct Contact *contact, const struct Configuration *w, int sought[UNKNOWNS],
                           struct Search search[LANES])
{
    int at = 1;
    sought[0] = w->feedback || w->sensors; /* how the bristle begins moves other states, too */
    for (int k = 0; k < w->on_count; ++k) {
        const struct Effect *effect = w->on[k];
        const int states = states_that_come_back(effect), heard = effect->driver == DRIVEN_BY_SENSOR;
        lanes M[EFFECT_STATES][EFFECT_STATES];
        if (heard && states)
            own_slopes(w, k, 1 / contact->value[VAR_VIBRATION_FREQUENCY][0], M);
        for (int c = 0; c < states; ++c) {
            sought[at + c] = !heard && (w->feedback || !effect->forgets);
            for (int r = 0; heard && r < states; ++r)
                for (int i = 0; i < LANES; ++i)
                    search[i].slope[at + r][at + c] = M[r][c][i];
        }
        at += states;
    }
}

/* Slopes lead nowhere where each cycle adds as much as the one before until a limit is met, as a gap that closes in
 * some cycles: then these are passed, from rest. */
static void begin_anew(const struct Configuration *w, struct Search *x, int count, lanes *from, int i)
{
    if (x->done)
        return;
    memset(x->slope, 0, sizeof x->slope);
    memset(x->went_far, 0, sizeof x->went_far);
    x->steps = x->more = x->idle = 0;
    x->least = INFINITY;
    for (int n = 0; n < count; ++n)
        from[n][i] = is_left(w, n, i) ? from[n][i] : 0;
}

/* Slopes by differences, of the lanes that `renew` them, by the unknowns that are `sought`: one cycle more for each.
 * `to` is what the cycle from `from` comes to, `trial` the contact then. */
static enum Status difference_slopes(struct Contact *contact, const struct Configuration *w, int used,
                                     const int *sought, const int *renew, const struct Contact *trial,
                                     const lanes *from, const lanes *to, struct Search *search)
{
    for (int c = 0; c < used; ++c) {
        lanes beside[UNKNOWNS], other[UNKNOWNS], step;
        int any = 0;
        memcpy(beside, from, sizeof beside);
        for (int i = 0; i < LANES; ++i) {
            const int varied = (!sought || sought[c]) && !is_left(w, c, i);
            step[i] = 1e-2 * scale_of(trial, unknown_index(w, c), i);
            beside[c][i] += varied ? step[i] : 0;
            any |= varied;
        }
        if (!any)
            continue;
        struct Contact second;
        const enum Status status = cycle(contact, w, used, (const lanes *)beside, other, &second);
        if (status != STATUS_OK)
            return status;
        for (int i = 0; i < LANES; ++i)
            for (int n = 0; n < used && renew[i]; ++n)
                search[i].slope[n][c] = (other[n][i] - to[n][i]) / step[i];
    }
    return STATUS_OK;
}

/* Does something go by a position that no cycle brings back? */
static int is_carried_off(const struct Contact *begun, const struct Contact *end, const struct Configuration *w, int n,
                          int i)
{
    const int index = unknown_index(w, n);
    return is_left(w, n, i) && is_felt(w, n, i) && end->value[index][i] != begun->value[index][i];
}

static enum Status find_states(struct Contact *contact, const struct Configuration *w)
{
    const int count = 1 + kernel_state_count() - BASE_STATES;
    struct Contact trial;
    struct Search search[LANES];
    lanes from[UNKNOWNS] = {{0}}, to[UNKNOWNS];
    int used = 0, converged = 0, given_up = 0, sought[UNKNOWNS];
    memset(search, 0, sizeof search);
    EACH_LANE
        search[i].least = INFINITY;
    while (used < count && unknown_index(w, used) >= 0)
        ++used;
    foresee_slopes(contact, w, sought, search);
    for (int n = 0; n < used; ++n)
        for (int i = 0; i < LANES; ++i)
            from[n][i] = is_left(w, n, i) ? contact->value[unknown_index(w, n)][i] : 0;
    for (int tries = 0; tries < 2 * MOST_TRIES && !converged; ++tries) {
        const int by_slopes = tries < MOST_TRIES;
        for (int i = 0; tries == MOST_TRIES && i < LANES; ++i)
            begin_anew(w, &search[i], used, from, i);
        enum Status status = cycle(contact, w, used, (const lanes *)from, to, &trial);
        if (status == STATUS_TOO_MANY_STEPS && by_slopes && tries > 0) {
            tries = MOST_TRIES - 1; /* they have led where no contact is */
            continue;
        }
        if (status != STATUS_OK)
            return status;
        int renew[LANES], any = 0;
        for (int i = 0; i < LANES; ++i) {
            struct Search *x = &search[i];
            double miss[UNKNOWNS];
            for (int n = 0; n < used; ++n)
                miss[n] = to[n][i] - from[n][i];
            if (by_slopes && x->knows_slopes && !x->done)
                update_slopes(x, used, miss);
            for (int n = 0; n < used && !x->done; ++n) {
                x->miss[n] = miss[n];
                if (!x->went_far[n])
                    x->scale[n] = is_position(w, n)
                                      ? scale_of(contact, unknown_index(w, n), i)
                                      : larger(scale_of(&trial, unknown_index(w, n), i), fabs(from[n][i]));
            }
            const double missed = furthest(x->miss, x->scale, used);
            renew[i] = by_slopes && !x->done &&
                       (!x->knows_slopes || missed > larger(SLOW_STEP * x->missed, enough_of(&trial, i)));
            if (!x->done)
                note_miss(x, used, (const lanes *)to, missed, by_slopes, i);
            any |= renew[i];
            x->steps += (1 + renew[i] * unknowns_of(w, used, tries == 0 ? sought : NULL, i)) *
                        (trial.value[VAR_STEP_COUNT][i] - contact->value[VAR_STEP_COUNT][i]);
        }
        if (any)
            status = difference_slopes(contact, w, used, tries == 0 ? sought : NULL, renew, &trial, (const lanes *)from,
                                       (const lanes *)to, search);
        if (status != STATUS_OK)
            return status;
        converged = 1;
        for (int i = 0; i < LANES; ++i) {
            struct Search *x = &search[i];
            x->knows_slopes |= renew[i];
            if (x->done)
                continue;
            solve_step(x, used);
            turn_as_missed(x, w, used);
            const int near = larger(x->missed, furthest(x->step, x->scale, used)) <= enough_of(&trial, i);
            x->done = near && (forces_came_back(&trial, w, used, (const lanes *)from, i) || ++x->more > MORE_CYCLES);
            const int gives_up = !x->done && (x->steps > most_steps_of_cycles(contact) || x->idle >= MOST_IDLE);
            x->lost = !x->done && !((gives_up ? x->least : x->missed) <= ASTRAY) && !(gives_up && tries == 0);
            for (int n = 0; n < used && !x->done; ++n)
                from[n][i] = gives_up ? x->nearest[n] : from[n][i] + x->step[n];
            given_up |= gives_up && !(x->least <= w->p[VAR_RELATIVE_TOLERANCE][i]);
            x->done |= gives_up;
            converged &= x->done;
            if (tries == 0 && !x->done) /* once slopes are known: cycles of other steps differ by their errors, too */
                learn_steps(contact, &trial, w, i);
        }
    }
    for (int i = 0; i < LANES; ++i) {
        for (int n = 0; n < used; ++n)
            given_up |= is_carried_off(contact, &trial, w, n, i);
        if (search[i].lost)
            continue;
        learn_steps(contact, &trial, w, i);
        for (int n = 0; n < used; ++n)
            contact->value[unknown_index(w, n)][i] = from[n][i];
        copy_lane(contact->memory, (const lanes *)trial.memory, MEMORY, i);
    }
    contact->warnings |= converged && !given_up ? 0u : WARN_NOT_PERIODIC;
    return STATUS_OK;
}

int is_steady(const struct Configuration *w)
{
    int steady = 1;
    for (int n = 0; n < w->on_count; ++n)
        steady &= !w->on[n]->unsteady && !w->on[n]->periods;
    return steady;
}

/* Forces of the cycles before, for effects that look back. Of cycles that are alike the first stands for all but the
 * last two: the gap behind it says so. */
static enum Status fill_history(struct Contact *contact, const struct Configuration *w)
{
    const double period = 1 / contact->value[VAR_VIBRATION_FREQUENCY][0];
    double back = 0, taken;
    EACH_LANE
        back = larger(back, look_back(w, i));
    if (!(back > 0))
        return STATUS_OK;
    const double cycles = ceil(back / period), skipped = is_steady(w) ? larger(cycles - 3, 0) : 0;
    struct Contact before = *contact;
    EACH_LANE {
        before.value[VAR_TIME][i] = contact->value[VAR_TIME][i] - (cycles - skipped) * period;
        forget_past(&before, i);
    }
    enum Status status = kernel_event(&before);
    if (status == STATUS_OK)
        status = kernel_advance(&before, period, 0, &taken);
    for (int n = 0; n < HISTORY && skipped > 0; ++n)
        EACH_LANE
            before.past.end[n][i] -= skipped * period;
    if (status == STATUS_OK && cycles > 1)
        status = kernel_advance(&before, (cycles - skipped - 1) * period, 0, &taken);
    contact->past = before.past;
    memcpy(contact->past_force, before.past_force, sizeof contact->past_force);
    return status;
}

enum Status find_periodic(struct Contact *contact)
{
    const struct Configuration w = wire(contact);
    const enum Status status = w.drivers ? find_states(contact, &w) : find_deflection(contact, &w);
    if (status == STATUS_TOO_MANY_STEPS) {
        contact->warnings |= WARN_NOT_PERIODIC;
        return STATUS_OK; /* from rest */
    }
    return status == STATUS_OK && w.looks_back ? fill_history(contact, &w) : status;
}
