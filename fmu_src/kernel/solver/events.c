/* What does an event in one lane leave to the others? Everything, to the last bit. */
#include "../stages.h"

/* What an event in one lane must not touch in another. */
struct Aside {
    lanes sign[INDICATORS], memory[MEMORY], z, state[EFFECT_STATES];
    struct Point point;
};

void act_in_lanes(struct Contact *contact, const struct Configuration *w, const lanes s, const lanes ahead,
                  const int chased[LANES], const int event[LANES], struct Point *x)
{
    struct Aside aside;
    int all = 1;
    EACH_LANE
        all &= event[i];
    if (!all) {
        aside.point = *x;
        load_states(contact, w, &aside.point);
        for (int i = 0; i < LANES; ++i) {
            copy_lane(aside.sign, (const lanes *)contact->sign, INDICATORS, i);
            copy_lane(aside.memory, (const lanes *)contact->memory, MEMORY, i);
            aside.z[i] = contact->value[VAR_BRISTLE_DEFLECTION][i];
        }
    }
    act_on_event(contact, w, s, ahead, chased, x);
    for (int i = 0; i < LANES && !all; ++i) {
        if (event[i])
            continue;
        copy_lane(contact->sign, (const lanes *)aside.sign, INDICATORS, i);
        copy_lane(contact->memory, (const lanes *)aside.memory, MEMORY, i);
        contact->value[VAR_BRISTLE_DEFLECTION][i] = aside.z[i];
        store_state_of(contact, w, &aside.point, i);
        copy_lane((lanes *)x, (const lanes *)&aside.point, POINT_LANES, i);
    }
}

void act_at_step_end(struct Contact *contact, const struct Configuration *w, const lanes h, const int event[LANES],
                     const struct Point *end)
{
    lanes z, memory[MEMORY];
    EACH_LANE
        z[i] = contact->value[VAR_BRISTLE_DEFLECTION][i];
    for (int i = 0; i < LANES; ++i)
        copy_lane(memory, (const lanes *)contact->memory, MEMORY, i);
    w->law->event(w->law_p, end, contact->value[VAR_BRISTLE_DEFLECTION], contact->memory);
    for (int i = 0; i < LANES; ++i) {
        if (h[i] > 0 && !event[i])
            continue;
        contact->value[VAR_BRISTLE_DEFLECTION][i] = z[i];
        copy_lane(contact->memory, (const lanes *)memory, MEMORY, i);
    }
}

/* Which side of its own event the law is on, at the point x that stands at s: what has begun to slide goes on sliding.
 */
void take_law_side(struct Contact *contact, const struct Configuration *w, const lanes s, const lanes h,
                   const int event[LANES], struct Point *x)
{
    int changed = 0;
    for (int i = 0; i < LANES; ++i) {
        const double side = x->law[i] > 0 ? 1 : -1;
        if (!(h[i] > 0) || event[i] || side == contact->sign[AT_LAW][i])
            continue;
        contact->sign[AT_LAW][i] = side;
        changed = 1;
    }
    if (changed)
        point_at(contact, w, s, x);
}
