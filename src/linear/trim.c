/* Trim: positions and parameters at which forces balance.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With the joint forces tau that a model at rest would need (inverse dynamics at u = u' = 0) and
 * the rigid rows C, gaps g, at rest
 *
 *   tau(q, theta) - C^T lambda = 0,   g(q, theta) = 0
 *
 * for the positions along rates that are not held, lambda and the parameters theta that are free.
 * Newton's method, each step the shortest one that solves the linear equations best (singular
 * values): so rows that depend on others and parameters of which there are too many do no harm.
 * Equations are works, tau_k along a turn by 1 rad or a way as long as the model; all columns are
 * brought to the same length, so that units do not matter. */
#include "files/arena.h"
#include "linear/lapack.h"
#include "linear/spans.h"

#include "base/cookie.h"
#include "base/error.h"

#include <mbsrank/linear.h>
#include <mbsrank/closure.h>
#include <mbsrank/derivatives.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <string.h>

typedef struct trim {
    const mbsr_parameters *list;
    double t, length;
    int nq, nu, rows, gaps, params, unknowns, equations;
    const int *which;
    bool *held, *rigid; /* nu; rows */
    int *row_of;        /* gaps: their rows */
    struct {
        int count, *chosen, *place; /* parameters that have them, and which of all these are */
        double *change;             /* params: zeros */
    } products;
    double *span; /* nu */
    double *q, *lambda, *theta, *new_q, *new_lambda, *new_theta;
    double *r, *new_r; /* equations: scaled */
    struct {
        double *A, *U, *V, *s; /* equations x unknowns; its singular values */
        double *x, *column;    /* the step; lengths of columns */
        double *work;
        int lwork;
    } linear;
    double *row_scale; /* gaps: 1 over lengths of rows */
    double *by_nu, *rate;
    double force; /* largest work of a force met: J */
    mbsr_trim_info info;
} trim;

static const char name[] = "mbsr_trim";
static const double longest = 0.3;

mbsr_trim_opt mbsr_default_trim_opt(void)
{
    return (mbsr_trim_opt){.cookie = MBSRI_COOKIE, .max_iterations = 100, .tolerance = 1e-10};
}

static int fail_trim(int status, const char *text, mbsr_error *error)
{
    return mbsri_fail(error, status, MBSR_NONE, MBSR_NONE, "%s: %s", name, text);
}

/* Data with parameters theta. */
static int data_of_trim(const trim *w, const double *theta, mbsr_data **d, mbsr_error *error)
{
    return mbsr_parameters_data(w->list, w->params, w->which, theta, d, error);
}

/* Forces and gaps at q, lambda, scaled, into r. */
static int trim_balance(trim *w, mbsr_data *d, const double *q, const double *lambda, double *r,
                        mbsr_error *error)
{
    const mbsr_model *m = mbsr_data_model(d);
    memset(w->rate, 0, (size_t)w->nu * sizeof *w->rate);
    int status = mbsr_bias_forces(m, d, w->t, q, w->rate, r);
    if (!status) status = mbsr_stage_positions(m, d, w->t, q);
    if (!status && w->rows > 0) status = mbsr_closures_transpose(m, d, lambda, w->by_nu);
    for (int k = 0; k < w->nu && !status; ++k) {
        w->force = fmax(w->force, fabs(r[k]) * w->span[k]);
        if (w->rows > 0) r[k] -= w->by_nu[k];
        r[k] *= w->span[k];
    }
    double *g = r + w->nu;
    if (!status && w->gaps > 0) status = mbsr_closures_gap(m, d, g);
    for (int k = 0; k < w->gaps && !status; ++k)
        g[k] = w->rigid[w->row_of[k]] ? g[k] * w->row_scale[k] : 0.0;
    if (status) *error = *mbsr_data_error(d);
    return status;
}

static double length_of(int n, const double *x)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) sum += x[k] * x[k];
    return sqrt(sum);
}

/* q moved by x along rate k, in w->new_q. */
static int move_along_rate(trim *w, mbsr_data *d, int k, double x)
{
    const mbsr_model *m = mbsr_data_model(d);
    memset(w->rate, 0, (size_t)w->nu * sizeof *w->rate);
    w->rate[k] = x;
    int status = mbsr_stage_positions(m, d, w->t, w->q);
    if (!status) status = mbsr_stage_velocities(m, d, w->rate);
    if (!status) status = mbsr_coordinate_rates(m, d, w->new_q);
    for (int l = 0; l < w->nq && !status; ++l) w->new_q[l] += w->q[l];
    return status;
}

/* Columns of positions: of tau by formulas, of gaps by the rows, of C^T lambda by differences. */
static int position_columns(trim *w, mbsr_data *d, mbsr_derivatives *by, mbsr_error *error)
{
    const mbsr_model *m = mbsr_data_model(d);
    const double step = 1e-5;
    memset(w->rate, 0, (size_t)w->nu * sizeof *w->rate);
    int status = mbsr_derivatives_inverse(by, w->t, w->q, w->rate, w->rate, NULL);
    for (int k = 0; k < w->nu && !status; ++k) {
        double *a = w->linear.A + (size_t)k * (size_t)w->equations;
        memset(w->rate, 0, (size_t)w->nu * sizeof *w->rate);
        w->rate[k] = w->span[k];
        status = mbsr_derivatives_tangent(by, w->rate, NULL, NULL, a, NULL);
        for (int l = 0; l < w->nu; ++l) a[l] *= w->span[l];
    }
    if (status) {
        *error = *mbsr_derivatives_error(by);
        return status;
    }
    for (int k = 0; k < w->nu && w->rows > 0 && !status; ++k) {
        double *a = w->linear.A + (size_t)k * (size_t)w->equations;
        for (int side = -1; side <= 1 && !status; side += 2) {
            status = move_along_rate(w, d, k, side * step * w->span[k]);
            if (!status) status = mbsr_stage_positions(m, d, w->t, w->new_q);
            if (!status) status = mbsr_closures_transpose(m, d, w->lambda, w->by_nu);
            for (int l = 0; l < w->nu && !status; ++l)
                a[l] -= side * w->by_nu[l] * w->span[l] / (2.0 * step);
        }
    }
    if (!status) status = mbsr_stage_positions(m, d, w->t, w->q);
    if (status) *error = *mbsr_data_error(d);
    return status;
}

/* Columns of loop forces, and the rows of gaps in those of positions. */
static int force_columns(trim *w, mbsr_data *d, mbsr_error *error)
{
    const mbsr_model *m = mbsr_data_model(d);
    int status = MBSR_OK;
    for (int k = 0, gap = 0; k < w->rows && !status; ++k) {
        double *a = w->linear.A + (size_t)(w->nu + k) * (size_t)w->equations;
        double *unit = w->new_lambda;
        memset(unit, 0, (size_t)w->rows * sizeof *unit);
        unit[k] = w->rigid[k] ? 1.0 : 0.0;
        status = mbsr_closures_transpose(m, d, unit, a);
        for (int l = 0; l < w->nu; ++l) a[l] *= -w->span[l];
        if (gap == w->gaps || w->row_of[gap] != k) continue;
        const double size = length_of(w->nu, a);
        w->row_scale[gap] = size > 0.0 ? 1.0 / size : 0.0;
        for (int l = 0; l < w->nu; ++l)
            w->linear.A[(size_t)l * (size_t)w->equations + (size_t)(w->nu + gap)] =
                -a[l] * w->row_scale[gap];
        ++gap;
    }
    if (status) *error = *mbsr_data_error(d);
    return status;
}

/* How far a parameter is moved for a difference. */
static double parameter_step(const trim *w, int k)
{
    mbsr_parameter p;
    mbsr_parameter_get(w->list, w->which[k], &p);
    if (w->theta[k] != 0.0) return 1e-4 * fabs(w->theta[k]);
    return strcmp(p.unit, "m") == 0 ? 1e-4 * w->length : strcmp(p.unit, "rad") == 0 ? 1e-4 : 1.0;
}

/* The balance with parameter k moved by `step`, into out. A status. */
static int balance_with(trim *w, int k, double step, double *out, mbsr_error *error)
{
    mbsr_data *d;
    memcpy(w->new_theta, w->theta, (size_t)w->params * sizeof *w->theta);
    w->new_theta[k] += step;
    int status = data_of_trim(w, w->new_theta, &d, error);
    if (status) return status;
    status = trim_balance(w, d, w->q, w->lambda, out, error);
    mbsr_data_destroy(d);
    return status;
}

/* Parameters that move neither rows nor gaps and have products. A status. */
static int choose_products(trim *w, const mbsr_model *m, mbsr_error *error)
{
    mbsr_derivatives *by;
    int status = mbsr_derivatives_create(m, &by, error);
    for (int k = 0; k < w->params && !status; ++k) {
        mbsr_parameter p;
        mbsr_parameter_get(w->list, w->which[k], &p);
        const bool apart = p.part <= MBSR_PARAMETER_ARMATURE || p.part == MBSR_PARAMETER_LAW ||
                           (p.part == MBSR_PARAMETER_JOINT && w->rows == 0);
        const int chosen =
            apart ? mbsr_derivatives_parameters(by, w->list, 1, w->which + k) : MBSR_ERR_SPACE;
        if (chosen == MBSR_ERR_SPACE) continue;
        status = chosen;
        w->products.chosen[w->products.count] = w->which[k];
        w->products.place[w->products.count++] = k;
    }
    if (status && by) *error = *mbsr_derivatives_error(by);
    mbsr_derivatives_destroy(by);
    return status;
}

static double *column_of_parameter(const trim *w, int k)
{
    return w->linear.A + (size_t)(w->nu + w->rows + k) * (size_t)w->equations;
}

/* Columns of parameters that have products; the others are zero. */
static int product_columns(trim *w, mbsr_derivatives *by, mbsr_error *error)
{
    int status = MBSR_OK;
    for (int k = 0; k < w->products.count && !status; ++k) {
        double *a = column_of_parameter(w, w->products.place[k]);
        w->products.change[k] = 1.0;
        status = mbsr_derivatives_parameter_tangent(by, w->products.change, a, NULL);
        w->products.change[k] = 0.0;
        for (int l = 0; l < w->nu; ++l) a[l] *= w->span[l];
    }
    if (status) *error = *mbsr_derivatives_error(by);
    return status;
}

/* Those of others, by central differences, or on one side where the other is refused. */
static int trim_columns(trim *w, mbsr_error *error)
{
    for (int k = 0, next = 0; k < w->params; ++k) {
        if (next < w->products.count && w->products.place[next] == k) {
            ++next;
            continue;
        }
        double *a = column_of_parameter(w, k);
        const double step = parameter_step(w, k);
        const int up = balance_with(w, k, step, a, error);
        if (up == MBSR_ERR_NO_MEMORY) return up;
        const int down = balance_with(w, k, -step, w->new_r, error);
        if (down == MBSR_ERR_NO_MEMORY || (up && down)) return down;
        const double *above = up ? w->r : a, *below = down ? w->r : w->new_r;
        for (int l = 0; l < w->equations; ++l)
            a[l] = (above[l] - below[l]) / (up || down ? step : 2.0 * step);
    }
    return MBSR_OK;
}

/* What of unknown k no equation determines, of its square. */
static double share_unseen(const trim *w, int k, int rank)
{
    double seen = 0.0;
    for (int l = 0; l < rank; ++l) {
        const double v = w->linear.V[(size_t)k * (size_t)w->unknowns + (size_t)l];
        seen += v * v;
    }
    return fmax(0.0, 1.0 - seen);
}

static void find_loose(trim *w, int rank)
{
    w->info.loose = 0.0;
    w->info.loose_rate = w->info.loose_parameter = MBSR_NONE;
    for (int k = 0; k < w->unknowns; ++k) {
        const bool rate = k < w->nu, parameter = k >= w->nu + w->rows;
        if ((rate && w->held[k]) || !(rate || parameter)) continue;
        const double loose = share_unseen(w, k, rank);
        if (!(loose > w->info.loose + 1e-9) || loose < 1e-6) continue;
        w->info.loose = loose;
        w->info.loose_rate = rate ? k : MBSR_NONE;
        w->info.loose_parameter = parameter ? w->which[k - w->nu - w->rows] : MBSR_NONE;
    }
}

/* The step x: A x = -r. */
static int solve_step(trim *w, mbsr_error *error)
{
    const int m = w->equations, n = w->unknowns, least = m < n ? m : n;
    double largest = 0.0;
    int info;
    for (int k = 0; k < n; ++k) {
        w->linear.column[k] = length_of(m, w->linear.A + (size_t)k * (size_t)m);
        if (k < w->nu) w->force = fmax(w->force, w->linear.column[k]);
    }
    for (int k = 0; k < n; ++k) {
        double *a = w->linear.A + (size_t)k * (size_t)m;
        /* what rounding leaves is no stiffness */
        const bool out = k < w->nu && (w->held[k] || w->linear.column[k] <= 1e-13 * w->force);
        if (out || !(w->linear.column[k] > 0.0)) w->linear.column[k] = 1.0;
        for (int l = 0; l < m; ++l) a[l] = out ? 0.0 : a[l] / w->linear.column[k];
    }
    dgesvd_("S", "A", &m, &n, w->linear.A, &m, w->linear.s, w->linear.U, &m, w->linear.V, &n,
            w->linear.work, &w->linear.lwork, &info, 1, 1);
    if (info) return fail_trim(MBSR_EIGEN_FAILED, "LAPACK's singular values", error);
    for (int k = 0; k < least; ++k) largest = fmax(largest, w->linear.s[k]);
    int rank = 0;
    memset(w->linear.x, 0, (size_t)n * sizeof *w->linear.x);
    for (; rank < least && w->linear.s[rank] > 1e-10 * largest; ++rank) {
        double along = 0.0;
        for (int l = 0; l < m; ++l)
            along -= w->linear.U[(size_t)rank * (size_t)m + (size_t)l] * w->r[l];
        for (int k = 0; k < n; ++k)
            w->linear.x[k] +=
                along / w->linear.s[rank] * w->linear.V[(size_t)k * (size_t)n + (size_t)rank];
    }
    find_loose(w, rank);
    for (int k = 0; k < n; ++k)
        w->linear.x[k] = k < w->nu && w->held[k] ? 0.0 : w->linear.x[k] / w->linear.column[k];
    return MBSR_OK;
}

/* Everything moved by `share` of the step, and the balance there. */
static int try_share(trim *w, mbsr_data *d, double share, mbsr_data **made, mbsr_error *error)
{
    const double *x = w->linear.x;
    *made = NULL;
    for (int k = 0; k < w->nu; ++k) w->rate[k] = share * x[k] * w->span[k];
    int status = mbsr_stage_positions(mbsr_data_model(d), d, w->t, w->q);
    if (!status) status = mbsr_stage_velocities(mbsr_data_model(d), d, w->rate);
    if (!status) status = mbsr_coordinate_rates(mbsr_data_model(d), d, w->new_q);
    for (int k = 0; k < w->nq; ++k) w->new_q[k] += w->q[k];
    if (!status) status = mbsr_normalise(mbsr_data_model(d), d, w->new_q);
    if (status) {
        *error = *mbsr_data_error(d);
        return status;
    }
    for (int k = 0; k < w->rows; ++k) w->new_lambda[k] = w->lambda[k] + share * x[w->nu + k];
    for (int k = 0; k < w->params; ++k)
        w->new_theta[k] = w->theta[k] + share * x[w->nu + w->rows + k];
    status = data_of_trim(w, w->new_theta, made, error);
    return status ? status : trim_balance(w, *made, w->new_q, w->new_lambda, w->new_r, error);
}

static void swap_arrays(double **a, double **b)
{
    double *kept = *a;
    *a = *b;
    *b = kept;
}

/* The joint whose forces are farthest from balance, or a loop. */
static int refuse_trim(trim *w, mbsr_data *d, mbsr_error *error)
{
    const mbsr_model *m = mbsr_data_model(d);
    int worst = 0, body = 0, own = 0;
    for (int k = 1; k < w->equations; ++k)
        if (fabs(w->r[k]) > fabs(w->r[worst])) worst = k;
    if (worst >= w->nu)
        return fail_trim(MBSR_LOOP_OPEN, "loops cannot be closed with what is held", error);
    w->info.worst = worst;
    for (int i = 0; i < mbsr_model_bodies(m); ++i) {
        int ui, n;
        mbsr_body_coordinates(m, i, NULL, NULL, &ui, &n);
        if (worst >= ui && worst < ui + n) body = i, own = worst - ui;
    }
    return mbsri_fail(error, MBSR_NO_CONVERGENCE, body, MBSR_NONE,
                      "%s: no balance was found in %d steps: forces along u%d of body %d '%s' are "
                      "farthest from it (%.3g), and no free parameter or position acts on them "
                      "enough: free another one, or start nearer",
                      name, w->info.iterations, own, body, mbsr_body_name(m, body),
                      -w->r[worst] / w->span[worst]);
}

/* A matrix at the present state, and the step. */
static int linearise_trim(trim *w, mbsr_data *d, mbsr_error *error)
{
    mbsr_derivatives *by;
    memset(w->linear.A, 0, (size_t)w->equations * (size_t)w->unknowns * sizeof *w->linear.A);
    int status = mbsr_derivatives_create(mbsr_data_model(d), &by, error);
    if (status) return status;
    const int chosen =
        w->products.count > 0
            ? mbsr_derivatives_parameters(by, w->list, w->products.count, w->products.chosen)
            : MBSR_OK;
    if (chosen) w->products.count = 0; /* not at these values */
    if (chosen == MBSR_ERR_NO_MEMORY) *error = *mbsr_derivatives_error(by), status = chosen;
    if (!status) status = position_columns(w, d, by, error);
    if (!status) status = product_columns(w, by, error);
    mbsr_derivatives_destroy(by);
    if (!status) status = force_columns(w, d, error);
    if (!status) status = trim_balance(w, d, w->q, w->lambda, w->r, error);
    if (!status) status = trim_columns(w, error);
    return status ? status : solve_step(w, error);
}

/* The steps; *d belongs to the present state. */
static int iterate_trim(trim *w, const mbsr_trim_opt *opt, mbsr_data **d, mbsr_error *error)
{
    while (w->info.iterations < opt->max_iterations) {
        int status = linearise_trim(w, *d, error);
        if (status) return status;
        double length = 0.0, most = 0.0;
        for (int k = 0; k < w->nu; ++k) length = fmax(length, fabs(w->linear.x[k]));
        for (int k = 0; k < w->equations; ++k) most = fmax(most, fabs(w->r[k]));
        w->info.step = length;
        const bool last = length <= opt->tolerance && most <= opt->tolerance * w->force;
        double share = length > longest ? longest / length : 1.0;
        const double before = length_of(w->equations, w->r);
        mbsr_data *made = NULL;
        for (int half = 0;; ++half) {
            status = try_share(w, *d, share, &made, error);
            if (!status && length_of(w->equations, w->new_r) <= (1.0 - 1e-3 * share) * before)
                break;
            if (!status && most <= 1e3 * opt->tolerance * w->force) break;
            const bool lost = status == MBSR_ERR_NO_MEMORY;
            if (last || lost || half == 12) {
                mbsr_data_destroy(made);
                return last && !lost ? MBSR_OK : status ? status : refuse_trim(w, *d, error);
            }
            mbsr_data_destroy(made);
            share *= 0.5;
        }
        mbsr_data_destroy(*d);
        *d = made;
        swap_arrays(&w->q, &w->new_q);
        swap_arrays(&w->lambda, &w->new_lambda);
        swap_arrays(&w->theta, &w->new_theta);
        ++w->info.iterations;
        if (last) return MBSR_OK;
    }
    return refuse_trim(w, *d, error);
}

static bool take_trim(trim *w, mbsri_arena *arena)
{
    const size_t m = (size_t)w->equations + 1, n = (size_t)w->unknowns + 1;
    const struct {
        double **place;
        size_t size;
    } all[] = {{&w->q, (size_t)w->nq + 1},
               {&w->new_q, (size_t)w->nq + 1},
               {&w->lambda, n},
               {&w->new_lambda, n},
               {&w->theta, n},
               {&w->new_theta, n},
               {&w->span, n},
               {&w->by_nu, n},
               {&w->rate, n},
               {&w->products.change, n},
               {&w->linear.column, n},
               {&w->linear.x, n},
               {&w->linear.s, n},
               {&w->row_scale, m},
               {&w->r, m},
               {&w->new_r, m},
               {&w->linear.A, m * n},
               {&w->linear.U, m * m},
               {&w->linear.V, n * n},
               {&w->linear.work, 8 * (m + n)}};
    w->linear.lwork = (int)(8 * (m + n));
    for (size_t k = 0; k < sizeof all / sizeof *all; ++k)
        *all[k].place = mbsri_arena_take(arena, all[k].size * sizeof(double));
    w->products.chosen = mbsri_arena_take(arena, n * sizeof *w->products.chosen);
    w->products.place = mbsri_arena_take(arena, n * sizeof *w->products.place);
    w->held = mbsri_arena_take(arena, n * sizeof *w->held);
    w->rigid = mbsri_arena_take(arena, n * sizeof *w->rigid);
    w->row_of = mbsri_arena_take(arena, m * sizeof *w->row_of);
    return !arena->failed;
}

/* What is held, which rows are rigid, spans. */
static int describe_trim(trim *w, mbsr_data *d, const mbsr_trim_opt *opt, mbsr_error *error)
{
    const mbsr_model *m = mbsr_data_model(d);
    for (int k = 0; k < opt->held; ++k) {
        if (!opt->hold || opt->hold[k] < 0 || opt->hold[k] >= w->nu)
            return fail_trim(MBSR_ERR_VALUE, "hold has a rate that does not exist", error);
        w->held[opt->hold[k]] = true;
    }
    for (int k = 0; k < w->nu && opt->held < 0; ++k) w->held[k] = true;
    for (int c = 0; c < mbsr_model_closures(m); ++c) {
        int row, rows, gap, gaps;
        mbsr_closure_indices(m, c, &row, &rows, &gap, &gaps);
        for (int k = 0; k < rows; ++k) {
            w->rigid[row + k] = !(mbsr_closure_stiffness(m, c, k) > 0.0);
            if (k < gaps) w->row_of[gap + k] = row + k;
        }
    }
    int status = mbsr_stage_positions(m, d, w->t, w->q);
    if (status) {
        *error = *mbsr_data_error(d);
        return status;
    }
    w->length = fmax(mbsri_linear_length(m, d), mbsr_model_length(m));
    if (!(w->length > 0.0)) w->length = 1.0;
    for (int i = 0; i < mbsr_model_bodies(m); ++i) {
        int at;
        mbsr_body_coordinates(m, i, NULL, NULL, &at, NULL);
        mbsri_linear_spans(m, i, true, w->length, w->span + at);
    }
    return MBSR_OK;
}

/* The largest real part of the eigenvalues about rest; NaN: not found. */
static double find_growth(const trim *w, mbsr_data *d, mbsri_arena *arena)
{
    mbsr_linear *linear;
    mbsr_linear_info info = {.states = 0};
    double growth = NAN;
    int count = 0;
    if (mbsr_linear_create(mbsr_data_model(d), d, w->t, w->q, NULL, NULL, &linear, NULL))
        return NAN;
    mbsr_linear_get_info(linear, &info);
    mbsr_mode *mode = mbsri_arena_take(arena, ((size_t)info.states + 1) * sizeof *mode);
    if (mode && !mbsr_linear_modes(linear, mode, &count)) {
        for (int k = 0; k < count; ++k) growth = fmax(growth, mode[k].real);
    }
    mbsr_linear_destroy(linear);
    return growth;
}

static int check_trim(const mbsr_parameters *list, const double *q, int count, const int *which,
                      const mbsr_trim_opt *opt, const double *q_rest, const double *value,
                      mbsr_error *error)
{
    if (!list || !q || !q_rest || (count > 0 && (!which || !value)))
        return fail_trim(MBSR_ERR_NULL, "list, q, which, q_rest or value is NULL", error);
    if (opt->cookie != MBSRI_COOKIE)
        return fail_trim(MBSR_ERR_NO_DEFAULT, "opt was not made by mbsr_default_trim_opt", error);
    if (count < 0 || opt->max_iterations < 1 || !(opt->tolerance > 0.0) || opt->held < -1)
        return fail_trim(MBSR_ERR_VALUE,
                         "count and held must not be negative, max_iterations and tolerance must "
                         "be positive",
                         error);
    for (int k = 0; k < count; ++k) {
        if (which[k] < 0 || which[k] >= mbsr_parameters_count(list))
            return mbsri_fail(error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                              "%s: which[%d] is %d, but there are %d parameters", name, k, which[k],
                              mbsr_parameters_count(list));
        for (int l = 0; l < k; ++l)
            if (which[l] == which[k])
                return mbsri_fail(error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                                  "%s: which[%d] and which[%d] are the same parameter", name, l, k);
    }
    return MBSR_OK;
}

int mbsr_trim(const mbsr_parameters *list, double t, const double *q, int count, const int *which,
              const mbsr_trim_opt *opt, double *q_rest, double *value, mbsr_trim_info *info,
              mbsr_error *error)
{
    const mbsr_trim_opt standard = mbsr_default_trim_opt();
    mbsr_error own;
    if (!error) error = &own;
    if (!opt) opt = &standard;
    int status = check_trim(list, q, count, which, opt, q_rest, value, error);
    if (status) return status;
    mbsr_data *d;
    status = mbsr_parameters_data(list, 0, NULL, NULL, &d, error);
    if (status) return status;
    const mbsr_model *m = mbsr_data_model(d);
    trim w = {.list = list,
              .t = t,
              .nq = mbsr_model_nq(m),
              .nu = mbsr_model_nu(m),
              .rows = mbsr_model_rows(m),
              .gaps = mbsr_model_position_rows(m),
              .params = count,
              .which = which,
              .info = {.worst = MBSR_NONE, .growth = NAN}};
    w.unknowns = w.nu + w.rows + w.params;
    w.equations = w.nu + w.gaps;
    mbsri_arena arena;
    mbsr_model_def def;
    mbsr_model_definition(m, &def);
    mbsri_arena_open(&arena, &def.allocator);
    if (!take_trim(&w, &arena)) status = fail_trim(MBSR_ERR_NO_MEMORY, "no memory", error);
    if (!status) memcpy(w.q, q, (size_t)w.nq * sizeof *q);
    for (int k = 0; k < count && !status; ++k) {
        mbsr_parameter p;
        status = mbsr_parameter_get(list, which[k], &p);
        w.theta[k] = p.value;
    }
    if (!status) status = choose_products(&w, m, error);
    if (!status) status = describe_trim(&w, d, opt, error);
    if (!status) status = iterate_trim(&w, opt, &d, error);
    if (!status) memcpy(q_rest, w.q, (size_t)w.nq * sizeof *q_rest);
    if (!status && count > 0) memcpy(value, w.theta, (size_t)count * sizeof *value);
    if (!status && info) w.info.growth = find_growth(&w, d, &arena);
    if (info) *info = w.info;
    mbsri_arena_close(&arena);
    mbsr_data_destroy(d);
    return status;
}
