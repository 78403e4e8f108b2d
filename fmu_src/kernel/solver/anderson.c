/* With which forces does the next pass over a step begin, where forces move the tool? With a mean of those that passes
 * have begun with, weighed such that a linear answer would be met, and a share of what it misses: Anderson 1965 (not
 * read).
 *
 * The forces at middle and end move the tool there, and a pass finds others. Where friction is damped stiffly it
 * overshoots as many times over as the step is longer than the tool takes to follow its contact, and repeating it
 * settles nothing. Friction at two points is what is stiff; the chip's load at them follows, so that three differences
 * of passes serve. A pass that has led astray is taken back: its difference counts like any other, and by as many times
 * as it has missed more the next ones follow less of what they miss. A force without bristles jumps where the slip
 * turns, and has no such mean: there each pass begins with what the one before has led to, and its end alone counts.
 */
#include "../stages.h"

#include <math.h>

#define ASTRAY 2 /* times what the pass before has missed */
#define SAME 1e-20 /* share of a square: roundings */

static lanes *force_of(struct Point *middle, struct Point *end, int k)
{
    struct Point *const x = k < CHANNELS ? middle : end;
    return k % CHANNELS == 0 ? &x->F : k % CHANNELS == 1 ? &x->F_p : &x->F_f;
}

void begin_passes(const struct Configuration *w, const lanes h, const struct Point *start, struct Point *middle,
                  struct Point *end, struct Passes *p)
{
    p->mixes = w->law->relaxes || w->law->event != NULL;
    for (int i = 0; i < LANES; ++i) {
        p->count[i] = 0;
        p->first[i] = 1;
        p->share[i] = 1;
        p->miss[i] = INFINITY;
    }
    if (!p->mixes)
        return;
    *middle = *end = *start;
    for (int k = 0; k < PASSED_FORCES; ++k)
        for (int i = 0; i < LANES; ++i)
            p->begun[k][i] = force_of(middle, end, k)[0][i];
    move_states(w, DRIVEN_BY_FORCE, h, start, middle, end);
}

/* What lies between the pass that stands and another one is kept, the newest first. */
static void keep_difference(const double from[PASSED_FORCES], const double missed[PASSED_FORCES], struct Passes *p,
                            int i)
{
    p->count[i] = p->count[i] < DIFFERENCES ? p->count[i] + 1 : DIFFERENCES;
    for (int k = 0; k < PASSED_FORCES; ++k) {
        for (int age = DIFFERENCES - 1; age > 0; --age) {
            p->by_from[age][k][i] = p->by_from[age - 1][k][i];
            p->by_missed[age][k][i] = p->by_missed[age - 1][k][i];
        }
        p->by_from[0][k][i] = from[k] - p->from[k][i];
        p->by_missed[0][k][i] = missed[k] - p->missed[k][i];
    }
}

void note_pass(const lanes will_do, struct Point *middle, struct Point *end, struct Passes *p)
{
    for (int i = 0; i < LANES; ++i) {
        double from[PASSED_FORCES], missed[PASSED_FORCES], miss = 0;
        for (int k = 0; k < PASSED_FORCES; ++k) {
            from[k] = p->mixes || p->first[i] == 0 ? p->begun[k][i] : 0;
            missed[k] = force_of(middle, end, k)[0][i] - from[k];
            miss = p->mixes || k >= CHANNELS ? larger(miss, fabs(missed[k])) : miss;
        }
        p->astray[i] = p->mixes && p->first[i] == 0 && !(miss <= larger(ASTRAY * p->miss[i], will_do[i]));
        if (p->mixes && p->first[i] == 0 && miss < INFINITY)
            keep_difference(from, missed, p, i);
        p->first[i] = 0;
        if (p->astray[i]) {
            p->share[i] *= miss < INFINITY ? p->miss[i] / miss : 1e-3;
            continue;
        }
        p->miss[i] = miss;
        for (int k = 0; k < PASSED_FORCES; ++k) {
            p->from[k][i] = from[k];
            p->missed[k][i] = missed[k];
        }
    }
}

static double product(const lanes x[PASSED_FORCES], const lanes y[PASSED_FORCES], int i)
{
    double sum = 0;
    for (int k = 0; k < PASSED_FORCES; ++k)
        sum += x[k][i] * y[k][i];
    return sum;
}

/* Takes from what is missed all that differences between passes span, one after the other, and from where it begins
 * what goes with it. */
static void mix(const struct Passes *p, int i, double from[PASSED_FORCES], double missed[PASSED_FORCES])
{
    lanes by_from[DIFFERENCES][PASSED_FORCES], by_missed[DIFFERENCES][PASSED_FORCES];
    for (int m = 0; m < p->count[i]; ++m) {
        for (int k = 0; k < PASSED_FORCES; ++k) {
            by_from[m][k][i] = p->by_from[m][k][i];
            by_missed[m][k][i] = p->by_missed[m][k][i];
        }
        const double whole = product(by_missed[m], by_missed[m], i);
        for (int n = 0; n < m; ++n) {
            const double square = product(by_missed[n], by_missed[n], i),
                         share = square > 0 ? product(by_missed[m], by_missed[n], i) / square : 0;
            for (int k = 0; k < PASSED_FORCES; ++k) {
                by_from[m][k][i] -= share * by_from[n][k][i];
                by_missed[m][k][i] -= share * by_missed[n][k][i];
            }
        }
        const double square = product(by_missed[m], by_missed[m], i);
        double weight = 0;
        if (!(square > SAME * whole)) { /* no direction of its own */
            for (int k = 0; k < PASSED_FORCES; ++k)
                by_missed[m][k][i] = 0;
            continue;
        }
        for (int k = 0; k < PASSED_FORCES; ++k)
            weight += missed[k] * by_missed[m][k][i] / square;
        for (int k = 0; k < PASSED_FORCES; ++k) {
            from[k] -= weight * by_from[m][k][i];
            missed[k] -= weight * by_missed[m][k][i];
        }
    }
}

void begin_pass(const struct Configuration *w, const lanes h, const struct Point *start, struct Point *middle,
                struct Point *end, struct Passes *p)
{
    if (!p->mixes) { /* the last pass has moved the tool already */
        for (int k = 0; k < PASSED_FORCES; ++k)
            for (int i = 0; i < LANES; ++i)
                p->begun[k][i] = force_of(middle, end, k)[0][i];
        return;
    }
    struct Point at_middle = *middle, at_end = *end;
    for (int i = 0; i < LANES; ++i) {
        double from[PASSED_FORCES], missed[PASSED_FORCES];
        for (int k = 0; k < PASSED_FORCES; ++k) {
            from[k] = p->from[k][i];
            missed[k] = p->missed[k][i];
        }
        mix(p, i, from, missed);
        for (int k = 0; k < PASSED_FORCES; ++k) {
            p->begun[k][i] = from[k] + p->share[i] * missed[k];
            force_of(&at_middle, &at_end, k)[0][i] = p->begun[k][i];
        }
    }
    move_states(w, DRIVEN_BY_FORCE, h, start, &at_middle, &at_end);
    for (int k = 0; k < EFFECT_STATES; ++k)
        for (int i = 0; i < LANES; ++i) {
            middle->state[k][i] = at_middle.state[k][i];
            end->state[k][i] = at_end.state[k][i];
        }
}
