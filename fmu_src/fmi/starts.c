/* Which values does this FMU start with, beside those of its model's tables? None; an FMU that has some brings a file
 * of its own in the place of this one. */
#include "component.h"

const struct Start fmu_starts[] = {{MODEL_TIME, 0}};
