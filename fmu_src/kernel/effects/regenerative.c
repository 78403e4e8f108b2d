/* Regeneration: each turn of the work meets the surface that the turn before it left. Tobias and Fishwick 1958. */
#include "effect.h"

enum { ON, SHARE, TURN, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "regenerative", SWITCH,
        .meaning = "switch: the tool meets the surface that it left one revolution earlier",
        .source = "Tobias and Fishwick 1958 (not read)"},
    [SHARE] = {.name = "regenerative.share", .unit = "1", .start = 1, .min = 0, .max = 1, TUNED,
        .meaning = "overlap of the cut with that of the turn before; 0: none, 1: all of it",
        .source = "Tobias and Fishwick 1958 (not read)"},
    [TURN] = {.name = "regenerative.revolution_time", .unit = "s", .display_unit = "ms", .start = 0.1, .min = 1e-5,
        .max = 1e3, .nominal = 0.1, SHAPE, TUNED, .meaning = "time of one revolution of the work; the surface that is left in it must fit into 256 pieces, "
            "vibration cycles that are alike counted once, or the run is refused",
        .source = "guess: 600 1/min"},
};
/* clang-format on */

static void meet(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        x->left[i] *= p[SHARE][i];
        x->raised[i] += x->left[i];
    }
}

static double turn(const lanes *p, int i) { return p[TURN][i]; }

static double longest_step(const lanes *p, int i) { return p[SHARE][i] > 0 ? p[TURN][i] / 50 : INFINITY; }

/* clang-format off */
const struct Effect effect_regenerative = {
    .equation = "thickness + s(t - T) - y(t), y the tool's height, s = min(y, s(t - T) + feed) the surface that it "
        "leaves",
    .signature = "run-out fades after one turn; a compliant tool wavers ever more where the cut is too wide for it",
    .applies_to = "internal, combined, uncut_thickness",
    .family = "path",
    .stage = STAGE_PATH, .variables = variables, .count = COUNT,
    .act = meet, .meets_again = turn, .longest_step = longest_step,
};
/* clang-format on */
