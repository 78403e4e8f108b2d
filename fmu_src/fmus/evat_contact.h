/* What does the FMU EvatContact show beyond the kernel's tables? Nothing but which variable stands for an argument of the standard.
 *
 * Value reference = index in the kernel's tables; an enumeration's item = kernel value + 1 (the items of FMI start at 1).
 */
#ifndef EVAT_CONTACT_H
#define EVAT_CONTACT_H

#include "../kernel/kernel.h"

enum { TOLERANCE_ARGUMENT = RELATIVE_TOLERANCE }; /* FMI's `tolerance` of the experiment */

#endif
