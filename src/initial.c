/* A consistent start: algebraic velocities from gamma(q, u, t) = 0, accelerations from the
 * equations of motion and gamma' = 0.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The directions in which u may change without changing a momentum span the null space of the
 * joint-space mass matrix. One basis vector belongs to each null vector N e_k of a joint j: it
 * starts with that rate at j and goes on to the leaves by the recursion of Az in forward.c,
 *
 *   a_i = z_i - D_i^+ J_i^T Mbar_i H_i Vz_pi,  Vz_i = -H_i Vz_pi - J_i a_i,  z_j = N e_k, others 0.
 *
 * gamma is taken as projection on each joint's null space, so that no sign or turning of
 * eigenvectors enters. */
#include "internal.h"

#include "dense.h"
#include "lapack.h"

#include <math.h>

mbsr_consistent_opt mbsr_default_consistent_opt(void)
{
    return (mbsr_consistent_opt){.cookie = MBSRI_COOKIE, .max_iterations = 20, .tolerance = 1e-12};
}

/* Memory of one call. nu rows, k columns. */
typedef struct start {
    const mbsr_model *m;
    mbsr_data *d;
    double t;
    int k;         /* null directions */
    double *q, *u; /* state being improved */
    double *qdot, *udot;
    double *basis; /* nu x k   null directions of the mass matrix */
    double *slope; /* nu x k   d gamma / d (weights of the basis) */
    double *gamma; /* nu */
    double *q_try, *u_try, *ahead, *behind, *matrix, *weights, *size, *work;
    int *pivots;
    int lwork;
} start;

/* Doubles needed; with base places the arrays. */
static size_t place(start *w, int nq, int nu, double *base)
{
    const size_t N = (size_t)nu, K = (size_t)w->k, long_side = N > K ? N : K;
    double **const array[] = {&w->q,      &w->u,      &w->qdot,    &w->udot,  &w->basis,
                              &w->slope,  &w->gamma,  &w->q_try,   &w->u_try, &w->ahead,
                              &w->behind, &w->matrix, &w->weights, &w->size,  &w->work};
    const size_t length[] = {(size_t)nq, N,     (size_t)nq, N, N * K,
                             N * K,      N,     (size_t)nq, N, N,
                             N,          N * K, long_side,  K, (size_t)w->lwork};
    size_t used = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        if (base) *array[l] = base + used;
        used += length[l];
    }
    return used;
}

/* gamma at a state, joint by joint; ranks and null spaces stay in the data. */
static int null_forces(start *w, double t, const double *q, const double *u, double *gamma)
{
    int status = mbsr_positions(w->m, w->d, t, q);
    if (!status) status = mbsr_velocities(w->m, w->d, u);
    if (!status) status = mbsr_forces(w->m, w->d, NULL);
    if (!status) status = mbsr_backward(w->m, w->d);
    if (status) return status;
    for (int i = 1; i <= w->m->bodies; ++i)
        mbsri_null_force(w->m, w->d, i, gamma + w->m->body[i].u);
    return mbsri_finite((size_t)w->m->nu, gamma) ? MBSR_OK : mbsri_report_not_finite(w->m, w->d);
}

/* Basis vector of null vector l of body j. */
static void lift(const start *w, int j, int l, double *a)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    const int n = m->body[j].n;
    mbsri_zero((size_t)m->nu, a);
    mbsri_zero(m->size_v, d->Az);
    for (int i = j; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i, *pred = m->body + b->parent;
        double *x = d->scratch, *Vz = d->Az + b->v, *ai = a + b->u;
        if (i == j) {
            for (int k = 0; k < n; ++k) ai[k] = d->s[b->u + k] * d->X[b->nn + (size_t)(l * n + k)];
        }
        mbsri_zero((size_t)b->d, x);
        mbsri_ax(b->d, b->d_pred, 1.0, d->H + b->dp, d->Az + pred->v, x);
        mbsri_atx(b->d, b->n, -1.0, d->G + b->dn, x, ai);
        mbsri_ax(b->d, b->n, -1.0, d->J + b->dn, ai, Vz);
        for (int k = 0; k < b->d; ++k) Vz[k] -= x[k];
    }
}

static void build_basis(start *w)
{
    int column = 0;
    for (int i = 1; i <= w->m->bodies; ++i) {
        for (int l = w->d->rank[i]; l < w->m->body[i].n; ++l)
            lift(w, i, l, w->basis + (size_t)column++ * (size_t)w->m->nu);
    }
}

static double largest(int n, const double *x)
{
    double value = 0.0;
    for (int k = 0; k < n; ++k) value = fmax(value, fabs(x[k]));
    return value;
}

/* slope = d gamma / d weights by central differences of u along the basis. */
static int differentiate(start *w)
{
    const int nu = w->m->nu;
    for (int c = 0; c < w->k; ++c) {
        const double *a = w->basis + (size_t)c * (size_t)nu;
        double *column = w->slope + (size_t)c * (size_t)nu;
        const double h = 1e-5 * (1.0 + largest(nu, w->u)) / largest(nu, a);
        for (int k = 0; k < nu; ++k) w->u_try[k] = w->u[k] + h * a[k];
        int status = null_forces(w, w->t, w->q, w->u_try, w->ahead);
        if (status) return status;
        for (int k = 0; k < nu; ++k) w->u_try[k] = w->u[k] - h * a[k];
        status = null_forces(w, w->t, w->q, w->u_try, w->behind);
        if (status) return status;
        for (int k = 0; k < nu; ++k) column[k] = (w->ahead[k] - w->behind[k]) / (2.0 * h);
    }
    return MBSR_OK;
}

/* weights with slope weights = right (least squares, columns scaled); refuses a slope that is
 * rank-deficient. */
static int solve(start *w, const double *right)
{
    const mbsr_model *m = w->m;
    const int nu = m->nu;
    int rank = 0;
    for (int c = 0; c < w->k; ++c) {
        const double *column = w->slope + (size_t)c * (size_t)nu;
        const double norm = sqrt(mbsri_dot(nu, column, column));
        w->size[c] = norm > 0.0 ? norm : 1.0;
        for (int k = 0; k < nu; ++k)
            w->matrix[(size_t)c * (size_t)nu + (size_t)k] = column[k] / w->size[c];
    }
    mbsri_copy((size_t)nu, right, w->weights);
    const int info = mbsri_lapack_gelsy(nu, w->k, w->matrix, w->weights, 1e-9, w->pivots, &rank,
                                        w->work, w->lwork);
    if (info != 0 || rank < w->k) {
        int i = 1;
        while (w->d->rank[i] == m->body[i].n) ++i;
        char label[MBSRI_LABEL];
        return mbsri_fail(&w->d->error, MBSR_UNDETERMINED, m->body[i].id, MBSR_NONE,
                          "mbsr_dae_consistent: %d of %d directions that move no mass have no "
                          "force that depends on velocity "
                          "(the first such joint is that of %s)",
                          w->k - rank, w->k, mbsri_body_label(m, i, label));
    }
    for (int c = 0; c < w->k; ++c) w->weights[c] /= w->size[c];
    return MBSR_OK;
}

/* Newton's method for gamma(q, u + basis weights, t) = 0. Rounding limits the last correction when
 * damping is weak: corrections that stop shrinking are accepted once they are small. */
static int find_velocities(start *w, const mbsr_consistent_opt *opt, mbsr_consistent_info *info)
{
    const int nu = w->m->nu;
    double before = INFINITY;
    for (int step = 0; step < opt->max_iterations; ++step) {
        int status = differentiate(w);
        if (!status) status = null_forces(w, w->t, w->q, w->u, w->gamma);
        if (status) return status;
        if (step == 0) info->force_defect = largest(nu, w->gamma);
        for (int k = 0; k < nu; ++k) w->gamma[k] = -w->gamma[k];
        status = solve(w, w->gamma);
        if (status) return status;
        mbsri_zero((size_t)nu, w->u_try);
        mbsri_ax(nu, w->k, 1.0, w->basis, w->weights, w->u_try);
        const double change = largest(nu, w->u_try), size = 1.0 + largest(nu, w->u);
        for (int k = 0; k < nu; ++k) w->u[k] += w->u_try[k];
        info->iterations = step + 1;
        if (change <= opt->tolerance * size || (change > 0.25 * before && change <= 1e-6 * size))
            return MBSR_OK;
        before = change;
    }
    return mbsri_fail(&w->d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
                      "mbsr_dae_consistent: the algebraic velocities did not converge in %d "
                      "iterations (last change %g)",
                      opt->max_iterations, before);
}

/* gamma along the motion, `h` seconds on. */
static int null_forces_at(start *w, double h, double *gamma)
{
    for (int k = 0; k < w->m->nq; ++k) w->q_try[k] = w->q[k] + h * w->qdot[k];
    for (int k = 0; k < w->m->nu; ++k) w->u_try[k] = w->u[k] + h * w->udot[k];
    return null_forces(w, w->t + h, w->q_try, w->u_try, gamma);
}

/* q' = G u, u' = range part from forward dynamics plus basis weights such that gamma' = 0. */
static int find_rates(start *w)
{
    const mbsr_model *m = w->m;
    int status = mbsr_forward_dynamics(m, w->d, w->t, w->q, w->u, NULL, w->udot);
    if (status && status != MBSR_UNDETERMINED) return status;
    status = mbsr_coordinate_rates(m, w->d, w->qdot);
    if (status || w->k == 0) return status;
    /* a step so short that state and time change by about a millionth */
    const double speed = fmax(largest(m->nq, w->qdot) / (1.0 + largest(m->nq, w->q)),
                              largest(m->nu, w->udot) / (1.0 + largest(m->nu, w->u)));
    const double h = 1e-6 / fmax(1.0, speed);
    /* slope, then gamma' along q', u' by central differences */
    status = differentiate(w);
    if (!status) status = null_forces_at(w, h, w->ahead);
    if (!status) status = null_forces_at(w, -h, w->behind);
    if (status) return status;
    for (int k = 0; k < m->nu; ++k) w->gamma[k] = -(w->ahead[k] - w->behind[k]) / (2.0 * h);
    status = solve(w, w->gamma);
    if (!status) mbsri_ax(m->nu, w->k, 1.0, w->basis, w->weights, w->udot);
    return status;
}

/* The state of y into w, its null directions counted; then the arrays that depend on their
 * number. */
static int prepare(start *w, const double *y)
{
    const mbsr_model *m = w->m;
    int status = mbsr_positions(m, w->d, w->t, y);
    if (!status) status = mbsr_velocities(m, w->d, y + m->nq);
    if (!status) status = mbsr_forces(m, w->d, NULL);
    if (!status) status = mbsr_backward(m, w->d);
    if (status) return status;
    w->k = m->nu - w->d->total_rank;
    w->lwork = w->k > 0 ? mbsri_lapack_gelsy_work(m->nu, w->k) : 1;
    double *memory = mbsri_allocate(&m->allocator, place(w, m->nq, m->nu, NULL) * sizeof(double));
    w->pivots = mbsri_allocate(&m->allocator, (size_t)w->k * sizeof *w->pivots);
    if (memory) place(w, m->nq, m->nu, memory);
    if (!memory || !w->pivots) {
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: no memory for %d null directions", w->k);
    }
    mbsri_copy((size_t)m->nq, y, w->q);
    mbsri_copy((size_t)m->nu, y + m->nq, w->u);
    build_basis(w);
    return MBSR_OK;
}

static int check(mbsr_data *d, mbsr_dae_form form, const mbsr_consistent_opt *opt)
{
    const int size = mbsr_dae_size(d->model, form);
    if (size < 0) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: form is %d, no such form", (int)form);
    }
    if (opt->cookie != MBSRI_COOKIE) {
        return mbsri_fail(&d->error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "mbsr_dae_consistent: opt was not made by mbsr_default_consistent_opt");
    }
    if (opt->max_iterations < 1 || !(opt->tolerance > 0.0)) {
        return mbsri_fail(
            &d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
            "mbsr_dae_consistent: max_iterations is %d, tolerance is %g; both must be positive",
            opt->max_iterations, opt->tolerance);
    }
    return MBSR_OK;
}

int mbsr_dae_consistent(const mbsr_model *model, mbsr_data *data, mbsr_dae_form form, double t,
                        double *y, double *yp, const mbsr_consistent_opt *opt,
                        mbsr_consistent_info *info)
{
    const mbsr_consistent_opt standard = mbsr_default_consistent_opt();
    mbsr_consistent_info report = {0};
    if (!opt) opt = &standard;
    int status = mbsri_enter(model, data, y && yp, MBSRI_STAGE_NONE, "mbsr_dae_consistent");
    if (!status) status = check(data, form, opt);
    if (status) return status;

    const mbsr_model *m = model;
    start w = {.m = m, .d = data, .t = t};
    status = prepare(&w, y);
    report.null_directions = w.k;
    if (!status && w.k > 0) status = find_velocities(&w, opt, &report);
    if (!status) status = find_rates(&w);
    if (!status) {
        for (int k = 0; k < m->nu; ++k)
            report.velocity_change = fmax(report.velocity_change, fabs(w.u[k] - y[m->nq + k]));
        mbsri_copy((size_t)m->nq, w.q, y);
        mbsri_copy((size_t)m->nu, w.u, y + m->nq);
        mbsri_copy((size_t)m->nq, w.qdot, yp);
        mbsri_copy((size_t)m->nu, w.udot, yp + m->nq);
    }
    if (info) *info = report;
    mbsri_release(&m->allocator, w.q);
    mbsri_release(&m->allocator, w.pivots);
    return status;
}
