/* The reduced ODE (q, p)': momenta give the velocities where there is mass, Newton's method where
 * there is none.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Root to leaves, with ep from the momenta (momentum.c) and any zeta,
 *
 *   u_i = D_i^+ (ep_i - J_i^T Mbar_i H_i V_pi) + N_i zeta_i        has the momenta p
 *   0   = gamma_i = N_i^T e_i(q, u(zeta), t)                       fixes zeta
 *
 * Directions that no force couples form groups; one difference quotient serves a direction of every
 * group at once, and the groups are solved apart. */
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forms/momentum.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/forward.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/rank.h"

#include <mbsrank/ode.h>

#include <math.h>

struct mbsr_ode {
    const mbsr_model *m;
    mbsr_data *d;
    int k;      /* massless directions */
    int *body;  /* k: index of the body of each */
    int *group; /* k: its group, 0 .. groups-1 */
    int *place; /* k: its place in the group */
    int groups, largest;
    int *size;     /* groups: directions of each */
    int *first;    /* groups: where each starts in member */
    int *member;   /* k: the directions, group by group */
    size_t *block; /* groups: offset of its matrix */
    double *matrix;
    double *gamma, *moved, *step;      /* k */
    double *x, *u, *trial, *increment; /* nq + nu, nu, nu, nu */
    long newton_steps, evaluations;
    void *memory;
};

/* ---- grouping ---- */

static int find(const int *parent, int l)
{
    while (parent[l] != l) l = parent[l];
    return l;
}

static void join(int *parent, int a, int b)
{
    const int ra = find(parent, a), rb = find(parent, b);
    if (ra < rb) {
        parent[rb] = ra;
    } else {
        parent[ra] = rb;
    }
}

/* Bodies that direction l moves, or whose joint rate it changes, belong to it; two directions with
 * a body in common are joined. owner: N + 1, -1 where none; null velocities flow as in
 * recursion/forward.c. */
static void claim(const mbsr_model *m, const mbsr_data *d, int *owner, int *parent)
{
    int l = 0;
    for (int i = 0; i <= m->bodies; ++i) owner[i] = -1;
    for (int i = 1; i <= m->bodies; ++i) {
        const int pred = m->body[i].parent;
        /* through a body without a definite mass, null velocities reach its successors */
        const bool through = !m->body[pred].regular || d->rank[pred] < m->body[pred].n;
        if (owner[pred] >= 0 && through) owner[i] = owner[pred];
        for (int n = d->rank[i]; n < m->body[i].n; ++n, ++l) {
            parent[l] = l;
            if (owner[i] >= 0) join(parent, owner[i], l);
            owner[i] = find(parent, l);
        }
    }
}

/* Force elements join the directions of their bodies. */
static void join_by_forces(const mbsr_model *m, const int *owner, int *parent)
{
    const mbsri_force *force = m->forces.data;
    for (size_t id = 0; id < m->forces.count; ++id) {
        int first = -1;
        for (int k = 0; k < force[id].def.bodies; ++k) {
            const int mine = owner[m->list_index[force[id].list + (size_t)k]];
            if (mine < 0) continue;
            if (first >= 0) join(parent, first, mine);
            first = first >= 0 ? first : mine;
        }
    }
}

/* Groups numbered in the order of their first direction. parent becomes scratch. */
static void number_groups(mbsr_ode *o, int *parent)
{
    o->groups = o->largest = 0;
    for (int l = 0; l < o->k; ++l) {
        const int root = find(parent, l);
        if (root == l) {
            o->size[o->groups] = 0;
            o->group[l] = o->groups++;
        } else {
            o->group[l] = o->group[root];
        }
        o->place[l] = o->size[o->group[l]]++;
        if (o->size[o->group[l]] > o->largest) o->largest = o->size[o->group[l]];
    }
    size_t offset = 0;
    for (int g = 0, first = 0; g < o->groups; ++g) {
        o->block[g] = offset;
        o->first[g] = first;
        offset += (size_t)o->size[g] * (size_t)o->size[g];
        first += o->size[g];
    }
    for (int l = 0; l < o->k; ++l) o->member[o->first[o->group[l]] + o->place[l]] = l;
}

/* ---- memory ---- */

static int no_memory(mbsr_data *d)
{
    return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "mbsr_ode_create: no memory");
}

/* Directions, groups; then everything whose size depends on them. */
static int build(mbsr_ode *o)
{
    const mbsr_model *m = o->m;
    const size_t k = (size_t)o->k, bodies = (size_t)m->bodies + 1;
    o->body = mbsri_allocate(&m->allocator, (7 * k + bodies) * sizeof(int) + k * sizeof(size_t));
    if (!o->body) return no_memory(o->d);
    o->block = (size_t *)(void *)o->body;
    o->body = (int *)(void *)(o->block + k);
    o->group = o->body + k;
    o->place = o->group + k;
    o->size = o->place + k;
    o->first = o->size + k;
    o->member = o->first + k;
    int *parent = o->member + k, *owner = parent + k;
    claim(m, o->d, owner, parent);
    join_by_forces(m, owner, parent);
    number_groups(o, parent);
    int l = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        for (int n = o->d->rank[i]; n < m->body[i].n; ++n) o->body[l++] = i;
    }
    size_t entries = 0;
    for (int g = 0; g < o->groups; ++g) entries += (size_t)o->size[g] * (size_t)o->size[g];
    const size_t nu = (size_t)m->nu, size = (size_t)m->nq + nu;
    double *next = mbsri_allocate(&m->allocator, (entries + 3 * k + size + 3 * nu) * sizeof *next);
    o->memory = next;
    if (!next) return no_memory(o->d);
    double **const array[] = {&o->matrix, &o->gamma, &o->moved, &o->step,
                              &o->x,      &o->u,     &o->trial, &o->increment};
    const size_t length[] = {entries, k, k, k, size, nu, nu, nu};
    for (size_t a = 0; a < sizeof length / sizeof length[0]; ++a) {
        *array[a] = next;
        next += length[a];
    }
    return MBSR_OK;
}

int mbsr_ode_create(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                    const double *u, mbsr_ode **ode)
{
    if (ode) *ode = NULL;
    int status = mbsri_enter(model, data, q && u && ode, MBSRI_STAGE_NONE, "mbsr_ode_create");
    if (!status) status = mbsri_positions(model, data, t, q);
    if (!status) status = mbsri_velocities(model, data, u);
    if (!status) status = mbsri_backward_masses(model, data);
    if (status) return status;
    mbsr_ode *o = mbsri_allocate(&model->allocator, sizeof *o);
    if (!o) return no_memory(data);
    *o = (mbsr_ode){.m = model, .d = data, .k = model->nu - data->total_rank};
    status = build(o);
    if (status) {
        mbsr_ode_destroy(o);
        return status;
    }
    mbsri_copy((size_t)model->nu, u, o->u);
    *ode = o;
    return MBSR_OK;
}

void mbsr_ode_destroy(mbsr_ode *ode)
{
    if (!ode) return;
    const mbsr_allocator allocator = ode->m->allocator;
    mbsri_release(&allocator, ode->block);
    mbsri_release(&allocator, ode->memory);
    mbsri_release(&allocator, ode);
}

int mbsr_ode_size(const mbsr_ode *ode)
{
    return ode ? ode->m->nq + ode->m->nu : -1;
}

int mbsr_ode_stats(const mbsr_ode *ode, long *newton_steps, long *evaluations)
{
    if (!ode) return MBSR_ERR_NULL;
    if (newton_steps) *newton_steps = ode->newton_steps;
    if (evaluations) *evaluations = ode->evaluations;
    return MBSR_OK;
}

int mbsr_ode_pack(mbsr_ode *ode, double t, const double *q, const double *u, double *x)
{
    if (!ode) return MBSR_ERR_NULL;
    int status = mbsri_enter(ode->m, ode->d, q && u && x, MBSRI_STAGE_NONE, "mbsr_ode_pack");
    if (!status) status = mbsri_positions(ode->m, ode->d, t, q);
    if (!status) status = mbsri_velocities(ode->m, ode->d, u);
    if (status) return status;
    mbsri_momenta(ode->m, ode->d, x + ode->m->nq);
    mbsri_copy((size_t)ode->m->nq, q, x);
    return MBSR_OK;
}

/* ---- velocities ---- */

/* u with the momenta of ep and the massless parts of u (both by the caller's order), root to
 * leaves. reads ep, U, Dinv, H, J, kI, X, s;  writes V, u. */
static void momentum_part(const mbsr_model *m, mbsr_data *d, double *u)
{
    double *x = d->scratch + m->max_d, *load = x + m->max_d, *null = load + m->max_d;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double *V = d->V + b->v, *ui = u + b->u;
        mbsri_zero((size_t)b->n, null);
        if (d->rank[i] < b->n) mbsri_null_part(m, d, i, ui, null);
        /* u = D^+ (ep - U^T H V_pi) + null part */
        mbsri_zero((size_t)b->d, x);
        mbsri_ax(b->d, b->d_pred, 1.0, d->H + b->dp, d->V + b->pred_v, x);
        mbsri_copy((size_t)b->n, d->ep + b->iu, load);
        mbsri_atx(b->d, b->n, -1.0, d->U + b->dn, x, load);
        mbsri_copy((size_t)b->n, null, ui);
        mbsri_ax(b->n, b->n, 1.0, d->Dinv + b->nn, load, ui);
        /* V = -(H V_pi + J u + kI) */
        for (int k = 0; k < b->d; ++k) V[k] = -x[k] - d->kI[b->v + (size_t)k];
        mbsri_ax(b->d, b->n, -1.0, d->J + b->dn, ui, V);
    }
}

/* du = direction with these weights of the null vectors, root to leaves as Az in
 * recursion/forward.c. */
static void apply(mbsr_ode *o, const double *weights, double *du)
{
    const mbsr_model *m = o->m;
    mbsr_data *d = o->d;
    double *x = d->scratch;
    int l = 0;
    d->carries[0] = false;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const double *X = d->X + b->nn, *s = d->s + b->iu;
        double *a = du + b->u;
        mbsri_zero((size_t)b->n, a);
        for (int c = d->rank[i]; c < b->n; ++c, ++l) {
            for (int k = 0; k < b->n; ++k) a[k] += s[k] * X[c * b->n + k] * weights[l];
        }
        const bool below = mbsri_null_below(m, d, i, x);
        mbsri_null_pass(m, d, i, d->rank[i] < b->n, below, x, a);
    }
}

/* gamma at velocities u; positions and masses are in the data. */
static int forces_at(mbsr_ode *o, const double *u, double *gamma)
{
    const mbsr_model *m = o->m;
    mbsr_data *d = o->d;
    int status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_forces(m, d, NULL);
    if (status) return status;
    mbsri_backward_loads(m, d);
    ++o->evaluations;
    int l = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int c = d->rank[i]; c < b->n; ++c, ++l) {
            gamma[l] = 0.0;
            for (int k = 0; k < b->n; ++k) {
                gamma[l] +=
                    d->X[b->nn + (size_t)(c * b->n + k)] * d->s[b->iu + k] * d->e[b->iu + k];
            }
        }
    }
    return mbsri_finite((size_t)o->k, gamma) ? MBSR_OK : mbsri_report_not_finite(m, d);
}

/* d gamma / d zeta, block by block: the c-th direction of every group is moved at once. */
static int differentiate(mbsr_ode *o)
{
    const int nu = o->m->nu;
    for (int c = 0; c < o->largest; ++c) {
        for (int l = 0; l < o->k; ++l) o->step[l] = o->place[l] == c ? 1.0 : 0.0;
        apply(o, o->step, o->increment);
        const double h = 1e-7 * (1.0 + mbsri_largest(nu, o->u)) / mbsri_largest(nu, o->increment);
        for (int k = 0; k < nu; ++k) o->trial[k] = o->u[k] + h * o->increment[k];
        const int status = forces_at(o, o->trial, o->moved);
        if (status) return status;
        for (int l = 0; l < o->k; ++l) {
            const int g = o->group[l], n = o->size[g];
            if (c >= n) continue;
            o->matrix[o->block[g] + (size_t)(c * n + o->place[l])] =
                (o->moved[l] - o->gamma[l]) / h;
        }
    }
    return MBSR_OK;
}

/* Elimination with row pivoting in the n x n block A, right-hand side b; false where it is
 * singular. */
static bool eliminate(int n, double *A, double *b)
{
    for (int k = 0; k < n; ++k) {
        int pivot = k;
        double size = 0.0;
        for (int r = 0; r < n; ++r) size = fmax(size, fabs(A[k * n + r]));
        for (int r = k + 1; r < n; ++r) {
            if (fabs(A[k * n + r]) > fabs(A[k * n + pivot])) pivot = r;
        }
        if (!(fabs(A[k * n + pivot]) > 1e-9 * size)) return false;
        for (int c = 0; c < n; ++c) {
            const double held = A[c * n + k];
            A[c * n + k] = A[c * n + pivot], A[c * n + pivot] = held;
        }
        const double held = b[k];
        b[k] = b[pivot], b[pivot] = held;
        for (int r = k + 1; r < n; ++r) {
            const double factor = A[k * n + r] / A[k * n + k];
            for (int c = k; c < n; ++c) A[c * n + r] -= factor * A[c * n + k];
            b[r] -= factor * b[k];
        }
    }
    for (int k = n - 1; k >= 0; --k) {
        for (int c = k + 1; c < n; ++c) b[k] -= A[c * n + k] * b[c];
        b[k] /= A[k * n + k];
    }
    return true;
}

/* step = -(d gamma / d zeta)^-1 gamma, group by group; `moved` is scratch. */
static int solve(mbsr_ode *o)
{
    double *b = o->moved;
    for (int g = 0; g < o->groups; ++g) {
        const int n = o->size[g], *member = o->member + o->first[g];
        for (int a = 0; a < n; ++a) b[a] = -o->gamma[member[a]];
        if (!eliminate(n, o->matrix + o->block[g], b)) {
            char label[MBSRI_LABEL];
            const int i = o->body[member[0]];
            return mbsri_fail(&o->d->error, MBSR_UNDETERMINED, o->m->body[i].id, MBSR_NONE,
                              "%s: no damping determines the velocity of its massless joint at "
                              "t = %g",
                              mbsri_body_label(o->m, i, label), o->d->t);
        }
        for (int a = 0; a < n; ++a) o->step[member[a]] = b[a];
    }
    return MBSR_OK;
}

/* Newton's method from o->u; corrections that stop shrinking are rounding and are accepted when
 * small. */
static int newton(mbsr_ode *o)
{
    enum { MOST = 30 };
    const int nu = o->m->nu;
    double before = INFINITY;
    for (int iteration = 0; iteration < MOST; ++iteration) {
        int status = forces_at(o, o->u, o->gamma);
        if (!status) status = differentiate(o);
        if (!status) status = solve(o);
        if (status) return status;
        apply(o, o->step, o->increment);
        for (int k = 0; k < nu; ++k) o->u[k] += o->increment[k];
        ++o->newton_steps;
        const double change = mbsri_largest(nu, o->increment), size = 1.0 + mbsri_largest(nu, o->u);
        if (change <= 1e-12 * size || (change > 0.25 * before && change <= 1e-8 * size))
            return MBSR_OK;
        before = change;
    }
    return mbsri_fail(
        &o->d->error, MBSR_NO_CONVERGENCE, MBSR_NONE, MBSR_NONE,
        "mbsr_ode: the massless velocities did not converge at t = %g (last change %g)", o->d->t,
        before);
}

/* Velocities of x into o->u, from those there; the data is left at forces of that state. */
static int velocities(mbsr_ode *o, double t, const double *x)
{
    const mbsr_model *m = o->m;
    mbsr_data *d = o->d;
    int status = mbsri_positions(m, d, t, x);
    if (!status) status = mbsri_velocities(m, d, o->u);
    if (!status) status = mbsri_backward_masses(m, d);
    if (status) return status;
    if (m->nu - d->total_rank != o->k) {
        return mbsri_fail(
            &d->error, MBSR_RANK_CHANGED, MBSR_NONE, MBSR_NONE,
            "mbsr_ode: the number of massless directions changes from %d to %d at t = %g", o->k,
            m->nu - d->total_rank, t);
    }
    mbsri_condense(m, d, x + m->nq);
    momentum_part(m, d, o->u);
    return o->k > 0 ? newton(o) : MBSR_OK;
}

int mbsr_ode_velocities(mbsr_ode *ode, double t, const double *x, double *u)
{
    if (!ode) return MBSR_ERR_NULL;
    int status = mbsri_enter(ode->m, ode->d, x && u, MBSRI_STAGE_NONE, "mbsr_ode_velocities");
    if (status) return status;
    const size_t nu = (size_t)ode->m->nu;
    mbsri_copy(nu, u, ode->u);
    status = velocities(ode, t, x);
    if (!status) mbsri_copy(nu, ode->u, u);
    return status;
}

int mbsr_ode_rhs(mbsr_ode *ode, double t, const double *x, double *xdot)
{
    if (!ode) return MBSR_ERR_NULL;
    const mbsr_model *m = ode->m;
    int status = mbsri_enter(m, ode->d, x && xdot, MBSRI_STAGE_NONE, "mbsr_ode_rhs");
    if (status) return status;
    if (!mbsri_finite((size_t)m->nu, ode->u)) mbsri_zero((size_t)m->nu, ode->u);
    status = velocities(ode, t, x);
    if (!status) status = mbsri_velocities(m, ode->d, ode->u);
    if (!status) status = mbsri_momentum_derivatives(m, ode->d, xdot, xdot + m->nq);
    if (status) return status;
    const size_t size = (size_t)(m->nq + m->nu);
    return mbsri_finite(size, xdot) ? MBSR_OK : mbsri_report_not_finite(m, ode->d);
}
