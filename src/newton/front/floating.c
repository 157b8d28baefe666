/* The step of a body that floats: see floating.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A joint of three translations and a ball about the body's origin, behind a root at rest, has a
 * constant J: with R = -J, blocks of 3 x 3 for rotation and translation,
 *
 *   V = R u,   dV = R du,   d(pose) = R (rotation, displacement) along the root's axes.
 *
 * Of q', c dq - d(G u) = r_q, the quaternion's part is one of quaternions, with w = u of the ball
 *
 *   (c - w / 2) dq = r_q + du q / 2,   1 / (c - w / 2) = (c + w / 2) / (c^2 + w.w / 4)
 *
 * and a rotation is 2 vec(dq q*) / q.q. So all of the pose is known beside du, without a pivot:
 *
 *   x = X du + x0,   X = (R T; R),   T = ((c + [w]x / 2) / (c^2 + w.w / 4), 1 / c)
 *
 * and x0, which has no velocity, is that of r_q alone. What stands over x becomes one over du, and
 * rows of y become those of (a), -R^T (c m - sigma). What is eliminated is 6 x 6 for each body,
 * with 6 rows and columns of each body of the border: (a) and du. */
#include "newton/front/floating.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "base/memory.h"
#include "forces/gravity.h"
#include "joints/chain.h"
#include "model/query.h"
#include "newton/front/crowd.h"
#include "newton/slopes/body_slopes.h"
#include "newton/slopes/steady_joint.h"
#include "recursion/elements.h"

#include <math.h>
#include <string.h>

enum { N = 6, POSES = 7, MOTIONS = 12, ROWS = 12, COLUMNS = MOTIONS + POSES + N };

/* A pivot beside the size of its row and column; below, fronts of all unknowns decide. */
static const double good = 1e-9;

/* Of a body. Blocks of rotation and translation, 3 x 3 each: */
typedef struct floating {
    double R[2][9], X[2][9];
    double q[4], w[3], c, by;       /* by: 1 / (c^2 + w.w / 4) */
    double held[N * N];             /* (a) over the pose, at the rates held */
    double momentum[N * N];         /* d(M u) over du */
    double momentum_of_turn[N * 3]; /* and over the rotation */
    double LU[N * N];
    int row[N]; /* pivots of (a) */
} floating;

/* (a) of one body of a pair over the pose of the other. */
typedef struct floating_pair {
    double held[2][N * N]; /* by the side that moves */
} floating_pair;

struct mbsri_floating {
    floating *body;      /* N + 1 */
    floating_pair *pair; /* by pair */
};

size_t mbsri_floating_place(mbsri_front *f, unsigned char *memory)
{
    size_t used = 0;
    struct mbsri_floating *all = mbsri_take_bytes(memory, &used, sizeof *all);
    floating *body = mbsri_take_bytes(memory, &used, ((size_t)f->model->bodies + 1) * sizeof *body);
    floating_pair *pair =
        mbsri_take_bytes(memory, &used, (size_t)f->model->elements.pairs * sizeof *pair);
    if (memory) *all = (struct mbsri_floating){body, pair};
    f->floating = all;
    return used;
}

/* ---- which ---- */

static bool may_act_on(const mbsri_front *f, int element, int i)
{
    const mbsri_front_source from = {.model = f->model, .pairs = &f->linear->pairs};
    const int *list, count = mbsri_front_bodies(&from, element, &list),
                     forces = (int)f->model->forces.count,
                     pair = element - forces - (int)f->model->closures.count;
    const mbsri_force *force =
        mbsri_force_at(f->model, (size_t)(pair < 0 ? element : f->linear->pairs.pair[pair].force));
    bool on = element < forces || pair >= 0;
    for (int l = 0; l < count && pair < 0; ++l) on = on && (list[l] == 0 || list[l] == i);
    return on && force->def.table->flags & MBSR_FORCE_NO_JOINT;
}

bool mbsri_front_may_float(const mbsri_front *f, int k)
{
    const mbsri_front_step *s = f->plan.step + k;
    const mbsri_body *b = f->model->body + s->body;
    bool may = f->floating && b->n == N && b->parent == 0 &&
               b->inertia.kind != MBSR_INERTIA_FUNCTION &&
               b->inertia.kind != MBSR_INERTIA_FLEXIBLE && mbsri_steady_joint_serves(b);
    for (int e = 0; e < f->model->elements.anywhere && may; ++e) {
        const mbsri_force *force = mbsri_force_at(f->model, (size_t)e);
        may = !(force->def.table->flags & MBSR_FORCE_EVERY_BODY) || mbsri_is_gravity(&force->def);
    }
    for (int l = 0; l < s->elements && may; ++l)
        may = may_act_on(f, f->plan.element[s->first_element + l], s->body);
    return may;
}

/* Steps whose contribution blocks meet float together or not at all. */
static void mark_floating(mbsri_front *f)
{
    const mbsri_linear *w = f->linear;
    mbsri_front_step *step = f->plan.step;
    for (int k = 0; k < f->plan.steps; ++k) {
        const int i = step[k].body;
        step[k].floats =
            step[k].may_float && w->rank[i] == N && !w->below_massless[i] && !w->coupled[i];
    }
    for (int k = 0; k < f->plan.steps; ++k)
        if (!step[k].floats && step[k].next >= 0) step[step[k].next].floats = false;
    for (int k = f->plan.steps - 1; k >= 0; --k)
        if (step[k].next >= 0 && !step[step[k].next].floats) step[k].floats = false;
}

/* ---- motions ---- */

static void read_floating(floating *b, const mbsri_body *body, const mbsr_data *d, double c)
{
    const double *J = d->J + body->dn, *u = d->u + body->iu, *q = d->q + body->iq;
    for (int l = 0; l < 3; ++l) {
        for (int r = 0; r < 3; ++r) {
            b->R[0][3 * l + r] = -J[N * l + r];
            b->R[1][3 * l + r] = -J[N * (3 + l) + 3 + r];
        }
    }
    double T[9];
    mbsri_copy(3, u, b->w);
    mbsri_copy(4, q, b->q);
    b->c = c;
    b->by = 1.0 / (c * c + 0.25 * mbsri_dot3(u, u));
    mbsri_cross_matrix3(u, T);
    for (int l = 0; l < 9; ++l) T[l] *= 0.5 * b->by;
    for (int l = 0; l < 9; l += 4) T[l] += c * b->by;
    mbsri_multiply3(b->R[0], T, b->X[0]);
    for (int l = 0; l < 9; ++l) b->X[1][l] = b->R[1][l] / c;
}

/* a b of quaternions */
static void multiply4(const double a[4], const double b[4], double ab[4])
{
    ab[0] = a[0] * b[0] - mbsri_dot3(a + 1, b + 1);
    mbsri_cross3(a + 1, b + 1, ab + 1);
    for (int l = 1; l < 4; ++l) ab[l] += a[0] * b[l] + b[0] * a[l];
}

/* dq of the quaternion: r / (c - w / 2) */
static void divide4(const floating *b, const double r[4], double dq[4])
{
    const double by[4] = {b->c * b->by, 0.5 * b->by * b->w[0], 0.5 * b->by * b->w[1],
                          0.5 * b->by * b->w[2]};
    multiply4(by, r, dq);
}

/* x0 (6), the pose that r_q (7) moves. */
static void pose_moved_by(const floating *b, const double r[POSES], double x[N])
{
    double dq[4], n[4], turn[3], way[3];
    divide4(b, r, dq);
    (void)mbsri_scale4(b->q, n);
    mbsri_chain_turn(b->q, n, dq, turn);
    for (int l = 0; l < 3; ++l) way[l] = r[4 + l] / b->c;
    mbsri_rotate3(b->R[0], turn, x);
    mbsri_rotate3(b->R[1], way, x + 3);
}

/* C (6 x 6, its columns `rows` apart) += A (6 x 6) B, B of two blocks */
static inline void add_times_blocks(const double *A, double B[2][9], double *C, int rows)
{
    for (int l = 0; l < N; ++l)
        mbsri_add_columns(N / 2, 3, 1.0, A + 3 * N * (l / 3), B[l / 3] + 3 * (l % 3), C + l * rows);
}

/* C (6 x count) = -R^T A, the columns of A `stride` numbers apart */
static void turn_back(const floating *b, int count, const double *A, int stride, double *C)
{
    for (int j = 0; j < count; ++j, A += stride, C += N) {
        mbsri_unrotate3(b->R[0], A, C);
        mbsri_unrotate3(b->R[1], A + 3, C + 3);
        for (int r = 0; r < N; ++r) C[r] = -C[r];
    }
}

/* What forces (6 x 12) on a body over the motion of another are of its (a) over the pose of that,
 * which is added to `held`, and over its du, to the block A. */
static void take_forces(const floating *on, floating *by, const double *E, int stride, double *held,
                        double *A, int rows)
{
    double over[MOTIONS * N];
    turn_back(on, MOTIONS, E, stride, over);
    mbsri_add_pairs(N * N / 2, over, held);
    add_times_blocks(over, by->X, A, rows);
    add_times_blocks(over + N * N, by->R, A, rows);
}

/* ---- what is known ---- */

/* c m - sigma of the body itself over its motion, and d(M u). */
static int know_floating(mbsri_front *f, mbsr_data *d, int i, double *A, int rows)
{
    const mbsri_body *body = f->model->body + i;
    floating *b = f->floating->body + i;
    double P[ROWS * MOTIONS] = {0.0}, moment[9], mass[N * N];
    const int status = mbsri_body_slopes_add(f->model, d, i, false, P, f->linear->body);
    if (status) return status;
    for (int e = 0; e < f->model->elements.anywhere; ++e) {
        const mbsri_force *force = mbsri_force_at(f->model, (size_t)e);
        if (!(force->def.table->flags & MBSR_FORCE_EVERY_BODY) ||
            mbsri_force_off(f->model, d, force))
            continue;
        mbsri_gravity_turn(&force->def, d->M + body->dd, moment);
        for (int l = 0; l < 9; ++l) P[ROWS * (l / 3) + N + l % 3] -= moment[l];
    }
    turn_back(b, 3, P, ROWS, b->momentum_of_turn);
    turn_back(b, N, P + N * ROWS, ROWS, mass);
    mbsri_zero(N * N, b->momentum);
    for (int l = 0; l < 3; ++l)
        mbsri_add_columns(N / 2, 3, 1.0, b->momentum_of_turn, b->X[0] + 3 * l, b->momentum + N * l);
    add_times_blocks(mass, b->R, b->momentum, N);
    for (int k = 0; k < N; ++k) b->momentum[k * (N + 1)] += body->mass.armature[k];
    for (int k = 0; k < ROWS * MOTIONS; k += ROWS) {
        for (int r = 0; r < N; ++r) P[k + r] = -P[k + N + r];
    }
    take_forces(b, b, P, ROWS, b->held, A, rows);
    for (int l = 0; l < 3; ++l) {
        for (int r = 0; r < N; ++r) b->held[N * l + r] += f->c * b->momentum_of_turn[N * l + r];
    }
    for (int l = 0; l < N; ++l) {
        for (int r = 0; r < N; ++r) A[l * rows + r] += f->c * b->momentum[N * l + r];
    }
    return MBSR_OK;
}

/* Where the rows and columns of a body begin in the present front. */
static int front_place(const mbsri_front *f, int i)
{
    return f->columns.at[f->names[i].u];
}

/* Element `element` in the call of the body i or of pair `pair` (-1: it is none). */
static int add_acting(mbsri_front *f, mbsr_data *d, int i, int element, int pair, double *M,
                      int rows)
{
    const bool apart = pair >= 0 && f->crowd && f->crowd->apart[pair];
    const mbsri_force *force = mbsri_force_at(f->model, (size_t)element);
    const int call = pair >= 0 ? pair : i;
    int stride, all;
    const int status = mbsri_linear_force(f->linear, d, (size_t)element, call);
    if (status) return status;
    const double *matrix = mbsri_linear_element(f->linear, (size_t)element, call, &stride, &all);
    floating *b = f->floating->body + i;
    if (apart) {
        mbsri_front_crowd_keep(f, pair, i, matrix, stride);
        matrix += mbsri_front_crowd_own(f, pair, i, stride);
        take_forces(b, b, matrix, stride, b->held, M, rows);
        return MBSR_OK;
    }
    const int *list, count = mbsri_linear_bodies(f->linear, force, call, &list);
    for (int l = 0, column = 0; l < count; ++l) {
        if (list[l] == 0) continue;
        for (int j = 0, row = 0; j < count; ++j) {
            if (list[j] == 0) continue;
            floating *on = f->floating->body + list[j], *by = f->floating->body + list[l];
            double *held = list[j] == list[l] ? on->held : f->floating->pair[pair].held[l],
                   *A =
                       M + (size_t)front_place(f, list[l]) * (size_t)rows + front_place(f, list[j]);
            if (list[j] != list[l]) mbsri_zero(N * N, held);
            take_forces(on, by, matrix + (size_t)column * (size_t)stride + row, stride, held, A,
                        rows);
            row += ROWS;
        }
        column += COLUMNS;
    }
    return MBSR_OK;
}

static int add_all_acting(mbsri_front *f, mbsr_data *d, const mbsri_front_step *s, double *M,
                          int rows)
{
    const int behind = (int)(f->model->forces.count + f->model->closures.count);
    int status = MBSR_OK;
    for (int l = 0; l < s->elements && !status; ++l) {
        const int element = f->plan.element[s->first_element + l], pair = element - behind;
        status = add_acting(f, d, s->body, pair < 0 ? element : f->linear->pairs.pair[pair].force,
                            pair < 0 ? -1 : pair, M, rows);
    }
    return status;
}

static const mbsri_front_border *border_of(const mbsri_front *f, const mbsri_front_step *s)
{
    return f->plan.border + s->first_border;
}

/* The contribution blocks of earlier steps. */
static void add_contributions(const mbsri_front *f, const mbsri_front_step *s, double *M, int rows)
{
    for (int l = 0; l < s->children; ++l) {
        const mbsri_front_step *child = f->plan.step + f->plan.child[s->first_child + l];
        const mbsri_front_border *of = border_of(f, child);
        const double *from = f->matrices + child->matrix;
        for (int j = 0; j < N * child->borders; ++j) {
            double *to = M + (size_t)(front_place(f, of[j / N].body) + j % N) * (size_t)rows;
            for (int k = 0; k < child->borders; ++k, from += N)
                mbsri_add_pairs(N / 2, from, to + front_place(f, of[k].body));
        }
    }
}

/* ---- elimination ---- */

static inline void raise_to(double x, double *most)
{
    *most = x > *most ? x : *most;
}

/* L U of the first rows and columns of M; false: a pivot is not good. */
static bool factor_own(floating *b, const double *M, int rows)
{
    double *A = b->LU, row_scale[N] = {0.0}, column_scale[N] = {0.0};
    for (int k = 0; k < N; ++k) {
        mbsri_copy(N, M + k * rows, A + N * k);
        for (int r = 0; r < N; ++r) raise_to(fabs(A[N * k + r]), row_scale + r);
    }
    for (int k = 0; k < N; ++k) {
        b->row[k] = k;
        for (int r = 0; r < N; ++r) raise_to(fabs(A[N * k + r]) / row_scale[r], column_scale + k);
    }
    for (int q = 0; q < N; ++q) {
        int most = q;
        for (int r = q + 1; r < N; ++r)
            if (fabs(A[N * q + r]) * row_scale[most] > fabs(A[N * q + most]) * row_scale[r])
                most = r;
        if (!(fabs(A[N * q + most]) > good * row_scale[most] * column_scale[q])) return false;
        for (int k = 0; k < N && most != q; ++k) {
            const double other = A[N * k + q];
            A[N * k + q] = A[N * k + most];
            A[N * k + most] = other;
        }
        const double scale = row_scale[q], by = 1.0 / A[N * q + q];
        const int row = b->row[q];
        row_scale[q] = row_scale[most], row_scale[most] = scale;
        b->row[q] = b->row[most], b->row[most] = row;
        for (int r = q + 1; r < N; ++r) A[N * q + r] *= by;
        for (int k = q + 1; k < N; ++k) {
            for (int r = q + 1; r < N; ++r) A[N * k + r] -= A[N * q + r] * A[N * k + q];
        }
    }
    return true;
}

/* y = L^-1 x of the pivots' rows */
static void solve_lower(const floating *b, const double *x, double *y)
{
    for (int k = 0; k < N; ++k) y[k] = x[b->row[k]];
    for (int k = 0; k < N; ++k) {
        for (int r = k + 1; r < N; ++r) y[r] -= b->LU[N * k + r] * y[k];
    }
}

/* y = U^-1 y */
static void solve_upper(const floating *b, double *y)
{
    for (int k = N - 1; k >= 0; --k) {
        y[k] /= b->LU[N * k + k];
        for (int r = 0; r < k; ++r) y[r] -= b->LU[N * k + r] * y[k];
    }
}

/* Of the border, L (others x 6) and U (6 x others); what is left of M goes to `left`. */
static void eliminate_border(const floating *b, const double *M, int rows, double *L, double *U,
                             double *left)
{
    const int others = rows - N;
    for (int k = 0; k < N; ++k) {
        double *column = L + k * others;
        mbsri_copy((size_t)others, M + k * rows + N, column);
        for (int l = 0; l < k; ++l) {
            const double x = b->LU[N * k + l], *before = L + l * others;
            for (int r = 0; r < others; ++r) column[r] -= x * before[r];
        }
        const double by = 1.0 / b->LU[N * k + k];
        for (int r = 0; r < others; ++r) column[r] *= by;
    }
    const double *const first[4] = {L, L + others, L + 2 * others, L + 3 * others};
    for (int j = 0; j < others; ++j, U += N, left += others) {
        const double *column = M + (size_t)(N + j) * (size_t)rows;
        solve_lower(b, column, U);
        mbsri_copy((size_t)others, column + N, left);
        mbsri_subtract_four(others, first, U, left);
        mbsri_add_two_long(others, L + 4 * others, -U[4], L + 5 * others, -U[5], left);
    }
}

int mbsri_floating_pass(mbsri_front *f, mbsr_data *d, int k, bool *done)
{
    const mbsri_front_step *s = f->plan.step + k;
    const int rows = N * (1 + s->borders), others = rows - N;
    floating *b = f->floating->body + s->body;
    double *M = f->now.M;
    mbsri_zero((size_t)rows * (size_t)rows, M);
    f->columns.at[f->names[s->body].u] = 0;
    for (int l = 0; l < s->borders; ++l)
        f->columns.at[f->names[border_of(f, s)[l].body].u] = N * (1 + l);
    add_contributions(f, s, M, rows);
    int status = know_floating(f, d, s->body, M, rows);
    if (!status) status = add_all_acting(f, d, s, M, rows);
    *done = !status && factor_own(b, M, rows);
    double *L = f->LU + s->LU;
    if (*done && others > 0)
        eliminate_border(b, M, rows, L, L + N * others, f->matrices + s->matrix);
    return status;
}

void mbsri_floating_begin(mbsri_front *f, const mbsr_data *d)
{
    mark_floating(f);
    for (int k = 0; k < f->plan.steps; ++k) {
        const int i = f->plan.step[k].body;
        if (!f->plan.step[k].floats) continue;
        read_floating(f->floating->body + i, f->model->body + i, d, f->c);
        mbsri_zero(N * N, f->floating->body[i].held);
    }
}

/* ---- solving ---- */

void mbsri_floating_displace(mbsri_front *f, const double *r)
{
    for (int k = 0; k < f->plan.steps; ++k) {
        const int i = f->plan.step[k].body;
        if (!f->plan.step[k].floats) continue;
        double *x = f->value + f->names[i].x;
        pose_moved_by(f->floating->body + i, r + f->model->body[i].q, x);
        mbsri_zero(N, x + N);
    }
}

/* What poses that r moves make of (a) of body i, by A over them. */
static void take_moved_pose(mbsri_front *f, int i, const double *A, int by)
{
    mbsri_ax_often(N, N, -1.0, A, f->value + f->names[by].x, f->h + f->names[i].a);
}

/* h of (a): c r_u + r_p, what loads do, and poses that r moves. */
static void load_floating(mbsri_front *f, const mbsri_front_step *s, const double *r)
{
    const mbsr_model *m = f->model;
    const mbsri_body *body = m->body + s->body;
    const floating *b = f->floating->body + s->body;
    const double *rp = r + m->nq + body->u, *ru = rp + m->nu, *y = f->h + f->names[s->body].y;
    const int behind = (int)(m->forces.count + m->closures.count);
    double *a = f->h + f->names[s->body].a, loads[N], turned[N];
    for (int l = 0; l < N; ++l) loads[l] = f->c * y[l] - y[N + l];
    turn_back(b, 1, loads, N, turned);
    for (int l = 0; l < N; ++l) a[l] += f->c * ru[l] + rp[l] + turned[l];
    take_moved_pose(f, s->body, b->held, s->body);
    for (int l = 0; l < s->elements; ++l) {
        const int pair = f->plan.element[s->first_element + l] - behind;
        if (pair < 0 || (f->crowd && f->crowd->apart[pair])) continue;
        const int *of = f->linear->pairs.pair[pair].body;
        if (of[0] == 0 || of[1] == 0) continue;
        take_moved_pose(f, of[1], f->floating->pair[pair].held[0], of[0]);
        take_moved_pose(f, of[0], f->floating->pair[pair].held[1], of[1]);
    }
}

void mbsri_floating_reduce(mbsri_front *f, int k, const double *r)
{
    const mbsri_front_step *s = f->plan.step + k;
    const double *L = f->LU + s->LU;
    double *a = f->h + f->names[s->body].a, y[N];
    load_floating(f, s, r);
    solve_lower(f->floating->body + s->body, a, y);
    mbsri_copy(N, y, a);
    for (int j = 0; j < N; ++j) {
        for (int l = 0; l < s->borders; ++l, L += N) {
            double *h = f->h + f->names[border_of(f, s)[l].body].a;
            for (int q = 0; q < N; ++q) h[q] -= L[q] * y[j];
        }
    }
}

/* dq, dp and x of a body from du. */
static void finish_floating(mbsri_front *f, int i, const double *r)
{
    const mbsr_model *m = f->model;
    const mbsri_body *body = m->body + i;
    const floating *b = f->floating->body + i;
    const double *du = f->value + f->names[i].u, *rq = r + body->q,
                 *ru = r + m->nq + m->nu + body->u;
    double *x = f->value + f->names[i].x, *dq = f->value + f->names[i].q,
           *dp = f->rates + 2 * m->nu + body->group.iu, move[3], quaternion[4];
    mbsri_chain_quaternion_rate(b->q, du, quaternion);
    for (int l = 0; l < 4; ++l) quaternion[l] += rq[l];
    divide4(b, quaternion, dq);
    for (int l = 0; l < 3; ++l) dq[4 + l] = (rq[4 + l] + du[3 + l]) / b->c;
    for (int l = 0; l < N; ++l) dp[l] = -ru[l];
    mbsri_ax_often(N, 3, 1.0, b->momentum_of_turn, x, dp);
    mbsri_ax_often(N, N, 1.0, b->momentum, du, dp);
    for (int l = 0; l < 2; ++l) {
        mbsri_rotate3(b->X[l], du + 3 * l, move);
        mbsri_add3(1.0, move, x + 3 * l);
        mbsri_rotate3(b->R[l], du + 3 * l, x + N + 3 * l);
    }
}

void mbsri_floating_substitute(mbsri_front *f, int k, const double *r)
{
    const mbsri_front_step *s = f->plan.step + k;
    const double *U = f->LU + s->LU + N * N * s->borders;
    double *du = f->value + f->names[s->body].u;
    mbsri_copy(N, f->h + f->names[s->body].a, du);
    for (int l = 0; l < s->borders; ++l, U += N * N)
        mbsri_ax_often(N, N, -1.0, U, f->value + f->names[border_of(f, s)[l].body].u, du);
    solve_upper(f->floating->body + s->body, du);
    finish_floating(f, s->body, r);
}

void mbsri_floating_response(const mbsri_front *f, int k, double *motion)
{
    const floating *b = f->floating->body + f->plan.step[k].body;
    for (int l = 0; l < N; ++l, motion += MOTIONS) {
        double load[N], du[N];
        for (int r = 0; r < N; ++r)
            load[r] = r / 3 == l / 3 ? b->R[r / 3][3 * (r % 3) + l % 3] : 0.0;
        solve_lower(b, load, du);
        solve_upper(b, du);
        for (int h = 0; h < 2; ++h) {
            mbsri_rotate3(b->X[h], du + 3 * h, motion + 3 * h);
            mbsri_rotate3(b->R[h], du + 3 * h, motion + N + 3 * h);
        }
    }
}
