/* The Newton system by the sweeps of newton_kernels.h: memory, slopes of joint forces, calls.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton.h"

#include "../dense.h"

#include <stdint.h>
#include <string.h>

/* ---- memory ---- */

static void *take(unsigned char *base, size_t *used, size_t size)
{
    void *place = base ? base + *used : NULL;
    *used += (size + MBSR_DATA_ALIGNMENT - 1) / MBSR_DATA_ALIGNMENT * MBSR_DATA_ALIGNMENT;
    return place;
}

static size_t branching(const mbsri_fast *tree)
{
    size_t count = 0;
    for (int i = 1; i <= tree->bodies; ++i) count += (tree->body[i].flags & MBSRI_BRANCHES) != 0;
    return count;
}

/* Places the solver in `base`, or with base == NULL only returns the size. */
static size_t layout(const mbsr_model *m, unsigned char *base, mbsri_fast_newton **newton)
{
    const mbsri_fast *tree = m->fast;
    const size_t bodies = (size_t)m->bodies + 1, nu = (size_t)m->nu, depth = (size_t)tree->depth;
    mbsri_fast_newton counted;
    size_t used = 0, doubles, ints;
    mbsri_fast_newton *w = take(base, &used, sizeof *w);
    if (!w) w = &counted;
    const bool full = tree->body_forces;
    w->column_size = full ? sizeof(mbsri_newton_column) : offsetof(mbsri_newton_column, last);
    w->column = take(base, &used, nu * w->column_size);
    w->step = take(base, &used, bodies * sizeof *w->step);
    w->block = take(base, &used, (size_t)tree->many * sizeof *w->block);
    w->own = take(base, &used, full ? bodies * sizeof *w->own : 0);
    w->k = take(base, &used, nu * sizeof *w->k);
    w->p = take(base, &used, nu * sizeof *w->p);
    w->x = take(base, &used, branching(tree) * sizeof *w->x);
    w->carry = take(base, &used, depth * sizeof *w->carry);
    w->flow = take(base, &used, depth * sizeof *w->flow);
    const size_t slopes = full || tree->joint_forces ? nu : 0;
    w->tau_q = take(base, &used, slopes * sizeof *w->tau_q);
    w->tau_u = take(base, &used, slopes * sizeof *w->tau_u);
    mbsri_slopes_size(m, &doubles, &ints);
    double *work = take(base, &used, doubles * sizeof *work);
    int *places = take(base, &used, ints * sizeof *places);
    if (!base) return used;
    w->model = m;
    w->tree = tree;
    if (!full) w->own = NULL;
    if (slopes == 0) w->tau_q = w->tau_u = NULL;
    mbsri_slopes_place(m, &w->slopes, work, places);
    *newton = w;
    return used;
}

size_t mbsri_fast_newton_size(const mbsr_model *m)
{
    return m->fast ? layout(m, NULL, NULL) : 0;
}

mbsri_fast_newton *mbsri_fast_newton_place(const mbsr_model *m, void *memory)
{
    mbsri_fast_newton *w;
    layout(m, memory, &w);
    memset(w->step, 0, sizeof *w->step);
    int branch = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_fast_body *b = m->fast->body + i;
        w->step[i] = (mbsri_newton_step){.parent = b->parent,
                                         .flags = b->flags,
                                         .n = b->n,
                                         .q = b->q,
                                         .u = b->u,
                                         .many = b->many,
                                         .branch = branch};
        branch += (b->flags & MBSRI_BRANCHES) != 0;
    }
    for (int k = 0; k < m->fast->many; ++k) memset(w->block + k, 0, sizeof *w->block);
    return w;
}

/* ---- slopes of joint forces ---- */

static void clear_slopes(mbsri_fast_newton *w)
{
    const size_t nu = (size_t)w->model->nu;
    if (!w->tau_q) return;
    mbsri_zero(nu, w->tau_q);
    mbsri_zero(nu, w->tau_u);
    for (int k = 0; k < w->tree->many; ++k) {
        memset(w->block[k].tau_q, 0, sizeof w->block[k].tau_q);
        memset(w->block[k].tau_u, 0, sizeof w->block[k].tau_u);
    }
}

/* dtau of body i with respect to its own q and u. */
static void add_joint_slopes(mbsri_fast_newton *w, int i, const mbsr_force_derivatives *by, int row,
                             int column)
{
    const mbsri_body *body = w->model->body + i;
    const mbsri_fast_body *b = w->tree->body + i;
    const double *tau = by->matrix + row + body->d,
                 *q = tau + by->rows * (column + mbsri_pose_size(body) + body->d),
                 *u = q + by->rows * body->nq;
    if (!(b->flags & MBSRI_MANY)) {
        if (b->n == 0) return;
        w->tau_q[b->u] += *q;
        w->tau_u[b->u] += *u;
        return;
    }
    mbsri_newton_block *B = w->block + b->many;
    for (int k = 0; k < body->n; ++k) {
        for (int l = 0; l < body->nq; ++l) B->tau_q[k][l] += q[by->rows * l + k];
        for (int l = 0; l < body->n; ++l) B->tau_u[k][l] += u[by->rows * l + k];
    }
}

/* One call of an element: on body i, or on those of its list. */
static int slopes_of_call(mbsri_fast_newton *w, mbsr_data *d, const mbsri_force *force, int i)
{
    const mbsr_model *m = w->model;
    const bool every = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    const mbsr_force_derivatives *by = &w->slopes.out;
    const int status = mbsri_force_slopes(m, d, force, i, &w->slopes),
              bodies = every ? 1 : force->def.bodies;
    for (int l = 0; l < bodies && !status; ++l) {
        const int on = every ? i : m->list_index[force->list + (size_t)l];
        if (on > 0) add_joint_slopes(w, on, by, by->row[l], by->column[l]);
    }
    return status;
}

/* Elements that act on joints alone. */
static int joint_slopes(mbsri_fast_newton *w, mbsr_data *d)
{
    const mbsr_model *m = w->model;
    const mbsri_force *force = m->forces.data;
    int status = MBSR_OK;
    for (size_t k = 0; k < m->forces.count; ++k, ++force) {
        const unsigned flags = force->def.table->flags;
        if (!(flags & MBSR_FORCE_JOINT_ONLY)) continue;
        const int calls = flags & MBSR_FORCE_EVERY_BODY ? m->bodies : 1;
        for (int i = 1; i <= calls && !status; ++i) status = slopes_of_call(w, d, force, i);
    }
    return status;
}

/* ---- calls ---- */

int mbsri_fast_newton_factor(mbsri_fast_newton *newton, mbsr_data *d, double t, const double *q,
                             const double *u, double c)
{
    const mbsr_model *m = newton->model;
    mbsri_fast_run run;
    if (newton->tree->body_forces) return MBSRI_NOT_SERVED;
    if (!mbsri_fast_open(&run, m, d, t, q, u)) return MBSRI_NOT_SERVED;
    newton->c = c;
    newton->by_c = 1.0 / c;
    clear_slopes(newton);
    if (newton->tree->joint_forces) {
        /* elements look into the data */
        if (run.q != d->q) mbsri_copy((size_t)m->nq, run.q, d->q);
        if (run.u != d->u) mbsri_copy((size_t)m->nu, run.u, d->u);
        const int status = joint_slopes(newton, d);
        if (status) return status;
    }
    const int singular = run.tree->kernels->newton_factor(&run, newton);
    if (singular < 0 || !mbsri_fast_as_watched(&run)) return MBSRI_NOT_SERVED;
    mbsri_remember(m, d, MBSRI_PENDING_FORWARD, q, u, NULL);
    if (singular == 0) return MBSR_OK;
    char label[MBSRI_LABEL];
    return mbsri_fail(&d->error, MBSR_SINGULAR_BLOCK, m->body[singular].id, MBSR_NONE,
                      "%s: the Newton equations of its joint are singular at t = %g",
                      mbsri_body_label(m, singular, label), t);
}

void mbsri_fast_newton_solve(mbsri_fast_newton *newton, const double *r, const double *load,
                             double *delta, double *motion)
{
    newton->tree->kernels->newton_solve(newton, r, load, delta, motion);
}
