/* The communication step, the power balance over it, and the calls of FMI. */
#include "coupling.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* Types of FMI 2 and 3; where both have a function, that of FMI 3 is told the count of the values, too. */
typedef int SetValues2(void *instance, const uint32_t *references, size_t count, const double *values);
typedef int SetValues3(void *instance, const uint32_t *references, size_t count, const double *values, size_t values_n);
typedef int SetSlopes2(void *instance, const uint32_t *references, size_t count, const int *orders,
                       const double *rates);
typedef int GetValues2(void *instance, const uint32_t *references, size_t count, void *values);
typedef int GetValues3(void *instance, const uint32_t *references, size_t count, void *values, size_t values_n);
typedef int DoStep2(void *instance, double time, double step, int no_way_back);
typedef int DoStep3(void *instance, double time, double step, _Bool no_way_back, _Bool *event, _Bool *terminate,
                    _Bool *early, double *reached);
enum { FMI_WARNING = 1 }; /* the last status that lets a run go on */

static int went_well(struct Coupling *c, const struct Member *m, const struct Function *called, int status)
{
    if (status <= FMI_WARNING && status != ASKS_TO_END)
        return 1;
    c->failed = (int)(m - c->members);
    c->function = called->name;
    c->status = status;
    return 0;
}

/* ---- calls ---- */

static int set_inputs(struct Coupling *c, const struct Member *m, const double *values)
{
    const struct Function *set = &m->set_inputs;
    const size_t count = (size_t)m->input_count;
    return went_well(c, m, set,
                     m->fmi == 2 ? ((SetValues2 *)set->address)(m->instance, m->inputs, count, values)
                                 : ((SetValues3 *)set->address)(m->instance, m->inputs, count, values, count));
}

/* Over the step the inputs go from where they stand to `ahead`: linearly, or where the FMU cannot, at their mean. */
static int lead_inputs(struct Coupling *c, const struct Member *m, double step)
{
    for (int i = 0; i < m->input_count; ++i) {
        const double now = c->signals[m->sources[i]];
        m->told[i] = m->slopes ? (m->ahead[i] - now) / step : 0.5 * (now + m->ahead[i]);
    }
    if (!m->slopes)
        return set_inputs(c, m, m->told);
    SetSlopes2 *set_slopes = (SetSlopes2 *)m->set_slopes.address;
    return went_well(c, m, &m->set_slopes,
                     set_slopes(m->instance, m->inputs, (size_t)m->input_count, m->orders, m->told));
}

static int do_step(struct Coupling *c, const struct Member *m, double time, double step)
{
    _Bool event = 0, ends = 0, early = 0;
    double reached = time;
    const struct Function *call = &m->do_step;
    const int status = m->fmi == 2
                           ? ((DoStep2 *)call->address)(m->instance, time, step, 1)
                           : ((DoStep3 *)call->address)(m->instance, time, step, 1, &event, &ends, &early, &reached);
    return went_well(c, m, call, status <= FMI_WARNING && ends ? ASKS_TO_END : status);
}

static double number(const void *values, int form, int i)
{
    switch ((enum Form)form) {
    case FLOAT32:
        return (double)((const float *)values)[i];
    case INT8:
        return ((const int8_t *)values)[i];
    case UINT8:
        return ((const uint8_t *)values)[i];
    case INT16:
        return ((const int16_t *)values)[i];
    case UINT16:
        return ((const uint16_t *)values)[i];
    case INT32:
        return ((const int32_t *)values)[i];
    case UINT32:
        return ((const uint32_t *)values)[i];
    case INT64:
        return (double)((const int64_t *)values)[i];
    case UINT64:
        return (double)((const uint64_t *)values)[i];
    case BOOLEAN:
        return ((const _Bool *)values)[i];
    case FLOAT64:
        break;
    }
    return ((const double *)values)[i];
}

static int show(struct Coupling *c, const struct Member *m, double *signals)
{
    for (const struct Outputs *o = m->outputs; o < m->outputs + m->call_count; ++o) {
        const size_t count = (size_t)o->count;
        const int status = m->fmi == 2
                               ? ((GetValues2 *)o->get.address)(m->instance, o->references, count, c->buffer)
                               : ((GetValues3 *)o->get.address)(m->instance, o->references, count, c->buffer, count);
        if (!went_well(c, m, &o->get, status))
            return 0;
        for (int i = 0; i < o->count; ++i) {
            const double shown = number(c->buffer, o->form, i);
            if (!isfinite(shown)) {
                c->failed = (int)(m - c->members);
                c->status = 0;
                c->place = o->places[i];
                c->shown = shown;
                return 0;
            }
            signals[o->places[i]] = shown;
        }
    }
    return 1;
}

/* ---- the power balance ---- */

/* Of a force on a velocity that are linear over a step of 1 s. */
static double work(double f_0, double f_1, double v_0, double v_1)
{
    return (2 * f_0 * v_0 + f_0 * v_1 + f_1 * v_0 + 2 * f_1 * v_1) / 6;
}

/* A member has moved: what it saw at the end of the step, and what it shows there. */
static void note_power(struct Coupling *c, const struct Member *m, const double *signals)
{
    const int member = (int)(m - c->members);
    for (struct Bond *b = c->bonds; b < c->bonds + c->bond_count; ++b) {
        if (member == b->force_side) {
            b->velocity_received = b->velocity_input < 0 ? signals[b->velocity] : m->ahead[b->velocity_input];
            b->force_sent = signals[b->force];
        }
        if (member == b->velocity_side) {
            b->force_received = b->force_input < 0 ? signals[b->force] : m->ahead[b->force_input];
            b->velocity_sent = signals[b->velocity];
        }
    }
}

static void add_power(struct Coupling *c, double step)
{
    for (struct Bond *b = c->bonds; b < c->bonds + c->bond_count; ++b) {
        const double f_0 = c->signals[b->force], v_0 = c->signals[b->velocity];
        const double one = work(f_0, b->force_sent, v_0, b->velocity_received) * step;
        const double other = work(f_0, b->force_received, v_0, b->velocity_sent) * step;
        b->made += b->against ? one - other : other - one; /* what is taken less what is given */
        b->moved += fabs(other - one);
        b->passed += fabs(other);
    }
}

/* ---- the step ---- */

static void gather(const struct Member *m, const double *signals, double *values)
{
    for (int i = 0; i < m->input_count; ++i)
        values[i] = signals[m->sources[i]];
}

int coupling_set(struct Coupling *c, int member)
{
    const struct Member *m = &c->members[member];
    gather(m, c->signals, m->held);
    return m->input_count == 0 || set_inputs(c, m, m->held);
}

int coupling_show(struct Coupling *c, int member) { return show(c, &c->members[member], c->signals); }

static int move(struct Coupling *c, const struct Member *m, double time, double step)
{
    gather(m, c->jacobi ? c->guess : c->then, m->ahead);
    if (m->input_count > 0 && !lead_inputs(c, m, step))
        return 0;
    if (!do_step(c, m, time, step))
        return 0;
    if (m->input_count > 0 && !set_inputs(c, m, m->ahead))
        return 0;
    memcpy(m->held, m->ahead, (size_t)m->input_count * sizeof *m->held);
    return show(c, m, c->then);
}

/* Outputs that follow inputs at once pass a change on from member to member, one in a pass at least; a loop in which a
 * tenth of it is lost each time is done with it, too. */
#define MOST_PASSES 220
#define SETTLED 2e-10 /* share of the largest that an input has been, in passes after the first, which hands on all */

/* Beside the input itself no change would be small on its way to 0: each leaves as large a share. */
static int moves(double held, double turned_out, double *largest, int pass)
{
    *largest = fmax(pass == 0 ? fabs(held) : *largest, fabs(turned_out));
    return pass == 0 ? held != turned_out : fabs(turned_out - held) > SETTLED * *largest;
}

/* Inputs as they have turned out. What would be set to what it is, is left alone. Answers 0 where the member failed. */
static int settle(struct Coupling *c, const struct Member *m, int pass, int *moved)
{
    int place = -1;
    gather(m, c->signals, m->told);
    for (int i = 0; i < m->input_count; ++i)
        place = moves(m->held[i], m->told[i], &m->largest[i], pass) ? m->sources[i] : place;
    if (place < 0)
        return 1;
    *moved = 1;
    c->failed = (int)(m - c->members);
    c->place = place;
    memcpy(m->held, m->told, (size_t)m->input_count * sizeof *m->held);
    return set_inputs(c, m, m->held) && show(c, m, c->signals);
}

int coupling_settle(struct Coupling *c)
{
    int moved = 1;
    for (int pass = 0; moved && pass < MOST_PASSES; ++pass) {
        moved = 0;
        for (struct Member *m = c->members; m < c->members + c->member_count; ++m)
            if (!settle(c, m, pass, &moved))
                return 0;
    }
    if (moved)
        c->status = NOT_SETTLED;
    return !moved;
}

#define ROUNDING 1e-6 /* of a step: one that ends no further behind a time ends there, 3 steps of 0.1 s at 0.3 s */

static int one_step(struct Coupling *c, double begin, double end, const double *given)
{
    const double step = end - begin;
    const size_t all = (size_t)c->signal_count * sizeof *c->signals;
    for (int i = 0; i < c->shown_count; ++i) /* what a source that has not moved yet is taken to show at the end */
        c->guess[i] = c->signals[i] + step * c->rates[i];
    for (int i = c->shown_count; i < c->signal_count; ++i)
        c->guess[i] = given[i - c->shown_count];
    memcpy(c->then, c->guess, all);
    for (struct Member *m = c->members; m < c->members + c->member_count; ++m) {
        if (!move(c, m, begin, step))
            return 0;
        note_power(c, m, c->then);
    }
    add_power(c, step);
    memcpy(c->guess, c->signals, all); /* as they were */
    memcpy(c->signals, c->then, all);
    if (!coupling_settle(c))
        return 0;
    for (int i = 0; i < c->shown_count && c->continued; ++i)
        c->rates[i] = (c->signals[i] - c->guess[i]) / step;
    if (end > c->averaged_from + ROUNDING * step) {
        for (int i = 0; i < c->shown_count; ++i)
            c->integrals[i] += step * 0.5 * (c->guess[i] + c->signals[i]);
        c->averaged += step;
    }
    return 1;
}

static void keep(struct Coupling *c)
{
    for (int i = 0; i < c->shown_count; ++i)
        c->table[i * c->rows + c->kept] = c->signals[i];
    ++c->kept;
}

int coupling_steps(struct Coupling *c, int64_t count, const double *times, const double *given)
{
    for (int64_t n = 0; n < count; ++n) {
        if (!one_step(c, times[n], times[n + 1], given + n * (c->signal_count - c->shown_count)))
            return 0;
        ++c->done;
        if (c->done % c->every == 0 || c->done == c->count)
            keep(c);
    }
    return 1;
}
