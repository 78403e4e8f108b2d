/* Which surface has the tool left one revolution ago? The reference keeps it as exactly as it keeps states, by the
 * polynomial through the nodes of each step; the kernel by a parabola, and in fewer pieces where it has no room. */
#include "course.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* On the polynomial through the heights of one step. */
static double within(const struct Course *c, const struct Left *left, double t)
{
    double place[1 + STAGES_OF_RADAU] = {0}, sum = 0;
    const double at = (t - left->start) / left->length;
    memcpy(place + 1, c->radau.c, sizeof c->radau.c);
    for (int k = 0; k <= STAGES_OF_RADAU; ++k) {
        double share = left->height[k];
        for (int m = 0; m <= STAGES_OF_RADAU; ++m)
            share *= m == k ? 1 : (at - place[m]) / (place[k] - place[m]);
        sum += share;
    }
    return sum;
}

/* The surface that was left one turn before t. The first turn meets the nominal one. */
static double met(const struct Course *c, double t)
{
    const double before = fmax(t - c->turn, c->motion->times[0] + (c->turns - 1) * c->turn);
    int64_t low = 0, high = c->left_count - 1;
    if (c->turns == 0)
        return 0;
    while (low < high) {
        const int64_t half = (low + high + 1) / 2;
        if (c->left[half].start <= before)
            low = half;
        else
            high = half - 1;
    }
    return within(c, &c->left[low], before);
}

/* The kernel looks its own surface up in the one piece that there is: all of it is the right height. */
void surface_meet(struct Course *c, double t)
{
    if (!(c->turn > 0))
        return;
    struct Contact *const contact = c->contact;
    contact->surface.count[0] = c->turns > 0;
    contact->surface.end[0][0] = t - (1 - 1e-6) * c->turn;
    contact->surface.length[0][0] = 2e-6 * c->turn;
    for (int n = 0; n < NODES; ++n)
        contact->surface_height[0][n][0] = met(c, t);
}

/* The height that the tool leaves at the contact's present time, over the nominal surface. */
static double leaves(const struct Course *c)
{
    const double t = parameter(c, VAR_TIME);
    double tool = 0;
    if ((int)parameter(c, VAR_KINEMATICS) == KINEMATICS_COMBINED)
        tool += parameter(c, VAR_TOOL_DISPLACEMENT_Y);
    if (course_named(c, "holder_compliance") != 0)
        tool += course_named(c, "holder_compliance.displacement_y");
    if (course_named(c, "run_out") != 0)
        tool -= course_named(c, "run_out.amplitude") *
                sin(6.283185307179586 * course_named(c, "run_out.spindle_frequency") * t +
                    course_named(c, "run_out.phase"));
    return fmin(tool, course_named(c, "regenerative.share") * met(c, t) + parameter(c, VAR_FEED));
}

void surface_leave(struct Course *c, double h, const struct Step *step)
{
    if (!(c->turn > 0))
        return;
    if (c->left_count == c->left_room) {
        c->left_room = 2 * c->left_room + 64;
        c->left = realloc(c->left, (size_t)c->left_room * sizeof *c->left);
    }
    struct Left *const left = &c->left[c->left_count++];
    left->start = c->t;
    left->length = h;
    for (int k = 0; k <= STAGES_OF_RADAU; ++k) {
        course_put(c, k ? c->t + c->radau.c[k - 1] * h : c->t, k ? step->node[k - 1] : c->y);
        left->height[k] = leaves(c);
    }
}

double surface_next_turn(const struct Course *c)
{
    return c->turn > 0 ? c->motion->times[0] + (c->turns + 1) * c->turn : INFINITY;
}
