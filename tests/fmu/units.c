/* Models whose FMUs are tested: see units.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#define _XOPEN_SOURCE 700
#include "units.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static const double y_axis[3] = {0.0, 1.0, 0.0}, z_axis[3] = {0.0, 0.0, 1.0};

static unit_model begin(void)
{
    return (unit_model){.s = mbsr_simulation_begin(NULL)};
}

static mbsr_inertia rod(double mass, double length)
{
    const double a[3] = {0.0}, b[3] = {length, 0.0, 0.0};
    return mbsr_inertia_rod(mass, a, b);
}

static int hinge(unit_model *m, const char *name, int parent, double x, const double axis[3],
                 mbsr_inertia inertia)
{
    const mbsr_frame at = mbsr_frame_at(x, 0.0, 0.0);
    return mbsr_simulation_add_body(&m->s, name, parent, mbsr_joint_revolute(&at, NULL, axis),
                                    inertia);
}

static void named(unit_model *m, const char *name, mbsr_force_def force)
{
    force.name = name;
    mbsr_simulation_add_force(&m->s, force);
}

void make_arm(unit_model *m)
{
    *m = begin();
    const int upper = hinge(m, "upper", MBSR_GROUND, 0.0, y_axis, rod(2.0, 0.5)),
              lower = hinge(m, "lower arm", upper, 0.5, y_axis, rod(1.0, 0.4)),
              flap = hinge(m, "flap", lower, 0.4, z_axis, mbsr_inertia_zero());
    named(m, "weight", mbsr_force_gravity(0.0, 0.0, -9.81));
    named(m, "spring", mbsr_force_joint_spring(upper, 0, 3.0, 0.1, 0.2));
    named(m, "stop", mbsr_force_joint_stop(upper, 0, -1.0, 0.6, 2000.0, 20.0));
    named(m, "damper", mbsr_force_joint_spring(lower, 0, 0.0, 0.05, 0.0));
    named(m, "hold", mbsr_force_joint_spring(flap, 0, 1.0, 0.2, 0.3));
    named(m, "motor", mbsr_force_joint_applied(lower, mbsr_stored_force, m->held));
}

void make_linkage(unit_model *m)
{
    static const double t[] = {0.0, 0.5, 1.0, 2.0}, angle[] = {0.0, 0.3, 0.2, 0.5};
    *m = begin();
    mbsr_table *table = mbsr_simulation_add_table(&m->s, MBSR_TABLE_SPLINE, 4, t, angle);
    const mbsr_frame right = mbsr_frame_at(1.0, 0.0, 0.0);
    const mbsr_axis turn = {.kind = MBSR_AXIS_ROTATION, .direction = {0.0, 1.0, 0.0}, .driven = 1};
    const mbsr_frame up = mbsr_frame_rotated((double[3]){0.0}, y_axis, -1.5707963267948966);
    const int crank = mbsr_simulation_add_body(
                  &m->s, "crank", MBSR_GROUND,
                  mbsr_joint_compound(&up, NULL, 1, &turn, mbsr_table_motion, table),
                  rod(0.5, 0.5)),
              coupler = hinge(m, "coupler", crank, 0.5, y_axis, rod(1.0, 1.0));
    const mbsr_frame foot = mbsr_frame_product(&right, &up);
    const int rocker = mbsr_simulation_add_body(
        &m->s, "rocker", MBSR_GROUND, mbsr_joint_revolute(&foot, NULL, y_axis), rod(0.7, 0.5));
    const double end[3] = {1.0, 0.0, 0.0}, top[3] = {0.5, 0.0, 0.0};
    const double directions[6] = {1.0, 0.0, 0.0, 0.0, 0.0, 1.0};
    mbsr_closure_def pin = mbsr_closure_rows(coupler, end, rocker, top, 2, directions);
    pin.name = "pin";
    mbsr_simulation_add_closure(&m->s, pin);
    named(m, "weight", mbsr_force_gravity(0.0, 0.0, -9.81));
    named(m, "spring", mbsr_force_joint_spring(rocker, 0, 5.0, 0.2, 0.0));
}

void make_beam(unit_model *m)
{
    static const int tip[] = {8};
    *m = begin();
    mbsr_error error;
    mbsr_beam_def def = mbsr_default_beam_def();
    def.length = 1.0, def.density = 0.8;
    def.EI_y = def.EI_z = 20.0;
    def.elements = 8, def.modes = 2, def.loaded = 1, def.node = tip;
    def.damping = 0.02, def.cutoff = 2000.0, def.radius_y = def.radius_z = 0.01;
    if (mbsr_flex_beam(&def, &m->flex, &error)) return;
    mbsr_flexible_def at = mbsr_default_flexible_def();
    at.name = "beam", at.flex = m->flex;
    at.joint = mbsr_joint_revolute(NULL, NULL, y_axis);
    int body, end;
    mbsr_model_add_flexible(m->s.model, &at, &body);
    mbsr_model_add_marker(m->s.model, body, 8, "tip", &end);
    named(m, "weight", mbsr_force_gravity(0.0, 0.0, -9.81));
    named(m, "hinge", mbsr_force_joint_spring(body - 1, 0, 30.0, 0.5, 0.0));
    named(m, "push", mbsr_force_wrench(end, NULL, 0, mbsr_stored_force, m->motion.value));
}

void make_flyer(unit_model *m)
{
    static const double tensor[6] = {0.1, 0.2, 0.15, 0.01, 0.02, -0.01}, com[3] = {0.1, 0.0, 0.05},
                        above[3] = {0.1, 0.0, 0.4};
    *m = begin();
    const mbsr_frame end = mbsr_frame_at(0.3, 0.0, 0.0);
    const int first =
                  mbsr_simulation_add_body(&m->s, "first", MBSR_GROUND, mbsr_joint_free(NULL, NULL),
                                           mbsr_inertia_rigid(2.0, com, tensor)),
              second =
                  mbsr_simulation_add_body(&m->s, "second", first, mbsr_joint_spherical(&end, NULL),
                                           mbsr_inertia_rigid(1.0, com, tensor));
    named(m, "weight", mbsr_force_gravity(0.0, 0.0, -9.81));
    named(m, "spring", mbsr_force_point_spring(first, above, MBSR_GROUND, NULL, 200.0, 3.0, 0.1));
    named(m, "push", mbsr_force_wrench(second, NULL, 0, mbsr_stored_force, m->motion.value));
}

void make_mite(unit_model *m)
{
    static const double x_axis[3] = {1.0, 0.0, 0.0}, aside[3] = {0.0, 2e-6, 0.0}, com[3] = {0.0};
    *m = begin();
    const int mite = mbsr_simulation_add_body(&m->s, "mite", MBSR_GROUND,
                                              mbsr_joint_prismatic(NULL, NULL, x_axis),
                                              mbsr_inertia_point_mass(1e-9, com));
    named(m, "spring", mbsr_force_point_spring(mite, NULL, MBSR_GROUND, aside, 1.0, 0.0, 1e-6));
    named(m, "friction", mbsr_force_joint_friction(mite, 0, 1e-9, 1e-3));
}

void make_twins(unit_model *m)
{
    static const double t[] = {0.0, 0.5, 1.0}, torque[] = {0.0, 0.0, 10.0};
    const mbsr_planar_frame here = {0.0, 0.0, 0.0}, above = {0.0, 1.0, 0.0};
    *m = begin();
    mbsr_table *table = mbsr_simulation_add_table(&m->s, MBSR_TABLE_LINEAR, 3, t, torque);
    const int bead = mbsr_simulation_add_body(&m->s, "bead", MBSR_GROUND, mbsr_joint_point_free(),
                                              mbsr_inertia_zero());
    int pendulum = 0;
    for (int k = 0; k < 2; ++k)
        pendulum = mbsr_simulation_add_body(&m->s, k == 0 ? "left" : "right", bead,
                                            mbsr_joint_planar_revolute(here, above),
                                            mbsr_inertia_particle(1.0));
    for (int axis = 0; axis < 2; ++axis)
        mbsr_simulation_add_force(&m->s,
                                  mbsr_force_axis_spring(bead, MBSR_GROUND, axis, 100.0, 5.0, 0.0));
    named(m, "weight", mbsr_force_gravity(0.0, -9.81, 0.0));
    named(m, "torque", mbsr_force_joint_applied(pendulum, mbsr_table_force, table));
}

/* ---- a quarter of a vehicle ---- */

enum { BODY = 300, WHEEL = 40 };

static int slider(unit_model *m, const char *name, double mass)
{
    return mbsr_simulation_add_body(&m->s, name, MBSR_GROUND,
                                    mbsr_joint_prismatic(NULL, NULL, z_axis),
                                    mbsr_inertia_particle(mass));
}

static void add_wheel(unit_model *m, int carrier)
{
    static const double above[3] = {0.0, 0.0, 1.0}, below[3] = {0.0, 0.0, -1.0};
    const int wheel = slider(m, "wheel", WHEEL);
    named(m, "tyre", mbsr_force_point_spring(wheel, NULL, MBSR_GROUND, below, 150e3, 300.0, 1.05));
    named(m, "strut", mbsr_force_point_spring(carrier, above, wheel, NULL, 20e3, 1500.0, 1.15));
}

void make_vehicle(unit_model *m)
{
    *m = begin();
    add_wheel(m, slider(m, "body", BODY));
    named(m, "weight", mbsr_force_gravity(0.0, 0.0, -9.81));
}

void make_body(unit_model *m)
{
    *m = begin();
    const int body = slider(m, "body", BODY);
    named(m, "weight", mbsr_force_gravity(0.0, 0.0, -9.81));
    named(m, "strut", mbsr_force_joint_applied(body, mbsr_stored_force, m->held));
}

void make_wheel(unit_model *m)
{
    *m = begin();
    m->motion = (mbsr_fmu_motion){.count = 1};
    const mbsr_axis up = {.kind = MBSR_AXIS_TRANSLATION, .direction = {0.0, 0.0, 1.0}, .driven = 1};
    const int carrier = mbsr_simulation_add_body(
        &m->s, "carrier", MBSR_GROUND,
        mbsr_joint_compound(NULL, NULL, 1, &up, mbsr_fmu_stored_motion, &m->motion),
        mbsr_inertia_zero());
    add_wheel(m, carrier);
    named(m, "weight", mbsr_force_gravity(0.0, 0.0, -9.81));
}

/* ---- contacts ---- */

static const double still[6] = {0.1, 0.2, 0.15, 0.01, 0.02, -0.01};

static int shape_on(unit_model *m, const char *name, int body, mbsr_shape_kind kind, double x,
                    double y, double z)
{
    int id = -1;
    mbsr_shape s = mbsr_default_shape();
    s.name = name, s.body = body, s.kind = kind;
    s.size[0] = x, s.size[1] = y, s.size[2] = z;
    s.law = (mbsr_contact_law){2e3, 1.5, 0.1, 0.5, 1.0, 0.02, 0.03, 0.8, 0.0};
    if (mbsr_contacts_add(m->contacts, &s, &id, NULL)) return -1;
    return id;
}

static void begin_contacts(unit_model *m)
{
    *m = begin();
    mbsr_contacts_create(&m->contacts, NULL);
    shape_on(m, "floor", MBSR_GROUND, MBSR_SHAPE_PLANE, 0.0, 0.0, 0.0);
}

static void end_contacts(unit_model *m)
{
    mbsr_force_def touch;
    named(m, "weight", mbsr_force_gravity(0.0, 0.0, -9.81));
    if (!mbsr_contacts_force(m->contacts, 0, &touch, NULL)) named(m, "touch", touch);
}

static int loose(unit_model *m, const char *name, double x, double z)
{
    static const double com[3] = {0.02, 0.0, 0.01};
    const mbsr_frame at = mbsr_frame_at(x, 0.0, z);
    return mbsr_simulation_add_body(&m->s, name, MBSR_GROUND, mbsr_joint_free(&at, NULL),
                                    mbsr_inertia_rigid(2.0, com, still));
}

void make_balls(unit_model *m)
{
    begin_contacts(m);
    const int ball = loose(m, "ball", 0.0, 0.35);
    const mbsr_frame above = mbsr_frame_at(0.0, 0.0, 0.97);
    const int second = mbsr_simulation_add_body(&m->s, "second", MBSR_GROUND,
                                                mbsr_joint_prismatic(&above, NULL, z_axis),
                                                mbsr_inertia_particle(3.0));
    shape_on(m, "ball", ball, MBSR_SHAPE_SPHERE, 0.5, 0.0, 0.0);
    shape_on(m, "second", second, MBSR_SHAPE_SPHERE, 0.3, 0.0, 0.0);
    named(m, "push", mbsr_force_wrench(ball, NULL, 0, mbsr_stored_force, m->motion.value));
    end_contacts(m);
}

/* A hill of the ground, and a stone. */
static void add_rough(unit_model *m, int stone)
{
    static const double height[9] = {0.0, 0.05, 0.0, 0.05, 0.1, 0.05, 0.0, 0.05, 0.0},
                        corner[18] = {0.3, 0.0,  0.0, -0.3, 0.0, 0.0,  0.0, 0.2, 0.0,
                                      0.0, -0.2, 0.0, 0.0,  0.0, 0.25, 0.0, 0.0, -0.25};
    static const int side[24] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    mbsr_shape hill = mbsr_default_shape(), s = hill;
    hill.kind = MBSR_SHAPE_HEIGHTS;
    hill.size[0] = hill.size[1] = 1.0;
    hill.rows = hill.columns = 3, hill.height = height;
    s.kind = MBSR_SHAPE_MESH, s.body = stone;
    s.vertices = 6, s.triangles = 8, s.vertex = corner, s.triangle = side, s.rounding = 0.02;
    hill.law.stiffness = s.law.stiffness = 1e4;
    hill.groups = hill.mask = s.groups = s.mask = 5;
    s.law.damping = 0.2;
    mbsr_contacts_add(m->contacts, &hill, NULL, NULL);
    mbsr_contacts_add(m->contacts, &s, NULL, NULL);
}

void make_heap(unit_model *m)
{
    static const char *const names[] = {"dice", "peg", "egg", "pill", "stone"};
    static const mbsr_shape_kind kinds[] = {MBSR_SHAPE_BOX, MBSR_SHAPE_CYLINDER,
                                            MBSR_SHAPE_ELLIPSOID, MBSR_SHAPE_CAPSULE};
    static const double x[] = {0.0, 0.05, 0.3, 0.45, 0.9}, z[] = {0.45, 0.8, 0.7, 0.9, 0.4};
    int body[5], shape[4];
    begin_contacts(m);
    for (int k = 0; k < 5; ++k) body[k] = loose(m, names[k], x[k], z[k]);
    for (int k = 0; k < 4; ++k) shape[k] = shape_on(m, names[k], body[k], kinds[k], 0.15, 0.2, 0.1);
    add_rough(m, body[4]);
    const mbsr_frame below = mbsr_frame_at(0.0, 0.1, -0.2);
    const int foot = mbsr_simulation_add_body(
        &m->s, "foot", body[0], mbsr_joint_prismatic(&below, NULL, z_axis), mbsr_inertia_zero());
    named(m, "leg", mbsr_force_joint_spring(foot, 0, 400.0, 20.0, 0.0));
    shape_on(m, "", foot, MBSR_SHAPE_SPHERE, 0.05, 0.0, 0.0);
    const mbsr_contact_law own = {5e3, 1.0, 0.4, 0.1, 0.5, 0.0, 0.0, 1.0, 0.01};
    int joined[6][2];
    for (int k = 0; k < 6; ++k) joined[k][0] = k, joined[k][1] = k == foot ? body[0] : MBSR_NONE;
    mbsr_contacts_pair(m->contacts, shape[0], shape[1], &own, NULL);
    mbsr_contacts_pair(m->contacts, shape[1], shape[2], NULL, NULL);
    mbsr_contacts_exclude(m->contacts, body[2], body[3], NULL);
    mbsr_contacts_join(m->contacts, 6, joined[0], NULL);
    end_contacts(m);
}

void free_model(unit_model *m)
{
    mbsr_simulation_end(&m->s);
    mbsr_contacts_destroy(m->contacts);
    mbsr_flex_destroy(m->flex);
}

/* ---- archives ---- */

int write_unit(unit_model *m, const mbsr_fmu_opt *opt, const char *path)
{
    mbsr_fmu *fmu;
    mbsr_error error;
    int status = mbsr_model_finish(m->s.model);
    error = *mbsr_model_error(m->s.model);
    if (!status) status = mbsr_fmu_export(m->s.model, opt, &fmu, &error);
    if (status) {
        fprintf(stderr, "%s: %s\n", path, error.text);
        return status;
    }
    FILE *to = fopen(path, "wb");
    if (!to || fwrite(fmu->data, 1, fmu->size, to) != fmu->size) status = -1;
    if (to && fclose(to)) status = -1;
    mbsr_fmu_destroy(fmu);
    return status;
}

static uint32_t number(const unsigned char *p, int bytes)
{
    uint32_t x = 0;
    for (int k = bytes - 1; k >= 0; --k) x = x << 8 | p[k];
    return x;
}

/* The folders of a path. */
static void make_folders(char *path, size_t from)
{
    for (char *c = path + from; *c; ++c) {
        if (*c != '/') continue;
        *c = '\0';
        mkdir(path, 0777);
        *c = '/';
    }
}

int unpack(const mbsr_fmu *fmu, const char *folder)
{
    size_t at = 0;
    while (at + 30 < fmu->size && number(fmu->data + at, 4) == 0x04034b50) {
        const unsigned char *head = fmu->data + at;
        const size_t size = number(head + 18, 4), name = number(head + 26, 2);
        char path[4096];
        snprintf(path, sizeof path, "%s/%.*s", folder, (int)name, (const char *)head + 30);
        make_folders(path, strlen(folder) + 1);
        FILE *to = fopen(path, "wb");
        if (!to || fwrite(head + 30 + name, 1, size, to) != size || fclose(to)) return -1;
        at += 30 + name + size;
    }
    return at > 0 ? 0 : -1;
}

static uint64_t hash(const unsigned char *data, size_t size, uint64_t start)
{
    for (size_t k = 0; k < size; ++k) start = (start ^ data[k]) * UINT64_C(1099511628211);
    return start;
}

static uint32_t crc32(const unsigned char *data, size_t size)
{
    uint32_t crc = UINT32_MAX;
    for (size_t k = 0; k < size; ++k) {
        crc ^= data[k];
        for (int bit = 0; bit < 8; ++bit)
            crc = crc >> 1 ^ (UINT32_C(0xedb88320) & (0u - (crc & 1u)));
    }
    return ~crc;
}

void stamp(unsigned char *data, size_t size, char token[33])
{
    const uint32_t crc = size < 4 ? 0 : crc32(data, size - 4) >> 1;
    for (size_t k = 0; size >= 4 && k < 4; ++k) data[size - 4 + k] = (unsigned char)(crc >> 8 * k);
    snprintf(token, 33, "%016llx%016llx",
             (unsigned long long)hash(data, size, UINT64_C(14695981039346656037)),
             (unsigned long long)hash(data, size, UINT64_C(88172645463325252)));
}
