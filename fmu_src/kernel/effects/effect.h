/* What do the tables of all effects have in common? */
#ifndef EFFECT_H
#define EFFECT_H

#include "../stages.h"

#include <math.h>

#define SWITCH .unit = "1", .max = 1, .type = BOOLEAN, .causality = PARAMETER, .variability = FIXED
#define SHAPE .neutral = NAN
#define STATE .causality = LOCAL, .variability = CONTINUOUS, .min = -INFINITY, .max = INFINITY

/* What an effect does has a kink: on which side of it is x? Between two sides a step looks closer. */
static inline void mark_side(struct Point *x, int lane, int side) { x->piece[lane] = 2 * x->piece[lane] + side; }

#endif
