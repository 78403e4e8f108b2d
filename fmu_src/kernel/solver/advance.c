/* How does the contact get through a communication step? In internal steps that the tolerance chooses and that end at
 * events.
 *
 * An internal step sees the point at its start, middle and end on one and the same side of every event. Where an
 * indicator has changed its sign the step is cut there.
 */
#include "trial.h"

#include <math.h>
#include <string.h>

/* Integral by Simpson's rule of what start, middle and end show. */
#define SUM(field) (sixth * (a->field[i] + 4 * m->field[i] + b->field[i]))

static void accumulate(struct Contact *contact, const struct Configuration *w, const lanes h,
                       const struct Point *restrict a, const struct Point *restrict m, const struct Point *restrict b)
{
    lanes *const restrict value = contact->value;
    lanes of_force[CHANNELS];
    EACH_LANE {
        const double sixth = h[i] / 6;
        of_force[0][i] = SUM(F);
        of_force[1][i] = SUM(F_p);
        of_force[2][i] = SUM(F_f);
        value[VAR_BRISTLE_DEFLECTION][i] = b->z[i];
        value[VAR_DISSIPATED_ENERGY][i] += SUM(P_f);
        value[VAR_SHEAR_ENERGY][i] += SUM(P_s);
        value[VAR_SLIDING_DISTANCE][i] += a->cutting[i] * SUM(speed);
        value[VAR_FRICTION_IMPULSE][i] += of_force[0][i];
        value[VAR_PRINCIPAL_IMPULSE][i] += of_force[1][i];
        value[VAR_FEED_IMPULSE][i] += of_force[2][i];
        value[VAR_NORMAL_IMPULSE][i] += SUM(N);
        value[VAR_CONTACT_TIME][i] += h[i] * a->cutting[i];
        value[VAR_STEP_COUNT][i] += h[i] > 0;
        value[VAR_CLAMPED_COUNT][i] +=
            (h[i] > 0) & ((contact->at_bound[i] != 0) | ((b->cutting[i] != 0) & (b->clamped[i] + b->outside[i] > 0)));
    }
    if (measures(w))
        EACH_LANE {
            const double sixth = h[i] / 6;
            for (int k = 0; k < CHANNELS; ++k)
                of_force[k][i] = SUM(measured[k]);
        }
    EACH_LANE {
        value[VAR_MEASURED_FRICTION_IMPULSE][i] += of_force[0][i];
        value[VAR_MEASURED_PRINCIPAL_IMPULSE][i] += of_force[1][i];
        value[VAR_MEASURED_FEED_IMPULSE][i] += of_force[2][i];
    }
    for (int i = 0; w->current_angle && i < LANES; ++i)
        if (h[i] > 0 && b->cutting[i] != 0) {
            contact->follows[i] = fabs(b->solved_slip[i]) < INFINITY;
            contact->followed_slip[i] = contact->follows[i] != 0 ? b->solved_slip[i] : 0;
        }
    if (w->drivers)
        store_states(contact, w, b);
    for (int i = 0; w->looks_back && i < LANES; ++i)
        if (h[i] > 0)
            remember(contact, w, i, h[i], a, m, b);
    for (int i = 0; w->meets_again && i < LANES; ++i)
        if (h[i] > 0)
            leave_surface(contact, w, i, a, m, b);
}

/* The step is taken: s moves on, and with it the integrals, the history and the averaging windows. What ends the
 * communication step by a rounding does not stand where the next one begins. */
static enum Status take(struct Contact *contact, const struct Configuration *w, double step, lanes s, struct Trial *t,
                        struct Course *course)
{
    EACH_LANE
        contact->next_step[i] = t->next[i];
    warn(contact, t->end);
    if (measures(w))
        measure_step(contact, w, t->h, t->start, t->middle, t->end);
    else
        open_measured(t->end);
    accumulate(contact, w, t->h, t->start, t->middle, t->end);
    for (int i = 0; (w->looks_back || w->meets_again) && i < LANES; ++i)
        if (!past_reaches(contact, w, i, t->end->t[i]))
            return STATUS_HISTORY_SHORT;
    int windows_ended = 0;
    course->arrived = 1;
    EACH_LANE {
        const double end = s[i] + t->h[i];
        course->arrived &= end == step;
        s[i] = t->h[i] == step - s[i] ? step : end;
        windows_ended |= t->to_window[i] != 0;
    }
    for (int i = 0; w->kinematics != KINEMATICS_EXTERNAL && i < LANES; ++i)
        if (t->h[i] > 0 && keeps_breakpoints(w, i))
            note_breakpoint(contact, w, i, contact->value[VAR_TIME][i] + s[i], t->h[i],
                            ended_at(contact, t, step, s[i], i));
    for (int i = 0; windows_ended && i < LANES; ++i)
        if (t->to_window[i] != 0) {
            close_window(contact, i);
            course->window_end[i] = window_end(contact, i);
        }
    return STATUS_OK;
}

/* The lanes in which the slip goes on otherwise from s on; status where it is no longer known. */
static enum Status feel_next_part(struct Contact *contact, const struct Configuration *w, double step, const lanes s,
                                  int next[LANES])
{
    enum Status status = STATUS_OK;
    for (int i = 0; i < LANES && status == STATUS_OK; ++i) {
        next[i] = s[i] < step && s[i] >= contact->late_until[i];
        if (next[i])
            status = feel_slip(contact, w, i, s[i]);
    }
    return status;
}

static int is_any(const int cut[LANES], int jumps)
{
    int any = 0;
    EACH_LANE
        any |= jumps ? cut[i] == JUMP : cut[i] >= 0;
    return any;
}

/* Is no other event among them? */
static int is_only(const int cut[LANES], int k)
{
    int other = 0;
    EACH_LANE
        other |= cut[i] >= 0 && cut[i] != k;
    return !other;
}

/* An event that has happened before the start, as where an input has jumped. Where no side changes the start lies
 * beside it by roundings only, and it may still lie ahead. */
static void act_on_jump(struct Contact *contact, const struct Configuration *w, const lanes s, const lanes ahead,
                        const int chased[LANES], const int acts[LANES], struct Trial *t)
{
    lanes before[INDICATORS];
    for (int i = 0; i < LANES; ++i)
        copy_lane(before, (const lanes *)contact->sign, INDICATORS, i);
    act_in_lanes(contact, w, s, ahead, chased, acts, t->start);
    t->alike = 0;
    for (int i = 0; i < LANES; ++i) {
        int same = acts[i];
        for (int k = 0; k < INDICATORS; ++k)
            same &= before[k][i] == contact->sign[k][i];
        t->acted[i] |= same;
        if (w->feedback && acts[i])
            forget_feedback(t, i);
    }
}

/* After how long a contact that was passed over is looked at again: ever longer where contact and its end follow on one
 * another at once. */
static double next_wait(double wait, double quiet, int chased, double first)
{
    return chased ? 2 * wait : quiet > 2 * wait ? first : wait;
}

static int all_finite(const struct Point *x)
{
    int lost = 0;
    EACH_LANE
        lost |= !(fabs(x->z[i]) < INFINITY) | !(fabs(x->F_p[i]) < INFINITY);
    return !lost;
}

enum Status advance_internal(struct Contact *contact, const struct Configuration *w, double step, int stop_at_events,
                             lanes s, struct Course *course)
{
    struct ZenoGuard *const guard = &course->guard;
    const double most_steps = course->most_steps > 0 ? course->most_steps : INFINITY;
    struct Room *const room = course->room;
    static const int other[3][2] = {{1, 2}, {2, 0}, {0, 1}};
    struct LoopMemory loop;
    struct Trial t = {.loop = &loop,
                      .start = &room[course->now].point,
                      .middle = &room[other[course->now][0]].point,
                      .end = &room[other[course->now][1]].point,
                      .alike = course->known && course->alike};
    int jumps = 0, stopped = 0, acts[LANES], chased[LANES] = {0};
    lanes quiet_for, ahead;
    EACH_LANE
        quiet_for[i] = INFINITY; /* since the last event [s] */
    course->arrived = 0;
    begin_trials(w, step, &t);
    if (w->feedback)
        memset(&loop, 0, sizeof loop);
    guard_stretch(contact, w, guard);
    if (step < NO_STEP) {
        EACH_LANE
            s[i] = step;
        course->known = 0;
        return STATUS_OK;
    }
    if (w->delays) {
        const enum Status felt = feel_slip_now(contact, w);
        if (felt != STATUS_OK)
            return felt;
        course->known = 0;
    }
    const double moment = w->kinematics == KINEMATICS_EXTERNAL ? 1e-14 * step : 1e-9 / w->p[VAR_VIBRATION_FREQUENCY][0],
                 first_wait =
                     10 * moment; /* a hundred-millionth of a cycle: what is missed of a contact that is back at once */
    EACH_LANE {
        ahead[i] = moment;
        t.wait[i] = first_wait;
    }
    if (!stop_at_events)
        skip_windows(contact, w, step);
    if (!course->known) {
        point_at(contact, w, s, t.start);
        let_go(contact, w);
        EACH_LANE
            t.start->z[i] = contact->value[VAR_BRISTLE_DEFLECTION][i];
    }
    EACH_LANE
        course->window_end[i] = window_end(contact, i);
    t.first = !course->known;
    course->known = 0;
    for (double n = 0; choose_step(contact, w, step, s, course->window_end, &t); ++n) {
        if (n >= most_steps || is_without_end(contact, guard, step, s, n))
            return STATUS_TOO_MANY_STEPS;
        compute_trial(contact, w, s, &t);
        if (!all_finite(t.end))
            return STATUS_DIVERGED;
        if (!trial_is_accurate(contact, w, &t)) {
            if (trial_repeats(&t))
                return STATUS_TOO_MANY_STEPS;
            ask_again(contact, &t);
            continue;
        }
        const int shorter = cut_short(contact, w, s, &t);
        if (is_any(t.cut, 1) && jumps++ < INDICATORS) { /* an input has jumped across an event */
            EACH_LANE
                acts[i] = t.cut[i] == JUMP; /* the same step again: it says nothing yet of a longer one */
            act_on_jump(contact, w, s, ahead, chased, acts, &t);
            continue;
        }
        jumps = 0;
        if (shorter ? !settle_cut(contact, w, s, &t) : !halves_are_accurate(contact, w, s, &t)) {
            ask_again(contact, &t);
            continue;
        }
        const int event = is_any(t.cut, 0);
        const int breaks = event && w->law->rest && is_only(t.cut, AT_LAW);
        guard->breaks += breaks;
        guard->events += event && !breaks;
        const enum Status taken = take(contact, w, step, s, &t, course);
        EACH_LANE
            t.acted[i] = t.failed[i] = 0;
        if (taken != STATUS_OK)
            return taken;
        stopped = event && stop_at_events;
        if (stopped)
            break;
        for (int i = 0; w->feedback && i < LANES; ++i)
            if (t.h[i] > 0)
                keep_feedback(&t, i);
        struct Point *const reached = t.end;
        t.end = t.start;
        t.start = reached;
        EACH_LANE {
            const double quiet = quiet_for[i] + t.h[i];
            acts[i] = t.cut[i] >= 0;
            chased[i] = quiet < moment;
            if (acts[i])
                t.wait[i] = next_wait(t.wait[i], quiet, chased[i], first_wait);
            quiet_for[i] = acts[i] ? 0 : quiet;
        }
        int turns = 0;
        if (w->delays) {
            int next[LANES];
            const enum Status felt = feel_next_part(contact, w, step, s, next);
            if (felt != STATUS_OK)
                return felt;
            for (int i = 0; i < LANES; ++i) {
                acts[i] |= next[i];
                turns |= next[i];
            }
        }
        if (w->current_angle && w->law->event) {
            act_at_step_end(contact, w, t.h, acts, t.start);
            point_at(contact, w, s, t.start);
            take_law_side(contact, w, s, t.h, acts, t.start);
        }
        for (int i = 0; w->feedback && i < LANES; ++i)
            if (acts[i])
                forget_feedback(&t, i);
        if (event || turns) {
            act_in_lanes(contact, w, s, ahead, chased, acts, t.start);
            t.alike = 0;
        }
    }
    course->now = t.start == &room[0].point ? 0 : t.start == &room[1].point ? 1 : 2;
    course->known = !stopped;
    course->alike = t.alike;
    return STATUS_OK;
}
