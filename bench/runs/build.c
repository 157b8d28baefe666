/* Stiff trees in libmbsrank.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "build.h"

#include "bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double norm(const double x[3])
{
    return sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

/* ---- forces of the description ----------------------------------------------------------------
 * */

/* A point of a body: lever from its origin, position, velocity; world. */
typedef struct point {
    double r[3], p[3], v[3];
} point;

static point find_point(const mbsr_force_body *b, const double at[3])
{
    point x = {{0.0}, {0.0}, {0.0}};
    if (b->space == MBSR_SPACE_PLANAR) {
        const double cosine = cos(b->p[2]), sine = sin(b->p[2]);
        x.r[0] = cosine * at[0] - sine * at[1], x.r[1] = sine * at[0] + cosine * at[1];
        x.p[0] = b->p[0] + x.r[0], x.p[1] = b->p[1] + x.r[1];
        x.v[0] = b->V[0] - b->V[2] * x.r[1], x.v[1] = b->V[1] + b->V[2] * x.r[0];
        return x;
    }
    const double *R = b->p + MBSR_POSE_R, *w = b->V;
    for (int i = 0; i < 3; ++i) x.r[i] = R[i] * at[0] + R[3 + i] * at[1] + R[6 + i] * at[2];
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        x.p[i] = b->p[MBSR_POSE_X + i] + x.r[i];
        x.v[i] = b->V[3 + i] + w[j] * x.r[k] - w[k] * x.r[j];
    }
    return x;
}

/* The body gets the force f, times `sign`, at the lever r. */
static void add_at(const mbsr_force_body *b, const double r[3], double sign, const double f[3])
{
    if (b->space == MBSR_SPACE_PLANAR) {
        b->f[0] += sign * f[0], b->f[1] += sign * f[1];
        b->f[2] += sign * (r[0] * f[1] - r[1] * f[0]);
        return;
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        b->f[i] += sign * (r[j] * f[k] - r[k] * f[j]);
        b->f[3 + i] += sign * f[i];
    }
}

static int push(const mbsr_force_args *args)
{
    const stiff_model *s = args->force->user;
    const point x = find_point(args->body, s->load_at);
    double f[3];
    s->force(args->force->option[0], args->t, x.p, x.v, f);
    add_at(args->body, x.r, 1.0, f);
    return MBSR_OK;
}

static int pull(const mbsr_force_args *args)
{
    const stiff_ball *s = args->force->user;
    const point b = find_point(args->body + 1, s->at_b);
    for (int k = 0; k < 3; ++k) {
        double at[3] = {s->at_a[0], s->at_a[1], s->at_a[2]}, line[3], square = 0.0, rate = 0.0;
        at[k] -= s->length;
        const point a = find_point(args->body, at);
        for (int i = 0; i < 3; ++i) {
            line[i] = b.p[i] - a.p[i];
            square += line[i] * line[i];
            rate += line[i] * (b.v[i] - a.v[i]);
        }
        const double length = sqrt(square);
        const double force = s->stiffness * (length - s->length) + s->damping * rate / length;
        for (int i = 0; i < 3; ++i) line[i] *= force / length;
        add_at(args->body, a.r, 1.0, line);
        add_at(args->body + 1, b.r, -1.0, line);
    }
    return MBSR_OK;
}

static void cross(const double a[3], const double b[3], double c[3])
{
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        c[i] = a[j] * b[k] - a[k] * b[j];
    }
}

/* One of its springs: the force f on a, and how it changes with b's place and velocity relative to
 * a. */
typedef struct rubber {
    point end[2];
    double f[3], by_p[3][3], by_v[3][3];
} rubber;

static rubber stretch(const stiff_ball *s, const mbsr_force_body *body, int along)
{
    rubber x;
    double at[3] = {s->at_a[0], s->at_a[1], s->at_a[2]}, n[3], v[3], length = 0.0, rate = 0.0;
    at[along] -= s->length;
    x.end[0] = find_point(body, at);
    x.end[1] = find_point(body + 1, s->at_b);
    for (int i = 0; i < 3; ++i) {
        n[i] = x.end[1].p[i] - x.end[0].p[i];
        v[i] = x.end[1].v[i] - x.end[0].v[i];
        length += n[i] * n[i];
    }
    length = sqrt(length);
    for (int i = 0; i < 3; ++i) n[i] /= length, rate += n[i] * v[i];
    const double force = s->stiffness * (length - s->length) + s->damping * rate;
    for (int i = 0; i < 3; ++i) {
        x.f[i] = force * n[i];
        for (int j = 0; j < 3; ++j) {
            const double across = (i == j) - n[i] * n[j];
            x.by_v[i][j] = s->damping * n[i] * n[j];
            x.by_p[i][j] = s->stiffness * n[i] * n[j] + force / length * across +
                           s->damping / length * n[i] * (v[j] - rate * n[j]);
        }
    }
    return x;
}

/* The change of what one spring exerts with number k of the pose (0 to 5) or of V (6 to 11) of an
 * end. */
static void add_change(const rubber *x, const mbsr_force_body *body, int end, int k,
                       const mbsr_force_derivatives *out)
{
    const double *r = x->end[end].r, sign = end ? 1.0 : -1.0;
    double unit[3] = {0.0}, p[3] = {0.0}, v[3] = {0.0}, df[3] = {0.0};
    unit[k % 3] = 1.0;
    if (k < 3) cross(unit, r, p), cross(body[end].V, p, v);
    if (k / 3 == 1) memcpy(p, unit, sizeof p);
    if (k / 3 == 2) cross(unit, r, v);
    if (k / 3 == 3) memcpy(v, unit, sizeof v);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) df[i] += sign * (x->by_p[i][j] * p[j] + x->by_v[i][j] * v[j]);
    }
    for (int on = 0; on < 2; ++on) {
        double *to =
            out->matrix + (size_t)(out->column[end] + k) * (size_t)out->rows + out->row[on];
        double moment[3], turned[3] = {0.0};
        cross(x->end[on].r, df, moment);
        if (on == end && k < 3) cross(p, x->f, turned);
        for (int i = 0; i < 3; ++i) {
            to[i] += (on ? -1.0 : 1.0) * (moment[i] + turned[i]);
            to[3 + i] += (on ? -1.0 : 1.0) * df[i];
        }
    }
}

/* Of bodies in space. */
static int pull_slopes(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    for (int along = 0; along < 3; ++along) {
        const rubber x = stretch(args->force->user, args->body, along);
        for (int k = 0; k < 24; ++k) add_change(&x, args->body, k / 12, k % 12, out);
    }
    return MBSR_OK;
}

static const mbsr_force_table pull_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                            .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
                                            .name = "ball joint with rubber",
                                            .evaluate = pull,
                                            .derivatives = pull_slopes};

static const mbsr_force_table push_table = {.version = MBSR_FORCE_TABLE_VERSION,
                                            .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
                                            .name = "load",
                                            .evaluate = push};

static void add_force(mbsr_model *m, mbsr_force_def force)
{
    bench_check(mbsr_model_add_force(m, &force, NULL), "force", mbsr_model_error(m)->text);
}

static void add_forces(mbsr_model *m, stiff_model *s)
{
    for (int k = 0; k < s->bodies; ++k) {
        const stiff_body *b = s->body + k;
        for (int i = 0; i < b->axes; ++i) {
            const stiff_axis *a = b->axis + i;
            if (a->stiffness > 0.0 || a->damping > 0.0)
                add_force(m, mbsr_force_joint_spring(k, i, a->stiffness, a->damping, a->rest));
        }
    }
    for (int k = 0; k < s->balls; ++k) {
        const int bodies[2] = {s->ball[k].a, s->ball[k].b};
        add_force(m, mbsr_force_custom(&pull_table, 2, bodies, s->ball + k));
    }
    for (int k = 0; k < s->loads; ++k) {
        mbsr_force_def load = mbsr_force_custom(&push_table, 1, s->load + k, s);
        load.option[0] = k;
        add_force(m, load);
    }
    if (s->gravity[0] != 0.0 || s->gravity[1] != 0.0 || s->gravity[2] != 0.0)
        add_force(m, mbsr_force_gravity(s->gravity[0], s->gravity[1], s->gravity[2]));
}

/* ---- model ------------------------------------------------------------------------------------
 * */

static mbsr_joint joint_in_plane(const stiff_body *b)
{
    const mbsr_planar_frame A = {b->place[0], b->place[1], 0.0}, B = {0.0, 0.0, 0.0};
    return mbsr_joint_planar_revolute(A, B);
}

static mbsr_joint joint_in_space(const stiff_body *b)
{
    const mbsr_frame A = mbsr_frame_at(b->place[0], b->place[1], b->place[2]);
    mbsr_axis axes[STIFF_AXES];
    if (b->free) return mbsr_joint_free(&A, NULL);
    if (b->axes == 1)
        return b->axis->turns ? mbsr_joint_revolute(&A, NULL, b->axis->direction)
                              : mbsr_joint_prismatic(&A, NULL, b->axis->direction);
    if (b->axes == 2 && b->axis[0].turns && b->axis[1].turns)
        return mbsr_joint_universal(&A, NULL, b->axis[0].direction, b->axis[1].direction);
    for (int k = 0; k < b->axes; ++k) {
        axes[k] =
            (mbsr_axis){.kind = b->axis[k].turns ? MBSR_AXIS_ROTATION : MBSR_AXIS_TRANSLATION};
        memcpy(axes[k].direction, b->axis[k].direction, sizeof axes[k].direction);
    }
    return mbsr_joint_compound(&A, NULL, b->axes, axes, NULL, NULL);
}

static mbsr_inertia inertia(const stiff_model *s, const stiff_body *b, int plane,
                            double replacement)
{
    const double moment = replacement / s->mass_size * s->moment_size,
                 tensor[6] = {moment, moment, moment};
    if (b->mass > 0.0)
        return plane ? mbsr_inertia_planar(b->mass, b->com, b->tensor[MBSR_ZZ])
                     : mbsr_inertia_rigid(b->mass, b->com, b->tensor);
    return replacement > 0.0 ? mbsr_inertia_rigid(replacement, b->com, tensor)
                             : mbsr_inertia_zero();
}

mbsr_model *build_model(stiff_model *s, int plane, double replacement)
{
    mbsr_model *m = NULL;
    bench_check(mbsr_model_create(NULL, &m, NULL), "mbsr_model_create", NULL);
    plane = plane && s->in_plane;
    for (int k = 0; k < s->bodies; ++k) {
        const stiff_body *b = s->body + k;
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = b->parent == STIFF_GROUND ? MBSR_GROUND : b->parent;
        body.joint = plane ? joint_in_plane(b) : joint_in_space(b);
        body.inertia = inertia(s, b, plane, replacement);
        bench_check(mbsr_model_add_body(m, &body, NULL), "body", mbsr_model_error(m)->text);
    }
    add_forces(m, s);
    bench_check(mbsr_model_finish(m), "mbsr_model_finish", mbsr_model_error(m)->text);
    return m;
}

/* ---- start ------------------------------------------------------------------------------------
 * */

/* y at rest, in the position of the description. */
static void rest(const stiff_model *s, const mbsr_model *m, mbsr_data *d, double *y)
{
    double *q = bench_allocate((size_t)mbsr_model_nq(m) + 1, sizeof *q),
           *u = bench_allocate((size_t)mbsr_model_nu(m) + 1, sizeof *u);
    for (int k = 0; k < s->bodies; ++k) {
        int at;
        bench_check(mbsr_body_coordinates(m, k, &at, NULL, NULL, NULL), "coordinates", NULL);
        if (s->body[k].free) q[at] = 1.0;
        for (int i = 0; i < s->body[k].axes; ++i) q[at + i] = s->body[k].axis[i].start;
    }
    bench_check(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), "start",
                mbsr_data_error(d)->text);
    free(q);
    free(u);
}

void build_start(const stiff_model *s, const mbsr_model *m, mbsr_data *d, double *y, double *yp)
{
    rest(s, m, d, y);
    bench_check(mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL), "start",
                mbsr_data_error(d)->text);
}

void build_tolerances(const stiff_model *s, const mbsr_model *m, double tolerance, double *atol)
{
    const int nq = mbsr_model_nq(m), nu = mbsr_model_nu(m);
    double mass = 0.0, moment = 0.0, length = 0.0;
    for (int k = 0; k < s->bodies; ++k) length += norm(s->body[k].com);
    for (int k = s->bodies - 1; k >= 0; --k) {
        int q, u, n;
        bench_check(mbsr_body_coordinates(m, k, &q, NULL, &u, &n), "coordinates", NULL);
        mass += s->body[k].mass;
        moment += mass * norm(s->body[k].com);
        for (int i = 0; i < n; ++i) {
            atol[q + i] = tolerance / s->bodies;
            atol[nq + u + i] = tolerance * moment * length;
            atol[nq + nu + u + i] = tolerance;
        }
    }
}

void build_places(const mbsr_model *m, mbsr_data *d, double t, const double *q, double *x)
{
    bench_check(mbsr_stage_positions(m, d, t, q), "positions", mbsr_data_error(d)->text);
    for (int k = 0; k < mbsr_model_bodies(m); ++k) {
        double p[MBSR_POSE_SIZE];
        bench_check(mbsr_body_pose(m, d, k, p), "pose", mbsr_data_error(d)->text);
        if (mbsr_body_dimension(m, k) == 6)
            memcpy(x + 3 * k, p + MBSR_POSE_X, 3 * sizeof *x);
        else
            x[3 * k] = p[0], x[3 * k + 1] = p[1], x[3 * k + 2] = 0.0;
    }
}
