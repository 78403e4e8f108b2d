/* Which model do the shells carry in the FMU EvatContact? The contact, and which of its variables stands for an
 * argument of the standard.
 *
 * Every FMU has a file of this name in a folder of its own, which is among the includes where it is compiled; in the
 * sources that travel in an FMU it lies beside component.h, so its own includes are written from there. Value reference
 * = index in the model's tables; an enumeration's item = value there + 1 (the items of FMI start at 1).
 */
#ifndef MODEL_H
#define MODEL_H

#include "../kernel/kernel.h"

enum { TOLERANCE_ARGUMENT = VAR_RELATIVE_TOLERANCE }; /* FMI's `tolerance` of the experiment */

#endif
