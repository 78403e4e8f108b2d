/* Cross talk: a part of one force shows in the other channel. */
#include "effect.h"

enum { ON, PRINCIPAL_FROM_FEED, FEED_FROM_PRINCIPAL, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "cross_talk", SWITCH, .meaning = "switch: measured principal and feed force mix",
        .source = "definition"},
    [PRINCIPAL_FROM_FEED] = {.name = "cross_talk.principal_from_feed", .unit = "1", .start = 0.02, .min = -1, .max = 1,
        TUNED, .prior_sd = 0.05, .meaning = "share of feed_force that shows in measured_principal_force; 0: none",
        .source = "guess: 2 % is ordinary for piezoelectric dynamometers"},
    [FEED_FROM_PRINCIPAL] = {.name = "cross_talk.feed_from_principal", .unit = "1", .start = 0.02, .min = -1, .max = 1,
        TUNED, .prior_sd = 0.05, .meaning = "share of principal_force that shows in measured_feed_force; 0: none",
        .source = "guess: 2 % is ordinary for piezoelectric dynamometers"},
};
/* clang-format on */

static void mix(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        const double principal = x->measured[1][i], feed = x->measured[2][i];
        x->measured[1][i] += p[PRINCIPAL_FROM_FEED][i] * feed;
        x->measured[2][i] += p[FEED_FROM_PRINCIPAL][i] * principal;
    }
}

/* clang-format off */
const struct Effect effect_cross_talk = {
    .equation = "measured principal + c_pf feed, measured feed + c_fp principal",
    .signature = "one channel shows a scaled copy of the other, at all times and conditions alike",
    .family = "gain",
    .stage = STAGE_MEASUREMENT, .act = mix,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
