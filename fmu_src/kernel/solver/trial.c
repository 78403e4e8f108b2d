/* What becomes of an internal step before it is taken? It is chosen, computed, asked for its accuracy, and cut at the
 * first event that falls into it. */
#include "trial.h"

#include <math.h>

#define AS_LONG 1.01 /* times what is wanted: as long as in the cycle before, where that had ended where it did */

void begin_trials(const struct Configuration *w, double step, struct Trial *t)
{
    t->shortest = larger(1e-12 * step, w->current_angle ? jump_time(w, 0) : 0);
    EACH_LANE {
        const double window = w->p[VAR_AVERAGING_WINDOW][i];
        t->beside_window[i] = BESIDE_WINDOW * smaller(step, window > 0 ? window : w->longest[i]);
        t->acted[i] = t->failed[i] = 0;
    }
}

/* Where the slip is solved for, a law acts on its own event at the end of steps: none reaches further past one than the
 * tolerance, of a loaded bristle, at the slip where it starts [s]. */
static inline double until_law_event(const struct Configuration *w, const struct Point *x, int i)
{
    const double beyond = w->p[VAR_RELATIVE_TOLERANCE][i] * reach_of(x, i);
    return x->cutting[i] != 0 && x->law[i] > 0 ? (x->law[i] + beyond) / larger(x->speed[i], 1e-300) : INFINITY;
}

/* Choose the next internal step of each lane: what the tolerance asks for, ended at the communication step, the
 * averaging window and where one of the cycle before has ended. Returns whether any lane is still on its way. */
int choose_step(const struct Contact *contact, const struct Configuration *w, double step, const lanes s,
                const lanes window_ends, struct Trial *t)
{
    int running = 0;
    lanes breakpoint;
    look_for_breakpoints(contact, w, s, breakpoint);
    EACH_LANE {
        const double left = step - s[i];
        const double until = larger(window_ends[i] - contact->value[VAR_TIME][i] - s[i], 0),
                     window = until <= left + t->beside_window[i] ? smaller(until, left) : until;
        const double whole = smaller(left, window), wanted = smaller(contact->next_step[i], w->longest[i]);
        const int last = whole <= wanted;
        const double chosen = left <= 0            ? 0
                              : last               ? whole
                              : whole < 2 * wanted ? 0.5 * whole
                                                   : wanted; /* two even steps, not one and a remnant */
        /* not a breakpoint just before the end, and then a step of roundings */
        const int aims =
            (breakpoint[i] < (1 - 1e-6) * whole) & (breakpoint[i] <= (t->failed[i] ? 1 : AS_LONG) * chosen);
        t->h[i] = aims ? breakpoint[i] : chosen;
        t->to_window[i] = (left > 0) & last & (window <= left) & !aims;
        t->aimed[i] = aims ? t->h[i] : 0;
        /* the longer step that has failed there says what it said a cycle ago */
        t->next[i] =
            aims && !aims_at_event(contact, i) ? smaller(contact->next_step[i], breakpoint[i]) : contact->next_step[i];
        running |= left > 0;
    }
    for (int i = 0; w->current_angle && w->law->event && i < LANES; ++i) {
        const double most = larger(until_law_event(w, t->start, i), t->shortest);
        t->to_window[i] *= t->h[i] <= most;
        t->h[i] = smaller(t->h[i], most);
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

#define FARTHEST 2 /* lengths of the step before, as far as which forces go on as they did */

/* What the step before says of the feedback in this one. All lengths that are tried begin with the same: a lane does
 * not know how often others have asked it to try again. */
static void recall_feedback(struct Trial *t, int i)
{
    copy_lane((lanes *)&t->loop->latest, (const lanes *)&t->loop->known, FEEDBACK_LANES, i);
    const double share = t->loop->before.length[i] > 0 ? t->h[i] / t->loop->before.length[i] : INFINITY;
    if (share <= FARTHEST)
        predict_forces(&t->loop->before, 1 + 0.5 * share, 1 + share, i, &t->loop->latest);
}

void compute_trial(const struct Contact *contact, const struct Configuration *w, const lanes s, struct Trial *t)
{
    for (int i = 0; w->feedback && i < LANES; ++i)
        recall_feedback(t, i);
    if (t->alike && w->held)
        try_alike(contact, w, s, t->h, t->start, NULL, t->middle, t->end, t->difference);
    else
        try_step(contact, w, s, t->h, t->start, w->feedback ? &t->loop->latest : NULL, t->middle, t->end,
                 t->difference);
    t->alike = w->held;
}

void forget_feedback(struct Trial *t, int i)
{
    t->loop->known.predicted[i] = t->loop->known.count[i] = 0;
    t->loop->before.length[i] = 0;
}

void keep_feedback(struct Trial *t, int i)
{
    if (!(t->difference[i] < INFINITY)) {
        forget_feedback(t, i);
        return;
    }
    copy_lane((lanes *)&t->loop->known, (const lanes *)&t->loop->latest, FEEDBACK_LANES, i);
    t->loop->known.predicted[i] = 0;
    note_forces(t->h[i], t->start, t->middle, t->end, i, &t->loop->before);
}

/* A step is tried again because some lanes ask for it: only they take what they have chosen, the others repeat the step
 * that they had. */
static void try_again(struct Contact *contact, const int asks[LANES], const lanes next)
{
    EACH_LANE
        contact->next_step[i] = asks[i] ? next[i] : contact->next_step[i];
}

/* The lanes that are beyond the tolerance ask for a shorter step. */
void ask_again(struct Contact *contact, struct Trial *t)
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
int trial_repeats(const struct Trial *t)
{
    int same = 0;
    EACH_LANE
        same |= !t->fits[i] & (t->h[i] > 0) & (t->h[i] <= t->shortest) & (t->next[i] >= t->h[i]);
    return same;
}

/* The lanes that start on the other side of an event than they hold, as where an input has jumped. It may come back
 * before the middle of the step, which then shows nothing of it. */
static int look_for_jumps(const struct Contact *contact, const struct Configuration *w, const struct Trial *t,
                          int cut[LANES])
{
    lanes now[INDICATORS];
    int any = 0;
    indicators(w, t->start, now);
    for (int i = 0; i < LANES; ++i)
        for (int k = 0; k < INDICATORS; ++k)
            if (contact->sign[k][i] * now[k][i] < 0 && watched(contact, k, i)) {
                cut[i] = JUMP;
                any = 1;
            }
    return any;
}

/* Which events fall into the step? It is cut short at the first; true where it is shorter then. */
int cut_short(const struct Contact *contact, const struct Configuration *w, const lanes s, struct Trial *t)
{
    int known[LANES], asked[LANES], any = 0, shorter = 0;
    lanes wanted;
    for (int i = 0; i < LANES; ++i) {
        t->cut[i] = known[i] = NO_EVENT;
        wanted[i] = t->h[i];
    }
    const int first = t->first;
    t->first = 0;
    if (first && look_for_jumps(contact, w, t, t->cut))
        return 0;
    if (!any_event(contact, w, t->start, t->middle, t->end))
        return 0;
    for (int i = 0; i < LANES; ++i) {
        cut_at_touch(contact, w, i, s, t->h, t->start, t->middle, t->end, t->cut);
        asked[i] = t->cut[i] == NO_EVENT && t->h[i] > 0 && sees_event(contact, w, i, t->start, t->middle, t->end);
        any |= asked[i];
    }
    if (any)
        cut_at_events(contact, w, asked, known, t->acted, t->wait, s, t->h, t->start, t->middle, t->end, t->cut);
    for (int i = 0; i < LANES; ++i) {
        shorter |= t->h[i] < wanted[i];
        t->to_window[i] *= t->cut[i] == NO_EVENT;
    }
    return shorter;
}

/* A step that was cut short is computed anew, and may show an event that the long one had at both of its ends, as a
 * narrow band of sticking; 0 where it is beyond the tolerance. */
int settle_cut(const struct Contact *contact, const struct Configuration *w, const lanes s, struct Trial *t)
{
    int shorter = 1;
    for (int tries = 0; shorter && tries < INDICATORS; ++tries) {
        int known[LANES], asked[LANES];
        lanes wanted;
        compute_trial(contact, w, s, t);
        if (!trial_is_accurate(contact, w, t) || !halves_are_accurate(contact, w, s, t))
            return 0;
        shorter = 0;
        for (int i = 0; i < LANES; ++i) {
            asked[i] = t->cut[i] >= 0;
            known[i] = t->cut[i];
            t->cut[i] = NO_EVENT;
            wanted[i] = t->h[i];
        }
        cut_at_events(contact, w, asked, known, t->acted, t->wait, s, t->h, t->start, t->middle, t->end, t->cut);
        for (int i = 0; i < LANES; ++i) {
            t->cut[i] = t->cut[i] >= 0 ? t->cut[i] : known[i];
            shorter |= t->h[i] < wanted[i];
        }
    }
    if (shorter)
        compute_trial(contact, w, s, t);
    return 1;
}

/* Where has the step of a lane ended, that now stands at s? An event that it aimed at in vain is none any more. */
enum Ended ended_at(const struct Contact *contact, const struct Trial *t, double step, double s, int i)
{
    const int aimed = t->aimed[i] > 0 && t->h[i] == t->aimed[i], at_event = aimed && aims_at_event(contact, i);
    if (t->cut[i] >= 0 && t->cut[i] != AT_LAW)
        return at_event ? AT_EVENT_AS_BEFORE : AT_NEW_EVENT;
    const int elsewhere = t->cut[i] >= 0 || at_event || t->to_window[i] != 0 || s == step;
    return elsewhere || !(aimed || t->failed[i]) ? ENDED_ELSEWHERE : BY_TOLERANCE;
}
