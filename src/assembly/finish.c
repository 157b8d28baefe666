/* Finishing a model: check the tree, number it parent before child, place every body's arrays.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/lapack.h"
#include "assembly/closures.h"
#include "assembly/groups.h"
#include "assembly/measure.h"
#include "assembly/order_forces.h"
#include "assembly/places.h"
#include "assembly/survey.h"
#include "assembly/welds.h"
#include "base/error.h"
#include "base/memory.h"
#include "forces/drive.h"
#include "joints/flexible.h"
#include "model/locked.h"
#include "model/query.h"
#include "recursion/flexible_factors.h"
#include "recursion/rates.h"
#include "fronts/choose.h"
#include "sweeps/build.h"

#include <limits.h>
#include <math.h>
#include <string.h>

/* Workspace while numbering; all by id except where said. */
typedef struct numbering {
    int *first; /* N + 1  first child of id - 1, the root at 0 */
    int *next;  /* N      next sibling */
    int *order; /* N      ids in depth-first order */
} numbering;

static void number_release(const mbsr_model *m, numbering *w)
{
    mbsri_release(&m->allocator, w->first);
    mbsri_release(&m->allocator, w->next);
    mbsri_release(&m->allocator, w->order);
}

static bool number_allocate(const mbsr_model *m, size_t N, numbering *w)
{
    w->first = mbsri_allocate(&m->allocator, (N + 1) * sizeof *w->first);
    w->next = mbsri_allocate(&m->allocator, N * sizeof *w->next);
    w->order = mbsri_allocate(&m->allocator, N * sizeof *w->order);
    return w->first && w->next && w->order;
}

static const char *entry_label(const mbsr_model *m, int id, char *buffer)
{
    const mbsri_body_entry *entry = m->entries.data;
    return mbsri_label(buffer, "body", id, (const char *)m->stored.names.data + entry[id].name);
}

/* Children of each body as linked lists in ascending id; refuses unknown predecessors. */
static int link_children(mbsr_model *m, int N, numbering *w)
{
    const mbsri_body_entry *entry = m->entries.data;
    char label[MBSRI_LABEL];
    for (int id = -1; id < N; ++id) w->first[id + 1] = MBSR_NONE;
    for (int id = N - 1; id >= 0; --id) {
        const int parent = entry[id].parent;
        if (parent >= N) {
            return mbsri_fail(&m->error, MBSR_ERR_ID, id, MBSR_NONE,
                              "%s: parent is %d, but there are only %d bodies",
                              entry_label(m, id, label), parent, N);
        }
        w->next[id] = w->first[parent + 1];
        w->first[parent + 1] = id;
    }
    return MBSR_OK;
}

/* A body that the walk did not reach hangs on a cycle; following its predecessors N times ends on
 * that cycle. */
static int report_cycle(mbsr_model *m, int N)
{
    const mbsri_body_entry *entry = m->entries.data;
    char label[MBSRI_LABEL], other[MBSRI_LABEL];
    int on = 0;
    while (m->index[on] >= 0) ++on;
    for (int k = 0; k < N; ++k) on = entry[on].parent;
    return mbsri_fail(
        &m->error, MBSR_ERR_CYCLE, on, MBSR_NONE,
        "%s: its predecessors form a cycle: parent is %s, and following them leads back",
        entry_label(m, on, label), entry_label(m, entry[on].parent, other));
}

/* Depth-first order without a stack: down to the first child, else across to the next sibling of
 * the nearest ancestor that has one. Sets index. */
static int walk(mbsr_model *m, int N, numbering *w)
{
    const mbsri_body_entry *entry = m->entries.data;
    int count = 0, id = w->first[0];
    for (int k = 0; k < N; ++k) m->index[k] = -1;
    while (id >= 0) {
        w->order[count++] = id;
        m->index[id] = count;
        int next = w->first[id + 1];
        while (next < 0 && id >= 0) {
            next = w->next[id];
            id = entry[id].parent;
        }
        id = next;
    }
    return count == N ? MBSR_OK : report_cycle(m, N);
}

static void place_root(mbsr_model *m)
{
    m->body[0] = (mbsri_body){.id = MBSR_GROUND,
                              .parent = -1,
                              .d = m->root.d,
                              .np = m->root.np,
                              .survey.in_sweeps = true,
                              .joint.space = m->root.space};
    m->most.d = m->root.d > 1 ? m->root.d : 1;
}

/* Body i, whose predecessor is there. */
static void number_body(mbsr_model *m, int i, int id, const mbsri_welds *w)
{
    const mbsri_body_entry *entry = (const mbsri_body_entry *)m->entries.data + id;
    mbsri_body *b = m->body + i;
    const mbsri_joint *joint = w->joint + id;
    const int parent = mbsri_welds_parent(m, w, id), locks = w->left[id] ? entry->locks : 0;
    *b = (mbsri_body){.id = id,
                      .parent = parent,
                      .d = joint->d,
                      .pred.d = m->body[parent].d,
                      .np = joint->np,
                      .n = joint->n - locks,
                      .nq = joint->nq - locks,
                      .joint = *joint,
                      .inertia = entry->inertia,
                      .pred.space = m->body[parent].joint.space,
                      .name = entry->name,
                      .mass.regular = entry->regular,
                      .lock.count = locks,
                      .mass.neglected = entry->neglected};
    if (b->inertia.kind == MBSR_INERTIA_MATRIX && b->inertia.matrix) {
        b->inertia.matrix = (const double *)m->stored.matrices.data + entry->matrix;
    }
    if (entry->added > 0) b->mass.added = (const double *)m->stored.matrices.data + entry->added;
    b->lock.given_at = mbsri_locked_values(m, id);
    if (locks > 0) b->lock.at = (const double *)m->stored.matrices.data + entry->locked_at;
    if (joint->d > m->most.d) m->most.d = joint->d;
    if (b->n > m->most.n) m->most.n = b->n;
    m->differences = m->differences || mbsri_rates_need_tree(b);
    if (mbsri_rates_room(m, b) > m->most.displaced) m->most.displaced = mbsri_rates_room(m, b);
}

/* Coordinates stand in the caller's q and u in the order of ids, in the data in that of the
 * sweeps. */
static int place_coordinates(mbsr_model *m, int N)
{
    long long nq = 0, nu = 0;
    for (int id = 0; id < N; ++id) {
        mbsri_body *b = m->body + m->index[id];
        b->q = (int)nq;
        b->u = (int)nu;
        nq += b->nq;
        nu += b->n;
        if (nq + nu > INT_MAX / 4) {
            return mbsri_fail(&m->error, MBSR_ERR_VALUE, id, MBSR_NONE,
                              "mbsr_model_finish: too many joint coordinates");
        }
    }
    m->nq = (int)nq;
    m->nu = (int)nu;
    for (int i = 1, iq = 0, iu = 0; i <= N; ++i) {
        m->body[i].iq = iq;
        m->body[i].iu = iu;
        iq += m->body[i].nq;
        iu += m->body[i].n;
    }
    return MBSR_OK;
}

/* That of the coordinates of body i that are not locked. */
static void place_armature(mbsr_model *m, int i)
{
    mbsri_body *b = m->body + i;
    const mbsri_body_entry *entry = (const mbsri_body_entry *)m->entries.data + b->id;
    const double *given = entry->armature > 0
                              ? (const double *)m->stored.matrices.data + entry->armature
                              : NULL,
                 *locked_at = mbsri_locked_values(m, b->id);
    double *to = m->armature + b->iu;
    b->mass.armature = to;
    for (int k = 0; k < entry->joint.n; ++k) {
        if (locked_at && !isnan(locked_at[k])) continue;
        *to++ = given ? given[k] : 0.0;
    }
}

/* Where the joint rates of the sweeps stand in the caller's vectors, and their armature. */
static int place_rates(mbsr_model *m, int N)
{
    m->armature = mbsri_allocate(&m->allocator, (size_t)m->nu * sizeof *m->armature);
    m->order.u_of = mbsri_allocate(&m->allocator, (size_t)m->nu * sizeof *m->order.u_of);
    m->order.q_of = mbsri_allocate(&m->allocator, (size_t)m->nq * sizeof *m->order.q_of);
    if (!m->armature || !m->order.u_of || !m->order.q_of) {
        return mbsri_fail(&m->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_finish: no memory");
    }
    for (int i = 1; i <= N; ++i) {
        const mbsri_body *b = m->body + i;
        place_armature(m, i);
        for (int k = 0; k < b->n; ++k) m->order.u_of[b->iu + k] = b->u + k;
        for (int k = 0; k < b->nq; ++k) m->order.q_of[b->iq + k] = b->q + k;
    }
    m->order.as_given = true;
    for (int k = 0; k < m->nu; ++k) m->order.as_given = m->order.as_given && m->order.u_of[k] == k;
    for (int k = 0; k < m->nq; ++k) m->order.as_given = m->order.as_given && m->order.q_of[k] == k;
    m->order.plain_rates = m->order.as_given;
    for (int i = 1; i <= N; ++i)
        m->order.plain_rates = m->order.plain_rates && !m->body[i].joint.table->coordinate_rates;
    return MBSR_OK;
}

/* A joint as the caller gave it, and the space and dimension of the predecessor that he gave. */
static mbsr_joint joint_as_given(const mbsr_model *m, int id, mbsr_space *space, int *d)
{
    const mbsri_body_entry *entry = (const mbsri_body_entry *)m->entries.data + id;
    const mbsri_joint *kept = &entry->joint,
                      *pred = &m->body[entry->parent == MBSR_GROUND ? 0 : m->index[entry->parent]]
                                   .joint;
    mbsr_joint joint = {MBSRI_JOINT_FIELDS(kept)};
    if (kept->params > 0)
        memcpy(joint.param, (const double *)m->stored.matrices.data + entry->param,
               (size_t)kept->params * sizeof *joint.param);
    memcpy(joint.option, kept->option, sizeof joint.option);
    *space = pred->space;
    *d = entry->parent == MBSR_GROUND ? m->root.d : pred->d;
    return joint;
}

/* A marker is one of the body it stands on, and a mount carries the body of its data. */
static int check_flexible(mbsr_model *m, int i)
{
    const mbsri_body *b = m->body + i, *pred = m->body + b->parent;
    const mbsr_flex *marker = mbsri_marker_of(b->joint.table, b->joint.user),
                    *mount = mbsri_mount_of(b->joint.table, b->joint.user);
    char label[MBSRI_LABEL];
    if (marker && marker != mbsri_mount_of(pred->joint.table, pred->joint.user))
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, b->id, MBSR_NONE,
                          "%s: joint 'marker': its predecessor, body %d, has other modal data",
                          mbsri_body_label(m, i, label), pred->id);
    if (mount && b->inertia.kind == MBSR_INERTIA_FLEXIBLE && b->inertia.flex != mount)
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, b->id, MBSR_NONE,
                          "%s: joint 'mount': the inertia is of other modal data",
                          mbsri_body_label(m, i, label));
    return MBSR_OK;
}

/* Each joint may refuse the predecessor it was put on. */
static int check_joints(mbsr_model *m, int N)
{
    for (int i = 1; i <= N; ++i) {
        mbsri_body *b = m->body + i;
        b->flexible.modal = mbsri_mount_of(b->joint.table, b->joint.user) && b->lock.count == 0;
        b->flexible.upright =
            b->flexible.modal && mbsri_mount_rests(b->joint.user, b->joint.option[0]);
        if (!b->joint.table->check) continue;
        char text[MBSR_TEXT_SIZE] = "", label[MBSRI_LABEL];
        mbsr_space space;
        int d;
        const mbsr_joint joint = joint_as_given(m, b->id, &space, &d);
        const int status = joint.table->check(&joint, space, d, text);
        if (status) {
            return mbsri_fail(&m->error, status, b->id, MBSR_NONE, "%s: joint '%s': %.120s",
                              mbsri_body_label(m, i, label), b->joint.table->name,
                              text[0] ? text : mbsr_status_text(status));
        }
        const int other = check_flexible(m, i);
        if (other) return other;
    }
    return MBSR_OK;
}

static int check_force(mbsr_model *m, int id, mbsr_force_body *bodies)
{
    const mbsri_force *force = (const mbsri_force *)m->forces.data + id;
    const mbsr_force_table *table = force->def.table;
    const mbsri_body_entry *entry = m->entries.data;
    const bool named = mbsri_force_coordinates(&force->def) > 0;
    if (!table->check || (table->flags & MBSR_FORCE_EVERY_BODY)) return MBSR_OK;
    for (int k = 0; k < force->def.bodies; ++k) {
        const mbsri_body *b = m->body + m->stored.list_index[force->list + (size_t)k];
        bodies[k] = (mbsr_force_body){.id = b->id,
                                      .space = b->joint.space,
                                      .d = b->d,
                                      .np = b->np,
                                      .n = b->n,
                                      .nq = b->nq,
                                      .locked_at = b->lock.given_at};
        if (!named || b->id == MBSR_GROUND) continue;
        bodies[k].n = entry[b->id].joint.n;
        bodies[k].nq = entry[b->id].joint.nq;
    }
    char text[MBSR_TEXT_SIZE] = "", label[MBSRI_LABEL], on[MBSRI_LABEL];
    const mbsr_force_args args = {
        .force = &force->def, .bodies = force->def.bodies, .body = bodies};
    const int status = table->check(&args, text);
    if (!status) return MBSR_OK;
    const bool one = force->def.bodies == 1 && bodies->id != MBSR_GROUND;
    return mbsri_fail(
        &m->error, status, MBSR_NONE, id, "%s (%s)%s%s: %.120s",
        mbsri_label(label, "force", id, (const char *)m->stored.names.data + force->name),
        table->name, one ? " on " : "",
        one ? mbsri_body_label(m, m->stored.list_index[force->list], on) : "",
        text[0] ? text : mbsr_status_text(status));
}

/* What an element wants of every data object. */
static int find_needs(mbsr_model *m, mbsri_force *force)
{
    const mbsr_force_table *table = force->def.table;
    char label[MBSRI_LABEL];
    force->needs = (mbsr_force_needs){0};
    force->memory = m->elements.memory;
    if (table->needs) table->needs(&force->def, &force->needs);
    if (table->flags & MBSR_FORCE_BY_PAIRS && force->needs.pairs == 0)
        force->needs.pairs = 1; /* it stays an element by pairs where none can act */
    if (force->needs.pairs < 0 || force->needs.pairs > INT_MAX - m->elements.pairs) {
        return mbsri_fail(&m->error, MBSR_ERR_VALUE, MBSR_NONE, force->id,
                          "%s (%s): needs.pairs is %d",
                          mbsri_label(label, "force", force->id,
                                      (const char *)m->stored.names.data + force->name),
                          table->name, force->needs.pairs);
    }
    m->elements.memory +=
        (force->needs.bytes + MBSR_DATA_ALIGNMENT - 1) / MBSR_DATA_ALIGNMENT * MBSR_DATA_ALIGNMENT;
    m->elements.pairs += force->needs.pairs;
    if (force->needs.pairs > m->most.pairs) m->most.pairs = force->needs.pairs;
    return MBSR_OK;
}

/* Bodies of force elements by index; each element may refuse its bodies. */
static int resolve_forces(mbsr_model *m, int N)
{
    const mbsri_force *force = m->forces.data;
    char label[MBSRI_LABEL];
    for (size_t id = 0; id < m->forces.count; ++id) {
        for (int k = 0; k < force[id].def.bodies; ++k) {
            const size_t at = force[id].list + (size_t)k;
            const int body = ((const int *)m->stored.lists.data)[at];
            if (body >= N) {
                return mbsri_fail(&m->error, MBSR_ERR_ID, MBSR_NONE, (int)id,
                                  "%s (%s): acts on body %d, but there are only %d bodies",
                                  mbsri_label(label, "force", (int)id,
                                              (const char *)m->stored.names.data + force[id].name),
                                  force[id].def.table->name, body, N);
            }
            m->stored.list_index[at] = body == MBSR_GROUND ? 0 : m->index[body];
        }
        if (force[id].def.bodies > m->most.element_bodies)
            m->most.element_bodies = force[id].def.bodies;
    }
    const size_t most = m->most.element_bodies > 0 ? (size_t)m->most.element_bodies : 1;
    m->most.element_bodies = (int)most;
    mbsr_force_body *bodies = mbsri_allocate(&m->allocator, most * sizeof *bodies);
    if (!bodies)
        return mbsri_fail(&m->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_finish: no memory");
    int status = MBSR_OK;
    for (size_t id = 0; id < m->forces.count && !status; ++id) {
        status = check_force(m, (int)id, bodies);
        if (!status) status = find_needs(m, (mbsri_force *)m->forces.data + id);
    }
    mbsri_release(&m->allocator, bodies);
    return status;
}

/* Whether all bodies have inertia in all directions. */
static bool is_regular(const mbsr_model *m)
{
    bool regular = true;
    for (int i = 1; i <= m->bodies; ++i) regular = regular && m->body[i].mass.regular;
    return regular;
}

/* Groups of joints and which of them are whole; both may need a position of the tree: of a model
 * finished but for this. */
static bool group_joints(mbsr_model *m, int N)
{
    m->most.lapack_work = mbsri_lapack_syev_work(m->most.n);
    m->finished = true;
    bool built = mbsri_groups_build(m);
    m->most.lapack_work = mbsri_lapack_syev_work(m->most.n);
    built = built && mbsri_measure(m) && mbsri_survey(m);
    m->finished = false;
    built = built && mbsri_sweeps_build_others(m);
    mbsri_places_see(m);
    mbsri_places_set(m, N);
    built = built && mbsri_groups_place(m);
    built = built && (m->rows == 0 || mbsri_plan_create(m, is_regular(m), &m->plan));
    if (built) mbsri_factors_find(m);
    return built;
}

static int no_memory_for_finish(mbsr_model *m)
{
    return mbsri_fail(&m->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "mbsr_model_finish: no memory");
}

/* Returned where bodies that others are welded to are none of the sweeps' own. */
enum { WELDS_NOT_SERVED = 1 };

/* Numbers and places everything, with bodies welded to others or not; what it sets is forgotten by
 * undo. */
static int build_tree(mbsr_model *m, int N, numbering *w, bool weld)
{
    int status = link_children(m, N, w);
    if (!status) status = walk(m, N, w);
    if (status) return status;
    mbsri_welds welds;
    m->bodies = N;
    place_root(m);
    if (mbsri_welds_find(m, N, w->first, w->next, w->order, weld, &welds)) {
        for (int i = 1; i <= N; ++i) number_body(m, i, w->order[i - 1], &welds);
        mbsri_welds_list(m);
    } else {
        status = no_memory_for_finish(m);
    }
    mbsri_welds_release(m, &welds);
    if (status) return status;
    mbsri_places_set(m, N);
    status = place_coordinates(m, N);
    if (!status) status = check_joints(m, N);
    if (!status) status = resolve_forces(m, N);
    if (!status) status = place_rates(m, N);
    if (!status) status = mbsri_closures_resolve(m, N);
    const bool built = status || m->rows > 0 || mbsri_sweeps_build(m);
    if (!status && !(built && group_joints(m, N))) status = no_memory_for_finish(m);
    if (status) return status;
    if (!mbsri_welds_served(m)) return WELDS_NOT_SERVED;
    return mbsri_order_forces(m, N, w->first);
}

static void undo(mbsr_model *m)
{
    mbsri_release(&m->allocator, m->index);
    mbsri_release(&m->allocator, m->stored.list_index);
    mbsri_release(&m->allocator, m->armature);
    mbsri_release(&m->allocator, m->order.u_of);
    mbsri_release(&m->allocator, m->order.q_of);
    mbsri_release(&m->allocator, m->order.member);
    mbsri_release(&m->allocator, m->typical.inertia);
    mbsri_release(&m->allocator, m->typical.weight);
    mbsri_release(&m->allocator, m->typical.span);
    mbsri_release(&m->allocator, m->stand);
    mbsri_release(&m->allocator, m->stored.joint_param);
    mbsri_release(&m->allocator, m->elements.along.element);
    mbsri_release(&m->allocator, m->body);
    mbsri_sweeps_release(m);
    mbsri_plan_destroy(m, m->plan);
    m->plan = NULL;
    mbsri_closures_forget(m);
    m->index = m->stored.list_index = NULL;
    m->body = NULL;
    m->stand = NULL;
    m->stored.joint_param = m->armature = NULL;
    m->order = (mbsri_orders){.u_of = NULL};
    m->typical = (mbsri_scales){.inertia = NULL};
    m->elements = (mbsri_elements){.idle = m->elements.idle};
    m->most = (mbsri_maxima){0};
    m->size = m->in_sweeps = (mbsri_lengths){0};
    m->differences = false;
    m->bodies = m->live = m->nq = m->nu = m->rows = m->position_rows = 0;
    m->size_c = 0;
}

/* Everything that finishing a model sets, or nothing of it. */
static int number(mbsr_model *m, bool weld)
{
    const size_t N = m->entries.count;
    numbering w = {NULL, NULL, NULL};
    m->index = mbsri_allocate(&m->allocator, N * sizeof *m->index);
    m->stored.list_index =
        mbsri_allocate(&m->allocator, m->stored.lists.count * sizeof *m->stored.list_index);
    m->body = mbsri_allocate(&m->allocator, (N + 1) * sizeof *m->body);
    const bool memory = number_allocate(m, N, &w) && m->index && m->stored.list_index && m->body;
    const int status = memory ? build_tree(m, (int)N, &w, weld) : no_memory_for_finish(m);
    number_release(m, &w);
    if (status) undo(m);
    return status;
}

int mbsr_model_finish(mbsr_model *model)
{
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    if (m->finished) {
        return mbsri_fail(&m->error, MBSR_ERR_FINISHED, MBSR_NONE, MBSR_NONE,
                          "mbsr_model_finish: the model is finished");
    }
    int status = number(m, true);
    if (status == WELDS_NOT_SERVED) status = number(m, false);
    m->finished = status == MBSR_OK;
    return status;
}
