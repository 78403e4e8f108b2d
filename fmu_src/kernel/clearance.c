/* Does the clearance face stand in the surface that is left, and how deep?
 *
 * It rises behind the tool tip by the clearance angle, straight and long. Sheared by that angle it is level, and the
 * tip stands at eta = y + x tan(gamma): what is deep in the surface is the height by which eta lies below the highest
 * place of the surface behind the tip, sheared alike. What lies more than one cycle's advance behind need not be looked
 * at: it was left one cycle earlier, has been cut since, and lies lower. All cycles are taken to be alike, as in
 * path.c.
 */
#include "stages.h"

#include <math.h>

#define LEAST_ANGLE 1e-7 /* [rad]: more than roundings of an angle */
#define NO_DEPTH 1e-9 /* [m]: some atoms */
#define NO_ADVANCE 1e-12 /* of a cycle, in amplitudes */

#define GOLDEN_SECTION 0.61803398874989485 /* (sqrt(5) - 1)/2 */

enum { PLACES = 64, NARROWER = 40 }; /* that are looked at, and golden sections beside the best of them */

/* A tool that has come to angle psi; lengths in m. */
struct Flank {
    const struct Turn *turn;
    int lane;
    double advance, a, b; /* of a radian, and amplitudes */
    double nominal, slope, level; /* surface; tan(gamma); eta of the tip */
    double psi;
};

static double along(const struct Flank *f, double psi)
{
    double cosine, sine;
    cos_sin_of(psi, &cosine, &sine);
    return f->advance * psi + f->a * sine;
}

static double height(const struct Flank *f, double psi)
{
    double cosine, sine;
    cos_sin_of(psi + f->turn->lead[f->lane], &cosine, &sine);
    return f->b * cosine;
}

/* Height of what the tool has left at a place until the angle `begun`. */
static double surface_at(const struct Flank *f, double begun, double place)
{
    const struct Turn *const t = f->turn;
    const double r = t->r[f->lane], top = r * t->last[f->lane] + t->bend[f->lane], X = smaller(place / f->a, top);
    const double lowest = lowest_left(t, f->lane, begun, X, floor((top - X) / (2 * PI * r)) - 1);
    return smaller(f->nominal, lowest < INFINITY ? f->b * lowest : INFINITY);
}

/* How deep the face stands in the surface at a place behind the tip, where the tip itself has just passed. */
static double depth_behind(const struct Flank *f, double place)
{
    return surface_at(f, f->psi + LEAST_ANGLE, place) + f->slope * place - f->level;
}

/* How deep the tip that moves back stands below what it had left until it turned. */
static double depth_of_tip(const struct Flank *f, double psi)
{
    return surface_at(f, f->turn->last[f->lane], along(f, psi)) - height(f, psi);
}

/* The largest value between two places: the best of many, and of those beside it. */
static double largest(double (*value)(const struct Flank *, double), const struct Flank *f, double from, double to)
{
    double best = -INFINITY, low = from, high = to;
    const double spacing = (to - from) / (double)PLACES;
    for (int n = 0; n <= PLACES; ++n) {
        const double at = from + n * spacing, there = value(f, at);
        if (there > best) {
            best = there;
            low = larger(at - spacing, from);
            high = smaller(at + spacing, to);
        }
    }
    for (int n = 0; n < NARROWER; ++n) {
        const double left = high - GOLDEN_SECTION * (high - low), right = low + GOLDEN_SECTION * (high - low),
                     at_left = value(f, left), at_right = value(f, right);
        best = larger(best, larger(at_left, at_right));
        if (at_left > at_right)
            high = right;
        else
            low = left;
    }
    return best;
}

/* A tool that never turns back: the surface behind is its own path, up to the nominal surface. */
static double without_separation(const struct Flank *f, double highest)
{
    if (height(f, f->psi) >= f->nominal)
        return 0;
    const double lead = f->turn->lead[f->lane], top = 2 * PI * floor((highest + lead) / (2 * PI)) - lead;
    const double begun = height(f, highest) > f->nominal ? top + acos(f->nominal / f->b) : highest;
    return height(f, begun) + f->slope * along(f, begun) - f->level;
}

/* It is deepest where eta is least, or while the tip moves back under the surface. */
static double with_separation(struct Flank *f, double highest)
{
    const double last = f->turn->last[f->lane], fell = f->psi - highest;
    const double turned = 2 * PI * floor((f->psi + last) / (2 * PI)); /* that psi lies within -last .. 2 pi - last */
    f->psi -= turned;
    f->level -= f->slope * f->advance * turned;
    const double place = along(f, f->psi);
    double depth = largest(depth_behind, f, place - 2 * PI * f->advance, place);
    for (int before = 0; before < 2; ++before) { /* this stroke back, and the one before */
        const double from = larger(f->psi - fell + 2 * PI * before, last),
                     to = smaller(f->psi + 2 * PI * before, 2 * PI - last);
        if (from < to)
            depth = larger(depth, largest(depth_of_tip, f, from, to));
    }
    return depth;
}

/* What the depth follows from: advance of a radian, amplitudes, nominal surface [m], phase of y, tan(gamma). */
enum Fact { ADVANCE, A, B, NOMINAL, LEAD, SLOPE };

static void facts_of(const struct Configuration *w, const struct Point *x, int i, double fact[FLANK_FACTS])
{
    const lanes *p = w->p;
    fact[ADVANCE] = p[VAR_CUTTING_SPEED][i] / (2 * PI * p[VAR_VIBRATION_FREQUENCY][i]);
    fact[A] = x->a[i];
    fact[B] = x->b[i];
    fact[NOMINAL] = p[VAR_FEED][i] - p[VAR_AMPLITUDE_Y][i] + x->raised[i] - x->centre_y[i];
    fact[LEAD] = x->phase_y[i] - p[VAR_PHASE_X][i] - PI / 2;
    fact[SLOPE] = w->tan_clearance[i];
}

/* At its deepest in a cycle [m]; 0: it does not. */
static double depth_of_flank(const struct Configuration *w, const double fact[FLANK_FACTS], int lane)
{
    const double slope = fact[SLOPE], a = fact[A], b = fact[B], r = a > 0 ? fact[ADVANCE] / a : INFINITY;
    double cosine, sine;
    cos_sin_of(fact[LEAD], &cosine, &sine);
    /* d eta / d psi = S cos(psi) + C sin(psi) + slope advance */
    const double S = slope * a - b * sine, C = -b * cosine, share = slope * fact[ADVANCE] / sqrt(S * S + C * C);
    if (!(r > NO_ADVANCE && share < 1)) /* it stays where it is, or eta never falls */
        return 0;
    const double turns_at = PI / 2 - acos(share), phase = atan2(S, C), highest = PI + turns_at - phase;
    struct Turn turn = w->turn;
    turn_at(w, r, fact[LEAD], a > 0 ? b / a : 0, &turn, lane);
    if (r < 1)
        valleys_at(&turn, lane);
    struct Flank f = {.turn = &turn,
                      .lane = lane,
                      .advance = fact[ADVANCE],
                      .a = a,
                      .b = b,
                      .nominal = fact[NOMINAL],
                      .slope = slope,
                      .psi = 2 * PI - turns_at - phase};
    f.level = height(&f, f.psi) + slope * along(&f, f.psi);
    return r < 1 ? with_separation(&f, highest) : without_separation(&f, highest);
}

void look_at_flank(struct Contact *contact, const struct Configuration *w, const struct Point *x)
{
    double depth = 0;
    for (int i = 0; i < LANES && w->kinematics != KINEMATICS_EXTERNAL; ++i) {
        double fact[FLANK_FACTS];
        int fresh = 0;
        if (!(w->tan_clearance[i] > 0) || contact->warnings & WARN_CLEARANCE)
            continue;
        facts_of(w, x, i, fact);
        for (int n = 0; n < FLANK_FACTS; ++n) {
            fresh |= contact->flank_of[n][i] != fact[n];
            contact->flank_of[n][i] = fact[n];
        }
        if (fresh)
            depth = larger(depth, depth_of_flank(w, fact, i));
    }
    if (depth > NO_DEPTH) {
        contact->flank_depth = depth;
        contact->warnings |= WARN_CLEARANCE;
    }
}
