/* Inertias of bodies in space against clouds of particles, Lagrange's equations and each other;
 * what is refused.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"
#include "recursion/inertia.h"
#include "samples.h"

#include <stdio.h>
#include <string.h>

/* ---- clouds of particles in body axes ------------------------------------------------------- */

enum { CLOUD = 6000 };

typedef struct cloud {
    int count;
    double m[CLOUD], x[CLOUD][3];
} cloud;

static void add_particle(cloud *c, double m, double x, double y, double z)
{
    assert_true(c->count < CLOUD);
    c->m[c->count] = m;
    c->x[c->count][0] = x, c->x[c->count][1] = y, c->x[c->count][2] = z;
    ++c->count;
}

static void random_cloud(cloud *c, int count, test_rng *rng)
{
    c->count = 0;
    for (int k = 0; k < count; ++k) {
        double x[3];
        test_fill(rng, 3, x);
        add_particle(c, 1.1 + test_uniform(rng), x[0], x[1], x[2]);
    }
}

/* The cloud moved with a frame in which it was given. */
static void move_cloud(cloud *c, const mbsr_frame *f)
{
    for (int k = 0; k < c->count; ++k) {
        double y[3];
        for (int i = 0; i < 3; ++i) {
            y[i] = f->x[i];
            for (int j = 0; j < 3; ++j) y[i] += f->R[3 * j + i] * c->x[k][j];
        }
        memcpy(c->x[k], y, sizeof y);
    }
}

/* Mass, centre of mass, and second moments about the point `about`, as a tensor of inertia. */
static void moments(const cloud *c, const double about[3], double *mass, double com[3],
                    double tensor[6])
{
    *mass = 0.0;
    memset(com, 0, 3 * sizeof *com);
    memset(tensor, 0, 6 * sizeof *tensor);
    for (int k = 0; k < c->count; ++k) {
        const double m = c->m[k], x = c->x[k][0] - about[0], y = c->x[k][1] - about[1],
                     z = c->x[k][2] - about[2];
        *mass += m;
        for (int i = 0; i < 3; ++i) com[i] += m * c->x[k][i];
        tensor[MBSR_XX] += m * (y * y + z * z);
        tensor[MBSR_YY] += m * (x * x + z * z);
        tensor[MBSR_ZZ] += m * (x * x + y * y);
        tensor[MBSR_XY] -= m * x * y;
        tensor[MBSR_XZ] -= m * x * z;
        tensor[MBSR_YZ] -= m * y * z;
    }
    for (int i = 0; i < 3 && *mass > 0.0; ++i) com[i] /= *mass;
}

static void assert_same_inertia(const mbsr_inertia *inertia, const cloud *c)
{
    const double origin[3] = {0, 0, 0};
    double mass, com[3], tensor[6], unused[3];
    moments(c, origin, &mass, com, tensor);
    moments(c, com, &mass, unused, tensor);
    assert_int_equal(inertia->kind, MBSR_INERTIA_SPATIAL);
    const double size = mass + test_largest(6, tensor);
    assert_close(inertia->mass, mass, 1e-13 * size);
    for (int k = 0; k < 3; ++k) assert_close(inertia->com[k], com[k], 1e-13);
    for (int k = 0; k < 6; ++k) assert_close(inertia->tensor[k], tensor[k], 1e-13 * size);
}

/* ---- solids, integrated --------------------------------------------------------------------- */

/* Gauss's points and weights for polynomials up to degree 5 on -1 .. 1. */
static const double gauss_x[3] = {-0.774596669241483377, 0.0, 0.774596669241483377},
                    gauss_w[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};

/* A disc of radius^2 = square and this mass at height z: exact for second moments. */
static void add_disc(cloud *c, double mass, double square, double z)
{
    enum { TURN = 8 };
    for (int i = 0; i < 3; ++i) {
        const double share = 0.5 * (1.0 + gauss_x[i]), r = sqrt(square * share);
        for (int k = 0; k < TURN; ++k) {
            const double angle = 2.0 * acos(-1.0) * k / TURN;
            add_particle(c, mass * 0.5 * gauss_w[i] / TURN, r * cos(angle), r * sin(angle), z);
        }
    }
}

/* A body of revolution between two heights with radius^2 = a + b (z - z0)^2. */
static void add_revolution(cloud *c, double density, double low, double high, double a, double b,
                           double z0)
{
    for (int i = 0; i < 3; ++i) {
        const double z = 0.5 * (low + high) + 0.5 * (high - low) * gauss_x[i],
                     square = a + b * (z - z0) * (z - z0);
        const double mass = density * acos(-1.0) * square * 0.5 * (high - low) * gauss_w[i];
        if (mass > 0.0) add_disc(c, mass, square, z);
    }
}

static void solids_agree_with_integrals(void **state)
{
    (void)state;
    static cloud c;
    const double edges[3] = {0.3, 0.7, 1.9}, density = 7.8;
    c.count = 0;
    for (int i = 0; i < 27; ++i) {
        const int k[3] = {i % 3, i / 3 % 3, i / 9};
        double x[3], m = density;
        for (int l = 0; l < 3; ++l) {
            x[l] = 0.5 * edges[l] * gauss_x[k[l]];
            m *= 0.5 * edges[l] * gauss_w[k[l]];
        }
        add_particle(&c, m, x[0], x[1], x[2]);
    }
    mbsr_inertia inertia = mbsr_inertia_box(density, edges);
    assert_same_inertia(&inertia, &c);

    const double r = 0.6, l = 1.7;
    c.count = 0;
    add_revolution(&c, density, -r, r, r * r, -1.0, 0.0);
    inertia = mbsr_inertia_sphere(density, r);
    assert_same_inertia(&inertia, &c);

    c.count = 0;
    add_revolution(&c, density, -0.5 * l, 0.5 * l, r * r, 0.0, 0.0);
    inertia = mbsr_inertia_cylinder(density, r, l);
    assert_same_inertia(&inertia, &c);

    add_revolution(&c, density, 0.5 * l, 0.5 * l + r, r * r, -1.0, 0.5 * l);
    add_revolution(&c, density, -0.5 * l - r, -0.5 * l, r * r, -1.0, -0.5 * l);
    inertia = mbsr_inertia_capsule(density, r, l);
    assert_same_inertia(&inertia, &c);

    /* a capsule without length is a sphere */
    const mbsr_inertia ball = mbsr_inertia_sphere(density, r),
                       round = mbsr_inertia_capsule(density, r, 0.0);
    assert_close(round.mass, ball.mass, 1e-15);
    for (int k = 0; k < 6; ++k) assert_close(round.tensor[k], ball.tensor[k], 1e-15);
}

static void rods_and_points_agree_with_particles(void **state)
{
    (void)state;
    static cloud c;
    test_rng rng = test_seed(41);
    double a[3], b[3];
    test_fill(&rng, 3, a);
    test_fill(&rng, 3, b);
    c.count = 0;
    for (int i = 0; i < 3; ++i) {
        const double s = 0.5 * (1.0 + gauss_x[i]);
        add_particle(&c, 2.5 * 0.5 * gauss_w[i], a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]),
                     a[2] + s * (b[2] - a[2]));
    }
    mbsr_inertia inertia = mbsr_inertia_rod(2.5, a, b);
    assert_same_inertia(&inertia, &c);
    c.count = 0;
    add_particle(&c, 1.5, a[0], a[1], a[2]);
    inertia = mbsr_inertia_point_mass(1.5, a);
    assert_same_inertia(&inertia, &c);
}

static void sums_moves_and_reference_points_agree_with_particles(void **state)
{
    (void)state;
    static cloud c;
    test_rng rng = test_seed(42);
    const double origin[3] = {0, 0, 0};
    for (int l = 0; l < 20; ++l) {
        random_cloud(&c, 5, &rng);
        double mass, com[3], tensor[6], unused[3];
        mbsr_inertia sum = mbsr_inertia_zero();
        for (int k = 0; k < c.count; ++k)
            sum = mbsr_inertia_sum(sum, mbsr_inertia_point_mass(c.m[k], c.x[k]));
        assert_same_inertia(&sum, &c);

        moments(&c, origin, &mass, com, tensor);
        moments(&c, com, &mass, unused, tensor);
        const mbsr_inertia rigid = mbsr_inertia_rigid(mass, com, tensor);
        assert_same_inertia(&rigid, &c);

        /* the tensor about another point and along other axes: of the cloud seen from there */
        static cloud seen;
        const mbsr_frame frame = test_frame(&rng, 2.0), back = mbsr_frame_inverse(&frame);
        seen = c;
        move_cloud(&seen, &back);
        moments(&seen, origin, &mass, unused, tensor);
        const mbsr_inertia about = mbsr_inertia_rigid_about(mass, com, &frame, tensor);
        assert_same_inertia(&about, &c);

        const mbsr_inertia moved = mbsr_inertia_in_frame(&frame, rigid);
        move_cloud(&c, &frame);
        assert_same_inertia(&moved, &c);

        /* a particle at the origin of a frame */
        const mbsr_inertia one = mbsr_inertia_in_frame(&frame, mbsr_inertia_particle(0.7)),
                           both = mbsr_inertia_sum(one, moved),
                           swapped = mbsr_inertia_sum(moved, one);
        add_particle(&c, 0.7, frame.x[0], frame.x[1], frame.x[2]);
        assert_same_inertia(&both, &c);
        assert_same_inertia(&swapped, &c);
    }
}

/* ---- a body that is free in space ----------------------------------------------------------- */

/* Its joint's u is (omega, v) of the body, so that the joint-space mass matrix and bias are its M
 * and h. */
typedef struct body {
    mbsr_model *model;
    mbsr_data *data;
    double q[7], R[9], M[36], h[6];
} body;

static void make_body(body *b, mbsr_inertia inertia, const double *added, test_rng *rng)
{
    assert_ok(mbsr_model_create(NULL, &b->model, NULL), NULL);
    mbsr_body_def def = mbsr_default_body_def();
    def.joint = mbsr_joint_free(NULL, NULL);
    def.inertia = inertia;
    assert_ok(mbsr_model_add_body(b->model, &def, NULL), mbsr_model_error(b->model));
    if (added) assert_ok(mbsr_model_regularise(b->model, 0, 6, added), mbsr_model_error(b->model));
    assert_ok(mbsr_model_finish(b->model), mbsr_model_error(b->model));
    assert_ok(mbsr_data_create(b->model, &b->data, NULL), NULL);
    test_fill(rng, 7, b->q);
    mbsr_quaternion_rotation(b->q, b->R);
}

/* M and h in the pose q for the velocity V. */
static void evaluate_body(body *b, const double *V)
{
    assert_ok(mbsr_bias_forces(b->model, b->data, 0.0, b->q, V, b->h), mbsr_data_error(b->data));
    assert_ok(mbsr_stage_positions(b->model, b->data, 0.0, b->q), mbsr_data_error(b->data));
    assert_ok(mbsr_stage_velocities(b->model, b->data, V), mbsr_data_error(b->data));
    assert_ok(mbsr_mass_matrix(b->model, b->data, b->M), mbsr_data_error(b->data));
}

static void drop_body(body *b)
{
    mbsr_data_destroy(b->data);
    mbsr_model_destroy(b->model);
}

static void cross(const double a[3], const double b[3], double c[3])
{
    for (int k = 0; k < 3; ++k)
        c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void times(int n, const double *A, const double *x, double *y)
{
    for (int i = 0; i < n; ++i) {
        y[i] = 0.0;
        for (int j = 0; j < n; ++j) y[i] += A[j * n + i] * x[j];
    }
}

/* M A + h is what moves the particles, and 1/2 V^T M V is their energy. */
static void rigid_bodies_move_as_their_particles(void **state)
{
    (void)state;
    static cloud c;
    test_rng rng = test_seed(43);
    for (int count = 1; count < 7; ++count) {
        random_cloud(&c, count, &rng);
        mbsr_inertia inertia = mbsr_inertia_zero();
        for (int k = 0; k < count; ++k)
            inertia = mbsr_inertia_sum(inertia, mbsr_inertia_point_mass(c.m[k], c.x[k]));
        body b;
        double V[6], A[6], force[6] = {0.0}, energy = 0.0, MV[6], MA[6];
        make_body(&b, inertia, NULL, &rng);
        test_fill(&rng, 6, V);
        test_fill(&rng, 6, A);
        evaluate_body(&b, V);
        for (int k = 0; k < count; ++k) {
            double arm[3], turn[3], v[3], a[3], spin[3], moment[3];
            times(3, b.R, c.x[k], arm);
            cross(V, arm, turn);
            cross(V, turn, spin);
            cross(A, arm, a);
            for (int i = 0; i < 3; ++i) {
                v[i] = V[3 + i] + turn[i];
                a[i] = c.m[k] * (A[3 + i] + a[i] + spin[i]);
                energy += 0.5 * c.m[k] * v[i] * v[i];
            }
            cross(arm, a, moment);
            for (int i = 0; i < 3; ++i) force[i] += moment[i], force[3 + i] += a[i];
        }
        times(6, b.M, V, MV);
        times(6, b.M, A, MA);
        double twice = 0.0;
        for (int i = 0; i < 6; ++i) {
            twice += V[i] * MV[i];
            assert_close(MA[i] + b.h[i], force[i], 1e-13);
            for (int j = 0; j < 6; ++j) assert_close(b.M[6 * i + j], b.M[6 * j + i], 1e-14);
        }
        assert_close(0.5 * twice, energy, 1e-13);
        drop_body(&b);
    }
    /* a particle at the origin */
    body b;
    const double V[6] = {1, 2, 3, 4, 5, 6};
    make_body(&b, mbsr_inertia_particle(2.5), NULL, &rng);
    evaluate_body(&b, V);
    for (int k = 0; k < 36; ++k) assert_close(b.M[k], k % 7 == 0 && k > 20 ? 2.5 : 0.0, 0.0);
    for (int k = 0; k < 6; ++k) assert_close(b.h[k], 0.0, 0.0);
    drop_body(&b);
}

/* ---- matrices that turn with the body ------------------------------------------------------- */

static void random_matrix(double *A, int rank, test_rng *rng)
{
    double B[36];
    test_fill(rng, 36, B);
    memset(A, 0, 36 * sizeof *A);
    for (int l = 0; l < rank; ++l) {
        for (int i = 0; i < 36; ++i) A[i] += B[6 * l + i % 6] * B[6 * l + i / 6];
    }
}

/* Where the body is after the rotation vector x[0 .. 2] and the shift x[3 .. 5]; D: (omega, v) =
 * D(x) x'. */
static void local(const double R[9], const double x[6], transform *T, double D[9])
{
    const double none[3] = {0, 0, 0};
    *T = transform_product(transform_exp(x, none), transform_of(R, none));
    /* 1 + [x] / 2 + [x]^2 / 6: what second differences see */
    double X[9] = {0, x[2], -x[1], -x[2], 0, x[0], x[1], -x[0], 0};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            double square = 0.0;
            for (int k = 0; k < 3; ++k) square += X[3 * k + i] * X[3 * j + k];
            D[3 * j + i] = (i == j) + X[3 * j + i] / 2.0 + square / 6.0;
        }
    }
}

/* Momenta dT/dx' and the energy T of the matrix A (body axes) at x, x'. */
static double momenta(const double *A, const double R[9], const double x[6], const double xd[6],
                      double p[6])
{
    transform T;
    double D[9], V[6], own[6], momentum[6], world[6], energy = 0.0;
    local(R, x, &T, D);
    times(3, D, xd, V);
    memcpy(V + 3, xd + 3, 3 * sizeof *V);
    for (int half = 0; half < 6; half += 3) {
        for (int i = 0; i < 3; ++i) {
            own[half + i] = 0.0;
            for (int j = 0; j < 3; ++j) own[half + i] += T.m[j][i] * V[half + j];
        }
    }
    times(6, A, own, momentum);
    for (int half = 0; half < 6; half += 3) {
        for (int i = 0; i < 3; ++i) {
            world[half + i] = 0.0;
            for (int j = 0; j < 3; ++j) world[half + i] += T.m[i][j] * momentum[half + j];
        }
    }
    for (int i = 0; i < 6; ++i) energy += 0.5 * V[i] * world[i];
    for (int i = 0; i < 3; ++i) {
        p[i] = D[3 * i] * world[0] + D[3 * i + 1] * world[1] + D[3 * i + 2] * world[2];
        p[3 + i] = world[3 + i];
    }
    return energy;
}

/* Lagrange's equations d/dt dT/dx' - dT/dx by differences at x = 0, where x' = V and x'' = A and
 * the generalised force is the wrench. */
static void lagrange(const double *A, const double R[9], const double V[6], const double acc[6],
                     double force[6])
{
    const double h = 1e-3;
    static const double weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12},
                        at[4] = {-2, -1, 1, 2};
    memset(force, 0, 6 * sizeof *force);
    for (int l = 0; l < 4; ++l) {
        const double s = at[l] * h;
        double x[6], xd[6], p[6];
        for (int i = 0; i < 6; ++i) {
            x[i] = s * V[i] + 0.5 * s * s * acc[i];
            xd[i] = V[i] + s * acc[i];
        }
        momenta(A, R, x, xd, p);
        for (int i = 0; i < 6; ++i) force[i] += weight[l] / h * p[i];
        for (int i = 0; i < 6; ++i) {
            double beside[6] = {0.0}, unused[6];
            beside[i] = s;
            force[i] -= weight[l] / h * momenta(A, R, beside, V, unused);
        }
    }
}

static void matrices_follow_lagranges_equations(void **state)
{
    (void)state;
    test_rng rng = test_seed(44);
    for (int rank = 1; rank < 7; ++rank) {
        double A[36], V[6], acc[6], force[6], MA[6], MV[6], p[6];
        const double none[6] = {0.0};
        body b;
        random_matrix(A, rank, &rng);
        make_body(&b, mbsr_inertia_matrix(6, A), NULL, &rng);
        test_fill(&rng, 6, V);
        test_fill(&rng, 6, acc);
        evaluate_body(&b, V);
        times(6, b.M, V, MV);
        momenta(A, b.R, none, V, p);
        for (int i = 0; i < 6; ++i) assert_close(MV[i], p[i], 1e-13);
        lagrange(A, b.R, V, acc, force);
        times(6, b.M, acc, MA);
        for (int i = 0; i < 6; ++i) assert_close(MA[i] + b.h[i], force[i], 1e-9);
        drop_body(&b);
    }
}

/* The rigid body's own matrix in body axes: M where R is the unit matrix. */
static void own_matrix(const mbsr_inertia *inertia, double *A, test_rng *rng)
{
    body b;
    const double rest[6] = {0.0};
    make_body(&b, *inertia, NULL, rng);
    memset(b.q, 0, sizeof b.q);
    b.q[0] = 1.0;
    evaluate_body(&b, rest);
    memcpy(A, b.M, sizeof b.M);
    drop_body(&b);
}

static mbsr_inertia random_rigid(test_rng *rng)
{
    static const double edges[3] = {0.7, 0.4, 1.3};
    const mbsr_frame frame = test_frame(rng, 1.0);
    return mbsr_inertia_in_frame(&frame, mbsr_inertia_box(2.0, edges));
}

static int by_function(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    (void)t;
    const body *b = user;
    (void)p, (void)V;
    memcpy(M, b->M, sizeof b->M);
    memcpy(h, b->h, sizeof b->h);
    return 0;
}

/* The same body as rigid, as its matrix, as a massless one regularised by it, as zero plus it; and
 * a rigid one regularised by any matrix as the sum of both. */
static void the_same_inertia_told_in_several_ways_is_the_same(void **state)
{
    (void)state;
    test_rng rng = test_seed(45);
    for (int l = 0; l < 10; ++l) {
        double V[6], A[36], more[36];
        const mbsr_inertia rigid = random_rigid(&rng);
        own_matrix(&rigid, A, &rng);
        random_matrix(more, 3, &rng);
        test_fill(&rng, 6, V);
        body b[6];
        make_body(b, rigid, NULL, &rng);
        make_body(b + 1, mbsr_inertia_matrix(6, A), NULL, &rng);
        make_body(b + 2, mbsr_inertia_zero(), A, &rng);
        make_body(b + 3, mbsr_inertia_matrix(6, more), NULL, &rng);
        make_body(b + 4, rigid, more, &rng);
        make_body(b + 5, mbsr_inertia_function(by_function, b), more, &rng);
        for (int k = 0; k < 6; ++k) {
            memcpy(b[k].q, b[0].q, sizeof b[k].q);
            evaluate_body(b + k, V);
        }
        for (int i = 0; i < 36; ++i) {
            const double m[2] = {b[0].M[i], b[0].h[i % 6]}, sum[2] = {b[3].M[i], b[3].h[i % 6]};
            for (int k = 1; k < 6; ++k) {
                if (k == 3) continue;
                assert_close(b[k].M[i], m[0] + (k > 3 ? sum[0] : 0.0), 1e-14);
                assert_close(b[k].h[i % 6], m[1] + (k > 3 ? sum[1] : 0.0), 2e-14);
            }
        }
        for (int k = 0; k < 6; ++k) drop_body(b + k);
    }
}

/* M' against differences along the rotation with omega; h does no work but for M'. */
static void rates_of_mass_agree_with_differences(void **state)
{
    (void)state;
    test_rng rng = test_seed(46);
    double A[36];
    random_matrix(A, 4, &rng);
    for (int kind = 0; kind < 4; ++kind) {
        const mbsr_inertia list[] = {random_rigid(&rng), mbsr_inertia_matrix(6, A),
                                     mbsr_inertia_particle(1.5), mbsr_inertia_zero()};
        body b;
        double V[6], M[36], rate[36], expected[36] = {0.0}, q[7], power = 0.0;
        make_body(&b, list[kind], kind == 1 ? NULL : A, &rng);
        test_fill(&rng, 6, V);
        evaluate_body(&b, V);
        memcpy(M, b.M, sizeof M);
        double h[6], p[MBSR_POSE_SIZE] = {0.0};
        memcpy(h, b.h, sizeof h);
        memcpy(p, b.R, sizeof b.R);
        mbsri_inertia_mass_rate(b.model->body + 1, p, V, M, rate);
        memcpy(q, b.q, sizeof q);
        static const double weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12},
                            at[4] = {-2, -1, 1, 2};
        const double step = 1e-3;
        for (int l = 0; l < 4; ++l) {
            /* exp of (0, omega s / 2), times q */
            const double speed = sqrt(V[0] * V[0] + V[1] * V[1] + V[2] * V[2]),
                         angle = 0.5 * at[l] * step * speed;
            const double turn[4] = {cos(angle), sin(angle) * V[0] / speed,
                                    sin(angle) * V[1] / speed, sin(angle) * V[2] / speed};
            quaternion_product(turn, q, b.q);
            evaluate_body(&b, V);
            for (int i = 0; i < 36; ++i) expected[i] += weight[l] / step * b.M[i];
        }
        for (int i = 0; i < 36; ++i) {
            assert_close(rate[i], expected[i], 1e-11);
            power += 0.5 * V[i / 6] * expected[i] * V[i % 6];
        }
        for (int i = 0; i < 6; ++i) power -= V[i] * h[i];
        assert_close(power, 0.0, 1e-11);
        drop_body(&b);
    }
}

/* ---- refusals ------------------------------------------------------------------------------- */

static int add_with(mbsr_inertia inertia, mbsr_joint joint, mbsr_error *error)
{
    mbsr_model *m;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    mbsr_body_def def = mbsr_default_body_def();
    def.name = "hull";
    def.joint = joint;
    def.inertia = inertia;
    const int status = mbsr_model_add_body(m, &def, NULL);
    *error = *mbsr_model_error(m);
    mbsr_model_destroy(m);
    return status;
}

static void assert_inertia_refused(mbsr_inertia inertia, int status, const char *words)
{
    char all[200];
    mbsr_error error;
    snprintf(all, sizeof all, "body 0 'hull'|%s", words);
    assert_refused(add_with(inertia, mbsr_joint_free(NULL, NULL), &error), &error, status, 0,
                   MBSR_NONE, all);
}

static mbsr_inertia tensor_of(double xx, double yy, double zz, double xy)
{
    const double com[3] = {0, 0, 0}, tensor[6] = {xx, yy, zz, xy, 0, 0};
    return mbsr_inertia_rigid(1.0, com, tensor);
}

static void what_no_distribution_of_mass_has_is_refused(void **state)
{
    (void)state;
    const double com[3] = {1, 2, 3}, none[6] = {0}, bad_com[3] = {0, NAN, 0},
                 bad[6] = {1, 1, 1, 0, 0, NAN};
    mbsr_error error;
    const mbsr_joint free = mbsr_joint_free(NULL, NULL);
    assert_inertia_refused(mbsr_inertia_rigid(-2.5, com, none), MBSR_ERR_VALUE,
                           "inertia.mass is -2.5");
    assert_inertia_refused(mbsr_inertia_rigid(INFINITY, com, none), MBSR_ERR_VALUE,
                           "inertia.mass is inf");
    assert_inertia_refused(mbsr_inertia_particle(-1.0), MBSR_ERR_VALUE, "inertia.mass is -1");
    assert_inertia_refused(mbsr_inertia_rigid(1.0, bad_com, none), MBSR_ERR_VALUE,
                           "inertia.com[1] is nan");
    assert_inertia_refused(mbsr_inertia_rigid(1.0, com, bad), MBSR_ERR_VALUE,
                           "inertia.tensor[5] is nan");
    /* one moment larger than the sum of the others, or negative; on the diagonal and off it */
    assert_inertia_refused(tensor_of(1.0, 2.0, 3.1, 0.0), MBSR_ERR_VALUE,
                           "inertia.tensor|principal moments|1, 2, 3.1");
    assert_inertia_refused(tensor_of(3.1, 1.0, 2.0, 0.0), MBSR_ERR_VALUE, "1, 2, 3.1");
    assert_inertia_refused(tensor_of(2.0, 2.0, 2.0, 1.1), MBSR_ERR_VALUE, "0.9, 2, 3.1");
    assert_inertia_refused(tensor_of(1.0, 1.0, -0.1, 0.0), MBSR_ERR_VALUE, "-0.1, 1, 1");
    assert_inertia_refused(tensor_of(0.0, 0.0, 1.0, 0.0), MBSR_ERR_VALUE, "0, 0, 1");
    /* the edge is allowed: flat bodies, rods, points, and rounded data */
    assert_ok(add_with(tensor_of(1.0, 2.0, 3.0, 0.0), free, &error), &error);
    assert_ok(add_with(tensor_of(1.0, 2.0, 3.000002, 0.0), free, &error), &error);
    assert_ok(add_with(tensor_of(2.0, 0.0, 2.0, 0.0), free, &error), &error);
    assert_ok(add_with(tensor_of(2.0, -1e-7, 2.0, 0.0), free, &error), &error);
    assert_ok(add_with(tensor_of(0.0, 0.0, 0.0, 0.0), free, &error), &error);
    /* the tensor about a point where none can be that small */
    const mbsr_frame frame = mbsr_frame_identity();
    const double small[6] = {1, 1, 1, 0, 0, 0};
    assert_inertia_refused(mbsr_inertia_rigid_about(1.0, com, &frame, small), MBSR_ERR_VALUE,
                           "about the centre");
}

/* Far from its origin the moments about the centre of mass are lost to rounding, not wrong. */
static void rounding_of_far_reference_points_is_not_refused(void **state)
{
    (void)state;
    test_rng rng = test_seed(47);
    const mbsr_joint free = mbsr_joint_free(NULL, NULL);
    for (int l = 0; l < 100; ++l) {
        static cloud c;
        double mass, com[3], tensor[6], at[3], x[3];
        test_fill(&rng, 3, x);
        for (int k = 0; k < 3; ++k) at[k] = 1e3 * x[k];
        c.count = 0;
        add_particle(&c, 2.0, at[0], at[1], at[2]);
        const mbsr_frame identity = mbsr_frame_identity();
        const double origin[3] = {0, 0, 0};
        moments(&c, origin, &mass, com, tensor);
        const mbsr_inertia inertia = mbsr_inertia_rigid_about(mass, at, &identity, tensor);
        mbsr_error error;
        assert_ok(add_with(inertia, free, &error), &error);
    }
}

static void what_constructors_cannot_make_is_refused(void **state)
{
    (void)state;
    const double edges[3] = {1, -1, 1}, A[36] = {0}, com[3] = {0, 0, 0}, unit[6] = {1, 1, 1};
    const double good[3] = {1, 1, 1}, unknown[3] = {1, NAN, 1};
    mbsr_frame skew = mbsr_frame_identity();
    skew.R[3] = 0.1;
    const mbsr_inertia ball = mbsr_inertia_sphere(1.0, 1.0),
                       given = mbsr_default_body_def().inertia;
    const mbsr_inertia list[] = {mbsr_inertia_box(1.0, edges),
                                 mbsr_inertia_sphere(1.0, -1.0),
                                 mbsr_inertia_cylinder(1.0, -1.0, 1.0),
                                 mbsr_inertia_cylinder(1.0, 1.0, -1.0),
                                 mbsr_inertia_capsule(1.0, -1.0, 1.0),
                                 mbsr_inertia_capsule(1.0, 1.0, -1.0),
                                 mbsr_inertia_rigid_about(1.0, com, &skew, unit),
                                 mbsr_inertia_in_frame(&skew, ball),
                                 mbsr_inertia_in_frame(&skew, mbsr_inertia_matrix(6, A)),
                                 mbsr_inertia_sum(ball, mbsr_inertia_matrix(6, A)),
                                 mbsr_inertia_sum(mbsr_inertia_planar(1.0, com, 1.0), ball),
                                 mbsr_inertia_sum(ball, given),
                                 mbsr_inertia_in_frame(&skew, given)};
    for (size_t k = 0; k < sizeof list / sizeof list[0]; ++k) {
        assert_int_equal(list[k].kind, MBSR_INERTIA_INVALID);
        assert_inertia_refused(list[k], MBSR_ERR_VALUE, "negative dimension|orthonormal|sum");
    }
    const mbsr_inertia spread = mbsr_inertia_sum(ball, mbsr_inertia_sum(ball, list[0]));
    assert_int_equal(spread.kind, MBSR_INERTIA_INVALID);
    assert_inertia_refused(mbsr_inertia_box(1.0, unknown), MBSR_ERR_VALUE, "inertia.mass is nan");
    assert_inertia_refused(mbsr_inertia_box(-1.0, good), MBSR_ERR_VALUE, "inertia.mass is -1");
    assert_inertia_refused(mbsr_inertia_sphere(1.0, NAN), MBSR_ERR_VALUE, "inertia.mass is nan");
}

static void inertias_of_other_spaces_are_refused(void **state)
{
    (void)state;
    const mbsr_planar_frame o = {0, 0, 0};
    const double A[36] = {1}, com[3] = {0, 0, 0};
    mbsr_error error;
    assert_refused(add_with(mbsr_inertia_sphere(1.0, 1.0), mbsr_joint_planar_free(o, o), &error),
                   &error, MBSR_ERR_SPACE, 0, MBSR_NONE,
                   "body 0 'hull'|rigid inertia needs a SPATIAL body");
    assert_inertia_refused(mbsr_inertia_planar(1.0, com, 1.0), MBSR_ERR_SPACE,
                           "planar inertia needs a PLANAR body");
    assert_inertia_refused(mbsr_inertia_matrix(3, A), MBSR_ERR_VALUE, "3 x 3|d = 6");
    assert_inertia_refused(mbsr_inertia_matrix(6, NULL), MBSR_ERR_NULL, "inertia.matrix is NULL");
    double skew[36] = {0};
    skew[1] = 1.0;
    assert_inertia_refused(mbsr_inertia_matrix(6, skew), MBSR_ERR_VALUE, "not symmetric");
}

static void not_given_is_told_from_zero(void **state)
{
    (void)state;
    test_rng rng = test_seed(48);
    const mbsr_inertia not_given = mbsr_default_body_def().inertia, zero = mbsr_inertia_zero();
    assert_int_equal(not_given.kind, MBSR_INERTIA_NOT_GIVEN);
    assert_int_not_equal(zero.kind, MBSR_INERTIA_NOT_GIVEN);
    const mbsr_frame frame = test_frame(&rng, 1.0);
    const mbsr_inertia moved = mbsr_inertia_in_frame(&frame, zero),
                       both = mbsr_inertia_sum(zero, zero);
    const mbsr_inertia *const list[] = {&not_given, &zero, &moved, &both};
    const double V[6] = {1, 2, 3, 4, 5, 6};
    for (int k = 0; k < 4; ++k) {
        body b;
        make_body(&b, *list[k], NULL, &rng);
        evaluate_body(&b, V);
        for (int i = 0; i < 36; ++i) assert_close(b.M[i], 0.0, 0.0);
        for (int i = 0; i < 6; ++i) assert_close(b.h[i], 0.0, 0.0);
        drop_body(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solids_agree_with_integrals),
        cmocka_unit_test(rods_and_points_agree_with_particles),
        cmocka_unit_test(sums_moves_and_reference_points_agree_with_particles),
        cmocka_unit_test(rigid_bodies_move_as_their_particles),
        cmocka_unit_test(matrices_follow_lagranges_equations),
        cmocka_unit_test(the_same_inertia_told_in_several_ways_is_the_same),
        cmocka_unit_test(rates_of_mass_agree_with_differences),
        cmocka_unit_test(what_no_distribution_of_mass_has_is_refused),
        cmocka_unit_test(rounding_of_far_reference_points_is_not_refused),
        cmocka_unit_test(what_constructors_cannot_make_is_refused),
        cmocka_unit_test(inertias_of_other_spaces_are_refused),
        cmocka_unit_test(not_given_is_told_from_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
