/* The entries of Newton systems in sparse augmented form: see augmented.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "augmented.h"

#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A null vector N of the mass matrix on one body of those that it moves, or whose joint it does. */
typedef struct augmented_null {
    int body;
    double N[LINEAR_RATES], V[6];
} augmented_null;

/* ---- entries ---- */

static void append(augmented_list *l, int row, int column, double value)
{
    if (l->count == l->room) {
        l->room = 2 * l->room + 1024;
        l->at = realloc(l->at, (size_t)l->room * sizeof *l->at);
        if (!l->at) bench_check(MBSR_ERR_NO_MEMORY, "entries", NULL);
    }
    l->at[l->count++] = (augmented_entry){row, column, value};
}

static void put(augmented *s, int row, int column, double value)
{
    append(&s->entries, row, column, value);
}

/* x^T (the six numbers of this kind of body i) in a row. */
static void put_product(augmented *s, int row, int i, int kind, double factor, const double x[6])
{
    for (int k = 0; k < s->dim; ++k)
        put(s, row, augmented_place(s, i, kind) + k, factor * x[s->part[k]]);
}

/* value theta_k of body i in a row. */
static void put_theta(augmented *s, int row, int i, int k, double value)
{
    const linear_body *b = s->linear.body + i;
    append(&s->shares, row, b->u + k, value);
    for (int l = 0; l < b->axes; ++l) {
        if (l == k || (b->free && l < 3 && k < 3))
            put(s, row, augmented_place(s, i, AUGMENTED_RATES) + l, value * b->theta[6 * k + l]);
    }
}

static void put_column(augmented *s, int row, int column, double factor, const double x[6])
{
    for (int k = 0; k < s->dim; ++k) put(s, row + k, column, factor * x[s->part[k]]);
}

static void put_thetas(augmented *s, int row, int i, int k, double factor, const double x[6])
{
    for (int j = 0; j < s->dim; ++j) put_theta(s, row + j, i, k, factor * x[s->part[j]]);
}

static void put_unit(augmented *s, int row, int column, double value)
{
    for (int k = 0; k < s->dim; ++k) put(s, row + k, column + k, value);
}

/* factor A (rows of `stride`) of unknowns from `column` on. */
static void put_matrix(augmented *s, int row, int column, double factor, const double *A,
                       int stride)
{
    for (int j = 0; j < s->dim; ++j) {
        for (int k = 0; k < s->dim; ++k)
            put(s, row + j, column + k, factor * A[stride * s->part[j] + s->part[k]]);
    }
}

/* ---- rows of a body ---- */

static void put_motion(augmented *s, int i)
{
    const linear_body *b = s->linear.body + i;
    for (int kind = AUGMENTED_XI; kind <= AUGMENTED_NU; ++kind) {
        put_unit(s, augmented_place(s, i, kind), augmented_place(s, i, kind), 1.0);
        if (b->parent >= 0)
            put_unit(s, augmented_place(s, i, kind), augmented_place(s, b->parent, kind), -1.0);
    }
    for (int k = 0; k < b->axes; ++k) {
        put_thetas(s, augmented_place(s, i, AUGMENTED_XI), i, k, -1.0, b->axis[k].S);
        put_thetas(s, augmented_place(s, i, AUGMENTED_NU), i, k, -1.0, b->axis[k].twist);
        put_column(s, augmented_place(s, i, AUGMENTED_NU),
                   augmented_place(s, i, AUGMENTED_RATES) + k, -1.0, b->axis[k].S);
    }
}

static void put_sums(augmented *s, int i)
{
    const linear_body *b = s->linear.body + i;
    const int chi = augmented_place(s, i, AUGMENTED_CHI),
              phi = augmented_place(s, i, AUGMENTED_PHI);
    put_unit(s, chi, chi, 1.0);
    put_unit(s, phi, phi, 1.0);
    if (s->linear.stiff->body[i].mass > 0.0)
        put_matrix(s, chi, augmented_place(s, i, AUGMENTED_NU), -1.0, b->M, 6);
    if (b->loaded) {
        put_matrix(s, phi, augmented_place(s, i, AUGMENTED_XI), -1.0, b->by_xi, 6);
        put_matrix(s, phi, augmented_place(s, i, AUGMENTED_NU), -1.0, b->by_nu, 6);
    }
    if (b->parent < 0) return;
    put_unit(s, augmented_place(s, b->parent, AUGMENTED_CHI), chi, -1.0);
    put_unit(s, augmented_place(s, b->parent, AUGMENTED_PHI), phi, -1.0);
    for (int k = 0; k < b->axes; ++k) {
        double turned[6];
        linear_cross_force(b->axis[k].S, b->h, turned);
        put_thetas(s, augmented_place(s, b->parent, AUGMENTED_CHI), i, k, -1.0, turned);
        linear_cross_force(b->axis[k].S, b->F, turned);
        put_thetas(s, augmented_place(s, b->parent, AUGMENTED_PHI), i, k, -1.0, turned);
    }
}

static void put_tie(augmented *s, const linear_tie *tie)
{
    for (int j = 0; j < 2; ++j) {
        for (int k = 0; k < 4; ++k)
            put_matrix(
                s, augmented_place(s, j ? tie->b : tie->a, AUGMENTED_PHI),
                augmented_place(s, k < 2 ? tie->a : tie->b, k % 2 ? AUGMENTED_NU : AUGMENTED_XI),
                -1.0, tie->by + 24 * 6 * j + 6 * k, 24);
    }
}

/* factor times c delta p_k - delta psi_k of joint i. */
static void put_balance(augmented *s, int row, int i, int k, double factor)
{
    const linear_body *b = s->linear.body + i;
    const linear_axis *a = b->axis + k;
    double by_chi[6], by_nu[6];
    for (int r = 0; r < 6; ++r) by_chi[r] = s->c * a->S[r] - a->rate[r];
    linear_cross_force(a->S, b->h, by_nu); /* (nu x S)^T h = nu^T (S x* h) */
    put_product(s, row, i, AUGMENTED_CHI, factor, by_chi);
    put_product(s, row, i, AUGMENTED_PHI, -factor, a->S);
    put_product(s, row, i, AUGMENTED_NU, -factor, by_nu);
    for (int l = 0; l < b->axes; ++l) {
        if (!(a->after & 1u << l)) continue;
        const linear_axis *after = b->axis + l;
        double h[6], F[6];
        linear_cross_force(after->S, b->h, h);
        linear_cross_force(after->S, b->F, F);
        put_theta(s, row, i, l,
                  factor * (linear_dot(by_chi, h) - linear_dot(a->S, F) +
                            linear_dot(after->twist, by_nu)));
        put(s, row, augmented_place(s, i, AUGMENTED_RATES) + l,
            factor * linear_dot(after->S, by_nu));
    }
    put_theta(s, row, i, k, factor * a->stiffness);
    put(s, row, augmented_place(s, i, AUGMENTED_RATES) + k, factor * a->damping);
}

/* ---- rows of null vectors ---- */

/* N = L^-T (the vector x of joint i): its parts; their number. */
static int find_null(augmented *s, int i, const double *x)
{
    const int bodies = s->linear.stiff->bodies;
    int parts = 0, *of = bench_allocate((size_t)bodies, sizeof *of); /* 1 + part */
    for (int j = i; j < bodies; ++j) {
        const linear_body *b = s->linear.body + j;
        const int from = b->parent >= 0 ? of[b->parent] : 0;
        double most = 0.0;
        if (j != i && !from) continue;
        augmented_null *p = s->null + parts;
        memset(p, 0, sizeof *p);
        p->body = j;
        if (j != i) memcpy(p->V, s->null[from - 1].V, sizeof p->V);
        for (int r = 0; r < 6; ++r) most = fmax(most, fabs(p->V[r]));
        for (int k = 0; k < b->axes; ++k)
            p->N[k] = j == i ? x[k] : -linear_dot(p->V, b->gain + 6 * k);
        for (int k = 0; k < b->axes; ++k) {
            for (int r = 0; r < 6; ++r) p->V[r] += p->N[k] * b->axis[k].S[r];
        }
        double left = 0.0;
        for (int r = 0; r < 6; ++r) left = fmax(left, fabs(p->V[r]));
        if (left < 1e-9 * most) memset(p->V, 0, sizeof p->V);
        ++parts;
        of[j] = left < 1e-9 * most ? 0 : parts;
    }
    free(of);
    return parts;
}

/* The field of N before axis k. */
static void before(const linear_body *b, const augmented_null *p, int k, double V[6])
{
    memcpy(V, p->V, 6 * sizeof *V);
    for (int l = 0; l < b->axes; ++l) {
        if (l != k && !(b->axis[k].after & 1u << l)) continue;
        for (int r = 0; r < 6; ++r) V[r] -= p->N[l] * b->axis[l].S[r];
    }
}

/* Change of V^T (V x* M V - F) of a body with xi and nu, and of N^T times the linearised inverse
 * dynamics with theta. */
static void put_null_part(augmented *s, int row, const augmented_null *p)
{
    const int i = p->body;
    const linear_body *b = s->linear.body + i;
    double by_nu[6], by_xi[6];
    for (int r = 0; r < 6; ++r) {
        double unit[6] = {0.0}, h[6] = {0.0}, turned[6], Mr[6];
        unit[r] = 1.0;
        for (int k = 0; k < 36; ++k) h[k / 6] += b->M[k] * b->V[k % 6];
        for (int k = 0; k < 6; ++k) Mr[k] = b->M[6 * k + r];
        linear_cross_force(unit, h, turned);
        by_nu[r] = linear_dot(p->V, turned);
        linear_cross_force(b->V, Mr, turned);
        by_nu[r] += linear_dot(p->V, turned);
        by_xi[r] = 0.0;
        for (int k = 0; k < 6; ++k) {
            by_nu[r] -= p->V[k] * b->by_nu[6 * k + r];
            by_xi[r] -= p->V[k] * b->by_xi[6 * k + r];
        }
    }
    put_product(s, row, i, AUGMENTED_NU, 1.0, by_nu);
    put_product(s, row, i, AUGMENTED_XI, 1.0, by_xi);
    for (int k = 0; k < b->axes; ++k) {
        const linear_axis *a = b->axis + k;
        double V[6], moved[6];
        before(b, p, k, V);
        linear_cross(b->free && k < 3 ? p->V : V, a->S, moved);
        put_theta(s, row, i, k, linear_dot(moved, b->B) + p->N[k] * a->stiffness);
        put(s, row, augmented_place(s, i, AUGMENTED_RATES) + k, p->N[k] * a->damping);
    }
}

static void put_null_ties(augmented *s, int row, const augmented_null *p)
{
    for (int l = 0; l < s->linear.stiff->balls; ++l) {
        const linear_tie *tie = s->linear.tie + l;
        for (int j = 0; j < 2; ++j) {
            if ((j ? tie->b : tie->a) != p->body) continue;
            for (int k = 0; k < 4; ++k) {
                double by[6] = {0.0};
                for (int r = 0; r < 36; ++r)
                    by[r % 6] -= p->V[r / 6] * tie->by[24 * (6 * j + r / 6) + 6 * k + r % 6];
                put_product(s, row, k < 2 ? tie->a : tie->b, k % 2 ? AUGMENTED_NU : AUGMENTED_XI,
                            1.0, by);
            }
        }
    }
}

static void put_joint(augmented *s, int i)
{
    const linear_body *b = s->linear.body + i;
    int row = augmented_place(s, i, AUGMENTED_RATES);
    if (b->rank == b->axes) {
        for (int k = 0; k < b->axes; ++k) put_balance(s, row + k, i, k, 1.0);
        return;
    }
    for (int j = 0; j < b->rank; ++j, ++row) {
        for (int k = 0; k < b->axes; ++k) put_balance(s, row, i, k, b->range[6 * j + k]);
    }
    for (int j = 0; j < b->axes - b->rank; ++j, ++row) {
        const int parts = find_null(s, i, b->null + 6 * j);
        for (int k = 0; k < parts; ++k) {
            put_null_part(s, row, s->null + k);
            put_null_ties(s, row, s->null + k);
        }
    }
}

static void put_all(augmented *s)
{
    s->entries.count = s->shares.count = 0;
    for (int i = 0; i < s->linear.stiff->bodies; ++i) {
        put_motion(s, i);
        put_sums(s, i);
        put_joint(s, i);
    }
    for (int k = 0; k < s->linear.stiff->balls; ++k) put_tie(s, s->linear.tie + k);
}

int augmented_at(augmented *s, double t, const double *y, double c)
{
    memcpy(s->y, y, (size_t)mbsr_dae_size(s->model, MBSR_DAE_MOMENTUM) * sizeof *y);
    s->c = c;
    const int status = linear_at(&s->linear, s->model, s->data, t, y, c);
    if (!status) put_all(s);
    return status;
}

static void number_unknowns(augmented *s, int in_plane)
{
    static const int plane[3] = {2, 3, 4};
    const int bodies = s->linear.stiff->bodies;
    s->dim = in_plane ? 3 : 6;
    for (int k = 0; k < s->dim; ++k) s->part[k] = in_plane ? plane[k] : k;
    s->first = bench_allocate((size_t)bodies, sizeof *s->first);
    for (int i = 0; i < bodies; ++i) {
        s->first[i] = s->size;
        s->size += 4 * s->dim + s->linear.body[i].axes;
    }
    s->null = bench_allocate((size_t)bodies, sizeof *s->null);
    s->passed = bench_allocate(6 * (size_t)bodies, sizeof *s->passed);
}

void augmented_open(augmented *s, const stiff_model *stiff, const mbsr_model *model,
                    mbsr_data *data)
{
    const size_t n = (size_t)mbsr_dae_size(model, MBSR_DAE_MOMENTUM);
    s->model = model;
    s->data = data;
    linear_open(&s->linear, stiff, model);
    number_unknowns(s, mbsr_body_dimension(model, 0) == 3);
    s->y = bench_allocate(n, sizeof *s->y);
    s->u = s->y + mbsr_model_nq(model) + mbsr_model_nu(model);
    s->theta = bench_allocate(n, sizeof *s->theta);
    s->w = bench_allocate(n, sizeof *s->w);
}

void augmented_close(augmented *s)
{
    linear_close(&s->linear);
    void *const owned[] = {s->first, s->entries.at, s->shares.at, s->theta,
                           s->w,     s->null,       s->y,         s->passed};
    for (size_t k = 0; k < sizeof owned / sizeof owned[0]; ++k) free(owned[k]);
}
