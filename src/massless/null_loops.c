/* Directions that move no mass in models with closures: see null_loops.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/null_loops.h"

#include "algebra/classes.h"
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "base/error.h"
#include "loops/forward.h"
#include "loops/ranks.h"
#include "recursion/rounding.h"
#include "massless/element_power.h"
#include "massless/element_rows.h"
#include "massless/null_lift.h"
#include "massless/scales.h"
#include "recursion/closures.h"
#include "recursion/kinematics.h"
#include "recursion/pose.h"
#include "recursion/spans.h"

#include <float.h>
#include <math.h>

/* Of directions and products with them, relative; the least share that counts of what is
 * subtracted. */
static const double ROUNDING = 256.0 * DBL_EPSILON, LEAST = 1e-12;

/* The largest coordinate of a place in the tree. */
static double farthest_place(const mbsr_model *m, const mbsr_data *d)
{
    double largest = 0.0;
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const bool turns = mbsri_turns(b->joint.space);
        const double *p = d->p + b->p + (turns ? MBSR_POSE_X : 0);
        const int count = turns ? 3 : b->joint.space == MBSR_SPACE_GENERAL ? 0 : 2;
        for (int k = 0; k < count; ++k) largest = fmax(largest, fabs(p[k]));
    }
    return largest;
}

/* Springs of rows that K does without (left_out), in lambda: zero where they bear no more than
 * rounding of places and velocities makes of them. Whatever it is, it would stiffen directions
 * along which nothing else acts. After the derivatives of the closures. */
static void clear_rounded_springs(mbsri_null_space *w, const bool *left_out, const double *u)
{
    static const double rounding = 1e3 * DBL_EPSILON;
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const double lever = fmax(mbsri_longest_lever(w->m, w->d), farthest_place(w->m, w->d)),
                 speed = mbsri_largest_rate(w->m, u);
    for (const mbsri_closure *c = first; c < first + w->m->closures.count; ++c) {
        for (int k = 0; k < c->position_rows; ++k) {
            double gap = 0.0, turn, move;
            if (!mbsri_is_stiff(c, k) || !left_out[c->row + k]) continue;
            for (int l = 0; l < c->bodies; ++l) {
                mbsri_row_parts(w->m, w->d, c, l, k, &turn, &move);
                gap += turn + move * lever;
            }
            const double force = c->def.stiffness[k] * gap + c->def.damping[k] * speed * gap;
            if (fabs(w->loads.lambda[c->row + k]) <= rounding * force)
                w->loads.lambda[c->row + k] = 0.0;
        }
    }
}

/* The rows without a part in the equations into w->left_out: those that the data leaves out, and
 * springs that a start takes as they are. Stiffnesses (rows) of the other stiff ones; whether there
 * are some. */
static bool find_left_out(mbsri_ranking *w, double *stiffness)
{
    const mbsri_closure *c = mbsri_all_closures(w->m), *end = c + w->m->closures.count;
    bool any = false;
    for (; c < end; ++c) {
        for (int k = 0, row = c->row; k < c->rows; ++k, ++row) {
            w->left_out[row] = mbsri_is_loose(c, k) || w->d->dropped[row];
            const bool settled = mbsri_is_stiff(c, k) && !w->left_out[row];
            stiffness[row] = settled ? c->def.stiffness[k] : 0.0;
            any = any || settled;
        }
    }
    return any;
}

/* Of rows that depend on each other stiff ones share what they bear by their compliance. */
static int find_forces(mbsri_null_space *w, mbsri_ranking *ranking, double t, const double *q,
                       const double *u)
{
    double *lambda = w->loads.lambda, *stiffness = ranking->y, *doubt = ranking->out, load;
    const bool shares = find_left_out(ranking, stiffness);
    int status = mbsri_loops_settled(w->m, w->d, t, q, u, ranking->left_out, ranking->span, lambda,
                                     doubt, &load, w->function);
    if (!status && shares)
        status = mbsri_row_fronts_share(ranking->fronts, stiffness, ranking->left_out, lambda);
    if (status) return status;
    mbsri_row_fronts_clear_traces(ranking->fronts, load, doubt, lambda);
    status = mbsri_loops_take_springs(w->m, w->d, t, q, u, ranking->left_out, lambda);
    if (!status) status = mbsri_closure_jacobians(w->m, w->d);
    if (!status) clear_rounded_springs(w, ranking->left_out, u);
    return status;
}

int mbsri_null_loop_forces(mbsri_null_space *w, double t, const double *q, const double *u,
                           int *independent)
{
    mbsri_ranking ranking;
    mbsri_ranks ranks = {.independent = 0};
    int status = mbsri_ranking_open(&ranking, w->m, w->d, false, w->function);
    if (!status) status = find_forces(w, &ranking, t, q, u);
    if (!status) status = mbsri_ranks_here(&ranking, ranking.other, &ranks);
    *independent = ranks.independent;
    mbsri_ranking_close(&ranking);
    return status;
}

/* ---- what rows see of a direction ---- */

/* What may be rounding, over ROUNDING, in the force of a row on a rigid body, `force` (d numbers,
 * rows apart), along V: components of a force that are zero are traces of its largest one, and
 * turns count with the longest lever. */
static double rounded_along(const mbsri_body *b, size_t rows, const double *force, const double *V,
                            double lever)
{
    int turns, rotation, moves, translation;
    double most = 0.0, moment = 0.0;
    (void)mbsri_motion_places(b, &turns, &rotation, &moves, &translation);
    for (int j = 0; j < moves; ++j)
        most = fmax(most, fabs(force[(size_t)(translation + j) * rows]));
    for (int j = 0; j < turns; ++j)
        moment = fmax(moment, fabs(force[(size_t)(rotation + j) * rows]));
    return mbsri_largest(moves, V + translation) * most +
           mbsri_largest(turns, V + rotation) * (moment + lever * most);
}

/* Whether direction l may move the body. */
static bool moves_body(const mbsri_null_space *w, const mbsri_body *b, int l)
{
    const size_t at = (size_t)l * w->m->size.v + b->v;
    for (size_t k = at; k < at + (size_t)b->d; ++k) {
        if (w->twist[k] != 0.0 || w->lift.twist_error[k] != 0.0) return true;
    }
    return false;
}

/* Whether it may move what the closure reads. */
static bool moves_ends(const mbsri_null_space *w, const mbsri_closure *c, int l)
{
    const size_t at = (size_t)l * (size_t)w->m->nu;
    const bool joints = (c->def.table->flags & MBSR_CLOSURE_JOINTS) != 0;
    for (int n = 0; n < c->bodies; ++n) {
        const mbsri_body *b = w->m->body + c->body[n];
        if (c->column[n] < 0) continue;
        if (moves_body(w, b, l)) return true;
        for (int j = b->u; j < b->u + b->n && joints; ++j) {
            if (w->direction[at + (size_t)j] != 0.0 || w->lift.rate_error[at + (size_t)j] != 0.0)
                return true;
        }
    }
    return false;
}

/* C x of row k of a closure; *size: what may be rounding in it, over ROUNDING. */
static double seen_by_row(const mbsri_null_space *w, const mbsri_closure *c, int k, double lever,
                          const double *twist, const double *a, double *size)
{
    const double *C = w->d->closure_C + c->at + k;
    const size_t rows = (size_t)c->rows;
    const bool joints = (c->def.table->flags & MBSR_CLOSURE_JOINTS) != 0;
    double sum = 0.0;
    *size = 0.0;
    for (int l = 0; l < c->bodies; ++l) {
        if (c->column[l] < 0) continue;
        const mbsri_body *b = w->m->body + c->body[l];
        const double *block = C + (size_t)c->column[l] * rows, *V = twist + b->v;
        int turns, rotation, moves, translation;
        const bool rigid = mbsri_motion_places(b, &turns, &rotation, &moves, &translation);
        if (rigid) *size += rounded_along(b, rows, block, V, lever);
        for (int j = 0; j < b->d; ++j) {
            const double part = block[(size_t)j * rows] * V[j];
            sum += part;
            *size += rigid ? 0.0 : fabs(part);
        }
        for (int j = 0; j < b->n && joints; ++j) {
            const double part = block[(size_t)(b->d + j) * rows] * a[b->u + j];
            sum += part;
            *size += fabs(part);
        }
    }
    return sum;
}

/* What row k of a closure reads of the errors of direction l, of that size; beside its size a trace
 * of it is nothing else, where turns cancel. */
static double doubt_of_row(const mbsri_null_space *w, const mbsri_closure *c, int k, int l,
                           double size)
{
    const size_t rows = (size_t)c->rows;
    const double *C = w->d->closure_C + c->at + k,
                 *twist = w->lift.twist_error + (size_t)l * w->m->size.v,
                 *a = w->lift.rate_error + (size_t)l * (size_t)w->m->nu;
    const bool joints = (c->def.table->flags & MBSR_CLOSURE_JOINTS) != 0;
    const double trace = DBL_EPSILON * w->size * size;
    double sum = 0.0;
    for (int n = 0; n < c->bodies; ++n) {
        if (c->column[n] < 0) continue;
        const mbsri_body *b = w->m->body + c->body[n];
        const double *block = C + (size_t)c->column[n] * rows;
        int turns, rotation, moves, translation;
        const bool rigid = mbsri_motion_places(b, &turns, &rotation, &moves, &translation);
        const bool moved = moves_body(w, b, l);
        for (int j = 0; j < moves && rigid && moved; ++j)
            sum += trace * fabs(block[(size_t)(translation + j) * rows]);
        for (int j = 0; j < b->d; ++j)
            sum += fabs(block[(size_t)j * rows]) * twist[b->v + (size_t)j];
        for (int j = 0; j < b->n && joints; ++j)
            sum += fabs(block[(size_t)(b->d + j) * rows]) * a[b->u + j];
    }
    return sum;
}

/* What row k of a closure sees of direction l, of that size, 0 where that may be error, and its
 * error. */
static double seen_of(const mbsri_null_space *w, const mbsri_closure *c, int k, double lever, int l,
                      double size, double *error)
{
    const double *twist = w->twist + (size_t)l * w->m->size.v,
                 *a = w->direction + (size_t)l * (size_t)w->m->nu;
    double added;
    const double value = seen_by_row(w, c, k, lever, twist, a, &added);
    *error = ROUNDING * added + doubt_of_row(w, c, k, l, size);
    return fabs(value) > MBSRI_NULL_CLEAR * *error ? value : 0.0;
}

void mbsri_null_loop_sizes(const mbsri_null_space *w, double *sizes)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    const double lever = w->loads.lever;
    for (const mbsri_closure *c = first; c < first + w->m->closures.count && w->loads.lambda; ++c) {
        for (int l = 0; l < w->k; ++l) {
            const double *twist = w->twist + (size_t)l * w->m->size.v,
                         *a = w->direction + (size_t)l * (size_t)w->m->nu;
            if (!moves_ends(w, c, l)) continue;
            for (int k = 0; k < c->rows; ++k) {
                const double force = fabs(w->loads.lambda[c->row + k]);
                double size;
                if (!(force > 0.0)) continue;
                (void)seen_by_row(w, c, k, lever, twist, a, &size);
                sizes[l] += force * size;
            }
        }
    }
}

/* ---- which directions rigid rows hold ---- */

/* What a rigid row sees of a direction of size 1, and what that may be wrong by. */
typedef struct seen_entry {
    int row, direction;
    double value, error;
} seen_entry;

/* Directions that rows have in common, and where entries begin. */
typedef struct held_classes {
    mbsri_array entries; /* direction by direction */
    double *sizes;       /* k: of the directions */
    int *first, *leader; /* k + 1, k */
    int *place;          /* rows: of the class at work, or the first direction seen; -1: none */
    int *member;         /* k: directions of the class at work */
    int *held;           /* k: whether rows hold them */
    int rows, members;   /* of the class at work */
} held_classes;

static int no_memory_for_null_space(mbsri_null_space *w)
{
    return mbsri_fail(&w->d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                      "%s: no memory for what %d rows of closures hold of %d null directions",
                      w->function, w->m->rows, w->k);
}

static int find_seen(mbsri_null_space *w, double lever, held_classes *s)
{
    const mbsri_closure *first = mbsri_all_closures(w->m), *end = first + w->m->closures.count;
    for (int k = 0; k < w->m->rows; ++k) s->place[k] = -1;
    for (int l = 0; l < w->k; ++l) {
        const double size = s->sizes[l] = mbsri_direction_size(w, l);
        s->leader[l] = l;
        s->first[l] = (int)s->entries.count;
        for (const mbsri_closure *c = first; c < end; ++c) {
            if (!moves_ends(w, c, l)) continue;
            for (int k = 0, row = c->row; k < c->rows; ++k, ++row) {
                double error;
                if (mbsri_is_stiff(c, k)) continue;
                const double value = seen_of(w, c, k, lever, l, size, &error);
                if (value == 0.0 && error == 0.0) continue;
                if (!mbsri_reserve(&w->m->allocator, &s->entries, 1, sizeof(seen_entry)))
                    return no_memory_for_null_space(w);
                ((seen_entry *)s->entries.data)[s->entries.count++] =
                    (seen_entry){row, l, value / size, error / size};
                if (s->place[row] < 0)
                    s->place[row] = l;
                else
                    mbsri_class_join(s->leader, l, s->place[row]);
            }
        }
    }
    s->first[w->k] = (int)s->entries.count;
    return MBSR_OK;
}

/* The members of the class of that leader, and its rows with their places. */
static void gather_class(const mbsri_null_space *w, held_classes *s, int leader)
{
    const seen_entry *e = s->entries.data;
    s->members = s->rows = 0;
    for (int l = 0; l < w->k; ++l) {
        if (mbsri_class_of(s->leader, l) != leader) continue;
        s->member[s->members++] = l;
        for (int k = s->first[l]; k < s->first[l + 1]; ++k) {
            if (s->place[e[k].row] < 0) s->place[e[k].row] = s->rows++;
        }
    }
}

/* Of the class at work the directions that rows leave, and their errors, into T and dT (k x k), at
 * the columns of directions without pivot. */
static int reduce_class(mbsri_null_space *w, held_classes *s, double *T, double *dT)
{
    const seen_entry *e = s->entries.data;
    mbsri_reduction *r = &w->element.reduced;
    const int n = s->rows, m = s->members;
    const size_t size = mbsri_reduction_size(n, m) / sizeof(double) + 1;
    w->element.room.count = 0;
    if (!mbsri_reserve(&w->m->allocator, &w->element.room, size + 2 * (size_t)m, sizeof(double)))
        return no_memory_for_null_space(w);
    double *z = (double *)w->element.room.data + size, *error = z + m;
    mbsri_reduction_place(r, n, m, w->element.room.data);
    mbsri_zero((size_t)n * (size_t)m, r->A);
    mbsri_zero((size_t)n * (size_t)m, r->error);
    for (int c = 0; c < m; ++c) {
        for (int k = s->first[s->member[c]]; k < s->first[s->member[c] + 1]; ++k) {
            r->A[c * n + s->place[e[k].row]] = e[k].value;
            r->error[c * n + s->place[e[k].row]] = e[k].error;
        }
    }
    mbsri_reduce(r, n, m, m, LEAST, NULL);
    for (int c = 0, l = 0; c < m; ++c) {
        s->held[s->member[c]] = r->column_taken[c];
        if (r->column_taken[c]) continue;
        const size_t at = (size_t)s->member[c] * (size_t)w->k;
        mbsri_right_null(r, l++, z, error);
        for (int a = 0; a < m; ++a) {
            T[at + (size_t)s->member[a]] = z[a] / s->sizes[s->member[a]];
            dT[at + (size_t)s->member[a]] = error[a] / s->sizes[s->member[a]];
        }
    }
    return MBSR_OK;
}

/* T (k x count) of the directions that rows leave, and its errors dT; *count. */
static int find_left(mbsri_null_space *w, held_classes *s, double *T, double *dT, int *count)
{
    const size_t k = (size_t)w->k;
    int status = find_seen(w, w->loads.lever, s);
    mbsri_zero(k * k, T);
    mbsri_zero(k * k, dT);
    for (int row = 0; row < w->m->rows; ++row) s->place[row] = -1;
    for (int l = 0; l < w->k && !status; ++l) {
        if (s->leader[l] != l) continue;
        gather_class(w, s, l);
        status = reduce_class(w, s, T, dT);
    }
    *count = 0;
    for (size_t l = 0; l < k && !status; ++l) {
        if (s->held[l]) continue;
        mbsri_copy(k, T + l * k, T + (size_t)*count * k);
        mbsri_copy(k, dT + l * k, dT + (size_t)(*count)++ * k);
    }
    return status;
}

/* Directions that rows leave: count columns of T (k x count) and of its errors dT, and where these
 * are not zero: row[first[l]] to before row[first[l + 1]] of column l. */
typedef struct left_columns {
    int k, count;
    const double *T, *dT;
    int *first, *row;
} left_columns;

static void list_places(left_columns *x)
{
    int found = 0;
    for (int l = 0; l < x->count; ++l) {
        x->first[l] = found;
        for (int c = 0; c < x->k; ++c) {
            const size_t at = (size_t)l * (size_t)x->k + (size_t)c;
            if (x->T[at] != 0.0 || x->dT[at] != 0.0) x->row[found++] = c;
        }
    }
    x->first[x->count] = found;
}

/* A (n x k) becomes A T, without what may be rounding; error (n x k, or NULL): of A, becomes that
 * of A T; `old`: 2 n k of scratch. */
static void combine(const left_columns *x, size_t n, double *A, double *error, double *old)
{
    const size_t k = (size_t)x->k;
    double *old_error = old + n * k;
    mbsri_copy(n * k, A, old);
    if (error) mbsri_copy(n * k, error, old_error);
    for (int l = 0; l < x->count; ++l) {
        const double *T = x->T + (size_t)l * k, *dT = x->dT + (size_t)l * k;
        for (size_t r = 0; r < n; ++r) {
            const size_t to = (size_t)l * n + r;
            double sum = 0.0, size = 0.0, doubt = 0.0;
            for (int at = x->first[l]; at < x->first[l + 1]; ++at) {
                const int c = x->row[at];
                const size_t from = (size_t)c * n + r;
                const double part = T[c] * old[from];
                sum += part;
                size += fabs(part);
                if (error) doubt += fabs(T[c]) * old_error[from] + dT[c] * fabs(old[from]);
            }
            const bool clear = fabs(sum) > 1e-13 * size && fabs(sum) > MBSRI_NULL_CLEAR * doubt;
            A[to] = clear ? sum : 0.0;
            if (error) error[to] = doubt;
        }
    }
}

/* A (k x k) becomes T^T A T (count x count) with its errors, those of T, dT, among them; old: of
 * 2 k k + 3 k scratch. */
static void restrict_slopes(const left_columns *x, double *A, double *error, double *old)
{
    const int k = x->k, count = x->count;
    const size_t all = (size_t)k * (size_t)k;
    double *old_error = old + all, *sum = old_error + all, *size = sum + k, *doubt = size + k;
    mbsri_copy(all, A, old);
    mbsri_copy(all, error, old_error);
    for (int b = 0; b < count; ++b) {
        mbsri_zero((size_t)3 * (size_t)k, sum);
        for (int at = x->first[b]; at < x->first[b + 1]; ++at) {
            const size_t c = (size_t)x->row[at] * (size_t)k;
            const double y = x->T[(size_t)b * (size_t)k + (size_t)x->row[at]],
                         dy = x->dT[(size_t)b * (size_t)k + (size_t)x->row[at]];
            for (int r = 0; r < k; ++r) {
                const double value = old[c + (size_t)r], most = fabs(value);
                sum[r] += value * y;
                size[r] += most * fabs(y);
                doubt[r] +=
                    (old_error[c + (size_t)r] + 4.0 * DBL_EPSILON * most) * fabs(y) + most * dy;
            }
        }
        for (int a = 0; a < count; ++a) {
            const double *T = x->T + (size_t)a * (size_t)k, *dT = x->dT + (size_t)a * (size_t)k;
            const size_t to = (size_t)b * (size_t)count + (size_t)a;
            A[to] = error[to] = 0.0;
            for (int at = x->first[a]; at < x->first[a + 1]; ++at) {
                const int r = x->row[at];
                A[to] += T[r] * sum[r];
                error[to] += fabs(T[r]) * doubt[r] + dT[r] * size[r];
            }
        }
    }
}

/* Directions are those that T leaves; `old`: scratch of mbsri_null_leave_held. */
static void take_left(mbsri_null_space *w, const left_columns *x, double *old)
{
    combine(x, (size_t)w->m->nu, w->direction, w->lift.rate_error, old);
    combine(x, w->m->size.v, w->twist, w->lift.twist_error, old);
    combine(x, (size_t)w->m->nq, w->element.q_rate, NULL, old);
    restrict_slopes(x, w->C, w->C_error, old);
    restrict_slopes(x, w->S, w->S_error, old);
    for (int l = 0; l < x->count; ++l) w->sums.head[l] = 1;
    w->k = x->count;
    w->sums.on = false;
}

int mbsri_null_leave_held(mbsri_null_space *w)
{
    const mbsr_model *m = w->m;
    const size_t k = (size_t)w->k, rows = (size_t)m->rows, nu = (size_t)m->nu, nq = (size_t)m->nq;
    const size_t more = nu > nq ? nu : nq, longest = m->size.v > more ? m->size.v : more,
                 wide = 2 * (longest > k ? longest : k) * k + 3 * k;
    int status = mbsri_closure_jacobians(m, w->d), count;
    if (status || k == 0 || rows == 0) return status;
    double *T = mbsri_allocate(&m->allocator, (2 * k * k + wide) * sizeof(double) +
                                                  (k * k + 5 * k + 2 + rows) * sizeof(int));
    if (!T) return no_memory_for_null_space(w);
    double *dT = T + k * k, *old = dT + k * k;
    held_classes s = {.sizes = w->sums.gamma, .first = (int *)(void *)(old + wide)};
    s.leader = s.first + k + 1;
    s.member = s.leader + k;
    s.held = s.member + k;
    s.place = s.held + k;
    status = find_left(w, &s, T, dT, &count);
    if (!status) {
        left_columns x = {w->k, count, T, dT, s.place + rows, s.place + rows + k + 1};
        list_places(&x);
        take_left(w, &x, old);
    }
    mbsri_release(&m->allocator, s.entries.data);
    mbsri_release(&m->allocator, T);
    return status;
}

/* ---- stiff rows ---- */

/* One row of the closure sees its stiffness, or damping, of all directions. */
static int add_row(mbsri_null_space *w, int closure, int k, double lever, double weight,
                   bool velocity)
{
    const mbsri_closure *c = (const mbsri_closure *)w->m->closures.data + closure;
    double *A = velocity ? w->C : w->S, *error = velocity ? w->C_error : w->S_error;
    const size_t entries = w->element.entries.count;
    if (!mbsri_reserve(&w->m->allocator, &w->element.rows, 1, sizeof(mbsri_row)) ||
        !mbsri_reserve(&w->m->allocator, &w->element.entries, (size_t)w->k,
                       sizeof(mbsri_row_entry)))
        return no_memory_for_null_space(w);
    mbsri_row_entry *entry = (mbsri_row_entry *)w->element.entries.data + entries;
    for (int l = 0; l < w->k; ++l) {
        double doubt;
        const double value = seen_of(w, c, k, lever, l, mbsri_direction_size(w, l), &doubt);
        entry[l] = (mbsri_row_entry){l, value, doubt};
    }
    for (int b = 0; b < w->k; ++b) {
        for (int a = 0; a < w->k; ++a) {
            A[b * w->k + a] -= weight * entry[a].value * entry[b].value;
            error[b * w->k + a] += weight * (fabs(entry[a].value) * entry[b].error +
                                             entry[a].error * fabs(entry[b].value));
        }
    }
    mbsri_row *row = (mbsri_row *)w->element.rows.data + w->element.rows.count++;
    *row = (mbsri_row){-1 - closure, velocity, -weight, entries, w->k};
    w->element.entries.count += (size_t)w->k;
    return MBSR_OK;
}

int mbsri_null_stiff_rows(mbsri_null_space *w)
{
    const mbsri_closure *first = mbsri_all_closures(w->m);
    int status = mbsri_closure_jacobians(w->m, w->d);
    if (status || w->k == 0) return status;
    const double lever = w->loads.lever;
    for (int id = 0; id < (int)w->m->closures.count; ++id) {
        const mbsri_closure *c = first + id;
        for (int k = 0; k < c->rows && !status; ++k) {
            if (!mbsri_is_stiff(c, k)) continue;
            if (c->def.damping[k] > 0.0) status = add_row(w, id, k, lever, c->def.damping[k], true);
            if (!status) status = add_row(w, id, k, lever, c->def.stiffness[k], false);
        }
    }
    return status;
}

bool mbsri_null_closure_resists(mbsri_null_space *w, const mbsri_closure *c, const double *twist,
                                const double *a, bool velocity)
{
    const double lever = w->loads.lever;
    for (int k = 0; k < c->rows; ++k) {
        double size;
        if (!mbsri_is_stiff(c, k) || (velocity && !(c->def.damping[k] > 0.0))) continue;
        const double value = seen_by_row(w, c, k, lever, twist, a, &size);
        if (fabs(value) > 1e-6 * size) return true;
    }
    return false;
}
