/* The descriptor form: E x' = A x + B w.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Linearised about y, the momentum form is F_y dy + F_y' dy' = 0: A = -F_y, E = F_y', column by
 * column from products with the Newton matrices of c = 0 and c = 1. In their place of q stand joint
 * rates, dq = G x:
 *
 *   x' = -G^+ (F_y dy)_q - G^+ G' x        with G' along a steady motion
 *
 * Multipliers come in F as rates, lambda = Lambda': where F does not know Lambda itself, their
 * column is that of lambda, in A, and they are algebraic. */
#include "linear/record.h"

#include "base/error.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <string.h>

typedef mbsri_coordinates coordinates;

/* G of all bodies at q, into G. */
static int find_G(const coordinates *c, const double *q, double *u, double *qdot, double *G)
{
    int most = 0, status = mbsr_stage_positions(c->model, c->data, c->t, q);
    for (int i = 0; i < c->bodies; ++i) {
        int n;
        mbsr_body_coordinates(c->model, i, NULL, NULL, NULL, &n);
        if (n > most) most = n;
    }
    for (int k = 0; k < most && !status; ++k) { /* rate k of every joint at once */
        for (int side = 0; side < 2 && !status; ++side) {
            memset(u, 0, (size_t)c->nu * sizeof *u);
            for (int i = 0; i < c->bodies; ++i) {
                int n, ui;
                mbsr_body_coordinates(c->model, i, NULL, NULL, &ui, &n);
                if (k < n) u[ui + k] = side ? -1.0 : 1.0;
            }
            status = mbsr_stage_velocities(c->model, c->data, u);
            if (!status) status = mbsr_coordinate_rates(c->model, c->data, qdot);
            for (int i = 0; i < c->bodies && !status; ++i) {
                int n, nq, qi;
                mbsr_body_coordinates(c->model, i, &qi, &nq, NULL, &n);
                double *column = G + c->at[i] + k * nq;
                for (int r = 0; r < nq && k < n; ++r)
                    column[r] = side ? 0.5 * (column[r] - qdot[qi + r]) : qdot[qi + r];
            }
        }
    }
    return status;
}

/* left = (G^T G)^-1 G^T by elimination: n x nq. */
static void invert_left(int n, int nq, const double *G, double *left, double *work)
{
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            work[j * n + i] = 0.0;
            for (int k = 0; k < nq; ++k) work[j * n + i] += G[i * nq + k] * G[j * nq + k];
        }
        for (int k = 0; k < nq; ++k) left[k * n + i] = G[i * nq + k];
    }
    for (int i = 0; i < n; ++i) {
        for (int r = 0; r < n; ++r) {
            if (r == i) continue;
            const double factor = work[i * n + r] / work[i * n + i];
            for (int j = 0; j < n; ++j) work[j * n + r] -= factor * work[j * n + i];
            for (int k = 0; k < nq; ++k) left[k * n + r] -= factor * left[k * n + i];
        }
    }
    for (int i = 0; i < n; ++i) {
        for (int k = 0; k < nq; ++k) left[k * n + i] /= work[i * n + i];
    }
}

void mbsri_coordinates_of(mbsri_coordinates *c, const mbsr_model *model, mbsr_data *data, double t)
{
    *c = (mbsri_coordinates){.model = model,
                             .data = data,
                             .t = t,
                             .nq = mbsr_model_nq(model),
                             .nu = mbsr_model_nu(model),
                             .bodies = mbsr_model_bodies(model),
                             .size = mbsr_dae_size(model, MBSR_DAE_MOMENTUM)};
}

int mbsri_coordinates_find(mbsri_coordinates *c, mbsri_arena *arena, const double *q,
                           const double *qdot)
{
    size_t count = 0, squares = 0, widest = 1;
    c->at = mbsri_arena_take(arena, (size_t)(c->bodies + 1) * sizeof *c->at);
    c->joint = mbsri_arena_take(arena, (size_t)(c->bodies + 1) * sizeof *c->joint);
    for (int i = 0; i < c->bodies && !arena->failed; ++i) {
        int *j = c->joint[i];
        mbsr_body_coordinates(c->model, i, j, j + 1, j + 2, j + 3);
        const int nq = j[1], n = j[3];
        c->at[i] = (int)count;
        count += (size_t)nq * (size_t)n;
        squares += (size_t)n * (size_t)n;
        if ((size_t)n > widest) widest = (size_t)n;
    }
    const size_t numbers = 5 * count + widest * widest + (size_t)(c->nu + 2 * c->nq) + squares + 1;
    double *memory = mbsri_arena_take(arena, numbers * sizeof *memory);
    if (!memory) return MBSR_ERR_NO_MEMORY;
    c->G = memory;
    c->left = c->G + count;
    c->turning = c->left + count;
    double *before = c->turning + count, *behind = before + count, *work = behind + count,
           *u = work + widest * widest, *place = u + c->nu, *rate = place + c->nq;
    const double h = 0x1p-10;
    int status = MBSR_OK;
    for (int side = 0; side < 2 && !status; ++side) {
        for (int k = 0; k < c->nq; ++k) place[k] = q[k] + (side ? -h : h) * qdot[k];
        status = find_G(c, place, u, rate, side ? before : behind);
    }
    if (!status) status = find_G(c, q, u, rate, c->G);
    for (int i = 0; i < c->bodies && !status; ++i) {
        int n, nq;
        mbsr_body_coordinates(c->model, i, NULL, &nq, NULL, &n);
        invert_left(n, nq, c->G + c->at[i], c->left + c->at[i], work);
        double *turning = c->turning + c->at[i]; /* n <= nq */
        for (int j = 0; j < n; ++j) {
            for (int r = 0; r < n; ++r) {
                double sum = 0.0;
                for (int k = 0; k < nq; ++k) {
                    const int at = c->at[i] + j * nq + k;
                    sum += c->left[c->at[i] + k * n + r] * (behind[at] - before[at]) / (2.0 * h);
                }
                turning[j * n + r] = sum;
            }
        }
    }
    return status;
}

void mbsri_coordinates_lift(const mbsri_coordinates *c, const double *x, double *dq)
{
    for (int i = 0; i < c->bodies; ++i) {
        const int qi = c->joint[i][0], nq = c->joint[i][1], ui = c->joint[i][2], n = c->joint[i][3];
        for (int k = 0; k < nq; ++k) {
            dq[qi + k] = 0.0;
            for (int j = 0; j < n; ++j) dq[qi + k] += c->G[c->at[i] + j * nq + k] * x[ui + j];
        }
    }
}

void mbsri_coordinates_take(const mbsri_coordinates *c, const double *dq, double *x)
{
    for (int i = 0; i < c->bodies; ++i) {
        const int qi = c->joint[i][0], nq = c->joint[i][1], ui = c->joint[i][2], n = c->joint[i][3];
        for (int j = 0; j < n; ++j) {
            x[ui + j] = 0.0;
            for (int k = 0; k < nq; ++k) x[ui + j] += c->left[c->at[i] + k * n + j] * dq[qi + k];
        }
    }
}

void mbsri_pencil_rows(const coordinates *c, const double *r, double factor, double *to)
{
    mbsri_coordinates_take(c, r, to);
    for (int k = 0; k < c->nu; ++k) to[k] *= factor;
    for (int k = c->nq; k < c->size; ++k) to[k - c->nq + c->nu] = factor * r[k];
}

/* The body of rate k, and its own number of it. */
static int joint_of_rate(const coordinates *c, int k, int *own)
{
    for (int i = 0; i < c->bodies; ++i) {
        int n, ui;
        mbsr_body_coordinates(c->model, i, NULL, NULL, &ui, &n);
        *own = k - ui;
        if (k >= ui && k < ui + n) return i;
    }
    return 0;
}

static bool is_zero(int n, const double *x)
{
    for (int k = 0; k < n; ++k) {
        if (x[k] != 0.0) return false;
    }
    return true;
}

/* Columns of A. delta, r: size of y. */
static int columns_of_A(const coordinates *c, mbsr_newton *newton, double *delta, double *r,
                        double *A)
{
    const int size = c->rows, known = c->size - c->nq + c->nu;
    for (int j = 0; j < known; ++j) {
        int own = 0, qi = 0, nq = 0, n = 0, ui = 0;
        const int i = j < c->nu ? joint_of_rate(c, j, &own) : 0;
        memset(delta, 0, (size_t)c->size * sizeof *delta);
        if (j < c->nu) {
            mbsr_body_coordinates(c->model, i, &qi, &nq, &ui, &n);
            for (int k = 0; k < nq; ++k) delta[qi + k] = c->G[c->at[i] + own * nq + k];
        } else {
            delta[j - c->nu + c->nq] = 1.0;
        }
        const int status = mbsr_newton_multiply(newton, delta, r);
        if (status) return status;
        double *column = A + (size_t)j * (size_t)size;
        mbsri_pencil_rows(c, r, -1.0, column);
        for (int k = 0; k < n && j < c->nu; ++k)
            column[ui + k] -= c->turning[c->at[i] + own * n + k];
    }
    return MBSR_OK;
}

/* Columns of E; those of multipliers that F does not know go to A. */
static int columns_of_E(const coordinates *c, mbsr_newton *newton, double *delta, double *r,
                        double *A, double *E)
{
    const int size = c->rows, known = c->size - c->nq + c->nu;
    for (int j = 0; j < 2 * c->nu; ++j) E[(size_t)j * (size_t)(size + 1)] = 1.0;
    memset(delta, 0, (size_t)c->size * sizeof *delta);
    for (int j = 3 * c->nu; j < known; ++j) {
        double *of_A = A + (size_t)j * (size_t)size, *of_E = E + (size_t)j * (size_t)size;
        delta[j - c->nu + c->nq] = 1.0;
        const int status = mbsr_newton_multiply(newton, delta, r);
        delta[j - c->nu + c->nq] = 0.0;
        if (status) return status;
        mbsri_pencil_rows(c, r, 1.0, of_E);
        const bool unknown = is_zero(size, of_A);
        for (int k = 0; k < size; ++k) {
            if (unknown) {
                of_A[k] = -of_E[k];
                of_E[k] = 0.0;
            } else {
                of_E[k] += of_A[k]; /* (F_y + F_y') - F_y */
            }
        }
    }
    return MBSR_OK;
}

/* Whether row k of A has numbers for rates and for nothing else. */
static bool reads_rates_alone(const coordinates *c, int k, const double *A)
{
    bool alone = true;
    for (int j = 0; j < c->rows; ++j) {
        const bool of_rate = j >= 2 * c->nu && j < 3 * c->nu;
        alone = alone && (of_rate || A[(size_t)j * (size_t)c->rows + (size_t)k] == 0.0);
    }
    return alone;
}

/* Of a redundant stiff row, whose position row F leaves out, the velocity row s' / k = C u alone
 * ties the force s to the motion, which would make s a state of its own. At rest it is C dq = s / k
 * instead. */
static int tie_springs(const coordinates *c, mbsri_arena *arena, double *A, double *E)
{
    const int rows = mbsr_model_rows(c->model), nu = c->nu;
    const size_t size = (size_t)c->rows;
    int *redundant = mbsri_arena_take(arena, ((size_t)rows + 1) * sizeof *redundant);
    if (!redundant) return MBSR_ERR_NO_MEMORY;
    const int status = mbsr_closures_redundant(c->model, c->data, redundant);
    for (int k = 3 * nu; k < 3 * nu + rows && !status; ++k) {
        const size_t at = (size_t)k, own = at * (size + 1);
        if (!redundant[k - 3 * nu] || E[own] == 0.0 || !reads_rates_alone(c, k, A)) continue;
        for (size_t j = 0; j < (size_t)nu; ++j) {
            double *rate = A + (2 * (size_t)nu + j) * size + at;
            A[j * size + at] = *rate;
            *rate = 0.0;
        }
        A[own] = -E[own];
        E[own] = 0.0;
    }
    return status;
}

static int columns_of_B(const coordinates *c, mbsr_newton *newton, const mbsr_linear_opt *opt,
                        double *tau, double *r, double *B)
{
    const int size = c->rows;
    for (int j = 0; j < opt->inputs; ++j) {
        if (opt->input[j].kind != MBSR_SIGNAL_JOINT) continue;
        memset(tau, 0, (size_t)c->nu * sizeof *tau);
        tau[opt->input[j].id] = 1.0;
        const int status = mbsr_newton_multiply_torque(newton, tau, r);
        if (status) return status;
        mbsri_pencil_rows(c, r, -1.0, B + (size_t)j * (size_t)size);
    }
    return MBSR_OK;
}

static int take_descriptor(mbsr_linear *l, int size)
{
    const int columns[] = {size, size, l->inputs};
    for (int part = MBSR_LINEAR_E; part <= MBSR_LINEAR_B; ++part) {
        l->rows[part] = size;
        l->columns[part] = columns[part];
        l->part[part] = mbsri_arena_take(&l->arena, ((size_t)size * (size_t)columns[part] + 1) *
                                                        sizeof(double));
    }
    const size_t outputs = (size_t)l->outputs;
    l->output = mbsri_arena_take(&l->arena, (outputs * (size_t)size + 1) * sizeof *l->output);
    l->direct = mbsri_arena_take(&l->arena, (outputs * (size_t)l->inputs + 1) * sizeof *l->direct);
    return l->arena.failed ? MBSR_ERR_NO_MEMORY : MBSR_OK;
}

static int fail_as(mbsr_error *error, int status, const mbsr_error *why)
{
    return mbsri_fail(error, status, why->body, why->force, "mbsr_linear_create: %s", why->text);
}

int mbsri_pencil_assemble(mbsr_linear *l, coordinates *c, const mbsr_model *model, mbsr_data *data,
                          double t, const double *y, const double *yp, const mbsr_linear_opt *opt,
                          mbsr_error *error)
{
    mbsri_coordinates_of(c, model, data, t);
    c->rows = c->size - c->nq + c->nu;
    for (int j = 0; j < opt->inputs; ++j) c->rows += mbsri_is_motion(opt->input + j) ? 2 : 0;
    l->info.size = c->rows;
    int status = take_descriptor(l, l->info.size);
    double *delta = mbsri_arena_take(&l->arena, 2 * ((size_t)c->size + 1) * sizeof *delta);
    if (status || !delta)
        return mbsri_fail(error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_linear_create: no memory for %d equations", l->info.size);
    status = mbsri_coordinates_find(c, &l->arena, y, yp);
    if (status) return fail_as(error, status, mbsr_data_error(data));
    mbsr_newton_opt products = mbsr_default_newton_opt();
    mbsr_newton *newton;
    products.products = 1;
    products.by_blocks = 1;
    status = mbsr_newton_create(model, MBSR_DAE_MOMENTUM, &products, &newton, error);
    if (status) return status;
    double *A = l->part[MBSR_LINEAR_A], *r = delta + c->size + 1;
    status = mbsr_newton_linearise(newton, data, t, y, yp, 0.0);
    if (!status) status = columns_of_A(c, newton, delta, r, A);
    if (!status) status = columns_of_B(c, newton, opt, delta, r, l->part[MBSR_LINEAR_B]);
    if (!status) status = mbsr_newton_linearise(newton, data, t, y, yp, 1.0);
    if (!status) status = columns_of_E(c, newton, delta, r, A, l->part[MBSR_LINEAR_E]);
    if (status) status = fail_as(error, status, mbsr_newton_error(newton));
    mbsr_newton_destroy(newton);
    if (!status && mbsr_model_rows(model) > 0)
        status = tie_springs(c, &l->arena, A, l->part[MBSR_LINEAR_E]);
    return status;
}
