/* Masses for the tolerances of momenta.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * An error of p_k alone changes u_k by that over D, what is left of the inertia behind the joint
 * where all joints behind it give way. But errors of a step do not come alone: where a light body
 * carries a heavy one by joints that move freely, nearly all of its momentum and of the error in it
 * is the heavy one's, and tested beside D = m it would be held to m / M of what is asked of the
 * heavy body's own. So at least a share of 𝓜_kk counts, the inertia with the joints behind locked.
 * (The scale of a joint has what cancels there, such as a heavy body on the light one itself, but
 * not what is further behind.) In chains, where D is a share of 𝓜_kk by the length of levers alone,
 * that hardly counts. The share keeps errors below one tolerance (a quarter of a car with a carrier
 * of a millionth of the body: 2 at a tenth, 1 at 3 %, 0.2 at 1 %). */
#include "assembly/rate.h"
#include "dynamics/entry.h"
#include "model/record.h"
#include "recursion/backward.h"
#include "recursion/group.h"
#include "recursion/mass_matrix.h"
#include "recursion/modal.h"
#include "recursion/spans.h"

#include <mbsrank/dae.h>
#include <mbsrank/closure.h>
#include <mbsrank/driver.h>

#include <math.h>

static const double share_of_locked = 0.03;

/* Of what a rate moves with closed loops: several momenta act on one rate. */
static const double share_of_moved = 0.35;

/* Square of a lever of rounding errors over one that is none; a mass over the largest is more. */
static const double rounding = 1e-20;

/* A number of the mass matrix that is rounding, beside what was added up in it. */
static const double cancelled = 1e-14;

enum { KINDS = 3 };

/* Of the masses of a model: the largest of each kind of rate, 0: it has none, and of all times the
 * square of the span, kg m^2 (recursion/spans.h). */
typedef struct masses {
    double largest[KINDS], all;
} masses;

/* Diag(J^T W J) and the armature of a joint, the largest entry of each kind of rate, to `largest`.
 */
static void add_masses_of(const mbsr_model *m, const mbsr_data *d, int i, double *largest)
{
    const mbsri_body *b = m->body + i;
    const double *W = d->W + b->dd, *J = d->J + b->dn;
    mbsr_coordinate_kind kind[MBSR_MAX_D];
    mbsr_body_coordinate_kinds(m, b->id, NULL, kind);
    for (int k = 0; k < b->n; ++k) {
        const double mass = mbsri_along_itself(b, W, J, k, d->scratch);
        double *most = largest + (int)kind[k];
        *most = fmax(*most, mass + b->mass.armature[k]);
    }
}

/* What is left of D, for each kind of rate of all joints that are eliminated together: their
 * mbsr_rank_info.scale, the largest entry of diag(J^T W J), where they have rates of one kind; 0
 * where there is none. */
static void of_joints(const mbsr_model *model, mbsr_data *data, double *mass)
{
    mbsr_coordinate_kind kind[MBSR_MAX_D];
    for (int i = 1; i <= model->bodies; ++i) {
        const mbsri_body *b = model->body + i;
        const mbsri_group g = mbsri_group_of(model, data, b->group.head);
        double largest[KINDS] = {0.0};
        for (int k = 0; k < g.members; ++k) add_masses_of(model, data, g.member[k], largest);
        mbsr_body_coordinate_kinds(model, b->id, NULL, kind);
        for (int k = 0; k < b->n; ++k) mass[b->u + k] = largest[(int)kind[k]];
    }
}

/* Of the masses of all rates. A kind has none where its masses are rounding beside the others;
 * without any mass `all` is what force elements would swing. */
static masses find_largest_mass(const mbsr_model *model, const double *mass)
{
    const mbsri_spans spans = mbsri_spans_of(model, NULL);
    mbsr_coordinate_kind kind[MBSR_MAX_D];
    masses found = {.all = 0.0};
    double inertia[KINDS] = {0.0};
    for (int id = 0; id < model->bodies; ++id) {
        const mbsri_body *b = model->body + model->index[id];
        mbsr_body_coordinate_kinds(model, id, NULL, kind);
        for (int k = 0; k < b->n; ++k) {
            const double span = mbsri_coordinate_span(&spans, model, b, true, k);
            double *most = found.largest + (int)kind[k], *moment = inertia + (int)kind[k];
            *most = fmax(*most, mass[b->u + k]);
            *moment = fmax(*moment, mass[b->u + k] * span * span);
            found.all = fmax(found.all, *moment);
        }
    }
    for (int k = 0; k < KINDS; ++k) {
        if (!(inertia[k] > rounding * found.all)) found.largest[k] = 0.0;
    }
    if (!(found.all > 0.0)) found.all = mbsri_elements_inertia(model);
    if (!(found.all > 0.0)) found.all = spans.length * spans.length;
    return found;
}

/* The largest of its kind; of a kind that has none, from all. */
static double usual_mass(const mbsr_model *m, const mbsri_body *b, int k, mbsr_coordinate_kind kind,
                         const masses *of)
{
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    const double span = mbsri_coordinate_span(&spans, m, b, true, k), own = of->largest[(int)kind];
    return own > 0.0 ? own : of->all / (span * span);
}

/* The same with loops closed, which does not depend on where they are cut, beside the inertias
 * `locked`: at most the largest of them of its kind, where nothing moves that. */
static int close_loops(const mbsr_model *model, mbsr_data *data, const double *locked, double *mass)
{
    mbsr_coordinate_kind kind[MBSR_MAX_D];
    const int status = model->rows > 0 ? mbsr_closures_mobility(model, data, mass) : MBSR_OK;
    if (status || model->rows == 0) return status;
    const masses largest = find_largest_mass(model, locked);
    for (int id = 0; id < model->bodies; ++id) {
        const mbsri_body *b = model->body + model->index[id];
        mbsr_body_coordinate_kinds(model, id, NULL, kind);
        for (int k = 0; k < b->n; ++k) {
            double *x = mass + b->u + k;
            const double most = usual_mass(model, b, k, kind[k], &largest),
                         moved = *x > 0.0 ? fmin(share_of_moved / *x, most) : most;
            *x = fmax(moved, 1e-3 * most);
        }
    }
    return MBSR_OK;
}

/* Rates without mass, or with that of levers which are none but for rounding, have the largest of
 * their kind. */
static void fill_kinds(const mbsr_model *model, const masses *largest, double *mass)
{
    mbsr_coordinate_kind kind[MBSR_MAX_D];
    for (int id = 0; id < model->bodies; ++id) {
        const mbsri_body *b = model->body + model->index[id];
        mbsr_body_coordinate_kinds(model, id, NULL, kind);
        for (int k = 0; k < b->n; ++k) {
            double *x = mass + b->u + k;
            const double most = usual_mass(model, b, k, kind[k], largest);
            if (!(*x > rounding * most)) *x = most;
        }
    }
}

int mbsr_momentum_scales(const mbsr_model *model, mbsr_data *data, double *mass)
{
    int status = mbsri_enter(model, data, mass, MBSRI_STAGE_BACKWARD, "mbsr_momentum_scales");
    if (status) return status;
    double *locked = data->out;
    of_joints(model, data, mass);
    if (mbsr_total_rank(model, data) == 0) mbsri_zero((size_t)model->nu, mass);
    const masses largest = find_largest_mass(model, mass);
    mbsri_mass_diagonal(model, data, locked);
    for (int k = 0; k < model->nu; ++k) {
        if (!(locked[k] > cancelled * mass[k])) locked[k] = 0.0;
    }
    status = close_loops(model, data, locked, mass);
    if (!status) fill_kinds(model, &largest, mass);
    for (int k = 0; k < model->nu && !status; ++k)
        mass[k] = fmax(mass[k], share_of_locked * locked[k]);
    return status ? status : mbsri_backward(model, data);
}
