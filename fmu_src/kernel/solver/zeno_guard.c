/* When are steps without end, as those of Zeno? Contact that opens and closes at no speed, forces that chase one
 * another. A stretch of time that the steps pass in `few` where nothing happens may take so many times more. An ellipse
 * takes up to 60 a cycle at the usual tolerance, steps shrink with its fourth root, a law with events of its own may
 * break bonds at each of them, however small they are, so that these count as steps and not as events, and a ripple of
 * friction over a long way has thousands of periods, which break no more bonds than friction without it. A record's
 * samples may lie so near to one another that none of them alone shows it: the stretch goes on over them.
 */
#include "../stages.h"

#include <math.h>

void guard_stretch(const struct Contact *contact, const struct Configuration *w, struct ZenoGuard *p)
{
    const double few = 20, usual = w->current_angle ? 1000 : 4000, breaks = w->law->rest ? 24 * usual : 0;
    const int goes_on = p->length > 0 && p->length < INFINITY;
    p->length = few * w->longest[0];
    p->most = (usual * w->finer[0] + breaks) * (w->comes_back ? 100 : 1);
    p->most_events = 200;
    p->most_breaks = w->law->rest ? breaks : INFINITY;
    if (!goes_on) {
        p->begun = contact->value[VAR_TIME][0];
        p->taken = p->events = p->breaks = 0;
    }
}

/* Is the step that begins at s, the n-th of this communication step, one too many? The slowest lane counts; each lane
 * moves on in each step. Two steps are what a communication step takes in any case. */
int is_without_end(const struct Contact *contact, struct ZenoGuard *p, double step, const lanes s, double n)
{
    double slowest = INFINITY;
    EACH_LANE
        slowest = s[i] < step ? smaller(slowest, s[i]) : slowest;
    slowest += contact->value[VAR_TIME][0];
    if (slowest > p->begun + p->length) {
        p->begun = slowest;
        p->taken = p->events = p->breaks = 0;
    }
    p->taken += n >= 2;
    return p->taken > p->most || p->events > p->most_events || p->breaks > p->most_breaks;
}
