/* Consistent starts of trees: directions on springs alone, many directions, masses that stay.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "body.h"
#include "expect.h"
#include "units.h"

#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const double now = 0.3;

/* A state of the momentum form, and what was found of it. */
typedef struct starts {
    int nq, nu;
    double *q, *u, *y, *yp;
} starts;

static void take(starts *s, const mbsr_model *model)
{
    s->nq = mbsr_model_nq(model);
    s->nu = mbsr_model_nu(model);
    const size_t size = (size_t)(s->nq + 2 * s->nu) + 1;
    s->q = calloc(size, sizeof(double));
    s->u = calloc(size, sizeof(double));
    s->y = calloc(size, sizeof(double));
    s->yp = calloc(size, sizeof(double));
}

static void give_back(starts *s)
{
    free(s->q), free(s->u), free(s->y), free(s->yp);
}

/* Bytes that were asked for. */
static size_t asked;

static void *ask(void *user, size_t size)
{
    (void)user;
    asked += size;
    return malloc(size);
}

static void give(void *user, void *memory)
{
    (void)user;
    free(memory);
}

/* A chain of carts without mass but for the last, each on a spring and a damper to the one before.
 * The dampers of carts `bare` and
 * the one after are left out: in series with others, one spring without damper would do. */
static void make_carts(int count, int bare, mbsr_model **model, mbsr_data **data)
{
    mbsr_error error;
    mbsr_model_def def = mbsr_default_model_def();
    def.allocator = (mbsr_allocator){.allocate = ask, .release = give};
    assert_ok(mbsr_model_create(&def, model, &error), &error);
    int at = MBSR_GROUND, id;
    for (int k = 0; k < count; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = at;
        body.joint = mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL);
        body.inertia = k + 1 < count ? mbsr_inertia_zero() : mbsr_inertia_particle(1.0);
        assert_ok(mbsr_model_add_body(*model, &body, &at), mbsr_model_error(*model));
        const bool damped = bare < 0 || (k != bare && k != bare + 1);
        const double damping = damped ? 0.5 + 0.01 * k : 0.0;
        const mbsr_force_def spring = mbsr_force_joint_spring(at, 0, 10.0 + k, damping, 0.0);
        assert_ok(mbsr_model_add_force(*model, &spring, &id), mbsr_model_error(*model));
    }
    assert_ok(mbsr_model_finish(*model), mbsr_model_error(*model));
    assert_ok(mbsr_data_create(*model, data, &error), &error);
}

static void carts_free(mbsr_model *model, mbsr_data *data)
{
    mbsr_data_destroy(data);
    mbsr_model_destroy(model);
}

/* Springs in balance leave the rates to chance, were the direction on a spring alone not found. */
static void a_direction_on_a_spring_alone_is_told(void **state)
{
    (void)state;
    for (int run = 0; run < 10; ++run) {
        const int bare = run / 2 - 1, balanced = run % 2;
        mbsr_model *model;
        mbsr_data *data;
        mbsr_consistent_info info;
        starts s;
        make_carts(6, bare, &model, &data);
        take(&s, model);
        for (int k = 0; k < 6; ++k) s.q[k] = balanced ? 1.0 / (10.0 + k) : 0.1 * k, s.u[k] = 1.0;
        assert_ok(mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, now, s.q, s.u, s.y),
                  mbsr_data_error(data));
        assert_ok(mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, now, s.y, s.yp, NULL, &info),
                  mbsr_data_error(data));
        assert_int_equal(info.null_directions, 5);
        assert_int_equal(info.elastic, bare < 0 ? 0 : 1);
        /* the force in all elements is the same, and its rate where springs alone hold */
        double force = 0.0, rate = 0.0;
        for (int k = 0; k < 6; ++k) {
            const bool damped = bare < 0 || (k != bare && k != bare + 1);
            const double d = damped ? 0.5 + 0.01 * k : 0.0, *u = s.y + 12, *udot = s.yp + 12,
                         f = (10.0 + k) * s.y[k] + d * u[k], g = (10.0 + k) * u[k] + d * udot[k];
            if (k == 0) force = f, rate = g;
            assert_close(f, force, 1e-11 * (1.0 + fabs(force)));
            assert_close(g, rate, 3e-8 * (1.0 + fabs(rate)));
        }
        give_back(&s);
        carts_free(model, data);
    }
}

/* A cart whose mass is rounding beside that of the next one, on springs alone: as a massless one.
 */
static void a_cart_of_next_to_no_mass(void **state)
{
    (void)state;
    static const double stiffness[] = {10.0, 11.0}, mass[] = {1e-20, 2.0};
    mbsr_model *model;
    mbsr_data *data;
    mbsr_consistent_info info;
    starts s;
    assert_ok(mbsr_model_create(NULL, &model, NULL), NULL);
    for (int k = 0; k < 2; ++k) {
        const int cart = test_add_body(
            model, k - 1, mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL),
            mbsr_inertia_particle(mass[k]));
        const mbsr_force_def spring = mbsr_force_joint_spring(cart, 0, stiffness[k], 0.0, 0.0);
        assert_ok(mbsr_model_add_force(model, &spring, NULL), mbsr_model_error(model));
    }
    assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
    assert_ok(mbsr_data_create(model, &data, NULL), NULL);
    take(&s, model);
    s.q[0] = 0.4, s.q[1] = -0.1, s.u[0] = 1.0, s.u[1] = 0.5;
    const double share = stiffness[1] / (stiffness[0] + stiffness[1]), way = s.q[0] + s.q[1],
                 rate = s.u[0] + s.u[1], acceleration = -share * stiffness[0] * way / mass[1];
    assert_ok(mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, now, s.q, s.u, s.y), NULL);
    assert_ok(mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, now, s.y, s.yp, NULL, &info),
              mbsr_data_error(data));
    assert_int_equal(info.null_directions, 1);
    assert_int_equal(info.elastic, 1);
    for (int k = 0; k < 2; ++k) {
        const double part = k ? 1.0 - share : share;
        assert_close(s.y[k], part * way, 1e-12);
        assert_close(s.y[4 + k], part * rate, 1e-9);
        assert_close(s.yp[4 + k], part * acceleration, 1e-7);
    }
    give_back(&s);
    carts_free(model, data);
}

/* Far more directions than a start by directions could find; the carts move at a common force, v_k
 * = (F - c_k q_k) / d_k with F from what the momentum leaves. */
static void a_thousand_massless_carts_start(void **state)
{
    (void)state;
    enum { CARTS = 1000 };
    mbsr_model *model;
    mbsr_data *data;
    starts s;
    make_carts(CARTS, -1, &model, &data);
    take(&s, model);
    double sum = 0.0, compliance = 0.0;
    for (int k = 0; k < CARTS; ++k) {
        s.q[k] = 0.1 * sin(k);
        s.u[k] = 1.0;
        sum += (10.0 + k) * s.q[k] / (0.5 + 0.01 * k);
        compliance += 1.0 / (0.5 + 0.01 * k);
    }
    const double force = (CARTS + sum) / compliance; /* the last one moves with CARTS */
    mbsr_consistent_info info;
    assert_ok(mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, now, s.q, s.u, s.y),
              mbsr_data_error(data));
    assert_ok(mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, now, s.y, s.yp, NULL, &info),
              mbsr_data_error(data));
    assert_int_equal(info.null_directions, CARTS - 1);
    assert_int_equal(info.elastic, 0);
    double acceleration = 0.0;
    for (int k = 0; k < CARTS; ++k) {
        const double v = (force - (10.0 + k) * s.q[k]) / (0.5 + 0.01 * k);
        assert_close(s.y[2 * CARTS + k], v, 1e-7 * CARTS);
        acceleration += s.yp[2 * CARTS + k];
    }
    assert_close(acceleration, -force, 1e-6 * fabs(force));
    give_back(&s);
    carts_free(model, data);
}

/* No matrix of all directions is made. */
static void memory_of_a_start_grows_with_the_carts(void **state)
{
    (void)state;
    size_t bytes[2];
    for (int k = 0; k < 2; ++k) {
        mbsr_model *model;
        mbsr_data *data;
        starts s;
        make_carts(400 << k, -1, &model, &data);
        take(&s, model);
        for (int l = 0; l < s.nu; ++l) s.q[l] = 0.1 * sin(l), s.u[l] = 1.0;
        assert_ok(mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, now, s.q, s.u, s.y),
                  mbsr_data_error(data));
        asked = 0;
        assert_ok(mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, now, s.y, s.yp, NULL, NULL),
                  mbsr_data_error(data));
        bytes[k] = asked;
        give_back(&s);
        carts_free(model, data);
    }
    assert_true((double)bytes[1] < 2.1 * (double)bytes[0]);
}

/* A carrier without mass turns to where its springs balance; the body that it carries, in SI and in
 * mm, g, ms, stays where it is and keeps its velocity, though the joint between them has turned by
 * nearly one rad. */
static void what_has_mass_stays(void **state)
{
    (void)state;
    static const struct {
        double length, mass, time;
    } in[2] = {{1.0, 1.0, 1.0}, {1e3, 1e3, 1e3}};
    for (int k = 0; k < 2; ++k) {
        const double L = in[k].length, stiffness = in[k].mass / (in[k].time * in[k].time),
                     at[3] = {0.5 * L, 0.2 * L, 0.0}, com[2] = {0.1 * L, 0.3 * L};
        const mbsr_planar_frame origin = {0.0, 0.0, 0.0};
        mbsr_model *model = NULL;
        mbsr_data *data = NULL;
        assert_ok(mbsr_model_create(NULL, &model, NULL), NULL);
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_planar_revolute(origin, origin);
        body.inertia = mbsr_inertia_zero();
        assert_ok(mbsr_model_add_body(model, &body, NULL), mbsr_model_error(model));
        body.parent = 0;
        body.joint = mbsr_joint_planar_free(origin, origin);
        body.inertia = mbsr_inertia_planar(in[k].mass, com, 0.2 * in[k].mass * L * L);
        assert_ok(mbsr_model_add_body(model, &body, NULL), mbsr_model_error(model));
        const mbsr_force_def turns =
                                 mbsr_force_joint_spring(0, 0, 20.0 * stiffness * L * L, 0.0, 1.1),
                             pulls = mbsr_force_point_spring(0, at, 1, NULL, 5.0 * stiffness, 0.0,
                                                             0.3 * L);
        assert_ok(mbsr_model_add_force(model, &turns, NULL), mbsr_model_error(model));
        assert_ok(mbsr_model_add_force(model, &pulls, NULL), mbsr_model_error(model));
        assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
        assert_ok(mbsr_data_create(model, &data, NULL), NULL);
        const double v = L / in[k].time, w = 1.0 / in[k].time, q[4] = {0.1, 0.8 * L, 0.4 * L, 0.3},
                     u[4] = {0.5 * w, 0.2 * v, -0.3 * v, 0.7 * w};
        double y[12], yp[12], before[3], after[3], V[3], kept[3], share;
        int where;
        assert_ok(mbsr_stage_positions(model, data, now, q), mbsr_data_error(data));
        assert_ok(mbsr_stage_velocities(model, data, u), mbsr_data_error(data));
        assert_ok(mbsr_body_pose(model, data, 1, before), NULL);
        assert_ok(mbsr_body_twist(model, data, 1, V), NULL);
        assert_ok(mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, now, q, u, y), NULL);
        assert_ok(mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, now, y, yp, NULL, NULL),
                  mbsr_data_error(data));
        assert_true(fabs(y[0] - q[0]) > 0.5);
        assert_ok(mbsr_stage_positions(model, data, now, y), mbsr_data_error(data));
        assert_ok(mbsr_stage_velocities(model, data, y + 8), mbsr_data_error(data));
        assert_ok(mbsr_body_pose(model, data, 1, after), NULL);
        assert_ok(mbsr_body_twist(model, data, 1, kept), NULL);
        for (int c = 0; c < 3; ++c) {
            const double span = c < 2 ? L : 1.0;
            assert_close(after[c], before[c], 1e-11 * span);
            assert_close(kept[c], V[c], 1e-11 * span / in[k].time);
        }
        assert_ok(
            mbsr_dae_imbalance(model, data, MBSR_DAE_MOMENTUM, now, y, &share, &where, NULL, NULL),
            mbsr_data_error(data));
        assert_less(share, 1e-10);
        mbsr_data_destroy(data);
        mbsr_model_destroy(model);
    }
}

/* A rod on a link without mass, a point of it on a spring to the link: the spin of the rod is on
 * that spring alone, the link on a damper a hundred times as large. Positions are known no better
 * than rounding of the damper's part leaves them; the ends of the rod stay where they are. */
static void make_spin(const units *in, mbsr_model **model, mbsr_data **data, int *rod)
{
    const double L = in->length, M = in->mass, T = in->time;
    const double axis[3] = {-2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0};
    const double one[3] = {0.7 * L, -0.4 * L, 0.75 * L}, end[3] = {-L, -0.4 * L, 0.5 * L};
    const double here[3] = {0.0, 0.7 * L, 0.0}, there[3] = {0.75 * L, -0.4 * L, 0.0};
    const mbsr_frame at = mbsr_frame_at(0.0, 0.7 * L, 0.0),
                     up = mbsr_frame_at(0.5 * L, 0.75 * L, 0.5 * L);
    assert_ok(mbsr_model_create(NULL, model, NULL), NULL);
    const int link = test_add_body(*model, MBSR_GROUND, mbsr_joint_revolute(&at, NULL, axis),
                                   mbsr_inertia_zero());
    *rod = test_add_body(*model, link, mbsr_joint_free(&up, NULL),
                         mbsr_inertia_rod(25.0 * M, one, end));
    const mbsr_force_def spring = mbsr_force_point_spring(*rod, here, link, there,
                                                          2.31 * M / (T * T), 0.0, L),
                         damper = mbsr_force_joint_spring(link, 0, 0.03 * M * L * L / (T * T),
                                                          212.0 * M * L * L / T, 2.0);
    assert_ok(mbsr_model_add_force(*model, &spring, NULL), mbsr_model_error(*model));
    assert_ok(mbsr_model_add_force(*model, &damper, NULL), mbsr_model_error(*model));
    assert_ok(mbsr_model_finish(*model), mbsr_model_error(*model));
    assert_ok(mbsr_data_create(*model, data, NULL), NULL);
}

static void a_spring_beside_a_large_damper(void **state)
{
    (void)state;
    for (size_t l = 0; l < sizeof systems / sizeof *systems; ++l) {
        const double L = systems[l].length, T = systems[l].time, end[3] = {-L, -0.4 * L, 0.5 * L},
                     q[8] = {2.06, 0.4, -0.2, 0.8, 0.4, 0.0, -L, 0.7 * L};
        double before[3], after[3];
        int rod;
        mbsr_model *model;
        mbsr_data *data;
        starts s;
        make_spin(systems + l, &model, &data, &rod);
        take(&s, model);
        memcpy(s.q, q, sizeof q);
        for (int k = 0; k < 7; ++k) s.u[k] = cos(2.0 * k) * (k > 3 ? L : 1.0) / T;
        assert_ok(mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, s.y),
                  mbsr_data_error(data));
        assert_ok(mbsr_stage_positions(model, data, 0.0, s.y), mbsr_data_error(data));
        assert_ok(mbsr_body_point(model, data, rod, end, before, NULL, NULL), NULL);
        assert_ok(mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, 0.0, s.y, s.yp, NULL, NULL),
                  mbsr_data_error(data));
        assert_ok(mbsr_stage_positions(model, data, 0.0, s.y), mbsr_data_error(data));
        assert_ok(mbsr_body_point(model, data, rod, end, after, NULL, NULL), NULL);
        for (int k = 0; k < 3; ++k) assert_close(after[k], before[k], 1e-3 * L);
        give_back(&s);
        carts_free(model, data);
    }
}

/* A massless cart on a damper c = 2, pulled by a force whose slope jumps at `now` from 3 to 5 N/s:
 * u' is its slope by c, before `now` where nothing else is asked for, behind it on side 1. */
static void rates_where_a_force_has_a_kink(void **state)
{
    (void)state;
    const double x[3] = {now - 1.0, now, now + 1.0}, value[3] = {-3.0, 0.0, 5.0};
    mbsr_table_def def = mbsr_default_table_def();
    mbsr_table *table;
    mbsr_model *model;
    mbsr_data *data;
    starts s;
    def.points = 3;
    def.x = x;
    def.value = value;
    assert_ok(mbsr_table_create(&def, &table, NULL), NULL);
    assert_ok(mbsr_model_create(NULL, &model, NULL), NULL);
    const int cart = test_add_body(model, MBSR_GROUND,
                                   mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL),
                                   mbsr_inertia_zero());
    const mbsr_force_def damper = mbsr_force_joint_spring(cart, 0, 0.0, 2.0, 0.0),
                         pull = mbsr_force_joint_applied(cart, mbsr_table_force, table);
    assert_ok(mbsr_model_add_force(model, &damper, NULL), mbsr_model_error(model));
    assert_ok(mbsr_model_add_force(model, &pull, NULL), mbsr_model_error(model));
    assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
    assert_ok(mbsr_data_create(model, &data, NULL), NULL);
    take(&s, model);
    for (int side = -1; side <= 1; ++side) {
        mbsr_consistent_opt opt = mbsr_default_consistent_opt();
        opt.side = side;
        s.u[0] = 1.0;
        assert_ok(mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, now, s.q, s.u, s.y), NULL);
        assert_ok(mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, now, s.y, s.yp, &opt, NULL),
                  mbsr_data_error(data));
        assert_close(s.y[2], 0.0, 1e-12);
        assert_close(s.yp[2], side > 0 ? 2.5 : 1.5, 1e-6);
    }
    give_back(&s);
    carts_free(model, data);
    mbsr_table_destroy(table);
}

/* A slider that falls and a cart without mass, a damper between them along an axis that the cart
 * moves along by no more than rounding: nothing resists it, although no number is zero. */
static void a_damper_along_rounding_resists_nothing(void **state)
{
    (void)state;
    static const double e = 1.6653e-16, along[3] = {0.6, 0.8, 0.0}, across[3] = {0.0, 1.0, 0.0};
    for (size_t k = 0; k < sizeof systems / sizeof *systems; ++k) {
        const double L = systems[k].length, M = systems[k].mass, T = systems[k].time,
                     damper[6] = {[4] = 6.7 * M / T};
        const mbsr_frame turned = {.R = {0.6, 0.8, 0.0, 0.0, -e, -1.0, -0.8, 0.6, -e}};
        const mbsr_force_def gravity = mbsr_force_gravity(0.0, 0.0, -9.81 * L / (T * T));
        mbsr_model *model;
        mbsr_data *data;
        starts s;
        assert_ok(mbsr_model_create(NULL, &model, NULL), NULL);
        const int heavy =
            test_add_body(model, MBSR_GROUND, mbsr_joint_prismatic(&turned, NULL, along),
                          mbsr_inertia_particle(0.8 * M));
        const int light = test_add_body(
            model, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, across), mbsr_inertia_zero());
        const mbsr_force_def force = mbsr_force_bushing(heavy, NULL, light, NULL, NULL, damper);
        assert_ok(mbsr_model_add_force(model, &gravity, NULL), mbsr_model_error(model));
        assert_ok(mbsr_model_add_force(model, &force, NULL), mbsr_model_error(model));
        assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
        assert_ok(mbsr_data_create(model, &data, NULL), NULL);
        take(&s, model);
        assert_ok(mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, now, s.q, s.u, s.y), NULL);
        assert_int_equal(
            mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, now, s.y, s.yp, NULL, NULL),
            MBSR_UNDETERMINED);
        give_back(&s);
        carts_free(model, data);
    }
}

/* A rod upright on the axis about which a massless carrier turns, but for rounding, on a slide of
 * it; dampers hold the carrier along x and about that axis. The rod falls freely in the plane, and
 * the slide and the carrier along y share that. */
static void a_rod_on_the_axis_of_its_carrier(void **state)
{
    (void)state;
    for (size_t l = 0; l < sizeof systems / sizeof *systems; ++l) {
        const double L = systems[l].length, M = systems[l].mass, T = systems[l].time, angle = -0.25,
                     e = sin(4.0 * atan(1.0)), along[3] = {0.0, 1.0, 0.0}, end[3] = {0.0, 0.0, L},
                     bottom[3] = {0.0}, pull[2] = {1.3 * L / (T * T), 2.1 * L / (T * T)},
                     slide = pull[0] / sin(angle);
        const mbsr_frame turned = {.x = {0.0, 0.5 * L, 0.0},
                                   .R = {-1.0, e, 0.0, -e, -1.0, 0.0, 0.0, 0.0, 1.0}};
        mbsr_model *model;
        mbsr_data *data;
        starts s;
        assert_ok(mbsr_model_create(NULL, &model, NULL), NULL);
        const int carrier =
            test_add_body(model, MBSR_GROUND, mbsr_joint_in_plane(NULL, NULL), mbsr_inertia_zero());
        test_add_body(model, carrier, mbsr_joint_prismatic(&turned, NULL, along),
                      mbsr_inertia_rod(2.0 * M, bottom, end));
        const mbsr_force_def force[] = {
            mbsr_force_joint_spring(carrier, 0, 0.0, 4.0 * M / T, 0.0),
            mbsr_force_joint_spring(carrier, 2, 0.0, 5.0 * M * L * L / T, 0.0),
            mbsr_force_gravity(pull[0], pull[1], -9.81 * L / (T * T))};
        for (int k = 0; k < 3; ++k)
            assert_ok(mbsr_model_add_force(model, force + k, NULL), mbsr_model_error(model));
        assert_ok(mbsr_model_finish(model), mbsr_model_error(model));
        assert_ok(mbsr_data_create(model, &data, NULL), NULL);
        take(&s, model);
        s.q[2] = angle, s.q[3] = 0.5 * L;
        assert_ok(mbsr_dae_pack(model, data, MBSR_DAE_MOMENTUM, now, s.q, s.u, s.y), NULL);
        assert_ok(mbsr_dae_consistent(model, data, MBSR_DAE_MOMENTUM, now, s.y, s.yp, NULL, NULL),
                  mbsr_data_error(data));
        const double *udot = s.yp + s.nq + s.nu,
                     expected[4] = {0.0, pull[1] + cos(angle) * slide, 0.0, slide};
        for (int k = 0; k < 4; ++k)
            assert_close(udot[k], expected[k], 1e-9 * (k == 2 ? 1.0 : L) / (T * T));
        give_back(&s);
        carts_free(model, data);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_direction_on_a_spring_alone_is_told),
        cmocka_unit_test(a_cart_of_next_to_no_mass),
        cmocka_unit_test(a_thousand_massless_carts_start),
        cmocka_unit_test(memory_of_a_start_grows_with_the_carts),
        cmocka_unit_test(what_has_mass_stays),
        cmocka_unit_test(a_spring_beside_a_large_damper),
        cmocka_unit_test(rates_where_a_force_has_a_kink),
        cmocka_unit_test(a_damper_along_rounding_resists_nothing),
        cmocka_unit_test(a_rod_on_the_axis_of_its_carrier),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
