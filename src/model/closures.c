/* Adding closures, and finding them in a finished model.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/principal.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "closures/rows.h"
#include "model/check.h"
#include "model/query.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <string.h>

#define REFUSE(status, ...) mbsri_fail(&m->error, status, MBSR_NONE, MBSR_NONE, __VA_ARGS__)

static int check_bodies(mbsr_model *m, const mbsr_closure_def *def, const char *label)
{
    if (def->bodies < 1 || def->bodies > MBSR_CLOSURE_BODIES)
        return REFUSE(MBSR_ERR_VALUE, "%s (%s): bodies is %d, must be 1 .. %d", label,
                      def->table->name, def->bodies, MBSR_CLOSURE_BODIES);
    for (int k = 0; k < def->bodies; ++k) {
        if (def->body[k] < MBSR_GROUND)
            return REFUSE(MBSR_ERR_ID,
                          "%s (%s): body number %d is %d, neither a body nor "
                          "MBSR_GROUND",
                          label, def->table->name, k, def->body[k]);
    }
    return MBSR_OK;
}

static int check_closure_numbers(mbsr_model *m, const mbsr_closure_def *def, const char *label)
{
    for (int k = 0; k < MBSR_CLOSURE_PARAMS; ++k) {
        if (!isfinite(def->param[k]))
            return REFUSE(MBSR_ERR_VALUE, "%s (%s): param[%d] is %g", label, def->table->name, k,
                          def->param[k]);
    }
    for (int k = 0; k < MBSR_CLOSURE_ROWS; ++k) {
        const double stiffness = def->stiffness[k], damping = def->damping[k];
        if (!(stiffness >= 0.0 && isfinite(stiffness)))
            return REFUSE(MBSR_ERR_VALUE, "%s (%s): stiffness[%d] is %g", label, def->table->name,
                          k, stiffness);
        if (!(damping >= 0.0 && isfinite(damping)))
            return REFUSE(MBSR_ERR_VALUE, "%s (%s): damping[%d] is %g", label, def->table->name, k,
                          damping);
        if (damping > 0.0 && !(stiffness > 0.0))
            return REFUSE(MBSR_ERR_VALUE,
                          "%s (%s): damping[%d] is %g, but the row has no "
                          "stiffness",
                          label, def->table->name, k, damping);
    }
    if (def->settled != 0 && def->settled != 1)
        return REFUSE(MBSR_ERR_VALUE, "%s (%s): settled is %d, must be 0 or 1", label,
                      def->table->name, def->settled);
    return MBSR_OK;
}

/* Whether a matrix is finite and symmetric, without negative entries on its diagonal. */
static int check_compliance(mbsr_model *m, int n, const double *A, const char *what,
                            const char *label)
{
    for (int k = 0; k < n * n; ++k) {
        const int i = k % n, j = k / n;
        if (!isfinite(A[k]) || (i == j && A[k] < 0.0))
            return REFUSE(MBSR_ERR_VALUE, "%s: %s (%d,%d) is %g", label, what, i, j, A[k]);
        const double other = A[i * n + j], size = sqrt(A[i * n + i]) * sqrt(A[j * n + j]);
        if (fabs(A[k] - other) > 1e-12 * size || (size == 0.0 && A[k] != 0.0))
            return REFUSE(MBSR_ERR_VALUE,
                          "%s: %s is not symmetric positive semi-definite: (%d,%d) is "
                          "%g, (%d,%d) is %g",
                          label, what, i, j, A[k], j, i, other);
    }
    return MBSR_OK;
}

/* The rows in which springs and dampers act apart; the numbers of each go to the definition, which
 * is the model's copy. */
static int find_rows(mbsr_model *m, mbsr_closure_def *def, mbsri_principal *rows, const char *label)
{
    static const char *const faults[] = {
        "", "compliance is not positive semi-definite",
        "compliance_damping is not positive semi-definite", "",
        "compliance and its damping have principal directions too near to each other"};
    const int n = def->compliant;
    if (n < 0 || n > MBSR_CLOSURE_ROWS || !def->compliance)
        return REFUSE(MBSR_ERR_VALUE, "%s: compliant is %d, must be 0 .. %d%s", label, n,
                      MBSR_CLOSURE_ROWS, def->compliance ? "" : "; compliance is NULL");
    int status = check_compliance(m, n, def->compliance, "compliance", label);
    if (!status && def->compliance_damping)
        status = check_compliance(m, n, def->compliance_damping, "compliance_damping", label);
    if (status) return status;
    for (int k = 0; k < MBSR_CLOSURE_ROWS; ++k) {
        if (def->stiffness[k] > 0.0)
            return REFUSE(MBSR_ERR_VALUE, "%s: stiffness[%d] is %g beside a compliance matrix",
                          label, k, def->stiffness[k]);
    }
    const int fault =
        (int)mbsri_principal_compliance(n, def->compliance, def->compliance_damping, rows);
    if (fault != MBSRI_PRINCIPAL_GOOD)
        return REFUSE(MBSR_ERR_VALUE, "%s: %s", label, faults[fault]);
    for (int k = 0; k < n; ++k) {
        def->stiffness[k] = rows->stiffness[k];
        def->damping[k] = rows->damping[k];
    }
    def->compliance = def->compliance_damping = NULL;
    return MBSR_OK;
}

static int check_closure_table(mbsr_model *m, const mbsr_closure_def *def, const char *label)
{
    const mbsr_closure_table *table = def->table;
    if (!table || table->version != MBSR_CLOSURE_TABLE_VERSION || !table->name)
        return REFUSE(MBSR_ERR_VALUE, "%s: table is NULL, of another version, or lacks its name",
                      label);
    if (!table->count && (def->rows < 1 || def->rows > MBSR_CLOSURE_ROWS ||
                          def->position_rows < 0 || def->position_rows > def->rows))
        return REFUSE(MBSR_ERR_VALUE,
                      "%s (%s): rows is %d and position_rows %d, must be 1 .. %d and 0 .. "
                      "rows",
                      label, table->name, def->rows, def->position_rows, MBSR_CLOSURE_ROWS);
    if (!table->count && def->position_rows > 0 && !table->position)
        return REFUSE(MBSR_ERR_VALUE, "%s (%s): position_rows is %d, but the table has no position",
                      label, table->name, def->position_rows);
    if (!table->count && def->position_rows < def->rows && !table->jacobian)
        return REFUSE(MBSR_ERR_VALUE, "%s (%s): rows that are no position rows need a jacobian",
                      label, table->name);
    return mbsri_check_scales(m, &table->scales, MBSR_NONE, MBSR_NONE, label, table->name);
}

int mbsri_check_closure(mbsr_model *m, const mbsr_closure_def *def, const char *label)
{
    int status = check_closure_table(m, def, label);
    if (!status) status = check_bodies(m, def, label);
    if (!status) status = check_closure_numbers(m, def, label);
    if (status || !def->table->check_fields) return status;
    char text[MBSR_TEXT_SIZE] = "";
    status = def->table->check_fields(def, text);
    if (!status) return MBSR_OK;
    return REFUSE(status, "%s (%s): %.150s", label, def->table->name,
                  text[0] ? text : mbsr_status_text(status));
}

int mbsr_model_add_closure(mbsr_model *model, const mbsr_closure_def *def, int *id)
{
    static const char function[] = "mbsr_model_add_closure";
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    if (!def) return REFUSE(MBSR_ERR_NULL, "%s: the definition is NULL", function);
    if (m->finished)
        return REFUSE(MBSR_ERR_FINISHED, "%s: the model is finished and cannot be changed",
                      function);
    const int next = (int)m->closures.count;
    if (def->cookie != MBSRI_COOKIE)
        return REFUSE(MBSR_ERR_NO_DEFAULT,
                      "closure %d: the definition was not made by "
                      "mbsr_default_closure_def",
                      next);
    char label[MBSRI_LABEL];
    mbsri_label(label, "closure", next, def->name);
    mbsri_closure closure = {.def = *def, .force = MBSR_NONE};
    mbsri_principal rows;
    int status = mbsri_check_closure(m, def, label);
    if (!status && def->compliant != 0) status = find_rows(m, &closure.def, &rows, label);
    if (status) return status;
    mbsri_stiff_axes(&closure.def);
    const size_t length = def->name && def->name[0] ? strlen(def->name) + 1 : 0,
                 mixture = (size_t)closure.def.compliant * (size_t)closure.def.compliant;
    if (!mbsri_reserve(&m->allocator, &m->stored.names, length, sizeof(char)) ||
        !mbsri_reserve(&m->allocator, &m->stored.matrices, mixture + 1, sizeof(double)) ||
        !mbsri_reserve(&m->allocator, &m->closures, 1, sizeof(mbsri_closure)))
        return REFUSE(MBSR_ERR_NO_MEMORY, "%s: no memory", label);
    if (mixture > 0) {
        if (m->stored.matrices.count == 0)
            ((double *)m->stored.matrices.data)[m->stored.matrices.count++] = 0.0;
        closure.mixture = m->stored.matrices.count;
        memcpy((double *)m->stored.matrices.data + closure.mixture, rows.T,
               mixture * sizeof *rows.T);
        m->stored.matrices.count += mixture;
    }
    closure.name = length > 0 ? m->stored.names.count : 0;
    closure.def.name = NULL;
    if (length > 0) memcpy((char *)m->stored.names.data + m->stored.names.count, def->name, length);
    m->stored.names.count += length;
    ((mbsri_closure *)m->closures.data)[m->closures.count++] = closure;
    if (id) *id = next;
    return MBSR_OK;
}

int mbsr_model_add_loop_joint(mbsr_model *model, const char *name, int body,
                              const mbsr_joint *joint, int other, const mbsr_frame *frame_other,
                              int *closure, int *cut_body)
{
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    if (!joint) return REFUSE(MBSR_ERR_NULL, "mbsr_model_add_loop_joint: joint is NULL");
    mbsr_body_def cut = mbsr_default_body_def();
    cut.name = name;
    cut.parent = body;
    cut.joint = *joint;
    int made;
    int status = mbsr_model_add_body(m, &cut, &made);
    if (status) return status;
    mbsr_closure_def weld = mbsr_closure_weld(made, NULL, other, frame_other);
    weld.name = name;
    if (other == made)
        status = REFUSE(MBSR_ERR_ID, "mbsr_model_add_loop_joint: other is %d, the cut body", other);
    else
        status = mbsr_model_add_closure(m, &weld, closure);
    if (status) {
        --m->entries.count; /* its name and parameters stay unused */
        return status;
    }
    if (cut_body) *cut_body = made;
    return MBSR_OK;
}

/* ---- reading ---- */

const mbsri_closure *mbsri_closure_of(const mbsr_model *m, int id)
{
    if (!m || !m->finished || id < 0 || (size_t)id >= m->closures.count) return NULL;
    return (const mbsri_closure *)m->closures.data + id;
}

const char *mbsri_closure_label(const mbsr_model *m, int id, char *buffer)
{
    const mbsri_closure *closure = (const mbsri_closure *)m->closures.data + id;
    return mbsri_label(buffer, "closure", id, (const char *)m->stored.names.data + closure->name);
}

int mbsr_model_closures(const mbsr_model *model)
{
    return model && model->finished ? (int)model->closures.count : -1;
}

int mbsr_model_rows(const mbsr_model *model)
{
    return model && model->finished ? model->rows : -1;
}

int mbsr_model_position_rows(const mbsr_model *model)
{
    return model && model->finished ? model->position_rows : -1;
}

int mbsr_closure_indices(const mbsr_model *model, int closure, int *row, int *rows, int *held_row,
                         int *position_rows)
{
    if (!model) return MBSR_ERR_NULL;
    if (!model->finished) return MBSR_ERR_UNFINISHED;
    const mbsri_closure *c = mbsri_closure_of(model, closure);
    if (!c) return MBSR_ERR_ID;
    if (row) *row = c->row;
    if (rows) *rows = c->rows;
    if (held_row) *held_row = c->position_row;
    if (position_rows) *position_rows = c->position_rows;
    return MBSR_OK;
}

double mbsr_closure_stiffness(const mbsr_model *model, int closure, int row)
{
    const mbsri_closure *c = mbsri_closure_of(model, closure);
    return c && row >= 0 && row < c->rows ? c->def.stiffness[row] : -1.0;
}

int mbsr_closure_mixture(const mbsr_model *model, int closure, double *T)
{
    if (!model || !T) return MBSR_ERR_NULL;
    if (!model->finished) return MBSR_ERR_UNFINISHED;
    const mbsri_closure *c = mbsri_closure_of(model, closure);
    if (!c) return MBSR_ERR_ID;
    for (int j = 0; j < c->position_rows; ++j) {
        for (int k = 0; k < c->position_rows; ++k)
            T[j * c->position_rows + k] = c->mix   ? c->mix[k * c->position_rows + j]
                                          : j == k ? 1.0
                                                   : 0.0;
    }
    return MBSR_OK;
}

int mbsr_force_closure(const mbsr_model *model, int force)
{
    if (!model || !model->finished) return MBSR_NONE;
    const mbsri_force *first = model->forces.data, *carried = first + model->forces.count;
    for (size_t k = 0; k < model->elements.idle; ++k) {
        if (carried[k].id == force) return carried[k].closure;
    }
    return MBSR_NONE;
}

const char *mbsr_closure_name(const mbsr_model *model, int closure)
{
    const mbsri_closure *c = mbsri_closure_of(model, closure);
    return c ? (const char *)model->stored.names.data + c->name : NULL;
}

int mbsr_model_find_closure(const mbsr_model *model, const char *name)
{
    for (int id = 0; name && name[0] && id < mbsr_model_closures(model); ++id) {
        if (strcmp(mbsr_closure_name(model, id), name) == 0) return id;
    }
    return MBSR_NONE;
}
