/* What does the contact answer at one time, and on which side of each event is it? Knows no law and no effect by name.
 *
 * An event is a change of sign of an indicator. A point is evaluated on the sides that the contact holds, so that
 * within an internal step everything is smooth; the sides change only where an event is acted upon.
 */
#include "stages.h"

#include <math.h>

static int anywhere(const lanes flag)
{
    int any = 0;
    EACH_LANE
        any |= flag[i] != 0;
    return any;
}

/* All that a point out of contact needs while nobody looks: no force, bristles that relax. */
static void coast(const struct Configuration *w, struct Point *x)
{
    const double *const F_S = w->p[w->law->has_static ? VAR_F_S : VAR_F_C];
    EACH_LANE {
        x->k[i] = x->F[i] = x->N[i] = x->F_p[i] = x->F_f[i] = x->P_f[i] = x->P_s[i] = x->drive[i] = x->target[i] =
            x->clamped[i] = x->outside[i] = x->edge_p[i] = x->edge_f[i] = x->piece[i] = 0;
        x->rate[i] = w->p[VAR_RELEASE_TIME][i] >= NO_TIME ? 1 / w->p[VAR_RELEASE_TIME][i] : 0;
        x->F_C[i] = w->p[VAR_F_C][i];
        x->F_S[i] = F_S[i];
        x->P[i] = w->p[VAR_SIGMA0][i];
    }
    x->warnings = 0;
}

static void approach(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    path_at(contact, w, tau, x);
    EACH_LANE {
        x->cutting[i] = contact->sign[AT_CONTACT][i] > 0;
        x->law_side[i] = contact->sign[AT_LAW][i];
        x->stuck[i] = x->law_side[i] > 0;
        x->direction[i] = x->cutting[i] != 0 ? contact->sign[AT_SLIP][i] : x->v[i] < 0 ? -1 : 1;
        x->law[i] = 1;
        x->distance[i] = contact->value[VAR_SLIDING_DISTANCE][i];
    }
}

static void meet(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    pass_on(w, x);
    proxy_open(contact, w, tau, x);
}

/* Motion and temperature: all that does not wait for the bristle. */
void engage_point(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    approach(contact, w, tau, x);
    meet(contact, w, tau, x);
}

/* The same of a step's middle and end: how much of the motion reaches the contact goes by states that it has moved. */
void engage_step(const struct Contact *contact, const struct Configuration *w, const lanes h, const lanes half,
                 const lanes whole, const struct Point *start, struct Point *middle, struct Point *end)
{
    approach(contact, w, half, middle);
    approach(contact, w, whole, end);
    move_states(w, DRIVEN_BY_APPROACH, h, start, middle, end);
    meet(contact, w, half, middle);
    meet(contact, w, whole, end);
}

/* Stages up to the rates, z given in x. passing: a point within a step, whose outputs nobody looks at. */
INLINED void open_point(const struct Contact *contact, const struct Configuration *w, const lanes tau, int passing,
                        struct Point *x)
{
    if (passing && !anywhere(x->cutting)) {
        coast(w, x);
        return;
    }
    if (w->current_angle) {
        friction_solved(contact, w, tau, x);
        return;
    }
    load_at(contact, w, tau, x);
    friction_open(contact, w, tau, x);
    friction_rates(w, x);
}

void bend_point(const struct Configuration *w, struct Point *x)
{
    if (!anywhere(x->cutting))
        return;
    lanes limited; /* the damping is limited already */
    EACH_LANE
        limited[i] = x->limited[i];
    friction_rates(w, x);
    EACH_LANE
        x->limited[i] = limited[i];
}

/* The rest of the stages, once z is known. */
INLINED void close_point(const struct Contact *contact, const struct Configuration *w, int passing, struct Point *x)
{
    if (passing && !anywhere(x->cutting))
        return;
    if (w->law->indicator)
        w->law->indicator(w->law_p, contact->memory, x);
    friction_force(w, x);
    forces_at(w, x);
}

/* Where the slip is solved for, its reversal and the law's event lie inside the solution and are not searched for; the
 * law's side changes at the end of steps (act_at_step_end). */
void indicators(const struct Configuration *w, const struct Point *x, lanes indicator[INDICATORS])
{
    EACH_LANE {
        indicator[AT_CONTACT][i] = x->contact[i];
        indicator[AT_SURFACE][i] = x->surface[i];
        indicator[AT_SLIP][i] = w->current_angle ? 1 : x->v[i];
        indicator[AT_LAW][i] = w->current_angle ? x->law_side[i] : x->law[i];
    }
}

/* Does event k matter to this lane? Out of contact only the contact itself does. */
int watched(const struct Contact *contact, int k, int i) { return k == AT_CONTACT || contact->sign[AT_CONTACT][i] > 0; }

void rest_law(const struct Configuration *w, lanes *memory)
{
    struct Point alike;
    EACH_LANE {
        alike.F_C[i] = w->p[VAR_F_C][i];
        alike.P[i] = w->p[VAR_SIGMA0][i];
    }
    w->law->rest(w->law_p, &alike, memory);
}

/* Bristles that are out of contact slide no longer, and those that have no release time are let go; doing it again
 * changes nothing. */
void let_go(struct Contact *contact, const struct Configuration *w)
{
    lanes fresh[MEMORY] = {{0}};
    if (w->law->rest)
        rest_law(w, fresh);
    EACH_LANE {
        if (contact->sign[AT_CONTACT][i] > 0)
            continue;
        contact->sign[AT_LAW][i] = 1;
        contact->follows[i] = contact->followed_slip[i] = 0;
        if (w->p[VAR_RELEASE_TIME][i] >= NO_TIME)
            continue;
        contact->value[VAR_BRISTLE_DEFLECTION][i] = 0;
        for (int n = 0; w->law->rest && n < MEMORY; ++n)
            contact->memory[n][i] = fresh[n][i];
        forget_states(contact, w, i);
    }
}

/* Take the side of every event from the indicators at x. Returns whether any changed. Out of contact the law has no
 * side to take: what let go of the work has nothing to slide on, and begins anew where it comes back. */
static int take_sides(struct Contact *contact, const struct Configuration *w, const struct Point *x)
{
    lanes now[INDICATORS];
    int changed = 0;
    indicators(w, x, now);
    EACH_LANE
        now[AT_LAW][i] = contact->sign[AT_CONTACT][i] > 0 ? now[AT_LAW][i] : 0;
    for (int k = 0; k < INDICATORS; ++k)
        EACH_LANE
            if (now[k][i] * contact->sign[k][i] < 0) {
                contact->sign[k][i] = -contact->sign[k][i];
                changed = 1;
            }
    return changed;
}

/* Of the point at tau what says its sides, where these are of the motion alone. */
static void motion_at(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    EACH_LANE
        x->z[i] = contact->value[VAR_BRISTLE_DEFLECTION][i];
    load_states(contact, w, x);
    recall_slip(contact, x);
    engage_point(contact, w, tau, x);
}

void point_at(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    motion_at(contact, w, tau, x);
    open_point(contact, w, tau, 0, x);
    close_point(contact, w, 0, x);
    measure(contact, w, x);
}

/* The point a little after tau, in all lanes or in none. Where forces move the path, what they move is led on with it:
 * the tool may come near by that alone. Not so in lanes that are chased: where contact pushes the tool away and its
 * path back, there is no side to take, and the path decides. */
static void point_ahead(const struct Contact *contact, const struct Configuration *w, const lanes tau,
                        const lanes ahead, const int chased[LANES], struct Point *x)
{
    lanes after;
    EACH_LANE
        after[i] = tau[i] + ahead[i];
    if (ahead[0] > 0 && !w->feedback && !w->current_angle && !w->law->indicator && !w->law->event) {
        motion_at(contact, w, after, x); /* nobody asks more of it */
        return;
    }
    if (!w->feedback || !(ahead[0] > 0)) {
        point_at(contact, w, after, x);
        return;
    }
    struct Point left;
    point_at(contact, w, after, &left);
    point_at(contact, w, tau, x);
    lead_states(w, DRIVEN_BY_FORCE, ahead, x);
    engage_point(contact, w, after, x);
    open_point(contact, w, after, 0, x);
    close_point(contact, w, 0, x);
    for (int i = 0; i < LANES; ++i)
        if (chased[i])
            copy_lane((lanes *)x, (const lanes *)&left, POINT_LANES, i);
}

/* Sides as the indicators shortly after tau say, until none changes: entry decides which surface and which way of slip
 * count. Shortly after, because an event that was searched for may lie a rounding error off; bristles with an event of
 * their own are led on with it. */
void settle_sides(struct Contact *contact, const struct Configuration *w, const lanes tau, const lanes ahead,
                  const int chased[LANES], struct Point *x)
{
    lanes after;
    EACH_LANE
        after[i] = tau[i] + ahead[i];
    for (int n = 0; n <= INDICATORS; ++n) {
        point_ahead(contact, w, tau, ahead, chased, x);
        if (w->law->event && ahead[0] > 0) {
            EACH_LANE
                x->z[i] += ahead[i] * x->dz[i];
            open_point(contact, w, after, 0, x);
            close_point(contact, w, 0, x);
        }
        if (!take_sides(contact, w, x))
            break;
    }
}

/* Act on an event at tau: sides anew, bristles that lost contact let go, the law's own event. Leaves the point at tau
 * in x. */
void act_on_event(struct Contact *contact, const struct Configuration *w, const lanes tau, const lanes ahead,
                  const int chased[LANES], struct Point *x)
{
    settle_sides(contact, w, tau, ahead, chased, x);
    let_go(contact, w);
    if (w->law->event) {
        w->law->event(w->law_p, x, contact->value[VAR_BRISTLE_DEFLECTION], contact->memory);
        settle_sides(contact, w, tau, ahead, chased, x);
    }
    point_at(contact, w, tau, x);
    if (!w->law->event)
        return;
    int again = 0; /* where the law has acted, its next event still lies ahead, however near */
    EACH_LANE
        if (x->law[i] > 0 && contact->sign[AT_LAW][i] < 0)
            contact->sign[AT_LAW][i] = again = 1;
    if (again)
        point_at(contact, w, tau, x);
}
