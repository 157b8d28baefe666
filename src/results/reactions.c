/* What single closures do at a state.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/closure.h>

#include "algebra/dense.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "model/locked.h"
#include "model/query.h"
#include "recursion/closure_differences.h"
#include "recursion/closure_rows.h"
#include "recursion/closures.h"
#include "recursion/not_finite.h"

static const mbsri_closure *find_closure(const mbsr_model *m, mbsr_data *d, int id,
                                         const char *name)
{
    const int count = mbsr_model_closures(m);
    if (id >= 0 && id < count) return (const mbsri_closure *)m->closures.data + id;
    mbsri_fail(&d->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
               "%s: closure is %d, the model has %d closures", name, id, count);
    return NULL;
}

/* Its rows by the velocities of its bodies, into the data's closure_C. */
static int renew_rows(const mbsr_model *m, mbsr_data *d, const mbsri_closure *c)
{
    const bool known = c->def.table->jacobian != NULL;
    double *C = d->closure_C + c->at;
    const mbsr_closure_jacobian out = {C, c->rows, c->columns, c->column};
    mbsri_closure_view view;
    mbsri_view_closure(m, d, c, false, &view);
    mbsri_zero((size_t)c->rows * (size_t)c->columns, C);
    const int status = known ? mbsri_closure_jacobian(c, &view.args, &out)
                             : mbsri_closure_slopes(m, c, &view, d->closure_x, C);
    return status ? mbsri_closure_failed(m, d, c, status, known ? "jacobian" : "position")
                  : MBSR_OK;
}

/* What a coupling exerts by a coordinate that is locked. */
static int nothing_at(const mbsr_model *m, int body, double *f, double *tau)
{
    const mbsri_body *b = m->body + mbsri_index(m, body);
    if (f) mbsri_zero((size_t)b->d, f);
    if (tau) mbsri_zero((size_t)b->n, tau);
    return MBSR_OK;
}

int mbsr_closure_reaction(const mbsr_model *model, mbsr_data *data, int closure, int place,
                          double *f, double *tau)
{
    static const char name[] = "mbsr_closure_reaction";
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = mbsri_enter(m, d, f || tau, MBSRI_STAGE_FORCES, name);
    if (status) return status;
    const mbsri_closure *c = find_closure(m, d, closure, name);
    if (!c) return MBSR_ERR_ID;
    const mbsr_closure_def *given = mbsri_closure_as_given(m, c);
    if (place < 0 || place >= given->bodies)
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: place is %d; closure %d (%s) acts on %d bodies", name, place,
                          closure, c->def.table->name, given->bodies);
    int held = 0; /* terms before it that are locked */
    for (int k = 0; k < place; ++k) held += mbsri_term_is_held(m, given, k);
    if (c->rows == 0 || mbsri_term_is_held(m, given, place))
        return nothing_at(m, given->body[place], f, tau);
    place -= held;
    const mbsri_body *b = m->body + c->body[place];
    const bool joints = (c->def.table->flags & MBSR_CLOSURE_JOINTS) != 0 && c->body[place] > 0;
    if (f) mbsri_zero((size_t)b->d, f);
    if (tau) mbsri_zero((size_t)b->n, tau);
    if (c->column[place] < 0) return MBSR_OK;
    status = renew_rows(m, d, c);
    if (status) return status;
    const double *lambda = d->loop_lambda + c->row,
                 *C = d->closure_C + c->at + (size_t)c->column[place] * (size_t)c->rows;
    if (f) mbsri_atx(c->rows, b->d, 1.0, C, lambda, f);
    if (tau && joints)
        mbsri_atx(c->rows, b->n, 1.0, C + (size_t)b->d * (size_t)c->rows, lambda, tau);
    if (f) status = mbsri_check_result(m, d, (size_t)b->d, f, name);
    if (tau && !status) status = mbsri_check_result(m, d, (size_t)b->n, tau, name);
    return status;
}

int mbsr_closure_point(const mbsr_model *model, mbsr_data *data, int closure, double point[3])
{
    static const char name[] = "mbsr_closure_point";
    int status = mbsri_enter(model, data, point != NULL, MBSRI_STAGE_POSITIONS, name);
    if (status) return status;
    const mbsri_closure *c = find_closure(model, data, closure, name);
    if (!c) return MBSR_ERR_ID;
    if (!c->def.table->point)
        return mbsri_fail(&data->error, MBSR_ERR_VALUE, MBSR_NONE, MBSR_NONE,
                          "%s: closure %d (%s) acts at no point", name, closure,
                          c->def.table->name);
    mbsri_closure_view view;
    mbsri_view_closure(model, data, c, false, &view);
    status = c->def.table->point(&view.args, point);
    if (status) return mbsri_closure_failed(model, data, c, status, "point");
    return mbsri_check_result(model, data, 3, point, name);
}
