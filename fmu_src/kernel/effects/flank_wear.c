/* Flank wear: a land wears onto the tool and rubs on the new surface. */
#include "effect.h"

enum { ON, FEED_RATE, PRINCIPAL_RATE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "flank_wear", SWITCH, .meaning = "switch: forces on the flank grow with the distance slid",
        .source = "Smithey, Kapoor and DeVor 2000 (not read): forces in proportion to the land; "
            "its growth with distance: guess"},
    [FEED_RATE] = {.name = "flank_wear.feed_rate", .unit = "Pa", .start = 1e2, .min = 0, .max = 1e7, .nominal = 1e2,
        TUNED, .meaning = "growth of feed_force per width and distance slid; 0: none", .source = "guess"},
    [PRINCIPAL_RATE] = {.name = "flank_wear.principal_rate", .unit = "Pa", .start = 30, .min = 0, .max = 1e7,
        .nominal = 1e2, TUNED, .meaning = "growth of principal_force per width and distance slid; 0: none",
        .source = "guess"},
};
/* clang-format on */

static void rub(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        x->edge_f[i] += p[FEED_RATE][i] * x->w[i] * x->distance[i];
        x->edge_p[i] += p[PRINCIPAL_RATE][i] * x->w[i] * x->distance[i];
    }
}

/* clang-format off */
const struct Effect effect_flank_wear = {
    .equation = "feed_force + K_f w s, principal_force + K_p w s while cutting, s the sliding distance on "
                "the rake face since the start",
    .signature = "feed force (and some principal force) grows steadily through the record, at the same motion",
    .applies_to = "internal, combined, uncut_thickness",
    .family = "wear", .unsteady = 1, .irreversible = 1,
    .stage = STAGE_LOAD, .act = rub,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
