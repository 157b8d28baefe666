/* Tables by number: see stock.h. A table is found by an element that its constructor makes.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fmu/stock.h"

#include <mbsrank/contact.h>
#include <mbsrank/files.h>
#include <mbsrank/flex.h>

#include <stdbool.h>
#include <string.h>

/* Numbers of those that link to something; where the elements of other_force_table and those of
 * files begin. */
enum { MOUNT = 13, MARKER = 14, OTHERS = 11, CURVE = 3, ELASTIC = 8, SHAPES = 9, OF_FILES = 10 };

static const double zero[3] = {0.0}, axis[3] = {0.0, 0.0, 1.0};
static const double directions[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};

const mbsr_joint_table *mbsri_fmu_joint_table(int k)
{
    const mbsr_planar_frame flat = {0.0, 0.0, 0.0};
    switch (k) {
    case 0: return mbsr_joint_weld(NULL, NULL).table;
    case 1: return mbsr_joint_revolute(NULL, NULL, axis).table;
    case 2: return mbsr_joint_prismatic(NULL, NULL, axis).table;
    case 3: return mbsr_joint_screw(NULL, NULL, axis, 1.0).table;
    case 4: return mbsr_joint_cylindrical(NULL, NULL, axis).table;
    case 5: return mbsr_joint_universal(NULL, NULL, directions, directions + 3).table;
    case 6: return mbsr_joint_in_plane(NULL, NULL).table;
    case 7: return mbsr_joint_translational(NULL, NULL).table;
    case 8: return mbsr_joint_spherical(NULL, NULL).table;
    case 9: return mbsr_joint_free(NULL, NULL).table;
    case 10: return mbsr_joint_compound(NULL, NULL, 0, NULL, NULL, NULL).table;
    case 11: return mbsr_joint_planar_weld(flat, flat).table;
    case 12: return mbsr_joint_point_free().table;
    case MOUNT: return mbsr_joint_mount(NULL, 0).table;
    case MARKER: return mbsr_joint_marker(NULL, 0).table;
    default: return NULL;
    }
}

/* Elements with laws of their own. */
static const mbsr_force_table *other_force_table(int k)
{
    switch (k) {
    case 0: return mbsr_force_bushing(0, NULL, 1, NULL, NULL, NULL).table;
    case 1: {
        const mbsr_planar_frame flat = {0.0, 0.0, 0.0};
        return mbsr_force_planar_bushing(0, flat, 1, flat, NULL, NULL).table;
    }
    case 2: return mbsr_force_joint_servo(0, 0, &(mbsr_servo){.kp = 0.0}).table;
    case CURVE: return mbsr_force_joint_curve(0, 0, NULL).table;
    case 4: return mbsr_force_gear(0, 0, 1, 0, &(mbsr_gear){.ratio = 1.0}).table;
    case 5: return mbsr_force_contact(0, 1, &(mbsr_contact){.radius = 1.0}).table;
    case 6: return mbsr_force_point_friction(0, NULL, 1, &(mbsr_friction){.slip = 1.0}).table;
    case 7: return mbsr_force_bearing_friction(0, 1, &(mbsr_bearing){.slip = 1.0}).table;
    case ELASTIC: return mbsr_force_elastic(0, NULL).table;
    case SHAPES: return mbsr_contacts_table();
    default: return mbsr_file_force_table(k - OF_FILES);
    }
}

const mbsr_force_table *mbsri_fmu_force_table(int k)
{
    switch (k) {
    case 0: return mbsr_force_gravity(0.0, 0.0, 0.0).table;
    case 1: return mbsr_force_axis_spring(0, 1, 0, 0.0, 0.0, 0.0).table;
    case 2: return mbsr_force_axis_friction(0, 1, 0, 0.0, 1.0).table;
    case 3: return mbsr_force_point_spring(0, NULL, 1, NULL, 0.0, 0.0, 0.0).table;
    case 4: return mbsr_force_joint_spring(0, 0, 0.0, 0.0, 0.0).table;
    case 5: return mbsr_force_joint_rotation_spring(0, zero, zero, NULL).table;
    case 6: return mbsr_force_joint_stop(0, 0, 0.0, 1.0, 0.0, 0.0).table;
    case 7: return mbsr_force_joint_friction(0, 0, 0.0, 1.0).table;
    case 8: return mbsr_force_applied(0, NULL, NULL).table;
    case 9: return mbsr_force_joint_applied(0, NULL, NULL).table;
    case 10: return mbsr_force_wrench(0, NULL, 0, NULL, NULL).table;
    default: return k < 0 ? NULL : other_force_table(k - OTHERS);
    }
}

const mbsr_closure_table *mbsri_fmu_closure_table(int k)
{
    static const int body[1] = {0}, coordinate[1] = {0};
    static const double one[1] = {1.0};
    switch (k) {
    case 0: return mbsr_closure_weld(0, NULL, 1, NULL).table;
    case 1: return mbsr_closure_ball(0, NULL, 1, NULL).table;
    case 2: return mbsr_closure_rows(0, NULL, 1, NULL, 1, axis).table;
    case 3: return mbsr_closure_body_rows(0, NULL, 1, NULL, 1, axis).table;
    case 4: return mbsr_closure_distance(0, NULL, 1, NULL, 1.0).table;
    case 5: return mbsr_closure_coupling(1, body, coordinate, one, 0.0).table;
    case 6: return mbsr_closure_rolling_ball(0, NULL, 1.0, 1, NULL).table;
    case 7: return mbsr_closure_rolling_disc(0, NULL, 1.0, 1, NULL).table;
    default: return mbsr_file_closure_table(k - 8);
    }
}

mbsri_user mbsri_fmu_joint_user(int number)
{
    return number == MOUNT || number == MARKER ? MBSRI_USER_FLEX : MBSRI_USER_NONE;
}

mbsri_user mbsri_fmu_force_user(int number)
{
    switch (number - OTHERS) {
    case CURVE: return MBSRI_USER_TABLE;
    case ELASTIC: return MBSRI_USER_FLEX;
    case SHAPES: return MBSRI_USER_SHAPES;
    default: return number >= OTHERS + OF_FILES ? MBSRI_USER_CONTROL : MBSRI_USER_NONE;
    }
}

int mbsri_fmu_joint_number(const mbsr_joint_table *table)
{
    int k = 0;
    while (mbsri_fmu_joint_table(k) && mbsri_fmu_joint_table(k) != table) ++k;
    return mbsri_fmu_joint_table(k) ? k : -1;
}

int mbsri_fmu_force_number(const mbsr_force_table *table)
{
    int k = 0;
    while (mbsri_fmu_force_table(k) && mbsri_fmu_force_table(k) != table) ++k;
    return mbsri_fmu_force_table(k) ? k : -1;
}

/* A weld or a ball with stiff rows has got another table with the same functions, and gets it
 * again. */
static bool is_same(const mbsr_closure_table *a, const mbsr_closure_table *b)
{
    return a == b || (a->position == b->position && strcmp(a->name, b->name) == 0);
}

int mbsri_fmu_closure_number(const mbsr_closure_table *table)
{
    int same = -1;
    for (int k = 0; mbsri_fmu_closure_table(k); ++k) {
        if (mbsri_fmu_closure_table(k) == table) return k;
        if (same < 0 && is_same(mbsri_fmu_closure_table(k), table)) same = k;
    }
    return same;
}
