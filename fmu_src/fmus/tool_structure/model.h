/* Which model do the shells carry in this FMU? A partner of the contact: machines/parts/tool_structure.c. */
#include "../machines/machine.h"
