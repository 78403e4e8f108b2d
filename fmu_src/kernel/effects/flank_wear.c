/* Flank wear: a land wears onto the tool and rubs on the new surface. */
#include "effect.h"

enum { ON, FEED_RATE, PRINCIPAL_RATE, BREAK_IN, COUNT };

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
    [BREAK_IN] = {.name = "flank_wear.break_in", .unit = "m", .start = 1e9, .min = 1e-6, .max = 1e12, SHAPE, TUNED,
        .meaning = "distance slid within which the edge breaks in, and the forces end their growth; far beyond the "
            "record: steady wear", .source = "guess: steady wear"},
};
/* clang-format on */

static void rub(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        /* 1 - exp(-worn) has no digits left where little is worn: there by its series. */
        const double worn = x->distance[i] / p[BREAK_IN][i], few = worn * (1 - worn / 2 * (1 - worn / 3));
        const double land = p[BREAK_IN][i] * x->w[i] * (worn > 1e-4 ? 1 - exponential(-worn) : few);
        x->edge_f[i] += p[FEED_RATE][i] * land;
        x->edge_p[i] += p[PRINCIPAL_RATE][i] * land;
    }
}

/* clang-format off */
const struct Effect effect_flank_wear = {
    .equation = "feed_force + K_f w l, principal_force + K_p w l while cutting, l = L (1 - exp(-s/L)), s the sliding "
                "distance on the rake face since the start, L = break_in",
    .signature = "feed force (and some principal force) grows through the record, at the same motion, steadily or as an edge breaks in",
    .applies_to = "internal, combined, uncut_thickness",
    .family = "wear", .unsteady = 1, .irreversible = 1,
    .stage = STAGE_LOAD, .act = rub,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
