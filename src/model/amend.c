/* Amendments that a caller states: mass added to a body, joint coordinates locked.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/error.h"
#include "base/memory.h"
#include "joints/chain.h"
#include "model/check.h"
#include "model/entry.h"
#include "model/query.h"

#include <mbsrank/driver.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *amended_label(const mbsr_model *m, const mbsri_body_entry *entry, int body,
                                 char *buffer)
{
    return mbsri_label(buffer, "body", body, (const char *)m->stored.names.data + entry->name);
}

/* Room for `size` doubles in the model, at the offset returned; the model's array starts with one
 * unused number, so that 0 means none. */
static size_t reserve_doubles(mbsr_model *m, size_t size, int body)
{
    if (!mbsri_reserve(&m->allocator, &m->stored.matrices, size + 1, sizeof(double))) {
        mbsri_fail(&m->error, MBSR_ERR_NO_MEMORY, body, MBSR_NONE, "body %d: no memory", body);
        return 0;
    }
    if (m->stored.matrices.count == 0)
        ((double *)m->stored.matrices.data)[m->stored.matrices.count++] = 0.0;
    const size_t offset = m->stored.matrices.count;
    m->stored.matrices.count += size;
    return offset;
}

int mbsr_model_regularise(mbsr_model *model, int body, int d, const double *matrix)
{
    static const char function[] = "mbsr_model_regularise";
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    int status;
    mbsri_body_entry *entry = mbsri_find_entry(m, body, function, &status);
    if (!entry) return status;
    char label[MBSRI_LABEL], culprit[MBSRI_LABEL + sizeof function + 2];
    snprintf(culprit, sizeof culprit, "%s: %s", amended_label(m, entry, body, label), function);
    if (!matrix || d < 1) {
        return mbsri_fail(&m->error, matrix ? MBSR_ERR_VALUE : MBSR_ERR_NULL, body, MBSR_NONE,
                          "%s: %s", culprit, matrix ? "d must be positive" : "matrix is NULL");
    }
    if (entry->added > 0) {
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, body, MBSR_NONE,
                          "%s: the body has a regularisation already", culprit);
    }
    const mbsr_inertia inertia = mbsr_inertia_matrix(d, matrix);
    bool regular;
    status = mbsri_check_inertia(m, &inertia, entry->joint.space, entry->joint.d, body, culprit,
                                 &regular);
    if (status) return status;
    const size_t size = (size_t)d * (size_t)d, offset = reserve_doubles(m, size, body);
    if (offset == 0) return MBSR_ERR_NO_MEMORY;
    memcpy((double *)m->stored.matrices.data + offset, matrix, size * sizeof *matrix);
    entry->added = offset;
    entry->regular = entry->regular || regular;
    return MBSR_OK;
}

/* Whether the body's coordinate can be locked at the value. */
static int check_lock(mbsr_model *m, const mbsri_body_entry *entry, int body, int coordinate,
                      double value)
{
    const mbsri_joint *joint = &entry->joint;
    char label[MBSRI_LABEL];
    amended_label(m, entry, body, label);
    if (joint->nq != joint->n || joint->table->coordinate_rates) {
        return mbsri_fail(
            &m->error, MBSR_ERR_SPACE, body, MBSR_NONE,
            "%s: mbsr_model_lock: the coordinates of joint '%s' have rates other than "
            "u (nq = %d, n = %d)",
            label, joint->table->name, joint->nq, joint->n);
    }
    if (coordinate < 0 || coordinate >= joint->n) {
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, body, MBSR_NONE,
                          "%s: mbsr_model_lock: coordinate is %d, joint '%s' has %d", label,
                          coordinate, joint->table->name, joint->n);
    }
    if (!isfinite(value)) {
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, body, MBSR_NONE,
                          "%s: mbsr_model_lock: value is %g", label, value);
    }
    if (entry->locked_at > 0 &&
        !isnan(((const double *)m->stored.matrices.data)[entry->locked_at + (size_t)coordinate])) {
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, body, MBSR_NONE,
                          "%s: mbsr_model_lock: coordinate %d is locked already", label,
                          coordinate);
    }
    return MBSR_OK;
}

int mbsr_model_lock(mbsr_model *model, int body, int coordinate, double value)
{
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    int status;
    mbsri_body_entry *entry = mbsri_find_entry(m, body, "mbsr_model_lock", &status);
    if (!status) status = check_lock(m, entry, body, coordinate, value);
    if (status) return status;
    if (entry->locked_at == 0) {
        const size_t n = (size_t)entry->joint.n, offset = reserve_doubles(m, n, body);
        if (offset == 0) return MBSR_ERR_NO_MEMORY;
        for (size_t k = 0; k < n; ++k) ((double *)m->stored.matrices.data)[offset + k] = NAN;
        entry->locked_at = offset;
    }
    ((double *)m->stored.matrices.data)[entry->locked_at + (size_t)coordinate] = value;
    ++entry->locks;
    return MBSR_OK;
}

int mbsr_model_drop_locked(mbsr_model *model, int body)
{
    if (!model) return MBSR_ERR_NULL;
    int status;
    mbsri_body_entry *entry = mbsri_find_entry(model, body, "mbsr_model_drop_locked", &status);
    if (!status) entry->drops_locked = true;
    return status;
}

/* A status: another motion in the place of one that is there. */
static int replace_motion(mbsr_model *m, const char *label, int body, mbsr_motion_fn *motion,
                          void **user, mbsr_motion_fn new_motion, void *new_user)
{
    if (!new_motion)
        return mbsri_fail(&m->error, MBSR_ERR_NULL, body, MBSR_NONE, "%s: motion is NULL", label);
    if (!*motion)
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, body, MBSR_NONE, "%s: it follows no motion",
                          label);
    *motion = new_motion;
    *user = new_user;
    return MBSR_OK;
}

int mbsr_model_drive(mbsr_model *model, int body, mbsr_motion_fn motion, void *user)
{
    static const char function[] = "mbsr_model_drive";
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    int status;
    mbsri_body_entry *entry = mbsri_find_entry(m, body, function, &status);
    if (status) return status;
    char label[MBSRI_LABEL], culprit[MBSRI_LABEL + sizeof function + 2];
    snprintf(culprit, sizeof culprit, "%s: %s", amended_label(m, entry, body, label), function);
    return replace_motion(m, culprit, body, &entry->joint.motion, &entry->joint.user, motion, user);
}

int mbsr_model_drive_closure(mbsr_model *model, int closure, mbsr_motion_fn motion, void *user)
{
    static const char function[] = "mbsr_model_drive_closure";
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    if (m->finished)
        return mbsri_fail(&m->error, MBSR_ERR_FINISHED, MBSR_NONE, MBSR_NONE,
                          "%s: the model is finished", function);
    if (closure < 0 || (size_t)closure >= m->closures.count)
        return mbsri_fail(&m->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                          "%s: there is no closure %d", function, closure);
    mbsri_closure *c = (mbsri_closure *)m->closures.data + closure;
    char label[MBSRI_LABEL], culprit[MBSRI_LABEL + sizeof function + 2];
    mbsri_label(label, "closure", closure, (const char *)m->stored.names.data + c->name);
    snprintf(culprit, sizeof culprit, "%s: %s", label, function);
    return replace_motion(m, culprit, MBSR_NONE, &c->def.motion, &c->def.user, motion, user);
}

/* Whether rates k and l are two of one quaternion. */
static bool same_quaternion(const mbsri_joint *joint, int k, int l)
{
    return joint->nq > joint->n && k < 3 && l < 3;
}

static int check_armature(mbsr_model *m, const mbsri_body_entry *entry, int body, int n,
                          const double *values)
{
    const mbsri_joint *joint = &entry->joint;
    char label[MBSRI_LABEL];
    amended_label(m, entry, body, label);
    if (!values && n > 0)
        return mbsri_fail(&m->error, MBSR_ERR_NULL, body, MBSR_NONE,
                          "%s: mbsr_model_armature: values is NULL", label);
    if (n != joint->n) {
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, body, MBSR_NONE,
                          "%s: mbsr_model_armature: n is %d, joint '%s' has %d rates", label, n,
                          joint->table->name, joint->n);
    }
    if (joint->table->coordinate_rates && joint->table->position != mbsri_chain_position) {
        return mbsri_fail(&m->error, MBSR_ERR_SPACE, body, MBSR_NONE,
                          "%s: mbsr_model_armature: the coordinates of joint '%s' have rates other "
                          "than u",
                          label, joint->table->name);
    }
    for (int k = 0; k < n; ++k) {
        if (!isfinite(values[k]) || values[k] < 0.0) {
            return mbsri_fail(&m->error, MBSR_ERR_VALUE, body, MBSR_NONE,
                              "%s: mbsr_model_armature: values[%d] is %g", label, k, values[k]);
        }
        if (same_quaternion(joint, 0, k) && values[k] != values[0]) {
            return mbsri_fail(
                &m->error, MBSR_ERR_VALUE, body, MBSR_NONE,
                "%s: mbsr_model_armature: values[%d] is %g and values[0] %g, but both "
                "belong to the quaternion of joint '%s'",
                label, k, values[k], values[0], joint->table->name);
        }
    }
    return MBSR_OK;
}

int mbsr_model_armature(mbsr_model *model, int body, int n, const double *values)
{
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    int status;
    mbsri_body_entry *entry = mbsri_find_entry(m, body, "mbsr_model_armature", &status);
    if (!status) status = check_armature(m, entry, body, n, values);
    if (status || n == 0) return status;
    if (entry->armature == 0) entry->armature = reserve_doubles(m, (size_t)n, body);
    if (entry->armature == 0) return MBSR_ERR_NO_MEMORY;
    memcpy((double *)m->stored.matrices.data + entry->armature, values, (size_t)n * sizeof *values);
    return MBSR_OK;
}

const double *mbsr_body_armature(const mbsr_model *model, int body)
{
    if (!model || !model->finished) return NULL;
    const int i = mbsri_index(model, body);
    return i > 0 ? model->body[i].mass.armature : NULL;
}

const double *mbsr_body_regularisation(const mbsr_model *model, int body)
{
    if (!model || !model->finished) return NULL;
    const int i = mbsri_index(model, body);
    return i > 0 ? model->body[i].mass.added : NULL;
}

int mbsr_body_locks(const mbsr_model *model, int body)
{
    if (!model || !model->finished || body < 0 || body >= model->bodies) return -1;
    return ((const mbsri_body_entry *)model->entries.data)[body].locks;
}

const double *mbsr_body_locked(const mbsr_model *model, int body)
{
    if (mbsr_body_locks(model, body) <= 0) return NULL;
    const mbsri_body_entry *entry = (const mbsri_body_entry *)model->entries.data + body;
    return (const double *)model->stored.matrices.data + entry->locked_at;
}

int mbsr_body_drops(const mbsr_model *model, int body)
{
    if (mbsr_body_locks(model, body) < 0) return -1;
    return ((const mbsri_body_entry *)model->entries.data)[body].drops_locked;
}
