/* What do the mean forces mean? Averages over windows that follow one another from the start. */
#include "../stages.h"

#include <math.h>

static int turning(const struct Contact *contact)
{
    return chosen(contact->value, VAR_KINEMATICS, 0) != KINEMATICS_EXTERNAL;
}

double window_length(const struct Contact *contact, int i)
{
    const double length = or_none(contact->value[VAR_AVERAGING_WINDOW][i], NO_WINDOW);
    return length > 0 ? length : turning(contact) ? 1 / contact->value[VAR_VIBRATION_FREQUENCY][i] : 0;
}

void forms_means(const struct Contact *contact, int forms[LANES])
{
    const int always = turning(contact);
    EACH_LANE
        forms[i] = always | (contact->value[VAR_AVERAGING_WINDOW][i] >= NO_WINDOW);
}

double window_end(const struct Contact *contact, int i)
{
    const double length = window_length(contact, i);
    return length > 0 ? contact->window_origin + (contact->window[i] + 1) * length : INFINITY;
}

const int mean_of[MEANS] = {VAR_MEAN_DISSIPATED_POWER,
                            VAR_MEAN_SHEAR_POWER,
                            VAR_MEAN_FRICTION_FORCE,
                            VAR_MEAN_PRINCIPAL_FORCE,
                            VAR_MEAN_FEED_FORCE,
                            VAR_MEAN_NORMAL_FORCE,
                            VAR_MEAN_CONTACT_RATIO,
                            VAR_MEAN_MEASURED_FRICTION_FORCE,
                            VAR_MEAN_MEASURED_PRINCIPAL_FORCE,
                            VAR_MEAN_MEASURED_FEED_FORCE};

void open_window(struct Contact *contact, int i)
{
    for (int n = 0; n < MEANS; ++n)
        contact->window_start[n][i] = contact->value[integral_of[FIRST_MEAN_INTEGRAL + n]][i];
}

void close_window(struct Contact *contact, int i)
{
    const double length = window_length(contact, i);
    for (int n = 0; n < MEANS; ++n) {
        const double integral = contact->value[integral_of[FIRST_MEAN_INTEGRAL + n]][i];
        contact->value[mean_of[n]][i] = (integral - contact->window_start[n][i]) / length;
        contact->window_start[n][i] = integral;
    }
    contact->window[i] += 1;
}

/* Of windows that end within a communication step nobody sees more than the last mean. Where steps may be longer than
 * windows, as of a tool that does not vibrate, none is cut for the others; one more than the last two is looked at, as
 * roundings may leave the last to the next step. */
#define LOOKED_AT 3

void skip_windows(struct Contact *contact, const struct Configuration *w, double step)
{
    for (int i = 0; i < LANES; ++i) {
        const double length = window_length(contact, i);
        if (!(length > 0 && length < w->longest[i]))
            continue;
        const double ended = floor((contact->value[VAR_TIME][i] + step - contact->window_origin) / length);
        contact->window[i] = larger(contact->window[i], ended - LOOKED_AT);
    }
}

/* After a step that has ended before one of the windows that it looked at: what has passed of the present one counts as
 * the last mean. */
void return_to_window(struct Contact *contact)
{
    for (int i = 0; i < LANES; ++i) {
        const double length = window_length(contact, i), now = contact->value[VAR_TIME][i];
        const double ended = length > 0 ? floor((now - contact->window_origin) / length) : INFINITY;
        if (!(contact->window[i] > ended))
            continue;
        const double begun = contact->window_origin + ended * length;
        for (int n = 0; n < MEANS; ++n)
            contact->window_start[n][i] =
                contact->value[integral_of[FIRST_MEAN_INTEGRAL + n]][i] - contact->value[mean_of[n]][i] * (now - begun);
        contact->window[i] = ended;
    }
}

void pass_windows(struct Contact *contact, int i, double begin, const double mean[MEANS])
{
    const double length = window_length(contact, i), now = contact->value[VAR_TIME][i];
    const double ended = floor((now - contact->window_origin) / length + BESIDE_WINDOW),
                 last = contact->window_origin + ended * length;
    if (!(ended > contact->window[i]))
        return;
    for (int n = 0; n < MEANS; ++n) {
        const double integral = contact->value[integral_of[FIRST_MEAN_INTEGRAL + n]][i] - mean[n] * (now - last);
        const int within = last - length >= begin;
        contact->value[mean_of[n]][i] = within ? mean[n] : (integral - contact->window_start[n][i]) / length;
        contact->window_start[n][i] = integral;
    }
    contact->window[i] = ended;
}

enum { FIRST_RECENT = VAR_RECENT_DISSIPATED_ENERGY };

void show_recent(struct Contact *contact)
{
    for (int n = 0; n < MEANS; ++n) {
        const double *const integral = contact->value[integral_of[FIRST_MEAN_INTEGRAL + n]];
        double *const recent = contact->value[FIRST_RECENT + n];
        EACH_LANE /* what a solver has led stays as it was given, to the last bit */
            if (contact->event_start[n][i] + recent[i] != integral[i])
                recent[i] = integral[i] - contact->event_start[n][i];
    }
}

void follow_recent(struct Contact *contact, int index, int lane)
{
    const int n = index - FIRST_RECENT;
    if (n >= 0 && n < MEANS)
        contact->value[integral_of[FIRST_MEAN_INTEGRAL + n]][lane] =
            contact->event_start[n][lane] + contact->value[index][lane];
}

int recent_of(int index)
{
    for (int n = 0; n < MEANS; ++n)
        if (integral_of[FIRST_MEAN_INTEGRAL + n] == index)
            return FIRST_RECENT + n;
    return index;
}

void begin_recent(struct Contact *contact)
{
    for (int n = 0; n < MEANS; ++n)
        EACH_LANE {
            contact->event_start[n][i] = contact->value[integral_of[FIRST_MEAN_INTEGRAL + n]][i];
            contact->value[FIRST_RECENT + n][i] = 0;
        }
}
