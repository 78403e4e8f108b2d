/* What does the kernel's own stepping make of a motion, as a host drives it? */
#include "reference.h"

enum Status stepped_run(struct Contact *contact, const struct Motion *m, double *rows)
{
    for (int n = -1; n < m->segments; ++n) {
        enum Status status;
        double taken;
        const int now = n < 0 ? 0 : n;
        const double length = m->times[now + 1] - m->times[now];
        for (int j = 0; j < m->inputs; ++j) {
            const double u_0 = m->begin[now * m->inputs + j], u_1 = m->end[now * m->inputs + j];
            contact->value[m->input_index[j]][0] = u_0;
            contact->slope[m->input_index[j] - INPUT_FIRST][0] = n < 0 ? 0 : (u_1 - u_0) / length;
        }
        status = n < 0 ? kernel_start(contact, m->times[0]) : kernel_advance(contact, length, 0, &taken);
        if (status == STATUS_OK)
            status = kernel_evaluate(contact);
        if (status != STATUS_OK)
            return status;
        for (int j = 0; j < m->outputs; ++j)
            rows[(int64_t)(n + 1) * m->outputs + j] = contact->value[m->output_index[j]][0];
    }
    return STATUS_OK;
}
