/* Where is the tool tip, how fast does it move, and how thick is the chip that it cuts?
 *
 * Tool relative to the work: x along the cutting direction, y away from the machined surface. The origin of x is the
 * bottom of the path when both phases are at their starts. The chip's upper side is the lower of the nominal surface
 * and what all motion left there before the tool last began to move into the material: forward and backward strokes of
 * all earlier cycles. Of most ellipses only the forward stroke of the cycle before may count, which is found out once.
 */
#include "stages.h"

#include <math.h>

#define NO_PITCH 1e-12 /* of a cycle, in amplitudes: all cycles pass the same places */
#define MOST_ENDS 15

/* The whole part of x >= 0; floor() would be a call. */
static inline double whole(double x)
{
    const double rounded = (x + ROUNDER) - ROUNDER;
    return rounded - (rounded > x ? 1 : 0);
}

/* The chip leaves along the rake as one rigid body that shears on one plane: V_s = approach / cos(phi - alpha) along
 * that plane. Merchant 1945, with the tool's own velocity u in place of the cutting speed. */
double slip_along_rake(const struct Configuration *w, const struct Point *x, int lane, double tan_flow)
{
    return x->approach[lane] * tan_flow + x->u_x[lane] * w->sin_rake[lane] - x->u_y[lane] * w->cos_rake[lane];
}

/* Angle in the previous cycle at which the tool stood at the same place X (in units of amplitude_x) on its way forward:
 * r chi + sin(chi) = X, |chi| <= last. The slope vanishes at `last`, so the search starts from there, d = last - |chi|
 * as a polynomial of the root s of 2 (top - |X|)/bend, bend d^2/2 + r d^3/6 - bend d^4/24 + ... = top - |X|: its series
 * to s^3, and for an ellipse that is asked for many angles two terms that make value and slope right in the middle. It
 * goes on by Halley's rule. */
static void series_at(struct Turn *t, int i)
{
    const double q = t->r[i] / t->bend[i];
    t->shape[0][i] = -q / 6;
    t->shape[1][i] = (3 + 5 * q * q) / 72;
    t->shape[2][i] = t->shape[3][i] = 0;
}

void shape_at(struct Turn *t, int i)
{
    const double r = t->r[i], last = t->last[i], bend = t->bend[i], middle = sqrt(2 * (r * last + bend) / bend),
                 cube = middle * middle * middle, second = t->shape[0][i], third = t->shape[1][i];
    const double value = last / middle - 1 - middle * (second + middle * third),
                 slope = middle * bend / (1 + r) - 1 - middle * (2 * second + 3 * middle * third);
    t->shape[2][i] = (5 * value - slope) / cube;
    t->shape[3][i] = (slope - 4 * value) / (cube * middle);
}

static INLINED double from_the_end(double X, const struct Turn *t, int i)
{
    const double top = t->r[i] * t->last[i] + t->bend[i], s = sqrt(2 * larger(top - fabs(X), 0) / t->bend[i]);
    const double chi =
        t->last[i] - s * (1 + s * (t->shape[0][i] + s * (t->shape[1][i] + s * (t->shape[2][i] + s * t->shape[3][i]))));
    return chosen_of(X < 0, -chi, chi);
}

/* One step on, and cosine and sine there by those of the place before. Is it close? */
static INLINED int nearer(double X, double r, double last, double *low, double *high, double *chi, double *cosine,
                          double *sine)
{
    const int inside = (*chi > *low) & (*chi < *high);
    const double at = inside ? *chi : 0.5 * (*low + *high);
    double c, s;
    cos_sin_of(at, &c, &s);
    const double miss = r * at + s - X, slope = r + c;
    const double move = miss / (slope + 0.5 * miss * s / slope);
    *high = miss > 0 ? at : *high;
    *low = miss > 0 ? *low : at;
    *chi = at - move;
    *cosine = c + move * (s - 0.5 * move * c);
    *sine = s - move * (c + 0.5 * move * s);
    /* Halley's rule leaves the cube of the move as error, over the square of the way to an end, where two roots meet;
     * the last: rounding of X */
    return (fabs(move) < 1e-6 * (last - fabs(*chi))) | (*high - *low < 1e-15) | (fabs(miss) < 4e-16);
}

enum { MOST_NEARER = 60 };

/* Cosine and sine of it, in all lanes; of `last` where it is not sought. */
static void angle_at(const lanes X, const struct Turn *t, lanes sought, lanes cosine, lanes sine)
{
    lanes low, high, chi;
    int any = 0;
    EACH_LANE {
        low[i] = -t->last[i];
        high[i] = t->last[i];
        chi[i] = from_the_end(X[i], t, i);
        cosine[i] = -t->r[i];
        sine[i] = t->bend[i];
        any |= sought[i] != 0;
    }
    for (int n = 0; n < MOST_NEARER && any; ++n) {
        any = 0;
        EACH_LANE {
            const int on = sought[i] != 0;
            double next = chi[i], c, s;
            const int close = nearer(X[i], t->r[i], t->last[i], &low[i], &high[i], &next, &c, &s);
            chi[i] = on ? next : chi[i];
            cosine[i] = on ? c : cosine[i];
            sine[i] = on ? s : sine[i];
            sought[i] = on & !close;
            any |= on & !close;
        }
    }
}

/* The angle itself, in one. */
static double angle_of(double X, const struct Turn *t, int lane)
{
    const double r = t->r[lane], last = t->last[lane];
    double low = -last, high = last, chi = from_the_end(X, t, lane), cosine, sine;
    for (int n = 0; n < MOST_NEARER && !nearer(X, r, last, &low, &high, &chi, &cosine, &sine); ++n)
        continue;
    return smaller(larger(chi, -last), last);
}

static double cosine_of(double angle)
{
    double cosine, sine;
    cos_sin_of(angle, &cosine, &sine);
    return cosine;
}

static double sine_of(double angle)
{
    double cosine, sine;
    cos_sin_of(angle, &cosine, &sine);
    return sine;
}

/* The backward stroke as a forward one of speed -r, run through from its end: with psi = e - pi, X + pi r = r e -
 * sin(e), |e| <= acos(r). */
static void reverse(const struct Turn *t, struct Turn *back, int lane)
{
    *back = *t;
    back->r[lane] = -t->r[lane];
    back->last[lane] = PI - t->last[lane];
    series_at(back, lane);
}

/* When the tool moves into the material: approach over a w is r cos(alpha) + A cos(psi - fastest). */
static void stroke_at(const struct Configuration *w, struct Turn *t, int i)
{
    t->begins[i] = -t->last[i];
    if (w->sin_rake[i] == 0)
        return;
    double cosine, sine;
    cos_sin_of(t->lead[i], &cosine, &sine);
    const double tilted = t->aspect[i] * w->sin_rake[i], C = w->cos_rake[i] - tilted * sine, S = -tilted * cosine,
                 share = t->r[i] * w->cos_rake[i] / sqrt(C * C + S * S);
    t->always[i] = share >= 1;
    t->fastest[i] = atan2(S, C);
    t->begins[i] = t->fastest[i] - acos(-smaller(share, 1));
}

/* The phase of y, less that of an upright ellipse: -pi..pi. */
static double tilt_of(double lead) { return lead - PI - 2 * PI * whole((lead - PI) / (2 * PI) + 0.5); }

/* psi of the lowest point is -tilt, and its e: */
static double lowest_backward(double tilt) { return tilt > 0 ? PI - tilt : -PI - tilt; }

void valleys_at(struct Turn *t, int i)
{
    const double r = t->r[i], tilt = tilt_of(t->lead[i]), forward = -tilt, backward = lowest_backward(tilt);
    if (fabs(forward) < t->last[i])
        t->valley_forward[i] = r * forward + sine_of(forward);
    if (fabs(backward) < PI - t->last[i])
        t->valley_backward[i] = r * (backward - PI) - sine_of(backward);
}

/* Does the left end of a forward stroke lie below the place where the stroke before meets it? On one valley, which is
 * alike to both sides of its lowest point, that is so on the far side of the place as high as the left end. The strokes
 * always meet: half a turn's advance is less than half a stroke's reach. */
static int rises_at_left(const struct Turn *t, int lane, double tilt, double met, double left)
{
    const double r = t->r[lane], last = t->last[lane], as_high = last - 2 * tilt;
    if (fabs(tilt) > PI - last)
        return left < cosine_of(angle_of(met, t, lane) + t->lead[lane]);
    return as_high <= -last || (as_high < last && met > r * as_high + sine_of(as_high));
}

/* Where strokes may cut below another: with its right end rising, its left end falling, and the left end above what the
 * cycle before left there, a forward stroke is one valley, and where it is below the valley before, it is below all
 * that is older and below the backward strokes, which are hills over their ends. */
static void crossings_at(struct Turn *t, int i)
{
    const double r = t->r[i], last = t->last[i], lead = t->lead[i], top = r * last + t->bend[i];
    struct Turn back;
    reverse(t, &back, i);
    const double tilt = tilt_of(lead), stroke_ends = 2 * t->fastest[i] - t->begins[i];
    const double left = cosine_of(lead - last), right = cosine_of(lead + last);
    const double backward = lowest_backward(tilt);
    const int falls_there = sine_of(last + tilt) < 0, rises_here = rises_at_left(t, i, tilt, 2 * PI * r - top, left);
    if (falls_there || rises_here)
        t->dips[i] = fabs(backward) < back.last[i] ? -1 : smaller(falls_there ? right : 1, rises_here ? left : 1);
    const int one_valley = fabs(tilt) <= PI - last, one_turn = t->begins[i] >= -PI && stroke_ends <= PI;
    const double stop = r * stroke_ends + sine_of(stroke_ends), start = r * t->begins[i] + sine_of(t->begins[i]);
    const int gets_on = t->begins[i] <= -last || stop >= start;
    t->alone[i] = one_valley && !rises_here && one_turn && gets_on && t->always[i] == 0;
}

void turn_at(const struct Configuration *w, double r, double lead, double aspect, struct Turn *turn, int lane)
{
    if (!(turn->lead[lane] == lead))
        cos_sin_of(lead, &turn->cos_lead[lane], &turn->sin_lead[lane]);
    turn->r[lane] = r;
    turn->lead[lane] = lead;
    turn->aspect[lane] = aspect;
    turn->last[lane] = r < 1 ? acos(-r) : 0;
    turn->bend[lane] = r < 1 ? sqrt(1 - r * r) : 0;
    series_at(turn, lane);
    turn->alone[lane] = 1;
    turn->fastest[lane] = turn->begins[lane] = turn->always[lane] = 0;
    turn->dips[lane] = INFINITY;
    turn->valley_forward[lane] = turn->valley_backward[lane] = NAN;
    const int upright = fabs(lead - PI) < 1e-9;
    if (!(r > NO_PITCH && r < 1) || (upright && w->sin_rake[lane] == 0))
        return;
    stroke_at(w, turn, lane);
    valleys_at(turn, lane);
    crossings_at(turn, lane);
}

/* The lowest height, in b, at which any stroke has passed a place until the angle `begun`, -last <= begun < 2 pi - last
 * or that of a stroke which begins there; infinity: none. Stroke n of a kind passed it where the newest would pass 2 pi
 * r n further on, so that on a stroke of hills and one valley only the newest, the oldest and the two beside the valley
 * may be the lowest. ends: how many loops reach beyond the place, less 1. which: of which stroke it is; 0: of none. */
static double lowest_stroke(const struct Turn *t, int lane, double begun, double place, double ends, double *which)
{
    const double r = t->r[lane], last = t->last[lane], lead = t->lead[lane], pitch = 2 * PI * r,
                 top = r * last + t->bend[lane];
    struct Turn back;
    reverse(t, &back, lane);
    double lowest = INFINITY;
    *which = 0;
    for (int forward = 0; forward < 2; ++forward) {
        const double valley = forward ? t->valley_forward[lane] : t->valley_backward[lane],
                     beside = floor((valley - place) / pitch);
        const double newest = forward ? 0 : -1, oldest = forward ? ends + 1 : ends;
        const double choice[6] = {newest, newest + 1, newest + 2, beside, beside + 1, oldest};
        double before = newest - 1;
        for (int n = 0; n < 6; ++n) {
            const double k = choice[n], X = place + pitch * k, first = (forward ? -last : last - 2 * PI) - 2 * PI * k;
            if (!(k > before && k <= oldest) || X < -top || first >= begun)
                continue;
            before = k;
            const double chi = forward ? angle_of(X, t, lane) : angle_of(-X - PI * r, &back, lane) - PI;
            const double height = chi - 2 * PI * k <= begun ? cosine_of(chi + lead) : INFINITY;
            if (height < lowest) {
                lowest = height;
                *which = 2 * (k + 2) + forward;
            }
        }
    }
    return lowest;
}

double lowest_left(const struct Turn *t, int lane, double begun, double place, double ends)
{
    double which;
    return lowest_stroke(t, lane, begun, place, ends, &which);
}

/* How many loops' ends lie ahead, less 1, as the indicator's side says where one is near; and the indicator: the
 * distance to the nearest end in units of a, its sign changing at each. Ends further on than MOST_ENDS change nothing
 * that is not small. */
static double ends_ahead(double ahead, double pitch, int in_contact, int side, double *indicator)
{
    const double share = ahead / pitch, nearest = smaller(larger(floor(share + 0.5), 0), MOST_ENDS);
    const int even = nearest == 2 * floor(nearest / 2);
    *indicator = (even ? 1 : -1) * (share - nearest) * pitch;
    if (!in_contact || share >= MOST_ENDS + 1)
        return larger(floor(share), -1);
    return side == even ? nearest : nearest - 1;
}

/* Where more than the stroke before may have left what is cut. */
static void on_all_that_is_left(const struct Contact *contact, const struct Configuration *w, const struct Turn *t,
                                double psi, struct Point *x, int i)
{
    const double r = t->r[i], back = 2 * PI * whole((psi - t->fastest[i]) / (2 * PI) + 0.5), own = psi - back,
                 place = r * own + x->cos_x[i], pitch = 2 * PI * r;
    const double ends = ends_ahead(r * (t->last[i] - 2 * PI) + t->bend[i] - place, pitch,
                                   contact->sign[AT_CONTACT][i] > 0, contact->sign[AT_SURFACE][i] > 0, &x->surface[i]);
    const double nominal = w->p[VAR_FEED][i] - w->p[VAR_AMPLITUDE_Y][i] + x->raised[i] - x->centre_y[i],
                 y = nominal - x->h[i];
    const double last = t->last[i],
                 stroke = own < -last  ? last - 2 * PI
                          : own < last ? -last
                                       : last,
                 begun = own < t->begins[i] ? stroke : t->begins[i];
    double which;
    const double lowest = lowest_stroke(t, i, begun, place, ends, &which);
    /* a tool that is carried along may be in the work before its stroke begins, from where on the one before counts */
    x->surface_piece[i] = (lowest < INFINITY && x->b[i] * lowest < nominal ? which : 0) + 0.5 * (own < t->begins[i]);
    x->h[i] = smaller(nominal, lowest < INFINITY ? x->b[i] * lowest : nominal) - y;
}

/* The fields that the stage opens. The ellipse of a tool that nothing disturbs; its centre moves as a machine model
 * says. */
static void open_path(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    const int carried = w->kinematics == KINEMATICS_COMBINED;
    EACH_LANE {
        x->t[i] = w->p[VAR_TIME][i] + tau[i];
        x->a[i] = or_none(w->p[VAR_AMPLITUDE_X][i], NO_AMPLITUDE);
        x->b[i] = w->p[VAR_AMPLITUDE_Y][i];
        x->phase_y[i] = w->p[VAR_PHASE_Y][i];
        x->passed[i] = 1;
        x->tan_clearance[i] = w->tan_clearance[i];
        x->centre_y[i] = x->centre_u_x[i] = x->centre_u_y[i] = x->raised[i] = x->left[i] = x->piece[i] = 0;
    }
    if (carried)
        EACH_LANE {
            x->centre_y[i] = input_at(contact, VAR_TOOL_DISPLACEMENT_Y, i, tau[i]);
            x->centre_u_x[i] = input_at(contact, VAR_TOOL_VELOCITY_X, i, tau[i]);
            x->centre_u_y[i] = input_at(contact, VAR_TOOL_VELOCITY_Y, i, tau[i]);
        }
    for (int i = 0; w->meets_again && i < LANES; ++i)
        x->left[i] = surface_left(contact, w, i, x->t[i] - meeting_time(w, i));
}

/* Where the tool passes a place again, and only the cycle before may have left what stands there: thickness over the
 * surface that the previous cycle left there. It reaches up to where that cycle turned, and past it its last height
 * stands. turned: the part of the present turn; psi: vibration angle, 0 where the tool is fastest; X: its place in
 * units of a. */
static void on_what_is_left(const struct Contact *contact, const struct Configuration *w, const lanes turned,
                            struct Point *x)
{
    const lanes *p = w->p;
    lanes X, on_left, sought, angle;
    int passing = 0, others = 0, older = 0;
    EACH_LANE {
        on_left[i] = (x->speed_ratio[i] < 1) & (x->a[i] > 0) & (x->approach[i] > 0);
        passing |= on_left[i] != 0;
    }
    if (!passing)
        return;
    if (!w->turns_alike)
        EACH_LANE
            others |= (on_left[i] != 0) & (!(x->speed_ratio[i] == w->turn.r[i]) | (x->phase_y[i] != p[VAR_PHASE_Y][i]));
    const struct Turn *t = &w->turn;
    struct Turn other;
    if (others) {
        other = w->turn;
        for (int i = 0; i < LANES; ++i)
            if (on_left[i] != 0 && (!(x->speed_ratio[i] == other.r[i]) || x->phase_y[i] != p[VAR_PHASE_Y][i]))
                turn_at(w, x->speed_ratio[i], x->phase_y[i] - p[VAR_PHASE_X][i] - PI / 2, x->b[i] / x->a[i], &other, i);
        t = &other;
    }
    lanes all_left;
    int met = 0;
    EACH_LANE {
        all_left[i] = (on_left[i] != 0) & (t->alone[i] == 0);
        older |= all_left[i] != 0;
        on_left[i] = (on_left[i] != 0) & (t->alone[i] != 0);
    }
    EACH_LANE {
        const double r = x->speed_ratio[i], turn = 2 * PI * turned[i],
                     ahead = turn + p[VAR_PHASE_X][i] + PI / 2; /* -3/2 pi .. 9/2 pi */
        const double psi = ahead - 2 * PI * ((ahead >= PI) + (ahead >= 3 * PI) - (ahead < -PI)),
                     place = r * psi + x->cos_x[i];
        const double surface = r * (t->last[i] - 2 * PI) + t->bend[i] - place;
        const int moving_on = (on_left[i] != 0) & (r > 0);
        angle[i] = psi;
        x->surface[i] = moving_on ? surface : x->surface[i];
        const int in_contact = contact->sign[AT_CONTACT][i] > 0, side = contact->sign[AT_SURFACE][i] > 0,
                  there_now = (r == 0) | (x->surface[i] > 0);
        on_left[i] = (on_left[i] != 0) & (in_contact ? side : there_now);
        sought[i] = (on_left[i] != 0) & (x->surface[i] > 0);
        X[i] = place + 2 * PI * r;
        met |= on_left[i] != 0;
    }
    EACH_LANE {
        const double nominal = p[VAR_FEED][i] - p[VAR_AMPLITUDE_Y][i] + x->raised[i] - x->centre_y[i];
        x->flank[i] = x->b[i] * t->dips[i] < nominal;
        x->always[i] = t->always[i];
    }
    if (met) {
        lanes cos_there, sin_there;
        angle_at(X, t, sought, cos_there, sin_there);
        EACH_LANE {
            const double nominal = p[VAR_FEED][i] - p[VAR_AMPLITUDE_Y][i] + x->raised[i] - x->centre_y[i],
                         y = nominal - x->h[i];
            const double cosine = cos_there[i] * t->cos_lead[i] - sin_there[i] * t->sin_lead[i];
            const double height = x->speed_ratio[i] > 0 ? x->b[i] * cosine : y, left = smaller(nominal, height) - y;
            x->surface_piece[i] = (on_left[i] != 0) & (height < nominal);
            x->h[i] = on_left[i] != 0 ? left : x->h[i];
        }
    }
    for (int i = 0; older && i < LANES; ++i)
        if (all_left[i] != 0)
            on_all_that_is_left(contact, w, t, angle[i], x, i);
}

/* Of the phase of y, which an effect may have shifted. */
static void phase_of_y(const struct Configuration *w, const struct Point *x, lanes cosine, lanes sine)
{
    int shifted = 0;
    EACH_LANE {
        cosine[i] = w->cos_y[i];
        sine[i] = w->sin_y[i];
    }
    if (!w->turns_alike)
        EACH_LANE
            shifted |= x->phase_y[i] != w->p[VAR_PHASE_Y][i];
    for (int i = 0; shifted && i < LANES; ++i)
        if (x->phase_y[i] != w->p[VAR_PHASE_Y][i])
            cos_sin_of(x->phase_y[i], &cosine[i], &sine[i]);
}

static void ellipse_at(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    const lanes *p = w->p;
    lanes cos_phase, sin_phase, turned;
    phase_of_y(w, x, cos_phase, sin_phase);
    EACH_LANE {
        const double f = p[VAR_VIBRATION_FREQUENCY][i], omega = 2 * PI * f, a = x->a[i], b = x->b[i];
        const double v_c = input_at(contact, VAR_CUTTING_SPEED, i, tau[i]);
        const double turns = turns_at(w, i, tau[i]), share = turns - whole(turns);
        double c, s;
        turned[i] = share;
        cos_sin(share, &c, &s);
        const double c_y = cos_phase[i], s_y = sin_phase[i];
        const double sin_x = s * w->cos_x[i] + c * w->sin_x[i];
        const double cos_y = c * c_y - s * s_y, sin_y = s * c_y + c * s_y;
        x->cos_x[i] = c * w->cos_x[i] - s * w->sin_x[i];
        x->u_x[i] = v_c - a * omega * sin_x + x->centre_u_x[i];
        x->u_y[i] = -b * omega * sin_y + x->centre_u_y[i];
        x->approach[i] = x->u_x[i] * w->cos_rake[i] + x->u_y[i] * w->sin_rake[i];

        /* Heights over the vibration's centre; the previous cycle is taken to have had the same centre. Without
         * separation (r >= 1) no place is passed twice, and only the nominal surface stands, `feed` above the lowest
         * point of the undisturbed ellipse. */
        const double y = b * cos_y, nominal = p[VAR_FEED][i] - p[VAR_AMPLITUDE_Y][i] + x->raised[i] - x->centre_y[i];
        x->surface[i] = -1;
        x->flank[i] = x->always[i] = x->surface_piece[i] = 0;
        x->h[i] = nominal - y;
        x->speed_ratio[i] = w->turn.r[i];
    }
    if (!w->turns_alike)
        EACH_LANE {
            const double omega = 2 * PI * p[VAR_VIBRATION_FREQUENCY][i], a = x->a[i];
            x->speed_ratio[i] = a > 0 ? input_at(contact, VAR_CUTTING_SPEED, i, tau[i]) / (a * omega) : 0;
        }
    on_what_is_left(contact, w, turned, x);
}

/* Slip and thickness are given; what effects do to the path comes on top. */
static void given_at(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    const double *const slope = contact->slope[(int)VAR_SLIP_VELOCITY - (int)INPUT_FIRST],
                        *const thicker = contact->slope[(int)VAR_UNCUT_THICKNESS - (int)INPUT_FIRST];
    EACH_LANE {
        x->u_x[i] = x->centre_u_x[i];
        x->u_y[i] = x->centre_u_y[i];
        x->approach[i] = x->u_x[i] * w->cos_rake[i] + x->u_y[i] * w->sin_rake[i];
        const double given = w->delays ? given_then(contact->late_slip[i], contact->late_slope[i] * tau[i])
                                       : given_then(contact->value[VAR_SLIP_VELOCITY][i], slope[i] * tau[i]);
        x->v[i] = given + slip_along_rake(w, x, i, w->tan_flow[i]);
        x->h[i] =
            given_then(contact->value[VAR_UNCUT_THICKNESS][i], thicker[i] * tau[i]) + x->raised[i] - x->centre_y[i];
        x->speed_ratio[i] = 0;
        x->surface[i] = x->approach[i] = 1;
        x->flank[i] = x->always[i] = x->surface_piece[i] = 0;
    }
}

/* The same where no effect asks for more. */
static void given_alone(const struct Contact *contact, const lanes tau, struct Point *x)
{
    const double *const slope = contact->slope[(int)VAR_SLIP_VELOCITY - (int)INPUT_FIRST],
                        *const thicker = contact->slope[(int)VAR_UNCUT_THICKNESS - (int)INPUT_FIRST];
    EACH_LANE {
        x->v[i] = given_then(contact->value[VAR_SLIP_VELOCITY][i], slope[i] * tau[i]);
        x->h[i] = given_then(contact->value[VAR_UNCUT_THICKNESS][i], thicker[i] * tau[i]);
        x->surface[i] = x->approach[i] = 1;
        x->flank[i] = x->always[i] = x->piece[i] = 0;
        x->a[i] = x->u_x[i] = x->u_y[i] = x->speed_ratio[i] = 0;
    }
}

/* Both indicators of order 1, in um and m/s; a given thickness of just 0 is none, and says so by its sign. */
static void engage_given(struct Point *x)
{
    EACH_LANE {
        x->shear_speed[i] = fabs(x->v[i]);
        x->contact[i] = x->h[i] > 0 ? x->h[i] : smaller(x->h[i], -1e-300);
    }
}

static void engage_ellipse(const struct Configuration *w, struct Point *x)
{
    EACH_LANE {
        x->v[i] = slip_along_rake(w, x, i, w->tan_flow[i]);
        x->shear_speed[i] = larger(x->approach[i], 0);
        x->contact[i] = smaller(x->h[i] / 1e-6, x->approach[i]);
    }
}

void path_at(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    const int given = w->kinematics == KINEMATICS_EXTERNAL;
    if (given && w->on_count == 0) {
        given_alone(contact, tau, x);
        engage_given(x);
        return;
    }
    open_path(contact, w, tau, x);
    act(w, STAGE_PATH, x);
    EACH_LANE
        x->path_piece[i] = x->piece[i];
    if (given)
        given_at(contact, w, tau, x);
    else
        ellipse_at(contact, w, tau, x);
    if (given)
        engage_given(x);
    else
        engage_ellipse(w, x);
}

void pass_on(const struct Configuration *w, struct Point *x)
{
    if (!(w->stages >> STAGE_ENGAGEMENT & 1))
        return;
    act(w, STAGE_ENGAGEMENT, x);
    EACH_LANE
        x->v[i] *= x->passed[i];
}
