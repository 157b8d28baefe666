/* A direction that moves no mass, from the joints where it begins to the leaves: see null_lift.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With x = H Vz_pi at the head of a group and the rates z of its own vector,
 *
 *   a = z - G^T x,    Vz = -x - J a,    Vz_i = -H_i Vz_pi(i) - J_i a_i of its other members
 *
 * Rounding errors arrive as x does, and go on as the recursion takes them there: those of Vz_i are
 * |dVz_i / dx| times those of x and what rounding leaves of its own sum. Behind a slender body they
 * may be as many times larger as its rate. G counts as exact but for a trace of the largest rate of
 * the direction, in the scale of the model (assembly/survey.c): an error in proportion is one of
 * the offset of a mass from an axis, and makes the direction one of a model that is as good.
 *
 * What is no more than errors is zero, body by body, so that rounding does not go on as if it were
 * motion. */
#include "massless/null_lift.h"

#include "algebra/numbers.h"
#include "algebra/dense.h"
#include "model/query.h"
#include "recursion/forward.h"
#include "recursion/group.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Scratch: x and its errors at the head; rates of the group and their errors; per member the
 * rounding of its own sums (d) and dVz_i / dx (d x d of the head). */
typedef struct work {
    const mbsr_model *m;
    mbsr_data *d;
    double *x, *x_error, *z, *z_error, *size, *own, *response;
} work;

size_t mbsri_null_lift_room(const mbsr_model *m)
{
    const size_t d = (size_t)m->most.d, n = (size_t)m->most.n;
    return 2 * d + 3 * n + MBSRI_GROUP_MOST * (d + d * d);
}

static work place_work(const mbsr_model *m, mbsr_data *d, double *room)
{
    const size_t dim = (size_t)m->most.d, n = (size_t)m->most.n;
    work k = {.m = m, .d = d, .x = room};
    k.x_error = k.x + dim;
    k.z = k.x_error + dim;
    k.z_error = k.z + n;
    k.size = k.z_error + n;
    k.own = k.size + n;
    k.response = k.own + MBSRI_GROUP_MOST * dim;
    return k;
}

/* y (r) += |A| |x|, A: r x c. */
static void add_sizes(int r, int c, const double *A, const double *x, double *y)
{
    for (int j = 0; j < c; ++j) {
        for (int k = 0; k < r && x[j] != 0.0; ++k) y[k] += fabs(A[j * r + k] * x[j]);
    }
}

void mbsri_null_drop(size_t n, double *x, const double *error)
{
    for (size_t k = 0; k < n; ++k) {
        if (fabs(x[k]) <= MBSRI_NULL_CLEAR * error[k]) x[k] = 0.0;
    }
}

bool mbsri_motion_places(const mbsri_body *b, int *turns, int *rotation, int *moves,
                         int *translation)
{
    const bool plane = b->joint.space == MBSR_SPACE_PLANAR;
    *turns = plane ? 1 : 3;
    *rotation = plane ? 2 : 0;
    *moves = plane ? 2 : 3;
    *translation = plane ? 0 : 3;
    return plane || b->joint.space == MBSR_SPACE_SPATIAL;
}

void mbsri_null_spread(const mbsri_body *b, double *sizes)
{
    int turns, rotation, moves, translation;
    if (!mbsri_motion_places(b, &turns, &rotation, &moves, &translation)) return;
    const double turn = mbsri_largest(turns, sizes + rotation),
                 move = mbsri_largest(moves, sizes + translation);
    for (int k = 0; k < turns; ++k) sizes[rotation + k] = turn;
    for (int k = 0; k < moves; ++k) sizes[translation + k] = move;
}

/* How many of V, from the first on, are the motion of a frame in space; 0: it is told otherwise. */
static int frame_of(mbsr_space space)
{
    return space == MBSR_SPACE_SPATIAL || space == MBSR_SPACE_FLEXIBLE ? 6 : 0;
}

/* The motion (d_pred) of the predecessor that `at` (d) of the body is, in sizes: |H^-1| is |H| of a
 * translation, which frames of flexible bodies make as they are; other spaces by the transpose. */
static void move_to_predecessor(const mbsri_body *b, const double *H, const double *at,
                                double *before)
{
    const int frame = frame_of(b->joint.space) ? frame_of(b->pred.space) : 0,
              square = frame > 0           ? frame
                       : b->d == b->pred.d ? b->d
                                           : 0;
    mbsri_zero((size_t)b->pred.d, before);
    for (int c = 0; c < square; ++c) {
        for (int r = 0; r < square; ++r) before[r] += fabs(H[c * b->d + r]) * at[c];
    }
    for (int c = 0; c < b->pred.d && square == 0; ++c) {
        for (int r = 0; r < b->d; ++r) before[c] += fabs(H[c * b->d + r]) * at[r];
    }
}

/* y (d of the head) = the sum of |J_i a_i| of all members, taken to the head; room: 2 max_d. */
static void add_motions(const work *k, const mbsri_group *g, const double *a, double *y,
                        double *room)
{
    for (int l = 0; l < g->members; ++l) {
        const mbsri_body *b = k->m->body + g->member[l];
        double *at = room, *before = room + k->m->most.d;
        mbsri_zero((size_t)b->d, at);
        add_sizes(b->d, b->n, k->d->J + b->dn, a + b->group.iu - g->ig, at);
        for (int i = g->member[l]; i != g->member[0]; i = b->parent, b = k->m->body + i) {
            move_to_predecessor(b, k->d->H + b->dp, at, before);
            double *swap = at;
            at = before, before = swap;
        }
        for (int r = 0; r < k->m->body[g->member[0]].d; ++r) y[r] += at[r];
    }
}

/* The rates of a group, whose own stand in z, and the sizes that count for their rounding; x = H
 * Vz_pi if `below`. */
static void find_rates(const work *k, const mbsri_group *g, bool below)
{
    const mbsri_body *b = k->m->body + g->member[0];
    const double *G = k->d->G + b->dg;
    for (int l = 0; l < g->n; ++l) {
        for (int r = 0; r < b->d && below; ++r) k->z[l] -= G[l * b->d + r] * k->x[r];
        k->size[l] = fmax(k->size[l], fabs(k->z[l]));
    }
}

/* The errors of x and of the rates: those that arrive, and what rounding of H and J leaves of x + J
 * a, which the group makes up for as if it had arrived. largest: rate so far, over its scale. Rates
 * that are not clear of these are dropped: what they were stands in size then. */
static void find_errors(const work *k, const mbsri_group *g, bool below, const double *error,
                        double *largest)
{
    const mbsr_data *d = k->d;
    const mbsri_body *b = k->m->body + g->member[0];
    const double *G = d->G + b->dg,
                 *scale = (k->m->typical.inertia ? k->m->typical.inertia : d->s) + g->ig;
    mbsri_zero((size_t)b->d, k->x_error);
    if (below) add_sizes(b->d, b->pred.d, d->H + b->dp, d->Az + b->pred.v, k->x_error);
    add_motions(k, g, k->z, k->x_error, k->own);
    for (int r = 0; r < b->d; ++r) k->x_error[r] *= MBSRI_NULL_ROUNDING;
    if (below) add_sizes(b->d, b->pred.d, d->H + b->dp, error + b->pred.v, k->x_error);
    for (int l = 0; l < g->n; ++l) *largest = fmax(*largest, fabs(k->z[l]) / scale[l]);
    for (int l = 0; l < g->n; ++l) {
        k->z_error[l] = fmax(MBSRI_NULL_ROUNDING * k->size[l], DBL_EPSILON * scale[l] * *largest);
        for (int r = 0; r < b->d; ++r) k->z_error[l] += fabs(G[l * b->d + r]) * k->x_error[r];
    }
    for (int l = 0; l < g->n; ++l)
        k->size[l] = fabs(k->z[l]) <= MBSRI_NULL_CLEAR * k->z_error[l] ? fabs(k->z[l]) : 0.0;
    mbsri_null_drop((size_t)g->n, k->z, k->z_error);
}

/* Member number l of a group: how its velocity changes with x of the head, and what rounding, and
 * rates that were dropped, leave of the sum that it is. at: number of its predecessor among the
 * members. */
static void respond(const work *k, const mbsri_group *g, int l, int at)
{
    const mbsr_data *d = k->d;
    const mbsri_body *head = k->m->body + g->member[0], *b = k->m->body + g->member[l];
    const size_t most = (size_t)k->m->most.d;
    const double *z = k->z + b->group.iu - g->ig, *J = d->J + b->dn, *H = d->H + b->dp,
                 *G = d->G + head->dg + (size_t)((b->group.iu - g->ig) * head->d);
    double *own = k->own + (size_t)l * most, *response = k->response + (size_t)l * most * most;
    mbsri_zero((size_t)b->d, own);
    mbsri_zero((size_t)(b->d * head->d), response);
    add_sizes(b->d, b->n, J, z, own);
    if (l > 0 && d->carries[b->parent]) add_sizes(b->d, b->pred.d, H, d->Az + b->pred.v, own);
    mbsri_null_spread(b, own);
    for (int r = 0; r < b->d; ++r) own[r] *= MBSRI_NULL_ROUNDING;
    add_sizes(b->d, b->n, J, k->size + b->group.iu - g->ig, own);
    if (l > 0 && d->carries[b->parent])
        add_sizes(b->d, b->pred.d, H, k->own + (size_t)at * most, own);
    for (int c = 0; c < head->d; ++c) {
        double *column = response + c * b->d;
        if (l == 0) column[c] = -1.0;
        if (l > 0 && d->carries[b->parent])
            mbsri_ax(b->d, b->pred.d, -1.0, H,
                     k->response + (size_t)at * most * most + (size_t)(c * b->pred.d), column);
        for (int n = 0; n < b->n; ++n)
            mbsri_ax(b->d, 1, G[n * head->d + c], J + n * b->d, &(double){1.0}, column);
    }
}

/* Velocity and its errors of member number l. */
static void find_velocity(const work *k, const mbsri_group *g, int l, bool below, double *twist,
                          double *error)
{
    mbsr_data *d = k->d;
    const int i = g->member[l];
    const mbsri_body *head = k->m->body + g->member[0], *b = k->m->body + i;
    const size_t most = (size_t)k->m->most.d;
    double *x = d->scratch;
    int at = 0;
    while (at < l && g->member[at] != b->parent) ++at;
    respond(k, g, l, at);
    const bool moved = l == 0 ? below : mbsri_null_below(k->m, d, i, x);
    if (l == 0 && below) mbsri_copy((size_t)b->d, k->x, x);
    mbsri_null_velocity(k->m, d, i, moved ? x : NULL, k->z + b->group.iu - g->ig);
    if (!d->carries[i]) return;
    mbsri_copy((size_t)b->d, k->own + (size_t)l * most, error + b->v);
    add_sizes(b->d, head->d, k->response + (size_t)l * most * most, k->x_error, error + b->v);
    mbsri_null_drop((size_t)b->d, d->Az + b->v, error + b->v);
    mbsri_copy((size_t)b->d, d->Az + b->v, twist + b->v);
}

void mbsri_null_lift(const mbsr_model *m, mbsr_data *d, int j, const double *z, const double *size,
                     const mbsri_lifted *out, double *room)
{
    const work k = place_work(m, d, room);
    double largest = 0.0;
    mbsri_zero((size_t)m->nu, out->a);
    mbsri_zero((size_t)m->nu, out->a_error);
    mbsri_zero(m->size.v, out->twist);
    mbsri_zero(m->size.v, out->twist_error);
    memset(d->carries, 0, (size_t)(m->bodies + 1) * sizeof *d->carries);
    for (int i = j; i <= m->bodies; ++i) {
        if (!mbsri_heads(m, d, i)) continue;
        const mbsri_group g = mbsri_group_of(m, d, i);
        const bool below = mbsri_null_below(m, d, i, k.x);
        mbsri_group_gather(m, &g, z, k.z);
        mbsri_group_gather(m, &g, size, k.size);
        if (!below && mbsri_largest(g.n, k.z) == 0.0) continue;
        find_rates(&k, &g, below);
        find_errors(&k, &g, below, out->twist_error, &largest);
        mbsri_group_scatter(m, &g, k.z, out->a);
        mbsri_group_scatter(m, &g, k.z_error, out->a_error);
        for (int l = 0; l < g.members; ++l)
            find_velocity(&k, &g, l, below, out->twist, out->twist_error);
    }
}
