/* What is said of every quantity, and how may a call end, whatever model it belongs to? One row of a table, and the
 * statuses. The contact and its partners (machines/) write their tables in these words, and the FMI shells, Python and
 * the documentation read them.
 */
#ifndef TABLES_H
#define TABLES_H

#include "names.h"

enum Type { REAL, INTEGER, BOOLEAN, CHOICE };
enum Causality { INDEPENDENT, PARAMETER, CALCULATED, INPUT, OUTPUT, LOCAL };
enum Variability { FIXED, TUNABLE, DISCRETE, CONTINUOUS };

struct Variable {
    const char *name, *unit, *display_unit; /* unit "1": dimensionless; display_unit may be NULL */
    double start, min, max, nominal;        /* in `unit`; nominal 0 stands for 1 */
    const char *meaning, *source;           /* source "guess" where nothing better is known */
    enum Type type;
    enum Causality causality;
    enum Variability variability;
    const char *const *choices; /* CHOICE: the names, ended by NULL; the value is the place in the list */
    int derivative_of; /* index of the state whose rate this is; 0: none (of an effect's: see kernel_derivative_of) */
    const char *required_with; /* of an input of the contact: the kinematics, comma-separated, with which whoever reads
                                  it needs it given; with others it is computed, or its start will do; NULL: with all */
    double neutral; /* of an effect's parameter: with all at their neutral values on equals off; NAN: shape, has no say;
                       of a law's parameter: the published law's value, where that is not 0 */
    int difference; /* of a temperature: a difference of two, to which no offset of a display unit is added */
    int reference; /* of a law's parameter: is its value a convention, at which others are said, and nothing to measure?
                    */
    double prior_sd; /* of an effect's parameter: standard deviation about `neutral` in ordinary rigs; 0: nobody says */
};

/* Bit of a model's warnings that all models have. */
enum { WARN_AT_BOUND = 1 }; /* an input was given a hair outside its bounds, and is held on them */

enum Status { /* status_text says each in words */
              STATUS_OK,
              STATUS_NO_SUCH_VARIABLE,
              STATUS_NOT_FINITE,
              STATUS_OUT_OF_BOUNDS,
              STATUS_BAD_STEP,
              STATUS_DIVERGED,
              /* of the contact alone */
              STATUS_TOO_MANY_STEPS,
              STATUS_TEMPERATURES,
              STATUS_RIVALS,
              STATUS_HISTORY_SHORT,
              STATUS_STOPPED,
              STATUS_NO_CYCLE,
              STATUS_AHEAD,
              STATUS_COUNT
};

#endif
