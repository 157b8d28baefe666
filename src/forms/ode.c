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
 * group at once, and the groups are solved apart.
 *
 * A slope of gamma counts as damping where it exceeds what rounding makes of a zero (damping.c).
 * The forward differences of a short step tell mostly; where they do not, the step is looked for, a
 * decade at a time. */
#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forms/damping.h"
#include "forms/momentum.h"
#include "model/query.h"
#include "recursion/backward.h"
#include "recursion/elements.h"
#include "recursion/forward.h"
#include "recursion/kinematics.h"
#include "recursion/not_finite.h"
#include "recursion/rank.h"
#include "recursion/sizes.h"
#include "recursion/spans.h"

#include <mbsrank/ode.h>

#include <math.h>

enum { DECADES = MBSRI_HIGHEST_DECADE - MBSRI_LOWEST_DECADE + 1 };

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
    int *pivots;   /* largest */
    double *matrix, *error;
    double *work;                      /* 6 largest */
    double *slopes, *sizes;            /* k x DECADES: of one column, and of the forces */
    double *gamma, *displaced, *step;  /* k */
    double *x, *u, *trial, *increment; /* nq + nu, nu, nu, nu */
    double fastest;                    /* of the rates at the start, over their spans, 1/s */
    long newton_steps, evaluations;
    void *memory;
};

/* ---- grouping ---- */

static int root_of_set(const int *parent, int l)
{
    while (parent[l] != l) l = parent[l];
    return l;
}

static void join_sets(int *parent, int a, int b)
{
    const int ra = root_of_set(parent, a), rb = root_of_set(parent, b);
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
        const bool through = !m->body[pred].mass.regular || d->rank[pred] < m->body[pred].n;
        if (!mbsri_heads(m, d, i)) continue;
        if (owner[pred] >= 0 && through) owner[i] = owner[pred];
        const mbsri_group g = mbsri_group_of(m, d, i);
        for (int n = mbsri_group_rank(d, &g); n < g.n; ++n, ++l) {
            parent[l] = l;
            if (owner[i] >= 0) join_sets(parent, owner[i], l);
            owner[i] = root_of_set(parent, l);
        }
        for (int k = 1; k < g.members; ++k) owner[g.member[k]] = owner[i];
    }
}

/* Force elements join the directions of their bodies. */
static void join_by_forces(const mbsr_model *m, const int *owner, int *parent)
{
    const mbsri_force *force = m->forces.data;
    for (size_t id = 0; id < m->forces.count; ++id) {
        int first = -1;
        for (int k = 0; k < force[id].def.bodies; ++k) {
            const int mine = owner[m->stored.list_index[force[id].list + (size_t)k]];
            if (mine < 0) continue;
            if (first >= 0) join_sets(parent, first, mine);
            first = first >= 0 ? first : mine;
        }
    }
}

/* Groups numbered in the order of their first direction. parent becomes scratch. */
static void number_groups(mbsr_ode *o, int *parent)
{
    o->groups = o->largest = 0;
    for (int l = 0; l < o->k; ++l) {
        const int root = root_of_set(parent, l);
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

static int no_memory_for_ode(mbsr_data *d)
{
    return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "mbsr_ode_create: no memory");
}

/* Directions, groups; then everything whose size depends on them. */
static int build_ode(mbsr_ode *o)
{
    const mbsr_model *m = o->m;
    const size_t k = (size_t)o->k, bodies = (size_t)m->bodies + 1;
    o->body = mbsri_allocate(&m->allocator, (8 * k + bodies) * sizeof(int) + k * sizeof(size_t));
    if (!o->body) return no_memory_for_ode(o->d);
    o->block = (size_t *)(void *)o->body;
    o->body = (int *)(void *)(o->block + k);
    o->group = o->body + k;
    o->place = o->group + k;
    o->size = o->place + k;
    o->first = o->size + k;
    o->member = o->first + k;
    o->pivots = o->member + k;
    int *parent = o->pivots + k, *owner = parent + k;
    claim(m, o->d, owner, parent);
    join_by_forces(m, owner, parent);
    number_groups(o, parent);
    int l = 0;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, o->d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, o->d, i);
        for (int n = mbsri_group_rank(o->d, &g); n < g.n; ++n) o->body[l++] = i;
    }
    size_t entries = 0;
    for (int g = 0; g < o->groups; ++g) entries += (size_t)o->size[g] * (size_t)o->size[g];
    const size_t nu = (size_t)m->nu, size = (size_t)m->nq + nu;
    double **const array[] = {&o->matrix, &o->error, &o->work,      &o->slopes,
                              &o->sizes,  &o->gamma, &o->displaced, &o->step,
                              &o->x,      &o->u,     &o->trial,     &o->increment};
    const size_t length[] = {
        entries, entries, 6 * (size_t)o->largest, DECADES * k, DECADES * k, k, k, k, size, nu,
        nu,      nu};
    size_t total = 0;
    for (size_t a = 0; a < sizeof length / sizeof length[0]; ++a) total += length[a];
    double *next = mbsri_allocate(&m->allocator, total * sizeof *next);
    o->memory = next;
    if (!next) return no_memory_for_ode(o->d);
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
    int status = mbsri_enter_tree(model, data, q && u && ode, MBSRI_STAGE_NONE, "mbsr_ode_create");
    if (!status) status = mbsri_positions(model, data, t, q);
    if (!status) status = mbsri_velocities(model, data, u);
    if (!status) status = mbsri_backward_masses(model, data);
    if (status) return status;
    mbsr_ode *o = mbsri_allocate(&model->allocator, sizeof *o);
    if (!o) return no_memory_for_ode(data);
    *o = (mbsr_ode){.m = model, .d = data, .k = model->nu - data->total_rank};
    status = build_ode(o);
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
    const size_t nq = (size_t)ode->m->nq, nu = (size_t)ode->m->nu;
    mbsri_momenta(ode->m, ode->d, x + nq);
    mbsri_copy(nq, q, x);
    return mbsri_check_result(ode->m, ode->d, nq + nu, x, "mbsr_ode_pack");
}

/* ---- velocities ---- */

/* u with the momenta of ep and the massless parts of u (both by the caller's order), root to
 * leaves. reads ep, U, Dinv, H, J, kI, X, s;  writes V, u. */
static void momentum_part(const mbsr_model *m, mbsr_data *d, double *u)
{
    double *x = d->scratch + m->most.d, *load = x + m->most.d, *given = load + m->most.d,
           *found = given + m->most.d;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double *V = d->V + b->v, *ui = u + b->u;
        mbsri_zero((size_t)b->d, x);
        mbsri_ax(b->d, b->pred.d, 1.0, d->H + b->dp, d->V + b->pred.v, x);
        if (mbsri_heads(m, d, i)) {
            /* u = D^+ (ep - U^T H V_pi) + null part */
            const mbsri_group g = mbsri_group_of(m, d, i);
            mbsri_group_gather(m, &g, u, given);
            mbsri_zero((size_t)g.n, found);
            if (mbsri_group_rank(d, &g) < g.n) mbsri_null_part(m, d, &g, given, found);
            mbsri_copy((size_t)g.n, d->ep + g.ig, load);
            mbsri_atx(b->d, g.n, -1.0, d->U + b->dg, x, load);
            mbsri_ax(g.n, g.n, 1.0, d->Dinv + b->nn, load, found);
            mbsri_group_scatter(m, &g, found, u);
        }
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
    double *x = d->scratch, *a = x + m->most.d;
    int l = 0;
    d->carries[0] = false;
    for (int i = 1; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        const int rank = mbsri_group_rank(d, &g);
        const double *X = d->X + m->body[i].nn, *s = d->s + g.ig;
        mbsri_zero((size_t)g.n, a);
        for (int c = rank; c < g.n; ++c, ++l) {
            for (int k = 0; k < g.n; ++k) a[k] += s[k] * X[c * g.n + k] * weights[l];
        }
        const bool below = mbsri_null_below(m, d, i, x);
        mbsri_null_pass(m, d, &g, rank < g.n, below, x, a);
        mbsri_group_scatter(m, &g, a, du);
    }
}

/* The null vector of direction l into x (n). */
static void null_vector(const mbsr_ode *o, int l, double *x)
{
    const mbsri_group g = mbsri_group_of(o->m, o->d, o->body[l]);
    int first = l;
    while (first > 0 && o->body[first - 1] == o->body[l]) --first;
    const double *X = o->d->X + o->m->body[o->body[l]].nn +
                      (size_t)((mbsri_group_rank(o->d, &g) + l - first) * g.n);
    for (int k = 0; k < g.n; ++k) x[k] = X[k] * o->d->s[g.ig + k];
}

/* gamma at velocities u; sizes, unless NULL, become at least those of what balances there.
 * Positions and masses are in the data. */
static int forces_at(mbsr_ode *o, const double *u, double *gamma, double *sizes)
{
    const mbsr_model *m = o->m;
    mbsr_data *d = o->d;
    double *vector = d->vec;
    int status = mbsri_velocities(m, d, u);
    if (!status) status = mbsri_forces(m, d, NULL, NULL);
    if (status) return status;
    mbsri_backward_loads(m, d);
    if (sizes) mbsri_gross_forces(m, d);
    ++o->evaluations;
    for (int l = 0; l < o->k; ++l) {
        const mbsri_group g = mbsri_group_of(m, d, o->body[l]);
        null_vector(o, l, vector);
        gamma[l] = mbsri_dot(g.n, vector, d->e + g.ig);
        if (sizes) sizes[l] = fmax(sizes[l], mbsri_gross_load(m, d, &g, vector));
    }
    return mbsri_check_result(m, d, (size_t)o->k, gamma, "mbsr_ode");
}

/* The c-th direction of every group at once, into o->increment; returns the step of the size of
 * the state. */
static double direction(mbsr_ode *o, int c)
{
    for (int l = 0; l < o->k; ++l) o->step[l] = o->place[l] == c ? 1.0 : 0.0;
    apply(o, o->step, o->increment);
    return mbsri_rate_step(o->m, o->increment, o->u);
}

/* Where entry (l, direction c of its group) stands in matrix and error. */
static size_t block_entry(const mbsr_ode *o, int l, int c)
{
    return o->block[o->group[l]] + (size_t)(c * o->size[o->group[l]] + o->place[l]);
}

/* gamma at u + h increment, with the sizes there. */
static int displaced(mbsr_ode *o, double h, double *gamma, double *sizes)
{
    for (int k = 0; k < o->m->nu; ++k) o->trial[k] = o->u[k] + h * o->increment[k];
    return forces_at(o, o->trial, gamma, sizes);
}

/* A slope along direction l that is none: what the rates at the start make of levers that are
 * rounding, beside the inertia that the rates of the joint move by themselves. */
static double slope_of_levers(const mbsr_ode *o, int l)
{
    static const double rounding = 1e-24; /* their squares over those of others, with room */
    const mbsri_body *b = o->m->body + o->body[l];
    return o->d->scale[b->scalar_offset] > 0.0 ? rounding * o->fastest : 0.0;
}

/* d gamma / d zeta, block by block, by forward differences of a short step, and its errors. */
static int difference_gamma(mbsr_ode *o)
{
    static const double share = 1e-7;
    for (int c = 0; c < o->largest; ++c) {
        const double unit = direction(o, c), h = share * unit;
        mbsri_zero((size_t)o->k, o->sizes);
        const int status = displaced(o, h, o->displaced, o->sizes);
        if (status) return status;
        for (int l = 0; l < o->k; ++l) {
            if (c >= o->size[o->group[l]]) continue;
            const double slope = (o->displaced[l] - o->gamma[l]) / h;
            o->matrix[block_entry(o, l, c)] = slope;
            o->error[block_entry(o, l, c)] =
                mbsri_slope_noise(1, 0, 1, &slope, o->sizes[l], share, unit) +
                slope_of_levers(o, l);
        }
    }
    return MBSR_OK;
}

/* The same by central differences over all steps that the model can be evaluated at, each entry by
 * its best one. */
static int differentiate_with_care(mbsr_ode *o)
{
    const int k = o->k;
    const double lowest = pow(10.0, MBSRI_LOWEST_DECADE);
    for (int c = 0; c < o->largest; ++c) {
        const double unit = direction(o, c);
        int count = 0;
        mbsri_zero(DECADES * (size_t)k, o->sizes);
        for (; count < DECADES; ++count) {
            const double h = unit * pow(10.0, MBSRI_LOWEST_DECADE + count);
            double *slopes = o->slopes + count * k, *sizes = o->sizes + count * k;
            const mbsr_error reported = o->d->error;
            int status = displaced(o, -h, slopes, sizes);
            if (!status) status = displaced(o, h, o->displaced, sizes);
            if (status && MBSRI_LOWEST_DECADE + count <= MBSRI_NEAR_DECADE) return status;
            if (status) {
                o->d->error = reported;
                break;
            }
            for (int l = 0; l < k; ++l) slopes[l] = (o->displaced[l] - slopes[l]) / (2.0 * h);
        }
        for (int l = 0; l < k; ++l) {
            if (c >= o->size[o->group[l]]) continue;
            o->matrix[block_entry(o, l, c)] =
                mbsri_best_slope(count, k, o->slopes + l, o->sizes + l, lowest, unit,
                                 o->error + block_entry(o, l, c));
            o->error[block_entry(o, l, c)] += slope_of_levers(o, l);
        }
    }
    return MBSR_OK;
}

/* The blocks become their inverses; returns a direction that is not determined, or -1. */
static int invert_blocks(mbsr_ode *o)
{
    for (int g = 0; g < o->groups; ++g) {
        int weakest;
        if (!mbsri_invert_within(o->size[g], o->matrix + o->block[g], o->error + o->block[g],
                                 o->pivots, o->work, &weakest))
            return o->member[o->first[g] + weakest];
    }
    return -1;
}

/* step = -(d gamma / d zeta)^-1 gamma, group by group. */
static int solve_groups(mbsr_ode *o)
{
    int status = difference_gamma(o);
    if (status) return status;
    int open = invert_blocks(o);
    if (open >= 0) {
        status = differentiate_with_care(o);
        if (status) return status;
        open = invert_blocks(o);
    }
    if (open >= 0) {
        char label[MBSRI_LABEL];
        const int i = o->body[open];
        return mbsri_fail(&o->d->error, MBSR_UNDETERMINED, o->m->body[i].id, MBSR_NONE,
                          "%s: no damping determines the velocity of its massless joint at t = %g",
                          mbsri_body_label(o->m, i, label), o->d->t);
    }
    mbsri_zero((size_t)o->k, o->step);
    for (int g = 0; g < o->groups; ++g) {
        const int n = o->size[g], *member = o->member + o->first[g];
        const double *A = o->matrix + o->block[g];
        for (int c = 0; c < n; ++c) {
            for (int r = 0; r < n; ++r) o->step[member[r]] -= A[c * n + r] * o->gamma[member[c]];
        }
    }
    return MBSR_OK;
}

/* Newton's method from o->u; corrections that stop shrinking are rounding and are accepted when
 * small. */
static int newton(mbsr_ode *o)
{
    enum { MOST = 30 };
    const int nu = o->m->nu;
    const mbsri_spans spans = mbsri_spans_of(o->m, NULL);
    double before = INFINITY;
    for (int iteration = 0; iteration < MOST; ++iteration) {
        int status = forces_at(o, o->u, o->gamma, NULL);
        if (!status) status = solve_groups(o);
        if (status) return status;
        apply(o, o->step, o->increment);
        for (int k = 0; k < nu; ++k) o->u[k] += o->increment[k];
        ++o->newton_steps;
        const double change = mbsri_largest_rate(o->m, o->increment),
                     size = mbsri_span_rate(&spans) + mbsri_largest_rate(o->m, o->u);
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
static int solve_velocities(mbsr_ode *o, double t, const double *x)
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
    o->fastest = mbsri_largest_rate(m, o->u);
    return o->k > 0 ? newton(o) : MBSR_OK;
}

int mbsr_ode_velocities(mbsr_ode *ode, double t, const double *x, double *u)
{
    if (!ode) return MBSR_ERR_NULL;
    int status = mbsri_enter(ode->m, ode->d, x && u, MBSRI_STAGE_NONE, "mbsr_ode_velocities");
    if (status) return status;
    const size_t nu = (size_t)ode->m->nu;
    mbsri_copy(nu, u, ode->u);
    status = solve_velocities(ode, t, x);
    if (!status) status = mbsri_check_result(ode->m, ode->d, nu, ode->u, "mbsr_ode_velocities");
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
    status = solve_velocities(ode, t, x);
    if (!status) status = mbsri_velocities(m, ode->d, ode->u);
    if (!status) status = mbsri_momentum_derivatives(m, ode->d, NULL, xdot, xdot + m->nq);
    if (status) return status;
    const size_t size = (size_t)(m->nq + m->nu);
    return mbsri_check_result(m, ode->d, size, xdot, "mbsr_ode_rhs");
}
