/* Products with dF/dy', and steps of the linearised equations of a run, which have it on the right.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * In F stand the rates of q and p by themselves, and those of multipliers where c dF/dy' has them:
 * so E = dF/dy' is the unit matrix of q and p, and columns of A + c E by c. A row that redundancy
 * leaves out has nothing in E; one with stiffness k and damping d, and its position row,
 *
 *   E e_lambda = e_lambda / (k + c d) + d / (k (k + c d)) e_eta + d / (k + c d) (A + c E) e_lambda
 *
 * which gives E h and E^T x from h, and from x and (A + c E)^T x. */
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "newton/carried/carried.h"
#include "newton/front/front.h"
#include "newton/solution.h"
#include "newton/sweeps/record.h"
#include "recursion/closures.h"

static int refuse_product(mbsr_newton *w, int status, const char *function, const char *text)
{
    return mbsri_fail(&w->error, status, MBSR_NONE, MBSR_NONE, "%s: %s", function, text);
}

static int check_product(mbsr_newton *w, const char *function, const double *in, const double *out,
                         size_t length)
{
    if (!in || !out) return refuse_product(w, MBSR_ERR_NULL, function, "a vector is NULL");
    if (!w->linearised)
        return refuse_product(w, MBSR_ERR_SEQUENCE, function,
                              "mbsr_newton_linearise has not run or has failed");
    if (!mbsri_finite(length, in))
        return refuse_product(w, MBSR_NOT_FINITE, function, "its argument is not finite");
    return MBSR_OK;
}

static size_t whole(const mbsr_newton *w)
{
    return (size_t)mbsr_dae_size(w->model, MBSR_DAE_MOMENTUM);
}

/* Hands out the result, which is in w->solution. */
static int hand_out(mbsr_newton *w, const char *function, double *out, size_t length)
{
    if (!mbsri_finite(length, w->solution))
        return refuse_product(w, MBSR_NOT_FINITE, function, "the product is not finite");
    mbsri_copy(length, w->solution, out);
    return MBSR_OK;
}

/* The matrix is dF/dy + c dF/dy': its product with c = 1, less that with c = 0. */
static int multiply_rate(mbsr_newton *w, const char *function, const double *in, double *out,
                         void (*product)(const mbsri_linear *, const double *, mbsri_vectors *,
                                         double *))
{
    const size_t size = whole(w);
    const int status = check_product(w, function, in, out, size);
    if (status) return status;
    mbsri_linear *linear = w->linear;
    const double c = linear->c;
    double *without = w->other;
    linear->c = 0.0;
    product(linear, in, &w->vectors, without);
    linear->c = 1.0;
    product(linear, in, &w->vectors, w->solution);
    linear->c = c;
    for (size_t k = 0; k < size; ++k) w->solution[k] -= without[k];
    return hand_out(w, function, out, size);
}

int mbsr_newton_multiply_rate(mbsr_newton *newton, const double *x, double *r)
{
    if (!newton) return MBSR_ERR_NULL;
    return multiply_rate(newton, "mbsr_newton_multiply_rate", x, r, mbsri_product);
}

/* ---- steps ---- */

/* A row of a closure, of which there are numbers at `lambda` and, of a position row, at `eta`;
 * dropped: redundancy leaves it out. */
typedef struct row {
    int lambda, eta;
    bool dropped, places, stiff;
    double of_rate, of_place, of_force; /* the three factors of e_lambda above */
} row;

static bool is_dropped(const mbsr_newton *w, const mbsri_closure *c, int k)
{
    if (!w->by_sweeps) return w->front->linear->dropped[c->row + k];
    const int name = k < c->position_rows && mbsri_is_stiff(c, k) ? mbsri_name_eta(w->model, c, k)
                                                                  : mbsri_name_lambda(c, k);
    return w->carried.multiplier[name].right < 0;
}

static double factor_of(const mbsr_newton *w)
{
    return w->by_sweeps ? w->sweeps->c : w->front->c;
}

static row row_of(const mbsr_newton *w, const mbsri_closure *c, int k)
{
    const mbsr_model *m = w->model;
    const int first = m->nq + 2 * m->nu;
    const double stiffness = c->def.stiffness[k], damping = c->def.damping[k],
                 both = stiffness + factor_of(w) * damping;
    row r = {.lambda = first + mbsri_name_lambda(c, k),
             .eta = first + mbsri_name_eta(m, c, k),
             .dropped = is_dropped(w, c, k),
             .places = k < c->position_rows,
             .stiff = mbsri_is_stiff(c, k)};
    if (!r.stiff) return r;
    r.of_rate = 1.0 / both;
    r.of_place = r.places && !r.dropped ? damping / (stiffness * both) : 0.0;
    r.of_force = damping / both;
    return r;
}

typedef void row_visit(const row *r, double c, const double *in, double *out);

static void visit_rows(const mbsr_newton *w, row_visit *visit, const double *in, double *out)
{
    const mbsri_closure *all = w->model->closures.data;
    for (size_t l = 0; l < w->model->closures.count; ++l) {
        for (int k = 0; k < all[l].rows; ++k) {
            const row r = row_of(w, all + l, k);
            visit(&r, factor_of(w), in, out);
        }
    }
}

/* r -= E h */
static void take_history(const row *r, double c, const double *h, double *right)
{
    (void)c;
    if (!r->stiff) return;
    right[r->lambda] -= r->of_rate * h[r->lambda];
    if (r->of_place != 0.0) right[r->eta] -= r->of_place * h[r->lambda];
}

/* delta -= what (A + c E)^-1 makes of the rest of E h */
static void finish_history(const row *r, double c, const double *h, double *delta)
{
    if (r->stiff)
        delta[r->lambda] -= r->of_force * h[r->lambda];
    else if (!r->dropped)
        delta[r->lambda] -= h[r->lambda] / c;
    if (r->places && !r->dropped) delta[r->eta] -= h[r->eta] / c;
}

/* h = -E^T x, where h has -(A + c E)^T x. */
static void say_history(const row *r, double c, const double *x, double *h)
{
    if (r->stiff)
        h[r->lambda] = r->of_force * h[r->lambda] - r->of_rate * x[r->lambda] -
                       (r->of_place != 0.0 ? r->of_place * x[r->eta] : 0.0);
    else
        h[r->lambda] = r->dropped ? 0.0 : h[r->lambda] / c;
    if (r->places) h[r->eta] = r->dropped ? 0.0 : h[r->eta] / c;
}

static int check_step(mbsr_newton *w, const char *function, const double *a, size_t length,
                      const double *b, size_t length_of_b, const void *out)
{
    if (!a || !b || !out) return refuse_product(w, MBSR_ERR_NULL, function, "a vector is NULL");
    if (w->lean) return refuse_product(w, MBSR_ERR_LEAN, function, "the solver is lean");
    if (!w->factored)
        return refuse_product(w, MBSR_ERR_SEQUENCE, function, "there is no factorisation");
    if (!mbsri_finite(length, a) || !mbsri_finite(length_of_b, b))
        return refuse_product(w, MBSR_NOT_FINITE, function, "its argument is not finite");
    return MBSR_OK;
}

int mbsr_newton_solve_sensitivity(mbsr_newton *newton, const double *tau, const double *history,
                                  double *delta)
{
    static const char name[] = "mbsr_newton_solve_sensitivity";
    if (!newton) return MBSR_ERR_NULL;
    const mbsr_model *m = newton->model;
    const size_t size = whole(newton), places = (size_t)m->nq, rates = (size_t)m->nu;
    const int status = check_step(newton, name, tau, rates, history, size, delta);
    if (status || size == 0) return status;
    double *r = newton->right;
    mbsri_zero(size, r);
    for (size_t k = 0; k < places + rates; ++k) r[k] = -history[k];
    visit_rows(newton, take_history, history, r);
    if (!mbsri_newton_solution(newton, r, tau))
        return refuse_product(newton, MBSR_NO_CONVERGENCE, name,
                              "the forces between bodies that are not eliminated together do not "
                              "converge");
    visit_rows(newton, finish_history, history, newton->solution);
    return hand_out(newton, name, delta, size);
}

int mbsr_newton_solve_adjoint(mbsr_newton *newton, const double *v, double *tau, double *history)
{
    static const char name[] = "mbsr_newton_solve_adjoint";
    if (!newton) return MBSR_ERR_NULL;
    const mbsr_model *m = newton->model;
    const size_t size = whole(newton), places = (size_t)m->nq, rates = (size_t)m->nu;
    const int status = check_step(newton, name, v, size, v, 0, tau && history ? tau : NULL);
    if (status) return status;
    if (!newton->transposes)
        return refuse_product(newton, MBSR_ERR_SEQUENCE, name,
                              "the solver was created without `transposes`");
    if (size == 0) return MBSR_OK;
    double *x = newton->right, *h = newton->solution, *torque = newton->load;
    mbsri_newton_solution_transposed(newton, v, x, torque);
    mbsri_zero(size, h);
    for (size_t k = 0; k < places + rates; ++k) h[k] = -x[k];
    for (size_t k = places + 2 * rates; k < size; ++k) h[k] = -v[k];
    visit_rows(newton, say_history, x, h);
    if (!mbsri_finite(rates, torque))
        return refuse_product(newton, MBSR_NOT_FINITE, name, "the product is not finite");
    const int finite = hand_out(newton, name, history, size);
    if (!finite) mbsri_copy(rates, torque, tau);
    return finite;
}
