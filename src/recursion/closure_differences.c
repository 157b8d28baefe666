/* Derivatives of closures by differences, where the table has none.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A state displaced by `step` along velocities (V, u): the bodies' poses turned by exp(step w) and
 * moved by step v, joint coordinates by step u, time by step tdot. Along a path of constant (V, u)
 * all accelerations are zero, so that the second derivative of g along it is the bias. */
#include "recursion/closure_differences.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/space3.h"
#include "recursion/closure_rows.h"
#include "recursion/spans.h"

/* The bodies of a closure at a displaced state. */
typedef struct displaced {
    mbsri_closure_view view;
    double pose[MBSR_CLOSURE_BODIES + 1][MBSR_POSE_SIZE];
} displaced;

/* R <- exp(step [w]x) R. */
static void turn_by_exponential(const double *w, double step, double R[9])
{
    double axis[3], now[9], by[9];
    const double angle = step * mbsri_norm3(w);
    mbsri_copy(9, R, now);
    if (!mbsri_direction3(w, axis)) return;
    const mbsr_frame frame = mbsr_frame_rotated(NULL, axis, angle);
    mbsri_copy(9, frame.R, by);
    mbsri_multiply3(by, now, R);
}

static void displace_body(const mbsr_force_body *body, const double *V, double step, double *pose)
{
    mbsri_copy((size_t)body->np, body->p, pose);
    switch (body->space) {
    case MBSR_SPACE_SPATIAL:
        turn_by_exponential(V, step, pose + MBSR_POSE_R);
        mbsri_add3(step, V + 3, pose + MBSR_POSE_X);
        break;
    case MBSR_SPACE_PLANAR:
    case MBSR_SPACE_POINT:
        for (int k = 0; k < body->d; ++k) pose[k] += step * V[k];
        break;
    default: break;
    }
}

/* x: velocities in the order of the columns; those of a root at rest are none. */
static void displace_bodies(const mbsri_closure *c, const mbsri_closure_view *view, const double *x,
                            double step, double tdot, displaced *to)
{
    to->view = *view;
    to->view.args.body = to->view.body;
    to->view.args.t += step * tdot;
    for (int k = 0; k < c->bodies; ++k) {
        mbsr_force_body *body = to->view.body + k;
        if (c->column[k] < 0) continue;
        const double *V = x + c->column[k];
        if (body->space != MBSR_SPACE_GENERAL) {
            displace_body(view->body + k, V, step, to->pose[k]);
            body->p = to->pose[k];
        }
        if (!(c->def.table->flags & MBSR_CLOSURE_JOINTS) || !body->q || body->n != body->nq)
            continue;
        double *q = view->q + c->column[k];
        for (int j = 0; j < body->n; ++j) q[j] = view->body[k].q[j] + step * V[body->d + j];
        body->q = q;
    }
}

/* Derivative of g along x and tdot, into `slope` (held numbers), where g changes over `span` times
 * these; g: as many of scratch. */
static int slope_along(const mbsri_closure *c, const mbsri_closure_view *view, const double *x,
                       double tdot, double span, double *g, double *slope)
{
    displaced at;
    const double h = mbsri_difference_step(0.0, span);
    mbsri_zero((size_t)c->position_rows, slope);
    for (int l = 0; l < 4; ++l) {
        displace_bodies(c, view, x, mbsri_difference_place(l) * h, tdot, &at);
        mbsri_zero((size_t)c->position_rows, g);
        const int status = mbsri_closure_position(c, &at.view.args, g);
        if (status) return status;
        for (int k = 0; k < c->position_rows; ++k)
            slope[k] += mbsri_difference_weight(l) * g[k] / (12.0 * h);
    }
    return MBSR_OK;
}

/* Derivatives of g with respect to `count` velocities from column `at` on, those of V or of u of
 * body i. */
static int difference_columns(const mbsr_model *m, const mbsri_closure *c,
                              const mbsri_closure_view *view, int i, bool joint, int at,
                              double *work, double *C)
{
    const mbsri_spans s = mbsri_spans_of(m, &c->def.table->scales);
    const mbsri_body *b = m->body + i;
    double g[MBSR_CLOSURE_ROWS];
    for (int l = 0; l < (joint ? b->n : b->d); ++l) {
        const int k = at + l;
        const double span =
            joint ? mbsri_coordinate_span(&s, m, b, true, l) : mbsri_pose_span(&s, b, l);
        work[k] = 1.0;
        const int status =
            slope_along(c, view, work, 0.0, span, g, C + (size_t)k * (size_t)c->rows);
        work[k] = 0.0;
        if (status) return status;
    }
    return MBSR_OK;
}

int mbsri_closure_slopes(const mbsr_model *m, const mbsri_closure *c,
                         const mbsri_closure_view *view, double *work, double *C)
{
    const bool joints = (c->def.table->flags & MBSR_CLOSURE_JOINTS) != 0;
    int status = MBSR_OK;
    mbsri_zero((size_t)c->columns, work);
    for (int k = 0; k < c->bodies && !status; ++k) {
        const int i = c->body[k], at = c->column[k];
        if (at < 0) continue;
        status = difference_columns(m, c, view, i, false, at, work, C);
        if (!status && joints)
            status = difference_columns(m, c, view, i, true, at + m->body[i].d, work, C);
    }
    return status;
}

int mbsri_closure_drift(const mbsr_model *m, const mbsri_closure *c, const mbsri_closure_view *view,
                        double *work, double *rate)
{
    const mbsri_spans s = mbsri_spans_of(m, &c->def.table->scales);
    double g[MBSR_CLOSURE_ROWS];
    if (c->position_rows == 0) return MBSR_OK;
    mbsri_zero((size_t)c->columns, work);
    return slope_along(c, view, work, 1.0, 1.0 / mbsri_span_rate(&s), g, rate);
}

/* Velocities of the bodies in the order of the columns; returns the rate at which they change the
 * state. */
static double gather_velocities(const mbsr_model *m, const mbsri_closure *c,
                                const mbsri_closure_view *view, double *x)
{
    const mbsri_spans s = mbsri_spans_of(m, &c->def.table->scales);
    double speed = mbsri_span_rate(&s);
    mbsri_zero((size_t)c->columns, x);
    for (int k = 0; k < c->bodies; ++k) {
        const mbsr_force_body *body = view->body + k;
        const mbsri_body *b = m->body + c->body[k];
        if (c->column[k] < 0) continue;
        if (!mbsri_is_coupling(c)) { /* whose data may have no V */
            mbsri_copy((size_t)body->d, body->V, x + c->column[k]);
            speed = fmax(speed, mbsri_twist_rate(&s, b, body->V));
        }
        if (!(c->def.table->flags & MBSR_CLOSURE_JOINTS) || !body->u) continue;
        mbsri_copy((size_t)body->n, body->u, x + c->column[k] + body->d);
        for (int l = 0; l < body->n; ++l)
            speed = fmax(speed, fabs(body->u[l]) / mbsri_coordinate_span(&s, m, b, true, l));
    }
    return speed;
}

/* Second differences of the position rows along the motion: of what they are beside where it is, so
 * that they are zero where nothing moves. */
static int second(const mbsri_closure *c, const mbsri_closure_view *view, const double *x, double h,
                  double *bias)
{
    static const double place[] = {0.0, 1.0, -1.0, 2.0, -2.0},
                        weight[] = {0.0, 16.0, 16.0, -1.0, -1.0};
    displaced at;
    double g[MBSR_CLOSURE_ROWS], here[MBSR_CLOSURE_ROWS];
    for (int l = 0; l < 5; ++l) {
        double *to = l == 0 ? here : g;
        displace_bodies(c, view, x, place[l] * h, 1.0, &at);
        mbsri_zero((size_t)c->position_rows, to);
        const int status = mbsri_closure_position(c, &at.view.args, to);
        if (status) return status;
        for (int k = 0; k < c->position_rows && l > 0; ++k)
            bias[k] += weight[l] * (g[k] - here[k]) / (12.0 * h * h);
    }
    return MBSR_OK;
}

int mbsri_closure_curvature(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                            const mbsri_closure_view *view, double *bias)
{
    displaced at;
    double *x = d->closure_x + m->most.columns, rate[MBSR_CLOSURE_ROWS];
    const double speed = gather_velocities(m, c, view, x);
    mbsri_zero((size_t)c->rows, bias);
    if (!c->def.table->jacobian) return second(c, view, x, 0x1p-8 / speed, bias);
    const double h = mbsri_difference_step(0.0, 1.0 / speed);
    double *C = d->closure_D;
    for (int l = 0; l < 4; ++l) {
        displace_bodies(c, view, x, mbsri_difference_place(l) * h, 1.0, &at);
        const mbsr_closure_jacobian out = {C, c->rows, c->columns, c->column};
        mbsri_zero((size_t)c->rows * (size_t)c->columns, C);
        int status = mbsri_closure_jacobian(c, &at.view.args, &out);
        mbsri_zero((size_t)c->rows, rate);
        if (!status)
            status = c->def.table->drift ? mbsri_closure_table_drift(c, &at.view.args, rate)
                                         : mbsri_closure_drift(m, c, &at.view, d->closure_x, rate);
        if (status) return status;
        mbsri_ax(c->rows, c->columns, 1.0, C, x, rate);
        for (int k = 0; k < c->rows; ++k)
            bias[k] += mbsri_difference_weight(l) * rate[k] / (12.0 * h);
    }
    return MBSR_OK;
}

/* C, C^T lambda in f and C V + g_t in rate at a displaced state, with the velocities of the view.
 */
static int loaded(const mbsr_model *m, const mbsri_closure *c, const mbsri_closure_view *view,
                  const double *lambda, const double *V, double *work, double *C, double *f,
                  double *rate)
{
    const mbsr_closure_table *table = c->def.table;
    const mbsr_closure_jacobian out = {C, c->rows, c->columns, c->column};
    mbsri_zero((size_t)c->rows * (size_t)c->columns, C);
    mbsri_zero((size_t)c->columns, f);
    mbsri_zero((size_t)c->rows, rate);
    int status = table->jacobian ? mbsri_closure_jacobian(c, &view->args, &out)
                                 : mbsri_closure_slopes(m, c, view, work, C);
    if (!status)
        status = table->drift ? mbsri_closure_table_drift(c, &view->args, rate)
                              : mbsri_closure_drift(m, c, view, work, rate);
    mbsri_atx(c->rows, c->columns, 1.0, C, lambda, f);
    mbsri_ax(c->rows, c->columns, 1.0, C, V, rate);
    return status;
}

int mbsri_closure_tangent(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                          const double *lambda, double *work, double *S, double *slope)
{
    const size_t columns = (size_t)c->columns, rows = (size_t)c->rows;
    const mbsri_spans spans = mbsri_spans_of(m, &c->def.table->scales);
    double *x = work, *V = x + columns, *q = V + columns, *f = q + columns, *C = f + columns,
           rate[MBSR_CLOSURE_ROWS];
    mbsri_closure_view view;
    mbsri_view_closure(m, d, c, true, &view);
    view.q = q;
    (void)gather_velocities(m, c, &view, V);
    mbsri_zero(columns, x);
    mbsri_zero(columns * columns, S);
    mbsri_zero(rows * columns, slope);
    for (int k = 0; k < c->bodies; ++k) {
        const mbsri_body *b = m->body + c->body[k];
        const int joints = c->def.table->flags & MBSR_CLOSURE_JOINTS ? b->n : 0;
        for (int l = 0; l < b->d + joints && c->body[k] > 0; ++l) {
            const double span = l < b->d ? mbsri_pose_span(&spans, b, l)
                                         : mbsri_coordinate_span(&spans, m, b, true, l - b->d);
            /* differences of differences are taken over longer steps */
            const double h = c->def.table->jacobian ? mbsri_difference_step(0.0, span)
                                                    : 0x1p-8 * mbsri_binary(span);
            const size_t at = (size_t)(c->column[k] + l);
            for (int step = 0; step < 4; ++step) {
                displaced to;
                x[at] = 1.0;
                displace_bodies(c, &view, x, mbsri_difference_place(step) * h, 0.0, &to);
                x[at] = 0.0;
                to.view.q = d->closure_q;
                const int status = loaded(m, c, &to.view, lambda, V, d->closure_x, C, f, rate);
                const double weight = mbsri_difference_weight(step) / (12.0 * h);
                if (status) return status;
                mbsri_ax(c->columns, 1, weight, f, &(double){1.0}, S + at * columns);
                mbsri_ax(c->rows, 1, weight, rate, &(double){1.0}, slope + at * rows);
            }
        }
    }
    return MBSR_OK;
}

/* What the tangent of accelerations is of, at a state with velocities. */
static int accelerated(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                       const mbsri_closure_view *view, const double *a, double *C, double *out)
{
    const mbsr_closure_table *table = c->def.table;
    const mbsr_closure_jacobian to = {C, c->rows, c->columns, c->column};
    mbsri_zero((size_t)c->rows * (size_t)c->columns, C);
    mbsri_zero((size_t)c->rows, out);
    int status = table->jacobian ? mbsri_closure_jacobian(c, &view->args, &to)
                                 : mbsri_closure_slopes(m, c, view, d->closure_x, C);
    if (!status)
        status = table->bias ? mbsri_closure_table_bias(c, &view->args, out)
                             : mbsri_closure_curvature(m, d, c, view, out);
    mbsri_ax(c->rows, c->columns, 1.0, C, a, out);
    return status;
}

/* The view with velocities changed by step x; V: columns of scratch. */
static void hasten(const mbsri_closure *c, const mbsri_closure_view *view, const double *x,
                   double step, double *V, mbsri_closure_view *to)
{
    *to = *view;
    to->args.body = to->body;
    for (int k = 0; k < c->bodies; ++k) {
        mbsr_force_body *body = to->body + k;
        const int at = c->column[k];
        if (at < 0) continue;
        for (int l = 0; l < body->d; ++l) V[at + l] = view->body[k].V[l] + step * x[at + l];
        body->V = V + at;
        if (!(c->def.table->flags & MBSR_CLOSURE_JOINTS) || !body->u) continue;
        double *u = V + at + body->d;
        for (int l = 0; l < body->n; ++l) u[l] = view->body[k].u[l] + step * x[at + body->d + l];
        body->u = u;
    }
}

/* Column `at` of both. */
static int accelerate_along(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                            const mbsri_closure_view *view, const double *a, int at, double h,
                            double rate, double *work, double *by_place, double *by_rate)
{
    double *x = work, *V = x + c->columns, *C = V + 2 * c->columns, out[MBSR_CLOSURE_ROWS];
    const size_t first = (size_t)at * (size_t)c->rows;
    int status = MBSR_OK;
    for (int step = 0; step < 4 && !status; ++step) {
        const double place = mbsri_difference_place(step), weight = mbsri_difference_weight(step);
        displaced moved;
        mbsri_closure_view faster;
        x[at] = 1.0;
        displace_bodies(c, view, x, place * h, 0.0, &moved);
        hasten(c, view, x, place * rate, V, &faster);
        x[at] = 0.0;
        moved.view.q = faster.q = d->closure_q;
        status = accelerated(m, d, c, &moved.view, a, C, out);
        for (int k = 0; k < c->rows; ++k)
            by_place[first + (size_t)k] += weight * out[k] / (12.0 * h);
        if (!status) status = accelerated(m, d, c, &faster, a, C, out);
        for (int k = 0; k < c->rows; ++k)
            by_rate[first + (size_t)k] += weight * out[k] / (12.0 * rate);
    }
    return status;
}

int mbsri_closure_acceleration_tangent(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c,
                                       const double *a, double *work, double *by_place,
                                       double *by_rate)
{
    const size_t columns = (size_t)c->columns, size = columns * (size_t)c->rows;
    const mbsri_spans spans = mbsri_spans_of(m, &c->def.table->scales);
    const mbsr_closure_table *table = c->def.table;
    mbsri_closure_view view;
    mbsri_view_closure(m, d, c, true, &view);
    const double speed = gather_velocities(m, c, &view, work);
    view.q = work + 2 * columns;
    mbsri_zero(columns, work);
    mbsri_zero(size, by_place);
    mbsri_zero(size, by_rate);
    for (int k = 0; k < c->bodies; ++k) {
        const mbsri_body *b = m->body + c->body[k];
        const int joints = table->flags & MBSR_CLOSURE_JOINTS ? b->n : 0;
        for (int l = 0; l < b->d + joints && c->body[k] > 0; ++l) {
            const double span = l < b->d ? mbsri_pose_span(&spans, b, l)
                                         : mbsri_coordinate_span(&spans, m, b, true, l - b->d),
                         unit = mbsri_binary(span),
                         h = table->jacobian && table->bias ? mbsri_difference_step(0.0, span)
                                                            : 0x1p-8 * unit;
            const int status =
                accelerate_along(m, d, c, &view, a, c->column[k] + l, h, mbsri_binary(span * speed),
                                 work, by_place, by_rate);
            if (status) return status;
        }
    }
    return MBSR_OK;
}
