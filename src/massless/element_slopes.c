/* Slopes of single force elements in the directions that move no mass: see element_slopes.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With the derivatives F_V, F_u, F_x, F_q of what an element exerts, f and tau, and the twist w_l and
 * joint rates a_l of direction l,
 *
 *   C_kl += (w_k, a_k)^T (F_V w_l + F_u a_l)
 *   S_kl += (w_k, a_k)^T (F_x w_l + F_V V'_l + F_q q'_l)
 *
 * where V'_l is the change of V along q'_l = G a_l with u held. Errors are those of rounding in
 * these sums. */
#include "massless/element_slopes.h"

#include "algebra/dense.h"
#include "algebra/differences.h"
#include "algebra/numbers.h"
#include "forces/columns.h"
#include "massless/element_power.h"
#include "massless/element_rows.h"
#include "massless/scales.h"
#include "model/query.h"
#include "recursion/elements.h"
#include "recursion/kinematics.h"

#include <float.h>
#include <math.h>

static const double rounding = MBSRI_ELEMENT_ROUNDING;

/* An element whose derivatives stand for its law: its own, without M, of bodies whose pose changes
 * with their twist. Those that act on every body are mostly weights, whose slopes cancel. */
static bool usable(const mbsr_model *m, const mbsri_force *force)
{
    const mbsr_force_table *table = force->def.table;
    if (!table->derivatives || table->flags & MBSR_FORCE_EVERY_BODY) return false;
    if (table->flags & MBSR_FORCE_JOINT_ONLY) return true;
    if (!(table->flags & MBSR_FORCE_NO_MASS)) return false;
    for (int k = 0; k < force->def.bodies; ++k) {
        const int i = m->list_index[force->list + (size_t)k];
        if (i > 0 && m->body[i].joint.space == MBSR_SPACE_GENERAL) return false;
    }
    return true;
}

/* ---- motions ---- */

/* Motion along a direction of what an element sees of it. */
typedef struct motion {
    const double *pose, *V, *q, *u; /* size_v, size_v, nq, nu in the caller's order; NULL: zero */
} motion;

/* y += K x and gross += |K| |x| over `count` columns from `at`. */
static void add_columns(const mbsri_slopes *s, int at, int count, const double *x, double *y,
                        double *gross)
{
    const int rows = s->out.rows;
    for (int c = 0; c < count && x; ++c) {
        const double *column = s->matrix + (size_t)(at + c) * (size_t)rows;
        if (x[c] == 0.0) continue;
        for (int r = 0; r < rows; ++r) {
            y[r] += column[r] * x[c];
            gross[r] += fabs(column[r] * x[c]);
        }
    }
}

/* gross += |K| |x| by the sizes of rotations and translations, from column `at` on, where a rotation
 * moves points at the typical length: axes and lever arms are differences of positions. */
static void add_sizes(const mbsri_null_space *w, const mbsri_body *b, int at, const double *x,
                      double *gross)
{
    const mbsri_slopes *s = &w->slope;
    int turns, rotation, moves, translation;
    if (!x || !mbsri_element_places(b, &turns, &rotation, &moves, &translation)) return;
    const double spin = mbsri_largest(turns, x + rotation),
                 speed = mbsri_largest(moves, x + translation) + w->size * spin;
    for (int c = 0; c < turns + moves && speed > 0.0; ++c) {
        const bool turn = c >= rotation && c < rotation + turns;
        const double *column = s->matrix + (size_t)(at + c) * (size_t)s->out.rows;
        for (int r = 0; r < s->out.rows; ++r) gross[r] += (turn ? spin : speed) * fabs(column[r]);
    }
}

/* gross of torques on a joint that is told by a quaternion, by the largest of them: their derivatives are
 * differences of products with its numbers. */
static void add_orientation(const mbsri_null_space *w, int bodies, double *gross)
{
    for (int k = 0; k < bodies; ++k) {
        if (w->slope.row[k] < 0) continue;
        const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
        double *torque = gross + w->slope.row[k] + b->d;
        if (b->nq != b->n + 1 || b->n < 3) continue;
        const double trace = 0.1 * mbsri_largest(3, torque);
        for (int r = 0; r < 3; ++r) torque[r] += trace;
    }
}

/* Change of the forces (rows) with a motion, and the sum of the sizes of its terms, with `arms` by the
 * sizes of vectors; false where the element does not move. */
static bool react(const mbsri_null_space *w, int bodies, motion x, bool arms, double *y,
                  double *gross)
{
    const mbsri_slopes *s = &w->slope;
    mbsri_zero((size_t)s->out.rows, y);
    mbsri_zero((size_t)s->out.rows, gross);
    for (int k = 0; k < bodies; ++k) {
        const mbsr_force_body *body = w->d->force_bodies + k;
        if (s->row[k] < 0) continue;
        const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
        const int at = s->column[k];
        const double *pose = x.pose && mbsri_pose_size(b) == b->d ? x.pose + b->v : NULL,
                     *V = x.V ? x.V + b->v : NULL;
        add_columns(s, at, mbsri_pose_size(b), pose, y, gross);
        add_columns(s, mbsri_V_column(body, at), b->d, V, y, gross);
        add_columns(s, mbsri_q_column(body, at), b->nq, x.q ? x.q + b->q : NULL, y, gross);
        add_columns(s, mbsri_u_column(body, at), b->n, x.u ? x.u + b->u : NULL, y, gross);
        if (!arms) continue;
        add_sizes(w, b, at, pose, gross);
        add_sizes(w, b, mbsri_V_column(body, at), V, gross);
    }
    if (arms) add_orientation(w, bodies, gross);
    for (int r = 0; r < s->out.rows; ++r) {
        if (gross[r] > 0.0) return true;
    }
    return false;
}

/* The largest of forces (rows) by what they do along typical sizes. */
static double largest_work(const mbsri_null_space *w, int bodies, const double *gross)
{
    const mbsri_slopes *s = &w->slope;
    int turns, rotation, moves, translation;
    double largest = 0.0;
    for (int k = 0; k < bodies; ++k) {
        if (s->row[k] < 0) continue;
        const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
        const double *f = gross + s->row[k];
        const bool rigid = mbsri_element_places(b, &turns, &rotation, &moves, &translation);
        for (int r = 0; r < b->d + b->n; ++r) {
            const bool turn = rigid && r >= rotation && r < rotation + turns;
            const double size = r >= b->d ? w->span[b->u + r - b->d] : turn ? 1.0 : w->size;
            largest = fmax(largest, size * f[r]);
        }
    }
    return largest;
}

/* Whether forces y (rows) are more than this share of what was added up to them: those of a rigid body
 * by the sizes of moment and force, others one by one beside a trace of the largest, by what they do: of
 * products with quaternions some are rounding alone. */
static bool stands_out(const mbsri_null_space *w, int bodies, double least, const double *y,
                       const double *gross)
{
    const mbsri_slopes *s = &w->slope;
    const double trace = 1e-9 * largest_work(w, bodies, gross);
    int turns, rotation, moves, translation;
    for (int k = 0; k < bodies; ++k) {
        if (s->row[k] < 0) continue;
        const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
        const double *f = y + s->row[k], *size = gross + s->row[k];
        const bool rigid = mbsri_element_places(b, &turns, &rotation, &moves, &translation);
        for (int r = rigid ? b->d : 0; r < b->d + b->n; ++r) {
            const double span = r < b->d ? 1.0 : w->span[b->u + r - b->d];
            if (fabs(f[r]) > least * (size[r] + trace / span)) return true;
        }
        if (!rigid) continue;
        const double force = mbsri_largest(moves, size + translation),
                     moment = mbsri_largest(turns, size + rotation) + w->size * force;
        if (mbsri_largest(moves, f + translation) > least * force ||
            mbsri_largest(turns, f + rotation) > least * moment)
            return true;
    }
    return false;
}

/* Whether body i, 0: the root, takes part in a motion: of elements on joints alone, its joint. */
static bool takes_part(const mbsri_null_space *w, int i, bool joint, const double *a,
                       const double *twist)
{
    const mbsri_body *b = w->m->body + i;
    return i > 0 && ((!joint && mbsri_largest(b->d, twist + b->v) > 0.0) ||
                     mbsri_largest(b->n, a + b->u) > 0.0);
}

static bool element_moves(const mbsri_null_space *w, const mbsri_force *force, int every,
                          const double *a, const double *twist)
{
    const bool joint = (force->def.table->flags & MBSR_FORCE_JOINT_ONLY) != 0;
    if (every > 0) return takes_part(w, every, joint, a, twist);
    for (int k = 0; k < force->def.bodies; ++k) {
        if (takes_part(w, w->m->list_index[force->list + (size_t)k], joint, a, twist)) return true;
    }
    return false;
}

/* ---- the slopes ---- */

/* Directions that move something the element sees, into w->moving. */
static int find_moving(mbsri_null_space *w, const mbsri_force *force)
{
    const mbsr_model *m = w->m;
    int count = 0;
    for (int l = 0; l < w->k; ++l) {
        if (element_moves(w, force, 0, w->direction + (size_t)l * (size_t)m->nu,
                          w->twist + (size_t)l * m->size_v))
            w->moving[count++] = l;
    }
    return count;
}

/* Column l of A and its errors: the reaction y in all moving directions. doubted: what lever arms are
 * wrong by counts beside y, or (S, whose forces are themselves differences of positions) beside
 * gross. They are as wrong on the side of the motion as on that of the power. */
static void add_column(mbsri_null_space *w, int bodies, int moving, int l, const double *y,
                       const double *gross, const double *doubted, double *A, double *error)
{
    const mbsr_model *m = w->m;
    for (int n = 0; n < moving; ++n) {
        const size_t k = (size_t)w->moving[n], at = (size_t)l * (size_t)w->k + k,
                     across = k * (size_t)w->k + (size_t)l;
        const double *twist = w->twist + k * m->size_v,
                     doubt = rounding * mbsri_element_doubt(w, bodies, twist, doubted) +
                             mbsri_element_error(w, bodies, (int)k, doubted);
        double size;
        A[at] += mbsri_element_power(w, bodies, w->direction + k * (size_t)m->nu, twist, y, gross,
                                     &size);
        error[at] += rounding * size + doubt;
        error[across] += doubt;
    }
}

/* gross (rows) = |F_x| |x| for positions x of typical sizes, or with `velocity` |F_V| |V| for
 * velocities of typical sizes per unit of time. */
static void find_strain(const mbsri_null_space *w, int bodies, bool velocity, double *gross)
{
    const mbsri_slopes *s = &w->slope;
    const int rows = s->out.rows;
    int turns, rotation, moves, translation;
    mbsri_zero((size_t)rows, gross);
    for (int k = 0; k < bodies; ++k) {
        const mbsr_force_body *body = w->d->force_bodies + k;
        if (s->row[k] < 0) continue;
        const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
        const int at = velocity ? mbsri_V_column(body, s->column[k]) : s->column[k],
                  joint = velocity ? mbsri_u_column(body, s->column[k])
                                   : mbsri_q_column(body, s->column[k]),
                  first = velocity ? b->d : mbsri_pose_size(b), rest = velocity ? b->n : b->nq;
        const double *scale = velocity ? w->span + b->u : w->q_scale + b->q;
        const bool rigid = mbsri_element_places(b, &turns, &rotation, &moves, &translation);
        for (int c = 0; c < first + rest; ++c) {
            const bool turn = rigid && c >= rotation && c < rotation + turns;
            const double size = c >= first ? scale[c - first]
                                : turn     ? 1.0
                                           : w->size,
                         *column = s->matrix +
                                   (size_t)(c >= first ? joint + c - first : at + c) * (size_t)rows;
            for (int r = 0; r < rows; ++r) gross[r] += size * fabs(column[r]);
        }
    }
}

/* Whether what an element exerts is more than what rounding of positions makes of its stiffness. */
static int exerts(mbsri_null_space *w, const mbsri_force *force, bool *something)
{
    int status = mbsri_force_slopes(w->m, w->d, force, 0, &w->slope);
    if (status) return status;
    const int bodies = force->def.bodies;
    double *y = w->reaction, *gross = y + w->slope.out.rows;
    find_strain(w, bodies, false, gross);
    status = mbsri_force_values(w->m, w->d, force, 0, &w->slope, y);
    *something = stands_out(w, bodies, 1e3 * DBL_EPSILON, y, gross);
    return status;
}

int mbsri_hold_elements(mbsri_null_space *w)
{
    const mbsr_model *m = w->m;
    mbsr_data *d = w->d;
    const mbsri_force *force = m->forces.data;
    int status = MBSR_OK;
    mbsri_zero((size_t)m->nu, d->tau);
    mbsri_zero(m->size_v, d->f);
    for (size_t k = 0; k < m->forces.count && !status; ++k) {
        w->own[k] = usable(m, force + k);
        bool something = false;
        if (w->own[k]) status = exerts(w, force + k, &something);
        if (!status && something) status = mbsri_add_element(m, d, force + k);
    }
    mbsri_copy((size_t)m->nu, d->tau, w->tau_held);
    mbsri_copy(m->size_v, d->f, w->f_held);
    d->stage = MBSRI_STAGE_VELOCITIES;
    return status;
}

int mbsri_element_rate(mbsri_null_space *w, double *rate)
{
    const mbsr_model *m = w->m;
    const mbsri_force *force = m->forces.data;
    double springs = 0.0, dampers = 0.0;
    for (size_t k = 0; k < m->forces.count; ++k) {
        if (!usable(m, force + k)) continue;
        const int status = mbsri_force_slopes(m, w->d, force + k, 0, &w->slope);
        if (status) return status;
        const int bodies = force[k].def.bodies;
        find_strain(w, bodies, false, w->reaction);
        springs = fmax(springs, largest_work(w, bodies, w->reaction));
        find_strain(w, bodies, true, w->reaction);
        dampers = fmax(dampers, largest_work(w, bodies, w->reaction));
    }
    const double inertia = m->mass * w->size * w->size;
    if (inertia > 0.0)
        *rate = springs > 0.0 ? sqrt(springs / inertia) : dampers / inertia;
    else
        *rate = dampers > 0.0 ? springs / dampers : 0.0;
    if (!isfinite(*rate)) *rate = 0.0;
    return MBSR_OK;
}

/* What the element last taken adds to w->strain in the moving directions. y, gross: rows each. */
static void add_strain(mbsri_null_space *w, int bodies, int moving, double *y, double *gross)
{
    const mbsr_model *m = w->m;
    mbsri_zero((size_t)w->slope.out.rows, y);
    find_strain(w, bodies, false, gross);
    for (int n = 0; n < moving; ++n) {
        const size_t l = (size_t)w->moving[n];
        double size;
        (void)mbsri_element_power(w, bodies, w->direction + l * (size_t)m->nu,
                                  w->twist + l * m->size_v, y, gross, &size);
        w->strain[l] += size;
    }
}

static int add_element(mbsri_null_space *w, int number)
{
    const mbsr_model *m = w->m;
    const mbsri_force *force = (const mbsri_force *)m->forces.data + number;
    int status = mbsri_force_slopes(m, w->d, force, 0, &w->slope);
    if (status) return status;
    const int bodies = force->def.bodies, moving = find_moving(w, force);
    double *y = w->reaction, *gross = y + w->slope.out.rows;
    for (int n = 0; n < moving; ++n) {
        const size_t l = (size_t)w->moving[n];
        const double *a = w->direction + l * (size_t)m->nu, *twist = w->twist + l * m->size_v;
        const motion rate = {.V = twist, .u = a}, shift = {.pose = twist,
                                                           .V = w->V_rate + l * m->size_v,
                                                           .q = w->q_rate + l * (size_t)m->nq};
        if (react(w, bodies, rate, true, y, gross) &&
            stands_out(w, bodies, 10.0 * rounding, y, gross) &&
            react(w, bodies, rate, false, y, gross))
            add_column(w, bodies, moving, (int)l, y, gross, y, w->C, w->C_error);
        if (react(w, bodies, shift, true, y, gross))
            add_column(w, bodies, moving, (int)l, y, gross, gross, w->S, w->S_error);
    }
    add_strain(w, bodies, moving, y, gross);
    status = mbsri_element_rows(w, number, moving, true);
    return status ? status : mbsri_element_rows(w, number, moving, false);
}

/* Bodies whose position to their predecessor, or whose pose, changes along direction l; how many. */
static int find_touched(const mbsri_null_space *w, int l)
{
    const mbsr_model *m = w->m;
    const double *a = w->direction + (size_t)l * (size_t)m->nu,
                 *twist = w->twist + (size_t)l * m->size_v;
    int count = 0;
    for (int i = w->first[l]; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        const double *before = twist + m->body[b->parent].v;
        if (mbsri_largest(b->n, a + b->u) > 0.0 || mbsri_largest(b->d, twist + b->v) > 0.0 ||
            mbsri_largest(b->d_pred, before) > 0.0)
            w->touched[count++] = i;
    }
    return count;
}

/* Positions and velocities of the bodies touched, at q + step rate. */
static int place(mbsri_null_space *w, int count, const double *q, const double *rate, double step)
{
    int status = MBSR_OK;
    for (int n = 0; n < count && !status; ++n) {
        const int i = w->touched[n];
        const mbsri_body *b = w->m->body + i;
        for (int c = 0; c < b->nq; ++c)
            w->d->q[b->iq + c] = step != 0.0 ? q[b->q + c] + step * rate[b->q + c] : q[b->q + c];
        status = mbsri_position_of(w->m, w->d, i);
        if (!status) status = mbsri_velocity_of(w->m, w->d, i);
    }
    return status;
}

/* V' of one direction: by differences where it moves bodies or turns joints, with the motion of the
 * predecessor elsewhere; what may be rounding is zero. The data is, and stays, at mbsri_velocities of
 * the state. */
static int velocity_change(mbsri_null_space *w, const double *q, int l)
{
    const mbsr_model *m = w->m;
    const mbsr_data *d = w->d;
    const double *rate = w->q_rate + (size_t)l * (size_t)m->nq;
    double *change = w->V_rate + (size_t)l * m->size_v;
    const double h = 1e-3 * mbsri_unit_step(m->nq, rate, q, w->q_scale);
    const int count = find_touched(w, l);
    int status = MBSR_OK;
    for (int k = 0; k < 4 && !status; ++k) {
        status = place(w, count, q, rate, mbsri_difference_place(k) * h);
        for (int n = 0; n < count; ++n) {
            const mbsri_body *b = m->body + w->touched[n];
            for (size_t c = b->v; c < b->v + (size_t)b->d; ++c)
                change[c] += mbsri_difference_weight(k) / (12.0 * h) * d->V[c];
        }
    }
    if (!status) status = place(w, count, q, rate, 0.0);
    for (int i = w->first[l], n = 0; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        double *own = change + b->v;
        if (n < count && w->touched[n] == i) {
            const double size = mbsri_largest(b->d, d->V + b->v) / h;
            for (int c = 0; c < b->d; ++c) {
                if (fabs(own[c]) <= 10.0 * rounding * size) own[c] = 0.0;
            }
            ++n;
        } else if (mbsri_largest(b->d_pred, change + b->pred_v) > 0.0) {
            mbsri_ax(b->d, b->d_pred, -1.0, d->H + b->dp, change + b->pred_v, own);
        }
    }
    return status;
}

/* Whether some element with derivatives of its own sees velocities of bodies. */
static bool bodies_seen(const mbsri_null_space *w)
{
    const mbsri_force *force = w->m->forces.data;
    bool some = false;
    for (size_t k = 0; k < w->m->forces.count; ++k)
        some = some || (w->own[k] && !(force[k].def.table->flags & MBSR_FORCE_JOINT_ONLY));
    return some;
}

int mbsri_element_slopes(mbsri_null_space *w, double t, const double *q, const double *u)
{
    const mbsr_model *m = w->m;
    int status = mbsri_positions(m, w->d, t, q);
    if (!status) status = mbsri_velocities(m, w->d, u);
    mbsri_zero(m->size_v * (size_t)w->k, w->V_rate);
    mbsri_zero((size_t)w->k, w->strain);
    const int changes = bodies_seen(w) ? w->k : 0;
    for (int l = 0; l < changes && !status; ++l) status = velocity_change(w, q, l);
    for (size_t k = 0; k < m->forces.count && !status; ++k) {
        if (w->own[k]) status = add_element(w, (int)k);
    }
    mbsri_null_remix(w, true, w->strain); /* gamma is made of the vectors as built */
    return status;
}

/* ---- which elements ---- */

int mbsri_element_resists(mbsri_null_space *w, const mbsri_force *force, const double *a,
                          const double *twist, const double *q_rate, bool velocity, double share,
                          double least, bool *resists)
{
    const mbsr_model *m = w->m;
    const bool every = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    const motion x = velocity ? (motion){.V = twist, .u = a} : (motion){.pose = twist, .q = q_rate};
    *resists = false;
    for (int i = 1; i <= (every ? m->bodies : 1) && !*resists; ++i) {
        if (!element_moves(w, force, every ? i : 0, a, twist)) continue;
        const int status = mbsri_force_slopes(m, w->d, force, i, &w->slope);
        if (status) return status;
        const int bodies = every ? 1 : force->def.bodies, rows = w->slope.out.rows;
        double *y = w->reaction, *gross = y + rows, *strain = gross + rows;
        if (!react(w, bodies, x, true, y, gross)) continue;
        find_strain(w, bodies, velocity, strain);
        for (int r = 0; r < rows; ++r) gross[r] = share * gross[r] + least * strain[r];
        *resists = stands_out(w, bodies, 1.0, y, gross);
    }
    return MBSR_OK;
}
