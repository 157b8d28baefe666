/* Values made by the stock constructors with one public field changed: each is refused with a text,
 * or accepted and then evaluated without harm. Run with sanitizers this finds reads beyond arrays.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "expect.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>

enum { MOST = 64 };

/* ---- values a caller may write -------------------------------------------------------------- */

static const int integers[] = {-1, 0, 1, 2, INT_MAX, INT_MIN};
static const double numbers[] = {NAN, INFINITY, -1.0, 1e308};
enum { INTEGERS = sizeof integers / sizeof *integers, NUMBERS = sizeof numbers / sizeof *numbers };

/* Walks over the changes of a value: change number `wanted` is made, `count` counts them all. */
typedef struct changes {
    int wanted, count;
    char name[64];
} changes;

static void change_int(changes *c, const char *name, int k, int *field)
{
    for (int v = 0; v < INTEGERS; ++v) {
        if (c->count++ != c->wanted) continue;
        *field = integers[v];
        snprintf(c->name, sizeof c->name, "%s[%d] = %d", name, k, integers[v]);
    }
}

static void change_double(changes *c, const char *name, int k, double *field)
{
    for (int v = 0; v < NUMBERS; ++v) {
        if (c->count++ != c->wanted) continue;
        *field = numbers[v];
        snprintf(c->name, sizeof c->name, "%s[%d] = %g", name, k, numbers[v]);
    }
}

/* Whether a pointer is to be made NULL. */
static int change_pointer(changes *c, const char *name)
{
    if (c->count++ != c->wanted) return 0;
    snprintf(c->name, sizeof c->name, "%s = NULL", name);
    return 1;
}

static void change_space(changes *c, mbsr_space *space)
{
    for (int v = -1; v <= 5; ++v) {
        if (c->count++ != c->wanted) continue;
        *space = (mbsr_space)v;
        snprintf(c->name, sizeof c->name, "space = %d", v);
    }
}

static void change_joint(changes *c, mbsr_joint *joint)
{
    if (change_pointer(c, "table")) joint->table = NULL;
    if (change_pointer(c, "motion")) joint->motion = NULL;
    if (change_pointer(c, "user")) joint->user = NULL;
    change_space(c, &joint->space);
    change_int(c, "d", 0, &joint->d);
    change_int(c, "np", 0, &joint->np);
    change_int(c, "n", 0, &joint->n);
    change_int(c, "nq", 0, &joint->nq);
    change_int(c, "params", 0, &joint->params);
    for (int k = 0; k < MBSR_JOINT_OPTIONS; ++k) change_int(c, "option", k, joint->option + k);
    for (int k = 0; k < MBSR_JOINT_PARAMS; ++k) change_double(c, "param", k, joint->param + k);
}

static void change_force(changes *c, mbsr_force_def *force)
{
    change_int(c, "cookie", 0, &force->cookie);
    if (change_pointer(c, "name")) force->name = NULL;
    if (change_pointer(c, "table")) force->table = NULL;
    if (change_pointer(c, "body_list")) force->body_list = NULL;
    if (change_pointer(c, "function")) force->function = NULL;
    if (change_pointer(c, "spring")) force->spring = NULL;
    if (change_pointer(c, "user")) force->user = NULL;
    change_int(c, "bodies", 0, &force->bodies);
    for (int k = 0; k < 2; ++k) change_int(c, "body", k, force->body + k);
    for (int k = 0; k < MBSR_FORCE_OPTIONS; ++k) change_int(c, "option", k, force->option + k);
    for (int k = 0; k < MBSR_FORCE_PARAMS; ++k) change_double(c, "param", k, force->param + k);
}

static void change_inertia(changes *c, mbsr_inertia *inertia)
{
    for (int v = -2; v <= 6; ++v) {
        if (c->count++ != c->wanted) continue;
        inertia->kind = (mbsr_inertia_kind)v;
        snprintf(c->name, sizeof c->name, "kind = %d", v);
    }
    if (change_pointer(c, "matrix")) inertia->matrix = NULL;
    if (change_pointer(c, "function")) inertia->function = NULL;
    if (change_pointer(c, "user")) inertia->user = NULL;
    change_int(c, "d", 0, &inertia->d);
    change_int(c, "unchecked", 0, &inertia->unchecked);
    change_double(c, "mass", 0, &inertia->mass);
    change_double(c, "moment", 0, &inertia->moment);
    for (int k = 0; k < 3; ++k) change_double(c, "com", k, inertia->com + k);
    for (int k = 0; k < 6; ++k) change_double(c, "tensor", k, inertia->tensor + k);
}

/* ---- the models they are put into ----------------------------------------------------------- */

static const mbsr_planar_frame flat = {0.1, 0.2, 0.3};
static const double e_x[3] = {1, 0, 0}, e_y[3] = {0, 1, 0}, e_z[3] = {0, 0, 1};
static const double tensor[6] = {1.0, 1.1, 1.2, 0.1, 0.05, 0.02}, com[3] = {0.1, 0.2, -0.1};

static int still(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user, (void)t;
    s[0] = sdot[0] = sddot[0] = 0.1;
    return 0;
}

static int push(void *user, double t, int n, double *value)
{
    (void)user, (void)t;
    for (int k = 0; k < n; ++k) value[k] = 0.5;
    return 0;
}

static int pull(void *user, double x, double v, double *force, double *energy, double *power)
{
    (void)user;
    *force = x + v;
    if (energy) *energy = 0.5 * x * x;
    if (power) *power = v * v;
    return 0;
}

static int unit_mass(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    (void)user, (void)t, (void)p, (void)V, (void)h;
    for (int k = 0; k < 6; ++k) M[7 * k] = 1.0;
    return 0;
}

static mbsr_body_def body_with(int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.name = "part";
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    return body;
}

static void add(mbsr_model *m, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    const mbsr_body_def body = body_with(parent, joint, inertia);
    assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
}

/* Two bodies in space (0 free, 1 spherical), then two in the plane (2 planar, 3 a point) and two
 * more on those in space (4 revolute, 5 with six axes), all with mass, under gravity; or the first
 * two alone. */
static mbsr_model *make_model(int in_space_only)
{
    mbsr_model *m = NULL;
    assert_ok(mbsr_model_create(NULL, &m, NULL), NULL);
    const mbsr_inertia rigid = mbsr_inertia_rigid(2.0, com, tensor);
    add(m, MBSR_GROUND, mbsr_joint_free(NULL, NULL), rigid);
    add(m, 0, mbsr_joint_spherical(NULL, NULL), rigid);
    if (!in_space_only) {
        add(m, MBSR_GROUND, mbsr_joint_planar_free(flat, flat), mbsr_inertia_planar(1, com, 0.5));
        add(m, MBSR_GROUND, mbsr_joint_point_free(), mbsr_inertia_particle(1.5));
        add(m, 1, mbsr_joint_revolute(NULL, NULL, e_y), rigid);
    }
    const mbsr_force_def gravity = mbsr_force_gravity(0.0, 0.0, -9.81);
    assert_ok(mbsr_model_add_force(m, &gravity, NULL), mbsr_model_error(m));
    return m;
}

static void assert_told(const mbsr_error *error, int status, const char *what, const char *change)
{
    if (error->status == status && error->text[0]) return;
    print_error("%s, %s: %s without a text (%s)\n", what, change, mbsr_status_name(status),
                error->text);
    fail();
}

static void assert_all_finite(int n, const double *x, const char *what, const char *change,
                              const char *quantity)
{
    for (int k = 0; k < n; ++k) {
        if (isfinite(x[k])) continue;
        print_error("%s, %s: %s[%d] is %g\n", what, change, quantity, k, x[k]);
        fail();
    }
}

/* Forward dynamics, energies, index report: finite numbers, or a status with a text. */
static void evaluate(const mbsr_model *m, const char *what, const char *change)
{
    mbsr_data *d = NULL;
    double q[MOST], u[MOST], udot[MOST], energy[2] = {0.0};
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_in_range(mbsr_model_nq(m), 0, MOST);
    for (int k = 0; k < MOST; ++k) {
        q[k] = 0.3 + 0.05 * k;
        u[k] = 0.2 - 0.03 * k;
    }
    int status = mbsr_forward_dynamics(m, d, 0.0, q, u, NULL, udot);
    if (status)
        assert_told(mbsr_data_error(d), status, what, change);
    else
        assert_all_finite(mbsr_model_nu(m), udot, what, change, "udot");
    status = mbsr_stage_positions(m, d, 0.0, q);
    if (!status) status = mbsr_stage_velocities(m, d, u);
    if (!status) status = mbsr_energy(m, d, energy, energy + 1);
    if (status)
        assert_told(mbsr_data_error(d), status, what, change);
    else
        assert_all_finite(2, energy, what, change, "energy");
    mbsr_index_report *report = NULL;
    status = mbsr_index_report_create(m, d, 0.0, q, u, &report);
    if (status) assert_told(mbsr_data_error(d), status, what, change);
    mbsr_index_report_destroy(m, report);
    mbsr_data_destroy(d);
}

/* After an addition with `status`: refused with a text and the model as it was, or evaluated. */
static int settle(mbsr_model *m, int status, const char *what, const char *change)
{
    if (status) assert_told(mbsr_model_error(m), status, what, change);
    const int accepted = status == MBSR_OK;
    status = mbsr_model_finish(m);
    if (status && !accepted) print_error("%s, %s: lost\n", what, change);
    assert_true(status == MBSR_OK || accepted);
    if (status)
        assert_told(mbsr_model_error(m), status, what, change);
    else
        evaluate(m, what, change);
    mbsr_model_destroy(m);
    return accepted && status == MBSR_OK;
}

/* ---- joints ---- */

static int number_of_joints;

static mbsr_joint stock_joint(int k)
{
    const mbsr_axis axes[3] = {
        {.kind = MBSR_AXIS_ROTATION, .direction = {1, 0, 0}},
        {.kind = MBSR_AXIS_SCREW, .direction = {0, 1, 0}, .pitch = 0.3},
        {.kind = MBSR_AXIS_TRANSLATION, .direction = {0, 0, 1}, .driven = 1}};
    const mbsr_joint joint[] = {mbsr_joint_weld(NULL, NULL),
                                mbsr_joint_revolute(NULL, NULL, e_x),
                                mbsr_joint_prismatic(NULL, NULL, e_y),
                                mbsr_joint_screw(NULL, NULL, e_z, 0.1),
                                mbsr_joint_cylindrical(NULL, NULL, e_x),
                                mbsr_joint_universal(NULL, NULL, e_x, e_y),
                                mbsr_joint_in_plane(NULL, NULL),
                                mbsr_joint_translational(NULL, NULL),
                                mbsr_joint_spherical(NULL, NULL),
                                mbsr_joint_free(NULL, NULL),
                                mbsr_joint_compound(NULL, NULL, 3, axes, still, NULL),
                                mbsr_joint_compound(NULL, NULL, 0, NULL, NULL, NULL),
                                mbsr_joint_planar(flat, flat, MBSR_X, MBSR_ANGLE, still, NULL),
                                mbsr_joint_planar_weld(flat, flat),
                                mbsr_joint_planar_revolute(flat, flat),
                                mbsr_joint_planar_prismatic(flat, flat),
                                mbsr_joint_planar_pin_slot(flat, flat),
                                mbsr_joint_planar_free(flat, flat),
                                mbsr_joint_point(flat, MBSR_X, MBSR_Y, still, NULL),
                                mbsr_joint_point_free()};
    number_of_joints = (int)(sizeof joint / sizeof *joint);
    return joint[k];
}

static void joints_with_a_changed_field(void **state)
{
    (void)state;
    stock_joint(0);
    int accepted = 0, total = 0;
    for (int k = 0; k < number_of_joints; ++k) {
        changes c = {.wanted = -1};
        for (int done = -1; done < c.count; ++done) {
            mbsr_joint joint = stock_joint(k);
            char what[64];
            c = (changes){.wanted = done};
            snprintf(what, sizeof what, "joint %d (%s)", k, joint.table->name);
            const int in_space = joint.space == MBSR_SPACE_SPATIAL;
            change_joint(&c, &joint);
            if (done == c.count) break;
            mbsr_model *m = make_model(0);
            const int parent = done % 2 ? MBSR_GROUND : in_space ? 1 : 2;
            const mbsr_body_def body = body_with(
                parent, joint, in_space ? mbsr_inertia_rigid(1, com, tensor) : mbsr_inertia_zero());
            int id = 77;
            const int status = mbsr_model_add_body(m, &body, &id);
            assert_true(id == (status ? 77 : 5));
            accepted += settle(m, status, what, c.name);
            ++total;
        }
    }
    print_message("%d of %d accepted\n", accepted, total);
    assert_true(accepted > total / 8 && accepted < total);
}

/* ---- forces ---- */

static int number_of_forces;

static mbsr_force_def stock_force(int k)
{
    static const double six[6] = {1, 2, 3, 4, 5, 6}, quaternion[4] = {1.0, 0.2, 0.3, -0.1};
    const mbsr_contact contact = {.radius = 3.0,
                                  .normal = {0, 0, 2},
                                  .stiffness = 10.0,
                                  .exponent = 1.5,
                                  .damping = 0.1,
                                  .friction = 0.3,
                                  .slip = 0.1};
    const mbsr_friction friction = {
        .coefficient = 0.3, .slip = 0.1, .load = 2.0, .axle = {1, 0, 0}};
    const mbsr_bearing bearing = {.torque = 1.0, .viscous = 0.2, .slip = 0.1, .axis = {0, 1, 0}};
    const mbsr_planar_frame o = {0.0, 0.0, 0.0};
    static const double nine[9] = {2, 1, 0, 1, 2, 0, 0, 0, 3};
    const mbsr_spring law = {.function = pull}, cable = {.stiffness = 5, .one_sided = 1};
    const mbsr_force_def force[] = {mbsr_force_gravity(0, 1, 2),
                                    mbsr_force_axis_spring(2, MBSR_GROUND, 1, 3.0, 0.1, 0.2),
                                    mbsr_force_axis_spring(2, 3, 1, 3.0, 0.1, 0.2),
                                    mbsr_force_point_spring(0, e_x, 1, e_y, 4.0, 0.1, 0.2),
                                    mbsr_force_point_spring(0, e_x, 2, e_y, 4.0, 0.1, 0.2),
                                    mbsr_force_spring(4, e_x, MBSR_GROUND, e_y, &cable),
                                    mbsr_force_spring(4, e_x, 1, e_y, &law),
                                    mbsr_force_bushing(0, NULL, 4, NULL, six, six),
                                    mbsr_force_joint_spring(4, 0, 3.0, 0.1, 0.2),
                                    mbsr_force_joint_cubic_spring(2, 1, 3.0, 2.0, 0.1, 0.2),
                                    mbsr_force_joint_rotation_spring(1, six, six, quaternion),
                                    mbsr_force_joint_rotation_spring(0, six, six, NULL),
                                    mbsr_force_joint_stop(4, 0, -0.1, 0.1, 5.0, 0.1),
                                    mbsr_force_joint_friction(1, 2, 0.3, 0.1),
                                    mbsr_force_applied(0, push, NULL),
                                    mbsr_force_wrench(1, e_x, 1, push, NULL),
                                    mbsr_force_joint_applied(1, push, NULL),
                                    mbsr_force_contact(0, MBSR_GROUND, &contact),
                                    mbsr_force_contact(0, 1, &contact),
                                    mbsr_force_axis_friction(2, 3, 1, 3.0, 0.1),
                                    mbsr_force_point_friction(0, e_x, 2, &friction),
                                    mbsr_force_bearing_friction(0, 1, &bearing),
                                    mbsr_force_planar_bushing(2, o, MBSR_GROUND, o, nine, NULL)};
    number_of_forces = (int)(sizeof force / sizeof *force);
    return force[k];
}

static void forces_with_a_changed_field(void **state)
{
    (void)state;
    stock_force(0);
    int accepted = 0, total = 0;
    for (int k = 0; k < number_of_forces; ++k) {
        changes c = {.wanted = -1};
        for (int done = -1; done < c.count; ++done) {
            mbsr_force_def force = stock_force(k);
            char what[64];
            c = (changes){.wanted = done};
            snprintf(what, sizeof what, "force %d (%s)", k, force.table->name);
            change_force(&c, &force);
            if (done == c.count) break;
            mbsr_model *m = make_model(0);
            int id = 77;
            const int status = mbsr_model_add_force(m, &force, &id);
            assert_true(id == (status ? 77 : 1));
            accepted += settle(m, status, what, c.name);
            ++total;
        }
    }
    print_message("%d of %d accepted\n", accepted, total);
    assert_true(accepted > total / 8 && accepted < total);
}

/* ---- inertias ---- */

static int number_of_inertias;

static mbsr_inertia stock_inertia(int k)
{
    static double six_by_six[36];
    for (int l = 0; l < 6; ++l) six_by_six[7 * l] = 1.0 + l;
    const mbsr_frame frame = mbsr_frame_at(0.1, 0.2, 0.3);
    const mbsr_inertia inertia[] = {
        mbsr_inertia_zero(),
        mbsr_inertia_particle(1.0),
        mbsr_inertia_rigid(1.0, com, tensor),
        mbsr_inertia_rigid_unchecked(1.0, com, tensor),
        mbsr_inertia_rigid_about(1.0, com, &frame, tensor),
        mbsr_inertia_point_mass(1.0, com),
        mbsr_inertia_rod(1.0, e_x, e_y),
        mbsr_inertia_box(1000.0, tensor),
        mbsr_inertia_sphere(1000.0, 0.1),
        mbsr_inertia_cylinder(1000.0, 0.1, 0.2),
        mbsr_inertia_capsule(1000.0, 0.1, 0.2),
        mbsr_inertia_in_frame(&frame, mbsr_inertia_particle(1.0)),
        mbsr_inertia_sum(mbsr_inertia_particle(1.0), mbsr_inertia_sphere(1000.0, 0.1)),
        mbsr_inertia_matrix(6, six_by_six),
        mbsr_inertia_function(unit_mass, NULL),
        mbsr_inertia_planar(1.0, com, 0.5)};
    number_of_inertias = (int)(sizeof inertia / sizeof *inertia);
    return inertia[k];
}

static void inertias_with_a_changed_field(void **state)
{
    (void)state;
    stock_inertia(0);
    int accepted = 0, total = 0;
    for (int k = 0; k < number_of_inertias; ++k) {
        changes c = {.wanted = -1};
        for (int done = -1; done < c.count; ++done) {
            mbsr_inertia inertia = stock_inertia(k);
            char what[64];
            c = (changes){.wanted = done};
            snprintf(what, sizeof what, "inertia %d (kind %d)", k, (int)inertia.kind);
            const int planar = inertia.kind == MBSR_INERTIA_PLANAR;
            change_inertia(&c, &inertia);
            if (done == c.count) break;
            mbsr_model *m = make_model(done % 2);
            const mbsr_body_def body =
                planar ? body_with(MBSR_GROUND, mbsr_joint_planar_revolute(flat, flat), inertia)
                       : body_with(1, mbsr_joint_universal(NULL, NULL, e_x, e_y), inertia);
            accepted += settle(m, mbsr_model_add_body(m, &body, NULL), what, c.name);
            ++total;
        }
    }
    print_message("%d of %d accepted\n", accepted, total);
    assert_true(accepted > total / 8 && accepted < total);
}

/* ---- what the texts say ---- */

static void texts_name_the_field_and_its_value(void **state)
{
    (void)state;
    mbsr_model *m = make_model(0);
    const mbsr_error *error = mbsr_model_error(m);
    mbsr_force_def force = mbsr_force_point_spring(0, NULL, 1, NULL, 1.0, 0.0, 0.0);
    force.name = "strut";
    force.bodies = 1;
    assert_refused(mbsr_model_add_force(m, &force, NULL), error, MBSR_ERR_VALUE, MBSR_NONE, 1,
                   "force 1 'strut' (point spring-damper): bodies is 1, must be 2");
    force = mbsr_force_applied(0, push, NULL);
    force.bodies = 0;
    assert_refused(mbsr_model_add_force(m, &force, NULL), error, MBSR_ERR_VALUE, MBSR_NONE, 1,
                   "force 1 (applied force): bodies is 0, must be 1");
    mbsr_body_def body = body_with(0, mbsr_joint_spherical(NULL, NULL), mbsr_inertia_zero());
    body.joint.option[0] = 0;
    assert_refused(mbsr_model_add_body(m, &body, NULL), error, MBSR_ERR_VALUE, 5, MBSR_NONE,
                   "body 5 'part': joint 'spherical': option[0] is 0, must be 1");
    body.joint = mbsr_joint_spherical(NULL, NULL);
    body.joint.params = 3;
    assert_refused(mbsr_model_add_body(m, &body, NULL), error, MBSR_ERR_VALUE, 5, MBSR_NONE,
                   "joint 'spherical': params is 3, must be 28");
    body.joint = mbsr_joint_free(NULL, NULL);
    body.joint.nq = 6;
    assert_refused(mbsr_model_add_body(m, &body, NULL), error, MBSR_ERR_VALUE, 5, MBSR_NONE,
                   "joint 'free': nq is 6, must be 7");
    body.joint = mbsr_joint_translational(NULL, NULL);
    memcpy(body.joint.param + 32, body.joint.param + 24, 4 * sizeof(double)); /* z becomes x */
    assert_refused(mbsr_model_add_body(m, &body, NULL), error, MBSR_ERR_VALUE, 5, MBSR_NONE,
                   "joint 'translational': the directions of its first three axes lie in a plane");
    mbsr_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(joints_with_a_changed_field),
        cmocka_unit_test(forces_with_a_changed_field),
        cmocka_unit_test(inertias_with_a_changed_field),
        cmocka_unit_test(texts_name_the_field_and_its_value),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
