/* How is a row of a partner's table written? What the rows have in common. */
#ifndef ROWS_H
#define ROWS_H

#include "machine.h"

#include <math.h>

#define PI 3.14159265358979323846
#define CLOCK                                                                                                          \
    {.name = "time",                                                                                                   \
     .unit = "s",                                                                                                      \
     .min = -INFINITY,                                                                                                 \
     .max = INFINITY,                                                                                                  \
     .causality = INDEPENDENT,                                                                                         \
     .variability = CONTINUOUS,                                                                                        \
     .meaning = "simulation time",                                                                                     \
     .source = DEFINITION}
#define GIVEN .causality = INPUT, .variability = CONTINUOUS
#define TUNED .causality = PARAMETER, .variability = TUNABLE
#define SWITCH .unit = "1", .type = BOOLEAN, .max = 1, .causality = PARAMETER, .variability = FIXED
#define RESULT .causality = OUTPUT, .variability = CONTINUOUS, .min = -INFINITY, .max = INFINITY
#define INNER .causality = LOCAL, .variability = CONTINUOUS, .min = -INFINITY, .max = INFINITY
#define NEWTON "Newton's second law"
#define DEFINITION "definition"

#endif
