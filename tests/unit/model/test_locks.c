/* Locked coordinates and welded bodies: what is locked moves as what is held by motors, and costs
 * nothing.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The oracle is the same tree without locks, whose locked coordinates stand at their values with u
 * = u' = 0: joint forces of the coordinates left, poses, accelerations and reactions of all bodies
 * are the same. */
#include "expect.h"
#include "tree.h"
#include "units.h"

#include <mbsrank/verify.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

enum { ARM = 4, FINGERS = 3, LINKS = 3, BODIES = ARM + FINGERS * LINKS, MOST = 64 };

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
    int bodies, locked; /* coordinates */
    double value[MOST]; /* of all coordinates of the tree without locks; NaN: free */
    double q[MOST], u[MOST], x[MOST];
} scene;

static mbsr_model *empty(void)
{
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    return m;
}

static int add(mbsr_model *m, const char *name, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id = -1;
    body.name = name;
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(m, &body, &id), mbsr_model_error(m));
    return id;
}

static void add_force(mbsr_model *m, mbsr_force_def force)
{
    assert_ok(mbsr_model_add_force(m, &force, NULL), mbsr_model_error(m));
}

static mbsr_data *finish(mbsr_model *m)
{
    mbsr_data *d = NULL;
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    return d;
}

static mbsr_inertia link_inertia(const units *by, int k)
{
    const double L = by->length, M = by->mass, com[3] = {0.01 * L, -0.02 * L, (0.1 + 0.01 * k) * L},
                 I = 0.01 * M * L * L;
    return mbsr_inertia_rigid((1.0 + 0.1 * k) * M, com,
                              (const double[6]){2.0 * I, 2.2 * I, 1.5 * I, 0.1 * I, 0.0, 0.0});
}

static int no_force(void *user, double t, int n, double *tau)
{
    (void)user, (void)t;
    for (int k = 0; k < n; ++k) tau[k] = 0.0;
    return MBSR_OK;
}

/* By what coordinates are held: locks, nothing, springs. */
typedef enum holding { LOCKS, NOTHING, SPRINGS } holding;

static double spring_stiffness(const units *by, bool slides)
{
    const double force = by->mass * by->length / (by->time * by->time);
    return 1e10 * force * (slides ? 1.0 / by->length : by->length);
}

/* An arm with locks at its second joint and at one axis of its third; fingers of which all is
 * locked but the last joint of each but the first. `massless`: links that are locked have no
 * inertia; `acted`: a force of zero on every body. */
static void make(scene *s, const units *by, holding how, bool massless, bool acted)
{
    static const double axes[3][3] = {{0.2, 1.0, 0.1}, {1.0, 0.0, 0.3}, {0.1, 0.4, 1.0}};
    const double L = by->length, G = 9.81 * by->length / (by->time * by->time);
    mbsr_model *m = empty();
    *s = (scene){.model = m};
    int last = MBSR_GROUND;
    for (int k = 0; k < ARM; ++k) {
        const mbsr_frame at = mbsr_frame_at(0.1 * L, 0.02 * k * L, 0.3 * L);
        const mbsr_joint joint = k == 2 ? mbsr_joint_universal(&at, NULL, axes[0], axes[1])
                                        : mbsr_joint_revolute(&at, NULL, axes[k % 3]);
        last = add(m, "arm", last, joint, link_inertia(by, k));
    }
    const int palm = last;
    for (int f = 0; f < FINGERS; ++f) {
        last = palm;
        for (int k = 0; k < LINKS; ++k) {
            const mbsr_frame at =
                mbsr_frame_rotated((const double[3]){0.05 * f * L, 0.0, 0.1 * L}, axes[f], 0.3 * k);
            const mbsr_joint joint = k == 1 ? mbsr_joint_cylindrical(&at, NULL, axes[k])
                                            : mbsr_joint_revolute(&at, NULL, axes[k]);
            last = add(m, "finger", last, joint,
                       massless && k < 2 ? mbsr_inertia_zero() : link_inertia(by, f));
        }
    }
    for (int k = 0; k < MOST; ++k) s->value[k] = NAN;
    for (int id = 0, at = 0; id < BODIES; ++id) {
        const int n = id == 2 || (id >= ARM && (id - ARM) % LINKS == 1) ? 2 : 1,
                  moves =
                      id >= ARM ? id >= ARM + LINKS && (id - ARM) % LINKS == LINKS - 1 : id != 1;
        for (int k = 0; k < n; ++k, ++at) {
            if (moves && !(id == 2 && k == 1)) continue;
            const bool slides = id >= ARM && k == 1;
            s->value[at] = (0.2 + 0.1 * id) * (slides ? 0.1 * L : 1.0);
            s->locked += 1;
            if (how == LOCKS)
                assert_ok(mbsr_model_lock(m, id, k, s->value[at]), mbsr_model_error(m));
            if (how == SPRINGS)
                add_force(m, mbsr_force_joint_spring(id, k, spring_stiffness(by, slides), 0.0,
                                                     s->value[at]));
        }
        if (acted) add_force(m, mbsr_force_applied(id, no_force, NULL));
    }
    add_force(m, mbsr_force_gravity(0.1 * G, -0.2 * G, -G));
    s->data = finish(m);
    s->bodies = BODIES;
}

static void release(scene *s)
{
    mbsr_data_destroy(s->data);
    mbsr_model_destroy(s->model);
}

/* The state of the coordinates left, `a`, put into that of all, `b`. */
static void take_state(const scene *a, scene *b)
{
    const int n = mbsr_model_nu(b->model);
    assert_int_equal(n, mbsr_model_nu(a->model) + b->locked);
    for (int k = 0, left = 0; k < n; ++k) {
        const bool free = isnan(b->value[k]);
        b->q[k] = free ? a->q[left] : b->value[k];
        b->u[k] = free ? a->u[left] : 0.0;
        b->x[k] = free ? a->x[left] : 0.0;
        left += free;
    }
}

static void choose_state(scene *s, const units *by, uint64_t seed)
{
    test_rng rng = test_seed(seed);
    const int n = mbsr_model_nu(s->model);
    test_fill(&rng, n, s->q);
    test_fill(&rng, n, s->u);
    test_fill(&rng, n, s->x);
    for (int k = 0; k < n; ++k) {
        s->u[k] /= by->time;
        s->x[k] /= by->time * by->time;
    }
}

static void assert_same(int n, const double *x, const double *y, double size, double tolerance)
{
    for (int k = 0; k < n; ++k) assert_close(x[k] / size, y[k] / size, tolerance);
}

/* Everything that belongs to u' of both. */
static void assert_same_bodies(scene *a, scene *b, const units *by)
{
    const double force = by->mass * by->length / (by->time * by->time);
    for (int id = 0; id < a->bodies; ++id) {
        double x[12], y[12];
        assert_ok(mbsr_body_pose(a->model, a->data, id, x), mbsr_data_error(a->data));
        assert_ok(mbsr_body_pose(b->model, b->data, id, y), mbsr_data_error(b->data));
        assert_same(9, x, y, 1.0, 1e-13);
        assert_same(3, x + 9, y + 9, by->length, 1e-13);
        mbsr_body_twist(a->model, a->data, id, x);
        mbsr_body_twist(b->model, b->data, id, y);
        assert_same(3, x, y, 1.0 / by->time, 1e-12);
        assert_same(3, x + 3, y + 3, by->length / by->time, 1e-12);
        mbsr_body_acceleration(a->model, a->data, id, x);
        mbsr_body_acceleration(b->model, b->data, id, y);
        assert_same(3, x, y, 1.0 / (by->time * by->time), 1e-11);
        assert_same(3, x + 3, y + 3, by->length / (by->time * by->time), 1e-11);
        assert_ok(mbsr_joint_reaction(a->model, a->data, id, x), mbsr_data_error(a->data));
        assert_ok(mbsr_joint_reaction(b->model, b->data, id, y), mbsr_data_error(b->data));
        assert_same(3, x, y, force * by->length, 1e-10);
        assert_same(3, x + 3, y + 3, force, 1e-10);
    }
}

static void assert_same_totals(scene *a, scene *b, const units *by)
{
    double mass[2], centre[2][3], momentum[2][6], T[2], V[2];
    const double speed = by->length / by->time, energy = by->mass * speed * speed;
    scene *const s[2] = {a, b};
    for (int k = 0; k < 2; ++k) {
        assert_ok(
            mbsr_tree_momentum(s[k]->model, s[k]->data, NULL, mass + k, centre[k], momentum[k]),
            mbsr_data_error(s[k]->data));
        assert_ok(mbsr_energy(s[k]->model, s[k]->data, T + k, V + k), mbsr_data_error(s[k]->data));
    }
    assert_same(1, mass, mass + 1, by->mass, 1e-12);
    assert_same(3, centre[0], centre[1], by->length, 1e-12);
    assert_same(3, momentum[0], momentum[1], by->mass * speed * by->length, 1e-11);
    assert_same(3, momentum[0] + 3, momentum[1] + 3, by->mass * speed, 1e-11);
    assert_same(1, T, T + 1, energy, 1e-11);
    assert_same(1, V, V + 1, energy, 1e-11);
}

/* Whether coordinate l of a tree without locks is a length. */
static bool coordinate_slides(const mbsr_model *m, int l)
{
    mbsr_coordinate_kind kind[2];
    int id = 0, at, n;
    do {
        assert_int_equal(mbsr_body_coordinates(m, id, NULL, NULL, &at, &n), MBSR_OK);
        ++id;
    } while (l >= at + n);
    assert_int_equal(mbsr_body_coordinate_kinds(m, id - 1, NULL, kind), MBSR_OK);
    return kind[l - at] == MBSR_COORDINATE_TRANSLATION;
}

static void what_is_locked_moves_as_what_is_held(void **state)
{
    (void)state;
    for (int k = 0; k < 4 * 4; ++k) {
        const units *by = systems + k / 4;
        const bool massless = k % 2, acted = k % 4 > 1;
        scene a, b;
        double tau[MOST], all[MOST];
        make(&a, by, LOCKS, massless, acted);
        make(&b, by, NOTHING, massless, false);
        choose_state(&a, by, 7 + (uint64_t)k);
        take_state(&a, &b);
        assert_int_equal(mbsr_body_locks(a.model, 2), 1);
        assert_int_equal(mbsr_body_locks(a.model, ARM + 1), 2);
        assert_ok(mbsr_inverse_dynamics(a.model, a.data, 0.0, a.q, a.u, a.x, NULL, tau),
                  mbsr_data_error(a.data));
        assert_ok(mbsr_inverse_dynamics(b.model, b.data, 0.0, b.q, b.u, b.x, NULL, all),
                  mbsr_data_error(b.data));
        const double moment = by->mass * by->length * by->length / (by->time * by->time);
        for (int l = 0, left = 0; l < mbsr_model_nu(b.model); ++l) {
            if (isnan(b.value[l])) assert_same(1, all + l, tau + left++, moment, 1e-11);
        }
        assert_same_bodies(&a, &b, by);
        assert_same_totals(&a, &b, by);
        /* and back, by the sweeps */
        assert_ok(mbsr_forward_dynamics(a.model, a.data, 0.0, a.q, a.u, tau, all),
                  mbsr_data_error(a.data));
        assert_same(mbsr_model_nu(a.model), all, a.x, 1.0 / (by->time * by->time), 1e-8);
        release(&a);
        release(&b);
    }
}

/* Springs of next to no compliance in the place of locks, bent by what these have to hold: nothing
 * moves there, and reactions are those of the locks. */
static void very_stiff_springs_react_as_locks(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        const units *by = systems + k;
        const double force = by->mass * by->length / (by->time * by->time);
        scene a, b, c;
        double tau[MOST], all[MOST], udot[MOST], x[6], y[6];
        make(&a, by, LOCKS, false, false);
        make(&b, by, NOTHING, false, false);
        make(&c, by, SPRINGS, false, false);
        choose_state(&a, by, 31 + (uint64_t)k);
        take_state(&a, &b);
        assert_ok(mbsr_inverse_dynamics(a.model, a.data, 0.0, a.q, a.u, a.x, NULL, tau),
                  mbsr_data_error(a.data));
        assert_ok(mbsr_inverse_dynamics(b.model, b.data, 0.0, b.q, b.u, b.x, NULL, all),
                  mbsr_data_error(b.data));
        for (int l = 0; l < mbsr_model_nu(b.model); ++l) {
            if (isnan(b.value[l])) continue;
            b.q[l] -= all[l] / spring_stiffness(by, coordinate_slides(b.model, l));
            all[l] = 0.0;
        }
        assert_ok(mbsr_forward_dynamics(c.model, c.data, 0.0, b.q, b.u, all, udot),
                  mbsr_data_error(c.data));
        assert_ok(mbsr_stage_accelerations(c.model, c.data, udot), mbsr_data_error(c.data));
        for (int id = 0; id < a.bodies; ++id) {
            assert_ok(mbsr_joint_reaction(a.model, a.data, id, x), mbsr_data_error(a.data));
            assert_ok(mbsr_joint_reaction(c.model, c.data, id, y), mbsr_data_error(c.data));
            assert_same(3, x, y, force * by->length, 1e-4);
            assert_same(3, x + 3, y + 3, force, 1e-4);
        }
        release(&a);
        release(&b);
        release(&c);
    }
}

/* A consistent start of the momentum form does not depend on who is welded. */
static void consistent_starts_do_not_depend_on_who_is_welded(void **state)
{
    (void)state;
    scene a, b;
    double y[2][3 * MOST], yp[2][3 * MOST];
    make(&a, systems, LOCKS, true, false);
    make(&b, systems, LOCKS, true, true);
    choose_state(&a, systems, 17);
    scene *const s[2] = {&a, &b};
    for (int k = 0; k < 2; ++k) {
        const mbsr_error *e = mbsr_data_error(s[k]->data);
        assert_ok(mbsr_dae_pack(s[k]->model, s[k]->data, MBSR_DAE_MOMENTUM, 0.0, a.q, a.u, y[k]),
                  e);
        assert_ok(mbsr_dae_consistent(s[k]->model, s[k]->data, MBSR_DAE_MOMENTUM, 0.0, y[k], yp[k],
                                      NULL, NULL),
                  e);
    }
    assert_same(3 * mbsr_model_nu(a.model), y[0], y[1], 1.0, 1e-10);
    assert_same(3 * mbsr_model_nu(a.model), yp[0], yp[1], 1.0, 1e-9);
    release(&a);
    release(&b);
}

/* Columns of the Jacobian against twists. */
static void jacobians_of_welded_bodies_give_their_twists(void **state)
{
    (void)state;
    scene s;
    make(&s, systems, LOCKS, false, false);
    choose_state(&s, systems, 3);
    const int n = mbsr_model_nu(s.model);
    double J[6 * MOST], V[6];
    assert_ok(mbsr_stage_positions(s.model, s.data, 0.0, s.q), mbsr_data_error(s.data));
    assert_ok(mbsr_stage_velocities(s.model, s.data, s.u), mbsr_data_error(s.data));
    for (int id = 0; id < BODIES; ++id) {
        assert_ok(mbsr_body_jacobian(s.model, s.data, id, J), mbsr_data_error(s.data));
        assert_ok(mbsr_body_twist(s.model, s.data, id, V), mbsr_data_error(s.data));
        for (int l = 0; l < 6; ++l) {
            double sum = 0.0;
            for (int k = 0; k < n; ++k) sum += J[6 * k + l] * s.u[k];
            assert_close(sum, V[l], 1e-12);
        }
    }
    release(&s);
}

/* The same welds with a force of zero on each body stay bodies of their own: all evaluations agree.
 */
static void evaluations_do_not_depend_on_who_is_welded(void **state)
{
    (void)state;
    enum { STATES = 5 };
    for (int massless = 0; massless < 2; ++massless) {
        scene a, b;
        make(&a, systems, LOCKS, massless, false);
        make(&b, systems, LOCKS, massless, true);
        choose_state(&a, systems, 11);
        const int n = mbsr_model_nu(a.model), size = 3 * n;
        double y[2][3 * MOST], yp[3 * MOST], F[2][3 * MOST], out[2][MOST];
        double q[STATES * MOST], many[2][STATES * MOST];
        test_rng rng = test_seed(5);
        test_fill(&rng, size, yp);
        test_fill(&rng, STATES * n, q);
        scene *const s[2] = {&a, &b};
        for (int k = 0; k < 2; ++k) {
            mbsr_newton *w = NULL;
            mbsr_batch *batch = NULL;
            const mbsr_error *e = mbsr_data_error(s[k]->data);
            assert_ok(mbsr_forward_dynamics(s[k]->model, s[k]->data, 0.0, a.q, a.u, a.x, out[k]),
                      e);
            assert_ok(
                mbsr_dae_pack(s[k]->model, s[k]->data, MBSR_DAE_MOMENTUM, 0.0, a.q, a.u, y[k]), e);
            assert_ok(
                mbsr_dae_residual(s[k]->model, s[k]->data, MBSR_DAE_MOMENTUM, 0.0, y[k], yp, F[k]),
                e);
            assert_ok(mbsr_newton_create(s[k]->model, MBSR_DAE_MOMENTUM, NULL, &w, NULL), NULL);
            assert_ok(mbsr_newton_factor(w, s[k]->data, 0.0, y[k], yp, 20.0), e);
            assert_ok(mbsr_newton_solve(w, yp, y[k]), e);
            mbsr_newton_destroy(w);
            assert_ok(mbsr_batch_create(s[k]->model, &batch, NULL), NULL);
            assert_ok(mbsr_batch_forward_dynamics(s[k]->model, batch, 0.0, STATES, q, q, q, many[k],
                                                  NULL),
                      mbsr_batch_error(batch));
            mbsr_batch_destroy(batch);
        }
        assert_same(n, out[0], out[1], 1.0, 1e-9);
        assert_same(size, F[0], F[1], 1.0, 1e-9);
        assert_same(size, y[0], y[1], 1.0, 1e-9);
        assert_same(STATES * n, many[0], many[1], 1.0, 1e-8);
        release(&a);
        release(&b);
    }
}

/* ---- joints of several axes ---- */

static int two_axes(void *user, double t, double *s, double *rate, double *second)
{
    (void)user;
    s[0] = 0.3 * sin(t);
    rate[0] = 0.3 * cos(t);
    second[0] = -0.3 * sin(t);
    return MBSR_OK;
}

/* Every subset of the coordinates of a joint in a chain of three bodies. */
static void assert_any_subset(mbsr_joint joint, mbsr_joint outer, bool plane)
{
    const units *by = systems;
    const double com[2] = {0.3, 0.1};
    const mbsr_inertia inertia = plane ? mbsr_inertia_planar(1.2, com, 0.4) : link_inertia(by, 1);
    for (int mask = 1; mask < 1 << joint.n; ++mask) {
        scene s[2];
        for (int k = 0; k < 2; ++k) {
            mbsr_model *m = empty();
            s[k] = (scene){.model = m, .bodies = 3};
            add(m, "first", MBSR_GROUND, outer, inertia);
            add(m, "middle", 0, joint, inertia);
            add(m, "last", 1, outer, inertia);
            for (int c = 0; c < MOST; ++c) s[k].value[c] = NAN;
            for (int c = 0; c < joint.n; ++c) {
                if (!(mask & 1 << c)) continue;
                s[k].value[outer.n + c] = 0.3 + 0.2 * c;
                s[k].locked += 1;
                if (k == 0) assert_ok(mbsr_model_lock(m, 1, c, 0.3 + 0.2 * c), mbsr_model_error(m));
            }
            add_force(m, mbsr_force_gravity(0.0, -9.81, plane ? 0.0 : 1.0));
            s[k].data = finish(m);
        }
        choose_state(s, by, (uint64_t)mask);
        take_state(s, s + 1);
        double tau[MOST], all[MOST], x[12], y[12];
        assert_ok(
            mbsr_inverse_dynamics(s[0].model, s[0].data, 0.7, s[0].q, s[0].u, s[0].x, NULL, tau),
            mbsr_data_error(s[0].data));
        assert_ok(
            mbsr_inverse_dynamics(s[1].model, s[1].data, 0.7, s[1].q, s[1].u, s[1].x, NULL, all),
            mbsr_data_error(s[1].data));
        for (int l = 0, left = 0; l < mbsr_model_nu(s[1].model); ++l) {
            if (isnan(s[1].value[l])) assert_close(all[l], tau[left++], 1e-11);
        }
        for (int id = 0; id < 3; ++id) {
            const int d = plane ? 3 : 6, np = plane ? 3 : 12;
            mbsr_body_pose(s[0].model, s[0].data, id, x);
            mbsr_body_pose(s[1].model, s[1].data, id, y);
            assert_same(np, x, y, 1.0, 1e-13);
            mbsr_joint_reaction(s[0].model, s[0].data, id, x);
            mbsr_joint_reaction(s[1].model, s[1].data, id, y);
            assert_same(d, x, y, 1.0, 1e-11);
        }
        assert_ok(mbsr_forward_dynamics(s[0].model, s[0].data, 0.7, s[0].q, s[0].u, tau, all),
                  mbsr_data_error(s[0].data));
        assert_same(mbsr_model_nu(s[0].model), all, s[0].x, 1.0, 1e-8);
        release(s);
        release(s + 1);
    }
}

static void any_coordinates_of_a_joint_can_be_locked(void **state)
{
    (void)state;
    static const double x[3] = {1.0, 0.2, 0.1}, y[3] = {-0.2, 1.0, 0.3}, z[3] = {0.1, 0.2, 1.0};
    const mbsr_frame A = mbsr_frame_rotated((const double[3]){0.1, 0.2, 0.3}, x, 0.4),
                     B = mbsr_frame_rotated((const double[3]){-0.1, 0.1, 0.2}, y, 0.5);
    const mbsr_axis every[6] = {{MBSR_AXIS_ROTATION, {0.1, 0.2, 1.0}, 0.0, 0},
                                {MBSR_AXIS_TRANSLATION, {1.0, 0.2, 0.1}, 0.0, 0},
                                {MBSR_AXIS_ROTATION, {0.3, 1.0, 0.1}, 0.0, 0},
                                {MBSR_AXIS_SCREW, {0.1, 1.0, 0.4}, 0.2, 0},
                                {MBSR_AXIS_TRANSLATION, {0.0, 0.2, 1.0}, 0.0, 0},
                                {MBSR_AXIS_ROTATION, {1.0, 0.1, 0.0}, 0.0, 0}};
    const mbsr_axis driven[3] = {{MBSR_AXIS_ROTATION, {0.1, 0.2, 1.0}, 0.0, 0},
                                 {MBSR_AXIS_TRANSLATION, {1.0, 0.2, 0.1}, 0.0, 1},
                                 {MBSR_AXIS_ROTATION, {0.3, 1.0, 0.1}, 0.0, 0}};
    const mbsr_joint outer = mbsr_joint_revolute(&A, &B, z);
    const mbsr_joint joint[] = {mbsr_joint_revolute(&A, &B, y),
                                mbsr_joint_prismatic(&A, &B, x),
                                mbsr_joint_cylindrical(&A, &B, z),
                                mbsr_joint_universal(&A, &B, x, y),
                                mbsr_joint_translational(&A, &B),
                                mbsr_joint_compound(&A, &B, 6, every, NULL, NULL),
                                mbsr_joint_compound(&A, &B, 3, driven, two_axes, NULL)};
    for (size_t k = 0; k < sizeof joint / sizeof joint[0]; ++k)
        assert_any_subset(joint[k], outer, false);
    const mbsr_planar_frame a = {0.3, 0.1, 0.4}, b = {-0.2, 0.2, 0.3};
    const mbsr_joint pin = mbsr_joint_planar_revolute(a, b);
    assert_any_subset(pin, pin, true);
    assert_any_subset(mbsr_joint_planar_pin_slot(a, b), pin, true);
    assert_any_subset(mbsr_joint_planar_free(a, b), pin, true);
    assert_any_subset(mbsr_joint_planar(a, b, MBSR_X | MBSR_ANGLE, MBSR_Y, two_axes, NULL), pin,
                      true);
}

/* ---- elements on locked coordinates ---- */

enum { HOLD, DROP, WITHOUT };

/* Three hinges of which the last is locked at 0.5, with one element of every kind on its
 * coordinate. */
static mbsr_model *make_elements(int how)
{
    static const double z[3] = {0.0, 0.0, 1.0};
    const mbsr_frame at = mbsr_frame_at(0.3, 0.0, 0.0);
    const mbsr_servo servo = {.kp = 3.0, .kd = 1.0, .reference = 0.1};
    const mbsr_gear gear = {.ratio = 2.0, .stiffness = 7.0, .damping = 0.3, .rest = 0.1};
    mbsr_model *m = empty();
    for (int id = 0; id < 3; ++id)
        add(m, id == 2 ? "hand" : "arm", id - 1, mbsr_joint_revolute(&at, NULL, z),
            link_inertia(systems, id));
    assert_ok(mbsr_model_lock(m, 2, 0, 0.5), mbsr_model_error(m));
    add_force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
    add_force(m, mbsr_force_joint_spring(0, 0, 2.0, 0.1, 0.2));
    if (how == WITHOUT) return m;
    add_force(m, mbsr_force_joint_spring(2, 0, 4.0, 0.3, 0.1));
    add_force(m, mbsr_force_joint_stop(2, 0, -0.1, 0.2, 100.0, 1.0));
    add_force(m, mbsr_force_joint_friction(2, 0, 1.0, 0.01));
    add_force(m, mbsr_force_joint_servo(2, 0, &servo));
    add_force(m, mbsr_force_gear(1, 0, 2, 0, &gear));
    assert_ok(mbsr_model_armature(m, 2, 1, (const double[1]){0.3}), mbsr_model_error(m));
    if (how == DROP) assert_ok(mbsr_model_drop_locked(m, 2), mbsr_model_error(m));
    return m;
}

static void elements_on_locked_coordinates_hold_or_are_dropped(void **state)
{
    (void)state;
    const double q[2] = {0.3, -0.4}, u[2] = {0.7, 0.2};
    /* the gear, of which one coordinate moves */
    const double e = q[1] - 2.0 * 0.5 - 0.1, torque = -7.0 * e - 0.3 * u[1];
    const double constant = 0.5 * 4.0 * 0.16 + 0.5 * 100.0 * 0.09 + 0.5 * 7.0 * e * e;
    double udot[3][2], energy[3], tau[2] = {0.0, 0.0};
    for (int how = HOLD; how <= WITHOUT; ++how) {
        mbsr_model *m = make_elements(how);
        mbsr_data *d = finish(m);
        tau[1] = how == HOLD ? -torque : 0.0;
        assert_ok(mbsr_forward_dynamics(m, d, 0.0, q, u, tau, udot[how]), mbsr_data_error(d));
        assert_ok(mbsr_energy(m, d, NULL, energy + how), mbsr_data_error(d));
        double f[6], t[1], E = -1.0, P = -1.0;
        if (how == HOLD) {
            assert_ok(mbsr_force_load(m, d, 2, 0, f, t), mbsr_data_error(d));
            assert_ok(mbsr_force_power(m, d, 2, &E, &P), mbsr_data_error(d));
            assert_close(E, 0.5 * 4.0 * 0.16, 1e-15);
            assert_close(P, 0.0, 0.0);
            mbsr_force_errors errors;
            assert_ok(mbsr_force_verify(m, d, 6, &errors), mbsr_data_error(d));
            assert_true(errors.largest < 1e-6);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    for (int k = 0; k < 2; ++k) {
        assert_close(udot[HOLD][k], udot[WITHOUT][k], 1e-11);
        assert_close(udot[DROP][k], udot[WITHOUT][k], 1e-12);
    }
    assert_close(energy[HOLD] - energy[WITHOUT], constant, 1e-12);
    assert_close(energy[DROP] - energy[WITHOUT], 0.0, 1e-12);
}

/* Definitions and copies name what was given. */
static void definitions_are_as_given(void **state)
{
    (void)state;
    mbsr_model *m = make_elements(HOLD), *copy = NULL;
    mbsr_data *d = finish(m);
    mbsr_force_def gear, spring;
    mbsr_body_def hand;
    assert_ok(mbsr_model_copy(m, &copy, NULL), NULL);
    assert_ok(mbsr_model_finish(copy), mbsr_model_error(copy));
    const mbsr_model *const both[2] = {m, copy};
    for (int k = 0; k < 2; ++k) {
        assert_int_equal(mbsr_force_definition(both[k], 6, &gear), MBSR_OK);
        assert_int_equal(mbsr_force_definition(both[k], 2, &spring), MBSR_OK);
        assert_int_equal(mbsr_body_definition(both[k], 2, &hand), MBSR_OK);
        assert_int_equal(gear.option[0], 0);
        assert_int_equal(gear.option[1], 0);
        assert_int_equal(spring.option[0], 0);
        assert_int_equal(hand.parent, 1);
        assert_int_equal(hand.joint.n, 1);
        assert_int_equal(mbsr_body_parent(both[k], 2), 1);
        assert_int_equal(mbsr_body_locks(both[k], 2), 1);
        assert_int_equal(mbsr_model_nu(both[k]), 2);
        for (int l = 5; l < MBSR_FORCE_PARAMS; ++l) assert_close(gear.param[l], 0.0, 0.0);
    }
    mbsr_model_destroy(copy);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
}

/* ---- couplings ---- */

/* q of bodies 1, 2, 3: 1 q_1 - 2 q_2 + 0.5 q_3 = offset; those with a value locked; offset NaN:
 * not coupled. */
static mbsr_model *make_coupled(const double value[3], double offset)
{
    static const double z[3] = {0.0, 0.0, 1.0};
    const mbsr_frame at = mbsr_frame_at(0.3, 0.0, 0.1);
    const int body[3] = {1, 2, 3}, coordinate[3] = {0, 0, 0};
    const double coefficient[3] = {1.0, -2.0, 0.5};
    mbsr_model *m = empty();
    for (int id = 0; id < 5; ++id)
        add(m, "link", id - 1, mbsr_joint_revolute(&at, NULL, z), link_inertia(systems, id));
    for (int k = 0; k < 3; ++k) {
        if (!isnan(value[k]))
            assert_ok(mbsr_model_lock(m, 1 + k, 0, value[k]), mbsr_model_error(m));
    }
    mbsr_closure_def coupling = mbsr_closure_coupling(3, body, coordinate, coefficient, offset);
    coupling.name = "tendon";
    if (!isnan(offset)) assert_ok(mbsr_model_add_closure(m, &coupling, NULL), mbsr_model_error(m));
    add_force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
    return m;
}

/* The row holds, and what it exerts on the tree without locks and without the coupling moves that
 * likewise. */
static void couplings_read_locked_coordinates(void **state)
{
    (void)state;
    const double left[3] = {NAN, 0.2, NAN}, none[3] = {NAN, NAN, NAN};
    const double q[4] = {0.4, 0.1, 1.0, -0.3}, u[4] = {0.5, 0.1, -0.2, 0.3};
    const double all[5] = {q[0], q[1], 0.2, q[2], q[3]}, v[5] = {u[0], u[1], 0.0, u[2], u[3]};
    mbsr_model *a = make_coupled(left, 0.2), *b = make_coupled(none, NAN);
    mbsr_data *da = finish(a), *db = finish(b);
    double g = -1.0, udot[4], tau[5], t[3] = {0.0};
    assert_int_equal(mbsr_model_rows(a), 1);
    assert_ok(mbsr_forward_dynamics(a, da, 0.0, q, u, NULL, udot), mbsr_data_error(da));
    assert_ok(mbsr_closures_gap(a, da, &g), mbsr_data_error(da));
    assert_close(g, q[1] - 0.4 + 0.5 * q[2] - 0.2, 1e-15);
    assert_close(udot[1] + 0.5 * udot[2], 0.0, 1e-11);
    const double w[5] = {udot[0], udot[1], 0.0, udot[2], udot[3]};
    assert_ok(mbsr_inverse_dynamics(b, db, 0.0, all, v, w, NULL, tau), mbsr_data_error(db));
    for (int k = 0; k < 3; ++k)
        assert_ok(mbsr_closure_reaction(a, da, 0, k, NULL, t + k), mbsr_data_error(da));
    assert_close(tau[0], 0.0, 1e-10);
    assert_close(tau[1], t[0], 1e-10);
    assert_close(t[1], 0.0, 0.0);
    assert_close(tau[3], t[2], 1e-10);
    assert_close(t[2], 0.5 * t[0], 1e-10);
    assert_close(tau[4], 0.0, 1e-10);
    mbsr_closure_def def;
    assert_int_equal(mbsr_closure_definition(a, 0, &def), MBSR_OK);
    assert_int_equal(def.bodies, 3);
    mbsr_data_destroy(da);
    mbsr_data_destroy(db);
    mbsr_model_destroy(a);
    mbsr_model_destroy(b);
}

static void couplings_without_free_coordinates_rest_or_are_refused(void **state)
{
    (void)state;
    const double locked[3] = {0.4, 0.2, 0.4}; /* the row is 0.4 - 0.4 + 0.2 */
    const double q[2] = {0.3, 0.1};
    double udot[2], other[2];
    mbsr_model *good = make_coupled(locked, 0.2), *bad = make_coupled(locked, 0.3);
    mbsr_data *d = finish(good);
    assert_int_equal(mbsr_model_rows(good), 0);
    assert_int_equal(mbsr_model_closures(good), 1);
    assert_ok(mbsr_forward_dynamics(good, d, 0.0, q, q, NULL, udot), mbsr_data_error(d));
    mbsr_data_destroy(d);
    assert_refused(mbsr_model_finish(bad), mbsr_model_error(bad), MBSR_ERR_VALUE, -2, -2,
                   "'tendon'|coupling|locked|-0.1");
    /* the model is as it was */
    assert_ok(mbsr_model_drop_locked(bad, 3), mbsr_model_error(bad));
    d = finish(bad);
    assert_ok(mbsr_forward_dynamics(bad, d, 0.0, q, q, NULL, other), mbsr_data_error(d));
    for (int k = 0; k < 2; ++k) assert_close(udot[k], other[k], 1e-13);
    mbsr_data_destroy(d);
    mbsr_model_destroy(good);
    mbsr_model_destroy(bad);
}

/* ---- loops ---- */

/* A four-bar in the plane whose coupler is of two bodies, locked to each other, or of one; a tail
 * that is locked stands on it. */
static mbsr_model *make_fourbar(bool split)
{
    const mbsr_planar_frame origin = {0.0, 0.0, 0.0}, half = {0.5, 0.0, 0.0}, one = {1.0, 0.0, 0.0};
    const double com[2] = {0.25, 0.0}, tail[2] = {0.5, 0.1}, whole[2] = {0.5, 0.0};
    mbsr_model *m = empty();
    const int crank = add(m, "crank", MBSR_GROUND, mbsr_joint_planar_revolute(origin, origin),
                          mbsr_inertia_planar(1.0, com, 0.05)),
              rocker = add(m, "rocker", MBSR_GROUND, mbsr_joint_planar_revolute(one, origin),
                           mbsr_inertia_planar(1.0, com, 0.05));
    int end;
    if (split) {
        const int first = add(m, "first", crank, mbsr_joint_planar_revolute(half, origin),
                              mbsr_inertia_planar(1.0, com, 0.04)),
                  second = add(m, "second", first, mbsr_joint_planar_revolute(half, origin),
                               mbsr_inertia_planar(1.0, com, 0.04));
        assert_ok(mbsr_model_lock(m, second, 0, 0.0), mbsr_model_error(m));
        const int last = add(m, "tail", second, mbsr_joint_planar_revolute(half, origin),
                             mbsr_inertia_planar(0.5, tail, 0.01));
        assert_ok(mbsr_model_lock(m, last, 0, 0.0), mbsr_model_error(m));
        /* rests beside the loop that follows */
        const mbsr_closure_def mimic =
            mbsr_closure_coupling(2, (const int[2]){second, last}, (const int[2]){0, 0},
                                  (const double[2]){1.0, -1.0}, 0.0);
        assert_ok(mbsr_model_add_closure(m, &mimic, NULL), mbsr_model_error(m));
        end = first;
    } else {
        end = add(m, "coupler", crank, mbsr_joint_planar_revolute(half, origin),
                  mbsr_inertia_planar(2.0, whole, 2.0 * (0.04 + 0.0625)));
        add(m, "tail", end, mbsr_joint_planar_weld(one, origin),
            mbsr_inertia_planar(0.5, tail, 0.01));
        add_force(m, mbsr_force_applied(end + 1, no_force, NULL));
    }
    const mbsr_closure_def pin = mbsr_closure_ball(end, (const double[3]){1.0, 0.0, 0.0}, rocker,
                                                   (const double[3]){0.5, 0.0, 0.0});
    assert_ok(mbsr_model_add_closure(m, &pin, NULL), mbsr_model_error(m));
    add_force(m, mbsr_force_gravity(0.0, -9.81, 0.0));
    return m;
}

/* Weights of multipliers depend on how masses are split: F without these. Newton systems of the
 * split one by the sweeps, which leave out what is welded, and by blocks, which do not. */
static void bodies_locked_in_loops_are_one_body(void **state)
{
    (void)state;
    enum { NU = 3, ROWS = 2, SIZE = 3 * NU + 2 * ROWS };
    /* a parallelogram: crank and rocker side by side, the coupler level */
    const double q[NU] = {1.2, 1.2, -1.2}, u[NU] = {0.7, 0.7, -0.7}, tau[NU] = {1.0, -0.3, 0.2};
    double udot[2][NU], y[SIZE], yp[SIZE], F[2][SIZE], delta[2][SIZE];
    for (int k = 0; k < SIZE; ++k) yp[k] = k < 3 * NU + ROWS ? sin(1.0 + k) : 0.0;
    for (int k = 0; k < 2; ++k) {
        mbsr_model *m = make_fourbar(k == 0);
        mbsr_data *d = finish(m);
        const mbsr_error *e = mbsr_data_error(d);
        assert_int_equal(mbsr_model_nu(m), NU);
        assert_int_equal(mbsr_dae_size(m, MBSR_DAE_MOMENTUM), SIZE);
        assert_ok(mbsr_forward_dynamics(m, d, 0.0, q, u, tau, udot[k]), e);
        assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), e);
        assert_ok(mbsr_dae_residual(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, F[k]), e);
        for (int blocks = 0; blocks < 2 && k == 0; ++blocks) {
            mbsr_newton_opt opt = mbsr_default_newton_opt();
            mbsr_newton *w = NULL;
            opt.by_blocks = blocks;
            assert_ok(mbsr_newton_create(m, MBSR_DAE_MOMENTUM, &opt, &w, NULL), NULL);
            assert_ok(mbsr_newton_factor(w, d, 0.0, y, yp, 30.0), e);
            assert_ok(mbsr_newton_solve(w, F[k], delta[blocks]), e);
            mbsr_newton_destroy(w);
        }
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
    assert_same(NU, udot[0], udot[1], 1.0, 1e-10);
    assert_same(SIZE, F[0], F[1], 1.0, 1e-10);
    assert_same(SIZE, delta[0], delta[1], 1.0, 1e-9);
}

/* ---- what is refused ---- */

static void elements_on_coordinates_that_are_none_name_them(void **state)
{
    (void)state;
    static const double z[3] = {0.0, 0.0, 1.0};
    mbsr_model *m = empty();
    add(m, "hand", MBSR_GROUND, mbsr_joint_revolute(NULL, NULL, z), link_inertia(systems, 1));
    assert_ok(mbsr_model_lock(m, 0, 0, 0.1), mbsr_model_error(m));
    add_force(m, mbsr_force_joint_spring(0, 1, 4.0, 0.3, 0.1));
    assert_refused(mbsr_model_finish(m), mbsr_model_error(m), MBSR_ERR_VALUE, -2, 0,
                   "joint spring|body 0 'hand'|coordinate is 1|has 1");
    assert_refused(mbsr_model_drop_locked(m, 1), mbsr_model_error(m), MBSR_ERR_ID, -2, -2,
                   "mbsr_model_drop_locked|body 1");
    assert_int_equal(mbsr_model_drop_locked(NULL, 0), MBSR_ERR_NULL);
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_locked_moves_as_what_is_held),
        cmocka_unit_test(very_stiff_springs_react_as_locks),
        cmocka_unit_test(consistent_starts_do_not_depend_on_who_is_welded),
        cmocka_unit_test(jacobians_of_welded_bodies_give_their_twists),
        cmocka_unit_test(evaluations_do_not_depend_on_who_is_welded),
        cmocka_unit_test(any_coordinates_of_a_joint_can_be_locked),
        cmocka_unit_test(elements_on_locked_coordinates_hold_or_are_dropped),
        cmocka_unit_test(definitions_are_as_given),
        cmocka_unit_test(couplings_read_locked_coordinates),
        cmocka_unit_test(couplings_without_free_coordinates_rest_or_are_refused),
        cmocka_unit_test(bodies_locked_in_loops_are_one_body),
        cmocka_unit_test(elements_on_coordinates_that_are_none_name_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
