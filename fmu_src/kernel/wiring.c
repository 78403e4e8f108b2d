/* What do all points of one call have in common? The law and the effects that are on, and trigonometry that does not change. */
#include "stages.h"

#include <math.h>

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
    EACH_LANE {
        const double rake = contact->value[RAKE_ANGLE][i], turns = contact->value[VIBRATION_FREQUENCY][i] * contact->value[TIME][i];
        w.cos_rake[i] = cos(rake);
        w.sin_rake[i] = sin(rake);
        if (w.kinematics == KINEMATICS_EXTERNAL)
            continue;
        w.cycle[i] = turns - floor(turns);
        const double phase_x = contact->value[PHASE_X][i], phase_y = contact->value[PHASE_Y][i];
        w.tan_flow[i] = tan(contact->value[CONSTANT_SHEAR_ANGLE][i] - rake);
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
