/* The tables of elements that files need, by number.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/elements.h"
#include "files/path.h"
#include "files/thrust.h"

#include <mbsrank/files.h>

const mbsr_force_table *mbsr_file_force_table(int k)
{
    static const double nothing[3] = {0.0};
    switch (k) {
    case 0: return mbsri_force_transmission(&(mbsri_transmission){.count = 0}).table;
    case 1: return mbsri_force_thrust(&(mbsri_thrust){.frame = mbsr_frame_identity()}).table;
    case 2: return mbsri_force_lift(MBSR_GROUND, nothing, nothing).table;
    case 3: return mbsri_path_table();
    default: return NULL;
    }
}

const mbsr_closure_table *mbsr_file_closure_table(int k)
{
    static const int body[2] = {0, 1}, coordinate[2] = {0};
    static const double numbers[5] = {0.0};
    return k == 0 ? mbsri_closure_polynomial(body, coordinate, numbers, numbers).table : NULL;
}
