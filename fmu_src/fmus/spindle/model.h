/* Which model do the shells carry in this FMU? A partner of the contact: machines/parts/spindle.c. */
#include "../machines/machine.h"
