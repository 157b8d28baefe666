/* Positions that close loops.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * min |W^(1/2) x|^2 towards g(q + G x) = 0 by Levenberg-Marquardt steps: with A = S C_h W^(-1/2),
 * where W and S make numbers of joint coordinates and gaps (closing.h),
 *
 *   (A^T A + mu |A|^2 1) z = -A^T S g,    x = W^(-1/2) z,
 *
 * as a least-squares problem in (A; sqrt(mu) |A| 1). mu falls tenfold with each step that makes the
 * gaps smaller and rises with each that does not; steps turn by 1 rad at most, and move by the
 * longest lever or the gaps, whichever is more. It ends
 *
 *   closed      every gap is below the tolerance
 *   open        |A^T S g| <= 1e-6 |A| |S g|: all ways make the gaps larger; or the gaps have
 *       stopped to
 *               fall, by 1e-6 of them in ten steps: so does a mechanism that is stretched */
#include "loops/assemble.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>
#include <string.h>

typedef struct search {
    mbsri_dense *w;
    const mbsr_assembly_opt *opt;
    double t, mu;
    double norm, open; /* of the gaps (closing.h), and the widest */
    double before[10]; /* of the last steps */
} search;

int mbsri_displace(const mbsr_model *m, mbsr_data *d, const double *q, double step, const double *x,
                   double *to)
{
    mbsri_gather(m, x, d->u);
    const int status = mbsri_coordinate_rates(m, d, to);
    if (status) return status;
    for (int k = 0; k < m->nq; ++k) to[k] = q[k] + step * to[k];
    return mbsri_normalise(m, d, to);
}

int mbsri_assembly_gaps(const mbsri_dense *w, double *g)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const int status = mbsri_closure_gaps(w->m, w->d, g);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->held; ++k) {
            const int row = c->held_row + k;
            g[row] = mbsri_is_asked(w, c, k) ? g[row] - w->offset[row] : 0.0;
        }
    }
    return status;
}

static int evaluate(const search *s, const double *q, double *g)
{
    const int status = mbsri_positions(s->w->m, s->w->d, s->t, q);
    return status ? status : mbsri_assembly_gaps(s->w, g);
}

/* A at the positions of the data: position rows among C, in the measure of closing.h; returns |A|.
 * Its leading dimension is held + n. */
static double fill(const search *s)
{
    const mbsri_dense *w = s->w;
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const size_t stride = (size_t)(w->held + w->n), rows = (size_t)w->rows;
    double square = 0.0;
    mbsri_zero(stride * (size_t)w->n, w->A);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->held; ++k) {
            for (int j = 0; j < w->n && mbsri_is_asked(w, c, k); ++j) {
                const double C = w->C[(size_t)j * rows + (size_t)(c->row + k)],
                             value = C * w->closing.give[j] / w->closing.gap[c->held_row + k];
                w->A[(size_t)j * stride + (size_t)(c->held_row + k)] = value;
                square += value * value;
            }
        }
    }
    return sqrt(square);
}

/* |A^T g| / (|A| |g|). */
static double slope(const search *s, double size)
{
    const mbsri_dense *w = s->w;
    double square = 0.0;
    for (int j = 0; j < w->n; ++j) {
        const double *column = w->A + (size_t)j * (size_t)(w->held + w->n);
        double along = 0.0;
        for (int k = 0; k < w->held; ++k) along += column[k] * w->g[k] / w->closing.gap[k];
        square += along * along;
    }
    return sqrt(square) / fmax(size * s->norm, 1e-300);
}

/* The step x (n) at the present mu. */
static int find_step(const search *s, double size)
{
    mbsri_dense *w = s->w;
    const int r = w->held + w->n;
    int rank;
    fill(s);
    for (int j = 0; j < w->n; ++j)
        w->A[(size_t)j * (size_t)r + (size_t)(w->held + j)] = sqrt(s->mu) * size;
    mbsri_zero((size_t)(r + w->n), w->b);
    for (int k = 0; k < w->held; ++k) w->b[k] = -w->g[k] / w->closing.gap[k];
    if (mbsri_lapack_gelsy(r, w->n, w->A, w->b, 1e-13, w->pivots, &rank, w->work, w->lwork))
        return mbsri_fail(&w->d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
                          "%s: a least-squares problem of the assembly failed", w->function);
    for (int j = 0; j < w->n; ++j) w->x[j] = w->b[j] * w->closing.give[j];
    return MBSR_OK;
}

/* One step from q, whose gaps are g; *better: whether q was moved. */
static int step(search *s, double *q, bool *better)
{
    mbsri_dense *w = s->w;
    double size;
    int status = mbsri_dense_rows(w); /* uses g */
    if (!status) status = mbsri_assembly_gaps(w, w->g);
    if (status) return status;
    size = fill(s);
    *better = false;
    for (int tries = 0; tries < 30 && !*better; ++tries) {
        status = find_step(s, size);
        const double share = mbsri_closing_share(w->m, &w->closing, w->x, s->norm);
        if (!status) status = mbsri_displace(w->m, w->d, q, share, w->x, w->q_try);
        if (!status) status = evaluate(s, w->q_try, w->y);
        if (status < 0) return status;
        const double norm = status ? INFINITY : mbsri_closing_norm(w->m, &w->closing, w->y);
        if (norm < s->norm) {
            mbsri_copy((size_t)w->m->nq, w->q_try, q);
            s->norm = norm;
            if (share >= 1.0) s->mu = fmax(0.1 * s->mu, 1e-16);
            *better = true;
        } else {
            if (s->mu >= 1e6) break;
            s->mu = fmax(s->mu, 1e-12) * 10.0;
            status = mbsri_positions(w->m, w->d, s->t, q);
            if (status) return status;
        }
    }
    return MBSR_OK;
}

/* "body 3", or "the ground". */
static const char *side(const mbsri_closure *c, int k, char text[24])
{
    const int body = k < c->def.bodies ? c->def.body[k] : MBSR_GROUND;
    if (body < 0) return "the ground";
    mbsri_print(text, 24, "body %d", body);
    return text;
}

/* The widest gap of a closure, in the measure of closing.h. */
static double open_by(const search *s, const mbsri_closure *c)
{
    const mbsri_dense *w = s->w;
    double widest = 0.0;
    for (int k = c->held_row; k < c->held_row + c->held; ++k)
        widest = fmax(widest, fabs(w->g[k]) / w->closing.gap[k]);
    return widest;
}

/* The loops that are open, widest first in info, all in the text. */
static int refuse(const search *s, const mbsr_assembly_info *info, double limit)
{
    const mbsr_model *m = s->w->m;
    const mbsri_closure *first = mbsri_all_closures(m);
    char label[MBSRI_LABEL], list[160] = "", one[24], other[24];
    for (int id = 0; id < (int)m->closures.count; ++id) {
        const mbsri_closure *c = first + id;
        const double gap = mbsri_largest(c->held, s->w->g + c->held_row);
        const size_t used = strlen(list);
        if (id == info->closure || !(open_by(s, c) > limit)) continue;
        mbsri_print(list + used, sizeof list - used, "%s%s by %.3g",
                    used ? ", " : "; also open: ", mbsri_closure_label(m, id, label), gap);
    }
    const mbsri_closure *c = first + info->closure;
    return mbsri_fail(&s->w->d->error, MBSR_LOOP_OPEN, c->def.body[0], MBSR_NONE,
                      "%s: %s (%s of %s and %s) stays open by %.9g after %d iterations: "
                      "no position of its "
                      "joints closes it, or start nearer%s",
                      s->w->function, mbsri_closure_label(m, info->closure, label),
                      c->def.table->name, side(c, 0, one), side(c, 1, other), info->gap,
                      info->iterations, list);
}

/* Gaps of q into info, and to s->open in the measure of closing.h; the tolerance that counts. */
static int measure(search *s, const double *q, mbsr_assembly_info *info, double *limit)
{
    const mbsri_dense *w = s->w;
    const mbsri_closure *c = mbsri_all_closures(w->m);
    const int status = evaluate(s, q, w->g);
    if (status) return status;
    info->closure = MBSR_NONE;
    info->gap = mbsri_largest(w->held, w->g);
    *limit = s->opt->tolerance * mbsri_closing_size(w->m, w->d, &w->closing);
    s->open = 0.0;
    for (int id = 0; id < (int)w->m->closures.count; ++id, ++c) {
        const double open = open_by(s, c);
        if (open > *limit && open > s->open) info->closure = id;
        s->open = fmax(s->open, open);
    }
    s->norm = mbsri_closing_norm(w->m, &w->closing, w->g);
    return MBSR_OK;
}

static bool stopped(search *s, int iteration)
{
    double *last = s->before + iteration % 10;
    const bool slow = iteration >= 10 && !(s->norm < *last * (1.0 - 1e-6));
    *last = s->norm;
    return slow;
}

int mbsri_assemble(mbsri_dense *w, double t, double *q, const mbsr_assembly_opt *opt,
                   mbsr_assembly_info *info)
{
    search s = {.w = w, .opt = opt, .t = t, .mu = 1e-3};
    double limit;
    *info = (mbsr_assembly_info){.closure = MBSR_NONE};
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_closing_measure(w->m, w->d, opt, &w->closing);
    if (!status) status = measure(&s, q, info, &limit);
    info->gap_before = info->gap;
    while (!status && info->closure != MBSR_NONE) {
        bool better;
        const double accepted = 1e3 * limit;
        if (info->iterations >= opt->max_iterations || stopped(&s, info->iterations))
            return s.open < accepted ? MBSR_OK : refuse(&s, info, limit);
        status = step(&s, q, &better);
        if (status) return status;
        ++info->iterations;
        status = measure(&s, q, info, &limit);
        if (status || info->closure == MBSR_NONE) break;
        if (!better) return s.open < accepted ? MBSR_OK : refuse(&s, info, limit);
        status = mbsri_dense_rows(w);
        if (!status) status = mbsri_assembly_gaps(w, w->g);
        if (!status && slope(&s, fill(&s)) <= 1e-6) return refuse(&s, info, limit);
    }
    return status;
}
