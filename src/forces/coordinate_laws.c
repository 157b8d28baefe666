/* Forces along joint coordinates, of all elements of a law at once.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "forces/coordinate_laws.h"

/* One loop for each law; e and k are the element and its number. */
#define MBSRI_EACH(law, statement)                                                                 \
    for (size_t k = all->first[law]; k < all->first[(law) + 1]; ++k) {                             \
        const mbsri_coordinate_element *e = all->element + k;                                      \
        if (!off[k]) statement;                                                                    \
    }

void mbsri_coordinate_forces(const mbsri_coordinate_elements *all, const bool *off, const double *q,
                             const double *u, double *tau)
{
    MBSRI_EACH(MBSRI_LAW_SPRING, tau[e->u] += mbsri_spring_force(e->param, q[e->q], u[e->u]))
    MBSRI_EACH(MBSRI_LAW_STOP, tau[e->u] += mbsri_stop_force(e->param, e->option, q[e->q], u[e->u]))
    MBSRI_EACH(MBSRI_LAW_FRICTION, tau[e->u] += mbsri_friction_force(e->param, u[e->u]))
}

static void add_two_slopes(mbsri_law_slopes slopes, int at, double *by_q, double *by_u)
{
    by_q[at] += slopes.by_q;
    by_u[at] += slopes.by_u;
}

void mbsri_coordinate_slopes(const mbsri_coordinate_elements *all, const bool *off, const double *q,
                             const double *u, double *by_q, double *by_u)
{
    MBSRI_EACH(MBSRI_LAW_SPRING,
               add_two_slopes(mbsri_spring_slopes(e->param, q[e->q]), e->u, by_q, by_u))
    MBSRI_EACH(
        MBSRI_LAW_STOP,
        add_two_slopes(mbsri_stop_slopes(e->param, e->option, q[e->q], u[e->u]), e->u, by_q, by_u))
    MBSRI_EACH(MBSRI_LAW_FRICTION,
               add_two_slopes(mbsri_friction_slopes(e->param, u[e->u]), e->u, by_q, by_u))
}
