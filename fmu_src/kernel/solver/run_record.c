/* How does a contact follow a record? Sample by sample with inputs linear in between, giving whole rows, or sums
 * against data. */
#include "../shared.h"
#include "../stages.h"

#include <math.h>

/* Input j at sample n as it is given: one number, or one for each lane. */
static const double *sample_of(const struct Record *r, int64_t n, int j)
{
    return r->inputs + (n * r->input_count + j) * (r->per_lane ? LANES : 1);
}

/* Inputs that lead to sample n, and their slopes from the one before. */
static enum Status set_slopes(struct Contact *contact, const struct Record *r, int64_t n)
{
    const double step = n > 0 ? r->times[n] - r->times[n - 1] : 1;
    for (int j = 0; j < r->input_count; ++j) {
        const int index = r->input_index[j];
        const struct Variable *const v = kernel_variable(index);
        const double *const now = sample_of(r, n, j), *const before = n > 0 ? sample_of(r, n - 1, j) : now;
        double *const slope = contact->slope[index - INPUT_FIRST];
        for (int i = 0; i < (r->per_lane ? LANES : 1); ++i) {
            const enum Status status = check_value(v, now[i]);
            if (status != STATUS_OK)
                return status;
        }
        if (r->per_lane)
            EACH_LANE
                slope[i] = (within_bounds(v, now[i]) - within_bounds(v, before[i])) / step;
        else {
            const double shared = (within_bounds(v, *now) - within_bounds(v, *before)) / step;
            EACH_LANE
                slope[i] = shared;
        }
        int outside = 0;
        for (int i = 0; i < (r->per_lane ? LANES : 1); ++i)
            outside |= (now[i] < v->min) | (now[i] > v->max);
        for (int i = 0; outside && i < LANES; ++i) { /* a step is clamped that begins or ends so */
            const double given = now[r->per_lane ? i : 0];
            if (given < v->min || given > v->max)
                note_bound(contact, index, i, 1);
        }
    }
    return STATUS_OK;
}

static void land(struct Contact *contact, const struct Record *r, int64_t n)
{
    const double time = r->times[n];
    EACH_LANE
        contact->value[VAR_TIME][i] = time;
    for (int j = 0; j < r->input_count; ++j) {
        const struct Variable *const v = kernel_variable(r->input_index[j]);
        const double *const now = sample_of(r, n, j);
        double *const value = contact->value[r->input_index[j]], *const slope =
                                                                     contact->slope[r->input_index[j] - INPUT_FIRST];
        if (r->per_lane)
            EACH_LANE
                value[i] = within_bounds(v, now[i]);
        else {
            const double shared = within_bounds(v, *now);
            EACH_LANE
                value[i] = shared;
        }
        int noted = 0;
        EACH_LANE {
            slope[i] = 0;
            noted |= contact->at_bound[i] != 0;
        }
        for (int i = 0; i < (r->per_lane ? LANES : 1); ++i)
            noted |= now[i] != value[i];
        for (int i = 0; noted && i < LANES; ++i)
            note_bound(contact, r->input_index[j], i, now[r->per_lane ? i : 0] != value[i]);
    }
}

/* A slip that is felt late or early is looked up in the record. */
static void look_up_in(const struct Record *r, struct Configuration *w)
{
    for (int j = 0; j < r->input_count && w->delays; ++j)
        if (r->input_index[j] == VAR_SLIP_VELOCITY) {
            w->record = r;
            w->slip_column = j;
        }
}

/* What a step after the record may look back to: until then the past before the record is kept. */
static void note_samples(struct Contact *contact, const struct Configuration *w, int64_t done)
{
    const struct Record *const r = w->record;
    for (int64_t n = 0; n < done; ++n)
        for (int i = 0; i < LANES; ++i)
            note_slip(contact, w, i, r->times[n], sample_of(r, n, w->slip_column)[r->per_lane ? i : 0]);
}

/* In which lanes does a point that a step has passed through show all there is? Not out of contact, nor where rates
 * wait for the deflection, nor where slip or thickness are given as just 0: the step missed that by a rounding, and it
 * means rest, or no contact. Returns whether in all. */
static int find_whole(const struct Contact *contact, const struct Configuration *w, const struct Point *x,
                      int whole[LANES])
{
    int all = 1;
    EACH_LANE {
        const int given = w->kinematics == KINEMATICS_EXTERNAL;
        const int zero = (contact->value[VAR_SLIP_VELOCITY][i] == 0) | (contact->value[VAR_UNCUT_THICKNESS][i] == 0);
        whole[i] = (x->cutting[i] != 0) & !w->iterated[i] & !(given & zero);
        all &= whole[i];
    }
    return all;
}

/* What is not finite is not given. */
static enum Status give(const struct Contact *contact, struct Yield *y)
{
    int lost = 0;
    for (int j = 0; j < y->output_count; ++j)
        EACH_LANE
            lost |= !(fabs(contact->value[y->output_index[j]][i]) < INFINITY);
    if (lost)
        return STATUS_DIVERGED;
    for (int j = 0; j < y->output_count; ++j) {
        const double *value = contact->value[y->output_index[j]];
        const int64_t cell = y->rows_done * y->output_count + j;
        const double data = y->squares ? y->data[cell] : NAN;
        for (int i = 0; i < LANES && y->rows; ++i)
            y->rows[cell * LANES + i] = value[i];
        for (int i = 0; i < LANES && y->sums; ++i)
            y->sums[j * LANES + i] += value[i];
        for (int i = 0; i < LANES && !isnan(data); ++i)
            y->squares[j * LANES + i] += (value[i] - data) * (value[i] - data);
    }
    y->rows_done += 1;
    return STATUS_OK;
}

/* What is left of the steps that a lane may take; none left is an error. */
static enum Status within(const struct Contact *contact, double most, double *left)
{
    double taken = 0;
    for (int i = 0; i < LANES; ++i)
        if (contact->value[VAR_STEP_COUNT][i] > taken)
            taken = contact->value[VAR_STEP_COUNT][i];
    *left = most - taken;
    return *left > 0 ? STATUS_OK : STATUS_TOO_MANY_STEPS;
}

enum Status kernel_run_record(struct Contact *contact, const struct Record *record, struct Yield *yield,
                              const volatile int *stop)
{
    struct Configuration w = wire(contact);
    struct Course course;
    look_up_in(record, &w);
    course.now = course.known = 0;
    course.guard.length = 0;
    course.most_steps = record->most_steps;
    const int averages = kernel_averages(contact);
    const int plainly = shows_plainly(yield->output_count, yield->output_index);
    int angles = 0;
    for (int j = 0; j < yield->output_count; ++j)
        angles |= yield->output_index[j] == VAR_SHEAR_ANGLE || yield->output_index[j] == VAR_CUSP_HEIGHT;
    enum Status status = ordered_temperatures(contact) ? STATUS_OK : STATUS_TEMPERATURES;
    for (int64_t n = 0; n < record->count && status == STATUS_OK; ++n) {
        yield->samples_done = n;
        status = stop && *stop ? STATUS_STOPPED : set_slopes(contact, record, n);
        if (status == STATUS_OK && n > 0) {
            const double step = record->times[n] - record->times[n - 1];
            lanes s = {0};
            const int was_held = w.held;
            wire_time(contact, &w);
            /* The last point missed its sample by a rounding, and a rest stands on the sample itself: a thickness of
             * just 0 is none. */
            course.known &= was_held || !w.held;
            status = !is_step(step) ? STATUS_BAD_STEP
                     : averages     ? average_step(contact, step)
                                    : advance_cycles(contact, &w, step, 0, s, &course);
            if (status == STATUS_OK && record->most_steps > 0)
                status = within(contact, record->most_steps, &course.most_steps);
        }
        if (status != STATUS_OK)
            break;
        land(contact, record, n);
        if (w.delays) {
            if (!w.record || n == 0)
                note_slip_now(contact, &w);
            status = feel_slip_now(contact, &w);
            if (status != STATUS_OK)
                break;
            course.known = 0;
        }
        const struct Point *const passed = &course.room[course.now].point;
        if (!record->keep || record->keep[n]) {
            const int shown = angles || n == record->count - 1;
            int whole[LANES];
            const int all_whole = course.known && find_whole(contact, &w, passed, whole);
            if (averages)
                ; /* the step has shown its means */
            else if (all_whole && plainly && n < record->count - 1)
                show_some(contact, passed, yield->output_count, yield->output_index);
            else if (all_whole)
                show_outputs(contact, &w, passed, shown);
            else {
                wire_time(contact, &w);
                status = show_here(contact, &w, course.known ? passed : NULL, whole, shown);
            }
            status = status == STATUS_OK ? give(contact, yield) : status;
        }
        yield->samples_done = n + (status == STATUS_OK);
    }
    if (w.record)
        note_samples(contact, &w, yield->samples_done);
    return status;
}
