/* As what does this program show its model? As the whole model, with the values of its tables. The builder writes a
 * file of its own in the place of this one: of each FMU that carries the model its token, its starts, and what it
 * shows. */
#include "component.h"

const struct Variant fmu_variants[] = {{.name = ""}};
const int fmu_variant_count = 1;
