/* Bodies that are welded to others: see welds.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "assembly/welds.h"

#include "assembly/locked_joints.h"
#include "base/memory.h"
#include "forces/gravity.h"
#include "inertias/exact.h"
#include "model/locked.h"
#include "sweeps/embed.h"
#include "sweeps/tree.h"

#include <string.h>

/* What is looked at while bodies are chosen, by id. */
typedef struct choice {
    const mbsr_model *m;
    const int *first, *next;
    mbsri_welds *w;
    bool *acted; /* elements or closures are on the body */
    bool every;  /* or on every one */
} choice;

static const mbsri_body_entry *entry_of_body(const mbsr_model *m, int id)
{
    return (const mbsri_body_entry *)m->entries.data + id;
}

/* ---- joints ---- */

/* The joint as it was added. */
static mbsri_joint joint_of(const mbsr_model *m, int id)
{
    const mbsri_body_entry *entry = entry_of_body(m, id);
    mbsri_joint joint = entry->joint;
    if (joint.params > 0) joint.param = (const double *)m->stored.matrices.data + entry->param;
    return joint;
}

/* Whether it may get parameters of its own. */
static bool may_change(const mbsr_model *m, int id)
{
    const mbsri_body_entry *entry = entry_of_body(m, id);
    if (entry->locks > 0) return true;
    if (entry->parent == MBSR_GROUND) return false;
    const mbsri_body_entry *pred = entry_of_body(m, entry->parent);
    return pred->joint.n == pred->locks;
}

/* Joints without the coordinates that are locked; *param: room for those that may change. */
static void hold_joints(const mbsr_model *m, int N, double *param, mbsri_welds *w)
{
    for (int id = 0; id < N; ++id) {
        const double *locked_at = mbsri_locked_values(m, id);
        const mbsri_joint given = joint_of(m, id);
        w->joint[id] = given;
        w->left[id] = locked_at && !mbsri_lock_joint(&given, locked_at, param, w->joint + id);
        if (w->left[id]) w->joint[id] = given;
        if (may_change(m, id)) param += MBSRI_LOCKED_PARAMS;
    }
}

/* Joints on bodies that are welded stand on what these are welded to. */
static void carry_joints(const mbsr_model *m, int N, double *param, mbsri_welds *w)
{
    for (int id = 0; id < N; ++id) {
        const int parent = entry_of_body(m, id)->parent;
        mbsri_joint *joint = w->joint + id;
        if (!may_change(m, id)) continue;
        if (parent != MBSR_GROUND && w->stand[parent].host != parent && w->stand[id].host == id) {
            if (joint->param != param)
                memcpy(param, joint->param, (size_t)joint->params * sizeof *param);
            joint->param = param;
            mbsri_carry_joint(joint, w->stand + parent, param);
        }
        param += MBSRI_LOCKED_PARAMS;
    }
}

/* ---- which bodies ---- */

/* Bodies on which something acts that does not rest. */
static void mark_acted(choice *c)
{
    const mbsr_model *m = c->m;
    const mbsri_force *force = m->forces.data;
    const mbsri_closure *closure = m->closures.data;
    const int N = (int)m->entries.count;
    for (size_t k = 0; k < m->forces.count; ++k) {
        const mbsr_force_def *def = &force[k].def;
        if (mbsri_is_gravity(def) || force[k].resting) continue;
        if (def->table->flags & MBSR_FORCE_EVERY_BODY) c->every = true;
        for (int l = 0; l < def->bodies; ++l) {
            const int id = ((const int *)m->stored.lists.data)[force[k].list + (size_t)l];
            if (id >= 0 && id < N) c->acted[id] = true;
        }
    }
    for (size_t k = 0; k < m->closures.count; ++k) {
        for (int l = 0; l < closure[k].def.bodies; ++l) {
            const int id = closure[k].def.body[l];
            const bool counts = !mbsri_term_is_held(m, &closure[k].def, l);
            if (id >= 0 && id < N && counts) c->acted[id] = true;
        }
    }
}

/* Whether the sweeps know its inertia with all digits. */
static bool plain_inertia(const choice *c, int id)
{
    const mbsri_body_entry *entry = entry_of_body(c->m, id);
    const mbsri_body body = {
        .joint = entry->joint,
        .inertia = entry->inertia,
        .mass.added = entry->added > 0 ? (const double *)c->m->stored.matrices.data : NULL};
    return mbsri_embeds_inertia(&body) && !(entry->inertia.kind == MBSR_INERTIA_SPATIAL &&
                                            mbsri_exact_hides_moment(&entry->inertia));
}

/* Whether body `host` can carry others in a space: one of a stock joint, or the root. */
static bool carries(const choice *c, int host, mbsr_space space)
{
    if (host == MBSR_GROUND)
        return c->m->root.space == MBSR_SPACE_FIXED || c->m->root.space == space;
    const mbsri_joint *joint = c->w->joint + host;
    return joint->space == space && !c->w->left[host] && mbsri_joint_has_frames(joint) &&
           plain_inertia(c, host);
}

/* Whether every joint on the body can stand on another. */
static bool may_be_moved(const choice *c, int id, mbsr_space space)
{
    bool all = true;
    for (int child = c->first[id + 1]; child >= 0; child = c->next[child]) {
        const mbsri_joint *joint = c->w->joint + child;
        const bool flat = space == MBSR_SPACE_PLANAR && joint->space == MBSR_SPACE_POINT;
        all = all && mbsri_joint_has_frames(joint) && (joint->space == space || flat);
    }
    return all;
}

/* Welds a body, whose predecessor has been looked at, if that is possible. */
static void weld(const choice *c, int id)
{
    mbsri_stand *stand = c->w->stand + id, *pred;
    const int parent = entry_of_body(c->m, id)->parent;
    const mbsri_joint *joint = c->w->joint + id;
    const mbsr_space space = joint->space;
    if ((space != MBSR_SPACE_SPATIAL && space != MBSR_SPACE_PLANAR) || c->acted[id] || c->every)
        return;
    if (c->w->left[id] || !mbsri_joint_has_frames(joint) || !plain_inertia(c, id)) return;
    const int host = parent == MBSR_GROUND ? parent : c->w->stand[parent].host;
    if (!carries(c, host, space) || !may_be_moved(c, id, space) || !mbsri_rigid_joint(joint, stand))
        return;
    stand->host = host;
    if (host == parent) return;
    pred = c->w->stand + parent;
    stand->frame = mbsr_frame_product(&pred->frame, &stand->frame);
    stand->angle += pred->angle;
}

/* ---- the order ---- */

/* Those that are not welded first; `other`: N. */
static void put_welded_last(mbsr_model *m, int N, const mbsri_welds *w, int *order, int *other)
{
    int live = 0, welded = 0;
    for (int k = 0; k < N; ++k) {
        const int id = order[k];
        if (w->stand[id].host == id)
            order[live++] = id;
        else
            other[welded++] = id;
    }
    memcpy(order + live, other, (size_t)welded * sizeof *order);
    for (int k = 0; k < N; ++k) m->index[order[k]] = k + 1;
    m->live = live;
    for (int k = 0; k < welded; ++k) {
        mbsri_stand *stand = m->stand + k;
        *stand = w->stand[other[k]];
        stand->host = stand->host == MBSR_GROUND ? 0 : m->index[stand->host];
    }
}

static void mark_resting(mbsr_model *m)
{
    mbsri_force *force = m->forces.data;
    const int *lists = m->stored.lists.data; /* NULL where no element has a list */
    for (size_t k = 0; k < m->forces.count; ++k)
        force[k].resting =
            mbsri_force_rests(m, &force[k].def, lists ? lists + force[k].list : NULL);
}

static bool weld_bodies(mbsr_model *m, int N, mbsri_welds *w)
{
    const size_t bodies = (size_t)N;
    size_t changed = 0, rigid = 0;
    for (int id = 0; id < N; ++id) {
        changed += may_change(m, id);
        rigid += entry_of_body(m, id)->joint.n == entry_of_body(m, id)->locks;
    }
    *w = (mbsri_welds){mbsri_allocate(&m->allocator, bodies * sizeof *w->joint),
                       mbsri_allocate(&m->allocator, bodies * sizeof *w->stand),
                       mbsri_allocate(&m->allocator, bodies * sizeof *w->left)};
    m->stored.joint_param = mbsri_allocate(&m->allocator, changed * MBSRI_LOCKED_PARAMS *
                                                              sizeof *m->stored.joint_param);
    m->stand = mbsri_allocate(&m->allocator, rigid * sizeof *m->stand);
    return w->joint && w->stand && w->left && m->stored.joint_param && m->stand;
}

bool mbsri_welds_find(mbsr_model *m, int N, const int *first, const int *next, int *order, bool any,
                      mbsri_welds *w)
{
    if (!weld_bodies(m, N, w)) return false;
    int *other = mbsri_allocate(&m->allocator, (size_t)N * sizeof *other);
    bool *acted = mbsri_allocate(&m->allocator, (size_t)N * sizeof *acted);
    const bool memory = other && acted;
    choice c = {.m = m, .first = first, .next = next, .w = w, .acted = acted};
    mark_resting(m);
    if (memory) {
        hold_joints(m, N, m->stored.joint_param, w);
        for (int id = 0; id < N; ++id) {
            acted[id] = false;
            w->stand[id].host = id;
        }
        mark_acted(&c);
        for (int k = 0; k < N && any; ++k) weld(&c, order[k]);
        carry_joints(m, N, m->stored.joint_param, w);
        put_welded_last(m, N, w, order, other);
    }
    mbsri_release(&m->allocator, other);
    mbsri_release(&m->allocator, acted);
    return memory;
}

void mbsri_welds_release(const mbsr_model *m, mbsri_welds *w)
{
    mbsri_release(&m->allocator, w->joint);
    mbsri_release(&m->allocator, w->stand);
    mbsri_release(&m->allocator, w->left);
}

int mbsri_welds_parent(const mbsr_model *m, const mbsri_welds *w, int id)
{
    const int given = entry_of_body(m, id)->parent;
    const int parent =
        given == MBSR_GROUND || w->stand[id].host != id ? given : w->stand[given].host;
    return parent == MBSR_GROUND ? 0 : m->index[parent];
}

void mbsri_welds_list(mbsr_model *m)
{
    for (int k = m->bodies - m->live; k > 0; --k) {
        mbsri_stand *stand = m->stand + (k - 1);
        stand->next = m->body[stand->host].on.welded;
        m->body[stand->host].on.welded = k;
    }
}

bool mbsri_welds_served(const mbsr_model *m)
{
    const mbsri_sweeps *const tree[] = {m->tree.plain, m->tree.newton, m->tree.evaluated};
    bool served = true;
    for (int k = 0; k < 3; ++k) {
        for (int i = m->live; i < m->bodies && tree[k]; ++i) {
            const int host = m->stand[i - m->live].host;
            served = served && !(host > 0 && tree[k]->body[host].flags & MBSRI_BLOCK);
        }
    }
    return served;
}
