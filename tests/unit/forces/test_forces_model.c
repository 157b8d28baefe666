/* Force elements in models with bodies in space: what is refused and how the text says it, and the
 * root as one of their ends.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "parts.h"

#include "recursion/data.h"

#include <stdio.h>

enum { BALL, ROD, FLAT, BEAD, ABSTRACT, GROUND = MBSR_GROUND };

/* ---- a model of two bodies in space, one in the plane, a point and one in general space ------ */

static int position(const mbsr_joint_args *args, double *p)
{
    for (int k = 0; k < args->d; ++k) p[k] = args->q[k];
    return 0;
}

static int jacobians(const mbsr_joint_args *args, double *K, double *H, double *J, double *kI)
{
    (void)K, (void)H, (void)kI;
    for (int k = 0; k < args->d; ++k) J[k * args->d + k] = -1.0;
    return 0;
}

static int bias(const mbsr_joint_args *args, double *kII)
{
    (void)args, (void)kII;
    return 0;
}

static const mbsr_joint_table general = {.version = MBSR_JOINT_TABLE_VERSION,
                                         .flags = MBSR_JOINT_UNIT_K,
                                         .name = "general",
                                         .position = position,
                                         .jacobians = jacobians,
                                         .bias = bias};

/* The root in screw motion, turning about z; in the plane the same without rise. */
static int screw(void *user, double t, double *p, double *V, double *A)
{
    static const double z[3] = {0, 0, 1};
    const int spatial = *(const int *)user;
    const mbsr_frame at = mbsr_frame_rotated(NULL, z, 2.0 * t);
    (void)A;
    if (spatial) {
        memcpy(p, at.R, sizeof at.R);
        p[11] = 0.5 * t;
        V[2] = 2.0;
        V[5] = 0.5;
    } else {
        p[0] = 0.5 * t;
        p[2] = 2.0 * t;
        V[0] = 0.5;
        V[2] = 2.0;
    }
    return 0;
}

static mbsr_model *make(void)
{
    const mbsr_planar_frame o = {0, 0, 0};
    const mbsr_joint joints[] = {mbsr_joint_free(NULL, NULL), mbsr_joint_spherical(NULL, NULL),
                                 mbsr_joint_planar_free(o, o), mbsr_joint_point_free(),
                                 mbsr_joint_custom(&general, 2, 2, NULL)};
    mbsr_model *m = NULL;
    assert_int_equal(mbsr_model_create(NULL, &m, NULL), 0);
    for (int k = 0; k < 5; ++k) {
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = k == ROD ? BALL : MBSR_GROUND;
        body.joint = joints[k];
        if (k < 2) body.inertia = mbsr_inertia_point_mass(1.0, (const double[3]){0, 0, 1});
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
    }
    return m;
}

/* ---- refusals -------------------------------------------------------------------------------- */

static void refused_when_added(mbsr_force_def def, const char *words)
{
    mbsr_model *m = make();
    char all[200];
    def.name = "pull";
    snprintf(all, sizeof all, "force 0 'pull'|%s", words);
    assert_refused(mbsr_model_add_force(m, &def, NULL), mbsr_model_error(m), MBSR_ERR_VALUE,
                   MBSR_NONE, 0, all);
    mbsr_model_destroy(m);
}

static void refused(mbsr_force_def def, int status, const char *words)
{
    mbsr_model *m = make();
    char all[200];
    def.name = "pull";
    snprintf(all, sizeof all, "force 0 'pull'|%s", words);
    assert_ok(mbsr_model_add_force(m, &def, NULL), mbsr_model_error(m));
    assert_refused(mbsr_model_finish(m), mbsr_model_error(m), status, MBSR_NONE, 0, all);
    mbsr_model_destroy(m);
}

static void accepted(mbsr_force_def def)
{
    mbsr_model *m = make();
    assert_ok(mbsr_model_add_force(m, &def, NULL), mbsr_model_error(m));
    assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
    mbsr_model_destroy(m);
}

static const double origin[3] = {0}, off[3] = {0.5, 0, 0}, above[3] = {0, 0, 0.25};

static mbsr_force_def spring(mbsr_spring law)
{
    return mbsr_force_spring(BALL, off, ROD, above, &law);
}

static void springs_refuse_what_they_cannot_be(void **state)
{
    (void)state;
    refused(spring((mbsr_spring){.stiffness = -1}), MBSR_ERR_VALUE,
            "point spring-damper|param[0] (stiffness) is -1, negative");
    refused(spring((mbsr_spring){.damping = -2}), MBSR_ERR_VALUE,
            "param[1] (damping) is -2, negative");
    refused(spring((mbsr_spring){.free_length = -3}), MBSR_ERR_VALUE,
            "param[2] (free_length) is -3, negative");
    refused(spring((mbsr_spring){.cubic = -4}), MBSR_ERR_VALUE, "param[3] (cubic) is -4, negative");
    refused(spring((mbsr_spring){.damping = 4, .one_sided = 1}), MBSR_ERR_VALUE,
            "param[1] (damping) is 4|cable without stiffness");
    accepted(spring((mbsr_spring){.damping = 4, .cubic = 1, .one_sided = 1}));
    accepted(spring((mbsr_spring){.damping = 4, .stiffness = 1, .one_sided = 1}));
    accepted(spring((mbsr_spring){.damping = 4}));
    const double bad[3] = {0, 0, NAN};
    refused_when_added(mbsr_force_spring(BALL, bad, ROD, off, &(mbsr_spring){.stiffness = 1}),
                       "param[6] (point_a[2]) is nan");
    refused_when_added(mbsr_force_spring(BALL, off, ROD, bad, &(mbsr_spring){.stiffness = 1}),
                       "param[9] (point_b[2]) is nan");
    refused_when_added(spring((mbsr_spring){.cubic = INFINITY}), "param[3] (cubic) is inf");
    refused(mbsr_force_point_spring(BEAD, above, ROD, off, 1, 1, 1), MBSR_ERR_VALUE,
            "point_a is (0, 0, 0.25), but body 3 is a POINT");
    refused(mbsr_force_point_spring(BALL, off, ABSTRACT, origin, 1, 1, 1), MBSR_ERR_SPACE,
            "body 4|GENERAL");
    refused(mbsr_force_point_spring(ROD, off, ROD, origin, 1, 1, 1), MBSR_ERR_ID,
            "both ends|body 1");
    accepted(mbsr_force_point_spring(FLAT, above, BEAD, origin, 1, 1, 1));
    refused(mbsr_force_axis_spring(BALL, GROUND, 0, 1, 1, 1), MBSR_ERR_SPACE,
            "axis spring-damper|body 0|SPATIAL");
    refused(mbsr_force_axis_spring(FLAT, GROUND, 0, -1, 1, 1), MBSR_ERR_VALUE,
            "param[0] (stiffness) is -1, negative");
    refused(mbsr_force_axis_spring(FLAT, GROUND, 0, 1, -1, 1), MBSR_ERR_VALUE,
            "param[1] (damping) is -1, negative");
    accepted(mbsr_force_axis_spring(ABSTRACT, GROUND, 1, 1, 1, -1));
}

static void bushings_refuse_what_they_cannot_be(void **state)
{
    (void)state;
    double ones[6] = {1, 1, 1, 1, 1, 1};
    mbsr_frame frame = mbsr_frame_identity();
    refused(mbsr_force_bushing(BALL, NULL, BALL, NULL, ones, ones), MBSR_ERR_ID,
            "bushing|both ends|body 0");
    refused(mbsr_force_bushing(BALL, NULL, FLAT, NULL, ones, ones), MBSR_ERR_SPACE,
            "body 2|SPATIAL");
    refused(mbsr_force_bushing(BEAD, NULL, BALL, NULL, ones, ones), MBSR_ERR_SPACE,
            "body 3|SPATIAL");
    refused(mbsr_force_bushing(GROUND, NULL, ABSTRACT, NULL, ones, ones), MBSR_ERR_SPACE,
            "body 4|SPATIAL");
    for (int k = 0; k < 6; ++k) {
        char words[80];
        double one[6] = {1, 1, 1, 1, 1, 1};
        one[k] = -0.5;
        snprintf(words, sizeof words, "(stiffness[%d]) is -0.5, negative", k);
        refused(mbsr_force_bushing(BALL, NULL, ROD, NULL, one, ones), MBSR_ERR_VALUE, words);
        snprintf(words, sizeof words, "(damping[%d]) is -0.5, negative", k);
        refused(mbsr_force_bushing(BALL, NULL, ROD, NULL, ones, one), MBSR_ERR_VALUE, words);
    }
    frame.R[8] = 1.0 + 1e-5;
    refused(mbsr_force_bushing(BALL, &frame, ROD, NULL, ones, ones), MBSR_ERR_VALUE,
            "frame A|orthonormal|2.0");
    refused(mbsr_force_bushing(BALL, NULL, ROD, &frame, ones, ones), MBSR_ERR_VALUE, "frame B|2.0");
    frame.R[8] = 1.0 + 1e-8;
    accepted(mbsr_force_bushing(BALL, &frame, ROD, &frame, ones, ones));
    frame.R[8] = -1.0;
    refused(mbsr_force_bushing(BALL, NULL, ROD, &frame, ones, ones), MBSR_ERR_VALUE,
            "frame B|right-handed");
    frame = (mbsr_frame){.x = {1, 2, 3}};
    refused(mbsr_force_bushing(BALL, &frame, ROD, NULL, ones, ones), MBSR_ERR_VALUE, "frame A");
    frame.R[1] = NAN;
    refused_when_added(mbsr_force_bushing(BALL, &frame, ROD, NULL, ones, ones),
                       "(frame A, R[1]) is nan");
    frame = mbsr_frame_at(0, INFINITY, 0);
    refused_when_added(mbsr_force_bushing(BALL, NULL, ROD, &frame, ones, ones),
                       "(frame B, x[1]) is inf");
}

static mbsr_contact right_contact(void)
{
    return (mbsr_contact){.radius = 0.5,
                          .normal = {0, 0, 1},
                          .stiffness = 10,
                          .exponent = 1.5,
                          .friction = 0.5,
                          .slip = 0.1};
}

static void contacts_refuse_what_they_cannot_be(void **state)
{
    (void)state;
    mbsr_contact c = right_contact();
    accepted(mbsr_force_contact(BALL, GROUND, &c));
    accepted(mbsr_force_contact(BALL, ROD, &c));
    refused(mbsr_force_contact(GROUND, BALL, &c), MBSR_ERR_ID, "contact|ground");
    accepted(mbsr_force_contact(FLAT, GROUND, &c));
    accepted(mbsr_force_contact(BEAD, FLAT, &c));
    refused(mbsr_force_contact(BALL, ABSTRACT, &c), MBSR_ERR_SPACE, "body 4|GENERAL");
    refused(mbsr_force_contact(ABSTRACT, GROUND, &c), MBSR_ERR_SPACE, "body 4|GENERAL");
    c.centre[0] = c.point[1] = 0.5;
    refused(mbsr_force_contact(BEAD, FLAT, &c), MBSR_ERR_VALUE,
            "centre is (0.5, 0, 0)|body 3|POINT");
    refused(mbsr_force_contact(FLAT, BEAD, &c), MBSR_ERR_VALUE,
            "point is (0, 0.5, 0)|body 3|POINT");
    c = right_contact();
    refused(mbsr_force_contact(BALL, BALL, &c), MBSR_ERR_ID, "both ends|body 0");
    const struct {
        double *field, value;
        const char *words;
    } wrong[] = {
        {&c.radius, 0.0, "(radius) is 0, not positive"},
        {&c.radius, -1.0, "(radius) is -1, not positive"},
        {&c.normal[2], 0.0, "normal is (0, 0, 0)"},
        {&c.stiffness, -1.0, "(stiffness) is -1, negative"},
        {&c.exponent, 0.99, "(exponent) is 0.99, must be at least 1"},
        {&c.damping, -1.0, "(damping) is -1, negative"},
        {&c.friction, -1.0, "(friction) is -1, negative"},
        {&c.slip, 0.0, "(slip) is 0, not positive"},
        {&c.creep, -0.1, "(creep) is -0.1, negative"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
        c = right_contact();
        *wrong[k].field = wrong[k].value;
        refused(mbsr_force_contact(BALL, GROUND, &c), MBSR_ERR_VALUE, wrong[k].words);
    }
    c = right_contact();
    c.friction = c.slip = 0.0;
    accepted(mbsr_force_contact(BALL, GROUND, &c));
    c.centre[1] = NAN;
    refused_when_added(mbsr_force_contact(BALL, GROUND, &c), "(centre[1]) is nan");
    c = right_contact();
    c.normal[0] = NAN;
    refused_when_added(mbsr_force_contact(BALL, GROUND, &c), "(normal[0]) is nan");
}

static mbsr_friction right_friction(void)
{
    return (mbsr_friction){.coefficient = 0.5, .viscous = 1.0, .slip = 0.1, .load = 3.0};
}

static void frictions_refuse_what_they_cannot_be(void **state)
{
    (void)state;
    mbsr_friction c = right_friction();
    accepted(mbsr_force_point_friction(GROUND, off, BALL, &c));
    accepted(mbsr_force_point_friction(BEAD, origin, FLAT, &c));
    refused(mbsr_force_point_friction(BEAD, off, FLAT, &c), MBSR_ERR_VALUE,
            "point friction|point is (0.5, 0, 0)|body 3|POINT");
    refused(mbsr_force_point_friction(BALL, off, ABSTRACT, &c), MBSR_ERR_SPACE, "body 4|GENERAL");
    refused(mbsr_force_point_friction(ABSTRACT, off, BALL, &c), MBSR_ERR_SPACE, "body 4|GENERAL");
    refused(mbsr_force_point_friction(BALL, off, BALL, &c), MBSR_ERR_ID, "both ends|body 0");
    const struct {
        double *field, value;
        const char *words;
    } wrong[] = {
        {&c.coefficient, -1.0, "(coefficient) is -1, negative"},
        {&c.viscous, -1.0, "(viscous) is -1, negative"},
        {&c.slip, 0.0, "(slip) is 0, not positive"},
        {&c.creep, -0.1, "(creep) is -0.1, negative"},
        {&c.creep, 0.1, "(creep) is 0.1, but there is no axle"},
        {&c.load, -2.0, "(load) is -2, negative"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
        c = right_friction();
        *wrong[k].field = wrong[k].value;
        refused(mbsr_force_point_friction(BALL, off, GROUND, &c), MBSR_ERR_VALUE, wrong[k].words);
    }
    c = right_friction();
    c.normal[0] = c.axle[2] = 1.0;
    refused_when_added(mbsr_force_point_friction(BALL, off, ROD, &c), "a normal and an axle");
    c.normal[0] = 0.0;
    c.creep = 0.1;
    accepted(mbsr_force_point_friction(BALL, off, ROD, &c));
    c.axle[2] = INFINITY;
    refused_when_added(mbsr_force_point_friction(BALL, off, ROD, &c), "(direction[2]) is inf");

    mbsr_bearing law = {.torque = 1.0, .viscous = 1.0, .slip = 1.0};
    accepted(mbsr_force_bearing_friction(FLAT, BALL, &law));
    accepted(mbsr_force_bearing_friction(GROUND, BALL, &law));
    refused(mbsr_force_bearing_friction(BALL, BEAD, &law), MBSR_ERR_SPACE,
            "bearing friction|body 3|PLANAR or SPATIAL");
    refused(mbsr_force_bearing_friction(FLAT, ABSTRACT, &law), MBSR_ERR_SPACE, "body 4");
    refused(mbsr_force_bearing_friction(FLAT, FLAT, &law), MBSR_ERR_ID, "both ends");
    law.torque = -1.0;
    refused(mbsr_force_bearing_friction(FLAT, BALL, &law), MBSR_ERR_VALUE,
            "(torque) is -1, negative");
    law = (mbsr_bearing){.viscous = -2.0, .slip = 1.0};
    refused(mbsr_force_bearing_friction(FLAT, BALL, &law), MBSR_ERR_VALUE,
            "(viscous) is -2, negative");
    law = (mbsr_bearing){.torque = 1.0};
    refused(mbsr_force_bearing_friction(FLAT, BALL, &law), MBSR_ERR_VALUE,
            "(slip) is 0, not positive");
    law = (mbsr_bearing){.slip = 1.0, .axis = {0.0, NAN, 0.0}};
    refused_when_added(mbsr_force_bearing_friction(FLAT, BALL, &law), "(axis[1]) is nan");
    law.axis[1] = 1.0;
    mbsr_force_def changed = mbsr_force_bearing_friction(FLAT, BALL, &law);
    changed.param[1] = 0.0;
    refused_when_added(changed, "direction is (0, 0, 0)");

    accepted(mbsr_force_axis_friction(ABSTRACT, GROUND, 1, 1, 1));
    refused(mbsr_force_axis_friction(BALL, GROUND, 0, 1, 1), MBSR_ERR_SPACE,
            "axis friction|body 0|SPATIAL");
    refused(mbsr_force_axis_friction(FLAT, BEAD, 2, 1, 1), MBSR_ERR_VALUE, "axis is 2|body 3");
    refused(mbsr_force_axis_friction(FLAT, GROUND, 0, -1, 1), MBSR_ERR_VALUE,
            "(force) is -1, negative");
    refused(mbsr_force_axis_friction(FLAT, GROUND, 0, 1, 0), MBSR_ERR_VALUE,
            "(slip) is 0, not positive");
}

static void bushings_in_the_plane_refuse_what_they_cannot_be(void **state)
{
    (void)state;
    const mbsr_planar_frame o = {0, 0, 0}, bad = {0, NAN, 0};
    const double semidefinite[9] = {4, 2, 0, 2, 1, 0, 0, 0, 0},
                 skew[9] = {4, 2, 0, 1, 4, 0, 0, 0, 1}, indefinite[9] = {4, 0, 3, 0, 1, 0, 3, 0, 2},
                 negative[9] = {1, 0, 0, 0, 1, 0, 0, 0, -3},
                 beside[9] = {1, 0, 0, 0, 0, 1e-9, 0, 1e-9, 1},
                 /* each pair may be, the three may not */
        three[9] = {1, -0.9, -0.9, -0.9, 1, -0.9, -0.9, -0.9, 1};
    accepted(mbsr_force_planar_bushing(FLAT, o, GROUND, o, semidefinite, NULL));
    accepted(mbsr_force_planar_bushing(GROUND, o, FLAT, o, NULL, semidefinite));
    refused(mbsr_force_planar_bushing(BALL, o, FLAT, o, NULL, NULL), MBSR_ERR_SPACE,
            "planar bushing|body 0|PLANAR");
    refused(mbsr_force_planar_bushing(FLAT, o, BEAD, o, NULL, NULL), MBSR_ERR_SPACE,
            "body 3|PLANAR");
    refused(mbsr_force_planar_bushing(FLAT, o, FLAT, o, NULL, NULL), MBSR_ERR_ID, "both ends");
    refused_when_added(mbsr_force_planar_bushing(FLAT, o, GROUND, bad, NULL, NULL), "(B.y) is nan");
    refused_when_added(mbsr_force_planar_bushing(FLAT, o, GROUND, o, skew, NULL),
                       "stiffness is not symmetric: (0,1) is 1, (1,0) is 2");
    refused_when_added(mbsr_force_planar_bushing(FLAT, o, GROUND, o, NULL, negative),
                       "damping(2,2) is -3, negative");
    const double *const wrong[] = {indefinite, beside, three};
    for (int k = 0; k < 3; ++k) {
        refused_when_added(mbsr_force_planar_bushing(FLAT, o, GROUND, o, wrong[k], NULL),
                           "stiffness is not positive semi-definite");
    }
}

static int no_value(void *user, double t, int n, double *value)
{
    (void)user, (void)t, (void)n, (void)value;
    return 0;
}

static void elements_on_joints_refuse_what_they_cannot_be(void **state)
{
    (void)state;
    refused(mbsr_force_joint_spring(FLAT, 0, -1, 0, 0), MBSR_ERR_VALUE,
            "joint spring-damper|(stiffness) is -1, negative");
    refused(mbsr_force_joint_spring(FLAT, 0, 1, -1, 0), MBSR_ERR_VALUE,
            "(damping) is -1, negative");
    refused(mbsr_force_joint_spring(ROD, 0, 1, 1, 0), MBSR_ERR_SPACE, "body 1|nq = 4, n = 3");
    refused(mbsr_force_joint_stop(ROD, 0, 1, 2, 1, 0), MBSR_ERR_SPACE, "body 1|nq = 4, n = 3");
    refused(mbsr_force_joint_stop(FLAT, 3, 1, 2, 1, 0), MBSR_ERR_VALUE, "coordinate is 3|body 2");
    refused(mbsr_force_joint_stop(FLAT, 0, 2, 2, 1, 0), MBSR_ERR_VALUE,
            "joint stop|lower is 2, not below upper, 2");
    refused(mbsr_force_joint_stop(FLAT, 0, 3, 2, 1, 0), MBSR_ERR_VALUE,
            "lower is 3, not below upper, 2");
    refused(mbsr_force_joint_stop(FLAT, 0, 1, 2, -1, 0), MBSR_ERR_VALUE,
            "(stiffness) is -1, negative");
    refused(mbsr_force_joint_stop(FLAT, 0, 1, 2, 1, -1), MBSR_ERR_VALUE,
            "(damping) is -1, negative");
    refused(mbsr_force_joint_stop(FLAT, 0, 1, 2, 0, 1), MBSR_ERR_VALUE,
            "(damping) is 1|stop without stiffness");
    refused_when_added(mbsr_force_joint_stop(FLAT, 0, NAN, 2, 1, 1), "(lower) is nan");
    refused_when_added(mbsr_force_joint_stop(FLAT, 0, 1, NAN, 1, 1), "(upper) is nan");
    refused_when_added(mbsr_force_joint_stop(FLAT, 0, INFINITY, INFINITY, 1, 1), "(lower) is inf");
    refused_when_added(mbsr_force_joint_stop(FLAT, 0, 1, -INFINITY, 1, 1), "(upper) is -inf");
    accepted(mbsr_force_joint_stop(FLAT, 0, 5, INFINITY, 1, 1));
    accepted(mbsr_force_joint_stop(FLAT, 0, -INFINITY, -5, 1, 1));
    refused(mbsr_force_joint_friction(FLAT, 0, -1, 1), MBSR_ERR_VALUE,
            "joint friction|(force) is -1, negative");
    refused(mbsr_force_joint_friction(FLAT, 0, 1, 0), MBSR_ERR_VALUE, "(slip) is 0, not positive");
    refused(mbsr_force_joint_friction(ROD, 3, 1, 1), MBSR_ERR_VALUE, "coordinate is 3|body 1");
    refused(mbsr_force_joint_friction(ROD, -1, 1, 1), MBSR_ERR_VALUE, "coordinate is -1|body 1");
    accepted(mbsr_force_joint_friction(ROD, 2, 1, 1));
    refused(mbsr_force_joint_friction(GROUND, 0, 1, 1), MBSR_ERR_VALUE, "coordinate is 0");
}

static void wrenches_refuse_what_they_cannot_be(void **state)
{
    (void)state;
    refused(mbsr_force_wrench(GROUND, off, 0, no_value, NULL), MBSR_ERR_ID, "ground");
    refused(mbsr_force_wrench(FLAT, off, 0, no_value, NULL), MBSR_ERR_SPACE, "body 2|SPATIAL");
    refused(mbsr_force_wrench(ABSTRACT, off, 0, no_value, NULL), MBSR_ERR_SPACE, "body 4|SPATIAL");
    refused_when_added(mbsr_force_wrench(BALL, (const double[3]){0, NAN, 0}, 0, no_value, NULL),
                       "(point[1]) is nan");
    accepted(mbsr_force_wrench(BALL, off, 0, no_value, NULL));
    mbsr_model *m = make();
    const mbsr_force_def none = mbsr_force_wrench(BALL, off, 0, NULL, NULL);
    assert_refused(mbsr_model_add_force(m, &none, NULL), mbsr_model_error(m), MBSR_ERR_NULL,
                   MBSR_NONE, 0, "force 0|wrench|function is NULL");
    mbsr_model_destroy(m);
}

/* Every stock element names its parameters, and none beyond them. */
static void unused_parameters_have_no_name(void **state)
{
    (void)state;
    const double ones[6] = {1, 1, 1, 1, 1, 1};
    const mbsr_contact c = right_contact();
    const mbsr_friction friction = right_friction();
    const mbsr_bearing bearing = {.torque = 1, .viscous = 1, .slip = 1};
    const mbsr_planar_frame o = {0, 0, 0};
    const mbsr_force_def list[] = {mbsr_force_gravity(0, 0, -9),
                                   mbsr_force_axis_spring(FLAT, BEAD, 0, 1, 1, 1),
                                   spring((mbsr_spring){.stiffness = 1}),
                                   mbsr_force_bushing(BALL, NULL, ROD, NULL, ones, ones),
                                   mbsr_force_joint_spring(FLAT, 0, 1, 1, 1),
                                   mbsr_force_joint_stop(FLAT, 0, 1, 2, 1, 1),
                                   mbsr_force_joint_friction(FLAT, 0, 1, 1),
                                   mbsr_force_wrench(BALL, off, 0, no_value, NULL),
                                   mbsr_force_contact(BALL, GROUND, &c),
                                   mbsr_force_axis_friction(FLAT, BEAD, 0, 1, 1),
                                   mbsr_force_point_friction(FLAT, off, BEAD, &friction),
                                   mbsr_force_bearing_friction(FLAT, BALL, &bearing),
                                   mbsr_force_planar_bushing(FLAT, o, GROUND, o, NULL, NULL)};
    static const int used[] = {3, 3, 10, 32, 4, 4, 2, 3, 16, 2, 11, 6, 24};
    for (int l = 0; l < 13; ++l) {
        for (int k = 0; k < MBSR_FORCE_PARAMS; ++k)
            assert_int_equal(list[l].table->parameter(k)[0] != 0, k < used[l]);
        for (int k = used[l]; k < MBSR_FORCE_PARAMS; ++k) assert_close(list[l].param[k], 0.0, 0.0);
        accepted(list[l]);
    }
}

/* ---- the root as an end ---------------------------------------------------------------------- */

static void a_root_in_general_space_has_no_points(void **state)
{
    (void)state;
    int spatial = 0;
    const double ones[6] = {1, 1, 1, 1, 1, 1};
    const mbsr_contact c = right_contact();
    const mbsr_force_def list[] = {mbsr_force_point_spring(BALL, off, GROUND, off, 1, 1, 1),
                                   mbsr_force_bushing(BALL, NULL, GROUND, NULL, ones, ones),
                                   mbsr_force_contact(BALL, GROUND, &c)};
    for (int k = 0; k < 3; ++k) {
        mbsr_model *m = NULL;
        mbsr_model_def def = mbsr_default_model_def();
        def.root = mbsr_root_moving(MBSR_SPACE_GENERAL, 3, 3, screw, &spatial);
        assert_int_equal(mbsr_model_create(&def, &m, NULL), 0);
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_custom(&general, 6, 6, NULL);
        body.joint.space = MBSR_SPACE_SPATIAL;
        body.joint.np = MBSR_POSE_SIZE;
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_add_force(m, list + k, NULL), mbsr_model_error(m));
        assert_refused(mbsr_model_finish(m), mbsr_model_error(m), MBSR_ERR_SPACE, MBSR_NONE, 0,
                       "body -1");
        mbsr_model_destroy(m);
    }
}

/* Elements between a body and a moving root, against the same called by hand. */
static void elements_on_a_moving_root_follow_it(void **state)
{
    (void)state;
    const double stiffness[6] = {1, 2, 3, 4, 5, 6}, damping[6] = {6, 5, 4, 3, 2, 1};
    const mbsr_frame A = mbsr_frame_at(0.1, 0.2, 0.3);
    mbsr_contact c = right_contact();
    c.radius = 5.0;
    const mbsr_force_def list[] = {mbsr_force_point_spring(BALL, off, GROUND, above, 10, 3, 0.2),
                                   mbsr_force_bushing(GROUND, &A, BALL, NULL, stiffness, damping),
                                   mbsr_force_contact(BALL, GROUND, &c)};
    for (int spatial = 0; spatial < 2; ++spatial) {
        const mbsr_space space = spatial ? MBSR_SPACE_SPATIAL : MBSR_SPACE_PLANAR;
        mbsr_model *m = NULL;
        mbsr_data *d = NULL;
        mbsr_model_def def = mbsr_default_model_def();
        def.root = mbsr_root_moving(space, spatial ? 6 : 3, spatial ? 12 : 3, screw, &spatial);
        assert_int_equal(mbsr_model_create(&def, &m, NULL), 0);
        mbsr_body_def body = mbsr_default_body_def();
        body.joint = mbsr_joint_free(NULL, NULL);
        assert_ok(mbsr_model_add_body(m, &body, NULL), mbsr_model_error(m));
        for (int k = 0; k < 3; ++k)
            assert_ok(mbsr_model_add_force(m, list + k, NULL), mbsr_model_error(m));
        assert_ok(mbsr_model_finish(m), mbsr_model_error(m));
        assert_int_equal(mbsr_data_create(m, &d, NULL), 0);
        const double q[7] = {0.5, 0.1, -0.4, 0.7, 0.3, 0.9, 0.2},
                     u[6] = {0.4, -0.3, 0.2, 0.6, -0.7, 0.1};
        test_part part[2] = {test_part_make(MBSR_SPACE_SPATIAL), test_part_make(space)};
        double sum[6] = {0};
        assert_int_equal(mbsr_stage_positions(m, d, 0.7, q), 0);
        assert_int_equal(mbsr_stage_velocities(m, d, u), 0);
        assert_int_equal(mbsr_body_pose(m, d, 0, part[0].p), 0);
        assert_int_equal(mbsr_body_twist(m, d, 0, part[0].V), 0);
        assert_int_equal(mbsr_body_pose(m, d, MBSR_GROUND, part[1].p), 0);
        assert_int_equal(mbsr_body_twist(m, d, MBSR_GROUND, part[1].V), 0);
        assert_close(part[1].V[2], 2.0, 0.0);
        for (int k = 0; k < 3; ++k) {
            test_part two[2] = {part[k == 1], part[k != 1]};
            double E, P;
            assert_int_equal(mbsr_force_power(m, d, k, &E, &P), 0);
            assert_close(E, test_value(list + k, two, 2, TEST_ENERGY), 1e-14);
            assert_close(P, test_value(list + k, two, 2, TEST_DISSIPATION), 1e-14);
            assert_int_equal(test_ask(list + k, two, 2, TEST_FORCES, NULL), 0);
            assert_less(0.1, test_largest(6, two[k == 1].f));
            for (int i = 0; i < 6; ++i) sum[i] += two[k == 1].f[i];
        }
        assert_int_equal(mbsr_stage_forces(m, d, NULL), 0);
        for (int i = 0; i < 6; ++i)
            assert_close(d->f[m->body[1].v + (size_t)i], sum[i], 1e-13 * (1.0 + fabs(sum[i])));
        mbsr_data_destroy(d);
        mbsr_model_destroy(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(springs_refuse_what_they_cannot_be),
        cmocka_unit_test(bushings_refuse_what_they_cannot_be),
        cmocka_unit_test(contacts_refuse_what_they_cannot_be),
        cmocka_unit_test(frictions_refuse_what_they_cannot_be),
        cmocka_unit_test(bushings_in_the_plane_refuse_what_they_cannot_be),
        cmocka_unit_test(elements_on_joints_refuse_what_they_cannot_be),
        cmocka_unit_test(wrenches_refuse_what_they_cannot_be),
        cmocka_unit_test(unused_parameters_have_no_name),
        cmocka_unit_test(a_root_in_general_space_has_no_points),
        cmocka_unit_test(elements_on_a_moving_root_follow_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
