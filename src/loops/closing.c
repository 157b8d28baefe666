/* In what measure loops are closed: see closing.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Positions are moved by joint rates x as little as may be, in the metric
 *
 *   sum weight_k (x_k / span_k)^2       span: 1 rad, or the longest lever of the mechanism
 *
 * of joint coordinates. It knows neither units nor the tree: of two cuts with the same coordinates
 * (the joint that is cut having its own, on a massless body) it makes the same of the same guess.
 * Gaps are compared likewise, turns to 1 rad, places to the lever, sums of joint coordinates to
 * what the coordinates' spans make of them. */
#include "loops/closing.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "fronts/plan.h"
#include "recursion/rounding.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/pose.h"
#include "recursion/spans.h"

#include <math.h>

/* ---- levers ---- */

/* The distance between the origins of a body and its predecessor: H has [r]x, of norm sqrt(2) |r|,
 * in space, r turned by 90 degrees in the plane. */
static double lever_of_body(const mbsr_data *d, const mbsri_body *b)
{
    const double *H = d->H + b->dp;
    double square = 0.0;
    int angles = 0;
    for (int c = 0; c < b->pred.d; ++c) {
        if (!mbsri_is_angle(b->pred.space, c)) continue;
        ++angles;
        for (int r = 0; r < b->d; ++r) {
            const double x = H[c * b->d + r];
            square += mbsri_is_angle(b->joint.space, r) ? 0.0 : x * x;
        }
    }
    return sqrt(angles > 1 ? 0.5 * square : square);
}

/* The arm at which rows of places act on body l of a closure, the same for two points in whatever
 * direction it is. */
static double lever_of_rows(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c, int l)
{
    const bool space = m->body[c->body[l]].joint.space == MBSR_SPACE_SPATIAL;
    double turns = 0.0, moves = 0.0, turn, move;
    for (int k = 0; k < c->rows; ++k) {
        if (mbsri_row_kind(m, d, c, k) != MBSR_COORDINATE_TRANSLATION) continue;
        mbsri_row_parts(m, d, c, l, k, &turn, &move);
        turns += turn * turn;
        moves += move * move;
    }
    return moves > 0.0 ? sqrt((space ? 1.5 : 2.0) * turns / moves) : 0.0;
}

static double find_lever(const mbsr_model *m, const mbsr_data *d)
{
    const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count;
    double lever = 0.0;
    for (int i = 1; i <= m->bodies; ++i) lever = fmax(lever, lever_of_body(d, m->body + i));
    for (; c < end; ++c) {
        for (int l = 0; l < c->bodies; ++l) lever = fmax(lever, lever_of_rows(m, d, c, l));
    }
    if (!(lever > 0.0)) lever = m->typical.length;
    return lever > 0.0 ? lever : 1.0;
}

/* ---- the measure ---- */

/* What the spans of joint coordinates make of row k of a closure that reads these. */
static double size_of_sum(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c, int k,
                          const mbsri_spans *spans)
{
    double size = 0.0;
    for (int l = 0; l < c->bodies; ++l) {
        const mbsri_body *b = m->body + c->body[l];
        for (int j = 0; j < b->n && c->column[l] >= 0; ++j) {
            const double C =
                d->closure_C[c->at + (size_t)((c->column[l] + b->d + j) * c->rows + k)];
            size = fmax(size, fabs(C) * mbsri_coordinate_span(spans, m, b, true, j));
        }
    }
    return size > 0.0 ? size : 1.0;
}

static void measure_gaps(const mbsr_model *m, const mbsr_data *d, const mbsri_spans *spans,
                         double *gap)
{
    const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count;
    for (; c < end; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            double *size = gap + c->position_row + k;
            switch (mbsri_row_kind(m, d, c, k)) {
            case MBSR_COORDINATE_ROTATION: *size = spans->angle; break;
            case MBSR_COORDINATE_TRANSLATION: *size = spans->length; break;
            case MBSR_COORDINATE_OTHER: *size = size_of_sum(m, d, c, k, spans); break;
            }
        }
    }
}

int mbsri_closing_measure(const mbsr_model *m, mbsr_data *d, const mbsr_assembly_opt *opt,
                          mbsri_closing *c)
{
    const int status = mbsri_closure_jacobians(m, d);
    if (status) return status;
    c->lever = find_lever(m, d);
    const mbsri_spans spans = {.length = c->lever, .angle = 1.0};
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k) {
            const int rate = b->u + k;
            const double weight = opt->weight ? opt->weight[rate] : 1.0;
            const bool stays = opt->keep_position && opt->keep_position[rate];
            c->give[rate] =
                stays ? 0.0 : mbsri_coordinate_span(&spans, m, b, true, k) / sqrt(weight);
        }
    }
    measure_gaps(m, d, &spans, c->gap);
    return MBSR_OK;
}

double mbsri_closing_share(const mbsr_model *m, const mbsri_closing *c, const double *x, double far)
{
    const mbsri_spans spans = {.length = c->lever * fmax(1.0, far), .angle = 1.0};
    double largest = 1.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k)
            largest =
                fmax(largest, fabs(x[b->u + k]) / mbsri_coordinate_span(&spans, m, b, true, k));
    }
    return 1.0 / largest;
}

double mbsri_closing_size(const mbsr_model *m, const mbsr_data *d, const mbsri_closing *c)
{
    double size = 1.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const double *p = d->p + b->p;
        const bool turns = mbsri_turns(b->joint.space);
        const int from = turns ? MBSR_POSE_X : 0,
                  to = turns ? MBSR_POSE_SIZE
                       : b->joint.space == MBSR_SPACE_PLANAR || b->joint.space == MBSR_SPACE_POINT
                           ? 2
                           : 0;
        for (int k = from; k < to; ++k) size = fmax(size, fabs(p[k]) / c->lever);
    }
    return size;
}

double mbsri_closing_norm(const mbsr_model *m, const mbsri_closing *c, const double *g)
{
    double square = 0.0;
    for (int k = 0; k < m->position_rows; ++k) square += (g[k] / c->gap[k]) * (g[k] / c->gap[k]);
    return sqrt(square);
}

/* ---- rows ---- */

/* P += factor x y^T, column by column. */
static void add_dyad(int d, double factor, const double *x, const double *y, double *P)
{
    for (int j = 0; j < d; ++j) {
        for (int i = 0; i < d; ++i) P[j * d + i] += factor * x[i] * y[j];
    }
}

/* The square of row k by a walk from its ends to the body where these meet. */
static double walk_row(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c, int k,
                       const double *give)
{
    double *f = d->closure_V, square = 0.0;
    int head[MBSRI_ENDS], heads = 0;
    for (int l = 0; l < c->bodies; ++l) {
        const mbsri_body *b = m->body + c->body[l];
        if (!mbsri_plan_reads(c, l)) continue;
        const double *C = d->closure_C + c->at + (size_t)(c->column[l] * c->rows + k);
        for (int j = 0; j < b->d; ++j) f[b->v + (size_t)j] += C[j * c->rows];
        for (int j = 0; j < b->n && mbsri_reads_joints(c); ++j) {
            const double part = C[(b->d + j) * c->rows] * give[b->u + j];
            square += part * part;
        }
        head[heads++] = c->body[l];
    }
    for (;;) {
        int i = c->meets;
        for (int l = 0; l < heads; ++l) i = head[l] > i ? head[l] : i;
        if (i == c->meets) break;
        const mbsri_body *b = m->body + i;
        for (int j = 0; j < b->n; ++j) {
            const double part =
                mbsri_dot(b->d, d->J + b->dn + (size_t)(j * b->d), f + b->v) * give[b->u + j];
            square += part * part;
        }
        mbsri_atx(b->d, b->pred.d, -1.0, d->H + b->dp, f + b->v, f + b->pred.v);
        mbsri_zero((size_t)b->d, f + b->v);
        for (int l = 0; l < heads; ++l) head[l] = head[l] == i ? b->parent : head[l];
    }
    mbsri_zero((size_t)m->body[c->meets].d, f + m->body[c->meets].v);
    return square;
}

/* Marks joints between the ends of closures and where these meet, by numbers that are not zero in
 * closure_V. */
static void mark_paths(const mbsr_model *m, double *V)
{
    const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count;
    for (; c < end; ++c) {
        for (int l = 0; l < c->bodies; ++l) {
            if (c->body[l] > 0) V[m->body[c->body[l]].v] += 1.0;
            if (c->meets > 0) V[m->body[c->meets].v] -= 1.0;
        }
    }
    for (int i = m->bodies; i > 0; --i) {
        if (m->body[i].parent > 0) V[m->body[i].pred.v] += V[m->body[i].v];
    }
}

/* P = sum over joints on these paths of give^2 a a^T, a: the motion of a body at a unit rate. P of
 * a body, in Mbar, is zero where no such joint is above it. */
static void spread_motions(const mbsr_model *m, mbsr_data *d, const double *give)
{
    double *V = d->closure_V, moved[MBSR_MAX_D];
    mbsri_zero(m->size.v, V);
    mark_paths(m, V);
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const double *H = d->H + b->dp, *above = d->Mbar + b->pred.dd;
        double *P = d->Mbar + b->dd;
        const bool on_path = V[b->v] != 0.0;
        mbsri_zero((size_t)(b->d * b->d), P);
        V[b->v] = 0.0;
        if (!on_path) continue;
        for (int k = 0; k < b->pred.d && b->parent > 0; ++k) {
            mbsri_zero((size_t)b->d, moved);
            mbsri_ax(b->d, b->pred.d, 1.0, H, above + k * b->pred.d, moved);
            add_dyad(b->d, 1.0, moved, H + k * b->d, P);
        }
        for (int k = 0; k < b->n; ++k) {
            const double *J = d->J + b->dn + (size_t)(k * b->d), own = give[b->u + k];
            add_dyad(b->d, own * own, J, J, P);
        }
    }
}

/* Whether squares of rows at both ends add up: they have no joint in common, not in P either. */
static bool are_apart(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c)
{
    const mbsri_body *meets = m->body + c->meets;
    if (c->bodies > 2 || mbsri_reads_joints(c)) return false;
    if (c->meets == 0) return true;
    return mbsri_largest(meets->d * meets->d, d->Mbar + meets->dd) == 0.0;
}

static double row_by_ends(const mbsr_model *m, const mbsr_data *d, const mbsri_closure *c, int k)
{
    double square = 0.0;
    for (int l = 0; l < c->bodies; ++l) {
        const mbsri_body *b = m->body + c->body[l];
        if (!mbsri_plan_reads(c, l) || c->body[l] == 0) continue;
        const double *C = d->closure_C + c->at + (size_t)(c->column[l] * c->rows + k),
                     *P = d->Mbar + b->dd;
        for (int i = 0; i < b->d; ++i) {
            for (int j = 0; j < b->d; ++j)
                square += C[i * c->rows] * P[i * b->d + j] * C[j * c->rows];
        }
    }
    return fmax(square, 0.0);
}

void mbsri_row_squares(const mbsr_model *m, mbsr_data *d, const double *give, double *square)
{
    const mbsri_closure *c = mbsri_all_closures(m), *end = c + m->closures.count;
    spread_motions(m, d, give);
    for (; c < end; ++c) {
        const bool apart = are_apart(m, d, c);
        for (int k = 0; k < c->rows; ++k)
            square[c->row + k] = apart ? row_by_ends(m, d, c, k) : walk_row(m, d, c, k, give);
    }
}

/* ---- what may be asked ---- */

/* Turns of a quaternion stay together, or not at all. */
static int check_kept(const mbsr_model *m, mbsr_data *d, const int *keep, const char *function)
{
    char label[MBSRI_LABEL];
    for (int i = 1; i <= m->bodies && keep; ++i) {
        const mbsri_body *b = m->body + i;
        const int *own = keep + b->u;
        if (b->nq == b->n || (!own[0] == !own[1] && !own[0] == !own[2])) continue;
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, b->id, MBSR_NONE,
                          "%s: keep_position[%d .. %d]: %s turns by a quaternion, which is kept as "
                          "a whole or not at all",
                          function, b->u, b->u + 2, mbsri_body_label(m, i, label));
    }
    return MBSR_OK;
}

int mbsri_closing_check(const mbsr_model *m, mbsr_data *d, const double *weight, const int *keep,
                        const char *function)
{
    for (int k = 0; k < m->nu && weight; ++k) {
        if (weight[k] > 0.0 && isfinite(weight[k])) continue;
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: weight[%d] is %g, must be positive", function, k, weight[k]);
    }
    return check_kept(m, d, keep, function);
}
