/* What does the contact show at its present time? Outputs, derivatives and events, for model exchange and after each
 * step. */
#include "stages.h"

#include <math.h>

static const lanes here; /* tau = 0 */
static const int none[LANES] = {0};

/* As a solver outside sees them: of order 1, and with a hysteresis, so that none is 0, or changes its sign by rounding,
 * where the solver goes on behind an event. The sides held are left so much later: by 1e-15 m, or 1e-9 m/s. */
#define HYSTERESIS 1e-9

static void watched_indicators(const struct Contact *contact, const struct Configuration *w, const struct Point *x,
                               lanes indicator[INDICATORS])
{
    const double thickness = w->kinematics == KINEMATICS_EXTERNAL ? 1e-6 : 1;
    const int own =
        w->law->indicator && !w->current_angle; /* a deflection [m] where the law acts on bristles, or a speed */
    const int engages = w->stages >> STAGE_ENGAGEMENT & 1; /* what turns is the motion, however little it passes on */
    indicators(w, x, indicator);
    EACH_LANE {
        const double slip = w->current_angle ? 1
                            : engages        ? 1e-3 * x->passed[i]
                                             : 1e-3,
                     law = !own            ? 1
                           : w->law->event ? x->F_C[i] / x->P[i]
                                           : 1e-3,
                     unit[INDICATORS] = {thickness, 1, slip, law};
        const int just_0 = indicator[AT_CONTACT][i] < 0 && indicator[AT_CONTACT][i] > -1e-200; /* given as just 0 */
        for (int k = 0; k < INDICATORS; ++k)
            indicator[k][i] = watched(contact, k, i) ? indicator[k][i] / unit[k] + HYSTERESIS * contact->sign[k][i] : 1;
        indicator[AT_CONTACT][i] = just_0 ? -HYSTERESIS : indicator[AT_CONTACT][i];
    }
}

void warn(struct Contact *contact, const struct Point *x)
{
    int outside = 0, flank = 0, always = 0;
    EACH_LANE {
        outside |= x->outside[i] != 0;
        flank |= x->flank[i] != 0;
        always |= x->always[i] != 0;
    }
    contact->warnings |=
        x->warnings | (outside ? WARN_FORCE_DOMAIN : 0u) | (flank ? WARN_FLANK : 0u) | (always ? WARN_ALWAYS_INTO : 0u);
}

/* Outputs that are a field of the point. */
static const struct {
    int index;
    size_t field;
} plain[] = {
    {VAR_FRICTION_FORCE, offsetof(struct Point, F)},
    {VAR_PRINCIPAL_FORCE, offsetof(struct Point, F_p)},
    {VAR_FEED_FORCE, offsetof(struct Point, F_f)},
    {VAR_NORMAL_FORCE, offsetof(struct Point, N)},
    {VAR_TOOL_FORCE_Y, offsetof(struct Point, F_f)},
    {VAR_MEASURED_FRICTION_FORCE, offsetof(struct Point, measured[0])},
    {VAR_MEASURED_PRINCIPAL_FORCE, offsetof(struct Point, measured[1])},
    {VAR_MEASURED_FEED_FORCE, offsetof(struct Point, measured[2])},
    {VAR_SLIP_VELOCITY_USED, offsetof(struct Point, v)},
    {VAR_DISSIPATED_POWER, offsetof(struct Point, P_f)},
    {VAR_SHEAR_POWER, offsetof(struct Point, P_s)},
    {VAR_THETA_USED, offsetof(struct Point, theta)},
    {VAR_SPEED_RATIO, offsetof(struct Point, speed_ratio)},
    {VAR_IN_CONTACT, offsetof(struct Point, cutting)},
    {VAR_CONTACT_RATE, offsetof(struct Point, cutting)},
    {VAR_BRISTLE_RATE, offsetof(struct Point, dz)},
};
enum { PLAIN_COUNT = sizeof plain / sizeof plain[0] };

static void show_plain(struct Contact *contact, const struct Point *x, int n)
{
    const double *const shown = (const double *)((const char *)x + plain[n].field);
    double *const value = contact->value[plain[n].index];
    EACH_LANE
        value[i] = shown[i];
}

int shows_plainly(int count, const int *index)
{
    int matches = 0;
    for (int j = 0; j < count; ++j)
        for (int n = 0; n < PLAIN_COUNT; ++n)
            matches += plain[n].index == index[j];
    return matches == count;
}

void show_some(struct Contact *contact, const struct Point *x, int count, const int *index)
{
    for (int j = 0; j < count; ++j)
        for (int n = 0; n < PLAIN_COUNT; ++n)
            if (plain[n].index == index[j])
                show_plain(contact, x, n);
    warn(contact, x);
}

/* Without a window the means are what is now. */
static void show_means(struct Contact *contact, const struct Point *x)
{
    const lanes *const now[MEANS] = {&x->P_f, &x->P_s,     &x->F,           &x->F_p,         &x->F_f,
                                     &x->N,   &x->cutting, &x->measured[0], &x->measured[1], &x->measured[2]};
    int forms[LANES];
    forms_means(contact, forms);
    for (int n = 0; n < MEANS; ++n)
        EACH_LANE
            contact->value[mean_of[n]][i] = forms[i] ? contact->value[mean_of[n]][i] : (*now[n])[i];
}

void show_outputs(struct Contact *contact, const struct Configuration *w, const struct Point *x, int angles)
{
    lanes *value = contact->value;
    watched_indicators(contact, w, x, value + VAR_CONTACT_INDICATOR);
    for (int n = 0; n < PLAIN_COUNT; ++n)
        show_plain(contact, x, n);
    EACH_LANE {
        value[VAR_TOOL_FORCE_X][i] = -x->F_p[i];
        value[VAR_UNCUT_THICKNESS_USED][i] = x->cutting[i] * x->h[i];
        value[VAR_SLIDING_SPEED][i] = x->cutting[i] * x->speed[i];
    }
    show_means(contact, x);
    for (int i = 0; i < LANES && angles; ++i)
        value[VAR_SHEAR_ANGLE][i] = shear_angle(w, x, i);
    if (angles)
        show_cusps(contact, w, x);
    show_recent(contact);
    if (w->drivers)
        show_rates(contact, w, x);
    warn(contact, x);
    look_at_flank(contact, w, x);
}

#define LEAST_RISE 1e-3 /* [K] that means anything, between which temperatures the proxy is stretched */

int ordered_temperatures(const struct Contact *contact)
{
    EACH_LANE
        if (chosen(contact->value, VAR_PROXY_SOURCE, i) == PROXY_IS_TEMPERATURE &&
            !(contact->value[VAR_REFERENCE_TEMPERATURE][i] - contact->value[VAR_AMBIENT_TEMPERATURE][i] >= LEAST_RISE))
            return 0;
    return 1;
}

static int rows_lost(const lanes *row, int count)
{
    int lost = 0;
    for (int n = 0; n < count; ++n)
        EACH_LANE
            lost |= !(fabs(row[n][i]) < INFINITY);
    return lost;
}

enum Status shows_finite(const struct Contact *contact, const struct Configuration *w)
{
    int lost = rows_lost(contact->value + VAR_FRICTION_FORCE, BASE_COUNT - VAR_FRICTION_FORCE);
    for (int n = 0; n < w->on_count; ++n)
        lost |= rows_lost(contact->value + w->on_value[n], 2 * w->on[n]->states);
    return lost ? STATUS_DIVERGED : STATUS_OK;
}

enum Status show_here(struct Contact *contact, const struct Configuration *w, const struct Point *passed,
                      const int whole[LANES], int angles)
{
    struct Point x;
    lanes held[INDICATORS]; /* looking must not touch */
    for (int k = 0; k < INDICATORS; ++k)
        EACH_LANE
            held[k][i] = contact->sign[k][i];
    if (w->kinematics == KINEMATICS_EXTERNAL) /* inputs may jump without an event: what is shown follows them */
        settle_sides(contact, w, here, here, none, &x);
    else
        point_at(contact, w, here, &x);
    for (int i = 0; passed && i < LANES; ++i)
        if (whole[i]) {
            copy_lane((lanes *)&x, (const lanes *)passed, POINT_LANES, i);
            for (int k = 0; k < INDICATORS; ++k)
                contact->sign[k][i] = held[k][i];
        }
    show_outputs(contact, w, &x, angles);
    for (int k = 0; k < INDICATORS; ++k)
        EACH_LANE
            contact->sign[k][i] = held[k][i];
    if (w->kinematics == KINEMATICS_EXTERNAL)
        watched_indicators(contact, w, &x, contact->value + VAR_CONTACT_INDICATOR); /* of the sides that are held */
    return shows_finite(contact, w);
}

enum Status kernel_evaluate(struct Contact *contact)
{
    if (!ordered_temperatures(contact))
        return STATUS_TEMPERATURES;
    const struct Configuration w = wire(contact);
    const enum Status felt = w.delays ? feel_slip_now(contact, &w) : STATUS_OK;
    if (felt != STATUS_OK)
        return felt;
    return kernel_averages(contact) ? shows_finite(contact, &w) : show_here(contact, &w, NULL, NULL, 1);
}

void kernel_indicators(const struct Contact *contact, lanes indicator[INDICATORS])
{
    const struct Configuration w = wire(contact);
    struct Point x;
    if (w.delays) {
        struct Contact felt = *contact;
        feel_slip_now(&felt, &w);
        point_at(&felt, &w, here, &x);
    } else
        point_at(contact, &w, here, &x);
    watched_indicators(contact, &w, &x, indicator);
}

#define NO_DEFLECTION 1e-12 /* [m]: a hundredth of an atom */

double kernel_nominal(const struct Contact *contact, int index)
{
    const double nominal = kernel_variable(index)->nominal, usual = nominal > 0 ? nominal : 1;
    if (index != VAR_BRISTLE_DEFLECTION)
        return usual;
    const double reach = stated_level(contact->value, 0) / contact->value[VAR_SIGMA0][0];
    return smaller(usual, larger(reach, NO_DEFLECTION));
}

enum Status kernel_event(struct Contact *contact)
{
    if (kernel_averages(contact))
        return STATUS_OK;
    const struct Configuration w = wire(contact);
    struct Point x;
    if (w.delays) {
        note_slip_now(contact, &w);
        const enum Status felt = feel_slip_now(contact, &w);
        if (felt != STATUS_OK)
            return felt;
    }
    /* hosts find events to some roundings of the time, and stop on either side */
    lanes ahead;
    EACH_LANE
        ahead[i] = 1e-9 / w.p[VAR_VIBRATION_FREQUENCY][i] + 1e-12 * fabs(w.p[VAR_TIME][i]);
    act_on_event(contact, &w, here, ahead, none, &x);
    for (int i = 0; i < LANES && w.looks_back; ++i)
        remember_host_step(contact, &w, i, &x); /* what stands before and behind a jump */
    EACH_LANE
        if (contact->value[VAR_TIME][i] >= window_end(contact, i) - 1e-9 * window_length(contact, i))
            close_window(contact, i);
    begin_recent(contact);
    return kernel_evaluate(contact);
}

enum Status kernel_step_completed(struct Contact *contact)
{
    const struct Configuration w = wire(contact);
    struct Point x;
    if (w.delays) {
        note_slip_now(contact, &w);
        const enum Status felt = feel_slip_now(contact, &w);
        if (felt != STATUS_OK)
            return felt;
        EACH_LANE
            if (slip_lead(&w, i) > 0)
                return STATUS_AHEAD;
    }
    if (!w.looks_back && !w.meets_again)
        return STATUS_OK;
    point_at(contact, &w, here, &x);
    for (int i = 0; i < LANES && w.meets_again; ++i)
        leave_surface_here(contact, &w, i, &x);
    for (int i = 0; i < LANES && w.looks_back; ++i)
        remember_host_step(contact, &w, i, &x);
    for (int i = 0; i < LANES; ++i)
        if (!past_reaches(contact, &w, i, x.t[i]))
            return STATUS_HISTORY_SHORT;
    return STATUS_OK;
}

int kernel_turned(const struct Contact *before, const struct Contact *after)
{
    int turned = 0;
    for (int k = 0; k < INDICATORS; ++k)
        EACH_LANE
            turned |= before->sign[k][i] != after->sign[k][i];
    for (int n = 0; n < MEMORY; ++n)
        EACH_LANE
            turned |= before->memory[n][i] != after->memory[n][i];
    for (int n = 0; n < kernel_state_count() && !turned; ++n)
        EACH_LANE
            turned |= before->value[kernel_state(n)][i] != after->value[kernel_state(n)][i];
    return turned;
}

double kernel_next_event(const struct Contact *contact)
{
    return kernel_averages(contact) ? INFINITY : window_end(contact, 0);
}
