/* Starts on the smooth motion, to second order in the masses.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The consistent state of the reduced model is on the smooth motion of the full one but for O(eps).
 * That of the reduced model under the load -w(t), the neglected inertia force with its rates, is
 * but for O(eps^2). The rates are differences along the smooth motion.
 *
 * Where directions are lightly damped (slow.h), their rates under the load are those of the
 * positions that they have under it, at later and earlier times: to O(eps d) not the load alone
 * changes these, but also the slow motion that it changes. */
#include "small/correct.h"

#include "algebra/dense.h"
#include "small/errors.h"
#include "small/loads.h"
#include "small/slow.h"
#include "small/smooth.h"

/* Times of the differences, over the slow time scale; with lightly damped directions second ones
 * count. */
static const double apart = 1e-4, apart_if_light = 0.02;

/* force of each candidate at t = from + h, along the smooth motion. */
static int forces_at(mbsr_small_masses *s, double h)
{
    if (h == 0.0) return mbsri_small_forces(s, s->start.t, s->y, s->yp);
    const int status = mbsri_small_beside(s, h, s->y_full, s->yp_full);
    return status ? status : mbsri_small_forces(s, s->start.t + h, s->y_full, s->yp_full);
}

static void clear_loads(mbsr_small_masses *s)
{
    for (int k = 0; k < s->candidates; ++k) {
        mbsri_small_load *load = &s->candidate[k].load;
        mbsri_zero((size_t)load->n, load->value);
        mbsri_zero((size_t)load->n, load->rate);
        mbsri_zero((size_t)load->n, load->bend);
    }
}

/* The loads -w, -w', -w'' from the forces h before, at and h after the start. */
static int find_loads(mbsr_small_masses *s, double h)
{
    int status = MBSR_OK;
    for (int p = -1; p <= 1 && !status; ++p) {
        status = forces_at(s, p * h);
        for (int k = 0; k < s->candidates && !status; ++k) {
            mbsri_candidate *c = s->candidate + k;
            double *const to[3] = {c->beside, c->rest, c->force};
            if (p < 1) mbsri_copy((size_t)c->load.n, c->force, to[p + 1]);
        }
    }
    for (int k = 0; k < s->candidates && !status; ++k) {
        mbsri_candidate *c = s->candidate + k;
        c->load.from = s->start.t;
        for (int l = 0; l < c->load.n && !c->held; ++l) {
            const double before = c->beside[l], now = c->rest[l], after = c->force[l];
            c->load.value[l] = -now;
            c->load.rate[l] = -(after - before) / (2.0 * h);
            c->load.bend[l] = s->slow.count > 0 ? -(after - 2.0 * now + before) / (h * h) : 0.0;
        }
    }
    return status;
}

/* s->y, s->yp and the rates of lightly damped directions are kept, or as they were again. */
static void keep(mbsr_small_masses *s)
{
    mbsri_copy((size_t)s->size, s->y, s->work.kept);
    mbsri_copy((size_t)s->size, s->yp, s->work.kept + s->size);
    for (int l = 0; l < s->slow.count; ++l)
        mbsri_copy(4, s->slow.each[l].rate, s->slow.each[l].kept);
}

static void restore(mbsr_small_masses *s)
{
    clear_loads(s);
    mbsri_copy((size_t)s->size, s->work.kept, s->y);
    mbsri_copy((size_t)s->size, s->work.kept + s->size, s->yp);
    for (int l = 0; l < s->slow.count; ++l)
        mbsri_copy(4, s->slow.each[l].kept, s->slow.each[l].rate);
}

int mbsri_small_correct(mbsr_small_masses *s, double *q, double *u)
{
    const mbsr_model *m = s->reduced.model;
    const bool light = s->slow.count > 0;
    int status = light ? mbsri_small_factor(s, s->start.t, s->y, s->yp, s->slow.c) : MBSR_OK;
    if (status) return status;
    keep(s);
    status = find_loads(s, (light ? apart_if_light : apart) * s->opt.time_scale);
    if (!status) status = mbsri_small_settle(s, s->start.t, s->start.q, s->start.u, s->y, s->yp);
    if (!status && light) status = mbsri_small_refine(s);
    if (!status) {
        mbsri_copy((size_t)m->nq, s->y, q);
        mbsri_copy((size_t)m->nu, s->y + m->nq + m->nu, u);
    }
    restore(s);
    return status;
}
