/* A test of a force element's derivatives against differences of its forces.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/numbers.h"
#include "base/error.h"
#include "base/memory.h"
#include "dynamics/entry.h"
#include "forces/columns.h"
#include "newton/slopes/force_slopes.h"
#include "recursion/elements.h"

#include <mbsrank/verify.h>

#include <math.h>

/* One call of the element, in both ways. */
typedef struct verifier {
    const mbsr_model *m;
    mbsr_data *d;
    const mbsri_force *force;
    mbsri_slopes own, truth;
    double *forces; /* rows: the forces at the state */
    mbsr_force_errors *errors;
} verifier;

/* Some of the rows or columns of a body. */
typedef struct range {
    const char *name;
    int first, count;
} range;

/* The error of one block, relative to its largest entry. */
static void compare_block(verifier *w, int k, range rows, int l, range columns)
{
    const int stride = w->own.out.rows;
    const mbsr_force_body *body = w->d->element.bodies;
    double size = 0.0;
    for (int c = columns.first; c < columns.first + columns.count; ++c) {
        const ptrdiff_t at = (ptrdiff_t)c * stride + rows.first;
        size = fmax(size, mbsri_largest(rows.count, w->own.matrix + at));
        size = fmax(size, mbsri_largest(rows.count, w->truth.matrix + at));
    }
    const double noise = 1e-10 * mbsri_largest(rows.count, w->forces + rows.first);
    for (int c = 0; c < columns.count; ++c) {
        for (int r = 0; r < rows.count; ++r) {
            const ptrdiff_t at = (ptrdiff_t)(columns.first + c) * stride + rows.first + r;
            const double off = fabs(w->own.matrix[at] - w->truth.matrix[at]) - noise;
            if (!(off > w->errors->largest * size)) continue;
            w->errors->largest = off / size;
            mbsri_print(w->errors->text, sizeof w->errors->text,
                        "d%s(%d) / d%s(%d) of bodies %d and %d is %.9g, by differences %.9g",
                        rows.name, r, columns.name, c, body[k].id, body[l].id, w->own.matrix[at],
                        w->truth.matrix[at]);
        }
    }
}

static void compare_bodies(verifier *w, int k, int l)
{
    const mbsr_force_body *a = w->d->element.bodies + k, *b = w->d->element.bodies + l;
    const int row = w->own.row[k], column = w->own.column[l];
    if (row < 0 || column < 0) return;
    const int V = mbsri_V_column(b, column), q = mbsri_q_column(b, column),
              u = mbsri_u_column(b, column);
    const range rows[2] = {{"f", row, a->d}, {"tau", mbsri_tau_row(a, row), a->n}};
    const range columns[4] = {
        {"pose", column, V - column}, {"V", V, b->d}, {"q", q, b->nq}, {"u", u, b->n}};
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 4; ++j) compare_block(w, k, rows[i], l, columns[j]);
    }
}

static int verify_force(verifier *w, int body)
{
    const char *const function = "mbsr_force_verify";
    int status = mbsri_force_slopes(w->m, w->d, w->force, body, &w->own);
    if (!status) status = mbsri_force_values(w->m, w->d, w->force, body, &w->truth, w->forces);
    if (!status) status = mbsri_force_differences(w->m, w->d, w->force, body, &w->truth);
    if (status) return status;
    const size_t rows = (size_t)w->own.out.rows, size = rows * (size_t)w->own.out.columns;
    if (!mbsri_finite(size, w->own.matrix) || !mbsri_finite(size, w->truth.matrix) ||
        !mbsri_finite(rows, w->forces)) {
        return mbsri_fail(&w->d->error, MBSR_NOT_FINITE, MBSR_NONE, w->force->id,
                          "%s: forces or derivatives of force %d are not finite", function,
                          w->force->id);
    }
    const bool every = (w->force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    const int bodies = every ? 1 : w->force->def.bodies;
    for (int k = 0; k < bodies; ++k) {
        for (int l = 0; l < bodies; ++l) compare_bodies(w, k, l);
    }
    return MBSR_OK;
}

static int verify_all(verifier *w)
{
    const bool every = (w->force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    int status = MBSR_OK;
    for (int i = 1; i <= (every ? w->m->bodies : 1) && !status; ++i) status = verify_force(w, i);
    return status;
}

int mbsr_force_verify(const mbsr_model *model, mbsr_data *data, int force,
                      mbsr_force_errors *errors)
{
    verifier w = {.m = model, .d = data, .errors = errors};
    int status = mbsri_enter(model, data, errors, MBSRI_STAGE_VELOCITIES, "mbsr_force_verify");
    if (status) return status;
    w.force = mbsri_find_force(model, data, force, "mbsr_force_verify");
    if (!w.force) return MBSR_ERR_ID;
    if (!w.force->def.table->derivatives) {
        return mbsri_fail(&data->error, MBSR_ERR_VALUE, MBSR_NONE, force,
                          "mbsr_force_verify: force %d (%s) has no derivatives of its own", force,
                          w.force->def.table->name);
    }
    /* two for slopes, and one more has room for a vector of forces */
    size_t doubles, ints;
    mbsri_slopes_size(model, MBSRI_SLOPES_WHOLE, &doubles, &ints);
    void *memory =
        mbsri_allocate(&model->allocator, 3 * doubles * sizeof(double) + 2 * ints * sizeof(int));
    if (!memory) {
        return mbsri_fail(&data->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, force,
                          "mbsr_force_verify: no memory");
    }
    double *numbers = memory;
    int *integers = (int *)(numbers + 3 * doubles);
    mbsri_slopes_place(model, MBSRI_SLOPES_WHOLE, &w.own, numbers, integers);
    mbsri_slopes_place(model, MBSRI_SLOPES_WHOLE, &w.truth, numbers + doubles, integers + ints);
    w.forces = numbers + 2 * doubles;
    *errors = (mbsr_force_errors){0.0, ""};
    status = verify_all(&w);
    mbsri_release(&model->allocator, memory);
    return status;
}
