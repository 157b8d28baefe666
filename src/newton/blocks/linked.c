/* Bodies that force elements tie across the tree: see linked.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/blocks/linked.h"

#include "algebra/dense.h"
#include "newton/blocks/solve.h"
#include "newton/blocks/swept.h"
#include "newton/slopes/force_slopes.h"
#include "newton/slopes/relation.h"
#include "recursion/group.h"
#include "sweeps/tree.h"

/* ---- numbers of a body ---- */

static bool is_swept(const mbsr_newton *w, int i)
{
    return i > 0 && w->mixed && !(w->model->whole->body[i].flags & MBSRI_BLOCK);
}

/* A, where a block perturbs it, drops out of all rows that count (docs/newton.md). */
static int columns_of(const mbsr_newton *w, int i)
{
    if (is_swept(w, i)) return MBSRI_SWEPT_MOTIONS;
    return w->node[i].e + w->model->body[i].d;
}

static int rows_of(const mbsr_newton *w, int i)
{
    return is_swept(w, i) ? MBSRI_SWEPT_ACTIONS : 3 * w->model->body[i].d;
}

static bool is_idle(const mbsr_newton *w, int i, int column)
{
    return is_swept(w, i) && column % 4 == 3;
}

int mbsri_links_stride(const mbsr_newton *w, int i)
{
    return rows_of(w, i);
}

static double *load_of(const mbsr_newton *w, int i)
{
    return is_swept(w, i) ? w->links.load + MBSRI_TIED_LOAD * (size_t)i
                          : w->b + 3 * w->model->body[i].v;
}

static double *motion_of(const mbsr_newton *w, int i)
{
    return is_swept(w, i) ? w->links.motion + MBSRI_SWEPT_MOTIONS * (size_t)i : w->x + w->node[i].x;
}

double *mbsri_links_own(const mbsr_newton *w, int i)
{
    return w->links.store + w->links.own[i];
}

double *mbsri_links_load(const mbsr_newton *w, int i)
{
    return load_of(w, i);
}

double *mbsri_links_motion(const mbsr_newton *w, int i)
{
    return motion_of(w, i);
}

/* ---- ties ---- */

/* The tie of body i to one that is eliminated later; NULL: there is none. */
static const mbsri_link *find(const mbsri_links *v, int i, int other)
{
    for (int k = v->first[i]; k < v->first[i + 1]; ++k) {
        if (v->link[k].other == other) return v->link + k;
    }
    return NULL;
}

/* Where forces on body i by the motion of body j stand. */
static double *matrix_of(const mbsri_links *v, int i, int j)
{
    if (i == j) return v->store + v->own[i];
    const bool first = v->position[i] < v->position[j];
    return v->store + (first ? find(v, i, j)->on : find(v, j, i)->onto);
}

/* The joint of body i, or the group it is the head of: what is eliminated in one step. */
typedef struct unit {
    int i, above, members, rates;
    const int *member;
    const mbsri_link *link; /* of the head, which is tied to all that any member is tied to */
    int links;
} unit;

/* False: nothing is tied to it, or it is done with the head of its group. */
static bool find_unit(const mbsr_newton *w, int i, unit *x)
{
    const mbsri_links *v = &w->links;
    const mbsr_model *m = w->model;
    if (!w->linked || v->first[i] == v->first[i + 1]) return false;
    const bool coupled = !is_swept(w, i) && w->node[i].coupled;
    if (coupled && m->body[i].head != i) return false;
    *x = (unit){.i = i,
                .above = m->body[i].parent,
                .members = 1,
                .link = v->link + v->first[i],
                .links = v->first[i + 1] - v->first[i]};
    x->member = m->member + m->body[i].at;
    x->rates = coupled ? m->body[i].group_n : m->body[i].n;
    if (coupled) x->members = m->body[i].members;
    return true;
}

/* ---- steps of the elimination ---- */

/* From what is loaded on the members to the unknowns, and the load on the body above. */
static void reduce(mbsr_newton *w, const unit *x)
{
    if (!is_swept(w, x->above)) mbsri_tree_clear_load(w, x->above);
    for (int k = x->members - 1; k >= 0; --k) {
        if (w->mixed)
            w->links.passes->reduce(w->sweeps, x->member[k]);
        else
            mbsri_tree_reduce(w, x->member[k], NULL);
    }
}

/* From the motion of the body above, and the unknowns, to the motions of the members. */
static void move(mbsr_newton *w, const unit *x, const double *r)
{
    if (w->mixed)
        w->links.passes->move(w->sweeps, x->i, r, w->solution);
    else
        mbsri_tree_move(w, x->i);
}

/* What a joint answers to a load before the body above moves: in vector code du and what goes to d(M u), else
 * the unknowns and the loads on the members. */
static int answers_of(const mbsr_newton *w, const unit *x)
{
    if (is_swept(w, x->i)) return 2 * w->model->whole->body[x->i].n;
    int count = w->node[x->i].unknowns;
    for (int k = 0; k < x->members; ++k) count += 3 * w->model->body[x->member[k]].d;
    return count;
}

/* Where they stand, part by part; the number of parts. */
enum { MOST_PARTS = MBSRI_GROUP_MOST + 1 };
typedef struct part {
    double *at;
    int count;
} part;

static int find_parts(const mbsr_newton *w, const unit *x, part parts[MOST_PARTS])
{
    if (is_swept(w, x->i)) {
        const mbsri_sweep_body *b = w->model->whole->body + x->i;
        parts[0] = (part){w->links.k + b->u, b->n};
        parts[1] = (part){w->links.p + b->u, b->n};
        return 2;
    }
    parts[0] = (part){w->v + w->node[x->i].v, w->node[x->i].unknowns};
    for (int k = 0; k < x->members; ++k)
        parts[k + 1] = (part){load_of(w, x->member[k]), rows_of(w, x->member[k])};
    return x->members + 1;
}

static void get_answers(const mbsr_newton *w, const unit *x, double *to)
{
    part parts[MOST_PARTS];
    const int count = find_parts(w, x, parts);
    for (int k = 0; k < count; to += parts[k++].count)
        mbsri_copy((size_t)parts[k].count, parts[k].at, to);
}

static void clear_answers(mbsr_newton *w, const unit *x)
{
    part parts[MOST_PARTS];
    const int count = find_parts(w, x, parts);
    for (int k = 0; k < count; ++k) mbsri_zero((size_t)parts[k].count, parts[k].at);
}

/* += Z x */
static void add_answers(mbsr_newton *w, const unit *x, const double *Z, const double *motion,
                        int columns)
{
    part parts[MOST_PARTS];
    const int count = find_parts(w, x, parts);
    double *sum = w->work;
    mbsri_zero((size_t)answers_of(w, x), sum);
    mbsri_ax(answers_of(w, x), columns, 1.0, Z, motion, sum);
    for (int k = 0; k < count; ++k) {
        for (int l = 0; l < parts[k].count; ++l) parts[k].at[l] += *sum++;
    }
}

/* ---- elements ---- */

/* Adds to A the forces on body i over the motion of body j: E, of `rows` rows, over pose and V. */
static void place(mbsr_newton *w, int i, int j, int rows, const double *E)
{
    const mbsri_link_passes *passes = w->links.passes;
    const mbsri_body *on = w->model->body + i, *by = w->model->body + j;
    const int count = columns_of(w, j), stride = rows_of(w, i), d = on->d,
              numbers = w->node[j].e + by->d;
    double *A = matrix_of(&w->links, i, j), *x = w->work, *motion = x + count,
           *f = motion + numbers + 12;
    for (int k = 0; k < count; ++k) {
        double *y = A + (size_t)k * (size_t)stride;
        if (is_idle(w, j, k)) continue;
        mbsri_zero((size_t)count, x);
        x[k] = 1.0;
        if (is_swept(w, j))
            passes->tell(w->sweeps, j, x, motion);
        else
            mbsri_copy((size_t)numbers, x, motion);
        mbsri_zero((size_t)d, f);
        for (int l = 0; l < numbers; ++l) {
            for (int r = 0; r < d; ++r) f[r] += E[l * rows + r] * motion[l];
        }
        if (is_swept(w, i)) {
            passes->act(w->sweeps, i, f, y);
            continue;
        }
        for (int r = 0; r < d; ++r) {
            y[d + r] -= f[r];
            y[2 * d + r] += f[r];
        }
    }
}

static int place_element(mbsr_newton *w, mbsr_data *d, const mbsri_force *force)
{
    const mbsr_model *m = w->model;
    const int *body = m->list_index + force->list;
    const int status = mbsri_force_slopes(m, d, force, 0, &w->slopes);
    const mbsr_force_derivatives *by = &w->slopes.out;
    for (int k = 0; k < force->def.bodies && !status; ++k) {
        for (int l = 0; l < force->def.bodies; ++l) {
            if (body[k] == 0 || body[l] == 0 || mbsri_relate(m, body[k], body[l]) != MBSRI_APART)
                continue;
            place(w, body[k], body[l], by->rows,
                  by->matrix + (size_t)by->column[l] * (size_t)by->rows + by->row[k]);
        }
    }
    return status;
}

int mbsri_links_open(mbsr_newton *w, mbsr_data *d, const mbsri_link_passes *passes)
{
    const mbsri_force *force = w->model->forces.data;
    int status = MBSR_OK;
    w->links.passes = passes;
    mbsri_zero(w->links.matrices, w->links.store);
    mbsri_zero(MBSRI_TIED_SUMS * ((size_t)w->model->bodies + 1), w->links.sums);
    for (int k = 0; k < w->correction.count && !status; ++k)
        status = place_element(w, d, force + w->correction.element[k].force);
    return status;
}

/* ---- factoring ---- */

/* Where forces on body i, and on the body above, by the motion of j go. */
static void find_places(mbsr_newton *w, const unit *x, int j)
{
    for (int k = 0; k < x->links; ++k)
        w->links.place[k] = matrix_of(&w->links, x->link[k].other, j);
    w->links.place[x->links] = x->above > 0 ? matrix_of(&w->links, x->above, j) : NULL;
}

/* What the motions of the members do to body `other`, rows_of numbers. */
static void act_on(const mbsr_newton *w, const unit *x, int other, double *to)
{
    const int rows = rows_of(w, other);
    for (int l = 0; l < x->members; ++l) {
        const int member = x->member[l];
        const mbsri_link *tie = find(&w->links, member, other);
        if (!tie) continue;
        mbsri_ax_long(rows, columns_of(w, member), 1.0, w->links.store + tie->onto,
                      motion_of(w, member), to);
    }
}

/* Column `column` of what the members feel by the motion of j, as a load; false: it is zero. */
static bool take_load(mbsr_newton *w, const unit *x, int j, int column)
{
    bool any = false;
    for (int l = 0; l < x->members; ++l) {
        const int member = x->member[l], rows = rows_of(w, member);
        const mbsri_link *tie = find(&w->links, member, j);
        double *load = load_of(w, member);
        if (!is_swept(w, member)) mbsri_tree_load(w, member, NULL, NULL);
        if (!tie) {
            mbsri_zero((size_t)rows, load);
            continue;
        }
        mbsri_copy((size_t)rows, w->links.store + tie->on + (size_t)column * (size_t)rows, load);
        for (int k = 0; k < rows && !any; ++k) any = load[k] != 0.0;
    }
    return any;
}

static void still(mbsr_newton *w, int above)
{
    const size_t count = is_swept(w, above)
                             ? MBSRI_SWEPT_MOTIONS
                             : (size_t)mbsri_motions(w->node + above, w->model->body + above);
    mbsri_zero(count, motion_of(w, above));
}

/* By the rates of the joint: what they do to the bodies it is tied to, into w->links.by_rate. */
static void pass_rates(mbsr_newton *w, const unit *x)
{
    part parts[MOST_PARTS];
    double *to = w->links.by_rate;
    (void)find_parts(w, x, parts);
    still(w, x->above);
    for (int u = 0; u < x->rates; ++u) {
        clear_answers(w, x);
        parts[0].at[u] = 1.0;
        move(w, x, NULL);
        for (int k = 0; k < x->links; ++k) {
            const int rows = rows_of(w, x->link[k].other);
            mbsri_zero((size_t)rows, to);
            act_on(w, x, x->link[k].other, to);
            to += rows;
        }
    }
}

/* By the motion of body j, which the joint is tied to. */
static void pass_other(mbsr_newton *w, const unit *x, const mbsri_link *tie)
{
    const int j = tie->other, count = columns_of(w, j), answers = answers_of(w, x);
    find_places(w, x, j);
    double *const below = w->links.place[x->links];
    for (int k = 0; k < count; ++k) {
        double *Z = w->links.store + tie->answer + (size_t)(k * answers);
        if (is_idle(w, j, k) || !take_load(w, x, j, k)) {
            mbsri_zero((size_t)answers, Z);
            continue;
        }
        reduce(w, x);
        get_answers(w, x, Z);
        if (below) {
            const int rows = rows_of(w, x->above);
            mbsri_ax(rows, 1, 1.0, load_of(w, x->above), &(double){1.0},
                     below + (size_t)k * (size_t)rows);
        }
        const double *by_rate = w->links.by_rate;
        for (int u = 0; u < x->rates; ++u) {
            for (int l = 0; l < x->links; ++l) {
                const int rows = rows_of(w, x->link[l].other);
                mbsri_ax(rows, 1, Z[u], by_rate, &(double){1.0},
                         w->links.place[l] + (size_t)k * (size_t)rows);
                by_rate += rows;
            }
        }
    }
}

/* By the motion of the body above. */
static void pass_above(mbsr_newton *w, const unit *x)
{
    const int count = columns_of(w, x->above);
    find_places(w, x, x->above);
    for (int k = 0; k < count; ++k) {
        if (is_idle(w, x->above, k)) continue;
        still(w, x->above);
        clear_answers(w, x);
        motion_of(w, x->above)[k] = 1.0;
        move(w, x, NULL);
        for (int l = 0; l < x->links; ++l) {
            const int other = x->link[l].other;
            act_on(w, x, other, w->links.place[l] + (size_t)k * (size_t)rows_of(w, other));
        }
    }
}

void mbsri_links_pass(mbsr_newton *w, int i)
{
    unit x;
    if (!find_unit(w, i, &x)) return;
    for (int l = 0; l < x.members; ++l) {
        const mbsri_body *b = w->model->body + x.member[l];
        if (!is_swept(w, i)) mbsri_zero((size_t)b->nq, w->q0 + b->igq);
    }
    pass_rates(w, &x);
    for (int k = 0; k < x.links; ++k) pass_other(w, &x, x.link + k);
    if (x.above > 0) pass_above(w, &x);
}

/* ---- solving ---- */

void mbsri_links_clear(mbsr_newton *w)
{
    mbsri_zero(MBSRI_TIED_LOAD * ((size_t)w->model->bodies + 1), w->links.load);
}

void mbsri_links_reduce(mbsr_newton *w, int i, const double *r)
{
    unit x;
    if (!find_unit(w, i, &x)) return;
    still(w, x.above);
    move(w, &x, r);
    for (int k = 0; k < x.links; ++k) act_on(w, &x, x.link[k].other, load_of(w, x.link[k].other));
}

void mbsri_links_substitute(mbsr_newton *w, int i)
{
    unit x;
    if (!find_unit(w, i, &x)) return;
    for (int k = 0; k < x.links; ++k) {
        const int other = x.link[k].other;
        add_answers(w, &x, w->links.store + x.link[k].answer, motion_of(w, other),
                    columns_of(w, other));
    }
}
