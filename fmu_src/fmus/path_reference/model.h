/* Which model do the shells carry in this FMU? A partner of the contact: machines/parts/path_reference.c. */
#include "../machines/machine.h"
