/* Sensitivities of runs: where the laws of elements take other branches, within steps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * As a stop that is hit: forces are continuous there, and so are sensitivities, but the matrices
 * jump. The step is divided there, see sensitivity_run.c. A crossing is found in the driver's
 * polynomial, by halving. Branches that are left and taken again within half a step are not seen.
 *
 * A force that jumps would have the sensitivities jump, too, by how the parameter moves the time of
 * the crossing. That is refused: the residual then changes as much over the last halves as it does
 * over the first. */
#include "ida/error.h"
#include "ida/sensitivity_record.h"

#include <mbsrank/driver.h>

#include <float.h>
#include <math.h>

static int look_at_side(const mbsr_force_args *args, void *user)
{
    *(double *)user = args->force->table->side(args);
    return MBSR_OK;
}

static bool has_side(const mbsr_model *m, int force)
{
    mbsr_force_def def;
    return mbsr_force_definition(m, force, &def) == MBSR_OK && def.table->side &&
           !(def.table->flags & MBSR_FORCE_EVERY_BODY);
}

int mbsri_sensitivity_find_sides(mbsr_sensitivity *s, mbsr_error *error)
{
    const int forces = mbsr_model_forces(s->model);
    mbsri_sides *w = &s->sides;
    for (int k = 0; k < forces; ++k) w->count += has_side(s->model, k);
    if (w->count == 0) return MBSR_OK;
    const size_t count = (size_t)w->count;
    w->last = mbsri_sensitivity_take(3 * count + 4 * (size_t)s->size); /* ints behind numbers */
    if (!w->last)
        return mbsri_ida_refuse(error, MBSR_ERR_NO_MEMORY, "mbsr_sensitivity_create: no memory");
    w->now = w->last + count;
    w->y = w->now + count;
    w->F = w->y + s->size;
    w->force = (int *)(void *)(w->F + 3 * (size_t)s->size);
    for (int k = 0, found = 0; k < forces; ++k)
        if (has_side(s->model, k)) w->force[found++] = k;
    return mbsr_data_create(s->model, &w->data, error);
}

void mbsri_sensitivity_free_sides(mbsri_sides *sides)
{
    mbsr_data_destroy(sides->data);
    mbsri_sensitivity_free(sides->last);
}

/* A failure of what reads the data. */
static int side_failed(mbsr_sensitivity *s, int status)
{
    return mbsri_sensitivity_fail(s, status, mbsr_data_error(s->sides.data),
                                  "mbsr_sensitivity_run");
}

/* The driver's polynomial at t in the last step, which ends at `end`; behind it a straight line. */
static int state_at(mbsr_sensitivity *s, double t, double end, double *y)
{
    double *rate = s->sides.F + 2 * (size_t)s->size;
    int status = mbsr_ida_dense(s->ida, fmin(t, end), 0, y);
    if (!status && t > end) status = mbsr_ida_dense(s->ida, end, 1, rate);
    for (int k = 0; k < s->size && !status && t > end; ++k) y[k] += (t - end) * rate[k];
    return status
               ? mbsri_sensitivity_fail(s, status, mbsr_ida_error(s->ida), "mbsr_sensitivity_run")
               : MBSR_OK;
}

static int sides_at(mbsr_sensitivity *s, double t, double *side)
{
    mbsri_sides *w = &s->sides;
    int status = state_at(s, t, t, w->y);
    if (status) return status;
    status = mbsr_stage_positions(s->model, w->data, t, w->y);
    if (!status) status = mbsr_stage_velocities(s->model, w->data, w->y + s->nq + s->nu);
    for (int k = 0; k < w->count && !status; ++k)
        status = mbsr_force_inspect(s->model, w->data, w->force[k], look_at_side, side + k);
    return status ? side_failed(s, status) : MBSR_OK;
}

int mbsri_sensitivity_note_sides(mbsr_sensitivity *s, double from)
{
    return s->sides.count > 0 ? sides_at(s, from, s->sides.last) : MBSR_OK;
}

/* The first element that is on another branch than it was last; -1: none. */
static int first_changed(const mbsri_sides *w)
{
    for (int k = 0; k < w->count; ++k)
        if (w->now[k] != w->last[k]) return k;
    return -1;
}

/* What F_p and F_u change by from a in the last step, which ends at `end`, to b, with the rates at
 * a. */
static int change_of_forces(mbsr_sensitivity *s, double a, double b, double end, double *most)
{
    mbsri_sides *w = &s->sides;
    double *const rate = w->F + s->size, *const F = rate + s->size;
    int status = mbsr_ida_dense(s->ida, a, 1, rate);
    if (status) mbsri_sensitivity_fail(s, status, mbsr_ida_error(s->ida), "mbsr_sensitivity_run");
    *most = 0.0;
    for (int k = 0; k < 2 && !status; ++k) {
        status = state_at(s, k == 0 ? a : b, end, w->y);
        if (status) break;
        status = mbsr_dae_residual(s->model, w->data, MBSR_DAE_MOMENTUM, k == 0 ? a : b, w->y, rate,
                                   k == 0 ? w->F : F);
        if (status) side_failed(s, status);
    }
    for (int k = s->nq; k < s->nq + 2 * s->nu && !status; ++k)
        *most = fmax(*most, fabs(F[k] - w->F[k]));
    return status;
}

/* From a to b, next to each other, element k takes another branch. */
static int check_continuous(mbsr_sensitivity *s, int k, double from, double to, double a, double b)
{
    const double far = 0x1p-10 * (to - from);
    double near_by = 0.0, over = 0.0;
    int status = change_of_forces(s, a, b, to, &near_by);
    if (!status) status = change_of_forces(s, fmax(from, a - far), b + far, to, &over);
    /* some forces that jump have no value next to where they do */
    const bool none = status == MBSR_DEGENERATE_FORCE;
    if (!none && (status || !(near_by > 0.5 * over))) return status;
    mbsr_force_def def;
    mbsr_force_definition(s->model, s->sides.force[k], &def);
    mbsri_ida_fail(&s->error, MBSR_ERR_SPACE, MBSR_NONE, s->sides.force[k],
                   "mbsr_sensitivity_run: at t = %.10g force %d (%s) jumps where it takes another "
                   "branch",
                   a, s->sides.force[k], def.table->name);
    return MBSR_ERR_SPACE;
}

int mbsri_sensitivity_cross(mbsr_sensitivity *s, double from, double to, double *before,
                            double *behind)
{
    mbsri_sides *w = &s->sides;
    double a = from, b = to;
    int k = -1;
    *before = to;
    for (int part = 1; part <= 2 && k < 0 && w->count > 0; ++part) {
        b = part == 2 ? to : from + 0.5 * (to - from);
        const int status = sides_at(s, b, w->now);
        if (status) return status;
        k = first_changed(w);
        if (k < 0) a = b;
    }
    if (k < 0) return MBSR_OK;
    for (int half = 0; half < 40 && b - a > 4.0 * DBL_EPSILON * fabs(b); ++half) {
        const double middle = a + 0.5 * (b - a);
        const int status = sides_at(s, middle, w->now);
        if (status) return status;
        const int other = first_changed(w);
        if (other < 0) {
            a = middle;
        } else {
            b = middle;
            k = other;
        }
    }
    *before = a;
    *behind = b;
    return check_continuous(s, k, from, to, a, b);
}
