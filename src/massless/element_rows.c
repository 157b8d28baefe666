/* What springs and dampers see of the directions that move no mass: see element_rows.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/element_rows.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "massless/element_power.h"
#include "massless/scales.h"
#include "recursion/kinematics.h"

#include <float.h>
#include <math.h>

/* Of the largest entry, by typical sizes: what rounding leaves of derivatives. */
static const double nothing = 1e-13;

/* How many times its error bound a number has to be, to be told from zero. */
static const double clear = 10.0;

/* ---- derivatives as sums of products ---- */

/* The coordinates of an element in which forces and rates are dual: their places among its rows and
 * columns, and typical sizes. Work of one element, in w->element.factor. */
typedef struct duals {
    int count, *row, *column;
    double *span, *F; /* count; count x count */
    double *size;     /* count: |diagonal of F| before factors were taken */
} duals;

static bool column_is_zero(const mbsri_slopes *s, int column)
{
    const double *x = s->matrix + (size_t)column * (size_t)s->out.rows;
    for (int r = 0; r < s->out.rows; ++r) {
        if (x[r] != 0.0) return false;
    }
    return true;
}

/* A block (n x n, `rows` apart) without what is rounding of its largest entry, by typical sizes. */
static void drop_traces(int n, size_t rows, const double *span, double *A)
{
    double largest = 0.0;
    for (int drop = 0; drop < 2; ++drop) {
        for (int c = 0; c < n; ++c) {
            for (int r = 0; r < n; ++r) {
                double *entry = A + (size_t)c * rows + (size_t)r;
                const double size = fabs(span[c] * *entry * span[r]);
                if (!drop) largest = fmax(largest, size);
                if (size <= nothing * largest && drop) *entry = 0.0;
            }
        }
    }
}

/* F_q G, q' = G u, in place of the derivatives by u, which are done with: for a joint whose
 * coordinates are not as many as its rates. */
static bool turn_to_rates(mbsri_null_space *w, int k, int i)
{
    const mbsri_slopes *s = &w->element.slope;
    const mbsr_force_body *body = w->d->element.bodies + k;
    const mbsri_body *b = w->m->body + i;
    const size_t rows = (size_t)s->out.rows;
    const double *by_q = s->matrix + (size_t)mbsri_q_column(body, s->column[k]) * rows;
    double *by_u = s->matrix + (size_t)mbsri_u_column(body, s->column[k]) * rows,
           *u = w->d->u + b->iu, *given = w->u, *rate = w->rate;
    bool done = true;
    mbsri_copy((size_t)b->n, u, given);
    for (int c = 0; c < b->n && done; ++c) {
        for (int l = 0; l < b->n; ++l) u[l] = l == c;
        done = mbsri_coordinate_rates_of(w->m, w->d, i, rate) == MBSR_OK;
        mbsri_zero(rows, by_u + (size_t)c * rows);
        mbsri_ax(s->out.rows, b->nq, 1.0, by_q, rate, by_u + (size_t)c * rows);
    }
    mbsri_copy((size_t)b->n, given, u);
    drop_traces(b->n, rows, w->scale.span + b->u, by_u + s->row[k] + b->d);
    return done;
}

static bool are_zero(const mbsri_slopes *s, int column, int count)
{
    for (int c = 0; c < count; ++c) {
        if (!column_is_zero(s, column + c)) return false;
    }
    return true;
}

static void add_duals(duals *x, int row, int column, int count, const double *span)
{
    for (int c = 0; c < count; ++c, ++x->count) {
        x->row[x->count] = row + c;
        x->column[x->count] = column + c;
        x->span[x->count] = span[c];
    }
}

/* Typical sizes of V of a body. */
static void twist_spans(const mbsri_null_space *w, const mbsri_body *b, double *span)
{
    const mbsri_spans spans = mbsri_null_spans(w);
    for (int c = 0; c < b->d; ++c) span[c] = mbsri_pose_span(&spans, b, c);
}

/* False where positions are told by other numbers than rates. */
static bool find_duals(mbsri_null_space *w, int bodies, bool velocity, duals *x)
{
    const mbsri_slopes *s = &w->element.slope;
    for (int k = 0; k < bodies; ++k) {
        const mbsr_force_body *body = w->d->element.bodies + k;
        if (s->row[k] < 0) continue;
        const int i = mbsri_element_body(w, k), at = s->column[k];
        const mbsri_body *b = w->m->body + i;
        const int poses = mbsri_pose_size(b);
        if (velocity) {
            twist_spans(w, b, w->element.reaction);
            add_duals(x, s->row[k], mbsri_V_column(body, at), b->d, w->element.reaction);
            add_duals(x, s->row[k] + b->d, mbsri_u_column(body, at), b->n, w->scale.span + b->u);
            continue;
        }
        if (poses == b->d) {
            twist_spans(w, b, w->element.reaction);
            add_duals(x, s->row[k], at, b->d, w->element.reaction);
        } else if (!are_zero(s, at, poses)) {
            return false;
        }
        if (b->nq == b->n) {
            add_duals(x, s->row[k] + b->d, mbsri_q_column(body, at), b->n, w->scale.span + b->u);
        } else if (!are_zero(s, mbsri_q_column(body, at), b->nq)) {
            if (!turn_to_rates(w, k, i)) return false;
            add_duals(x, s->row[k] + b->d, mbsri_u_column(body, at), b->n, w->scale.span + b->u);
        }
    }
    return true;
}

/* F by typical sizes; its largest entry. */
static double load(const mbsri_slopes *s, const duals *x)
{
    double largest = 0.0;
    for (int c = 0; c < x->count; ++c) {
        for (int r = 0; r < x->count; ++r) {
            const double F =
                s->matrix[(size_t)x->column[c] * (size_t)s->out.rows + (size_t)x->row[r]];
            x->F[c * x->count + r] = x->span[c] * F * x->span[r];
            largest = fmax(largest, fabs(x->F[c * x->count + r]));
        }
        x->size[c] = fabs(x->F[c * (x->count + 1)]);
    }
    return largest;
}

/* l (count) of the largest entry on the diagonal: F loses that times l l^T. The entry, 0: none
 * there. gross (count): of what l is the rest, |F_kk F_pp|^(1/2) over the entry. */
static double take_factor(const duals *x, double least, double *l, double *gross)
{
    const int n = x->count;
    int p = 0;
    for (int k = 1; k < n; ++k) {
        if (fabs(x->F[k * n + k]) > fabs(x->F[p * n + p])) p = k;
    }
    const double pivot = x->F[p * n + p];
    if (!(fabs(pivot) > least)) return 0.0;
    for (int k = 0; k < n; ++k) {
        l[k] = x->F[p * n + k] / pivot;
        gross[k] = fmax(sqrt(x->size[k] * x->size[p]) / fabs(pivot), fabs(l[k]));
    }
    for (int c = 0; c < n; ++c) {
        for (int r = 0; r < n; ++r) {
            double *F = x->F + c * n + r;
            *F -= l[r] * pivot * l[c];
            if (fabs(*F) <= least) *F = 0.0;
        }
    }
    return pivot;
}

/* ---- rows ---- */

/* Whether q' and u of a direction are the same where l sees joint coordinates. */
static bool rates_are_own(const mbsri_null_space *w, int bodies, const double *l, int direction)
{
    const double *a = w->direction + (size_t)direction * (size_t)w->m->nu,
                 *rate = w->element.q_rate + (size_t)direction * (size_t)w->m->nq;
    for (int k = 0; k < bodies; ++k) {
        if (w->element.slope.row[k] < 0) continue;
        const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
        for (int c = 0; c < b->n && b->nq == b->n; ++c) {
            if (l[w->element.slope.row[k] + b->d + c] != 0.0 && a[b->u + c] != rate[b->q + c])
                return false;
        }
    }
    return true;
}

/* What l (rows of the derivatives), the rest of gross, sees of the moving directions. */
static bool add_entries(mbsri_null_space *w, int bodies, int moving, mbsri_row *row,
                        const double *l, const double *gross)
{
    const mbsr_model *m = w->m;
    for (int n = 0; n < moving; ++n) {
        const int to = w->element.moving[n];
        const double *a = w->direction + (size_t)to * (size_t)m->nu,
                     *twist = w->twist + (size_t)to * m->size.v;
        double size;
        if (!row->velocity && !rates_are_own(w, bodies, l, to)) return false;
        const double value = mbsri_element_power(w, bodies, a, twist, l, gross, &size),
                     error = MBSRI_ELEMENT_ROUNDING *
                                 (size + mbsri_element_doubt(w, bodies, twist, l)) +
                             mbsri_element_error(w, bodies, to, gross);
        if (size == 0.0 && error == 0.0) continue;
        mbsri_row_entry *entry =
            (mbsri_row_entry *)w->element.entries.data + w->element.entries.count++;
        *entry = (mbsri_row_entry){to, fabs(value) > clear * error ? value : 0.0, error};
        ++row->count;
    }
    return true;
}

/* Whether all derivatives became rows; *memory is false where it is short. */
static bool add_rows(mbsri_null_space *w, int number, int moving, bool velocity, bool *memory)
{
    const mbsri_force *force = (const mbsri_force *)w->m->forces.data + number;
    const mbsr_allocator *allocator = &w->m->allocator;
    const int bodies = force->def.bodies, span = w->element.factor_size;
    duals x = {.row = w->element.factor_places,
               .column = w->element.factor_places + span,
               .span = w->element.factor};
    double *share = x.span + span, *l = w->element.reaction, *gross = l + w->element.slope.out.rows,
           *rest = gross + w->element.slope.out.rows;
    x.size = share + span;
    x.F = x.size + span;
    if (!find_duals(w, bodies, velocity, &x)) return false;
    const double largest = load(&w->element.slope, &x);
    for (int turn = 0; turn < x.count && largest > 0.0; ++turn) {
        const double slope = take_factor(&x, nothing * largest, share, rest);
        if (slope == 0.0) break;
        *memory =
            mbsri_reserve(allocator, &w->element.rows, 1, sizeof(mbsri_row)) &&
            mbsri_reserve(allocator, &w->element.entries, (size_t)moving, sizeof(mbsri_row_entry));
        if (!*memory) return false;
        mbsri_row *row = (mbsri_row *)w->element.rows.data + w->element.rows.count++;
        *row = (mbsri_row){number, velocity, slope, w->element.entries.count, 0};
        mbsri_zero(2 * (size_t)w->element.slope.out.rows, l);
        for (int k = 0; k < x.count; ++k) {
            l[x.row[k]] = share[k] / x.span[k];
            gross[x.row[k]] = rest[k] / x.span[k];
        }
        if (!add_entries(w, bodies, moving, row, l, gross)) return false;
    }
    for (int k = 0; k < x.count * x.count; ++k) {
        if (x.F[k] != 0.0) return false;
    }
    return true;
}

int mbsri_element_rows(mbsri_null_space *w, int number, int moving, bool velocity)
{
    const size_t rows = w->element.rows.count, entries = w->element.entries.count;
    bool memory = true;
    if (moving == 0 || add_rows(w, number, moving, velocity, &memory)) return MBSR_OK;
    if (!memory) {
        return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for what force elements see of %d null directions",
                          w->function, w->k);
    }
    w->element.rows.count = rows;
    w->element.entries.count = entries;
    for (int n = 0; n < moving; ++n)
        w->element.dense[velocity ? 0 : 1][w->element.moving[n]] = true;
    return MBSR_OK;
}

/* ---- of some directions ---- */

/* w->element.place (k): of each direction among these, -1: none of them. */
static void find_places(const mbsri_null_space *w, int count, const int *direction)
{
    for (int l = 0; l < w->k; ++l) w->element.place[l] = -1;
    for (int n = 0; n < count; ++n) w->element.place[direction[n]] = n;
}

static const mbsri_row_entry *entries_of(const mbsri_null_space *w, const mbsri_row *row)
{
    return (const mbsri_row_entry *)w->element.entries.data + row->first;
}

static bool sees_some(const mbsri_null_space *w, const mbsri_row *row)
{
    const mbsri_row_entry *entry = entries_of(w, row);
    for (int k = 0; k < row->count; ++k) {
        if (w->element.place[entry[k].direction] >= 0 && entry[k].value != 0.0) return true;
    }
    return false;
}

bool mbsri_rows_serve(const mbsri_null_space *w, int count, const int *direction, bool velocity)
{
    const mbsri_row *row = w->element.rows.data;
    double slope = 0.0;
    for (int n = 0; n < count; ++n) {
        if (w->element.dense[velocity ? 0 : 1][direction[n]]) return false;
    }
    find_places(w, count, direction);
    for (size_t r = 0; r < w->element.rows.count; ++r, ++row) {
        if (row->velocity != velocity || !sees_some(w, row)) continue;
        if ((row->slope > 0.0) != (slope > 0.0) && slope != 0.0) return false;
        slope = row->slope;
    }
    return true;
}

int mbsri_rows_gather(const mbsri_null_space *w, int count, const int *direction, bool velocity,
                      double *B, double *error)
{
    const mbsri_row *row = w->element.rows.data;
    int found = 0;
    find_places(w, count, direction);
    for (size_t r = 0; r < w->element.rows.count; ++r, ++row) {
        const mbsri_row_entry *entry = entries_of(w, row);
        const size_t column = (size_t)found * (size_t)count;
        if (row->velocity != velocity || !sees_some(w, row)) continue;
        ++found;
        if (!B) continue;
        mbsri_zero((size_t)count, B + column);
        mbsri_zero((size_t)count, error + column);
        for (int k = 0; k < row->count; ++k) {
            const int n = w->element.place[entry[k].direction];
            if (n < 0) continue;
            B[column + (size_t)n] = entry[k].value;
            error[column + (size_t)n] = entry[k].error;
        }
    }
    return found;
}
