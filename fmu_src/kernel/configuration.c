/* What do all points of one call have in common? The law and the effects that are on, and trigonometry that does not
 * change. */
#include "stages.h"

#include <math.h>

/* Shear angle, and that less the rake angle [rad]: planes beyond them are no chip formation, and they bound the search
 * for the slip. */
#define FLATTEST 0.02
#define STEEPEST 1.5

static double place_in_cycle(const struct Configuration *w, int lane, double time)
{
    const double turns = w->p[VAR_VIBRATION_FREQUENCY][lane] * time;
    return turns - floor(turns);
}

/* What changes with value[VAR_TIME] and the slopes of the inputs. */
void wire_time(const struct Contact *contact, struct Configuration *w)
{
    w->rises = any_rises(contact);
    w->held = w->kinematics == KINEMATICS_EXTERNAL && w->on_count == 0 && !w->yields && !w->rises;
    if (w->kinematics == KINEMATICS_EXTERNAL)
        return;
    int moving = w->stages >> STAGE_PATH & 1;
    for (int i = 0; i < LANES; ++i) {
        const double omega = 2 * PI * w->p[VAR_VIBRATION_FREQUENCY][i],
                     a = or_none(w->p[VAR_AMPLITUDE_X][i], NO_AMPLITUDE);
        const double r =
            a > 0 ? w->p[VAR_CUTTING_SPEED][i] / (a * omega) : INFINITY; /* to the bit as ellipse_at finds it */
        const double lead = w->p[VAR_PHASE_Y][i] - w->p[VAR_PHASE_X][i] - PI / 2,
                     aspect = a > 0 ? w->p[VAR_AMPLITUDE_Y][i] / a : 0;
        w->cycle[i] = place_in_cycle(w, i, w->p[VAR_TIME][i]);
        if (!(w->turn.r[i] == r)) {
            turn_at(w, r, lead, aspect, &w->turn, i);
            shape_at(&w->turn, i);
        }
        moving |= !(a > 0) | (contact->slope[(int)VAR_CUTTING_SPEED - (int)INPUT_FIRST][i] != 0);
    }
    w->turns_alike = !moving;
}

/* What goes by the length of the communication step, which begins at value[VAR_TIME]. */
void wire_step(double step, struct Configuration *w)
{
    if (w->kinematics == KINEMATICS_EXTERNAL)
        return;
    w->ends = step;
    for (int i = 0; i < LANES; ++i)
        w->cycle_then[i] = place_in_cycle(w, i, w->p[VAR_TIME][i] + step);
}

uint64_t effects_switched_on(const struct Contact *contact)
{
    uint64_t on = 0;
    for (int n = 0, at = kernel_effect_switch(0); n < EFFECT_COUNT; at += kernel_effect(n++)->count)
        on |= (uint64_t)(contact->value[at][0] != 0) << n;
    return on;
}

/* Is an effect more than on? One at its neutral values leaves all the rest as it is, the steps among it. */
static int acts(const struct Effect *effect, const lanes *p, int lane)
{
    int has_neutral = 0;
    for (int k = 1; k < effect->count - 2 * effect->states; ++k) {
        const double neutral = effect->variables[k].neutral;
        if (isnan(neutral))
            continue;
        has_neutral = 1;
        if (fabs(p[k][lane] - neutral) >= NO_TIME) /* a time or an amplitude: below it it means nothing */
            return 1;
    }
    return !has_neutral;
}

static void wire_effects(const struct Contact *contact, struct Configuration *w)
{
    uint64_t left = contact->effects_on;
    for (int n = 0, at = kernel_effect_switch(0), state = 0; n < EFFECT_COUNT && left; ++n, left >>= 1) {
        const struct Effect *effect = kernel_effect(n);
        const enum Driver driver = driver_of(w, effect);
        if (left & 1) {
            w->on[w->on_count] = effect;
            w->on_p[w->on_count] = contact->value + at;
            w->on_state[w->on_count] = state;
            w->on_value[w->on_count++] = at + effect->count - 2 * effect->states;
            w->stages |= 1 << effect->stage;
            w->drivers |= (driver != NO_STATES) << driver;
            const int keeps_past = effect->looks_back || effect->meets_again;
            for (int i = 0;
                 i < LANES && (driver != NO_STATES || effect->stage == STAGE_FRICTION || effect->bends || keeps_past);
                 ++i) {
                const int active = acts(effect, contact->value + at, i);
                w->acting[i] |= driver != NO_STATES ? active << driver : 0;
                w->levelled[i] |= active & (effect->stage == STAGE_FRICTION);
                w->bent[i] |= active & effect->bends;
                w->keeps_past[i] |= active & keeps_past;
            }
            w->sensors += driver == DRIVEN_BY_SENSOR;
            w->looks_back |= effect->looks_back != NULL;
            w->comes_back |= effect->periods != NULL;
            w->delays |= effect->delays != NULL && w->kinematics == KINEMATICS_EXTERNAL;
            w->bends |= effect->bends;
            w->meets_again |= effect->meets_again != NULL;
        }
        at += effect->count;
        state += effect->states;
    }
}

/* Sines, cosines and tangents of what does not move. Each only where something asks for it: a tangent costs as much as
 * a stage. */
static void wire_angles(const struct Contact *contact, struct Configuration *w)
{
    const lanes *const p = contact->value;
    const int given = w->kinematics == KINEMATICS_EXTERNAL, moves = !given || w->on_count > 0;
    EACH_LANE {
        w->cos_rake[i] = 1;
        w->sin_rake[i] = 0;
        if (p[VAR_RAKE_ANGLE][i] != 0)
            cos_sin_of(p[VAR_RAKE_ANGLE][i], &w->cos_rake[i], &w->sin_rake[i]);
        w->tan_clearance[i] = p[VAR_CLEARANCE_ANGLE][i] != 0 ? tan(p[VAR_CLEARANCE_ANGLE][i]) : 0;
        w->turn.r[i] = w->turn.lead[i] = NAN;
        w->tan_flow[i] = w->cot_flow[i] = 0;
    }
    for (int i = 0; given && i < LANES; ++i)
        w->cot_flow[i] = 1 / tan(p[VAR_CONSTANT_SHEAR_ANGLE][i]);
    for (int i = 0; moves && i < LANES; ++i) {
        w->tan_flow[i] = tan(p[VAR_CONSTANT_SHEAR_ANGLE][i] - p[VAR_RAKE_ANGLE][i]);
        cos_sin_of(p[VAR_PHASE_X][i], &w->cos_x[i], &w->sin_x[i]);
        cos_sin_of(p[VAR_PHASE_Y][i], &w->cos_y[i], &w->sin_y[i]);
    }
    for (int i = 0; w->current_angle && i < LANES; ++i) {
        w->tan_flattest[i] = tan(FLATTEST - p[VAR_RAKE_ANGLE][i]);
        w->tan_steepest[i] = tan(STEEPEST);
    }
}

#define DECAYED 9.2 /* e^-9.2 is 1e-4, the usual tolerance */
#define ROOT_DECAYED 3.0331501776206204

struct Configuration wire(const struct Contact *contact)
{
    struct Configuration w; /* not zeroed: that would cost a tenth of a step */
    w.p = contact->value;
    w.kinematics = (enum Kinematics)chosen(contact->value, VAR_KINEMATICS, 0);
    const int law = chosen(contact->value, VAR_FRICTION_LAW, 0);
    w.law = kernel_law(law);
    w.law_p = contact->value + law_values(law);
    w.proxy_source = (enum ProxySource)chosen(contact->value, VAR_PROXY_SOURCE, 0);
    w.by_energy = chosen(contact->value, VAR_SHEAR_ANGLE_PRINCIPLE, 0) == MINIMUM_ENERGY;
    w.dissipative = chosen(contact->value, VAR_DAMPING_MODE, 0) == DISSIPATIVE;
    w.thermal_rate = chosen(contact->value, VAR_RATE_STIFFNESS, 0) == THERMAL_STIFFNESS;
    w.current_angle =
        chosen(contact->value, VAR_CHIP_FLOW_ANGLE, 0) == CURRENT_ANGLE && w.kinematics != KINEMATICS_EXTERNAL;
    w.on_count = w.stages = w.drivers = w.sensors = w.looks_back = w.delays = w.comes_back = w.bends = w.meets_again =
        0;
    for (int i = 0; i < LANES; ++i)
        w.acting[i] = w.levelled[i] = w.bent[i] = w.keeps_past[i] = 0;
    if (contact->effects_on)
        wire_effects(contact, &w);
    w.record = NULL;
    w.slip_column = 0;
    w.feedback = w.drivers >> DRIVEN_BY_FORCE & 1;
    const int everywhere = w.feedback || w.bends || w.current_angle;
    w.yields = 0;
    for (int i = 0; i < LANES; ++i) {
        const int yields = w.law->yields && !w.bent[i] && w.law->yields(w.law_p, i);
        w.yielding[i] = yields;
        w.bent[i] |= yields;
        w.iterated[i] = everywhere || yields;
        w.yields |= yields;
    }
    w.iterates = everywhere || w.yields;
    wire_angles(contact, &w);
    for (int n = 0; n < w.on_count; ++n)
        if (w.on[n]->prepare)
            w.on[n]->prepare(w.on_p[n], &w);
    EACH_LANE {
        /* A tool that does not vibrate moves evenly; a slip that is solved for keeps the steps of one that does. */
        const int moves = w.kinematics != KINEMATICS_EXTERNAL &&
                          (w.current_angle || w.p[VAR_AMPLITUDE_X][i] > 0 || w.p[VAR_AMPLITUDE_Y][i] > 0);
        w.longest[i] = moves ? 1 / (20 * w.p[VAR_VIBRATION_FREQUENCY][i]) : INFINITY;
    }
    resolving_step(&w, w.longest);
    for (int i = 0; i < LANES; ++i) {
        const double tight = USUAL_TOLERANCE / w.p[VAR_RELATIVE_TOLERANCE][i];
        w.tighter[i] = smaller(w.p[VAR_RELATIVE_TOLERANCE][i] / USUAL_TOLERANCE, 1);
        w.decayed[i] = tight > 1 ? DECAYED + log(tight) : DECAYED;
        w.root_decayed[i] = tight > 1 ? sqrt(w.decayed[i]) : ROOT_DECAYED;
        w.finer[i] = tight > 1 ? sqrt(sqrt(tight)) : 1;
    }
    if (w.law->prepare)
        w.law->prepare(w.law_p, &w);
    w.ends = NAN;
    wire_time(contact, &w);
    return w;
}
