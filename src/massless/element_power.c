/* Power of a force element along the directions that move no mass: see element_power.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/element_power.h"

#include "algebra/numbers.h"
#include "model/query.h"

#include <math.h>

int mbsri_element_body(const mbsri_null_space *w, int k)
{
    return mbsri_index(w->m, w->d->element.bodies[k].id);
}

/* What is summed up of y (rows) along a motion. */
static double along(const mbsri_null_space *w, int bodies, const double *a, const double *twist,
                    const double *y, bool sizes)
{
    const mbsri_slopes *s = &w->element.slope;
    double sum = 0.0;
    for (int k = 0; k < bodies; ++k) {
        if (s->row[k] < 0) continue;
        const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
        const double *const part[] = {twist + b->v, a + b->u};
        const int count[] = {b->d, b->n}, from[] = {s->row[k], s->row[k] + b->d};
        for (int p = 0; p < 2; ++p) {
            for (int r = 0; r < count[p]; ++r) {
                const double term = part[p][r] * y[from[p] + r];
                sum += sizes ? fabs(term) : term;
            }
        }
    }
    return sum;
}

double mbsri_element_power(const mbsri_null_space *w, int bodies, const double *a,
                           const double *twist, const double *y, const double *gross, double *size)
{
    *size = along(w, bodies, a, twist, gross, true);
    return along(w, bodies, a, twist, y, false);
}

double mbsri_element_error(const mbsri_null_space *w, int bodies, int l, const double *y)
{
    return along(w, bodies, w->lift.rate_error + (size_t)l * (size_t)w->m->nu,
                 w->lift.twist_error + (size_t)l * w->m->size.v, y, true);
}

double mbsri_element_doubt(const mbsri_null_space *w, int bodies, const double *twist,
                           const double *y)
{
    const mbsri_slopes *s = &w->element.slope;
    double sum = 0.0;
    int turns, rotation, moves, translation;
    for (int k = 0; k < bodies; ++k) {
        if (s->row[k] < 0) continue;
        const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
        if (!mbsri_motion_places(b, &turns, &rotation, &moves, &translation)) continue;
        const double *V = twist + b->v, *f = y + s->row[k];
        const double moment = mbsri_largest(turns, f + rotation),
                     force = mbsri_largest(moves, f + translation);
        sum += mbsri_largest(turns, V + rotation) * (moment + w->size * force) +
               mbsri_largest(moves, V + translation) * force;
    }
    return sum;
}
