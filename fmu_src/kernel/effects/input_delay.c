/* Input delay: the slip is recorded earlier or later than the contact feels it, as by a clock, a filter or a drive that
 * follows late.
 *
 * A delay above 0 is causal: the contact answers to what was given so long ago, and the forces come late. Below 0 the
 * record is late, and the forces are early: the contact answers to what is recorded after. A record that is followed
 * as a whole has that; a host that steps has not, and is refused.
 */
#include "effect.h"

enum { ON, TIME_LATE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "input_delay", SWITCH,
        .meaning = "switch: the slip at the contact comes later or earlier than slip_velocity says",
        .source = "definition"},
    [TIME_LATE] = {.name = "input_delay.time", .unit = "s", .start = 1e-4, .min = -10, .max = 10, .display_unit = "ms",
        .nominal = 1e-4, TUNED,
        .meaning = "time tau by which the slip at the contact lags slip_velocity; 0, or less than 1e-12 s: none; below "
            "0 slip_velocity is late, which needs a record; a host's steps of that time must fit into 256 straight pieces, "
            "or the run is refused", .source = "guess"},
};
/* clang-format on */

static double delays(const lanes *p, int i) { return fabs(p[TIME_LATE][i]) >= NO_TIME ? p[TIME_LATE][i] : 0; }

/* clang-format off */
const struct Effect effect_input_delay = {
    .equation = "slip velocity = slip_velocity(t - tau)",
    .signature = "force over velocity opens into a loop that grows with frequency, with its sign; other inputs are in time",
    .rivals = "sensor_delay",
    .needs = "slip_velocity", .applies_to = "external",
    .family = "lag",
    .stage = STAGE_PATH, .delays = delays,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
