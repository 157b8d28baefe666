/* The forces at one point of contact: see law.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "contact/law.h"

#include "algebra/space3.h"

#include <stdlib.h>
#include <string.h>

/* ---- of two shapes ---- */

int mbsri_compare_couples(const void *x, const void *y)
{
    const mbsr_shape_pair *a = x, *b = y;
    return a->a != b->a ? (a->a > b->a) - (a->a < b->a) : (a->b > b->b) - (a->b < b->b);
}

const mbsr_shape_pair *mbsri_find_couple(const mbsr_contacts *c, int a, int b)
{
    const mbsr_shape_pair key = {.a = a, .b = b};
    return c->couples > 0
               ? bsearch(&key, c->couple, (size_t)c->couples, sizeof key, mbsri_compare_couples)
               : NULL;
}

int mbsri_compare_excluded(const void *x, const void *y)
{
    const int *a = x, *b = y;
    return a[0] != b[0] ? (a[0] > b[0]) - (a[0] < b[0]) : (a[1] > b[1]) - (a[1] < b[1]);
}

static bool is_excluded(const mbsr_contacts *c, int a, int b)
{
    const int key[2] = {a < b ? a : b, a < b ? b : a};
    return c->excluded > 0 && bsearch(key, c->exclude, (size_t)c->excluded, sizeof *c->exclude,
                                      mbsri_compare_excluded) != NULL;
}

/* Of one part, or of two of which one carries the other. */
static bool are_joined(const mbsri_shape *x, const mbsri_shape *y)
{
    return x->part == y->part || x->carrier == y->part || y->carrier == x->part;
}

bool mbsri_may_touch(const mbsr_contacts *c, int a, int b)
{
    const mbsri_shape *x = c->shape + a, *y = c->shape + b;
    if (x->body == y->body) return false;
    const mbsr_shape_pair *own = mbsri_find_couple(c, a < b ? a : b, a < b ? b : a);
    return own ? !own->never
               : mbsri_by_groups(x, y) && !are_joined(x, y) && !is_excluded(c, x->body, y->body);
}

mbsr_contact_law mbsri_law_of_shapes(const mbsr_contacts *c, int a, int b)
{
    const mbsr_shape_pair *own = mbsri_find_couple(c, a, b);
    if (own) return own->law;
    const mbsr_contact_law *x = &c->shape[a].law, *y = &c->shape[b].law;
    return (mbsr_contact_law){.stiffness = 1.0 / (1.0 / x->stiffness + 1.0 / y->stiffness),
                              .exponent = fmax(x->exponent, y->exponent),
                              .damping = fmax(x->damping, y->damping),
                              .friction = fmax(x->friction, y->friction),
                              .slip = fmax(x->slip, y->slip),
                              .torsional = fmax(x->torsional, y->torsional),
                              .rolling = fmax(x->rolling, y->rolling),
                              .spin = fmax(x->spin, y->spin),
                              .margin = x->margin + y->margin};
}

/* ---- at a point ---- */

static const double nothing[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};

static const double *body_origin(const mbsr_force_body *body)
{
    return body->space == MBSR_SPACE_SPATIAL ? body->p + MBSR_POSE_X : nothing;
}

static const double *body_twist(const mbsr_force_body *body)
{
    return body->space == MBSR_SPACE_SPATIAL && body->V ? body->V : nothing;
}

/* x^exponent; those of lines and spheres without logarithms */
static double power_of(double x, double exponent)
{
    return exponent == 1.0 ? x : exponent == 1.5 ? x * sqrt(x) : pow(x, exponent);
}

static double elastic_force(const mbsr_contact_law *law, const mbsri_touch *t)
{
    return t->weight * law->stiffness * power_of(t->depth, law->exponent);
}

/* The energy of a point of the weight 1. */
static double full_energy(const mbsr_contact_law *law, const mbsri_touch *t)
{
    return law->stiffness * power_of(t->depth, law->exponent) * t->depth / (law->exponent + 1.0);
}

/* Torsional and rolling friction. */
static void find_moment(const mbsr_contact_law *law, const mbsri_touch *t, mbsri_action *f)
{
    f->wn = mbsri_dot3(t->n, f->w);
    memcpy(f->wt, f->w, sizeof f->wt);
    mbsri_add3(-f->wn, t->n, f->wt);
    if (law->torsional > 0.0) f->torsion = law->torsional * f->normal / hypot(f->wn, law->spin);
    if (law->rolling > 0.0)
        f->roll = law->rolling * f->normal / hypot(mbsri_norm3(f->wt), law->spin);
    mbsri_add3(-f->torsion * f->wn, t->n, f->moment);
    mbsri_add3(-f->roll, f->wt, f->moment);
}

void mbsri_act(const mbsr_contact_law *law, const mbsri_touch *t, const mbsr_force_body *a,
               const mbsr_force_body *b, mbsri_action *f)
{
    const double *Va = body_twist(a), *Vb = body_twist(b), *xa = body_origin(a),
                 *xb = body_origin(b);
    *f = (mbsri_action){0};
    mbsri_touch_point(t, f->p);
    for (int k = 0; k < 3; ++k) {
        f->arm_a[k] = f->p[k] - xa[k];
        f->arm_b[k] = f->p[k] - xb[k];
        f->w[k] = Va[k] - Vb[k];
        f->v[k] = Va[3 + k] - Vb[3 + k];
    }
    double turned[3];
    mbsri_add_cross3(Va, f->arm_a, f->v);
    mbsri_cross3(Vb, f->arm_b, turned);
    mbsri_add3(-1.0, turned, f->v);
    f->rate = -mbsri_dot3(t->n, f->v);
    memcpy(f->sliding, f->v, sizeof f->sliding);
    mbsri_add3(f->rate, t->n, f->sliding);
    f->elastic = elastic_force(law, t);
    f->normal = f->elastic * fmax(0.0, 1.0 + law->damping * f->rate);
    mbsri_add3(f->normal, t->n, f->force);
    if (law->friction > 0.0) {
        f->speed = sqrt(mbsri_dot3(f->sliding, f->sliding) + law->slip * law->slip);
        f->drag = law->friction * f->normal / f->speed;
        mbsri_add3(-f->drag, f->sliding, f->force);
    }
    if (law->torsional > 0.0 || law->rolling > 0.0) find_moment(law, t, f);
    if (t->by_cosine == 0.0) return;
    double about[3]; /* the cosine grows by about . (wa - wb) */
    mbsri_cross3(t->ta, t->n, about);
    mbsri_add3(-full_energy(law, t) * t->by_cosine, about, f->moment);
}

double mbsri_action_energy(const mbsr_contact_law *law, const mbsri_touch *t)
{
    return t->weight * full_energy(law, t);
}

double mbsri_action_heat(const mbsri_action *f)
{
    return (f->normal - f->elastic) * f->rate + f->drag * mbsri_dot3(f->sliding, f->sliding) +
           f->torsion * f->wn * f->wn + f->roll * mbsri_dot3(f->wt, f->wt);
}

/* ---- derivatives ---- */

/* Changes of what the law reads, and of what it gives. */
typedef struct change {
    mbsri_touch_change along;
    double xa[3], xb[3], v[3], w[3]; /* of the origins; of v and w */
    double force[3], moment[3];
} change;

static void slope_of_moment(const mbsr_contact_law *law, const mbsri_touch *t,
                            const mbsri_action *f, double dN, change *c)
{
    const double *dn = c->along.n;
    const double dwn = mbsri_dot3(dn, f->w) + mbsri_dot3(t->n, c->w);
    double dwt[3];
    for (int k = 0; k < 3; ++k) dwt[k] = c->w[k] - dwn * t->n[k] - f->wn * dn[k];
    double dtorsion = 0.0, droll = 0.0;
    if (law->torsional > 0.0) {
        const double square = f->wn * f->wn + law->spin * law->spin;
        dtorsion = law->torsional * dN / sqrt(square) - f->torsion * f->wn * dwn / square;
    }
    if (law->rolling > 0.0) {
        const double square = mbsri_dot3(f->wt, f->wt) + law->spin * law->spin;
        droll = law->rolling * dN / sqrt(square) - f->roll * mbsri_dot3(f->wt, dwt) / square;
    }
    for (int k = 0; k < 3; ++k) {
        c->moment[k] = -(dtorsion * f->wn + f->torsion * dwn) * t->n[k] -
                       f->torsion * f->wn * dn[k] - droll * f->wt[k] - f->roll * dwt[k];
    }
}

/* That of the moment by which the weight's energy is not lost. */
static void slope_of_share(const mbsr_contact_law *law, const mbsri_touch *t, change *c)
{
    const double energy = full_energy(law, t),
                 denergy = law->stiffness * power_of(t->depth, law->exponent) * c->along.depth;
    double about[3], dabout[3];
    mbsri_cross3(t->ta, t->n, about);
    mbsri_cross3(c->along.axis, t->n, dabout);
    mbsri_add_cross3(t->ta, c->along.n, dabout);
    mbsri_add3(-denergy * t->by_cosine - energy * t->curve * c->along.cosine, about, c->moment);
    mbsri_add3(-energy * t->by_cosine, dabout, c->moment);
}

static void slope_of_force(const mbsr_contact_law *law, const mbsri_touch *t, const mbsri_action *f,
                           change *c)
{
    const double *dn = c->along.n;
    const double drate = -mbsri_dot3(dn, f->v) - mbsri_dot3(t->n, c->v);
    const double dN =
        f->normal * (law->exponent * c->along.depth / t->depth + c->along.weight / t->weight) +
        (f->normal > 0.0 ? f->elastic * law->damping * drate : 0.0);
    double dsliding[3];
    for (int k = 0; k < 3; ++k) {
        dsliding[k] = c->v[k] + drate * t->n[k] + f->rate * dn[k];
        c->force[k] = dN * t->n[k] + f->normal * dn[k];
    }
    if (law->friction > 0.0) {
        const double ddrag = law->friction * dN / f->speed -
                             f->drag * mbsri_dot3(f->sliding, dsliding) / (f->speed * f->speed);
        mbsri_add3(-ddrag, f->sliding, c->force);
        mbsri_add3(-f->drag, dsliding, c->force);
    }
    if (law->torsional > 0.0 || law->rolling > 0.0) slope_of_moment(law, t, f, dN, c);
    if (t->by_cosine != 0.0) slope_of_share(law, t, c);
}

/* Changes by number r of the pose of a (or of b). */
static void move_pose(const mbsri_touch *t, const mbsr_force_body *a, const mbsr_force_body *b,
                      bool of_a, int r, change *c)
{
    mbsri_motion by = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    const double *x = body_origin(of_a ? a : b), *at = of_a ? t->pa : t->pb;
    double *w = of_a ? by.wa : by.wb, *v = of_a ? by.va : by.vb;
    if (r < 3) {
        const double arm[3] = {at[0] - x[0], at[1] - x[1], at[2] - x[2]};
        w[r] = 1.0;
        mbsri_cross3(w, arm, v);
    } else {
        v[r - 3] = (of_a ? c->xa : c->xb)[r - 3] = 1.0;
    }
    mbsri_touch_moves(t, &by, &c->along);
    double arm_a[3], arm_b[3], turned[3];
    for (int k = 0; k < 3; ++k) {
        arm_a[k] = c->along.p[k] - c->xa[k];
        arm_b[k] = c->along.p[k] - c->xb[k];
    }
    mbsri_add_cross3(body_twist(a), arm_a, c->v);
    mbsri_cross3(body_twist(b), arm_b, turned);
    mbsri_add3(-1.0, turned, c->v);
}

/* Where derivatives by a column go: rows of a and of b; NULL: there are none. */
typedef struct rows_of {
    double *a, *b;
} rows_of;

static rows_of rows_at(const mbsr_force_derivatives *out, const int place[2], int column)
{
    double *to = out->matrix + (ptrdiff_t)column * out->rows;
    const int a = out->row[place[0]], b = out->row[place[1]];
    return (rows_of){a >= 0 ? to + a : NULL, b >= 0 ? to + b : NULL};
}

/* Adds a wrench about the origin of a body, whose arm it acts at; sign 1, or -1 for b. */
static inline void put(double sign, const double arm[3], const double force[3],
                       const double moment[3], double *rows)
{
    double about[3];
    mbsri_cross3(arm, force, about);
    for (int k = 0; k < 3; ++k) {
        rows[k] += sign * (about[k] + moment[k]);
        rows[3 + k] += sign * force[k];
    }
}

/* And what the force makes of moved arms. */
static inline void put_moved(double sign, const double arm[3], const double origin[3],
                             const mbsri_action *f, const change *c, double *rows)
{
    double darm[3], moment[3];
    for (int k = 0; k < 3; ++k) darm[k] = c->along.p[k] - origin[k], moment[k] = c->moment[k];
    mbsri_add_cross3(darm, f->force, moment);
    put(sign, arm, c->force, moment, rows);
}

/* By the poses. When both bodies are moved along nothing changes, so b's are those of a, the other
 * way. */
static void put_poses(const mbsr_contact_law *law, const mbsri_touch *t, const mbsr_force_body *a,
                      const mbsr_force_body *b, const mbsri_action *f,
                      const mbsr_force_derivatives *out, const int place[2])
{
    const int first_a = out->column[place[0]], first_b = out->column[place[1]];
    for (int l = 0; l < 12; ++l) {
        const bool of_a = l < 6;
        const int r = l % 6, first = of_a ? first_a : first_b;
        if (first < 0 || (!of_a && r >= 3 && first_a >= 0)) continue;
        change c = {0};
        move_pose(t, a, b, of_a, r, &c);
        slope_of_force(law, t, f, &c);
        for (int side = 0; side < (of_a && r >= 3 && first_b >= 0 ? 2 : 1); ++side) {
            const double sign = side == 0 ? 1.0 : -1.0;
            const rows_of to = rows_at(out, place, (side == 0 ? first : first_b) + r);
            if (to.a) put_moved(sign, f->arm_a, c.xa, f, &c, to.a);
            if (to.b) put_moved(-sign, f->arm_b, c.xb, f, &c, to.b);
        }
    }
}

/* By the velocities, of which v and w follow: six changes in all. */
static void put_rates(const mbsr_contact_law *law, const mbsri_touch *t, const mbsri_action *f,
                      const mbsr_force_derivatives *out, const int place[2])
{
    const bool turns = law->torsional > 0.0 || law->rolling > 0.0;
    double force[6][3] = {{0.0}}, moment[6][3] = {{0.0}}; /* by w, v */
    for (int r = turns ? 0 : 3; r < 6; ++r) {
        change c = {0};
        (r < 3 ? c.w : c.v)[r % 3] = 1.0;
        slope_of_force(law, t, f, &c);
        memcpy(force[r], c.force, sizeof force[r]);
        memcpy(moment[r], c.moment, sizeof moment[r]);
    }
    for (int l = 0; l < 12; ++l) {
        const int side = l / 6, r = l % 6, first = out->column[place[side]];
        if (first < 0) continue;
        const double sign = side == 0 ? 1.0 : -1.0, *arm = side == 0 ? f->arm_a : f->arm_b;
        double F[3], M[3];
        memcpy(F, force[r], sizeof F);
        memcpy(M, moment[r], sizeof M);
        if (r < 3) { /* v = e_r x arm */
            const int next = (r + 1) % 3, last = (r + 2) % 3;
            for (int k = 0; k < 3; ++k) {
                F[k] += arm[next] * force[3 + last][k] - arm[last] * force[3 + next][k];
                M[k] += arm[next] * moment[3 + last][k] - arm[last] * moment[3 + next][k];
            }
        }
        const rows_of to = rows_at(out, place, first + 6 + r);
        if (to.a) put(sign, f->arm_a, F, M, to.a);
        if (to.b) put(-sign, f->arm_b, F, M, to.b);
    }
}

void mbsri_action_slopes(const mbsr_contact_law *law, const mbsri_touch *t,
                         const mbsr_force_body *a, const mbsr_force_body *b, const mbsri_action *f,
                         const mbsr_force_derivatives *out)
{
    const int place[2] = {t->exchanged ? 1 : 0, t->exchanged ? 0 : 1};
    if (!(f->normal > 0.0) && t->by_cosine == 0.0) return;
    put_poses(law, t, a, b, f, out, place);
    put_rates(law, t, f, out, place);
}
