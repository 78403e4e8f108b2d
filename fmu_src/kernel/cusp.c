/* How high are the cusps that the vibration leaves along the cut?
 *
 * Heights are in amplitudes b, places in amplitudes a, as in path.c. The surface that is left repeats itself with the
 * advance of a cycle, and its lowest places are the bottom of the path, at -b. Of an upright ellipse it is one forward
 * stroke after the other, which meet at the angle entry before the bottom: r (pi - entry) = sin(entry), cusps of 1 -
 * cos(entry). Of others all strokes count, and the highest of one advance's places is searched for.
 */
#include "stages.h"

#include <math.h>

#define NO_ADVANCE 1e-12 /* of a cycle, in amplitudes */
#define UPRIGHT 1e-9 /* [rad] */
#define GOLDEN_SECTION 0.61803398874989485 /* (sqrt(5) - 1)/2 */

enum { PLACES = 64, NARROWER = 45 }; /* that are looked at, and golden sections beside each that is highest there */

/* Newton's steps from 0 on a convex function that falls to its root. */
static double of_upright(double r)
{
    double entry = 0, sine = 0, cosine = 1;
    for (int n = 0; n < 60; ++n) {
        const double move = (r * (PI - entry) - sine) / (r + cosine);
        entry += move;
        cos_sin_of(entry, &cosine, &sine);
        if (!(move > 1e-15 * entry))
            break;
    }
    return 1 - cosine;
}

/* What is left at a place that the newest forward stroke has passed and none after it reaches. */
static double left_at(const struct Turn *turn, int lane, double place)
{
    const double top = turn->r[lane] * turn->last[lane] + turn->bend[lane];
    return lowest_left(turn, lane, turn->last[lane], place, floor((top - place) / (2 * PI * turn->r[lane])) - 1);
}

/* The highest between two places, among which there is one that rises and then falls. Each golden section looks at one
 * new place. */
static double highest_between(const struct Turn *turn, int lane, double low, double high)
{
    double left = high - GOLDEN_SECTION * (high - low), right = low + GOLDEN_SECTION * (high - low),
           at_left = left_at(turn, lane, left), at_right = left_at(turn, lane, right), best = larger(at_left, at_right);
    for (int n = 0; n < NARROWER; ++n) {
        if (at_left > at_right) {
            high = right;
            right = left;
            at_right = at_left;
            left = high - GOLDEN_SECTION * (high - low);
            at_left = left_at(turn, lane, left);
        } else {
            low = left;
            left = right;
            at_left = at_right;
            right = low + GOLDEN_SECTION * (high - low);
            at_right = left_at(turn, lane, right);
        }
        best = larger(best, larger(at_left, at_right));
    }
    return best;
}

/* Above the bottom of the path. */
static double highest(const struct Turn *turn, int lane)
{
    const double pitch = 2 * PI * turn->r[lane], from = -turn->r[lane] * turn->last[lane] - turn->bend[lane],
                 to = from + pitch, spacing = pitch / (double)PLACES;
    double best = -1, height[PLACES + 1];
    for (int n = 0; n < PLACES; ++n)
        height[n] = left_at(turn, lane, from + n * spacing);
    height[PLACES] = height[0]; /* where the next advance begins */
    for (int n = 0; n <= PLACES; ++n) {
        const double at = from + n * spacing, before = height[n > 0 ? n - 1 : PLACES - 1],
                     behind = height[n < PLACES ? n + 1 : 1];
        if (height[n] < before || height[n] < behind)
            continue;
        const double beside = highest_between(turn, lane, larger(at - spacing, from), smaller(at + spacing, to));
        best = larger(best, larger(height[n], beside));
    }
    return 1 + best;
}

static double shape_of(const struct Configuration *w, double r, double lead, int lane)
{
    if (!(r > NO_ADVANCE))
        return 0;
    if (r >= 1)
        return 2;
    if (fabs(lead - PI) < UPRIGHT)
        return of_upright(r);
    struct Turn turn = w->turn;
    turn_at(w, r, lead, 1, &turn, lane);
    valleys_at(&turn, lane);
    return highest(&turn, lane);
}

void show_cusps(struct Contact *contact, const struct Configuration *w, const struct Point *x)
{
    const lanes *p = w->p;
    for (int i = 0; w->kinematics != KINEMATICS_EXTERNAL && i < LANES; ++i) {
        const double steady = p[VAR_CUTTING_SPEED][i] > 0 ? INFINITY : 0, r = x->a[i] > 0 ? x->speed_ratio[i] : steady,
                     lead = x->phase_y[i] - p[VAR_PHASE_X][i] - PI / 2, b = x->b[i];
        if (contact->cusp_of[0][i] != r || contact->cusp_of[1][i] != lead) {
            contact->cusp[i] = shape_of(w, r, lead, i);
            contact->cusp_of[0][i] = r;
            contact->cusp_of[1][i] = lead;
        }
        const double nominal = p[VAR_FEED][i] - p[VAR_AMPLITUDE_Y][i] + b + x->raised[i] - x->centre_y[i];
        contact->value[VAR_CUSP_HEIGHT][i] = larger(smaller(b * contact->cusp[i], nominal), 0);
    }
}
