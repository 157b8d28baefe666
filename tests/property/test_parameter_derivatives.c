/* Derivatives of inverse and forward dynamics and of the residual in parameters: against
 * differences of models with other values, and tangent against adjoint.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "medley.h"
#include "rigid_tree.h"

#include <mbsrank/derivatives.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEVELS = 4, MOST = 24 };

/* The longest and the shortest step of differences over a parameter's span; the sum of what the
 * shortest steps, each half as long as the last, count in Richardson's last line. */
#define LONGEST 0x1p-5
#define SHORTEST 0x1p-8
#define WEIGHTS 2.0

typedef enum subject { INVERSE, FORWARD, RESIDUAL } subject;

static const char *const kind_name[] = {"inverse dynamics", "forward dynamics", "residual"};

typedef struct scene {
    medley s;
    test_rigid_tree tree; /* whose model it then is */
    test_rng rng;
    subject kind;
    mbsr_parameters *list;
    mbsr_derivatives *w;
    int which[MOST], count, n, compared; /* n: numbers of a result, and of these the first */
    double *load, *out, *table;          /* load: of the residual y and y' */
    double size;                         /* of the result */
} scene;

typedef struct tally {
    int parts[MBSR_PARAMETER_TABLE_VALUE + 1], refused, closed, forward, deficient;
} tally;

static double *numbers(int count)
{
    return calloc((size_t)count + 1, sizeof(double));
}

static void expect_near(const scene *z, const char *what, const char *name, double off,
                        double limit)
{
    if (off <= limit) return;
    print_error("seed %d (%d bodies, %d rows), %s: %s of %s off by %.3g > %.3g\n", (int)z->s.c.seed,
                z->s.bodies, z->s.rows, kind_name[z->kind], what, name, off, limit);
    fail();
}

/* ---- what is differenced ---- */

static int evaluate(const scene *z, int parameter, double value, double *out)
{
    const medley *s = &z->s;
    mbsr_data *d;
    int status = mbsr_parameters_data(z->list, 1, &parameter, &value, &d, NULL);
    if (status) return status;
    const mbsr_model *m = mbsr_data_model(d);
    memset(out, 0, (size_t)z->n * sizeof *out);
    if (z->kind == RESIDUAL) {
        status = mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, s->t, z->load, z->load + z->n, out);
    } else if (z->kind == INVERSE) {
        status = mbsr_inverse_dynamics(m, d, s->t, s->q, s->u, z->load, NULL, out);
    } else {
        status = mbsr_forward_dynamics(m, d, s->t, s->q, s->u, z->load, out);
        if (!status && s->rows > 0) status = mbsr_closures_lambda(m, d, out + s->nu);
    }
    mbsr_data_destroy(d);
    return status;
}

/* What rounding makes of the differences: by how much results at values next to each other leave a
 * straight line. */
static int scatter(const scene *z, const mbsr_parameter *p, int parameter, double span,
                   double *rounding)
{
    enum { NEIGHBOURS = 9 };
    double *sample = numbers(NEIGHBOURS * z->n), largest = 0.0;
    int status = MBSR_OK;
    for (int l = 0; l < NEIGHBOURS && !status; ++l)
        status = evaluate(z, parameter, p->value + 1e-7 * (l - NEIGHBOURS / 2) * span,
                          sample + l * z->n);
    for (int l = 1; l < NEIGHBOURS - 1 && !status; ++l) {
        const double *x = sample + l * z->n;
        for (int k = 0; k < z->compared; ++k)
            largest = fmax(largest, fabs(x[k - z->n] - 2.0 * x[k] + x[k + z->n]));
    }
    *rounding = 0.5 * largest * WEIGHTS / (SHORTEST * span);
    free(sample);
    return status;
}

/* Richardson's differences, into the last line of the table; how far its last two disagree, with
 * what rounding makes of them. */
static int differences(const scene *z, const mbsr_parameter *p, int parameter, double span,
                       double *doubt)
{
    double *sample = numbers(2 * z->n), factor = 1.0;
    int status = MBSR_OK;
    for (int level = 0; level < LEVELS && !status; ++level) {
        const double h = LONGEST * span / (double)(1 << level);
        status = evaluate(z, parameter, p->value + h, sample);
        if (!status) status = evaluate(z, parameter, p->value - h, sample + z->n);
        for (int k = 0; k < z->n; ++k)
            z->table[level * z->n + k] = (sample[k] - sample[z->n + k]) / (2.0 * h);
    }
    free(sample);
    if (!status) status = scatter(z, p, parameter, span, doubt);
    for (int order = 1; order < LEVELS && !status; ++order) {
        factor *= 4.0;
        for (int level = LEVELS - 1; level >= order; --level) {
            double *fine = z->table + level * z->n, *coarse = fine - z->n;
            for (int k = 0; k < z->n; ++k) {
                const double better = (factor * fine[k] - coarse[k]) / (factor - 1.0);
                if (level == LEVELS - 1 && order == LEVELS - 1 && k < z->compared)
                    *doubt = fmax(*doubt, fabs(better - fine[k]));
                fine[k] = better;
            }
        }
    }
    return status;
}

static double span_of(const mbsr_parameter *p)
{
    return p->value != 0.0 ? fabs(p->value) : 1.0;
}

/* ---- checks ---- */

static void choose(scene *z, tally *all)
{
    const int count = mbsr_parameters_count(z->list);
    for (int tries = 0; tries < 4 * MOST && z->count < MOST; ++tries) {
        const int k = test_integer(&z->rng, 0, count - 1);
        bool known = false;
        for (int l = 0; l < z->count; ++l) known = known || z->which[l] == k;
        if (known) continue;
        const int status = mbsr_derivatives_parameters(z->w, z->list, 1, &k);
        if (status) {
            assert_int_equal(status, MBSR_ERR_SPACE);
            ++all->refused;
            continue;
        }
        z->which[z->count++] = k;
    }
    assert_ok(mbsr_derivatives_parameters(z->w, z->list, z->count, z->which),
              mbsr_derivatives_error(z->w));
}

/* Springs of 1e10 cancel in differences, and closures that give nothing but gaps are differenced
 * three times. */
static double rough(const scene *z)
{
    double factor = 1.0;
    for (int c = 0; c < mbsr_model_closures(z->s.m); ++c) {
        mbsr_closure_def def;
        int row, rows, gap, gaps;
        assert_int_equal(mbsr_closure_definition(z->s.m, c, &def), MBSR_OK);
        mbsr_closure_indices(z->s.m, c, &row, &rows, &gap, &gaps);
        if (!def.table->bias) factor = 100.0;
        for (int r = 0; r < rows; ++r)
            if (mbsr_closure_stiffness(z->s.m, c, r) > 1e7) factor = 100.0;
    }
    return factor;
}

/* Column k of the matrix, times the size of the parameter; its largest entry. */
static double column(scene *z, int k, double *out)
{
    mbsr_parameter p;
    double *dtheta = numbers(z->count);
    assert_int_equal(mbsr_parameter_get(z->list, z->which[k], &p), MBSR_OK);
    dtheta[k] = span_of(&p);
    if (z->kind == RESIDUAL)
        assert_ok(mbsr_derivatives_residual_tangent(z->w, NULL, NULL, dtheta, out),
                  mbsr_derivatives_error(z->w));
    else
        assert_ok(mbsr_derivatives_parameter_tangent(z->w, dtheta, out, NULL),
                  mbsr_derivatives_error(z->w));
    free(dtheta);
    return test_largest(z->compared, out);
}

/* Each parameter by itself, beside differences, to 1e-9 of the largest entry of the matrix. */
static void check_tangents(scene *z, tally *all)
{
    double size = z->size;
    for (int k = 0; k < z->count; ++k) size = fmax(size, column(z, k, z->out));
    for (int k = 0; k < z->count; ++k) {
        mbsr_parameter p;
        double doubt, off = 0.0;
        assert_int_equal(mbsr_parameter_get(z->list, z->which[k], &p), MBSR_OK);
        const double span = span_of(&p);
        (void)column(z, k, z->out);
        if (differences(z, &p, z->which[k], span, &doubt) != MBSR_OK) continue;
        const double *expected = z->table + (LEVELS - 1) * z->n;
        for (int j = 0; j < z->compared; ++j) off = fmax(off, fabs(z->out[j] - span * expected[j]));
        expect_near(z, "tangent", p.name, off, 1e-9 * rough(z) * size + 3.0 * doubt * span);
        ++all->parts[p.part];
    }
}

/* <w, J v> = <J^T w, v>. */
static void check_adjoint(scene *z, bool lambda)
{
    const medley *s = &z->s;
    double *dtheta = numbers(2 * z->count), *by = dtheta + z->count, *dlambda = numbers(s->rows),
           *w = numbers(s->nu + s->rows), *w_lambda = w + s->nu, left = 0.0, right = 0.0,
           size = z->size;
    test_fill(&z->rng, z->count, dtheta);
    test_fill(&z->rng, s->nu + s->rows, w);
    assert_ok(mbsr_derivatives_parameter_tangent(z->w, dtheta, z->out, lambda ? dlambda : NULL),
              mbsr_derivatives_error(z->w));
    assert_ok(mbsr_derivatives_parameter_adjoint(z->w, w, lambda ? w_lambda : NULL, by),
              mbsr_derivatives_error(z->w));
    for (int k = 0; k < s->nu; ++k) {
        left += w[k] * z->out[k];
        size += fabs(w[k] * z->out[k]);
    }
    for (int k = 0; k < s->rows && lambda; ++k) {
        left += w_lambda[k] * dlambda[k];
        size += fabs(w_lambda[k] * dlambda[k]);
    }
    for (int k = 0; k < z->count; ++k) {
        right += by[k] * dtheta[k];
        size += fabs(by[k] * dtheta[k]);
    }
    expect_near(z, "adjoint", "all", fabs(left - right), 1e-12 * size);
    free(dtheta);
    free(dlambda);
    free(w);
}

static double product(int n, const double *a, const double *b, double *size)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) {
        sum += a[k] * b[k];
        *size += fabs(a[k] * b[k]);
    }
    return sum;
}

/* Of the residual, in y, y' and parameters together: <w, J v> = <J^T w, v>; in y and y' the
 * products of the Newton solver. */
static void check_residual(scene *z)
{
    const medley *s = &z->s;
    const int n = z->n, all = 2 * n + z->count;
    double *x = numbers(2 * all + 4 * n), *by = x + all, *w = by + all, *other = w + n, size = 1.0,
           largest = 1.0;
    mbsr_newton_opt opt = mbsr_default_newton_opt();
    mbsr_newton *newton;
    mbsr_data *fresh; /* which leaves out no rows */
    const mbsr_error *error = mbsr_derivatives_error(z->w);
    opt.products = 1;
    assert_ok(mbsr_data_create(s->m, &fresh, NULL), NULL);
    test_fill(&z->rng, all, x);
    test_fill(&z->rng, n, w);
    assert_ok(mbsr_derivatives_residual_tangent(z->w, x, x + n, x + 2 * n, z->out), error);
    assert_ok(mbsr_derivatives_residual_adjoint(z->w, w, by, by + n, by + 2 * n), error);
    const double left = product(n, w, z->out, &size), right = product(all, by, x, &size);
    expect_near(z, "adjoint", "all", fabs(left - right), 1e-12 * size);
    assert_ok(mbsr_derivatives_residual_tangent(z->w, x, x + n, NULL, z->out), error);
    assert_ok(mbsr_newton_create(s->m, MBSR_DAE_MOMENTUM, &opt, &newton, NULL), NULL);
    assert_ok(mbsr_newton_linearise(newton, fresh, s->t, z->load, z->load + n, 0.0),
              mbsr_newton_error(newton));
    assert_ok(mbsr_newton_multiply(newton, x, other), mbsr_newton_error(newton));
    assert_ok(mbsr_newton_multiply_rate(newton, x + n, other + n), mbsr_newton_error(newton));
    for (int k = 0; k < n; ++k) largest = fmax(largest, fabs(other[k]) + fabs(other[n + k]));
    for (int k = 0; k < n; ++k)
        expect_near(z, "tangent", "y", fabs(z->out[k] - other[k] - other[n + k]), 1e-12 * largest);
    mbsr_newton_destroy(newton);
    mbsr_data_destroy(fresh);
    free(x);
}

/* ---- scenes ---- */

static bool open_scene(scene *z, uint64_t seed, bool tree, subject kind)
{
    *z = (scene){.rng = test_seed(seed + 11), .kind = kind};
    medley *s = &z->s;
    if (tree) {
        test_rng rng = test_seed(seed + 77);
        const test_rigid_choice c = {.seed = seed,
                                     .bodies = test_integer(&rng, 2, 14),
                                     .massless = seed % 4 == 0 && kind != FORWARD ? 0.2 : 0.0,
                                     .many = seed % 2 == 0 ? 0.6 : 0.1,
                                     .branching = 0.4,
                                     .floating = seed % 5 == 0,
                                     .length = 1.0,
                                     .moving = seed % 7 == 0,
                                     .shuffle = seed % 6 == 0,
                                     .forces = seed % 3 == 1,
                                     .held = seed % 2 == 0 ? 0.3 : 0.0,
                                     .armature = seed % 4 == 1 ? 0.4 : 0.0};
        test_rigid_tree *t = &z->tree;
        test_rigid_tree_make(t, c);
        *s = (medley){.c = {.seed = seed},
                      .m = t->model,
                      .d = t->data,
                      .bodies = c.bodies,
                      .nq = t->nq,
                      .nu = t->nu,
                      .t = t->t,
                      .q = t->q,
                      .u = t->u};
    } else {
        medley_choice c = medley_choose(seed);
        if (seed % 3 == 0) c.closures = 0;
        if (!medley_make(s, &c) || s->nu > 100) return false;
    }
    z->compared = s->nu;
    z->n = s->nu + s->rows;
    if (kind == RESIDUAL) z->n = z->compared = mbsr_dae_size(s->m, MBSR_DAE_MOMENTUM);
    z->load = numbers(2 * z->n);
    z->out = numbers(z->n);
    z->table = numbers(LEVELS * z->n);
    assert_ok(mbsr_parameters_create(s->m, &z->list, NULL), NULL);
    return mbsr_derivatives_create(s->m, &z->w, NULL) == MBSR_OK;
}

static void close_scene(scene *z)
{
    mbsr_derivatives_destroy(z->w);
    mbsr_parameters_destroy(z->list);
    free(z->load);
    free(z->out);
    free(z->table);
    if (z->tree.model)
        test_rigid_tree_free(&z->tree);
    else
        medley_free(&z->s);
}

/* Whether the rows allow what parameters move: forward dynamics has lambda then. */
static bool has_lambda(scene *z)
{
    double *zero = numbers(z->count), *dlambda = numbers(z->s.rows);
    const bool has = z->kind == FORWARD && z->s.rows > 0 &&
                     mbsr_derivatives_parameter_tangent(z->w, zero, z->out, dlambda) == MBSR_OK;
    free(zero);
    free(dlambda);
    return has;
}

static void check_dynamics(scene *z, tally *all)
{
    const medley *s = &z->s;
    const bool forward = z->kind == FORWARD;
    test_fill(&z->rng, s->nu, z->load);
    const int status = forward
                           ? mbsr_derivatives_forward(z->w, s->t, s->q, s->u, z->load, z->out, NULL)
                           : mbsr_derivatives_inverse(z->w, s->t, s->q, s->u, z->load, z->out);
    if (status != MBSR_OK) return;
    z->size = fmax(1.0, test_largest(s->nu, z->out));
    const bool lambda = has_lambda(z);
    if (!lambda && forward && s->rows > 0) return;
    check_tangents(z, all);
    check_adjoint(z, lambda);
    all->forward += forward;
    all->closed += lambda;
}

/* At a start, where the algebraic equations hold. */
static void check_start(scene *z, tally *all)
{
    const medley *s = &z->s;
    double *y = z->load, *yp = y + z->n;
    mbsr_consistent_info info;
    assert_ok(mbsr_dae_pack(s->m, s->d, MBSR_DAE_MOMENTUM, s->t, s->q, s->u, y),
              mbsr_data_error(s->d));
    if (mbsr_dae_consistent(s->m, s->d, MBSR_DAE_MOMENTUM, s->t, y, yp, NULL, &info) ||
        mbsr_derivatives_residual(z->w, s->t, y, yp, z->out))
        return;
    z->size = fmax(1.0, test_largest(z->n, z->out));
    check_tangents(z, all);
    check_residual(z);
    all->forward += 1;
    all->closed += s->rows > 0;
    all->deficient += mbsr_total_rank(s->m, s->d) < s->nu;
}

static void check(uint64_t seed, bool tree, subject kind, tally *all)
{
    scene z;
    const bool opened = open_scene(&z, seed, tree, kind);
    if (opened && mbsr_parameters_count(z.list) > 0) choose(&z, all);
    if (opened && z.count > 0) (kind == RESIDUAL ? check_start : check_dynamics)(&z, all);
    close_scene(&z);
}

static void mechanisms_of_everything(void **state)
{
    (void)state;
    tally all = {{0}, 0, 0, 0, 0};
    const int seeds = test_long() ? 150 : test_seeds_short(8, 30);
    for (int seed = 1; seed <= seeds; ++seed) {
        check((uint64_t)seed, false, INVERSE, &all);
        check((uint64_t)seed, false, FORWARD, &all);
    }
    check(117, false, INVERSE, &all); /* a point in the plane, whose frame is turned */
    check(117, false, FORWARD, &all);
    for (int part = 0; part <= MBSR_PARAMETER_DAMPING; ++part)
        assert_true(all.parts[part] > 0 || seeds < 30); /* fewer do not have all */
    assert_true(all.refused > 0 && all.closed > 0);
}

static void rigid_trees(void **state)
{
    (void)state;
    tally all = {{0}, 0, 0, 0, 0};
    const int seeds = test_long() ? 300 : test_seeds_short(6, 30);
    for (int seed = 1; seed <= seeds; ++seed) {
        check((uint64_t)seed, true, INVERSE, &all);
        check((uint64_t)seed, true, FORWARD, &all);
    }
    assert_true(all.forward > seeds / 2);
}

static void residuals(void **state)
{
    (void)state;
    tally all = {{0}, 0, 0, 0, 0};
    const int seeds = test_long() ? 200 : test_seeds_short(3, 10);
    for (int seed = 1; seed <= seeds; ++seed) {
        check((uint64_t)seed, false, RESIDUAL, &all);
        check((uint64_t)seed, true, RESIDUAL, &all);
    }
    check(117, false, RESIDUAL, &all); /* a point in the plane, whose frame is turned */
    check(8, false, RESIDUAL, &all);   /* stiff rows */
    for (int part = 0; part <= MBSR_PARAMETER_DAMPING; ++part)
        assert_true(all.parts[part] > 0 || !test_long());
    assert_true(all.forward > seeds && all.closed > 0 && all.deficient > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(mechanisms_of_everything),
                                       cmocka_unit_test(rigid_trees), cmocka_unit_test(residuals)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
