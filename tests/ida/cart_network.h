/* Carts on a line, some without mass, with springs and dampers between them: as a model in relative
 * coordinates, and as the linear equations written by hand in absolute ones.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * States x: the positions of all carts, then the velocities of those with mass. Cart 0 may be moved
 * instead, by s = amplitude sin(omega t), which solves s'' = -omega^2 s. The velocities of the
 * massless carts follow from the balance of forces there,
 *
 *   sum over elements at k of c (x_k - x_l) + d (x_k' - x_l') = 0
 */
#ifndef TEST_CART_NETWORK_H
#define TEST_CART_NETWORK_H

#include "reference_runs.h"

#include "../../examples/expm.h"

enum { CARTS_MOST = 6, ELEMENTS_MOST = 8, CART_GROUND = -1 };

typedef enum cart_drive {
    CART_FREE,         /* cart 0 is a cart as the others */
    CART_DRIVEN_JOINT, /* cart 0 is a body whose joint is driven */
    CART_MOVING_ROOT   /* cart 0 is the root of the tree; no element may go to the ground */
} cart_drive;

typedef struct cart_element {
    int a, b; /* carts, or CART_GROUND */
    double c, d;
} cart_element;

typedef struct cart_network {
    const char *name;
    int carts;
    int parent[CARTS_MOST]; /* an earlier cart, or CART_GROUND */
    double mass[CARTS_MOST];
    int elements;
    cart_element element[ELEMENTS_MOST];
    cart_drive drive;
    double amplitude, omega; /* of cart 0 when it is moved */
} cart_network;

/* ---- as a model ---- */

static inline int cart_motion(void *user, double t, double *s, double *rate, double *acceleration)
{
    const cart_network *w = user;
    *s = w->amplitude * sin(w->omega * t);
    *rate = w->amplitude * w->omega * cos(w->omega * t);
    *acceleration = -w->omega * w->omega * *s;
    return MBSR_OK;
}

static inline mbsr_model *cart_empty_model(cart_network *w)
{
    mbsr_model *m = NULL;
    mbsr_model_def def = mbsr_default_model_def();
    if (w->drive == CART_MOVING_ROOT) {
        def.root = mbsr_root_moving(MBSR_SPACE_POINT, 2, 2, cart_motion, w);
    }
    assert_ok(mbsr_model_create(&def, &m, NULL), NULL);
    return m;
}

/* The network must outlive the model. */
static inline mbsr_model *cart_model(cart_network *w)
{
    mbsr_model *m = cart_empty_model(w);
    int id[CARTS_MOST];
    for (int k = 0; k < w->carts; ++k) {
        const int parent = w->parent[k] == CART_GROUND ? MBSR_GROUND : id[w->parent[k]];
        if (k > 0 || w->drive == CART_FREE) {
            id[k] = run_cart(m, NULL, parent, w->mass[k]);
        } else if (w->drive == CART_DRIVEN_JOINT) {
            id[k] =
                run_body(m, NULL, parent, mbsr_joint_point(run_origin, 0, MBSR_X, cart_motion, w),
                         mbsr_inertia_zero());
        } else {
            id[k] = MBSR_GROUND;
        }
    }
    for (int k = 0; k < w->elements; ++k) {
        const cart_element *e = w->element + k;
        run_force(m, mbsr_force_axis_spring(e->a == CART_GROUND ? MBSR_GROUND : id[e->a],
                                            e->b == CART_GROUND ? MBSR_GROUND : id[e->b], 0, e->c,
                                            e->d, 0.0));
    }
    return run_finish(m);
}

/* ---- as linear equations ---- */

static inline int cart_has_velocity_state(const cart_network *w, int k)
{
    return w->mass[k] > 0.0 || (k == 0 && w->drive != CART_FREE);
}

/* row k of C and D: force on cart k = -sum_l C_kl x_l - sum_l D_kl x_l'. */
static inline void cart_matrices(const cart_network *w, double C[CARTS_MOST][CARTS_MOST],
                                 double D[CARTS_MOST][CARTS_MOST])
{
    memset(C, 0, sizeof(double) * CARTS_MOST * CARTS_MOST);
    memset(D, 0, sizeof(double) * CARTS_MOST * CARTS_MOST);
    for (int k = 0; k < w->elements; ++k) {
        const cart_element *e = w->element + k;
        const int end[2] = {e->a, e->b};
        for (int r = 0; r < 2; ++r) {
            if (end[r] == CART_GROUND) continue;
            for (int c = 0; c < 2; ++c) {
                if (end[c] == CART_GROUND) continue;
                C[end[r]][end[c]] += r == c ? e->c : -e->c;
                D[end[r]][end[c]] += r == c ? e->d : -e->d;
            }
        }
    }
}

/* Gaussian elimination without pivots, which matrices of dampers do not need. Row k of A: n
 * entries, then `columns` right-hand sides, which become the solutions. */
static inline void cart_eliminate(int n, int columns, double A[CARTS_MOST][CARTS_MOST + EXPM_MOST])
{
    for (int p = 0; p < n; ++p) {
        assert_less(1e-12, fabs(A[p][p]));
        for (int k = p + 1; k < n + columns; ++k) A[p][k] /= A[p][p];
        for (int r = 0; r < n; ++r) {
            for (int k = p + 1; r != p && k < n + columns; ++k) A[r][k] -= A[r][p] * A[p][k];
        }
    }
}

/* rate[k]: the velocity of cart k as a row over the states. */
static inline void cart_velocity_rows(const cart_network *w, double rate[CARTS_MOST][EXPM_MOST])
{
    double C[CARTS_MOST][CARTS_MOST], D[CARTS_MOST][CARTS_MOST];
    double A[CARTS_MOST][CARTS_MOST + EXPM_MOST] = {{0.0}};
    int node[CARTS_MOST], nodes = 0, states = w->carts;
    cart_matrices(w, C, D);
    memset(rate, 0, sizeof(double) * CARTS_MOST * EXPM_MOST);
    for (int k = 0; k < w->carts; ++k) {
        if (cart_has_velocity_state(w, k))
            rate[k][states++] = 1.0;
        else
            node[nodes++] = k;
    }
    /* D_nn v_n = -C_n x - D_nm v_m */
    for (int r = 0; r < nodes; ++r) {
        for (int c = 0; c < nodes; ++c) A[r][c] = D[node[r]][node[c]];
        for (int k = 0; k < w->carts; ++k) {
            A[r][nodes + k] -= C[node[r]][k];
            for (int s = w->carts; s < states; ++s) {
                A[r][nodes + s] -= D[node[r]][k] * rate[k][s];
            }
        }
    }
    cart_eliminate(nodes, states, A);
    for (int r = 0; r < nodes; ++r) {
        for (int s = 0; s < states; ++s) rate[node[r]][s] = A[r][nodes + s];
    }
}

static inline expm_system cart_system(const cart_network *w)
{
    expm_system system = {0};
    double C[CARTS_MOST][CARTS_MOST], D[CARTS_MOST][CARTS_MOST], rate[CARTS_MOST][EXPM_MOST];
    cart_matrices(w, C, D);
    cart_velocity_rows(w, rate);
    system.n = w->carts;
    for (int k = 0; k < w->carts; ++k) system.n += cart_has_velocity_state(w, k);
    assert_true(system.n < EXPM_MOST);
    for (int k = 0, row = w->carts; k < w->carts; ++k) {
        for (int s = 0; s < system.n; ++s) system.A[k][s] = rate[k][s];
        if (!cart_has_velocity_state(w, k)) continue;
        if (k == 0 && w->drive != CART_FREE) {
            system.A[row++][0] = -w->omega * w->omega;
            continue;
        }
        for (int l = 0; l < w->carts; ++l) {
            system.A[row][l] -= C[k][l] / w->mass[k];
            for (int s = 0; s < system.n; ++s) {
                system.A[row][s] -= D[k][l] * rate[l][s] / w->mass[k];
            }
        }
        ++row;
    }
    return system;
}

/* ---- states ---- */

static inline int cart_first(const cart_network *w) /* the first cart with a coordinate */
{
    return w->drive == CART_FREE ? 0 : 1;
}

/* States at t = 0 from q and u; the velocities of massless carts do not count. */
static inline void cart_state(const cart_network *w, const double *q, const double *u, double *x)
{
    double v[CARTS_MOST];
    const int first = cart_first(w);
    if (first) x[0] = 0.0, v[0] = w->amplitude * w->omega;
    for (int k = first; k < w->carts; ++k) {
        const int parent = w->parent[k];
        x[k] = q[k - first] + (parent == CART_GROUND ? 0.0 : x[parent]);
        v[k] = u[k - first] + (parent == CART_GROUND ? 0.0 : v[parent]);
    }
    for (int k = 0, s = w->carts; k < w->carts; ++k) {
        if (cart_has_velocity_state(w, k)) x[s++] = v[k];
    }
}

/* q and u from the states. */
static inline void cart_coordinates(const cart_network *w, const expm_system *system,
                                    const double *x, double *q, double *u)
{
    double v[CARTS_MOST] = {0.0};
    const int first = cart_first(w);
    for (int k = 0; k < w->carts; ++k) {
        for (int s = 0; s < system->n; ++s) v[k] += system->A[k][s] * x[s];
    }
    for (int k = first; k < w->carts; ++k) {
        const int parent = w->parent[k];
        q[k - first] = x[k] - (parent == CART_GROUND ? 0.0 : x[parent]);
        u[k - first] = v[k] - (parent == CART_GROUND ? 0.0 : v[parent]);
    }
}

#endif
