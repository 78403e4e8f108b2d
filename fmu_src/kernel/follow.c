/* How does a contact follow a record? Sample by sample with inputs linear in between, giving whole rows, or sums against data. */
#include "stages.h"

#include <math.h>

static double sample_of(const struct Record *r, int64_t n, int j, int lane)
{
    const int64_t at = n * r->input_count + j;
    return r->per_lane ? r->inputs[at * LANES + lane] : r->inputs[at];
}

/* Inputs that lead to sample n, and their slopes from the one before. */
static enum Status set_slopes(struct Contact *contact, const struct Record *r, int64_t n)
{
    const double step = n > 0 ? r->times[n] - r->times[n - 1] : 0;
    for (int j = 0; j < r->input_count; ++j)
        EACH_LANE {
            const double now = sample_of(r, n, j, i);
            const enum Status status = i == 0 || r->per_lane ? kernel_check(r->input_index[j], now) : KERNEL_OK;
            if (status != KERNEL_OK)
                return status;
            contact->slope[r->input_index[j] - INPUT_FIRST][i] = n > 0 ? (now - sample_of(r, n - 1, j, i)) / step : 0;
        }
    return KERNEL_OK;
}

static void land(struct Contact *contact, const struct Record *r, int64_t n)
{
    EACH_LANE contact->value[TIME][i] = r->times[n];
    for (int j = 0; j < r->input_count; ++j)
        EACH_LANE {
            contact->value[r->input_index[j]][i] = sample_of(r, n, j, i);
            contact->slope[r->input_index[j] - INPUT_FIRST][i] = 0;
        }
}

/* A point that a step has passed through shows all there is, but out of contact, and where rates wait for the deflection. */
static int is_whole(const struct Wiring *w, const struct Point *x)
{
    int cutting = 1;
    EACH_LANE cutting &= x->cutting[i] != 0;
    return cutting && !w->iterates;
}

static void give(const struct Contact *contact, struct Yield *y)
{
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
}

enum Status kernel_follow(struct Contact *contact, const struct Record *record, struct Yield *yield, const volatile int *stop)
{
    struct Wiring w = wire(contact);
    struct Course course;
    course.now = course.known = 0;
    int angles = 0;
    for (int j = 0; j < yield->output_count; ++j)
        angles |= yield->output_index[j] == SHEAR_ANGLE;
    enum Status status = ordered_temperatures(contact) ? KERNEL_OK : KERNEL_TEMPERATURES;
    for (int64_t n = 0; n < record->count && status == KERNEL_OK; ++n) {
        yield->samples_done = n;
        status = stop && *stop ? KERNEL_STOPPED : set_slopes(contact, record, n);
        if (status == KERNEL_OK && n > 0) {
            const double step = record->times[n] - record->times[n - 1];
            lanes s = {0};
            wire_time(contact, &w);
            status = step > 0 && isfinite(step) ? march(contact, &w, step, 0, s, &course) : KERNEL_BAD_STEP;
        }
        if (status != KERNEL_OK)
            break;
        land(contact, record, n);
        if (!record->keep || record->keep[n]) {
            if (course.known && is_whole(&w, &course.room[course.now]))
                show_outputs(contact, &w, &course.room[course.now], angles || n == record->count - 1);
            else
                status = kernel_evaluate(contact);
            give(contact, yield);
        }
        yield->samples_done = n + (status == KERNEL_OK);
    }
    return status;
}
