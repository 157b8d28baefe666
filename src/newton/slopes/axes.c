/* Derivatives of a joint that is a sequence of axes: see axes.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With S = -J at the body's origin, r from the predecessor's origin, and omega_k the angular
 * velocity past axis k,
 *
 *   omega_i = omega + sum S_w u,   v_i = v + omega x r + sum S_v u,   dr = S_v dq
 *   S_j' = omega_j x S_j + (0, S_jw x z_j),   z_j = sum over k > j of S_kv u_k
 *
 * where x from the left goes to both halves. A coordinate k carries what stands behind it, so that
 * E_jk, the change of S_j along q_k, and of S_j' along u_k, is S_kw x S_j for j > k, and (0, S_jw x
 * S_kv) else. Along q_k
 *
 *   dV = (S_kw x w_k, omega_k x S_kv + S_kw x z_k),   w_k = sum over j > k of S_jw u_j
 *   dS_j' = domega_j x S_j + omega_j x E_jk + (0, E_jkw x z_j + S_jw x dz_j)
 *
 * with domega_j = S_kw x (omega_j - omega_k) for j > k, else 0, and dz_j = S_kw x z_j for j >= k,
 * else (omega_k - omega_j) x S_kv + S_kw x z_k. Along the predecessor's motion: joint_turns.h. */
#include "newton/slopes/axes.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "joints/chain.h"

enum { MOST = MBSRI_MAX_STEPS };

typedef struct axes {
    int n;
    const double *J, *Jdot, *m, *sigma; /* m, sigma: of the joint, impulse and its rate */
    const double *above;                /* V of the predecessor */
    double r[3], rate[3], between[6];   /* r', (w, z) of all */
    double omega[MOST][3], w[MOST][3], z[MOST][3]; /* past each axis; of those behind it */
} axes;

bool mbsri_axes_serve(const mbsri_body *b)
{
    const mbsri_joint *joint = &b->joint;
    const bool chain = joint->space == MBSR_SPACE_SPATIAL &&
                       joint->table->tangent == mbsri_chain_tangent,
               seen = b->pred.space == MBSR_SPACE_SPATIAL || b->pred.space == MBSR_SPACE_FIXED;
    if (!chain || !seen || b->lock.count || b->nq != b->n || joint->option[0] != b->n) return false;
    for (int k = 0; k < b->n; ++k) {
        const int code = joint->option[1 + k];
        if ((code & MBSRI_STEP_KIND) == MBSRI_QUATERNION || code & MBSRI_DRIVEN ||
            code >> MBSRI_PLACE_SHIFT != k)
            return false;
    }
    return true;
}

/* c += a x b, the halves of b */
static void add_turn(const double a[3], const double b[6], double c[6])
{
    mbsri_add_cross3(a, b, c);
    mbsri_add_cross3(a, b + 3, c + 3);
}

/* J_w x m_1 + J_v x m_2: along a rotation of J, its products with m. */
static void moment(const double J[6], const double m[6], double out[3])
{
    mbsri_cross3(J, m, out);
    mbsri_add_cross3(J + 3, m + 3, out);
}

static void see(const mbsri_body *b, const mbsr_data *d, axes *a)
{
    static const double still[6] = {0.0};
    const bool fixed = b->pred.space == MBSR_SPACE_FIXED;
    const double *V = d->V + b->v, *x = d->p + b->p + MBSR_POSE_X,
                 *x_pred = fixed ? still : d->p + b->pred.p + MBSR_POSE_X, *u = d->u + b->iu;
    *a = (axes){.n = b->n,
                .J = d->J + b->dn,
                .Jdot = d->Jdot + b->dn,
                .m = d->imp + b->v,
                .sigma = d->sigma + b->v,
                .above = fixed ? still : d->V + b->pred.v};
    for (int k = 0; k < 3; ++k) {
        a->r[k] = x[k] - x_pred[k];
        a->rate[k] = V[3 + k] - a->above[3 + k];
        a->between[k] = V[k] - a->above[k];
        a->between[3 + k] = a->rate[k];
    }
    mbsri_add_cross3(a->r, a->above, a->between + 3);
    for (int j = 0; j < b->n; ++j) {
        const double *before = j > 0 ? a->omega[j - 1] : a->above;
        for (int k = 0; k < 3; ++k) a->omega[j][k] = before[k] - a->J[6 * j + k] * u[j];
    }
    for (int j = b->n - 2; j >= 0; --j) {
        for (int k = 0; k < 3; ++k) {
            a->w[j][k] = a->w[j + 1][k] - a->J[6 * (j + 1) + k] * u[j + 1];
            a->z[j][k] = a->z[j + 1][k] - a->J[6 * (j + 1) + 3 + k] * u[j + 1];
        }
    }
}

/* What changes of r and r' leave to the predecessor. */
static void leave(const axes *a, const double dr[3], const double drate[3], double *below)
{
    mbsri_add_cross3(dr, a->m + 3, below);
    mbsri_add_cross3(dr, a->sigma + 3, below + 6);
    mbsri_add_cross3(drate, a->m + 3, below + 6);
}

/* ---- the predecessor's motion ---- */

/* e_k x b: minus column k of [b]x */
static void unit_cross(const double B[9], int k, double out[3])
{
    for (int l = 0; l < 3; ++l) out[l] = -B[3 * k + l];
}

static void pose_columns(const axes *a, const double r[9], double *x, double *below)
{
    double w[9], z[9];
    mbsri_cross_matrix3(a->between, w);
    mbsri_cross_matrix3(a->between + 3, z);
    for (int k = 0; k < 3; ++k, x += 12, below += 12) {
        x[k] = 1.0;
        unit_cross(r, k, x + 3);
        unit_cross(w, k, x + 6);
        unit_cross(z, k, x + 9);
        mbsri_add_cross3(a->above, x + 3, x + 9);
        leave(a, x + 3, x + 9, below);
    }
    for (int k = 0; k < 3; ++k, x += 12) x[3 + k] = 1.0;
}

static void rate_columns(const axes *a, const double r[9], double *x, double *below)
{
    for (int k = 0; k < 3; ++k, x += 12, below += 12) {
        x[6 + k] = 1.0;
        unit_cross(r, k, x + 9);
        mbsri_add_cross3(x + 9, a->m + 3, below + 6);
    }
    for (int k = 0; k < 3; ++k, x += 12) x[9 + k] = 1.0;
}

/* The joint's rows along both. */
static void turn_rows(const axes *a, double *own)
{
    const int rows = 2 * a->n;
    for (int j = 0; j < a->n; ++j) {
        double momentum[3], rate[3], more[3];
        moment(a->J + 6 * j, a->m, momentum);
        moment(a->J + 6 * j, a->sigma, rate);
        moment(a->Jdot + 6 * j, a->m, more);
        mbsri_add3(1.0, more, rate);
        mbsri_add_cross3(momentum, a->above, rate);
        for (int k = 0; k < 3; ++k) {
            own[k * rows + j] = momentum[k];
            own[k * rows + a->n + j] = rate[k];
            own[(6 + k) * rows + a->n + j] = momentum[k];
        }
    }
}

/* ---- the joint's own ---- */

/* -E_jk */
static void change_axis(const axes *a, int j, int k, double E[6])
{
    const double *J = a->J + 6 * j, *by = a->J + 6 * k;
    for (int l = 0; l < 6; ++l) E[l] = 0.0;
    if (j > k) {
        mbsri_add_cross3(J, by, E);
        mbsri_add_cross3(J + 3, by, E + 3);
    } else {
        mbsri_add_cross3(by + 3, J, E + 3);
    }
}

/* Along q_k, -dS_j'; E: -E_jk. */
static void change_rate(const axes *a, int j, int k, const double E[6], double out[6])
{
    const double *J = a->J + 6 * j, *by = a->J + 6 * k;
    double domega[3] = {0.0}, dz[3] = {0.0}, between[3];
    for (int l = 0; l < 3; ++l) between[l] = a->omega[j][l] - a->omega[k][l];
    if (j > k) mbsri_add_cross3(between, by, domega);
    if (j < k) mbsri_add_cross3(between, by + 3, dz);
    mbsri_add_cross3(a->z[j > k ? j : k], by, dz);
    for (int l = 0; l < 6; ++l) out[l] = 0.0;
    add_turn(domega, J, out);
    add_turn(a->omega[j], E, out);
    mbsri_add_cross3(E, a->z[j], out + 3);
    mbsri_add_cross3(J, dz, out + 3);
}

/* The joint's rows along q_k and u_k. */
static void own_rows(const axes *a, int k, double *of_q, double *of_u)
{
    for (int j = 0; j < a->n; ++j) {
        double E[6], rate[6];
        change_axis(a, j, k, E);
        change_rate(a, j, k, E, rate);
        of_q[j] = of_u[a->n + j] = mbsri_dot_six(E, a->m);
        of_q[a->n + j] = mbsri_dot_six(E, a->sigma) + mbsri_dot_six(rate, a->m);
    }
}

/* below: of q and u; NULL: the root is at rest. */
static void own_columns(const axes *a, int k, double *x, double *below, double *own)
{
    const double *J = a->J + 6 * k;
    const size_t n = (size_t)a->n;
    double *of_q = x + 12 * (size_t)k, *of_u = of_q + 12 * n, *own_q = own + 2 * n * (size_t)k;
    for (int l = 0; l < 6; ++l) of_q[l] = of_u[6 + l] = -J[l];
    mbsri_add_cross3(a->w[k], J, of_q + 6);
    mbsri_add_cross3(a->z[k], J, of_q + 9);
    mbsri_add_cross3(J + 3, a->omega[k], of_q + 9);
    if (below) {
        leave(a, of_q + 3, of_q + 9, below + 12 * (size_t)k);
        mbsri_add_cross3(of_u + 9, a->m + 3, below + 12 * (n + (size_t)k) + 6);
    }
    own_rows(a, k, own_q, own_q + 2 * n * n);
}

void mbsri_axes_slopes(const mbsri_body *b, const mbsr_data *d, double *x, double *below,
                       double *own, double *qdot)
{
    const size_t n = (size_t)b->n, outside = b->pred.space == MBSR_SPACE_FIXED ? 0 : 12,
                 columns = outside + 2 * n;
    axes a;
    see(b, d, &a);
    mbsri_zero(12 * columns, x);
    mbsri_zero(outside * columns, below);
    mbsri_zero(2 * n * columns, own);
    mbsri_zero(n * columns, qdot);
    if (outside > 0) {
        double r[9];
        mbsri_cross_matrix3(a.r, r);
        pose_columns(&a, r, x, below);
        rate_columns(&a, r, x + 72, below + 72);
        turn_rows(&a, own);
    }
    for (size_t k = 0; k < n; ++k) {
        own_columns(&a, (int)k, x + 12 * outside, outside > 0 ? below + 144 : NULL,
                    own + 2 * n * outside);
        own[2 * n * (outside + n + k) + k] += b->mass.armature[k];
        qdot[n * (outside + n + k) + k] = 1.0;
    }
}
