/* Positions that close loops.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * min |W^(1/2) x|^2 towards g(q + G x) = 0 by Levenberg-Marquardt steps: with A = S C_h W^(-1/2),
 * where W and S make numbers of joint coordinates and gaps (closing.h),
 *
 *   (A^T A + mu |A|^2 1) z = -A^T S g,    x = W^(-1/2) z,
 *
 * which are the equations of fronts/fronts.h for a tree whose only inertias are W, with rows that
 * give way,
 *
 *   W x = C_h^T lambda,    C_h x + mu |A|^2 S^-2 lambda = -g
 *
 * mu begins with the size of the gaps, 1e-3 at most, with next to nothing where they are small,
 * falls tenfold with each step that makes them smaller and rises with each that does not; steps
 * turn by 1 rad at most, and move by the longest lever or the gaps, whichever is more. It ends
 *
 *   closed      every gap is below the tolerance
 *   open        |A^T S g| <= 1e-6 |A| |S g|: all ways make the gaps larger; or the gaps have
 *       stopped to
 *               fall, by 1e-6 of them in ten steps: so does a mechanism that is stretched */
#include "loops/assemble.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "fronts/fronts.h"
#include "model/query.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"

#include <math.h>
#include <string.h>

typedef struct search {
    mbsri_closer *w;
    const mbsr_assembly_opt *opt;
    double t, mu;
    double size;         /* |A| */
    double norm, widest; /* of the gaps (closing.h) */
    double before[10];   /* of the last steps */
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

/* Gaps at the positions of the data, into g (position rows), less what they are to be; loose
 * springs have none. */
static int assembly_gaps(const mbsri_closer *w, double *g)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const int status = mbsri_closure_gaps(w->m, w->d, g);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const int row = c->position_row + k;
            g[row] = mbsri_is_asked(w, c, k) ? g[row] - w->offset[row] : 0.0;
        }
    }
    return status;
}

static int evaluate_gaps(const search *s, const double *q, double *g)
{
    const int status = mbsri_positions(s->w->m, s->w->d, s->t, q);
    return status ? status : assembly_gaps(s->w, g);
}

/* |A| at the positions of the data, after the derivatives. */
static void find_size(search *s)
{
    const mbsri_closer *w = s->w;
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    double square = 0.0;
    mbsri_row_squares(w->m, w->d, w->closing.give, w->right);
    for (; c < end; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const double gap = w->closing.gap[c->position_row + k];
            if (mbsri_is_asked(w, c, k)) square += w->right[c->row + k] / (gap * gap);
        }
    }
    s->size = sqrt(square);
}

/* |A^T S g| / (|A| |S g|). */
static double slope(const search *s)
{
    const mbsri_closer *w = s->w;
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    double square = 0.0;
    mbsri_zero((size_t)w->m->rows, w->right);
    for (; c < end; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const double gap = w->closing.gap[c->position_row + k];
            w->right[c->row + k] = w->g[c->position_row + k] / (gap * gap);
        }
    }
    mbsri_closure_transpose(w->m, w->d, w->right, w->x);
    for (int j = 0; j < w->m->nu; ++j) {
        const double along = w->x[j] * w->closing.give[j];
        square += along * along;
    }
    return sqrt(square) / fmax(s->size * s->norm, 1e-300);
}

/* Resistances of coordinates that stay are so much larger, and what they do is left out. */
static const double stays = 1e12;

static void find_resistances(mbsri_closer *w)
{
    double most = 0.0, *resist = w->x;
    for (int k = 0; k < w->m->nu; ++k) {
        const double give = w->closing.give[k];
        resist[k] = give > 0.0 ? 1.0 / (give * give) : 0.0;
        most = fmax(most, resist[k]);
    }
    for (int k = 0; k < w->m->nu; ++k) {
        if (!(w->closing.give[k] > 0.0)) resist[k] = stays * (most > 0.0 ? most : 1.0);
    }
    mbsri_gather(w->m, resist, w->resist);
}

/* The step (n) at the present mu, by the derivatives of the rows at the positions of the data. */
static int find_step(const search *s)
{
    mbsri_closer *w = s->w;
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    mbsri_zero((size_t)w->m->rows, w->right);
    for (; c < end; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            const double gap = w->closing.gap[c->position_row + k];
            w->right[c->row + k] = -w->g[c->position_row + k];
            w->compliance[c->row + k] = s->mu * s->size * s->size * gap * gap;
        }
    }
    const int status = mbsri_fronts_factor(w->system, w->resist, w->function);
    if (status) return status;
    mbsri_fronts_solve(w->system, w->zero, w->right, w->step, w->lambda);
    for (int k = 0; k < w->m->nu; ++k) {
        if (!(w->closing.give[k] > 0.0)) w->step[k] = 0.0;
    }
    return MBSR_OK;
}

/* Rows and |A| at the positions of the data. */
static int look(search *s)
{
    const int status = mbsri_closure_jacobians(s->w->m, s->w->d);
    if (!status) find_size(s);
    return status;
}

/* One step from q, whose gaps are g and where the data is; *better: whether q was moved, with the
 * gaps and the data. */
static int step(search *s, double *q, bool *better)
{
    mbsri_closer *w = s->w;
    int status = MBSR_OK;
    *better = false;
    for (int tries = 0; tries < 30 && !*better; ++tries) {
        status = find_step(s);
        if (status) return status;
        const double share = mbsri_closing_share(w->m, &w->closing, w->step, s->norm);
        status = mbsri_displace(w->m, w->d, q, share, w->step, w->q_try);
        if (!status) status = mbsri_positions(w->m, w->d, s->t, w->q_try);
        if (!status) status = assembly_gaps(w, w->g_try);
        if (status < 0) return status;
        const double norm = status ? INFINITY : mbsri_closing_norm(w->m, &w->closing, w->g_try);
        if (norm < s->norm) {
            mbsri_copy((size_t)w->m->nq, w->q_try, q);
            mbsri_copy((size_t)w->m->position_rows, w->g_try, w->g);
            s->norm = norm;
            if (share >= 1.0) s->mu = fmax(0.1 * s->mu, 1e-16);
            *better = true;
        } else {
            status = evaluate_gaps(s, q, w->g);
            if (status || s->mu >= 1e6) return status;
            s->mu = fmax(s->mu, 1e-12) * 10.0;
            status = look(s);
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
    const mbsri_closer *w = s->w;
    double widest = 0.0;
    for (int k = c->position_row; k < c->position_row + c->position_rows; ++k)
        widest = fmax(widest, fabs(w->g[k]) / w->closing.gap[k]);
    return widest;
}

/* The loops that are open, widest first in info, all in the text. */
static int refuse_open_loops(const search *s, const mbsr_assembly_info *info, double limit)
{
    const mbsr_model *m = s->w->m;
    const mbsri_closure *first = mbsri_all_closures(m);
    char label[MBSRI_LABEL], list[160] = "", one[24], other[24];
    for (int id = 0; id < (int)m->closures.count; ++id) {
        const mbsri_closure *c = first + id;
        const double gap = mbsri_largest(c->position_rows, s->w->g + c->position_row);
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

/* Gaps into info, and to s->widest in the measure of closing.h; the tolerance that counts. */
static double measure_gaps(search *s, mbsr_assembly_info *info)
{
    const mbsri_closer *w = s->w;
    const mbsri_closure *c = mbsri_all_closures(w->m);
    const double limit = s->opt->tolerance * mbsri_closing_size(w->m, w->d, &w->closing);
    info->closure = MBSR_NONE;
    info->gap = mbsri_largest(w->m->position_rows, w->g);
    s->widest = 0.0;
    for (int id = 0; id < (int)w->m->closures.count; ++id, ++c) {
        const double open = open_by(s, c);
        if (open > limit && open > s->widest) info->closure = id;
        s->widest = fmax(s->widest, open);
    }
    s->norm = mbsri_closing_norm(w->m, &w->closing, w->g);
    return limit;
}

static bool stopped(search *s, int iteration)
{
    double *last = s->before + iteration % 10;
    const bool slow = iteration >= 10 && !(s->norm < *last * (1.0 - 1e-6));
    *last = s->norm;
    return slow;
}

static int search_closed(search *s, double *q, mbsr_assembly_info *info)
{
    static const double near = 1e-2, hardly = 1e-5;
    int status = evaluate_gaps(s, q, s->w->g);
    if (status) return status;
    double limit = measure_gaps(s, info);
    info->gap_before = info->gap;
    s->mu = s->norm > near ? fmin(s->mu, s->norm) : hardly * s->norm;
    if (info->closure != MBSR_NONE) status = look(s);
    while (!status && info->closure != MBSR_NONE) {
        bool better = false;
        const double accepted = 1e3 * limit;
        if (info->iterations >= s->opt->max_iterations || stopped(s, info->iterations))
            return s->widest < accepted ? MBSR_OK : refuse_open_loops(s, info, limit);
        status = step(s, q, &better);
        if (status) return status;
        ++info->iterations;
        limit = measure_gaps(s, info);
        if (info->closure == MBSR_NONE) break;
        if (!better) return s->widest < accepted ? MBSR_OK : refuse_open_loops(s, info, limit);
        status = look(s);
        if (!status && slope(s) <= 1e-6) return refuse_open_loops(s, info, limit);
    }
    return status;
}

int mbsri_assemble(mbsri_closer *w, double t, double *q, const mbsr_assembly_opt *opt,
                   mbsr_assembly_info *info)
{
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    search s = {.w = w, .opt = opt, .t = t, .mu = 1e-3};
    *info = (mbsr_assembly_info){.closure = MBSR_NONE};
    int status = mbsri_positions(w->m, w->d, t, q);
    if (!status) status = mbsri_closing_measure(w->m, w->d, opt, &w->closing);
    if (!status) status = mbsri_fronts_open(w->system, w->m, w->d, true, w->function);
    if (!status) {
        find_resistances(w);
        w->system->compliance = w->compliance;
        for (; c < end; ++c) {
            for (int k = 0; k < c->rows; ++k)
                w->system->left_out[c->row + k] = k >= c->position_rows || !mbsri_is_asked(w, c, k);
        }
        status = search_closed(&s, q, info);
    }
    mbsri_fronts_close(w->system);
    return status;
}

int mbsri_closer_open(mbsri_closer *w, const mbsr_model *m, mbsr_data *d, const char *function)
{
    const size_t nu = (size_t)m->nu, nq = (size_t)m->nq, rows = (size_t)m->rows,
                 gaps = (size_t)m->position_rows, numbers = 5 * nu + nq + 3 * rows + 4 * gaps;
    *w = (mbsri_closer){.m = m, .d = d, .function = function};
    w->memory = mbsri_allocate(&m->allocator,
                               sizeof *w->system + numbers * sizeof(double) + rows * sizeof(bool));
    if (!w->memory)
        return mbsri_fail(&d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d joint rates and %d rows of closures", function,
                          m->nu, m->rows);
    w->system = w->memory;
    *w->system = (mbsri_fronts){.m = m, .d = d};
    w->offset = (double *)(void *)(w->system + 1);
    w->closing.gap = w->offset + gaps;
    w->g = w->closing.gap + gaps;
    w->g_try = w->g + gaps;
    w->closing.give = w->g_try + gaps;
    w->x = w->closing.give + nu;
    w->resist = w->x + nu;
    w->zero = w->resist + nu;
    w->step = w->zero + nu;
    w->right = w->step + nu;
    w->lambda = w->right + rows;
    w->compliance = w->lambda + rows;
    w->q_try = w->compliance + rows;
    w->let_go = (bool *)(w->q_try + nq);
    mbsri_zero(numbers, w->offset);
    for (size_t k = 0; k < rows; ++k) w->let_go[k] = false;
    return MBSR_OK;
}

void mbsri_closer_close(mbsri_closer *w)
{
    if (w->m) mbsri_release(&w->m->allocator, w->memory);
    w->memory = NULL;
}
