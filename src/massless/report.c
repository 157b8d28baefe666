/* Diagnosis of the directions that move no mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With C = d gamma / d u and S = d gamma / d q along the null directions (null_space.h), directions
 * whose C and S do not couple are looked at apart. In each such component, with the errors of C and
 * S carried along (reduction.h):
 *
 *   rank of C               damped
 *   Y^T C = 0, C Z = 0      the others; of these the rank of Y^T S Z is elastic
 *   Y^T S Z x = 0           Z x is undetermined
 *
 * Damped directions are determined up to elastic and undetermined ones, and elastic up to
 * undetermined ones; which are shown is a choice (add). */
#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "massless/element_slopes.h"
#include "massless/null_slopes.h"
#include "massless/null_space.h"
#include "massless/reduction.h"
#include "model/query.h"
#include "recursion/not_finite.h"

#include <mbsrank/index.h>

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Workspace of one report; k null directions, a component has c <= k. */
typedef struct report_work {
    mbsri_null_space w;
    int *component; /* k: number of the component of each direction */
    int *member;    /* k: the directions of the present component */
    mbsri_reduction reduced;
    double *C, *values;        /* c x c, c: scaled C and its singular values */
    double *Y, *Z;             /* c x (c - damped): null vectors of C */
    double *Y_error, *Z_error; /* of the same shape */
    double *x, *sparse;        /* c: a direction as weights of the component's, two choices */
    double *weights;           /* k x k: found directions as weights of the null directions */
    mbsr_direction_kind *kind; /* k */
    bool *listed;              /* bodies + 1: those of elements that determine a direction */
    int found;
    double *u, *twist, *q_rate; /* nu, size_v, nq: of a found direction */
    double *other;              /* nu */
    double *size;               /* the most of these: scratch of mbsri_null_mix */
    double *work;
    int lwork;
    void *memory;
} report_work;

/* Takes memory for everything but the null space; the doubles first. */
static int allocate(report_work *r)
{
    const mbsr_model *m = r->w.m;
    const size_t k = (size_t)r->w.k;
    r->lwork = mbsri_lapack_svd_work(r->w.k > 0 ? r->w.k : 1);
    double **const array[] = {&r->C,       &r->values, &r->Y,       &r->Z,    &r->Y_error,
                              &r->Z_error, &r->x,      &r->sparse,  &r->u,    &r->twist,
                              &r->q_rate,  &r->other,  &r->weights, &r->size, &r->work};
    const size_t length[] = {k * k,
                             k,
                             k * k,
                             k * k,
                             k * k,
                             k * k,
                             k,
                             k,
                             (size_t)m->nu,
                             m->size_v,
                             (size_t)m->nq,
                             (size_t)m->nu,
                             k * k,
                             m->size_v + (size_t)m->nq + (size_t)m->nu,
                             (size_t)r->lwork};
    size_t total = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) total += length[l];
    const size_t reduced = mbsri_reduction_size(r->w.k), aligned = reduced + sizeof(double),
                 tail = 2 * k * sizeof(int) + k * sizeof(mbsr_direction_kind) +
                        ((size_t)m->bodies + 1) * sizeof(bool);
    r->memory = mbsri_allocate(&m->allocator,
                               total * sizeof(double) + aligned - aligned % sizeof(double) + tail);
    if (!r->memory) {
        return mbsri_fail(&r->w.d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_index_report_create: no memory for %d null directions", r->w.k);
    }
    double *next = r->memory;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    mbsri_reduction_place(&r->reduced, r->w.k, next);
    next += aligned / sizeof(double);
    r->component = (int *)(void *)next;
    r->member = r->component + k;
    r->kind = (mbsr_direction_kind *)(void *)(r->member + k);
    r->listed = (bool *)(void *)(r->kind + k);
    return MBSR_OK;
}

/* Spreads the number of l's component over all directions coupled to it. */
static void mark(report_work *r, int l, int number)
{
    const int k = r->w.k;
    int count = 0;
    r->member[count++] = l;
    r->component[l] = number;
    for (int next = 0; next < count; ++next) {
        const int a = r->member[next];
        for (int b = 0; b < k; ++b) {
            const bool coupled = r->w.C[a * k + b] != 0.0 || r->w.C[b * k + a] != 0.0 ||
                                 r->w.S[a * k + b] != 0.0 || r->w.S[b * k + a] != 0.0;
            if (!coupled || r->component[b] >= 0) continue;
            r->component[b] = number;
            r->member[count++] = b;
        }
    }
}

/* ---- the choice of a direction ---- */

/* weights (k) of the component's directions with weights x (c). */
static void spread(const report_work *r, int c, const double *x, double *weights)
{
    mbsri_zero((size_t)r->w.k, weights);
    for (int a = 0; a < c; ++a) weights[r->member[a]] = x[a];
}

/* u, twist and q_rate of a direction. */
static void combine(report_work *r, const double *weights)
{
    mbsri_null_mix(&r->w, MBSRI_NULL_RATES, weights, r->u, r->size);
    mbsri_null_mix(&r->w, MBSRI_NULL_TWISTS, weights, r->twist, r->size);
    mbsri_null_mix(&r->w, MBSRI_NULL_SHIFTS, weights, r->q_rate, r->size);
}

/* Whether an element determines the direction of this kind in u, twist and q_rate. */
static int determines(report_work *r, const mbsri_force *force, mbsr_direction_kind kind,
                      bool *determined)
{
    *determined = false;
    if (kind == MBSR_DIRECTION_UNDETERMINED) return MBSR_OK;
    return mbsri_element_resists(&r->w, force, r->u, r->twist, r->q_rate,
                                 kind == MBSR_DIRECTION_DAMPED, determined);
}

/* listed: the bodies that move in the direction and belong to elements that determine it. */
static int list_bodies(report_work *r, mbsr_direction_kind kind)
{
    const mbsr_model *m = r->w.m;
    const mbsri_force *force = m->forces.data;
    for (int i = 0; i <= m->bodies; ++i) r->listed[i] = false;
    for (size_t k = 0; k < m->forces.count; ++k) {
        bool determined;
        const int status = determines(r, force + k, kind, &determined);
        if (status) return status;
        for (int l = 0; l < force[k].def.bodies && determined; ++l)
            r->listed[m->list_index[force[k].list + (size_t)l]] = true;
    }
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        r->listed[i] = r->listed[i] && mbsri_largest(b->n, r->u + b->u) > 0.0;
    }
    return MBSR_OK;
}

static int count_terms(const mbsr_model *m, const double *u)
{
    int count = 0;
    for (int k = 0; k < m->nu; ++k) count += u[k] != 0.0;
    return count;
}

/* A direction of the component: x, or in its stead `sparse` (NULL: none) if that has fewer terms
 * and still names the bodies on which the elements act that determine x. */
static int add(report_work *r, int c, const double *x, const double *sparse,
               mbsr_direction_kind kind)
{
    const mbsr_model *m = r->w.m;
    double *weights = r->weights + (size_t)r->found * (size_t)r->w.k;
    r->kind[r->found++] = kind;
    spread(r, c, x, weights);
    combine(r, weights);
    const int terms = count_terms(m, r->u);
    if (!sparse || terms <= 2) return MBSR_OK;
    const int status = list_bodies(r, kind);
    if (status) return status;
    spread(r, c, sparse, weights);
    mbsri_null_mix(&r->w, MBSRI_NULL_RATES, weights, r->other, r->size);
    bool better = count_terms(m, r->other) < terms;
    for (int i = 1; i <= m->bodies && better; ++i) {
        const mbsri_body *b = m->body + i;
        better = !r->listed[i] || mbsri_largest(b->n, r->other + b->u) > 0.0;
    }
    if (!better) spread(r, c, x, weights);
    return MBSR_OK;
}

/* ---- the kinds ---- */

/* T = S Z of the component, its errors and |S| |Z|: c x e each. */
static void stiffness_of(report_work *r, int c, int e, double *T, double *error, double *gross)
{
    const int k = r->w.k;
    mbsri_zero((size_t)c * (size_t)e, T);
    mbsri_zero((size_t)c * (size_t)e, error);
    mbsri_zero((size_t)c * (size_t)e, gross);
    for (int b = 0; b < e; ++b) {
        for (int q = 0; q < c; ++q) {
            const double z = r->Z[b * c + q], dz = r->Z_error[b * c + q];
            for (int p = 0; p < c && (z != 0.0 || dz != 0.0); ++p) {
                const int at = r->member[q] * k + r->member[p], to = b * c + p;
                const double S = r->w.S[at], size = fabs(S);
                T[to] += S * z;
                gross[to] += size * fabs(z);
                error[to] += (r->w.S_error[at] + 4.0 * DBL_EPSILON * size) * fabs(z) + size * dz;
            }
        }
    }
}

/* reduced.A = Y^T S Z of the component with its errors, c - damped rows and columns. */
static void elastic_block(report_work *r, int c, int e)
{
    double *T = r->C, *T_error = r->reduced.A + (size_t)e * (size_t)e,
           *gross = r->reduced.error + (size_t)e * (size_t)e;
    stiffness_of(r, c, e, T, T_error, gross);
    for (int b = 0; b < e; ++b) {
        for (int a = 0; a < e; ++a) {
            const double *y = r->Y + a * c, *dy = r->Y_error + a * c;
            double sum = 0.0, error = 0.0;
            for (int p = 0; p < c; ++p) {
                sum += y[p] * T[b * c + p];
                error += fabs(y[p]) * T_error[b * c + p] + dy[p] * gross[b * c + p];
            }
            r->reduced.A[b * e + a] = fabs(sum) > 10.0 * error ? sum : 0.0;
            r->reduced.error[b * e + a] = error;
        }
    }
}

/* out (c) = Z weights (e) */
static void through(const report_work *r, int c, int e, const double *weights, double *out)
{
    mbsri_zero((size_t)c, out);
    for (int b = 0; b < e; ++b) {
        for (int a = 0; a < c; ++a) out[a] += weights[b] * r->Z[b * c + a];
    }
    for (int a = 0; a < c; ++a) {
        double size = 0.0;
        for (int b = 0; b < e; ++b) size += fabs(weights[b] * r->Z[b * c + a]);
        if (fabs(out[a]) <= 1e-12 * size) out[a] = 0.0;
    }
}

/* Elastic and undetermined directions among those C does not see. */
static int classify_rest(report_work *r, int c, int damped)
{
    const int e = c - damped;
    for (int l = 0; l < e; ++l) {
        mbsri_left_null(&r->reduced, l, r->Y + l * c, r->Y_error + l * c);
        mbsri_right_null(&r->reduced, l, r->Z + l * c, r->Z_error + l * c);
    }
    elastic_block(r, c, e);
    mbsri_reduce(&r->reduced, e, MBSRI_LEAST_STIFFNESS);
    const int elastic = r->reduced.rank;
    int status = MBSR_OK;
    for (int l = 0; l < e && !status; ++l) {
        double *weights = r->values; /* e numbers */
        if (l < elastic)
            mbsri_row_space(&r->reduced, l, weights);
        else
            mbsri_right_null(&r->reduced, l - elastic, weights, NULL);
        through(r, c, e, weights, r->x);
        const double *sparse = l < elastic ? r->Z + r->reduced.pivot_column[l] * c : NULL;
        status = add(r, c, r->x, sparse,
                     l < elastic ? MBSR_DIRECTION_ELASTIC : MBSR_DIRECTION_UNDETERMINED);
    }
    return status;
}

/* The smallest of `rank` singular values of the scaled C over the largest. */
static int condition(report_work *r, int c, int rank, mbsr_index_report *report)
{
    for (int b = 0; b < c; ++b) {
        for (int a = 0; a < c; ++a) {
            r->C[b * c + a] = r->reduced.rows[a] * r->reduced.columns[b] *
                              r->w.C[r->member[b] * r->w.k + r->member[a]];
        }
    }
    if (mbsri_lapack_svd(c, r->C, r->values, r->Y, r->Z, r->work, r->lwork) != 0) {
        return mbsri_fail(&r->w.d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
                          "mbsr_index_report_create: singular values did not converge");
    }
    report->conditioning = fmin(report->conditioning, r->values[rank - 1] / r->values[0]);
    return MBSR_OK;
}

static int classify(report_work *r, int number, mbsr_index_report *report)
{
    const int k = r->w.k;
    int c = 0;
    for (int l = 0; l < k; ++l) {
        if (r->component[l] == number) r->member[c++] = l;
    }
    for (int b = 0; b < c; ++b) {
        for (int a = 0; a < c; ++a) {
            const int at = r->member[b] * k + r->member[a];
            r->reduced.A[b * c + a] = r->w.C[at];
            r->reduced.error[b * c + a] = r->w.C_error[at];
        }
    }
    mbsri_reduce(&r->reduced, c, MBSRI_LEAST_DAMPING);
    const int damped = r->reduced.rank;
    int status = damped > 0 ? condition(r, c, damped, report) : MBSR_OK;
    for (int l = 0; l < damped && !status; ++l) {
        mbsri_row_space(&r->reduced, l, r->x);
        mbsri_zero((size_t)c, r->sparse);
        r->sparse[r->reduced.pivot_column[l]] = 1.0;
        status = add(r, c, r->x, r->sparse, MBSR_DIRECTION_DAMPED);
    }
    return !status && damped < c ? classify_rest(r, c, damped) : status;
}

/* All components; fills weights, kind, and the counts of the report. */
static int analyse(report_work *r, double t, const double *q, const double *u,
                   mbsr_index_report *report)
{
    mbsri_null_space *w = &r->w;
    int status = mbsri_null_basis(w, t, q, u);
    if (!status) status = mbsri_null_slopes(w, t, q, u);
    int components = 0;
    for (int l = 0; l < w->k; ++l) r->component[l] = -1;
    for (int l = 0; l < w->k && !status; ++l) {
        if (r->component[l] < 0) mark(r, l, components++);
    }
    for (int number = 0; number < components && !status; ++number) {
        status = classify(r, number, report);
    }
    if (!status)
        status = mbsri_check_result(w->m, w->d, (size_t)r->found * (size_t)w->k, r->weights,
                                    w->function);
    if (!status) status = mbsri_check_result(w->m, w->d, 1, &report->conditioning, w->function);
    for (int l = 0; l < r->found; ++l) {
        report->damped += r->kind[l] == MBSR_DIRECTION_DAMPED;
        report->elastic += r->kind[l] == MBSR_DIRECTION_ELASTIC;
        report->undetermined += r->kind[l] == MBSR_DIRECTION_UNDETERMINED;
    }
    report->dynamic = w->m->nu - w->k;
    report->directions = w->k;
    report->index = report->undetermined > 0 ? -1 : report->elastic > 0 ? 2 : w->k > 0 ? 1 : 0;
    return status;
}

/* Joint rates of found direction l, those below 1e-6 of the largest left out, a velocity compared
 * with an angular rate times the typical length; the largest number made 1. Returns how many there
 * are; writes them where term is not NULL. */
static int list_terms(report_work *r, int l, mbsr_direction_term *term)
{
    const mbsr_model *m = r->w.m;
    mbsri_null_mix(&r->w, MBSRI_NULL_RATES, r->weights + (size_t)l * (size_t)r->w.k, r->u, r->size);
    double largest = 0.0, size = 0.0;
    for (int k = 0; k < m->nu; ++k) {
        if (fabs(r->u[k]) > fabs(largest)) largest = r->u[k];
        size = fmax(size, fabs(r->u[k]) / r->w.span[k]);
    }
    int count = 0;
    for (int id = 0; id < m->bodies; ++id) {
        const mbsri_body *b = m->body + m->index[id];
        for (int k = 0; k < b->n; ++k) {
            const double x = r->u[b->u + k];
            if (fabs(x) / r->w.span[b->u + k] < 1e-6 * size && x != largest) continue;
            if (term) term[count] = (mbsr_direction_term){id, k, x / largest};
            ++count;
        }
    }
    return count;
}

/* Ids of the elements that determine found direction l; written where
 * force is not NULL. */
static int list_forces(report_work *r, int l, int *force, int *count)
{
    const mbsr_model *m = r->w.m;
    const mbsri_force *element = m->forces.data;
    combine(r, r->weights + (size_t)l * (size_t)r->w.k);
    *count = 0;
    for (size_t k = 0; k < m->forces.count; ++k) {
        bool determined;
        const int status = determines(r, element + k, r->kind[l], &determined);
        if (status) return status;
        if (!determined) continue;
        if (force) force[*count] = element[k].id;
        ++*count;
    }
    return MBSR_OK;
}

/* Appends to a text of `size` bytes, or with text == NULL only counts. */
static void append(char *text, size_t size, size_t *used, const char *format, const char *string,
                   double number)
{
    char piece[MBSRI_LABEL + 64];
    const int length = mbsri_print(piece, sizeof piece, format, string, number);
    if (length < 0) return;
    if (text && *used + (size_t)length < size) memcpy(text + *used, piece, (size_t)length + 1);
    *used += (size_t)length;
}

/* "bodies 'a', 'b': 1 u('a') - 0.5 u('b'): ..." */
static void describe(const mbsr_model *m, const mbsr_direction *direction, char *text, size_t size,
                     size_t *used)
{
    enum { SHOWN = 6 };
    char label[MBSRI_LABEL];
    const int shown = direction->terms < SHOWN ? direction->terms : SHOWN;
    append(text, size, used, *used > 0 ? "\n%s" : "%s", "", 0.0);
    for (int k = 0; k < shown; ++k) {
        const mbsr_direction_term *term = direction->term + k;
        if (k > 0 && term->body == term[-1].body) continue; /* each body once */
        append(text, size, used, k > 0 ? ", %s" : "%s",
               mbsri_body_label(m, m->index[term->body], label), 0.0);
    }
    append(text, size, used, direction->terms > SHOWN ? "%s and others: " : "%s: ", "", 0.0);
    for (int k = 0; k < shown; ++k) {
        const mbsr_direction_term *term = direction->term + k;
        char name[MBSRI_LABEL];
        snprintf(name, sizeof name, "u%d of body %d", term->coordinate, term->body);
        append(text, size, used, k > 0 ? "%s%+.3g " : "%s%.3g ", k > 0 ? " " : "", term->weight);
        append(text, size, used, "%s", name, 0.0);
    }
    append(text, size, used,
           direction->terms == 1 ? "%s moves no mass, and no force resists it: "
                                 : "%s together move no mass, and no force resists them: ",
           "", 0.0);
    append(text, size, used, "%sgive it inertia, a spring or a damper, or lock it", "", 0.0);
}

/* Terms and forces of all directions: how many. */
static int count_all(report_work *r, size_t *terms, size_t *forces)
{
    *terms = *forces = 0;
    for (int l = 0; l < r->found; ++l) {
        int count;
        *terms += (size_t)list_terms(r, l, NULL);
        const int status = list_forces(r, l, NULL, &count);
        if (status) return status;
        *forces += (size_t)count;
    }
    return MBSR_OK;
}

/* The directions in their order, with their terms, forces and text. */
static int write_directions(report_work *r, mbsr_direction *direction, mbsr_direction_term *term,
                            int *force, char *line, size_t text)
{
    static const mbsr_direction_kind order[] = {MBSR_DIRECTION_UNDETERMINED, MBSR_DIRECTION_ELASTIC,
                                                MBSR_DIRECTION_DAMPED};
    size_t used = 0;
    line[0] = '\0';
    for (int pass = 0; pass < 3; ++pass) {
        for (int l = 0; l < r->found; ++l) {
            if (r->kind[l] != order[pass]) continue;
            *direction = (mbsr_direction){r->kind[l], list_terms(r, l, term), term, 0, force};
            const int status = list_forces(r, l, force, &direction->forces);
            if (status) return status;
            term += direction->terms;
            force += direction->forces;
            if (pass == 0) describe(r->w.m, direction, line, text, &used);
            ++direction;
        }
    }
    return MBSR_OK;
}

/* Everything in one block: report, directions, terms, forces, text. */
static int assemble(report_work *r, mbsr_index_report result, mbsr_index_report **report)
{
    const mbsr_model *m = r->w.m;
    size_t terms, forces;
    int status = count_all(r, &terms, &forces);
    if (status) return status;
    /* a line of text names at most six bodies twice */
    const size_t text = (size_t)result.undetermined * (size_t)(8 * MBSRI_LABEL + 512) + 1;
    const size_t first = sizeof result + (size_t)r->found * sizeof(mbsr_direction);
    mbsr_index_report *made = mbsri_allocate(
        &m->allocator, first + terms * sizeof(mbsr_direction_term) + forces * sizeof(int) + text);
    if (!made) {
        return mbsri_fail(&r->w.d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_index_report_create: no memory for %d directions", r->found);
    }
    mbsr_direction *direction = (mbsr_direction *)(void *)(made + 1);
    mbsr_direction_term *term = (mbsr_direction_term *)(void *)(direction + r->found);
    int *force = (int *)(void *)(term + terms);
    char *line = (char *)(force + forces);
    result.direction = direction;
    result.text = line;
    *made = result;
    status = write_directions(r, direction, term, force, line, text);
    if (status) {
        mbsri_release(&m->allocator, made);
        return status;
    }
    *report = made;
    return MBSR_OK;
}

int mbsr_index_report_create(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                             const double *u, mbsr_index_report **report)
{
    if (report) *report = NULL;
    int status = mbsri_enter_tree(model, data, q && u && report, MBSRI_STAGE_NONE,
                                  "mbsr_index_report_create");
    if (status) return status;
    report_work r = {.found = 0};
    mbsr_index_report result = {.conditioning = 1.0};
    const bool watching = data->watching;
    data->watching = false;
    status = mbsri_null_open(&r.w, model, data, t, q, u, "mbsr_index_report_create");
    if (!status) {
        status = allocate(&r);
        if (!status) status = analyse(&r, t, q, u, &result);
        if (!status) status = assemble(&r, result, report);
        mbsri_release(&model->allocator, r.memory);
        mbsri_null_close(&r.w);
    }
    data->watching = watching;
    return status;
}

void mbsr_index_report_destroy(const mbsr_model *model, mbsr_index_report *report)
{
    if (model && report) mbsri_release(&model->allocator, report);
}
