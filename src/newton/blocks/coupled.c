/* Joints that are one group, eliminated as one: see coupled.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * As factor.c, symbols too, with the group in the place of the joint: z = (x_pi, dq, du, du') of the
 * head's predecessor and of all joints. One column of z after the other goes from the head through
 * the members, x_b = X_b z_b with z_b = (x of the member above, what of z belongs to the joint), and
 * back, where y of a member also has what the members behind it hand on. */
#include "newton/blocks/coupled.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "newton/blocks/front.h"
#include "newton/blocks/joint.h"
#include "newton/blocks/kept.h"
#include "recursion/group.h"

typedef struct member {
    mbsri_block_joint j;
    mbsri_joint_slopes s;
    int above; /* the member it hangs on; -1: none, it is the head */
    int q, u;  /* first of its coordinates and rates among those of the group */
    double *z; /* columns of j */
    double *load, *below, *own, *torque; /* 3 d, 4 d_pred, 3 n, n */
} member;

typedef struct coupled {
    mbsri_group g;
    member of[MBSRI_GROUP_MOST];
    mbsri_block_joint all;
} coupled;

/* The next `count` numbers; counts where there is no memory. */
static double *take(double *memory, size_t *used, size_t count)
{
    double *place = memory ? memory + *used : NULL;
    *used += count;
    return place;
}

static size_t slopes_size(const mbsr_newton *w, int i)
{
    const mbsri_body *b = w->model->body + i;
    const size_t e = (size_t)w->node[i].e, e_pred = (size_t)w->node[b->parent].e, d = (size_t)b->d,
                 dp = (size_t)b->d_pred, n = (size_t)b->n, nq = (size_t)b->nq;
    return (e + 2 * d + 3 * dp + 3 * n + nq) * (e_pred + 2 * dp + nq + 2 * n);
}

/* Arrays of one member but those of its joint; returns where those begin. */
static double *place_member(const mbsr_newton *w, int i, double *memory, size_t *used, member *k)
{
    const mbsri_body *b = w->model->body + i;
    const size_t d = (size_t)b->d, dp = (size_t)b->d_pred, n = (size_t)b->n,
                 columns = (size_t)w->node[b->parent].e + 2 * dp + (size_t)b->nq + 2 * n;
    k->z = take(memory, used, columns);
    k->load = take(memory, used, 3 * d);
    k->below = take(memory, used, 4 * dp);
    k->own = take(memory, used, 3 * n);
    k->torque = take(memory, used, n);
    k->s.x = take(memory, used, slopes_size(w, i));
    return take(memory, used, mbsri_block_size(w, i));
}

/* Arrays of the group. */
static void place_all(const mbsr_newton *w, int head, double *memory, size_t *used,
                      mbsri_block_joint *j)
{
    const mbsri_body *b = w->model->body + head;
    const size_t n = (size_t)b->group_n, dp = (size_t)b->d_pred,
                 columns = (size_t)w->node[b->parent].e + 2 * dp + (size_t)b->group_nq + 2 * n;
    j->below = take(memory, used, 3 * dp * columns);
    j->reaction = take(memory, used, n * columns);
    j->y = take(memory, used, 3 * n);
    j->size = take(memory, used, n);
    j->size_mu = take(memory, used, n);
    j->size_a = take(memory, used, n);
}

size_t mbsri_coupled_work(const mbsr_newton *w, int head)
{
    const mbsri_group g = mbsri_group_in_model(w->model, head);
    member some;
    mbsri_block_joint all;
    size_t used = 0;
    for (int k = 0; k < g.members; ++k) (void)place_member(w, g.member[k], NULL, &used, &some);
    place_all(w, head, NULL, &used, &all);
    return used;
}

/* The derivatives of the joint, copied from the memory that all joints share. */
static int keep_slopes(mbsr_newton *w, mbsr_data *d, int i, member *k)
{
    mbsri_joint_slopes s;
    mbsri_joint_slopes_place(&s, w->joint);
    const int status =
        mbsri_joint_slopes_of(w->model, d, i, true, d->udot + w->model->body[i].iu, &s);
    if (status) return status;
    double *memory = k->s.x;
    k->s = s;
    mbsri_copy((size_t)(s.work - s.x), s.x, memory);
    k->s.below = memory + (s.below - s.x);
    k->s.own = memory + (s.own - s.x);
    k->s.qdot = memory + (s.qdot - s.x);
    k->s.x = memory;
    return MBSR_OK;
}

static int open_group(mbsr_newton *w, mbsr_data *d, int head, coupled *c)
{
    const mbsr_model *m = w->model;
    const mbsri_body *b = m->body + head;
    mbsri_block_joint *all = &c->all;
    size_t used = 0;
    c->g = mbsri_group_in_model(m, head);
    *all = (mbsri_block_joint){.w = w, .d = d, .b = b, .node = w->node + head};
    all->above = w->node + b->parent;
    all->i = head;
    all->n = b->group_n;
    all->nq = b->group_nq;
    all->motions_pred = mbsri_motions(all->above, m->body + b->parent);
    all->actions_pred = mbsri_actions(all->above, m->body + b->parent);
    all->q = all->motions_pred;
    all->u = all->q + all->nq;
    all->a = all->u + all->n;
    all->columns = all->a + all->n;
    mbsri_keep(w, head, w->store + w->node[head].store, &all->kept);
    place_all(w, head, w->work, &used, all);
    for (int k = 0; k < c->g.members; ++k) {
        const int i = c->g.member[k];
        member *now = c->of + k;
        double *memory = place_member(w, i, w->work, &used, now);
        int status = mbsri_block_begin(w, d, i, memory, &now->j);
        if (!status) status = keep_slopes(w, d, i, now);
        if (status) return status;
        now->above = -1;
        for (int l = 0; l < k; ++l) {
            if (c->g.member[l] == now->j.b->parent) now->above = l;
        }
        now->q = now->j.b->igq - b->igq;
        now->u = now->j.b->ig - c->g.ig;
        now->j.size = all->size + now->u;
        now->j.size_mu = all->size_mu + now->u;
        now->j.size_a = all->size_a + now->u;
    }
    mbsri_zero((size_t)all->n, all->size);
    mbsri_zero((size_t)all->n, all->size_mu);
    mbsri_zero((size_t)all->n, all->size_a);
    return MBSR_OK;
}

/* out (rows) += matrix z_b, of whose columns the joint's derivatives have `stride` rows. */
static void along(const member *k, int rows, int stride, const double *matrix, double *out)
{
    for (int l = 0; l < k->j.columns; ++l) {
        if (k->z[l] == 0.0) continue;
        const int from = mbsri_block_source(&k->j, &k->s, l);
        mbsri_ax(rows, 1, k->z[l], matrix + (size_t)from * (size_t)stride, &(double){1.0}, out);
    }
}

/* z_b of column `at` of z. */
static void place_z(const coupled *c, member *k, int at)
{
    const mbsri_block_joint *j = &k->j;
    mbsri_zero((size_t)j->columns, k->z);
    if (k->above >= 0) {
        const mbsri_block_joint *above = &c->of[k->above].j;
        mbsri_copy((size_t)j->motions_pred, above->kept.x + (size_t)at * (size_t)above->motions,
                   k->z);
    } else if (at < c->all.q) {
        k->z[at] = 1.0;
    }
    const int q = at - c->all.q - k->q, u = at - c->all.u - k->u, a = at - c->all.a - k->u;
    if (at >= c->all.q && at < c->all.u && q >= 0 && q < j->nq) k->z[j->q + q] = 1.0;
    if (at >= c->all.u && at < c->all.a && u >= 0 && u < j->n) k->z[j->u + u] = 1.0;
    if (at >= c->all.a && a >= 0 && a < j->n) k->z[j->a + a] = 1.0;
}

/* y of a member, what it hands on, and its rows, in column `at`. */
static void fill_rows(coupled *c, member *k, int at, double factor)
{
    mbsri_block_joint *j = &k->j, *all = &c->all;
    const mbsri_kept *kept = &j->kept;
    const int d = j->b->d, n = j->n, dp = j->b->d_pred;
    const double *x = kept->x + (size_t)at * (size_t)j->motions;
    double *y = k->load;
    mbsri_ax(j->actions, j->columns, 1.0, j->action, k->z, y);
    mbsri_ax(j->actions, j->motions, 1.0, j->P, x, y);
    mbsri_zero(3 * (size_t)dp, k->below);
    along(k, j->actions_pred, 3 * dp, k->s.below, k->below);
    mbsri_pass_action(j->b, kept, j->above->deep, y, k->below);
    mbsri_zero((size_t)n, k->torque);
    if (j->elements) {
        double *pull = k->below + 3 * dp; /* spare */
        mbsri_zero((size_t)dp, pull);
        mbsri_ax(dp, j->columns, 1.0, j->pull_z, k->z, pull);
        mbsri_ax(dp, j->node->e + d, 1.0, j->pull, x, pull);
        for (int l = 0; l < dp; ++l) k->below[dp + l] -= pull[l];
        for (int l = 0; l < dp && j->above->deep; ++l) k->below[2 * dp + l] += pull[l];
        mbsri_ax(n, j->columns, 1.0, j->torque, k->z, k->torque);
        mbsri_ax(n, j->node->e + d, 1.0, j->torque_x, x, k->torque);
    }
    mbsri_zero(3 * (size_t)n, k->own);
    along(k, 3 * n, 3 * n, k->s.own, k->own);
    const size_t row = (size_t)at * (size_t)all->n + (size_t)k->u;
    double *momentum = all->kept.momentum + row, *rate = all->kept.rate + row,
           *reaction = all->reaction + row;
    mbsri_copy((size_t)n, k->own, momentum);
    mbsri_atx(d, n, 1.0, kept->J, y, momentum);
    for (int l = 0; l < n; ++l) {
        rate[l] = k->own[n + l] + k->torque[l];
        reaction[l] = k->own[2 * n + l] - k->torque[l];
    }
    mbsri_atx(d, n, 1.0, kept->J, y + d, rate);
    mbsri_atx(d, n, 1.0, kept->Jdot, y, rate);
    mbsri_atx(d, n, 1.0, kept->J, y + 2 * d, reaction);
    if (at < all->q) return;
    const mbsri_column_kind kind = at < all->u   ? MBSRI_COLUMN_Q
                                   : at < all->a ? MBSRI_COLUMN_U
                                                 : MBSRI_COLUMN_A;
    mbsri_block_measure(j, factor, kind, y, k->own, k->torque);
}

static void fill_column(coupled *c, int at, double factor)
{
    for (int l = 0; l < c->g.members; ++l) {
        member *k = c->of + l;
        double *x = k->j.kept.x + (size_t)at * (size_t)k->j.motions;
        place_z(c, k, at);
        mbsri_zero((size_t)k->j.motions, x);
        along(k, k->j.motions, k->j.motions, k->s.x, x);
        mbsri_zero((size_t)k->j.actions, k->load);
    }
    for (int l = c->g.members - 1; l >= 0; --l) {
        member *k = c->of + l;
        fill_rows(c, k, at, factor);
        double *to = k->above < 0 ? c->all.below + (size_t)at * (size_t)c->all.actions_pred
                                  : c->of[k->above].load;
        if (k->above < 0) mbsri_zero((size_t)c->all.actions_pred, to);
        for (int r = 0; r < k->j.actions_pred; ++r) to[r] += k->below[r];
    }
}

/* Cq and Q of the group from those of its joints. */
static int coordinates(coupled *c, double factor)
{
    mbsri_block_joint *all = &c->all;
    mbsri_zero((size_t)(all->nq * all->nq), all->kept.Cq);
    mbsri_zero((size_t)(all->nq * all->n), all->kept.Q);
    for (int l = 0; l < c->g.members; ++l) {
        member *k = c->of + l;
        const mbsri_body *b = k->j.b;
        const size_t nq = (size_t)b->nq, n = (size_t)b->n;
        if (!mbsri_finite(nq * (nq + n), k->s.qdot + (size_t)k->s.q * nq))
            return mbsri_block_not_finite(&k->j);
        double *Cq = k->j.reaction, *Q = k->j.torque; /* done with */
        if (!mbsri_block_coordinates(b, factor, &k->s, Cq, Q, all->kept.E, all->kept.row_scale,
                                     all->kept.column_scale, all->w->pivots + all->node->v))
            return mbsri_block_singular(&k->j, "c - d(q')/dq is singular", "take a shorter step");
        for (int j = 0; j < b->nq; ++j) {
            for (int r = 0; r < b->nq; ++r)
                all->kept.Cq[(k->q + j) * all->nq + k->q + r] = Cq[j * b->nq + r];
        }
        for (int j = 0; j < b->n; ++j) {
            for (int r = 0; r < b->nq; ++r)
                all->kept.Q[(k->u + j) * all->nq + k->q + r] = Q[j * b->nq + r];
        }
    }
    return MBSR_OK;
}

int mbsri_coupled_eliminate(mbsr_newton *w, mbsr_data *d, int head, double c)
{
    coupled group;
    int status = open_group(w, d, head, &group);
    for (int at = 0; at < group.all.columns && !status; ++at) fill_column(&group, at, c);
    if (!status) status = coordinates(&group, c);
    if (status || !mbsri_is_front(w, head))
        return status ? status : mbsri_block_finish(&group.all, c);
    mbsri_front_joint joints[MBSRI_GROUP_MOST];
    for (int k = 0; k < group.g.members; ++k) {
        member *now = group.of + k;
        joints[k] = (mbsri_front_joint){&now->j, now->above, now->q, now->u};
    }
    return mbsri_front_finish(&group.all, group.g.members, joints, c);
}
