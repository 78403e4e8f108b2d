/* What do all points of one call have in common? The law and the effects that are on, and trigonometry that does not change. */
#include "stages.h"

#include <math.h>

#define PI 3.14159265358979323846

struct Wiring wire(const struct Contact *contact)
{
    struct Wiring w = {.p = contact->value, .kinematics = (enum Kinematics)chosen(contact->value, KINEMATICS, 0)};
    const int law = chosen(contact->value, FRICTION_LAW, 0);
    w.law = kernel_law(law);
    w.law_p = contact->value + law_values(law);
    w.current_angle = chosen(contact->value, CHIP_FLOW_ANGLE, 0) == CURRENT_ANGLE && w.kinematics != KINEMATICS_EXTERNAL;
    for (int n = 0, at = kernel_effect_switch(0); n < EFFECT_COUNT; at += kernel_effect(n++)->count)
        if (contact->value[at][0] != 0) {
            w.on[w.on_count] = kernel_effect(n);
            w.on_p[w.on_count++] = contact->value + at;
        }
    w.held = w.kinematics == KINEMATICS_EXTERNAL;
    for (int k = 0; k < INPUT_END - INPUT_FIRST; ++k)
        EACH_LANE w.held &= contact->slope[k][i] == 0;
    EACH_LANE {
        const double rake = contact->value[RAKE_ANGLE][i], turns = contact->value[VIBRATION_FREQUENCY][i] * contact->value[TIME][i];
        w.cos_rake[i] = rake == 0 ? 1 : cos(rake);
        w.sin_rake[i] = rake == 0 ? 0 : sin(rake);
        if (w.kinematics == KINEMATICS_EXTERNAL)
            continue;
        w.cycle[i] = turns - floor(turns);
        const double phase_x = contact->value[PHASE_X][i], phase_y = contact->value[PHASE_Y][i];
        w.tan_flow[i] = tan(contact->value[CONSTANT_SHEAR_ANGLE][i] - rake);
        const double fastest = 2 * PI * w.p[VIBRATION_FREQUENCY][i] * w.p[AMPLITUDE_X][i];
        w.turn[i] = turn_at(fastest > 0 ? w.p[CUTTING_SPEED][i] / fastest : INFINITY);
        w.cos_x[i] = cos(phase_x);
        w.sin_x[i] = sin(phase_x);
        w.cos_y[i] = cos(phase_y);
        w.sin_y[i] = sin(phase_y);
    }
    return w;
}

void act(const struct Wiring *w, enum Stage stage, struct Point *x)
{
    for (int n = 0; n < w->on_count; ++n)
        if (w->on[n]->stage == stage)
            w->on[n]->act(w->on_p[n], x);
}
