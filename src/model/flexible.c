/* Adding flexible bodies and their markers.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/cookie.h"
#include "base/error.h"
#include "joints/flexible.h"
#include "model/record.h"

mbsr_flexible_def mbsr_default_flexible_def(void)
{
    return (mbsr_flexible_def){.cookie = MBSRI_COOKIE, .parent = MBSR_GROUND};
}

/* How much of the model's arrays is in use. */
typedef struct extent {
    size_t entries, forces, names, matrices, lists;
} extent;

static extent extent_of(const mbsr_model *m)
{
    return (extent){m->entries.count, m->forces.count, m->stored.names.count,
                    m->stored.matrices.count, m->stored.lists.count};
}

/* What has been added since is forgotten. */
static void take_back(mbsr_model *m, const extent *to)
{
    m->entries.count = to->entries;
    m->forces.count = to->forces;
    m->stored.names.count = to->names;
    m->stored.matrices.count = to->matrices;
    m->stored.lists.count = to->lists;
}

/* The body without mass that the joint moves. */
static int add_carrier(mbsr_model *m, const mbsr_flexible_def *def, int *id)
{
    mbsr_body_def carrier = mbsr_default_body_def();
    carrier.parent = def->parent;
    carrier.joint = def->joint;
    carrier.inertia = mbsr_inertia_zero();
    return mbsr_model_add_body(m, &carrier, id);
}

static int add_carrier_and_body(mbsr_model *m, const mbsr_flexible_def *def, int *body)
{
    mbsr_body_def flexible = mbsr_default_body_def();
    int status = MBSR_OK;
    flexible.name = def->name;
    flexible.parent = def->parent;
    flexible.joint = mbsr_joint_mount(def->flex, def->marker);
    flexible.inertia = mbsr_inertia_flexible(def->flex);
    if (def->joint.table) status = add_carrier(m, def, &flexible.parent);
    if (!status) status = mbsr_model_add_body(m, &flexible, body);
    if (status) return status;
    mbsr_force_def elastic = mbsr_force_elastic(*body, def->flex);
    elastic.name = def->name;
    return mbsr_model_add_force(m, &elastic, NULL);
}

int mbsr_model_add_flexible(mbsr_model *model, const mbsr_flexible_def *def, int *body)
{
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    if (!def)
        return mbsri_fail(&m->error, MBSR_ERR_NULL, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_add_flexible: the definition is NULL");
    if (def->cookie != MBSRI_COOKIE)
        return mbsri_fail(&m->error, MBSR_ERR_NO_DEFAULT, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_add_flexible: the definition was not made by "
                          "mbsr_default_flexible_def");
    const extent before = extent_of(m);
    int id = MBSR_NONE;
    const int status = add_carrier_and_body(m, def, &id);
    if (status)
        take_back(m, &before);
    else if (body)
        *body = id;
    return status;
}

int mbsr_model_add_marker(mbsr_model *model, int body, int marker, const char *name, int *id)
{
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    if (!m->finished && (body < 0 || (size_t)body >= m->entries.count))
        return mbsri_fail(&m->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_add_marker: body is %d, but there are %d bodies", body,
                          (int)m->entries.count);
    mbsr_body_def def = mbsr_default_body_def();
    const mbsri_body_entry *on =
        (const mbsri_body_entry *)m->entries.data + (m->finished ? 0 : body);
    const mbsr_flex *flex = m->finished ? NULL : mbsri_mount_of(on->joint.table, on->joint.user);
    if (!m->finished && !flex)
        return mbsri_fail(&m->error, MBSR_ERR_SPACE, body, MBSR_NONE,
                          "mbsr_model_add_marker: body %d is not flexible", body);
    def.name = name;
    def.parent = body;
    def.joint = mbsr_joint_marker(flex, marker);
    def.inertia = mbsr_inertia_zero();
    return mbsr_model_add_body(m, &def, id);
}
