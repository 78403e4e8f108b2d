/* Which model do the shells carry in this FMU? A partner of the contact: machines/parts/tool_heat.c. */
#include "../machines/machine.h"
