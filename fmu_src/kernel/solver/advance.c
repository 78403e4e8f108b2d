/* How does the contact get through a communication step? In internal steps that the tolerance chooses and that end at
 * events.
 *
 * An internal step sees the point at its start, middle and end on one and the same side of every event. Where an
 * indicator has changed its sign the step is cut there.
 */
#include "../stages.h"

#include <math.h>

/* Integral by Simpson's rule of what start, middle and end show. */
#define SUM(field) (sixth * (a->field[i] + 4 * m->field[i] + b->field[i]))

static void accumulate(struct Contact *contact, const struct Configuration *w, const lanes h, const struct Point *a,
                       const struct Point *m, const struct Point *b)
{
    lanes *value = contact->value;
    EACH_LANE {
        const double sixth = h[i] / 6;
        value[VAR_BRISTLE_DEFLECTION][i] = b->z[i];
        value[VAR_DISSIPATED_ENERGY][i] += SUM(P_f);
        value[VAR_SHEAR_ENERGY][i] += SUM(P_s);
        value[VAR_SLIDING_DISTANCE][i] += a->cutting[i] * SUM(speed);
        value[VAR_FRICTION_IMPULSE][i] += SUM(F);
        value[VAR_PRINCIPAL_IMPULSE][i] += SUM(F_p);
        value[VAR_FEED_IMPULSE][i] += SUM(F_f);
        value[VAR_NORMAL_IMPULSE][i] += SUM(N);
        value[VAR_CONTACT_TIME][i] += h[i] * a->cutting[i];
        value[VAR_MEASURED_FRICTION_IMPULSE][i] += SUM(measured[0]);
        value[VAR_MEASURED_PRINCIPAL_IMPULSE][i] += SUM(measured[1]);
        value[VAR_MEASURED_FEED_IMPULSE][i] += SUM(measured[2]);
        value[VAR_STEP_COUNT][i] += h[i] > 0;
        value[VAR_CLAMPED_COUNT][i] +=
            (h[i] > 0) & ((contact->at_bound[i] != 0) | ((b->cutting[i] != 0) & (b->clamped[i] + b->outside[i] > 0)));
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

/* One internal step while it is tried. */
struct Trial {
    struct Point *start, *middle, *end;
    lanes h, to_window;      /* its length [s]; nonzero where it ends with an averaging window */
    lanes aimed; /* the length with which it was to end where one of the cycle before had ended; 0: none */
    lanes next, difference; /* the step that the tolerance asks for [s], and what a lower order would change */
    double shortest; /* length at which the tolerance gives way [s] */
    int cut[LANES]; /* the event that h ends at, NO_EVENT or JUMP */
    int acted[LANES]; /* whether a jump at its start has been acted on and has changed no side */
    int fits[LANES]; /* whether it is within the tolerance */
    int failed[LANES]; /* whether a longer one was not */
};

#define AS_LONG 1.01 /* times what is wanted: as long as in the cycle before, where that had ended where it did */

/* Choose the next internal step of each lane: what the tolerance asks for, ended at the communication step, the
 * averaging window and where one of the cycle before has ended. Returns whether any lane is still on its way. */
static int choose_step(const struct Contact *contact, const struct Configuration *w, double step, const lanes s,
                       const lanes window_ends, struct Trial *t)
{
    int running = 0;
    lanes beat;
    look_for_beats(contact, w, s, beat);
    EACH_LANE {
        const double left = step - s[i], window = larger(window_ends[i] - contact->value[VAR_TIME][i] - s[i], 0);
        const double whole = smaller(left, window), wanted = smaller(contact->next_step[i], w->longest[i]);
        const int last = whole <= wanted;
        const double chosen = left <= 0            ? 0
                              : last               ? whole
                              : whole < 2 * wanted ? 0.5 * whole
                                                   : wanted; /* two even steps, not one and a remnant */
        /* not a beat just before the end, and then a step of roundings */
        const int aims = (beat[i] < (1 - 1e-6) * whole) & (beat[i] <= (t->failed[i] ? 1 : AS_LONG) * chosen);
        t->h[i] = aims ? beat[i] : chosen;
        t->to_window[i] = (left > 0) & last & (window <= left) & !aims;
        t->aimed[i] = aims ? t->h[i] : 0;
        /* the longer step that has failed there says what it said a cycle ago */
        t->next[i] =
            aims && !aims_at_event(contact, i) ? smaller(contact->next_step[i], beat[i]) : contact->next_step[i];
        running |= left > 0;
    }
    for (int i = 0; w->delays && i < LANES; ++i) {
        const double part = contact->late_until[i] - s[i];
        t->to_window[i] *= t->h[i] <= part;
        t->h[i] = smaller(t->h[i], part);
    }
    for (int i = 0; (w->looks_back || w->meets_again) && i < LANES; ++i) {
        const double chosen_step = t->h[i];
        if (step - s[i] > 0)
            t->h[i] = until_late_jump(contact, w, i, contact->value[VAR_TIME][i] + s[i], t->h[i], t->start);
        t->to_window[i] *= t->h[i] == chosen_step;
    }
    return running;
}

/* A step is tried again because some lanes ask for it: only they take what they have chosen, the others repeat the step
 * that they had. */
static void try_again(struct Contact *contact, const int asks[LANES], const lanes next)
{
    EACH_LANE
        contact->next_step[i] = asks[i] ? next[i] : contact->next_step[i];
}

static int all_finite(const struct Point *x)
{
    int lost = 0;
    EACH_LANE
        lost |= !(fabs(x->z[i]) < INFINITY) | !(fabs(x->F_p[i]) < INFINITY);
    return !lost;
}

/* Steps without end: contact that opens and closes at no speed, forces that chase one another. A stretch of time that
 * the steps pass in `few` where nothing happens may take so many times more. An ellipse takes up to 60 a cycle at the
 * usual tolerance, steps shrink with its fourth root, a law with events of its own may break bonds at each of them,
 * however small they are, so that these count as steps and not as events, and a ripple of friction over a long way has
 * thousands of periods. A record's samples may lie so near to one another that none of them alone shows it: the stretch
 * goes on over them.
 */
static void take_patience(const struct Contact *contact, const struct Configuration *w, struct Patience *p)
{
    const double few = 20, tolerance = w->p[VAR_RELATIVE_TOLERANCE][0],
                 tight = tolerance < USUAL_TOLERANCE ? sqrt(sqrt(USUAL_TOLERANCE / tolerance)) : 1,
                 usual = w->current_angle ? 1000 : 4000, breaks = w->law->rest ? 24 * usual : 0;
    const int goes_on = p->length > 0 && p->length < INFINITY;
    p->length = few * w->longest[0];
    p->most = (usual * tight + breaks) * (w->comes_back ? 100 : 1);
    p->most_events = 200;
    if (!goes_on) {
        p->begun = contact->value[VAR_TIME][0];
        p->taken = p->events = 0;
    }
}

/* Is the step that begins at s, the n-th of this communication step, one too many? The slowest lane counts; each lane
 * moves on in each step. Two steps are what a communication step takes in any case. */
static int worn_out(const struct Contact *contact, struct Patience *p, double step, const lanes s, double n)
{
    double slowest = INFINITY;
    EACH_LANE
        slowest = s[i] < step ? smaller(slowest, s[i]) : slowest;
    slowest += contact->value[VAR_TIME][0];
    if (slowest > p->begun + p->length) {
        p->begun = slowest;
        p->taken = p->events = 0;
    }
    p->taken += n >= 2;
    return p->taken > p->most || p->events > p->most_events;
}

static double shortest_step(const struct Configuration *w, double step)
{
    return larger(1e-12 * step, w->current_angle ? jump_time(w, 0) : 0);
}

static void compute(const struct Contact *contact, const struct Configuration *w, const lanes s, struct Trial *t)
{
    try_step(contact, w, s, t->h, t->start, t->middle, t->end, t->difference);
}

static int is_accurate(const struct Contact *contact, const struct Configuration *w, struct Trial *t)
{
    return accurate(contact, w, t->shortest, t->h, t->start, t->middle, t->end, t->difference, t->next, t->fits);
}

static int is_accurate_in_halves(const struct Contact *contact, const struct Configuration *w, const lanes s,
                                 struct Trial *t)
{
    return accurate_in_halves(contact, w, t->shortest, s, t->h, t->start, t->middle, t->end, t->next, t->fits);
}

/* The lanes that are beyond the tolerance ask for a shorter step. */
static void ask_again(struct Contact *contact, struct Trial *t)
{
    int misfits[LANES];
    EACH_LANE {
        misfits[i] = !t->fits[i];
        t->failed[i] |= misfits[i];
    }
    try_again(contact, misfits, t->next);
}

/* Is a lane beyond the tolerance, by forces that do not settle, at the step that would be tried again? The same step
 * says the same again. */
static int repeats(const struct Trial *t)
{
    int same = 0;
    EACH_LANE
        same |= !t->fits[i] & (t->h[i] > 0) & (t->h[i] <= t->shortest) & (t->next[i] >= t->h[i]);
    return same;
}

/* Which events fall into the step? It is cut short at the first; true where it is shorter then. */
static int cut_short(const struct Contact *contact, const struct Configuration *w, const lanes s, struct Trial *t)
{
    int known[LANES], asked[LANES], any = 0, shorter = 0;
    lanes wanted;
    for (int i = 0; i < LANES; ++i) {
        t->cut[i] = known[i] = NO_EVENT;
        wanted[i] = t->h[i];
    }
    if (!any_event(contact, w, t->start, t->middle, t->end))
        return 0;
    for (int i = 0; i < LANES; ++i) {
        cut_at_touch(contact, w, i, s, t->h, t->start, t->middle, t->end, t->cut);
        asked[i] = t->cut[i] == NO_EVENT && t->h[i] > 0 && sees_event(contact, w, i, t->start, t->middle, t->end);
        any |= asked[i];
    }
    if (any)
        cut_at_events(contact, w, asked, known, t->acted, s, t->h, t->start, t->middle, t->end, t->cut);
    for (int i = 0; i < LANES; ++i) {
        shorter |= t->h[i] < wanted[i];
        t->to_window[i] *= t->cut[i] == NO_EVENT;
    }
    return shorter;
}

/* A step that was cut short is computed anew, and may show an event that the long one had at both of its ends, as a
 * narrow band of sticking; 0 where it is beyond the tolerance. */
static int settle(const struct Contact *contact, const struct Configuration *w, const lanes s, struct Trial *t)
{
    int shorter = 1;
    for (int tries = 0; shorter && tries < INDICATORS; ++tries) {
        int known[LANES], asked[LANES];
        lanes wanted;
        compute(contact, w, s, t);
        if (!is_accurate(contact, w, t) || !is_accurate_in_halves(contact, w, s, t))
            return 0;
        shorter = 0;
        for (int i = 0; i < LANES; ++i) {
            asked[i] = t->cut[i] >= 0;
            known[i] = t->cut[i];
            t->cut[i] = NO_EVENT;
            wanted[i] = t->h[i];
        }
        cut_at_events(contact, w, asked, known, t->acted, s, t->h, t->start, t->middle, t->end, t->cut);
        for (int i = 0; i < LANES; ++i) {
            t->cut[i] = t->cut[i] >= 0 ? t->cut[i] : known[i];
            shorter |= t->h[i] < wanted[i];
        }
    }
    if (shorter)
        compute(contact, w, s, t);
    return 1;
}

/* Where has the step of a lane ended, that now stands at s? An event that it aimed at in vain is none any more. */
static enum Ended ended_at(const struct Contact *contact, const struct Trial *t, double step, double s, int i)
{
    const int aimed = t->aimed[i] > 0 && t->h[i] == t->aimed[i], at_event = aimed && aims_at_event(contact, i);
    if (t->cut[i] >= 0 && t->cut[i] != AT_LAW)
        return at_event ? AT_EVENT_AS_BEFORE : AT_NEW_EVENT;
    const int elsewhere = t->cut[i] >= 0 || at_event || t->to_window[i] != 0 || s == step;
    return elsewhere || !(aimed || t->failed[i]) ? ENDED_ELSEWHERE : BY_TOLERANCE;
}

/* The step is taken: s moves on, and with it the integrals, the history and the averaging windows. What ends the
 * communication step by a rounding does not stand where the next one begins. */
static enum Status take(struct Contact *contact, const struct Configuration *w, double step, lanes s, struct Trial *t,
                        struct Course *course)
{
    EACH_LANE
        contact->next_step[i] = t->next[i];
    warn(contact, t->end);
    measure_step(contact, w, t->h, t->start, t->middle, t->end);
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
        if (t->h[i] > 0 && keeps_rhythm(w, i))
            note_beat(contact, w, i, contact->value[VAR_TIME][i] + s[i], t->h[i], ended_at(contact, t, step, s[i], i));
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
static void act_on_jump(struct Contact *contact, const struct Configuration *w, const lanes s, double ahead,
                        const int chased[LANES], const int acts[LANES], struct Trial *t)
{
    lanes before[INDICATORS];
    for (int i = 0; i < LANES; ++i)
        copy_lane(before, (const lanes *)contact->sign, INDICATORS, i);
    act_in_lanes(contact, w, s, ahead, chased, acts, t->start);
    for (int i = 0; i < LANES; ++i) {
        int same = acts[i];
        for (int k = 0; k < INDICATORS; ++k)
            same &= before[k][i] == contact->sign[k][i];
        t->acted[i] |= same;
    }
}

enum Status advance_internal(struct Contact *contact, const struct Configuration *w, double step, int stop_at_events,
                             lanes s, struct Course *course)
{
    struct Patience *const patience = &course->patience;
    const double most_steps = course->most_steps > 0 ? course->most_steps : INFINITY;
    struct Room *const room = course->room;
    static const int other[3][2] = {{1, 2}, {2, 0}, {0, 1}};
    struct Trial t = {.start = &room[course->now].point,
                      .middle = &room[other[course->now][0]].point,
                      .end = &room[other[course->now][1]].point,
                      .shortest = shortest_step(w, step)};
    int jumps = 0, stopped = 0, acts[LANES], chased[LANES] = {0};
    lanes quiet_for;
    EACH_LANE {
        quiet_for[i] = INFINITY; /* since the last event [s] */
        t.acted[i] = t.failed[i] = 0;
    }
    take_patience(contact, w, patience);
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
    const double ahead = w->kinematics == KINEMATICS_EXTERNAL ? 1e-14 * step : 1e-9 / w->p[VAR_VIBRATION_FREQUENCY][0];
    if (!course->known) {
        point_at(contact, w, s, t.start);
        let_go(contact, w);
        EACH_LANE {
            t.start->z[i] = contact->value[VAR_BRISTLE_DEFLECTION][i];
            course->window_end[i] = window_end(contact, i);
        }
    }
    course->known = 0;
    for (double n = 0; choose_step(contact, w, step, s, course->window_end, &t); ++n) {
        if (n >= most_steps || worn_out(contact, patience, step, s, n))
            return STATUS_TOO_MANY_STEPS;
        compute(contact, w, s, &t);
        if (!all_finite(t.end))
            return STATUS_DIVERGED;
        if (!is_accurate(contact, w, &t)) {
            if (repeats(&t))
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
        if (shorter ? !settle(contact, w, s, &t) : !is_accurate_in_halves(contact, w, s, &t)) {
            ask_again(contact, &t);
            continue;
        }
        const int event = is_any(t.cut, 0);
        patience->events += event && !(w->law->rest && is_only(t.cut, AT_LAW));
        const enum Status taken = take(contact, w, step, s, &t, course);
        EACH_LANE
            t.acted[i] = t.failed[i] = 0;
        if (taken != STATUS_OK)
            return taken;
        stopped = event && stop_at_events;
        if (stopped)
            break;
        struct Point *const reached = t.end;
        t.end = t.start;
        t.start = reached;
        EACH_LANE {
            const double quiet = quiet_for[i] + t.h[i];
            acts[i] = t.cut[i] >= 0;
            chased[i] = quiet < ahead;
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
        if (event || turns)
            act_in_lanes(contact, w, s, ahead, chased, acts, t.start);
    }
    course->now = t.start == &room[0].point ? 0 : t.start == &room[1].point ? 1 : 2;
    course->known = !stopped;
    return STATUS_OK;
}
