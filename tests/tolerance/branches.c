/* Does more than one slip go with a state, where the chip flows by the angle of the moment?
 *
 * At a fixed shear angle slip and friction follow in closed form, and from them the shear angle that goes with these
 * forces. A slip is an answer where both angles are the same: a change of sign of their difference. Friction that falls
 * with speed may have three, of which nothing but the way there says which one holds; and the kernel, which goes on
 * from the slip it has found last, need not hold the one that a look from nowhere finds.
 */
#include "course.h"

#include <math.h>

#define FLATTEST 0.02
#define STEEPEST 1.5 /* less the rake angle */
#define DECADES 10
#define PER_DECADE 12

/* The contact with a shear angle that is given by its tangent, less the rake angle. */
struct Probe {
    struct Contact contact;
    double rake;
};

/* The slip, and how much steeper the plane of the forces is. */
static double difference(struct Probe *probe, double tangent, int side, double *slip)
{
    const double angle = probe->rake + atan(tangent);
    probe->contact.value[VAR_CONSTANT_SHEAR_ANGLE][0] = angle;
    probe->contact.sign[AT_SLIP][0] = side;
    kernel_evaluate(&probe->contact);
    *slip = probe->contact.value[VAR_SLIP_VELOCITY_USED][0];
    return probe->contact.value[VAR_SHEAR_ANGLE][0] - angle;
}

static double at_rest(struct Probe *probe, double flat, double steep)
{
    double low = flat, high = steep, slip, first;
    difference(probe, low, 1, &first);
    for (int n = 0; n < 100; ++n) {
        const double half = 0.5 * (low + high);
        difference(probe, half, 1, &slip);
        *((slip < 0) == (first < 0) ? &low : &high) = half;
    }
    return 0.5 * (low + high);
}

int branches_at(const struct Contact *contact)
{
    struct Probe probe = {*contact, contact->value[VAR_RAKE_ANGLE][0]};
    probe.contact.value[VAR_CHIP_FLOW_ANGLE][0] = CONSTANT_ANGLE;
    const double flat = tan(FLATTEST - probe.rake), steep = tan(STEEPEST), rest = at_rest(&probe, flat, steep);
    int count = 0, places = 2 * DECADES * PER_DECADE;
    double before = 1; /* beyond the flattest plane it is always the steeper one that is asked for */
    for (int n = 0; n <= places + 1; ++n) {
        const int below = n <= DECADES * PER_DECADE, from_rest = below ? n : places + 1 - n;
        const double end = below ? flat : steep, share = pow(10, -from_rest / (double)PER_DECADE);
        const double tangent = rest + share * (end - rest);
        double slip;
        difference(&probe, tangent, 1, &slip);
        const double now = difference(&probe, tangent, slip < 0 ? -1 : 1, &slip);
        count += (now > 0) != (before > 0);
        before = now;
    }
    return count + (before > 0);
}
