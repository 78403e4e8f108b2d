/* What do the mean forces mean? Averages over windows that follow one another from the start. */
#include "../stages.h"

#include <math.h>

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

enum { FIRST_INTEGRAL = BASE_STATES - MEANS }; /* the integrals are the last base states, in this order */

void open_window(struct Contact *contact, int i)
{
    for (int n = 0; n < MEANS; ++n)
        contact->window_start[n][i] = contact->value[kernel_state(FIRST_INTEGRAL + n)][i];
}

void close_window(struct Contact *contact, int i)
{
    const double length = window_length(contact, i);
    for (int n = 0; n < MEANS; ++n) {
        const double integral = contact->value[kernel_state(FIRST_INTEGRAL + n)][i];
        contact->value[mean_of[n]][i] = (integral - contact->window_start[n][i]) / length;
        contact->window_start[n][i] = integral;
    }
    contact->window[i] += 1;
}

void pass_windows(struct Contact *contact, int i, double begin, const double mean[MEANS])
{
    const double length = window_length(contact, i), now = contact->value[VAR_TIME][i];
    const double ended = floor((now - contact->window_origin) / length * (1 + 1e-12)),
                 last = contact->window_origin + ended * length;
    if (!(ended > contact->window[i]))
        return;
    for (int n = 0; n < MEANS; ++n) {
        const double integral = contact->value[kernel_state(FIRST_INTEGRAL + n)][i] - mean[n] * (now - last);
        const int within = last - length >= begin;
        contact->value[mean_of[n]][i] = within ? mean[n] : (integral - contact->window_start[n][i]) / length;
        contact->window_start[n][i] = integral;
    }
    contact->window[i] = ended;
}
