/* Which model do the shells carry in this FMU? A partner of the contact: machines/parts/feed_drive.c. */
#include "../machines/machine.h"
