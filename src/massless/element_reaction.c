/* What a force element exerts along a motion: see element_reaction.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/element_reaction.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "forces/columns.h"
#include "massless/element_power.h"

#include <math.h>

/* ---- motions ---- */

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

/* gross += |K| |x| by the sizes of rotations and translations, from column `at` on, where a
 * rotation moves points at the typical length: axes and lever arms are differences of positions. */
static void add_sizes(const mbsri_null_space *w, const mbsri_body *b, int at, const double *x,
                      double *gross)
{
    const mbsri_slopes *s = &w->element.slope;
    int turns, rotation, moves, translation;
    if (!x || !mbsri_motion_places(b, &turns, &rotation, &moves, &translation)) return;
    const double spin = mbsri_largest(turns, x + rotation),
                 speed = mbsri_largest(moves, x + translation) + w->size * spin;
    for (int c = 0; c < turns + moves && speed > 0.0; ++c) {
        const bool turn = c >= rotation && c < rotation + turns;
        const double *column = s->matrix + (size_t)(at + c) * (size_t)s->out.rows;
        for (int r = 0; r < s->out.rows; ++r) gross[r] += (turn ? spin : speed) * fabs(column[r]);
    }
}

/* gross of torques on a joint that is told by a quaternion, by the largest of them: their
 * derivatives are differences of products with its numbers. */
static void add_orientation(const mbsri_null_space *w, int bodies, double *gross)
{
    for (int k = 0; k < bodies; ++k) {
        if (w->element.slope.row[k] < 0) continue;
        const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
        double *torque = gross + w->element.slope.row[k] + b->d;
        if (b->nq != b->n + 1 || b->n < 3) continue;
        const double trace = 0.1 * mbsri_largest(3, torque);
        for (int r = 0; r < 3; ++r) torque[r] += trace;
    }
}

bool mbsri_element_react(const mbsri_null_space *w, int bodies, mbsri_element_motion x, bool arms,
                         double *y, double *gross)
{
    const mbsri_slopes *s = &w->element.slope;
    mbsri_zero((size_t)s->out.rows, y);
    mbsri_zero((size_t)s->out.rows, gross);
    for (int k = 0; k < bodies; ++k) {
        const mbsr_force_body *body = w->d->element.bodies + k;
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

double mbsri_element_work(const mbsri_null_space *w, int bodies, const double *gross)
{
    const mbsri_slopes *s = &w->element.slope;
    int turns, rotation, moves, translation;
    double largest = 0.0;
    for (int k = 0; k < bodies; ++k) {
        if (s->row[k] < 0) continue;
        const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
        const double *f = gross + s->row[k];
        const bool rigid = mbsri_motion_places(b, &turns, &rotation, &moves, &translation);
        for (int r = 0; r < b->d + b->n; ++r) {
            const bool turn = rigid && r >= rotation && r < rotation + turns;
            const double size = r >= b->d ? w->scale.span[b->u + r - b->d] : turn ? 1.0 : w->size;
            largest = fmax(largest, size * f[r]);
        }
    }
    return largest;
}

bool mbsri_element_stands_out(const mbsri_null_space *w, int bodies, double least, const double *y,
                              const double *gross)
{
    const mbsri_slopes *s = &w->element.slope;
    const double trace = 1e-9 * mbsri_element_work(w, bodies, gross);
    int turns, rotation, moves, translation;
    for (int k = 0; k < bodies; ++k) {
        if (s->row[k] < 0) continue;
        const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
        const double *f = y + s->row[k], *size = gross + s->row[k];
        const bool rigid = mbsri_motion_places(b, &turns, &rotation, &moves, &translation);
        for (int r = rigid ? b->d : 0; r < b->d + b->n; ++r) {
            const double span = r < b->d ? 1.0 : w->scale.span[b->u + r - b->d];
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

bool mbsri_element_moves(const mbsri_null_space *w, const mbsri_force *force, int every,
                         const double *a, const double *twist)
{
    const bool joint = (force->def.table->flags & MBSR_FORCE_JOINT_ONLY) != 0;
    if (every > 0) return takes_part(w, every, joint, a, twist);
    for (int k = 0; k < force->def.bodies; ++k) {
        if (takes_part(w, w->m->stored.list_index[force->list + (size_t)k], joint, a, twist))
            return true;
    }
    return false;
}

/* ---- typical sizes ---- */

/* The columns of what an element sees of one of its bodies: of the pose and q, or of V and u. */
typedef struct columns {
    const mbsri_body *b;
    int at, count, joint, joint_count; /* from where, and how many */
    int turns, rotation, moves, translation;
    bool rigid;
    const double *scale; /* joint_count: typical sizes */
} columns;

static columns columns_of(const mbsri_null_space *w, int k, bool velocity)
{
    const mbsr_force_body *body = w->d->element.bodies + k;
    const mbsri_body *b = w->m->body + mbsri_element_body(w, k);
    const int at = w->element.slope.column[k];
    columns c = {.b = b, .at = at, .count = mbsri_pose_size(b)};
    c.joint = mbsri_q_column(body, at);
    c.joint_count = b->nq;
    c.scale = w->scale.q + b->q;
    if (velocity) {
        c.at = mbsri_V_column(body, at);
        c.count = b->d;
        c.joint = mbsri_u_column(body, at);
        c.joint_count = b->n;
        c.scale = w->scale.span + b->u;
    }
    c.rigid = mbsri_motion_places(b, &c.turns, &c.rotation, &c.moves, &c.translation);
    return c;
}

static bool is_turn(const columns *c, int l)
{
    return c->rigid && l >= c->rotation && l < c->rotation + c->turns;
}

/* Of number l among the columns. */
static double typical_size(const mbsri_null_space *w, const columns *c, int l)
{
    if (l >= c->count) return c->scale[l - c->count];
    return is_turn(c, l) ? 1.0 : w->size;
}

static const double *column_of(const mbsri_null_space *w, const columns *c, int l)
{
    const int at = l < c->count ? c->at + l : c->joint + l - c->count;
    return w->element.slope.matrix + (size_t)at * (size_t)w->element.slope.out.rows;
}

void mbsri_element_strain(const mbsri_null_space *w, int bodies, bool velocity, double *gross)
{
    const int rows = w->element.slope.out.rows;
    mbsri_zero((size_t)rows, gross);
    for (int k = 0; k < bodies; ++k) {
        if (w->element.slope.row[k] < 0) continue;
        const columns c = columns_of(w, k, velocity);
        for (int l = 0; l < c.count + c.joint_count; ++l) {
            const double size = typical_size(w, &c, l), *column = column_of(w, &c, l);
            for (int r = 0; r < rows; ++r) gross[r] += size * fabs(column[r]);
        }
    }
}

/* ---- which elements ---- */

/* gross (rows) = the largest that one number of the motion, times `share`, or a typical one, times
 * `least`, makes of the forces; rotation and translation of a rigid body by their sizes. */
static void find_threshold(const mbsri_null_space *w, int bodies, bool velocity,
                           mbsri_element_motion x, double share, double least, double *gross)
{
    const int rows = w->element.slope.out.rows;
    mbsri_zero((size_t)rows, gross);
    for (int k = 0; k < bodies; ++k) {
        if (w->element.slope.row[k] < 0) continue;
        const columns c = columns_of(w, k, velocity);
        const double *twist = (velocity ? x.V : x.pose) + c.b->v,
                     *joint = velocity ? x.u + c.b->u : x.q + c.b->q;
        const double spin = c.rigid ? mbsri_largest(c.turns, twist + c.rotation) : 0.0,
                     speed = c.rigid ? mbsri_largest(c.moves, twist + c.translation) : 0.0;
        for (int l = 0; l < c.count + c.joint_count; ++l) {
            const double moved = l >= c.count        ? fabs(joint[l - c.count])
                                 : is_turn(&c, l)    ? spin
                                 : c.rigid           ? speed + w->size * spin
                                 : c.count == c.b->d ? fabs(twist[l])
                                                     : 0.0;
            const double size = fmax(share * moved, least * typical_size(w, &c, l)),
                         *column = column_of(w, &c, l);
            for (int r = 0; r < rows; ++r) gross[r] = fmax(gross[r], size * fabs(column[r]));
        }
    }
    add_orientation(w, bodies, gross);
}

int mbsri_element_resists(mbsri_null_space *w, const mbsri_force *force, const double *a,
                          const double *twist, const double *q_rate, bool velocity, double share,
                          double least, bool *resists)
{
    const mbsr_model *m = w->m;
    const bool every = (force->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    const mbsri_element_motion x = velocity ? (mbsri_element_motion){.V = twist, .u = a}
                                            : (mbsri_element_motion){.pose = twist, .q = q_rate};
    *resists = false;
    for (int i = 1; i <= (every ? m->bodies : 1) && !*resists; ++i) {
        if (!mbsri_element_moves(w, force, every ? i : 0, a, twist)) continue;
        const int status = mbsri_force_slopes(m, w->d, force, i, &w->element.slope);
        if (status) return status;
        const int bodies = every ? 1 : force->def.bodies;
        double *y = w->element.reaction, *gross = y + w->element.slope.out.rows;
        if (!mbsri_element_react(w, bodies, x, true, y, gross)) continue;
        find_threshold(w, bodies, velocity, x, share, least, gross);
        *resists = mbsri_element_stands_out(w, bodies, 1.0, y, gross);
    }
    return MBSR_OK;
}
