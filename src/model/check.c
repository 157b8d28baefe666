/* Validation of joints, inertias and force elements as they are added.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "model/check.h"

#include "algebra/dense.h"
#include "algebra/lapack.h"
#include "base/error.h"
#include "base/memory.h"
#include "flexible/data.h"

#include <math.h>

#define REFUSE(status, ...) mbsri_fail(&m->error, status, id, MBSR_NONE, __VA_ARGS__)

int mbsri_check_scales(mbsr_model *m, const mbsr_scales *scales, int body, int force,
                       const char *label, const char *name)
{
    static const char *const field[] = {"length", "angle", "other", "time"};
    const double value[] = {scales->length, scales->angle, scales->other, scales->time};
    for (int k = 0; k < 4; ++k) {
        if (value[k] >= 0.0 && isfinite(value[k])) continue;
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, body, force,
                          "%s (%s): table.scales.%s is %g, must be finite and not negative", label,
                          name, field[k], value[k]);
    }
    return MBSR_OK;
}

static int check_joint_table(mbsr_model *m, const mbsr_joint *joint, int id, const char *label)
{
    const mbsr_joint_table *table = joint->table;
    if (!table)
        return REFUSE(MBSR_ERR_VALUE,
                      "%s: joint.table is NULL; set joint by one of its constructors", label);
    if (table->version != MBSR_JOINT_TABLE_VERSION) {
        return REFUSE(MBSR_ERR_VALUE, "%s: joint.table version is %u, must be %u", label,
                      table->version, MBSR_JOINT_TABLE_VERSION);
    }
    if (!table->name || !table->position || !table->jacobians || !table->bias) {
        return REFUSE(MBSR_ERR_VALUE, "%s: joint.table needs name, position, jacobians and bias",
                      label);
    }
    return mbsri_check_scales(m, &table->scales, id, MBSR_NONE, label, table->name);
}

/* What the joint's own table says of its fields. */
static int check_own_fields(mbsr_model *m, const mbsr_joint *joint, int id, const char *label)
{
    if (!joint->table->check_fields) return MBSR_OK;
    char text[MBSR_TEXT_SIZE] = "";
    const int status = joint->table->check_fields(joint, text);
    if (!status) return MBSR_OK;
    return REFUSE(status, "%s: joint '%s': %.120s", label, joint->table->name,
                  text[0] ? text : mbsr_status_text(status));
}

int mbsri_check_joint(mbsr_model *m, const mbsr_joint *joint, int id, const char *label)
{
    static const int space_d[] = {
        [MBSR_SPACE_POINT] = 2, [MBSR_SPACE_PLANAR] = 3, [MBSR_SPACE_SPATIAL] = 6};
    static const int space_np[] = {
        [MBSR_SPACE_POINT] = 2, [MBSR_SPACE_PLANAR] = 3, [MBSR_SPACE_SPATIAL] = MBSR_POSE_SIZE};
    const int status = check_joint_table(m, joint, id, label);
    if (status) return status;
    const char *name = joint->table->name;
    const bool flexible = joint->space == MBSR_SPACE_FLEXIBLE,
               any = joint->space == MBSR_SPACE_GENERAL || flexible;
    if (!any && joint->space != MBSR_SPACE_POINT && joint->space != MBSR_SPACE_PLANAR &&
        joint->space != MBSR_SPACE_SPATIAL) {
        return REFUSE(MBSR_ERR_VALUE, "%s: joint '%s': space is %d, no space of a body", label,
                      name, (int)joint->space);
    }
    if (joint->d < 1 || joint->d > MBSR_MAX_D) {
        return REFUSE(MBSR_ERR_VALUE, "%s: joint '%s': d is %d, must be 1 .. %d", label, name,
                      joint->d, MBSR_MAX_D);
    }
    if (flexible && (joint->d < 6 || joint->np != joint->d + 6)) {
        return REFUSE(MBSR_ERR_VALUE,
                      "%s: joint '%s': d = %d, np = %d; this space has d = 6 and np = 12, and the "
                      "number of modes more",
                      label, name, joint->d, joint->np);
    }
    if (!any && (joint->d != space_d[joint->space] || joint->np != space_np[joint->space])) {
        return REFUSE(MBSR_ERR_VALUE,
                      "%s: joint '%s': d = %d, np = %d; this space has d = %d, np = %d", label,
                      name, joint->d, joint->np, space_d[joint->space], space_np[joint->space]);
    }
    if (joint->np < 0 || joint->np > 4 * MBSR_MAX_D) {
        return REFUSE(MBSR_ERR_VALUE, "%s: joint '%s': np is %d", label, name, joint->np);
    }
    if (joint->n < 0 || joint->n > joint->d) {
        return REFUSE(MBSR_ERR_VALUE, "%s: joint '%s': n is %d, must be 0 .. d = %d", label, name,
                      joint->n, joint->d);
    }
    if (joint->nq < 0 || joint->nq > 4 * MBSR_MAX_D ||
        (!joint->table->coordinate_rates && joint->nq != joint->n)) {
        return REFUSE(MBSR_ERR_VALUE,
                      "%s: joint '%s': nq is %d, n is %d; they differ only with coordinate_rates",
                      label, name, joint->nq, joint->n);
    }
    if (joint->params < 0 || joint->params > MBSR_JOINT_PARAMS) {
        return REFUSE(MBSR_ERR_VALUE, "%s: joint '%s': params is %d, must be 0 .. %d", label, name,
                      joint->params, MBSR_JOINT_PARAMS);
    }
    for (int k = 0; k < joint->params; ++k) {
        if (!isfinite(joint->param[k])) {
            const char *field = joint->table->parameter ? joint->table->parameter(k) : "";
            return REFUSE(MBSR_ERR_VALUE, "%s: joint '%s': param[%d]%s is %g", label, name, k,
                          field, joint->param[k]);
        }
    }
    return check_own_fields(m, joint, id, label);
}

/* Symmetric, finite, positive semi-definite up to rounding: scaled to unit diagonal, the matrix
 * must be symmetric to 1e-12 and have no eigenvalue below -1e-12. */
static int check_mass_matrix(mbsr_model *m, int d, const double *A, int id, const char *label,
                             bool *regular)
{
    for (int j = 0; j < d; ++j) {
        for (int k = 0; k < d; ++k) {
            const double a = A[j * d + k], b = A[k * d + j];
            if (!isfinite(a))
                return REFUSE(MBSR_ERR_VALUE, "%s: inertia.matrix(%d,%d) is %g", label, k, j, a);
            const double scale =
                fabs(a) + fabs(b) + sqrt(fabs(A[j * d + j])) * sqrt(fabs(A[k * d + k]));
            if (fabs(a - b) > 1e-12 * scale) {
                return REFUSE(MBSR_ERR_VALUE,
                              "%s: inertia.matrix is not symmetric: (%d,%d) is %g, (%d,%d) is %g",
                              label, k, j, a, j, k, b);
            }
        }
        if (A[j * d + j] < 0.0) {
            return REFUSE(MBSR_ERR_VALUE, "%s: inertia.matrix(%d,%d) is %g, negative", label, j, j,
                          A[j * d + j]);
        }
    }
    const int lwork = mbsri_lapack_syev_work(d);
    const size_t size = (size_t)d * (size_t)d;
    double *S = mbsri_allocate(&m->allocator, (size + (size_t)d + (size_t)lwork) * sizeof *S);
    if (!S) return REFUSE(MBSR_ERR_NO_MEMORY, "%s: no memory to check inertia.matrix", label);
    int status = MBSR_OK;
    for (int j = 0; j < d; ++j) {
        for (int k = 0; k < d; ++k) {
            const double product = sqrt(A[j * d + j]) * sqrt(A[k * d + k]);
            if (product == 0.0 && A[j * d + k] != 0.0) {
                status =
                    REFUSE(MBSR_ERR_VALUE,
                           "%s: inertia.matrix is indefinite: (%d,%d) is %g beside a zero diagonal",
                           label, k, j, A[j * d + k]);
            }
            S[j * d + k] = product > 0.0 ? A[j * d + k] / product : 0.0;
        }
    }
    double *w = S + size, *work = w + d;
    if (!status && mbsri_lapack_syev(d, S, w, work, lwork) != 0) {
        status = REFUSE(MBSR_ERR_NUMERICS, "%s: the eigenvalues of inertia.matrix did not converge",
                        label);
    }
    if (!status && w[0] < -1e-12) {
        status = REFUSE(
            MBSR_ERR_VALUE,
            "%s: inertia.matrix is indefinite: scaled to unit diagonal it has the eigenvalue %g",
            label, w[0]);
    }
    *regular = !status && w[0] > 1e-8;
    mbsri_release(&m->allocator, S);
    return status;
}

/* Whether what the tensor leaves off is small beside it, as rounding is. */
static bool exact_enough(const mbsr_inertia *inertia)
{
    const double *tensor = inertia->tensor,
                 trace = fabs(tensor[0]) + fabs(tensor[1]) + fabs(tensor[2]);
    const double tolerance =
        1e-6 * trace + 1e-12 * inertia->mass * mbsri_dot(3, inertia->com, inertia->com);
    bool small = inertia->lost >= 0.0 && isfinite(inertia->lost);
    for (int k = 0; k < 6; ++k) small = small && fabs(inertia->tensor_rest[k]) <= tolerance;
    for (int k = 0; k < 3; ++k) small = small && isfinite(inertia->com_rest[k]);
    return small;
}

/* Mass and centre of mass of a rigid body in space, and the principal moments about the latter:
 * none negative, none larger than the sum of the others, up to 1e-6 of the largest and to what
 * rounding leaves of the parallel axes. */
static int check_rigid(mbsr_model *m, const mbsr_inertia *inertia, int id, const char *label,
                       bool *regular)
{
    enum { WORK = 102 };
    const double *c = inertia->com, *tensor = inertia->tensor;
    if (!(inertia->mass >= 0.0) || !isfinite(inertia->mass)) {
        return REFUSE(MBSR_ERR_VALUE, "%s: inertia.mass is %g, must be finite and not negative",
                      label, inertia->mass);
    }
    for (int k = 0; k < 6; ++k) {
        if (!isfinite(tensor[k]) || (k < 3 && !isfinite(c[k]))) {
            return REFUSE(MBSR_ERR_VALUE, "%s: inertia.%s[%d] is %g", label,
                          isfinite(tensor[k]) ? "com" : "tensor", k,
                          isfinite(tensor[k]) ? c[k] : tensor[k]);
        }
    }
    if (inertia->exact && !exact_enough(inertia)) {
        return REFUSE(MBSR_ERR_VALUE,
                      "%s: inertia.com_rest, tensor_rest and lost are not what rounding com and "
                      "tensor leaves: set inertia.exact to 0 where these are changed",
                      label);
    }
    double I[9] = {tensor[0], tensor[3], tensor[4], tensor[3], tensor[1],
                   tensor[5], tensor[4], tensor[5], tensor[2]};
    double moment[3], work[WORK];
    if (mbsri_lapack_syev(3, I, moment, work, WORK) != 0) {
        return REFUSE(MBSR_ERR_NUMERICS, "%s: the principal moments of inertia did not converge",
                      label);
    }
    const double size = inertia->mass * (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    const double tolerance = 1e-6 * fabs(moment[2]) + 1e-12 * size;
    if (!isfinite(size)) {
        return REFUSE(MBSR_ERR_VALUE,
                      "%s: inertia.mass is %g and inertia.com (%g, %g, %g): the moments about the "
                      "origin are not finite",
                      label, inertia->mass, c[0], c[1], c[2]);
    }
    if (inertia->unchecked && moment[0] < -tolerance) {
        return REFUSE(MBSR_ERR_VALUE,
                      "%s: inertia.tensor is indefinite: the principal moments about the centre of "
                      "mass are %g, %g, %g; none may be negative",
                      label, moment[0], moment[1], moment[2]);
    }
    /* where the smallest is negative, the largest is more than the sum of the others */
    if (!inertia->unchecked && moment[2] - moment[1] - moment[0] > tolerance) {
        return REFUSE(MBSR_ERR_VALUE,
                      "%s: no body has this inertia.tensor: the principal moments about the centre "
                      "of mass are %g, %g, %g; none may be negative or larger than the sum of the "
                      "other two",
                      label, moment[0], moment[1], moment[2]);
    }
    *regular = inertia->mass > 0.0 && moment[0] > 1e-8 * (moment[2] + size);
    return MBSR_OK;
}

static int check_planar(mbsr_model *m, const mbsr_inertia *inertia, int id, const char *label)
{
    if (!(inertia->mass >= 0.0) || !isfinite(inertia->mass)) {
        return REFUSE(MBSR_ERR_VALUE, "%s: inertia.mass is %g, must be finite and not negative",
                      label, inertia->mass);
    }
    if (!(inertia->moment >= 0.0) || !isfinite(inertia->moment)) {
        return REFUSE(MBSR_ERR_VALUE, "%s: inertia.moment is %g, must be finite and not negative",
                      label, inertia->moment);
    }
    if (!isfinite(inertia->com[0]) || !isfinite(inertia->com[1])) {
        return REFUSE(MBSR_ERR_VALUE, "%s: inertia.com is (%g, %g)", label, inertia->com[0],
                      inertia->com[1]);
    }
    return MBSR_OK;
}

int mbsri_check_inertia(mbsr_model *m, const mbsr_inertia *inertia, mbsr_space space, int d, int id,
                        const char *label, bool *regular)
{
    *regular = false;
    switch (inertia->kind) {
    case MBSR_INERTIA_NOT_GIVEN: return MBSR_OK;
    case MBSR_INERTIA_PARTICLE:
        if (space == MBSR_SPACE_GENERAL || space == MBSR_SPACE_FLEXIBLE) {
            return REFUSE(MBSR_ERR_SPACE,
                          "%s: a particle inertia needs a POINT, PLANAR or SPATIAL body", label);
        }
        *regular = space == MBSR_SPACE_POINT && inertia->mass > 0.0;
        return check_planar(m, inertia, id, label);
    case MBSR_INERTIA_PLANAR:
        if (space != MBSR_SPACE_PLANAR) {
            return REFUSE(MBSR_ERR_SPACE, "%s: a planar inertia needs a PLANAR body", label);
        }
        *regular = inertia->mass > 0.0 && inertia->moment > 0.0;
        return check_planar(m, inertia, id, label);
    case MBSR_INERTIA_MATRIX:
        if (!inertia->matrix && d > 0 && inertia->d != 0)
            return REFUSE(MBSR_ERR_NULL, "%s: inertia.matrix is NULL", label);
        if (inertia->d == 0 && !inertia->matrix) return MBSR_OK; /* zero of any size */
        if (space == MBSR_SPACE_FLEXIBLE)
            return REFUSE(MBSR_ERR_SPACE,
                          "%s: a flexible body's mass is that of its modes, no matrix", label);
        if (inertia->d != d) {
            return REFUSE(MBSR_ERR_VALUE, "%s: inertia.matrix is %d x %d, the body has d = %d",
                          label, inertia->d, inertia->d, d);
        }
        return check_mass_matrix(m, d, inertia->matrix, id, label, regular);
    case MBSR_INERTIA_SPATIAL:
        if (space != MBSR_SPACE_SPATIAL)
            return REFUSE(MBSR_ERR_SPACE, "%s: a rigid inertia needs a SPATIAL body", label);
        return check_rigid(m, inertia, id, label, regular);
    case MBSR_INERTIA_FLEXIBLE:
        if (!inertia->flex) return REFUSE(MBSR_ERR_NULL, "%s: inertia.flex is NULL", label);
        if (space != MBSR_SPACE_FLEXIBLE || d != 6 + inertia->flex->n)
            return REFUSE(MBSR_ERR_SPACE,
                          "%s: an inertia of %d modes needs a FLEXIBLE body of as many", label,
                          inertia->flex->n);
        return MBSR_OK;
    case MBSR_INERTIA_INVALID:
        return REFUSE(
            MBSR_ERR_VALUE,
            "%s: inertia was made from a negative dimension, from NULL, from a frame whose "
            "axes are not orthonormal, or as a sum of kinds other than rigid, particle and zero",
            label);
    case MBSR_INERTIA_FUNCTION:
        if (!inertia->function) return REFUSE(MBSR_ERR_NULL, "%s: inertia.function is NULL", label);
        return MBSR_OK;
    }
    return REFUSE(MBSR_ERR_VALUE, "%s: inertia.kind is %d, no such kind", label,
                  (int)inertia->kind);
}
