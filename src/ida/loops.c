/* Closed loops in a run.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "ida/loops.h"

#include "ida/error.h"
#include "ida/linear.h"
#include "ida/stiff.h"

#include <mbsrank/closure.h>
#include <mbsrank/driver.h>

#include <math.h>

/* Squared sine of the angle between a row and the span of others, below which it is to blame. */
static const double SINGULAR = 1e-3;

/* What is left of the hold on bodies without mass, below which they are stretched. */
static const double STRETCHED = 1e-2;

int mbsri_ida_loops(const mbsr_ida *ida)
{
    return ida->size - mbsr_model_rows(ida->model) - mbsr_model_position_rows(ida->model);
}

/* ---- tolerances ---- */

/* Beyond so many joint rates and rows one product with C^T for each row is not worth while. */
enum { MOST_PRODUCTS = 600, KINDS = MBSR_COORDINATE_TRANSLATION + 1 };

/* What the tolerances of multipliers are made of. */
typedef struct rows_scale {
    mbsr_ida *ida;
    bool each;           /* by a product with C^T */
    const double *place; /* nu: tolerances of what joint rates move */
    double *e, *w, *along;
    double lever;                        /* m */
    double impulse[KINDS], shift[KINDS]; /* largest of the rates of each kind; 0: there are none */
} rows_scale;

static void note_kinds(rows_scale *s)
{
    const mbsr_model *m = s->ida->model;
    const double *p = N_VGetArrayPointer(s->ida->tol.atol) + mbsr_model_nq(m);
    mbsr_coordinate_kind kind[MBSR_MAX_D];
    for (int i = 0; i < mbsr_model_bodies(m); ++i) {
        int u, n;
        mbsr_body_coordinates(m, i, NULL, NULL, &u, &n);
        mbsr_body_coordinate_kinds(m, i, NULL, kind);
        for (int k = 0; k < n; ++k) {
            s->impulse[kind[k]] = fmax(s->impulse[kind[k]], p[u + k]);
            s->shift[kind[k]] = fmax(s->shift[kind[k]], s->place[u + k] / s->w[u + k]);
        }
    }
}

/* A row that measures turns or places, by what is on the rates that do. */
static double by_row_kind(const rows_scale *s, mbsr_coordinate_kind row, const double *largest)
{
    const double turn = largest[MBSR_COORDINATE_ROTATION], way = largest[row],
                 far = s->lever > 0.0 ? turn / s->lever : 0.0;
    if (row == MBSR_COORDINATE_ROTATION) return turn;
    return way > 0.0 && far > 0.0 ? fmin(way, far) : fmax(way, far);
}

/* Of the multipliers of one row, by its C^T. */
static int scale_by_product(rows_scale *s, int row, double *impulse, double *shift)
{
    mbsr_ida *ida = s->ida;
    const int nq = mbsr_model_nq(ida->model), nu = mbsr_model_nu(ida->model);
    const double *p = N_VGetArrayPointer(ida->tol.atol) + nq;
    s->e[row] = 1.0;
    const int status = mbsr_closures_transpose(ida->model, ida->data, s->e, s->along);
    s->e[row] = 0.0;
    *impulse = *shift = INFINITY;
    for (int k = 0; k < nu && !status; ++k) {
        const double size = fabs(s->along[k]);
        if (!(size > 0.0)) continue;
        *impulse = fmin(*impulse, p[k] / size);
        *shift = fmin(*shift, s->place[k] / (s->w[k] * size));
    }
    if (!isfinite(*impulse)) *impulse = *shift = ida->opt.atol;
    return status;
}

static int scale_row(rows_scale *s, int row, double *impulse, double *shift)
{
    mbsr_ida *ida = s->ida;
    mbsr_coordinate_kind kind = MBSR_COORDINATE_OTHER;
    const int status =
        s->each ? MBSR_OK : mbsr_closure_row_kind(ida->model, ida->data, row, &kind, NULL);
    if (status) return status;
    *impulse = kind == MBSR_COORDINATE_OTHER ? 0.0 : by_row_kind(s, kind, s->impulse);
    *shift = kind == MBSR_COORDINATE_OTHER ? 0.0 : by_row_kind(s, kind, s->shift);
    return *impulse > 0.0 ? MBSR_OK : scale_by_product(s, row, impulse, shift);
}

int mbsri_ida_scale_multipliers(mbsr_ida *ida, const double *place)
{
    const int nu = mbsr_model_nu(ida->model), rows = mbsr_model_rows(ida->model),
              first = mbsri_ida_loops(ida);
    double *atol = N_VGetArrayPointer(ida->tol.atol), *e = N_VGetArrayPointer(ida->work);
    if (rows == 0 || nu == 0) return MBSR_OK;
    rows_scale s = {.ida = ida,
                    .each = nu + rows <= MOST_PRODUCTS,
                    .place = place,
                    .e = e,
                    .w = e + rows,
                    .along = N_VGetArrayPointer(ida->displaced)};
    int status = mbsr_closures_weight(ida->model, s.w);
    if (!status) status = mbsr_closure_row_kind(ida->model, ida->data, 0, NULL, &s.lever);
    if (!status) note_kinds(&s);
    for (int k = 0; k < rows; ++k) e[k] = 0.0;
    for (int c = 0; c < mbsr_model_closures(ida->model) && !status; ++c) {
        int row, own, held_row, held;
        mbsr_closure_indices(ida->model, c, &row, &own, &held_row, &held);
        for (int k = 0; k < own && !status; ++k) {
            double impulse = 0.0, shift = 0.0;
            status = scale_row(&s, row + k, &impulse, &shift);
            const bool stiff = mbsr_closure_stiffness(ida->model, c, k) > 0.0; /* a force */
            atol[first + row + k] = stiff ? impulse / ida->tol.time : impulse;
            if (k < held) atol[first + rows + held_row + k] = shift;
        }
    }
    return status;
}

void mbsri_ida_allow_rounding(mbsr_ida *ida)
{
    static const double rounding = 1e-15;
    const int first = mbsri_ida_loops(ida);
    double *atol = N_VGetArrayPointer(ida->tol.atol), lever = 0.0;
    for (int c = 0; c < mbsr_model_closures(ida->model); ++c) {
        int row, own;
        mbsr_closure_indices(ida->model, c, &row, &own, NULL, NULL);
        for (int k = 0; k < own; ++k) {
            const double stiffness = mbsr_closure_stiffness(ida->model, c, k);
            mbsr_coordinate_kind kind;
            if (!(stiffness > 0.0)) continue;
            if (mbsr_closure_row_kind(ida->model, ida->data, row + k, &kind,
                                      lever > 0.0 ? NULL : &lever))
                return;
            const double size = kind == MBSR_COORDINATE_TRANSLATION ? lever : 1.0;
            atol[first + row + k] = fmax(atol[first + row + k], rounding * stiffness * size);
        }
    }
}

/* ---- springs that share a force ---- */

static bool springs_share(mbsr_ida *ida)
{
    if (mbsr_closures_redundant(ida->model, ida->data, ida->dropped)) return false;
    for (int c = 0; c < mbsr_model_closures(ida->model); ++c) {
        int row, rows;
        mbsr_closure_indices(ida->model, c, &row, &rows, NULL, NULL);
        for (int k = 0; k < rows; ++k) {
            if (ida->dropped[row + k] && mbsr_closure_stiffness(ida->model, c, k) > 0.0)
                return true;
        }
    }
    return false;
}

void mbsri_ida_take_care(mbsr_ida *ida)
{
    mbsri_stiff *stiff = mbsri_stiff_of(ida->nonlinear);
    mbsri_ida_judge_matrix(ida);
    stiff->test = ida->tol.scales ? MBSRI_TEST_MOVED : MBSRI_TEST_PLAIN;
    stiff->control.care = springs_share(ida) ? MBSRI_CARE_ALWAYS : MBSRI_CARE_BY_SIGNS;
    stiff->control.looks = false; /* loop forces take what momenta show */
}

/* ---- while it runs ---- */

/* A report on the state y of the driver; false where there is none. */
static bool report_on(mbsr_ida *ida, N_Vector y, double t, mbsr_closure_report *report)
{
    double *q = N_VGetArrayPointer(ida->displaced);
    return mbsr_dae_unpack(ida->model, ida->data, ida->opt.form, t, N_VGetArrayPointer(y), q,
                           q + mbsr_model_nq(ida->model)) == MBSR_OK &&
           mbsr_closures_report(ida->model, ida->data, t, q, report, NULL, NULL) == MBSR_OK;
}

/* What `stretch` was where IDA started; 0 where some direction is never held. */
static double usual_stretch(mbsr_ida *ida)
{
    mbsr_closure_report report;
    const bool known = report_on(ida, ida->run.first_y, ida->run.present, &report);
    return known && report.stretch > 1e-6 ? report.stretch : 0.0;
}

/* MBSR_LOOP_SINGULAR into `error` where the report shows a singular position; else MBSR_OK. */
static int blame(mbsr_ida *ida, mbsr_error *error, const char *prefix, double t,
                 const mbsr_closure_report *report)
{
    int closure = 0;
    const char *row = "";
    if (report->weakest >= 0 && report->weakest_pivot <= SINGULAR) {
        mbsr_closure_of_row(ida->model, report->weakest, &closure, NULL, &row);
        return mbsri_ida_refuse(error, MBSR_LOOP_SINGULAR,
                                "%sat t = %.10g closure %d '%.40s' is near a singular "
                                "position: its row %s depends on the others (pivot %.2g, %d of %d "
                                "rows independent); the motion may branch here",
                                prefix, t, closure, mbsr_closure_name(ida->model, closure), row,
                                report->weakest_pivot, report->independent, report->rows);
    }
    if (report->stretched < 0 || !(report->stretch <= STRETCHED * usual_stretch(ida)))
        return MBSR_OK;
    mbsr_closure_of_row(ida->model, report->stretched, &closure, NULL, &row);
    return mbsri_ida_refuse(
        error, MBSR_LOOP_SINGULAR,
        "%sat t = %.10g the bodies without mass that closure %d "
        "'%.40s' holds are stretched (singular value %.2g along %s): beyond is an "
        "impact; give them mass or make the closure stiff",
        prefix, t, closure, mbsr_closure_name(ida->model, closure), report->stretch, row);
}

int mbsri_ida_blame_loops(mbsr_ida *ida)
{
    mbsr_closure_report report;
    if (mbsr_model_rows(ida->model) == 0 || !ida->run.failed ||
        !report_on(ida, ida->y, ida->run.present, &report))
        return MBSR_OK;
    return blame(ida, &ida->error, "mbsr_ida_advance: ", ida->run.present, &report);
}

/* Steps between two looks, and what part of the way between others is none. */
enum { LOOK = 200 };
static const double NO_WAY = 1e-6;

int mbsri_ida_watch_loops(mbsr_ida *ida, N_Vector y)
{
    long steps = 0;
    double t = 0.0;
    mbsr_closure_report report;
    if (mbsr_model_rows(ida->model) == 0) return MBSR_OK;
    IDAGetNumSteps(ida->memory, &steps);
    IDAGetCurrentTime(ida->memory, &t);
    if (steps == 0 || steps < ida->look.steps) {
        ida->look.steps = steps;
        ida->look.at = t;
        ida->look.longest_way = 0.0;
    }
    if (steps < ida->look.steps + LOOK) return MBSR_OK;
    const double way = fabs(t - ida->look.at);
    const bool stuck = way < NO_WAY * ida->look.longest_way;
    ida->look.steps = steps;
    ida->look.at = t;
    ida->look.longest_way = fmax(ida->look.longest_way, way);
    if (!stuck || !report_on(ida, y, t, &report)) return MBSR_OK;
    ida->failing.callback = blame(ida, &ida->failing.failure, "", t, &report);
    return ida->failing.callback;
}

/* The position row of closure c called `name` has opened. */
static int refuse_open_row(mbsr_ida *ida, mbsr_error *error, double t, int closure,
                           const char *name, double gap, double limit)
{
    return mbsri_ida_refuse(error, MBSR_LOOP_OPEN,
                            "%sat t = %.10g row %s of closure %d '%.40s', redundant "
                            "at the start and left out, is open by %.3g (more than %.3g): the "
                            "mechanism's measures are not those that make it redundant",
                            error == &ida->error ? "mbsr_ida_advance: " : "", t, name, closure,
                            mbsr_closure_name(ida->model, closure), gap, limit);
}

/* An absolute tolerance given for a kind of coordinates, or else the one for all. */
static double or_all(const mbsr_ida *ida, double of_kind)
{
    return of_kind > 0.0 ? of_kind : ida->opt.atol;
}

/* The gap of a row, of all, from which it counts as open, a thousand tolerances; `gap` is looked at
 * first. */
static double limit_of(mbsr_ida *ida, int row, double gap)
{
    static const double many = 1e3;
    const double angle = or_all(ida, ida->opt.atol_angle),
                 length = or_all(ida, ida->opt.atol_length),
                 least = fmin(ida->opt.atol, fmin(angle, length)), rtol = ida->opt.rtol;
    mbsr_coordinate_kind kind;
    double lever;
    if (gap <= many * least || mbsr_closure_row_kind(ida->model, ida->data, row, &kind, &lever))
        return INFINITY;
    switch (kind) {
    case MBSR_COORDINATE_ROTATION: return many * fmax(angle, rtol);
    case MBSR_COORDINATE_TRANSLATION: return many * fmax(length, rtol * lever);
    case MBSR_COORDINATE_OTHER: break;
    }
    return many * fmax(ida->opt.atol, rtol);
}

static int check_gaps(mbsr_ida *ida, mbsr_error *error, double t, const double *y, const double *g)
{
    const double *spring = y + mbsri_ida_loops(ida);
    for (int c = 0; c < mbsr_model_closures(ida->model); ++c) {
        int row, held_row, held;
        mbsr_closure_indices(ida->model, c, &row, NULL, &held_row, &held);
        for (int k = 0; k < held; ++k) {
            const char *name = "";
            const double stiffness = mbsr_closure_stiffness(ida->model, c, k),
                         length = stiffness > 0.0 ? spring[row + k] / stiffness : 0.0,
                         gap = g[held_row + k] - length;
            if (!ida->dropped[row + k]) continue;
            const double limit = limit_of(ida, row + k, fabs(gap));
            if (fabs(gap) <= limit) continue;
            mbsr_closure_of_row(ida->model, row + k, NULL, NULL, &name);
            return refuse_open_row(ida, error, t, c, name, gap, limit);
        }
    }
    return MBSR_OK;
}

/* MBSR_LOOP_OPEN into `error` where a row that is left out has opened in the state y at t. */
static int check_dropped(mbsr_ida *ida, mbsr_error *error, double t, const double *y)
{
    const int rows = mbsr_model_rows(ida->model), nq = mbsr_model_nq(ida->model);
    double *g = N_VGetArrayPointer(ida->work), *q = N_VGetArrayPointer(ida->displaced);
    bool any = false;
    if (rows == 0 || mbsr_closures_redundant(ida->model, ida->data, ida->dropped)) return MBSR_OK;
    for (int k = 0; k < rows; ++k) any = any || ida->dropped[k] != 0;
    if (!any || mbsr_dae_unpack(ida->model, ida->data, ida->opt.form, t, y, q, q + nq) ||
        mbsr_stage_positions(ida->model, ida->data, t, q) ||
        mbsr_closures_gap(ida->model, ida->data, g))
        return MBSR_OK;
    return check_gaps(ida, error, t, y, g);
}

int mbsri_ida_check_dropped(mbsr_ida *ida)
{
    return check_dropped(ida, &ida->error, ida->run.present, N_VGetArrayPointer(ida->y));
}

int mbsri_ida_watch_dropped(mbsr_ida *ida, double t, N_Vector y)
{
    const int status = check_dropped(ida, &ida->failing.failure, t, N_VGetArrayPointer(y));
    if (status) ida->failing.callback = status;
    return status;
}
