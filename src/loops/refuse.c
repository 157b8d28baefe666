/* What the equations of loops refuse, by name.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops/refuse.h"

#include "base/error.h"
#include "model/query.h"
#include "recursion/closures.h"

#include <math.h>

double mbsri_largest_row(const mbsr_model *m, const double *x, const double *length)
{
    double largest = 0.0;
    for (int k = 0; k < m->rows; ++k)
        largest = fmax(largest, fabs(x[k]) / (length[k] > 0.0 ? length[k] : 1.0));
    return largest;
}

int mbsri_refuse_left(const mbsr_model *m, mbsr_data *d, const double *left, const double *length,
                      double size, const char *what, const char *function)
{
    static const double rounding = 1e-7;
    const mbsri_closure *first = mbsri_all_closures(m);
    double widest = 0.0;
    int id = 0, row = 0;
    char label[MBSRI_LABEL];
    for (int n = 0; n < (int)m->closures.count; ++n) {
        for (int k = first[n].row; k < first[n].row + first[n].rows; ++k) {
            const double own = fabs(left[k]) / (length[k] > 0.0 ? length[k] : 1.0);
            if (own > widest) widest = own, id = n, row = k;
        }
    }
    if (widest <= rounding * size) return MBSR_OK;
    return mbsri_fail(&d->error, MBSR_LOOP_OPEN, MBSR_NONE, MBSR_NONE,
                      "%s: %s: its %s cannot be met, %.3g is left: closures or motions "
                      "contradict each other",
                      function, mbsri_closure_label(m, id, label), what, fabs(left[row]));
}

int mbsri_refuse_motion(const mbsr_model *m, mbsr_data *d, int rate, const char *function,
                        const char *why)
{
    char label[MBSRI_LABEL];
    const int at = mbsri_body_of_rate(m, rate);
    return mbsri_fail(&d->error, MBSR_UNDETERMINED, m->body[at].id, MBSR_NONE,
                      "%s: u%d of %s moves no mass, no loop holds it%s", function,
                      rate - m->body[at].u, mbsri_body_label(m, at, label), why);
}
