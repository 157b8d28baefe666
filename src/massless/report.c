/* Diagnosis of the directions that move no mass.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With C = d gamma / d u and S = d gamma / d q along the null directions (null_space.h), directions
 * whose C and S do not couple are looked at apart. In each such component, with C scaled to unit
 * rows and columns:
 *
 *   rank of C               damped
 *   Y^T C = 0, C Z = 0      the others; of these the rank of Y^T S Z is elastic
 *   Y^T S Z x = 0           Z x is undetermined */
#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "massless/null_slopes.h"
#include "massless/null_space.h"
#include "model/query.h"
#include "recursion/not_finite.h"

#include <mbsrank/index.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double rank_tolerance = 1e-8; /* of scaled singular values; C and S are differences */

/* Workspace of one report; k null directions, a component has c <= k. */
typedef struct report_work {
    mbsri_null_space w;
    int *component;           /* k: number of the component of each direction */
    int *member;              /* k: the directions of the present component */
    double *C, *left, *right; /* c x c: scaled C, its left and right singular vectors */
    double *S, *S_right;      /* c x c: Y^T S Z and its right singular vectors */
    double *values, *rows, *columns;
    double *weights;           /* k x k: found directions as weights of the null directions */
    mbsr_direction_kind *kind; /* k */
    int found;
    double *u; /* nu */
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
    double **const array[] = {&r->C,    &r->left,    &r->right,   &r->S, &r->S_right, &r->values,
                              &r->rows, &r->columns, &r->weights, &r->u, &r->work};
    const size_t length[] = {k * k, k * k, k * k, k * k,         k * k,           k,
                             k,     k,     k * k, (size_t)m->nu, (size_t)r->lwork};
    size_t total = 0;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) total += length[l];
    const size_t tail = 2 * k * sizeof(int) + k * sizeof(mbsr_direction_kind);
    r->memory = mbsri_allocate(&m->allocator, total * sizeof(double) + tail);
    if (!r->memory) {
        return mbsri_fail(&r->w.d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_index_report_create: no memory for %d null directions", r->w.k);
    }
    double *next = r->memory;
    for (size_t l = 0; l < sizeof length / sizeof length[0]; ++l) {
        *array[l] = next;
        next += length[l];
    }
    r->component = (int *)(void *)next;
    r->member = r->component + k;
    r->kind = (mbsr_direction_kind *)(void *)(r->member + k);
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

/* A direction of the component, given by scaled weights x (c numbers): entry in weights and
 * kind. */
static void add(report_work *r, int c, const double *x, mbsr_direction_kind kind)
{
    double *weights = r->weights + (size_t)r->found * (size_t)r->w.k;
    mbsri_zero((size_t)r->w.k, weights);
    for (int a = 0; a < c; ++a) weights[r->member[a]] = x[a] * r->columns[a];
    r->kind[r->found++] = kind;
}

/* Y^T S Z of the component, scaled; c - damped rows and columns. */
static void elastic_block(report_work *r, int c, int damped)
{
    const int k = r->w.k, e = c - damped;
    for (int b = 0; b < e; ++b) {
        const double *z = r->right + (damped + b) * c;
        for (int a = 0; a < e; ++a) {
            const double *y = r->left + (damped + a) * c;
            double sum = 0.0;
            for (int q = 0; q < c; ++q) {
                for (int p = 0; p < c; ++p) {
                    sum += y[p] * r->rows[p] * r->w.S[r->member[q] * k + r->member[p]] *
                           r->columns[q] * z[q];
                }
            }
            r->S[b * e + a] = sum;
        }
    }
}

static int svd(report_work *r, int n, double *A, double *left, double *right)
{
    if (mbsri_lapack_svd(n, A, r->values, left, right, r->work, r->lwork) == 0) return MBSR_OK;
    return mbsri_fail(&r->w.d->error, MBSR_EIGEN_FAILED, MBSR_NONE, MBSR_NONE,
                      "mbsr_index_report_create: singular values did not converge");
}

/* Elastic and undetermined directions among those C does not see. */
static int classify_rest(report_work *r, int c, int damped)
{
    const int e = c - damped;
    elastic_block(r, c, damped);
    mbsri_scale_rows(e, r->S, r->C);
    double *const scale = r->u; /* e numbers of scratch: e <= k <= nu */
    mbsri_scale_columns(e, r->S, scale);
    const int status = svd(r, e, r->S, r->C, r->S_right);
    if (status) return status;
    for (int l = 0; l < e; ++l) {
        const bool elastic = r->values[l] > rank_tolerance;
        double *x = r->C; /* c numbers */
        mbsri_zero((size_t)c, x);
        for (int a = 0; a < e; ++a) {
            const double weight = r->S_right[l * e + a] * scale[a];
            for (int p = 0; p < c; ++p) x[p] += weight * r->right[(damped + a) * c + p];
        }
        add(r, c, x, elastic ? MBSR_DIRECTION_ELASTIC : MBSR_DIRECTION_UNDETERMINED);
    }
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
        for (int a = 0; a < c; ++a) r->C[b * c + a] = r->w.C[r->member[b] * k + r->member[a]];
    }
    mbsri_scale_rows(c, r->C, r->rows);
    mbsri_scale_columns(c, r->C, r->columns);
    const int status = svd(r, c, r->C, r->left, r->right);
    if (status) return status;
    int damped = 0;
    while (damped < c && r->values[damped] > rank_tolerance) ++damped;
    if (damped > 0) {
        report->conditioning = fmin(report->conditioning, r->values[damped - 1] / r->values[0]);
    }
    for (int l = 0; l < damped; ++l) add(r, c, r->right + l * c, MBSR_DIRECTION_DAMPED);
    return damped < c ? classify_rest(r, c, damped) : MBSR_OK;
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

/* Joint rates of found direction l, those below 1e-6 of the largest left out, the largest made 1.
 * Returns how many there are; writes them where term is not NULL. */
static int list_terms(report_work *r, int l, mbsr_direction_term *term)
{
    const mbsr_model *m = r->w.m;
    mbsri_zero((size_t)m->nu, r->u);
    mbsri_null_combine(&r->w, r->weights + (size_t)l * (size_t)r->w.k, r->u);
    double largest = 0.0;
    for (int k = 0; k < m->nu; ++k) {
        if (fabs(r->u[k]) > fabs(largest)) largest = r->u[k];
    }
    int count = 0;
    for (int id = 0; id < m->bodies; ++id) {
        const mbsri_body *b = m->body + m->index[id];
        for (int k = 0; k < b->n; ++k) {
            const double weight = r->u[b->u + k] / largest;
            if (fabs(weight) < 1e-6) continue;
            if (term) term[count] = (mbsr_direction_term){id, k, weight};
            ++count;
        }
    }
    return count;
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

/* Everything in one block: report, directions, terms, text. */
static int assemble(report_work *r, mbsr_index_report result, mbsr_index_report **report)
{
    const mbsr_model *m = r->w.m;
    size_t terms = 0;
    for (int l = 0; l < r->found; ++l) terms += (size_t)list_terms(r, l, NULL);
    /* a line of text names at most six bodies twice */
    const size_t text = (size_t)result.undetermined * (size_t)(8 * MBSRI_LABEL + 512) + 1;
    const size_t first = sizeof result + (size_t)r->found * sizeof(mbsr_direction);
    mbsr_index_report *made =
        mbsri_allocate(&m->allocator, first + terms * sizeof(mbsr_direction_term) + text);
    if (!made) {
        return mbsri_fail(&r->w.d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_index_report_create: no memory for %d directions", r->found);
    }
    mbsr_direction *direction = (mbsr_direction *)(void *)(made + 1);
    mbsr_direction_term *term = (mbsr_direction_term *)(void *)(direction + r->found);
    char *line = (char *)(term + terms);
    static const mbsr_direction_kind order[] = {MBSR_DIRECTION_UNDETERMINED, MBSR_DIRECTION_ELASTIC,
                                                MBSR_DIRECTION_DAMPED};
    size_t used = 0;
    int count = 0;
    line[0] = '\0';
    for (int pass = 0; pass < 3; ++pass) {
        for (int l = 0; l < r->found; ++l) {
            if (r->kind[l] != order[pass]) continue;
            direction[count] = (mbsr_direction){r->kind[l], list_terms(r, l, term), term};
            term += direction[count].terms;
            if (pass == 0) describe(m, direction + count, line, text, &used);
            ++count;
        }
    }
    result.direction = direction;
    result.text = line;
    *made = result;
    *report = made;
    return MBSR_OK;
}

int mbsr_index_report_create(const mbsr_model *model, mbsr_data *data, double t, const double *q,
                             const double *u, mbsr_index_report **report)
{
    if (report) *report = NULL;
    int status =
        mbsri_enter(model, data, q && u && report, MBSRI_STAGE_NONE, "mbsr_index_report_create");
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
