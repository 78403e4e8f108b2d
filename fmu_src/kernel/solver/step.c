/* What does one internal step make of a point? A trial: middle and end from the start, on one and the same side of
 * every event. */
#include "../stages.h"

#include <math.h>
#include <string.h>

/* Does a state of an effect follow a slip that is solved for? */
static inline int follows_slip(const struct Configuration *w, int i)
{
    return w->current_angle && w->acting[i] >> DRIVEN_BY_MOTION & 1;
}

/* How far a pass has moved the states that follow a slip which is solved for, in units of what is allowed. */
static double moved_states(double allowed, const struct Point *x, const lanes *before, int i)
{
    double worst = 0;
    for (int k = 0; k < EFFECT_STATES; ++k) {
        const double move = fabs(x->state[k][i] - before[k][i]);
        worst = move > 0 ? larger(worst, move / (allowed * fabs(x->state[k][i]))) : worst;
    }
    return worst;
}

/* What passes may still miss of the forces [N]: never 0, so that where a load and all that is in proportion to it
 * vanish, passes that miss nothing are done. */
static double enough(const struct Configuration *w, const struct Point *x, int i)
{
    return larger(1e-3 * w->p[VAR_RELATIVE_TOLERANCE][i] *
                      larger(larger(x->F_C[i], x->F_S[i]), larger(fabs(x->F[i]), fabs(x->F_p[i]))),
                  1e-300);
}

/* What a pass may move, as the one before has left it. */
struct PassBefore {
    lanes z, state[EFFECT_STATES];
};

static void note_before(const struct Configuration *w, const struct Point *end, struct PassBefore *before)
{
    memcpy(before->z, end->z, sizeof before->z);
    if (w->current_angle && w->drivers)
        memcpy(before->state, end->state, sizeof before->state);
}

/* How far a pass has moved what it repeats for, in units of what is allowed: the deflection, where the slip is solved
 * for, and where forces feed back these, at the middle as well as at the end: as much of it as comes back. */
static double moved(const struct Configuration *w, const struct Point *x, const struct PassBefore *before,
                    const struct Passes *passes, double gain, int i)
{
    const double allowed = 1e-3 * w->p[VAR_RELATIVE_TOLERANCE][i];
    const double of_z = w->current_angle ? fabs(x->z[i] - before->z[i]) / (allowed * larger(fabs(x->z[i]), 1e-300)) : 0;
    if (!w->feedback)
        return follows_slip(w, i) ? larger(of_z, moved_states(allowed, x, before->state, i)) : of_z;
    return passes->astray[i] || !(gain < INFINITY) ? INFINITY : larger(of_z, gain * passes->miss[i] / enough(w, x, i));
}

/* How far the contact has slid at middle and end, by the parabola of its speed: effects may ask. */
static void slide(const lanes h, const struct Point *a, struct Point *m, struct Point *b)
{
    EACH_LANE {
        const double s_0 = a->cutting[i] * a->speed[i], s_m = m->cutting[i] * m->speed[i],
                     s_1 = b->cutting[i] * b->speed[i];
        m->distance[i] = a->distance[i] + h[i] / 24 * (5 * s_0 + 8 * s_m - s_1);
        b->distance[i] = a->distance[i] + h[i] / 6 * (s_0 + 4 * s_m + s_1);
    }
}

/* Where the slip is solved for, the motion alone says less than the pass before has found, of a temperature proxy that
 * is the slip, too. */
static void slip_as_solved(const struct Configuration *w, struct Point *x)
{
    EACH_LANE
        if (!isnan(x->solved_slip[i])) {
            x->v[i] = x->solved_slip[i];
            x->direction[i] = x->v[i] < 0 ? -1 : 1;
            x->speed[i] = fabs(x->v[i]);
            if (w->proxy_source == PROXY_IS_SLIP_SPEED)
                x->theta_given[i] = x->cutting[i] * x->speed[i];
        }
}

/* The stages up to the rates at middle and end, with the z and the states that stand there. */
static INLINED void open_step(const struct Contact *contact, const struct Configuration *w, const lanes s,
                              const lanes h, const struct Point *start, struct Point *middle, struct Point *end)
{
    lanes half, whole;
    EACH_LANE {
        half[i] = s[i] + 0.5 * h[i];
        whole[i] = s[i] + h[i];
    }
    engage_step(contact, w, h, half, whole, start, middle, end);
    if (w->on_count > 0 && w->current_angle) {
        slip_as_solved(w, middle);
        slip_as_solved(w, end);
    }
    if (w->on_count > 0)
        slide(h, start, middle, end);
    move_states(w, DRIVEN_BY_MOTION, h, start, middle, end);
    open_point(contact, w, half, 1, middle);
    open_point(contact, w, whole, 1, end);
}

/* A slip that is solved for depends on z, and within its bounds its linearised rate may be some hundred times that at a
 * bound, with a target as much nearer: what a step makes of both lies off the way of either, and passes go round
 * between them. A rate linearised at z may be any, as long as z goes by it: there the largest of the three holds, with
 * laws that relax towards a target. */
#define APART 10

static int kinks(const struct Point *a, const struct Point *m, const struct Point *b, lanes top)
{
    int any = 0;
    EACH_LANE {
        const double low = smaller(smaller(a->rate[i], m->rate[i]), b->rate[i]),
                     high = larger(larger(a->rate[i], m->rate[i]), b->rate[i]);
        const int apart = (a->cutting[i] != 0) & (low * APART < high);
        top[i] = apart ? high : 0;
        any |= apart;
    }
    return any;
}

static struct Point raised(const struct Point *x, const lanes top)
{
    struct Point raised = *x;
    EACH_LANE
        if (top[i] > x->rate[i]) {
            raised.drive[i] += (top[i] - x->rate[i]) * x->z[i];
            raised.rate[i] = top[i];
            raised.target[i] = raised.drive[i] / top[i];
        }
    return raised;
}

/* By the rates at start, middle and end. */
static void bend(const struct Configuration *w, const lanes h, const struct Point *start, struct Point *middle,
                 struct Point *end, lanes difference)
{
    lanes top;
    if (w->current_angle && w->law->relaxes && kinks(start, middle, end, top)) {
        const struct Point a = raised(start, top), m = raised(middle, top), b = raised(end, top);
        bristle_step(1, 0, h, &a, &m, &b, middle->z, end->z, difference);
    } else
        bristle_step(w->law->relaxes || w->current_angle, !w->current_angle, h, start, middle, end, middle->z, end->z,
                     difference);
}

/* The bristle's new z again, from rates that go by the z of the pass before. Nothing else there depends on it. */
static void bend_again(const struct Configuration *w, const lanes h, const struct Point *start, struct Point *middle,
                       struct Point *end, lanes difference)
{
    bend_point(w, middle);
    bend_point(w, end);
    bristle_step(w->law->relaxes, 1, h, start, middle, end, middle->z, end->z, difference);
}

/* Passes in which none has come closer by a tenth than one before: it goes round, as where the slip jumps. */
#define ROUNDABOUT 6
#define MOST_PASSES 30

/* How the passes of a step come to an end. A lane that is done keeps its bits, whatever the others still do. */
struct Settling {
    int settled[LANES], done[LANES], nearest[LANES];
    lanes last, least;
};

static void begin_settling(struct Settling *x)
{
    memset(x, 0, sizeof *x);
    EACH_LANE
        x->last[i] = x->least[i] = INFINITY;
}

/* The n-th pass has moved a lane by `now`. Where passes come closer by the same ratio again, or faster (`linearised`),
 * the one that settles need not be made to be seen. */
static void note_moved(const struct Configuration *w, double now, int n, int linearised, int i, struct Settling *x)
{
    const double ratio = n > 0 ? smaller(now / x->last[i], 1) : 1;
    x->settled[i] = !w->iterated[i] || now <= 1 || (linearised && now * ratio <= 0.01);
    x->last[i] = now;
    if (now < 0.9 * x->least[i]) {
        x->least[i] = now;
        x->nearest[i] = n;
    }
    x->done[i] = x->settled[i] || n - x->nearest[i] >= ROUNDABOUT;
}

static int all_done(const struct Settling *x)
{
    int all = 1;
    EACH_LANE
        all &= x->done[i];
    return all;
}

/* Where rates go by the deflection: from z to rates to z, all else standing. `difference` is infinite where they have
 * not settled on one. */
static void settle_deflection(const struct Configuration *w, const lanes h, const struct Point *start,
                              struct Point *middle, struct Point *end, lanes difference)
{
    struct Settling at;
    struct {
        lanes middle, end;
    } rates_of = {{0}, {0}}, z = {{0}, {0}}; /* the deflections that rates are of, and what these made of them, */
    lanes shown = {0};                       /* when a lane was done */
    begin_settling(&at);
    for (int n = 0; n < MOST_PASSES && !all_done(&at); ++n) {
        EACH_LANE {
            rates_of.middle[i] = chosen_of(at.done[i], rates_of.middle[i], middle->z[i]);
            rates_of.end[i] = chosen_of(at.done[i], rates_of.end[i], end->z[i]);
        }
        if (n == 0)
            bend(w, h, start, middle, end, difference);
        else
            bend_again(w, h, start, middle, end, difference);
        EACH_LANE {
            z.middle[i] = chosen_of(at.done[i], z.middle[i], middle->z[i]);
            z.end[i] = chosen_of(at.done[i], z.end[i], end->z[i]);
            shown[i] = chosen_of(at.done[i], shown[i], difference[i]);
        }
        for (int i = 0; i < LANES; ++i)
            if (!at.done[i]) {
                const double allowed = 1e-3 * w->p[VAR_RELATIVE_TOLERANCE][i] * larger(fabs(end->z[i]), 1e-300);
                note_moved(w, fabs(end->z[i] - rates_of.end[i]) / allowed, n, 1, i, &at);
            }
    }
    if (LANES > 1) { /* lanes that were done have gone on with the others */
        memcpy(middle->z, rates_of.middle, sizeof middle->z);
        memcpy(end->z, rates_of.end, sizeof end->z);
        bend_point(w, middle);
        bend_point(w, end);
        memcpy(middle->z, z.middle, sizeof middle->z);
        memcpy(end->z, z.end, sizeof end->z);
    }
    EACH_LANE
        difference[i] = at.settled[i] ? shown[i] : INFINITY;
}

/* All stages there, and from their rates the bristle's new z. */
static INLINED void pass(const struct Contact *contact, const struct Configuration *w, const lanes s, const lanes h,
                         const struct Point *start, struct Point *middle, struct Point *end, lanes difference)
{
    if (!w->held)
        open_step(contact, w, s, h, start, middle, end);
    if (w->feedback && !w->current_angle && (w->yields || w->bends))
        settle_deflection(w, h, start, middle, end, difference);
    else
        bend(w, h, start, middle, end, difference);
    if (w->iterates && !w->feedback)
        return;
    close_point(contact, w, 1, middle);
    close_point(contact, w, 1, end);
}

/* z after t at the rate that is linearised at the start, which out of contact has no dz of its own. Where the level
 * vanishes with the load a bristle may follow it faster than the shortest step, and bends no further than it. */
static double led_on(int relaxes, const struct Point *start, int i, double t)
{
    const double D = relaxes ? t * start->rate[i] : 0, z = start->z[i];
    double I[3];
    moments(D, I);
    const double dz = start->drive[i] - start->rate[i] * z, moved = z + t * dz * (D > 0 ? I[0] / D : 1);
    const double bound = relaxes ? larger(reach_of(start, i), fabs(z)) : INFINITY;
    return larger(smaller(moved, bound), -bound);
}

/* Where a slip that is solved for jumps, or begins at an edge where force and load are both 0, rates before and behind
 * go into no step: the shortest of steps go straight on from their start. */
static void go_straight(const struct Contact *contact, const struct Configuration *w, const lanes s, const lanes h,
                        const int brief[LANES], const struct Point *start, struct Point *middle, struct Point *end)
{
    struct Point half = *start, whole = *start;
    for (int i = 0; i < LANES; ++i) {
        half.z[i] = led_on(w->law->relaxes, start, i, 0.5 * h[i]);
        whole.z[i] = led_on(w->law->relaxes, start, i, h[i]);
    }
    open_step(contact, w, s, h, start, &half, &whole);
    close_point(contact, w, 1, &half);
    close_point(contact, w, 1, &whole);
    move_states(w, DRIVEN_BY_FORCE, h, start, &half, &whole);
    copy_points(middle, &half, brief);
    copy_points(end, &whole, brief);
}

/* How much comes back of what a first pass misses, where that is asked. */
static double first_gain(const struct Feedback *known, double h, int i)
{
    return known && known->first_may_do && known->predicted[i] != 0 ? loop_gain(known, h, i) : INFINITY;
}

/* Where rates go by the deflection, and forces move nothing. */
static void settle_rates(const struct Contact *contact, const struct Configuration *w, const lanes s, const lanes h,
                         const struct Point *start, struct Point *middle, struct Point *end, lanes difference)
{
    if (!w->held)
        open_step(contact, w, s, h, start, middle, end);
    settle_deflection(w, h, start, middle, end, difference);
    close_point(contact, w, 1, middle);
    close_point(contact, w, 1, end);
}

/* Where forces move the path, or the slip is solved for: passes through all stages. */
static void settle_stages(const struct Contact *contact, const struct Configuration *w, const lanes s, const lanes h,
                          const struct Point *start, struct Feedback *known, struct Point *middle, struct Point *end,
                          lanes difference)
{
    struct Settling at;
    int some = 0;
    lanes kept_difference = {0};
    struct Point kept[2]; /* of lanes that are done while others go on */
    struct Passes passes;
    if (w->feedback)
        begin_passes(w, h, start, known, middle, end, &passes);
    begin_settling(&at);
    for (int n = 0; n < MOST_PASSES && !all_done(&at); ++n) {
        struct PassBefore before;
        note_before(w, end, &before);
        if (some) {
            kept[0] = *middle;
            kept[1] = *end;
            memcpy(kept_difference, difference, sizeof kept_difference);
        }
        if (n > 0 && w->feedback)
            begin_pass(w, h, start, middle, end, &passes);
        pass(contact, w, s, h, start, middle, end, difference);
        if (w->feedback) {
            lanes will_do;
            for (int i = 0; i < LANES; ++i)
                will_do[i] = enough(w, end, i);
            note_pass(will_do, middle, end, &passes);
        }
        if (some) {
            copy_points(middle, &kept[0], at.done);
            copy_points(end, &kept[1], at.done);
            copy_lanes((lanes *)difference, (const lanes *)kept_difference, 1, at.done);
        }
        int finished = n == MOST_PASSES - 1;
        for (int i = 0; i < LANES; ++i) {
            if (at.done[i])
                continue;
            const double gain = n > 0 ? 1 : first_gain(known, h[i], i);
            note_moved(w, moved(w, end, &before, &passes, gain, i), n, !w->feedback, i, &at);
            if (at.done[i] && known && w->feedback)
                note_feedback(&passes, h[i], i, known);
            some |= at.done[i];
            finished |= at.done[i];
        }
        /* other states the next pass begins with are of forces that are mixed */
        if (w->feedback && (finished || !passes.mixes))
            move_states(w, DRIVEN_BY_FORCE, h, start, middle, end);
    }
    for (int i = 0; i < LANES; ++i) {
        const int shows = w->feedback || w->bends || w->yields || follows_slip(w, i);
        difference[i] = shows && !at.settled[i] ? INFINITY : difference[i];
    }
    if (w->feedback)
        return; /* closed by the last pass */
    close_point(contact, w, 1, middle);
    close_point(contact, w, 1, end);
}

static void keep_arrived(const lanes h, const lanes *from, int count, lanes *to)
{
    for (int k = 0; k < count; ++k)
        EACH_LANE
            to[k][i] = chosen_of(h[i] > 0, to[k][i], from[k][i]);
}

/* A lane that has arrived waits where it is, to the last bit. */
static void wait_where_arrived(const struct Configuration *w, const lanes h, const struct Point *start, struct Point *x)
{
    const int beside = w->drivers ? 0 : BESIDE_STATES;
    keep_arrived(h, &start->t, 1, &x->t);
    keep_arrived(h, (const lanes *)start + beside, POINT_LANES - beside, (lanes *)x + beside);
}

/* Where passes begin: at what the rate that is linearised at the start makes of the deflection. */
static void foresee(const lanes h, const struct Point *start, struct Point *middle, struct Point *end)
{
    EACH_LANE {
        const double half = exponential(-0.5 * h[i] * start->rate[i]), away = start->z[i] - start->target[i];
        const int known = fabs(start->target[i]) < INFINITY;
        middle->z[i] = known ? start->target[i] + away * half : start->z[i];
        end->z[i] = known ? start->target[i] + away * half * half : start->z[i];
    }
}

void try_alike(const struct Contact *contact, const struct Configuration *w, const lanes s, const lanes h,
               const struct Point *start, struct Feedback *known, struct Point *middle, struct Point *end,
               lanes difference)
{
    EACH_LANE {
        difference[i] = 0;
        middle->z[i] = end->z[i] = start->z[i];
        middle->solved_slip[i] = end->solved_slip[i] = start->solved_slip[i];
        middle->solved_slope[i] = end->solved_slope[i] = start->solved_slope[i];
    }
    for (int k = 0; w->drivers && k < EFFECT_STATES; ++k)
        EACH_LANE
            middle->state[k][i] = end->state[k][i] = start->state[k][i];
    if (w->iterates && w->law->relaxes && !w->feedback)
        foresee(h, start, middle, end);
    int brief[LANES], all_brief = 1, any_brief = 0;
    for (int i = 0; i < LANES; ++i) {
        brief[i] = w->current_angle && h[i] <= jump_time(w, i);
        all_brief &= brief[i];
        any_brief |= brief[i];
    }
    if (!all_brief && (w->feedback || w->current_angle))
        settle_stages(contact, w, s, h, start, known, middle, end, difference);
    else if (!all_brief && w->iterates)
        settle_rates(contact, w, s, h, start, middle, end, difference);
    else if (!all_brief)
        pass(contact, w, s, h, start, middle, end, difference);
    if (any_brief)
        go_straight(contact, w, s, h, brief, start, middle, end);
    for (int i = 0; any_brief && i < LANES; ++i)
        difference[i] = brief[i] ? 0 : difference[i];
    int arrived = 0;
    EACH_LANE
        arrived |= !(h[i] > 0);
    if (arrived && LANES > 1) {
        wait_where_arrived(w, h, start, middle);
        wait_where_arrived(w, h, start, end);
    }
}

void try_step(const struct Contact *contact, const struct Configuration *w, const lanes s, const lanes h,
              const struct Point *start, struct Feedback *known, struct Point *middle, struct Point *end,
              lanes difference)
{
    if (w->held)
        *middle = *end = *start;
    try_alike(contact, w, s, h, start, known, middle, end, difference);
}

static void copy_but_states(const struct Point *from, struct Point *to)
{
    const size_t begin = offsetof(struct Point, a);
    memcpy((char *)to + begin, (const char *)from + begin, sizeof *to - begin);
}

/* Where a time alone says what the rates are: those of middle and end stand, and only the quarters are new. */
static void halves_between(const struct Contact *contact, const struct Configuration *w, const lanes s,
                           const lanes step, const struct Point *start, const struct Point *middle,
                           const struct Point *end, struct Point *early, struct Point *half, struct Point *late,
                           struct Point *whole)
{
    const int relaxes = w->law->relaxes;
    lanes first, last, ignored;
    EACH_LANE {
        first[i] = s[i] + 0.5 * step[i];
        last[i] = s[i] + step[i] + 0.5 * step[i];
    }
    copy_but_states(middle, half);
    copy_but_states(end, whole);
    engage_point(contact, w, first, early);
    engage_point(contact, w, last, late);
    if (w->on_count > 0) {
        slide(step, start, early, half);
        slide(step, half, late, whole);
    }
    open_point(contact, w, first, 1, early);
    open_point(contact, w, last, 1, late);
    bristle_step(relaxes, 1, step, start, early, half, early->z, half->z, ignored);
    bristle_step(relaxes, 1, step, half, late, whole, late->z, whole->z, ignored);
    close_point(contact, w, 1, early);
    close_point(contact, w, 1, half);
    close_point(contact, w, 1, late);
    close_point(contact, w, 1, whole);
}

void try_halves(const struct Contact *contact, const struct Configuration *w, const lanes s, const lanes step,
                const struct Feedback *known, const struct Point *start, const struct Point *middle,
                const struct Point *end, struct Point *early, struct Point *half, struct Point *late,
                struct Point *whole)
{
    const int stand = !w->drivers && !w->held;
    int some = 0, all = 1;
    for (int i = 0; i < LANES; ++i) {
        some |= w->iterated[i];
        all &= w->iterated[i] != 0;
    }
    if (stand && !some) {
        halves_between(contact, w, s, step, start, middle, end, early, half, late, whole);
        return;
    }
    lanes from, ignored;
    EACH_LANE
        from[i] = s[i] + step[i];
    struct Feedback of_half[2];
    struct StepForces forces;
    for (int i = 0; w->feedback && i < LANES; ++i)
        note_forces(2 * step[i], start, middle, end, i, &forces);
    for (int k = 0; w->feedback && k < 2; ++k) {
        of_half[k] = *known;
        of_half[k].first_may_do = 1; /* halves show what the whole step has missed, and nobody goes on from them */
        for (int i = 0; i < LANES; ++i)
            predict_forces(&forces, k ? 0.75 : 0.25, k ? 1 : 0.5, i, &of_half[k]);
    }
    try_step(contact, w, s, step, start, w->feedback ? &of_half[0] : NULL, early, half, ignored);
    try_step(contact, w, from, step, half, w->feedback ? &of_half[1] : NULL, late, whole, ignored);
    if (!stand || all)
        return;
    struct Point own[4]; /* of the lanes that would do so alone */
    halves_between(contact, w, s, step, start, middle, end, &own[0], &own[1], &own[2], &own[3]);
    int direct[LANES];
    for (int i = 0; i < LANES; ++i)
        direct[i] = !w->iterated[i];
    copy_points(early, &own[0], direct);
    copy_points(half, &own[1], direct);
    copy_points(late, &own[2], direct);
    copy_points(whole, &own[3], direct);
}
