/* Index reports of models with closures: cases known by reasoning, in the plane and in space, in
 * four systems of units.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "close.h"
#include "expect.h"
#include "units.h"

#include <mbsrank/mbsrank.h>
#include <mbsrank/driver.h>

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* A mechanism in the plane z = 0, whose bodies are rods along x, hinged about z; `space`: the same
 * in space, with pins that leave z alone. */
typedef struct scene {
    const units *unit;
    bool space;
    mbsr_model *m;
    mbsr_data *d;
    double q[16], u[16];
} scene;

static double length(const scene *s, double x)
{
    return x * s->unit->length;
}

static double mass(const scene *s, double x)
{
    return x * s->unit->mass;
}

static double force(const scene *s, double x)
{
    return x * s->unit->mass * s->unit->length / (s->unit->time * s->unit->time);
}

static double stiffness(const scene *s, double x)
{
    return force(s, x) / s->unit->length;
}

static double damping(const scene *s, double x)
{
    return stiffness(s, x) * s->unit->time;
}

static void begin(scene *s, const units *unit, bool space, double gravity)
{
    *s = (scene){.unit = unit, .space = space};
    assert_ok(mbsr_model_create(NULL, &s->m, NULL), NULL);
    const double g = gravity * unit->length / (unit->time * unit->time);
    const mbsr_force_def weight = mbsr_force_gravity(0.0, -g, 0.0);
    if (g > 0.0) assert_ok(mbsr_model_add_force(s->m, &weight, NULL), mbsr_model_error(s->m));
}

static int add(scene *s, const char *name, int parent, const mbsr_joint *joint, double kg, double m)
{
    int id;
    mbsr_body_def body = mbsr_default_body_def();
    const double M = mass(s, kg), l = length(s, m), com[3] = {0.5 * l, 0.0, 0.0},
                 tensor[6] = {0.0, M * l * l / 12.0, M * l * l / 12.0, 0.0, 0.0, 0.0};
    body.name = name;
    body.parent = parent;
    body.joint = *joint;
    if (kg > 0.0)
        body.inertia = s->space ? mbsr_inertia_rigid(M, com, tensor)
                                : mbsr_inertia_planar(M, com, M * l * l / 12.0);
    assert_ok(mbsr_model_add_body(s->m, &body, &id), mbsr_model_error(s->m));
    return id;
}

static int add_rod(scene *s, const char *name, int parent, double x, double kg, double m)
{
    static const double z[3] = {0.0, 0.0, 1.0};
    const mbsr_frame at = mbsr_frame_at(length(s, x), 0.0, 0.0);
    const mbsr_joint joint =
        s->space ? mbsr_joint_revolute(&at, NULL, z)
                 : mbsr_joint_planar_revolute((mbsr_planar_frame){length(s, x), 0.0, 0.0},
                                              (mbsr_planar_frame){0.0, 0.0, 0.0});
    return add(s, name, parent, &joint, kg, m);
}

/* Point x of body a on point x of body b. stiff: N/m, 0 where rigid, with as many N s/m of damping.
 */
static int pin(scene *s, const char *name, int a, double xa, int b, double xb, double stiff,
               double damped)
{
    static const double axes[2][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
    int id;
    const double at_a[3] = {length(s, xa), 0.0, 0.0}, at_b[3] = {length(s, xb), 0.0, 0.0};
    mbsr_closure_def pin = s->space ? mbsr_closure_rows(a, at_a, b, at_b, 2, axes[0])
                                    : mbsr_closure_ball(a, at_a, b, at_b);
    pin.name = name;
    for (int k = 0; k < 2; ++k) {
        pin.stiffness[k] = stiffness(s, stiff);
        pin.damping[k] = damping(s, damped);
    }
    assert_ok(mbsr_model_add_closure(s->m, &pin, &id), mbsr_model_error(s->m));
    return id;
}

/* A spring between point x of a body and the ground; its id. */
static int spring(scene *s, int body, double x, double ground_x, double ground_y, double k,
                  double d, double rest)
{
    int id;
    const double at[3] = {length(s, x), 0.0, 0.0},
                 to[3] = {length(s, ground_x), length(s, ground_y), 0.0};
    const mbsr_force_def def = mbsr_force_point_spring(body, at, MBSR_GROUND, to, stiffness(s, k),
                                                       damping(s, d), length(s, rest));
    assert_ok(mbsr_model_add_force(s->m, &def, &id), mbsr_model_error(s->m));
    return id;
}

/* Closes the loops from angles (rad) near q and makes the report. */
static mbsr_index_report *report(scene *s, int n, const double *q)
{
    mbsr_index_report *made;
    assert_ok(mbsr_model_finish(s->m), mbsr_model_error(s->m));
    assert_ok(mbsr_data_create(s->m, &s->d, NULL), NULL);
    assert_int_equal(mbsr_model_nq(s->m), n);
    memcpy(s->q, q, (size_t)n * sizeof *q);
    assert_ok(mbsr_assemble(s->m, s->d, 0.0, s->q, NULL, s->q, NULL), mbsr_data_error(s->d));
    assert_ok(mbsr_index_report_create(s->m, s->d, 0.0, s->q, s->u, &made), mbsr_data_error(s->d));
    return made;
}

static void end(scene *s, mbsr_index_report *made)
{
    mbsr_index_report_destroy(s->m, made);
    mbsr_data_destroy(s->d);
    mbsr_model_destroy(s->m);
}

static void assert_counts(const mbsr_index_report *r, int dynamic, int damped, int elastic,
                          int undetermined, int held)
{
    assert_int_equal(r->dynamic, dynamic);
    assert_int_equal(r->damped, damped);
    assert_int_equal(r->elastic, elastic);
    assert_int_equal(r->undetermined, undetermined);
    assert_int_equal(r->loop_supported, held);
    assert_int_equal(r->directions, damped + elastic + undetermined);
    assert_int_equal(r->index, undetermined ? -1 : elastic ? 2 : 1);
}

typedef void (*scene_test)(const units *unit, bool space);

static void everywhere(scene_test test)
{
    for (size_t k = 0; k < sizeof systems / sizeof *systems; ++k) {
        for (int space = 0; space < 2; ++space) test(systems + k, space == 1);
    }
}

/* ---- a four-bar linkage, crank 1 m, coupler 2.5 m, rocker 2 m, on ground of 2 m ---- */

static const double four_bar_q[3] = {1.2, -0.9, 1.3};

static void four_bar(scene *s, double crank, double coupler, double rocker, double k, double d)
{
    const int a = add_rod(s, "crank", MBSR_GROUND, 0.0, crank, 1.0),
              b = add_rod(s, "coupler", a, 1.0, coupler, 2.5),
              c = add_rod(s, "rocker", MBSR_GROUND, 2.0, rocker, 2.0);
    pin(s, "pin", b, 2.5, c, 2.0, k, d);
}

/* With mass somewhere the loop moves it, and holds what has none. */
static void held_by_the_loop(const units *unit, bool space)
{
    for (int heavy = 0; heavy < 3; ++heavy) {
        scene s;
        begin(&s, unit, space, 9.81);
        four_bar(&s, heavy == 0 ? 1.0 : 0.0, heavy == 1 ? 2.5 : 0.0, heavy == 2 ? 2.0 : 0.0, 0.0,
                 0.0);
        mbsr_index_report *r = report(&s, 3, four_bar_q);
        /* with mass on the coupler alone, that is behind two joints */
        assert_counts(r, 1, 0, 0, 0, heavy == 1 ? 1 : 2);
        assert_string_equal(r->text, "");
        end(&s, r);
    }
}

/* Without any mass: one direction, that of the mechanism, with the rates of all three joints. */
static void massless(const units *unit, bool space)
{
    for (int damped = 0; damped < 3; ++damped) {
        scene s;
        begin(&s, unit, space, 9.81);
        four_bar(&s, 0.0, 0.0, 0.0, 0.0, 0.0);
        int id = -1;
        if (damped > 0) id = spring(&s, 1, 1.25, 1.0, 3.0, 50.0, damped > 1 ? 2.0 : 0.0, 0.5);
        mbsr_index_report *r = report(&s, 3, four_bar_q);
        assert_counts(r, 0, damped == 2, damped == 1, damped == 0, 2);
        assert_int_equal(r->direction->terms, 3);
        assert_int_equal(r->direction->forces, damped > 0);
        assert_int_equal(r->direction->closures, 0);
        if (damped > 0) assert_int_equal(r->direction->force[0], id);
        if (damped == 0) assert_contains(r->text, "crank|coupler|rocker|no force resists");
        /* its rates keep the loop closed */
        double x[3] = {0.0}, y[4];
        for (int k = 0; k < 3; ++k)
            x[r->direction->term[k].body] = r->direction->term[k].weight / unit->time;
        assert_ok(mbsr_stage_positions(s.m, s.d, 0.0, s.q), NULL);
        assert_ok(mbsr_closures_apply(s.m, s.d, x, y), NULL);
        for (int k = 0; k < mbsr_model_rows(s.m); ++k)
            assert_close(y[k] / unit->length * unit->time, 0.0, 1e-12);
        end(&s, r);
    }
}

/* A link without mass on the coupler: nothing holds it, or a spring or a damper. */
static void coupler_point(const units *unit, bool space)
{
    for (int damped = 0; damped < 3; ++damped) {
        scene s;
        begin(&s, unit, space, 9.81);
        four_bar(&s, 1.0, 2.5, 2.0, 0.0, 0.0);
        const int link = add_rod(&s, "pointer", 1, 1.0, 0.0, 0.7);
        int id = -1;
        if (damped > 0) id = spring(&s, link, 0.7, 0.0, 5.0, 80.0, damped > 1 ? 3.0 : 0.0, 1.0);
        const double q[4] = {1.2, -0.9, 1.3, 0.4};
        mbsr_index_report *r = report(&s, 4, q);
        assert_counts(r, 1, damped == 2, damped == 1, damped == 0, 0);
        assert_int_equal(r->direction->terms, 1);
        assert_int_equal(r->direction->term[0].body, link);
        assert_int_equal(r->direction->forces, damped > 0);
        if (damped > 0) assert_int_equal(r->direction->force[0], id);
        if (damped == 0) assert_contains(r->text, "pointer");
        end(&s, r);
    }
}

/* A dummy link, by whose joints the coupler is taken twice: the loop does not hold its turn about
 * two hinges in one place. */
static void dummy_link(const units *unit, bool space)
{
    for (int shifted = 0; shifted < 2; ++shifted) {
        scene s;
        begin(&s, unit, space, 9.81);
        const double at = shifted ? 0.3 : 0.0;
        const int a = add_rod(&s, "crank", MBSR_GROUND, 0.0, 1.0, 1.0),
                  dummy = add_rod(&s, "dummy", a, 1.0, 0.0, at),
                  b = add_rod(&s, "coupler", dummy, at, 2.5, 2.5),
                  c = add_rod(&s, "rocker", MBSR_GROUND, 2.0, 2.0, 2.0);
        pin(&s, "pin", b, 2.5, c, 2.0, 0.0, 0.0);
        const double q[4] = {1.2, -0.5, -0.4, 1.3};
        mbsr_index_report *r = report(&s, 4, q);
        if (shifted) { /* the rod of 0.3 m moves the coupler: two freedoms */
            assert_counts(r, 2, 0, 0, 0, 0);
        } else { /* dummy against coupler */
            assert_counts(r, 1, 0, 0, 1, 0);
            assert_int_equal(r->direction->terms, 2);
            assert_contains(r->text, "dummy|coupler");
        }
        end(&s, r);
    }
}

/* ---- stiff closures ---- */

/* A massless four-bar whose pin is stiff: the pin alone holds the two directions that it held as a
 * rigid one. What it does not see is undetermined. */
static void stiff_pin(const units *unit, bool space)
{
    static const double k[] = {1e2, 1e6, 1e10, 1e14};
    for (int step = 0; step < 8; ++step) {
        const bool damped = step >= 4;
        scene s;
        begin(&s, unit, space, 9.81);
        four_bar(&s, 0.0, 0.0, 0.0, k[step % 4], damped ? 1e-4 * k[step % 4] : 0.0);
        mbsr_index_report *r = report(&s, 3, four_bar_q);
        assert_counts(r, 0, damped ? 2 : 0, damped ? 0 : 2, 1, 0);
        for (int l = 1; l < 3; ++l) { /* undetermined ones come first */
            assert_int_equal(r->direction[l].forces, 0);
            assert_int_equal(r->direction[l].closures, 1);
            assert_int_equal(r->direction[l].closure[0], 0);
        }
        assert_int_equal(r->direction->closures, 0);
        end(&s, r);
    }
}

/* ---- forces that turn ---- */

/* An arm without mass, a rod of 2 m (a distance) from its tip to a mass that slides straight below:
 * when all are in one line, the row does not see the arm turn, and the weight that the rod carries
 * holds it, or pushes it over. Without weight nothing does. */
static void hanging(const units *unit, bool space)
{
    for (int kind = 0; kind < 3; ++kind) {
        static const double y[3] = {0.0, 1.0, 0.0};
        scene s;
        begin(&s, unit, space, kind == 0 ? 0.0 : 9.81);
        const int arm = add_rod(&s, "arm", MBSR_GROUND, 0.0, 0.0, 1.0);
        const mbsr_joint slide =
            space ? mbsr_joint_prismatic(NULL, NULL, y)
                  : mbsr_joint_planar_prismatic((mbsr_planar_frame){0.0, 0.0, 0.5 * acos(-1.0)},
                                                (mbsr_planar_frame){0.0, 0.0, 0.0});
        const int weight = add(&s, "weight", MBSR_GROUND, &slide, 3.0, 1.0);
        const double tip[3] = {length(&s, 1.0), 0.0, 0.0}, here[3] = {0.0};
        const mbsr_closure_def rod = mbsr_closure_distance(arm, tip, weight, here, length(&s, 2.0));
        assert_ok(mbsr_model_add_closure(s.m, &rod, NULL), mbsr_model_error(s.m));
        const double q[2] = {-0.5 * acos(-1.0), length(&s, kind == 2 ? 1.0 : -3.0)};
        mbsr_index_report *r = report(&s, 2, q);
        /* the row alone is left of the slide */
        assert_counts(r, 0, 0, kind > 0, kind == 0, 0);
        assert_int_equal(r->direction->terms, 1);
        assert_int_equal(r->direction->term[0].body, arm);
        assert_int_equal(r->direction->forces, 0);
        end(&s, r);
    }
}

static void held_directions(void **state)
{
    (void)state;
    everywhere(held_by_the_loop);
}

static void massless_linkage(void **state)
{
    (void)state;
    everywhere(massless);
}

static void massless_pointer(void **state)
{
    (void)state;
    everywhere(coupler_point);
}

static void massless_dummy(void **state)
{
    (void)state;
    everywhere(dummy_link);
}

static void stiff_closures(void **state)
{
    (void)state;
    everywhere(stiff_pin);
}

static void turning_loop_forces(void **state)
{
    (void)state;
    everywhere(hanging);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(held_directions),  cmocka_unit_test(massless_linkage),
        cmocka_unit_test(massless_pointer), cmocka_unit_test(massless_dummy),
        cmocka_unit_test(stiff_closures),   cmocka_unit_test(turning_loop_forces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
