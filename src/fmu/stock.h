/* The tables of joints, force elements and closures that the library and the reader of files make,
 * by number: what a table is called in an FMU. The numbers of a version of the library are its own.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FMU_STOCK_H
#define MBSRI_FMU_STOCK_H

#include <mbsrank/closure.h>
#include <mbsrank/force.h>
#include <mbsrank/joint.h>

/* NULL: there is no such number. */
const mbsr_joint_table *mbsri_fmu_joint_table(int k);
const mbsr_force_table *mbsri_fmu_force_table(int k);
const mbsr_closure_table *mbsri_fmu_closure_table(int k);

/* -1: it is somebody's own. */
int mbsri_fmu_joint_number(const mbsr_joint_table *table);
int mbsri_fmu_force_number(const mbsr_force_table *table);
int mbsri_fmu_closure_number(const mbsr_closure_table *table);

/* What `user` of such a joint or element is, without a function of time. */
typedef enum mbsri_user {
    MBSRI_USER_NONE,
    MBSRI_USER_TABLE,
    MBSRI_USER_FLEX,
    MBSRI_USER_SHAPES,
    MBSRI_USER_CONTROL
} mbsri_user;
mbsri_user mbsri_fmu_joint_user(int number);
mbsri_user mbsri_fmu_force_user(int number);

#endif
