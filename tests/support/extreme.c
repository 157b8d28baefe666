/* Trees whose masses and lengths differ by many powers of ten.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "extreme.h"

#include "expect.h"
#include "space.h"

#include "recursion/data.h"

static double between(test_rng *rng, double low, double high)
{
    return low + (high - low) * 0.5 * (1.0 + test_uniform(rng));
}

void extreme_make(extreme *s, uint64_t seed)
{
    test_rng rng = test_seed(seed);
    assert_ok(mbsr_model_create(NULL, &s->model, NULL), NULL);
    const int bodies = 2 + (int)(seed % (EXTREME_BODIES - 1));
    for (int i = 0; i < bodies; ++i) {
        mbsr_body_def body = mbsr_default_body_def();
        if (i > 0) body.parent = test_integer(&rng, -1, i - 1);
        const double length = pow(10.0, between(&rng, -9.0, 9.0)),
                     mass = pow(10.0, between(&rng, -30.0, 30.0));
        int kind = test_integer(&rng, TEST_REVOLUTE, TEST_FREE);
        if (kind == TEST_COMPOUND) kind = TEST_UNIVERSAL;
        body.joint = test_joint_in_space(&rng, kind, length);
        double size = pow(10.0, between(&rng, -9.0, 9.0)), edges[3];
        if (seed % 2) size = length;
        for (int k = 0; k < 3; ++k) edges[k] = size * between(&rng, 0.2, 1.0);
        const mbsr_frame at = test_frame(&rng, size);
        body.inertia = mbsr_inertia_in_frame(
            &at, mbsr_inertia_box(mass / (edges[0] * edges[1] * edges[2]), edges));
        assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.3, -9.81, 0.4);
    assert_ok(mbsr_model_add_force(s->model, &gravity, NULL), mbsr_model_error(s->model));
    assert_ok(mbsr_model_finish(s->model), mbsr_model_error(s->model));
    assert_ok(mbsr_data_create(s->model, &s->data, NULL), NULL);
    s->nq = mbsr_model_nq(s->model);
    s->nu = mbsr_model_nu(s->model);
    rng = test_seed(seed + 1000000);
    test_fill(&rng, s->nq, s->q);
    test_fill(&rng, s->nu, s->u);
}

void extreme_free(extreme *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

/* ---- in long double; all bodies have d = 6 ---- */

typedef long double real;

typedef struct place {
    real Mbar[36], U[36], Dinv[36]; /* n: columns of U, rows and columns of Dinv */
    real sum[6], load[6], A[6];     /* of the recursion for loads */
} place;

/* Dinv (n x n) of D by elimination. */
static void invert(int n, const real *D, real *Dinv)
{
    real W[6][12];
    for (int r = 0; r < n; ++r) {
        for (int c = 0; c < n; ++c) W[r][c] = D[6 * c + r], W[r][n + c] = r == c;
    }
    for (int k = 0; k < n; ++k) {
        const real pivot = W[k][k];
        for (int c = 0; c < 2 * n; ++c) W[k][c] /= pivot;
        for (int r = 0; r < n; ++r) {
            const real factor = W[r][k];
            for (int c = 0; c < 2 * n && r != k; ++c) W[r][c] -= factor * W[k][c];
        }
    }
    for (int r = 0; r < n; ++r) {
        for (int c = 0; c < n; ++c) Dinv[6 * c + r] = W[r][n + c];
    }
}

static void factor(const mbsr_model *m, const mbsr_data *d, place *at)
{
    for (int i = 0; i <= m->bodies; ++i) {
        for (int k = 0; k < 36; ++k) at[i].Mbar[k] = i > 0 ? d->M[m->body[i].dd + (size_t)k] : 0.0;
    }
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const double *J = d->J + b->dn, *H = d->H + b->dp;
        place *p = at + i;
        real D[36] = {0.0L}, P[36];
        for (int k = 0; k < 6 * b->n; ++k) {
            p->U[k] = 0.0L;
            for (int c = 0; c < 6; ++c) p->U[k] += p->Mbar[6 * c + k % 6] * J[6 * (k / 6) + c];
        }
        for (int k = 0; k < b->n; ++k) {
            for (int l = 0; l < b->n; ++l) {
                for (int r = 0; r < 6; ++r) D[6 * l + k] += J[6 * k + r] * p->U[6 * l + r];
            }
        }
        invert(b->n, D, p->Dinv);
        for (int e = 0; e < 36; ++e) {
            P[e] = p->Mbar[e];
            for (int k = 0; k < b->n; ++k) {
                for (int l = 0; l < b->n; ++l)
                    P[e] -= p->U[6 * k + e % 6] * p->Dinv[6 * l + k] * p->U[6 * l + e / 6];
            }
        }
        for (int e = 0; e < 36 && b->pred.d == 6; ++e) {
            for (int j = 0; j < 6; ++j) {
                for (int k = 0; k < 6; ++k)
                    at[b->parent].Mbar[e] += H[6 * (e % 6) + j] * P[6 * k + j] * H[6 * (e / 6) + k];
            }
        }
    }
}

/* udot (by the order of the caller) from the forces of the state, or from joint forces tau alone.
 */
static void solve(const mbsr_model *m, const mbsr_data *d, place *at, const real *tau, real *udot)
{
    for (int i = 0; i <= m->bodies; ++i) {
        for (int k = 0; k < 6; ++k) {
            at[i].A[k] = 0.0L;
            at[i].sum[k] = i > 0 && !tau ? d->f[m->body[i].v + (size_t)k] : 0.0;
        }
    }
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        const double *J = d->J + b->dn, *H = d->H + b->dp, *kII = d->kII + b->v;
        place *p = at + i;
        for (int e = 0; e < 36 && !tau; ++e) p->sum[e % 6] += p->Mbar[e] * kII[e / 6];
        for (int k = 0; k < b->n; ++k) {
            p->load[k] = tau ? tau[b->u + k] : d->tau[b->iu + k];
            for (int r = 0; r < 6; ++r) p->load[k] -= J[6 * k + r] * p->sum[r];
        }
        for (int k = 0; k < b->n; ++k) {
            for (int l = 0; l < b->n; ++l) {
                const real rate = p->Dinv[6 * l + k] * p->load[l];
                for (int r = 0; r < 6; ++r) p->sum[r] += p->U[6 * k + r] * rate;
            }
        }
        for (int e = 0; e < 36 && b->pred.d == 6; ++e)
            at[b->parent].sum[e / 6] -= H[e] * p->sum[e % 6];
    }
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const double *J = d->J + b->dn, *H = d->H + b->dp;
        place *p = at + i;
        real x[6] = {0.0L};
        for (int e = 0; e < 36 && b->pred.d == 6; ++e) x[e % 6] += H[e] * at[b->parent].A[e / 6];
        for (int k = 0; k < b->n; ++k) {
            for (int r = 0; r < 6; ++r) p->load[k] -= p->U[6 * k + r] * x[r];
        }
        for (int r = 0; r < 6; ++r) p->A[r] = -x[r] - (tau ? 0.0 : d->kII[b->v + (size_t)r]);
        for (int k = 0; k < b->n; ++k) {
            udot[b->u + k] = 0.0L;
            for (int l = 0; l < b->n; ++l) udot[b->u + k] += p->Dinv[6 * l + k] * p->load[l];
            for (int r = 0; r < 6; ++r) p->A[r] -= J[6 * k + r] * udot[b->u + k];
        }
    }
}

/* tau - (inverse dynamics of udot) */
static void residual(const mbsr_model *m, const mbsr_data *d, place *at, const real *udot, real *r)
{
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        place *p = at + i;
        for (int c = 0; c < 6; ++c) p->A[c] = -(real)d->kII[b->v + (size_t)c];
        for (int e = 0; e < 36 && b->pred.d == 6; ++e)
            p->A[e % 6] -= d->H[b->dp + (size_t)e] * at[b->parent].A[e / 6];
        for (int e = 0; e < 6 * b->n; ++e)
            p->A[e % 6] -= d->J[b->dn + (size_t)e] * udot[b->u + e / 6];
        for (int c = 0; c < 6; ++c) p->sum[c] = d->f[b->v + (size_t)c];
        for (int e = 0; e < 36; ++e) p->sum[e % 6] -= d->M[b->dd + (size_t)e] * p->A[e / 6];
    }
    for (int i = m->bodies; i >= 1; --i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k) r[b->u + k] = d->tau[b->iu + k];
        for (int e = 0; e < 6 * b->n; ++e)
            r[b->u + e / 6] -= d->J[b->dn + (size_t)e] * at[i].sum[e % 6];
        for (int e = 0; e < 36 && b->pred.d == 6; ++e)
            at[b->parent].sum[e / 6] -= d->H[b->dp + (size_t)e] * at[i].sum[e % 6];
    }
}

static double square_of(const mbsr_data *d, const mbsri_body *b, const double *x)
{
    double sum = 0.0;
    for (int j = 0; j < b->n; ++j) {
        for (int k = 0; k < b->n; ++k) sum += x[j] * d->D[b->nn + (size_t)(j * b->n + k)] * x[k];
    }
    return fmax(sum, 0.0);
}

double extreme_distance(const extreme *s, const double *x, const double *y)
{
    double difference[EXTREME_NU], largest = 0.0;
    for (int k = 0; k < s->nu; ++k) difference[k] = x[k] - y[k];
    for (int i = 1; i <= s->model->bodies; ++i) {
        const mbsri_body *b = s->model->body + i;
        const double off = square_of(s->data, b, difference + b->u),
                     size = square_of(s->data, b, y + b->u);
        if (off > 0.0) largest = fmax(largest, size > 0.0 ? sqrt(off / size) : 1.0);
    }
    return largest;
}

double extreme_accelerations(const extreme *s, double *udot)
{
    static place at[EXTREME_BODIES + 1];
    real x[EXTREME_NU], r[EXTREME_NU], change[EXTREME_NU];
    double before[EXTREME_NU];
    factor(s->model, s->data, at);
    solve(s->model, s->data, at, NULL, x);
    residual(s->model, s->data, at, x, r);
    solve(s->model, s->data, at, r, change);
    for (int k = 0; k < s->nu; ++k) {
        before[k] = (double)x[k];
        udot[k] = (double)(x[k] + change[k]);
    }
    return extreme_distance(s, before, udot);
}
