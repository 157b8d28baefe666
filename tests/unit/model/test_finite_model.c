/* Constructors and amendments: a model with numbers that are not finite, or that overflow, is
 * refused or gives no numbers that are not finite.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "finite.h"

#include <mbsrank/driver.h>
#include <mbsrank/verify.h>

enum { OTHER = 1u << FINITE_OTHER, MOST = 24 };

/* One constructor of a joint, an inertia or a force element, or an amendment, as a function of its
 * numbers. */
typedef struct part {
    const char *function;
    int n;
    double good[MOST];
    mbsr_joint (*joint)(const double *x);
    mbsr_inertia (*inertia)(const double *x);
    mbsr_force_def (*force)(const double *x);
    int (*amend)(mbsr_model *m, const double *x);
    bool planar;
} part;

static const part *current;
static mbsr_error last;

static const mbsr_error *last_error(const finite_subject *s)
{
    (void)s;
    return &last;
}

/* ---- joints ---- */

static mbsr_planar_frame planar_frame(const double *x)
{
    return (mbsr_planar_frame){x[0], x[1], x[2]};
}

static mbsr_frame frame(const double *x)
{
    return mbsr_frame_rotated(x, (double[]){0.0, 0.6, 0.8}, x[3]);
}

static mbsr_joint planar_weld(const double *x)
{
    return mbsr_joint_planar_weld(planar_frame(x), planar_frame(x + 3));
}

static mbsr_joint planar_revolute(const double *x)
{
    return mbsr_joint_planar_revolute(planar_frame(x), planar_frame(x + 3));
}

static mbsr_joint planar_prismatic(const double *x)
{
    return mbsr_joint_planar_prismatic(planar_frame(x), planar_frame(x + 3));
}

static mbsr_joint planar_pin_slot(const double *x)
{
    return mbsr_joint_planar_pin_slot(planar_frame(x), planar_frame(x + 3));
}

static mbsr_joint planar_free(const double *x)
{
    return mbsr_joint_planar_free(planar_frame(x), planar_frame(x + 3));
}

static mbsr_joint planar(const double *x)
{
    return mbsr_joint_planar(planar_frame(x), planar_frame(x + 3), MBSR_X, 0, NULL, NULL);
}

static mbsr_joint weld(const double *x)
{
    const mbsr_frame A = frame(x), B = frame(x + 4);
    return mbsr_joint_weld(&A, &B);
}

static mbsr_joint revolute(const double *x)
{
    const mbsr_frame A = frame(x), B = frame(x + 4);
    return mbsr_joint_revolute(&A, &B, x + 8);
}

static mbsr_joint prismatic(const double *x)
{
    const mbsr_frame A = frame(x), B = frame(x + 4);
    return mbsr_joint_prismatic(&A, &B, x + 8);
}

static mbsr_joint screw(const double *x)
{
    const mbsr_frame A = frame(x), B = frame(x + 4);
    return mbsr_joint_screw(&A, &B, x + 8, x[11]);
}

static mbsr_joint cylindrical(const double *x)
{
    const mbsr_frame A = frame(x), B = frame(x + 4);
    return mbsr_joint_cylindrical(&A, &B, x + 8);
}

static mbsr_joint universal(const double *x)
{
    const mbsr_frame A = frame(x), B = frame(x + 4);
    return mbsr_joint_universal(&A, &B, x + 8, x + 11);
}

static mbsr_joint in_plane(const double *x)
{
    const mbsr_frame A = frame(x), B = frame(x + 4);
    return mbsr_joint_in_plane(&A, &B);
}

static mbsr_joint translational(const double *x)
{
    const mbsr_frame A = frame(x), B = frame(x + 4);
    return mbsr_joint_translational(&A, &B);
}

static mbsr_joint spherical(const double *x)
{
    const mbsr_frame A = frame(x), B = frame(x + 4);
    return mbsr_joint_spherical(&A, &B);
}

/* Without numbers, for elements that need one. */
static mbsr_joint plain_spherical(const double *x)
{
    (void)x;
    return mbsr_joint_spherical(NULL, NULL);
}

static mbsr_joint free_joint(const double *x)
{
    const mbsr_frame A = frame(x), B = frame(x + 4);
    return mbsr_joint_free(&A, &B);
}

static mbsr_joint compound(const double *x)
{
    const mbsr_frame A = frame(x), B = frame(x + 4);
    const mbsr_axis axes[2] = {{MBSR_AXIS_ROTATION, {x[8], x[9], x[10]}, 0.0, 0},
                               {MBSR_AXIS_SCREW, {x[11], x[12], x[13]}, x[14], 0}};
    return mbsr_joint_compound(&A, &B, 2, axes, NULL, NULL);
}

/* ---- inertias ---- */

static mbsr_inertia particle(const double *x)
{
    return mbsr_inertia_particle(x[0]);
}

static mbsr_inertia planar_inertia(const double *x)
{
    return mbsr_inertia_planar(x[0], x + 1, x[3]);
}

static mbsr_inertia rigid(const double *x)
{
    return mbsr_inertia_rigid(x[0], x + 1, x + 4);
}

static mbsr_inertia rigid_unchecked(const double *x)
{
    return mbsr_inertia_rigid_unchecked(x[0], x + 1, x + 4);
}

static mbsr_inertia rigid_about(const double *x)
{
    const mbsr_frame at = frame(x + 10);
    return mbsr_inertia_rigid_about(x[0], x + 1, &at, x + 4);
}

static mbsr_inertia point_mass(const double *x)
{
    return mbsr_inertia_point_mass(x[0], x + 1);
}

static mbsr_inertia rod(const double *x)
{
    return mbsr_inertia_rod(x[0], x + 1, x + 4);
}

static mbsr_inertia box(const double *x)
{
    return mbsr_inertia_box(x[0], x + 1);
}

static mbsr_inertia sphere(const double *x)
{
    return mbsr_inertia_sphere(x[0], x[1]);
}

static mbsr_inertia cylinder(const double *x)
{
    return mbsr_inertia_cylinder(x[0], x[1], x[2]);
}

static mbsr_inertia capsule(const double *x)
{
    return mbsr_inertia_capsule(x[0], x[1], x[2]);
}

static mbsr_inertia moved(const double *x)
{
    const mbsr_frame at = frame(x + 10);
    return mbsr_inertia_in_frame(&at, mbsr_inertia_rigid(x[0], x + 1, x + 4));
}

static mbsr_inertia sum(const double *x)
{
    return mbsr_inertia_sum(mbsr_inertia_point_mass(x[0], x + 1),
                            mbsr_inertia_point_mass(x[4], x + 5));
}

static mbsr_inertia matrix(const double *x)
{
    static double M[9];
    for (int k = 0; k < 3; ++k) M[4 * k] = x[k];
    M[1] = M[3] = x[3];
    return mbsr_inertia_matrix(3, M);
}

/* ---- force elements; on body 0 and the ground ---- */

static mbsr_force_def gravity(const double *x)
{
    return mbsr_force_gravity(x[0], x[1], x[2]);
}

static mbsr_force_def axis_spring(const double *x)
{
    return mbsr_force_axis_spring(0, MBSR_GROUND, 0, x[0], x[1], x[2]);
}

static mbsr_force_def axis_friction(const double *x)
{
    return mbsr_force_axis_friction(0, MBSR_GROUND, 0, x[0], x[1]);
}

static mbsr_force_def planar_bushing(const double *x)
{
    const mbsr_planar_frame A = {x[0], x[1], x[2]}, B = {x[3], x[4], x[5]};
    return mbsr_force_planar_bushing(0, A, MBSR_GROUND, B, x + 6, x + 15);
}

static mbsr_force_def point_friction(const double *x)
{
    const mbsr_friction law = {.coefficient = x[3],
                               .viscous = x[4],
                               .slip = x[5],
                               .creep = x[6],
                               .load = x[7],
                               .axle = {x[8], x[9], x[10]}};
    return mbsr_force_point_friction(0, x, MBSR_GROUND, &law);
}

static mbsr_force_def surface_friction(const double *x)
{
    const mbsr_friction law = {
        .coefficient = x[3], .slip = x[4], .load = x[5], .normal = {x[6], x[7], x[8]}};
    return mbsr_force_point_friction(0, x, MBSR_GROUND, &law);
}

static mbsr_force_def bearing_friction(const double *x)
{
    const mbsr_bearing law = {
        .axis = {x[0], x[1], x[2]}, .torque = x[3], .viscous = x[4], .slip = x[5]};
    return mbsr_force_bearing_friction(0, MBSR_GROUND, &law);
}

static mbsr_force_def spring(const double *x)
{
    const mbsr_spring law = {
        .stiffness = x[0], .cubic = x[1], .damping = x[2], .free_length = x[3]};
    return mbsr_force_spring(0, x + 4, MBSR_GROUND, x + 7, &law);
}

static mbsr_force_def point_spring(const double *x)
{
    return mbsr_force_point_spring(0, x + 4, MBSR_GROUND, x + 7, x[0], x[1], x[2]);
}

static mbsr_force_def bushing(const double *x)
{
    const mbsr_frame A = frame(x + 12);
    return mbsr_force_bushing(0, &A, MBSR_GROUND, NULL, x, x + 6);
}

static mbsr_force_def joint_spring(const double *x)
{
    return mbsr_force_joint_spring(0, 0, x[0], x[1], x[2]);
}

static mbsr_force_def joint_cubic_spring(const double *x)
{
    return mbsr_force_joint_cubic_spring(0, 0, x[0], x[1], x[2], x[3]);
}

static mbsr_force_def joint_rotation_spring(const double *x)
{
    return mbsr_force_joint_rotation_spring(0, x, x + 3, x + 6);
}

static mbsr_force_def joint_stop(const double *x)
{
    return mbsr_force_joint_stop(0, 0, x[0], x[1], x[2], x[3]);
}

static mbsr_force_def joint_friction(const double *x)
{
    return mbsr_force_joint_friction(0, 0, x[0], x[1]);
}

static int no_force(void *user, double t, int n, double *value)
{
    (void)user, (void)t;
    for (int k = 0; k < n; ++k) value[k] = 0.5;
    return 0;
}

static mbsr_force_def wrench(const double *x)
{
    return mbsr_force_wrench(0, x, 1, no_force, NULL);
}

static mbsr_force_def contact(const double *x)
{
    const mbsr_contact with = {.centre = {x[0], x[1], x[2]},
                               .radius = x[3],
                               .point = {x[4], x[5], x[6]},
                               .normal = {x[7], x[8], x[9]},
                               .stiffness = x[10],
                               .exponent = x[11],
                               .damping = x[12],
                               .friction = x[13],
                               .slip = x[14],
                               .creep = x[15]};
    return mbsr_force_contact(0, MBSR_GROUND, &with);
}

static int apply(void *user, double t, int n, double *value)
{
    (void)t;
    for (int k = 0; k < n; ++k) value[k] = *(const double *)user;
    return 0;
}

static double applied_value;

static mbsr_force_def applied(const double *x)
{
    applied_value = x[0];
    return mbsr_force_applied(0, apply, &applied_value);
}

static mbsr_force_def joint_applied(const double *x)
{
    applied_value = x[0];
    return mbsr_force_joint_applied(0, apply, &applied_value);
}

/* ---- amendments ---- */

static int regularise(mbsr_model *m, const double *x)
{
    double M[36] = {0.0};
    for (int k = 0; k < 6; ++k) M[7 * k] = x[k];
    return mbsr_model_regularise(m, 0, 6, M);
}

static int armature(mbsr_model *m, const double *x)
{
    return mbsr_model_armature(m, 0, 1, x);
}

static int lock(mbsr_model *m, const double *x)
{
    return mbsr_model_lock(m, 0, 0, x[0]);
}

#define PLANE                                                                                      \
    {                                                                                              \
        0.1, 0.2, 0.3, -0.2, 0.4, 0.1                                                              \
    }
#define SPACE 0.1, 0.2, 0.3, 0.4, -0.2, 0.3, 0.1, 0.5

static const part parts[] = {
    {"mbsr_joint_planar", 6, PLANE, .joint = planar, .planar = true},
    {"mbsr_joint_planar_weld", 6, PLANE, .joint = planar_weld, .planar = true},
    {"mbsr_joint_planar_revolute", 6, PLANE, .joint = planar_revolute, .planar = true},
    {"mbsr_joint_planar_prismatic", 6, PLANE, .joint = planar_prismatic, .planar = true},
    {"mbsr_joint_planar_pin_slot", 6, PLANE, .joint = planar_pin_slot, .planar = true},
    {"mbsr_joint_planar_free", 6, PLANE, .joint = planar_free, .planar = true},
    {"mbsr_joint_weld", 8, {SPACE}, .joint = weld},
    {"mbsr_joint_revolute", 11, {SPACE, 0.3, 0.4, 0.5}, .joint = revolute},
    {"mbsr_joint_prismatic", 11, {SPACE, 0.3, 0.4, 0.5}, .joint = prismatic},
    {"mbsr_joint_screw", 12, {SPACE, 0.3, 0.4, 0.5, 0.7}, .joint = screw},
    {"mbsr_joint_cylindrical", 11, {SPACE, 0.3, 0.4, 0.5}, .joint = cylindrical},
    {"mbsr_joint_universal", 14, {SPACE, 0.3, 0.4, 0.5, 1.0, -0.2, 0.1}, .joint = universal},
    {"mbsr_joint_in_plane", 8, {SPACE}, .joint = in_plane},
    {"mbsr_joint_translational", 8, {SPACE}, .joint = translational},
    {"mbsr_joint_spherical", 8, {SPACE}, .joint = spherical},
    {"mbsr_joint_free", 8, {SPACE}, .joint = free_joint},
    {"mbsr_joint_compound", 15, {SPACE, 0.3, 0.4, 0.5, 1.0, -0.2, 0.1, 0.7}, .joint = compound},
    {"mbsr_inertia_particle", 1, {2.0}, .inertia = particle},
    {"mbsr_inertia_planar", 4, {2.0, 0.1, 0.2, 0.5}, .inertia = planar_inertia, .planar = true},
    {"mbsr_inertia_rigid", 10, {2.0, 0.1, 0.2, 0.3, 0.5, 0.6, 0.7, 0.1}, .inertia = rigid},
    {"mbsr_inertia_rigid_unchecked",
     10,
     {2.0, 0.1, 0.2, 0.3, 0.5, 0.6, 1.7, 0.1},
     .inertia = rigid_unchecked},
    {"mbsr_inertia_rigid_about",
     14,
     {2.0, 0.1, 0.2, 0.3, 5.0, 6.0, 7.0, 0.1, 0.0, 0.0, 0.2, 0.1, 0.0, 0.5},
     .inertia = rigid_about},
    {"mbsr_inertia_point_mass", 4, {2.0, 0.1, 0.2, 0.3}, .inertia = point_mass},
    {"mbsr_inertia_rod", 7, {2.0, 0.1, 0.2, 0.3, 0.4, 0.8, 0.7}, .inertia = rod},
    {"mbsr_inertia_box", 4, {2.0, 0.1, 0.2, 0.3}, .inertia = box},
    {"mbsr_inertia_sphere", 2, {2.0, 0.1}, .inertia = sphere},
    {"mbsr_inertia_cylinder", 3, {2.0, 0.1, 0.2}, .inertia = cylinder},
    {"mbsr_inertia_capsule", 3, {2.0, 0.1, 0.2}, .inertia = capsule},
    {"mbsr_inertia_in_frame",
     14,
     {2.0, 0.1, 0.2, 0.3, 0.5, 0.6, 0.7, 0.1, 0.0, 0.0, 0.2, 0.1, 0.0, 0.5},
     .inertia = moved},
    {"mbsr_inertia_sum", 8, {2.0, 0.1, 0.2, 0.3, 1.0, 0.3, -0.2, 0.5}, .inertia = sum},
    {"mbsr_inertia_matrix", 4, {2.0, 2.0, 1.0, 0.3}, .inertia = matrix, .planar = true},
    {"mbsr_force_gravity", 3, {0.1, -9.81, 0.2}, .force = gravity},
    {"mbsr_force_axis_spring", 3, {20.0, 1.0, 0.1}, .force = axis_spring, .planar = true},
    {"mbsr_force_axis_friction", 2, {2.0, 0.1}, .force = axis_friction, .planar = true},
    {"mbsr_force_planar_bushing",
     24,
     {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 3, 1, 0, 1, 2, 0, 0, 0, 1, 2, 1, 0, 1, 3, 0, 0, 0, 1},
     .force = planar_bushing,
     .planar = true},
    {"mbsr_force_point_friction",
     11,
     {0.1, 0.2, 0.3, 0.7, 0.2, 0.1, 0.05, 30.0, 0.1, 0.9, 0.2},
     .force = point_friction},
    {"mbsr_force_point_friction",
     9,
     {0.1, 0.2, 0.3, 0.7, 0.1, 30.0, 0.1, 0.2, 0.9},
     .force = surface_friction},
    {"mbsr_force_bearing_friction", 6, {0.1, 0.2, 0.9, 2.0, 0.3, 0.1}, .force = bearing_friction},
    {"mbsr_force_spring", 10, {20.0, 3.0, 1.0, 0.4, 0.1, 0.2, 0.3, 0.9, 0.8, 0.5}, .force = spring},
    {"mbsr_force_point_spring",
     10,
     {20.0, 1.0, 0.4, 0.0, 0.1, 0.2, 0.3, 0.9, 0.8, 0.5},
     .force = point_spring},
    {"mbsr_force_bushing",
     16,
     {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.1, 0.2, 0.3, 0.4},
     .force = bushing},
    {"mbsr_force_joint_spring", 3, {20.0, 1.0, 0.1}, .force = joint_spring},
    {"mbsr_force_joint_cubic_spring", 4, {20.0, 3.0, 1.0, 0.1}, .force = joint_cubic_spring},
    {"mbsr_force_joint_rotation_spring",
     10,
     {2.0, 3.0, 4.0, 0.1, 0.2, 0.3, 1.0, 0.1, 0.2, 0.3},
     .joint = plain_spherical,
     .force = joint_rotation_spring},
    {"mbsr_force_joint_stop", 4, {-0.1, 0.1, 20.0, 1.0}, .force = joint_stop},
    {"mbsr_force_joint_friction", 2, {2.0, 0.1}, .force = joint_friction},
    {"mbsr_force_wrench", 3, {0.1, 0.2, 0.3}, .force = wrench},
    {"mbsr_force_applied", 1, {2.0}, .force = applied},
    {"mbsr_force_joint_applied", 1, {2.0}, .force = joint_applied},
    {"mbsr_force_contact",
     16,
     {0.1, 0.2, 0.3, 2.5, 0.0, 0.1, 0.0, 0.0, 0.2, 1.0, 100.0, 1.5, 0.2, 0.3, 0.1, 0.05},
     .force = contact},
    {"mbsr_model_regularise", 6, {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}, .amend = regularise},
    {"mbsr_model_armature", 1, {0.3}, .amend = armature},
    {"mbsr_model_lock", 1, {0.3}, .amend = lock},
};
enum { PARTS = sizeof parts / sizeof parts[0] };

/* No numbers that are inputs of an evaluation, no status, or a number for the caller's own use. */
static const char *const others[] = {
    "mbsr_status_name",
    "mbsr_status_text",
    "mbsr_version",
    "mbsr_root_fixed",
    "mbsr_root_moving",
    "mbsr_default_model_def",
    "mbsr_default_body_def",
    "mbsr_model_create",
    "mbsr_model_destroy",
    "mbsr_model_add_body",
    "mbsr_model_add_force",
    "mbsr_model_finish",
    "mbsr_model_error",
    "mbsr_model_bodies",
    "mbsr_model_forces",
    "mbsr_model_nq",
    "mbsr_model_nu",
    "mbsr_model_length",
    "mbsr_model_rate",
    "mbsr_body_coordinates",
    "mbsr_body_coordinate_kinds",
    "mbsr_body_parent",
    "mbsr_body_dimension",
    "mbsr_body_group",
    "mbsr_body_pose_size",
    "mbsr_body_armature",
    "mbsr_model_definition",
    "mbsr_body_locked",
    "mbsr_body_drops",
    "mbsr_body_definition",
    "mbsr_force_definition",
    "mbsr_joint_chain_of",
    "mbsr_body_locks",
    "mbsr_model_drop_locked",
    "mbsr_model_drive",
    "mbsr_model_drive_closure",
    "mbsr_body_regularisation",
    "mbsr_force_joint_servo",
    "mbsr_force_joint_curve",
    "mbsr_force_gear",
    "mbsr_table_create",
    "mbsr_table_destroy",
    "mbsr_default_table_def",
    "mbsr_table_value",
    "mbsr_table_kink",
    "mbsr_table_definition",
    "mbsr_table_motion",
    "mbsr_table_force",
    "mbsr_stored_force",
    "mbsr_model_kink",
    "mbsr_model_copy",
    /* values that are not finite: test_parameters.c */
    "mbsr_parameters_create",
    "mbsr_parameters_destroy",
    "mbsr_parameters_count",
    "mbsr_parameters_find",
    "mbsr_parameter_get",
    "mbsr_parameters_model",
    "mbsr_parameters_data",
    "mbsr_data_model",
    "mbsr_model_neglect",
    "mbsr_model_restore",
    "mbsr_body_neglected",
    "mbsr_body_name",
    "mbsr_model_find_body",
    "mbsr_inertia_zero",
    "mbsr_inertia_function",
    "mbsr_joint_point",
    "mbsr_joint_point_free",
    "mbsr_joint_custom",
    "mbsr_force_custom",
    "mbsr_default_force_def",
    "mbsr_frame_identity",
    "mbsr_frame_at",
    "mbsr_frame_rotated",
    "mbsr_frame_quaternion",
    "mbsr_frame_along",
    "mbsr_frame_product",
    "mbsr_frame_inverse",
    "mbsr_quaternion_rotation",
    "mbsr_rotation_quaternion",
    "mbsr_default_joint_test",
};

static int record(int status, const mbsr_error *error)
{
    if (status) last = *error;
    return status;
}

/* The part in a model of one body and another on it. */
static int build(const part *p, const double *x, mbsr_model **m)
{
    static const double tensor[6] = {0.5, 0.6, 0.7, 0.0, 0.0, 0.0};
    const double com[3] = {0.1, 0.2, 0.3};
    int status = record(mbsr_model_create(NULL, m, &last), &last);
    mbsr_body_def body = mbsr_default_body_def();
    if (p->planar) {
        body.joint = p->joint ? p->joint(x) : planar_free(p->good);
        body.inertia = p->inertia ? p->inertia(x) : mbsr_inertia_planar(2.0, com, 0.5);
    } else {
        const double plain[15] = {SPACE, 0.3, 0.4, 0.5};
        body.joint = p->joint ? p->joint(x) : revolute(plain);
        body.inertia = p->inertia ? p->inertia(x) : mbsr_inertia_rigid(2.0, com, tensor);
    }
    if (!status) status = record(mbsr_model_add_body(*m, &body, NULL), mbsr_model_error(*m));
    body = mbsr_default_body_def();
    body.parent = 0;
    body.joint = p->planar ? planar_revolute((const double[])PLANE)
                           : revolute((const double[]){SPACE, 0.3, 0.4, 0.5});
    body.inertia =
        p->planar ? mbsr_inertia_planar(1.0, com, 0.5) : mbsr_inertia_rigid(1.0, com, tensor);
    if (!status) status = record(mbsr_model_add_body(*m, &body, NULL), mbsr_model_error(*m));
    if (!status && p->force) {
        const mbsr_force_def force = p->force(x);
        status = record(mbsr_model_add_force(*m, &force, NULL), mbsr_model_error(*m));
    }
    if (!status && p->amend) status = record(p->amend(*m, x), mbsr_model_error(*m));
    if (!status) status = record(mbsr_model_finish(*m), mbsr_model_error(*m));
    return status;
}

/* Inverse dynamics, energies, pose of the last body and its rank of a model with the part. */
static int run_part(finite_subject *s)
{
    mbsr_model *m = NULL;
    mbsr_data *d = NULL;
    double q[16], u[16], udot[16];
    for (int k = 0; k < 16; ++k) q[k] = 0.2 + 0.1 * k, u[k] = 0.5 - 0.1 * k, udot[k] = 0.3 * k;
    for (int o = 0; o < FINITE_OUTPUTS; ++o) {
        if (!s->out[o]) return record(MBSR_ERR_NULL, &(mbsr_error){MBSR_ERR_NULL, 0, 0, "mbsr_"});
        for (int k = 0; k < 16; ++k) s->out[o][k] = 0.0;
    }
    int status = build(current, s->in[FINITE_OTHER], &m);
    if (!status) status = record(mbsr_data_create(m, &d, &last), &last);
    if (!status)
        status = record(mbsr_inverse_dynamics(m, d, 0.1, q, u, udot, NULL, s->out[0]),
                        mbsr_data_error(d));
    if (!status) status = record(mbsr_energy(m, d, s->out[1], s->out[1] + 1), mbsr_data_error(d));
    if (!status) status = record(mbsr_body_pose(m, d, 1, s->out[2]), mbsr_data_error(d));
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return status;
}

static int of_part(const finite_subject *s, int o)
{
    (void)s, (void)o;
    return 16;
}

static void every_constructor(void **unused)
{
    (void)unused;
    int complaints = 0;
    for (int k = 0; k < PARTS; ++k) {
        const finite_row row = {parts[k].function, run_part, NULL, OTHER, 0, 0, of_part};
        finite_subject s = {.name = "a model with it", .error = last_error, .object = &last};
        current = parts + k;
        finite_give(&s, FINITE_OTHER, parts[k].n, parts[k].good);
        if (!finite_try(&s, &row)) {
            print_error("%s: %s\n", parts[k].function, last.text);
            ++complaints;
        }
        complaints += s.complaints;
        s.complaints = 0;
        finite_free(&s);
    }
    assert_int_equal(complaints, 0);
    for (size_t k = 0; k < sizeof others / sizeof others[0]; ++k)
        assert_int_equal(strncmp(others[k], "mbsr_", 5), 0);
}

/* ---- a user's joint ---- */

/* A free joint, at t, q, u. */
static int run_joint_verify(finite_subject *s)
{
    const mbsr_joint joint = mbsr_joint_free(NULL, NULL);
    mbsr_joint_test at = mbsr_default_joint_test();
    mbsr_joint_errors errors;
    at.t = s->in[FINITE_T][0];
    at.q = s->in[FINITE_Q];
    at.u = s->in[FINITE_U];
    last = (mbsr_error){0};
    const int status = mbsr_joint_verify(&joint, &at, s->out[0] ? &errors : NULL, &last);
    if (!status && s->out[0]) memcpy(s->out[0], &errors, 13 * sizeof(double));
    return status;
}

static int of_errors(const finite_subject *s, int o)
{
    (void)s;
    return o == 0 ? 13 : 0;
}

static void a_joint_under_test(void **unused)
{
    (void)unused;
    static const finite_row row = {"mbsr_joint_verify",
                                   run_joint_verify,
                                   NULL,
                                   0,
                                   1 << FINITE_T | 1 << FINITE_Q | 1 << FINITE_U,
                                   0,
                                   of_errors};
    finite_subject s = {.name = "a free joint", .error = last_error, .object = &last};
    finite_give(&s, FINITE_T, 1, (double[]){0.3});
    finite_give(&s, FINITE_Q, 7, (double[]){0.8, 0.1, 0.2, 0.3, 0.5, 0.6, 0.7});
    finite_give(&s, FINITE_U, 6, (double[]){0.4, 0.5, -0.3, 1.0, 0.2, 0.1});
    assert_int_equal(finite_try(&s, &row), 1);
    assert_true(offsetof(mbsr_joint_errors, text) == 13 * sizeof(double));
    finite_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_constructor),
                                       cmocka_unit_test(a_joint_under_test)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
