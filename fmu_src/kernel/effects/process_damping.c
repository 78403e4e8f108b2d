/* Process damping: the flank is pressed into the wave that the edge leaves, by the slope of the path. Kurata, Altintas
 * and Shamoto 2010: in proportion to the velocity of the vibration over that of the cut. A flank with a clearance
 * angle is clear of a path that goes down less steeply; where none is stated, it is a worn land along the cut. */
#include "effect.h"

enum { ON, C, C_P, STEEPEST, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "process_damping", SWITCH, .meaning = "switch: a force on the flank against the motion into the surface",
        .source = "Kurata, Merdol, Altintas, Suzuki and Shamoto 2010 (abstract read); Altintas, Eynian and Onozuka 2008 "
            "(not read)"},
    [C] = {.name = "process_damping.C", .unit = "N/m", .start = 5e3, .min = 0, .max = 1e8, .nominal = 1e3,
        .display_unit = "N/mm", TUNED, .meaning = "feed force per width at a slope of the path of 1 into the surface; 0: none",
        .source = "guess"},
    [C_P] = {.name = "process_damping.C_p", .unit = "N/m", .start = 0, .min = 0, .max = 1e8, .nominal = 1e3,
        .display_unit = "N/mm", TUNED, .meaning = "principal force per width at that slope, as the flank rubs: its friction "
            "coefficient times C; 0: none", .source = "guess; 0: the published law, without friction on the flank"},
    [STEEPEST] = {.name = "process_damping.steepest", .unit = "1", .start = 1, .min = 1e-3, .max = 100, SHAPE, TUNED,
        .meaning = "slope beyond which the force does not grow: the law is one of small waves", .source = "guess"},
};
/* clang-format on */

/* The speed of the cut is that of the tool through the work: in a vibrating cut it is not the mean one. */
static void press(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        const double into = larger(-x->u_y[i], 0), along = larger(x->u_x[i], into / p[STEEPEST][i]);
        mark_side(x, i, (p[C][i] + p[C_P][i] > 0) & (into > p[STEEPEST][i] * x->u_x[i]));
        const double beyond = x->w[i] * larger(into > 0 ? into / along - x->tan_clearance[i] : 0, 0);
        x->edge_f[i] += p[C][i] * beyond;
        x->edge_p[i] += p[C_P][i] * beyond;
    }
}

/* clang-format off */
const struct Effect effect_process_damping = {
    .equation = "feed_force + C w (s - tan(clearance_angle)), principal_force + C_p w (s - tan(clearance_angle)) where that is "
                "above 0, s = -u_y/u_x the slope of the path, at most `steepest`",
    .signature = "feed force rises early in the contact, while the tool still moves into the surface, and not later; the "
        "less the faster the cut",
    .applies_to = "internal, combined",
    .family = "load",
    .stage = STAGE_LOAD, .act = press,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
