/* What the parts of the reader of URDF share: see urdf_parts.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/urdf_parts.h"

static mbsr_frame rpy_frame(const double x[3], const double rpy[3])
{
    static const double axes[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    mbsr_frame frame = mbsr_frame_turned(x, axes[2], rpy[2]);
    for (int k = 1; k >= 0; --k) {
        const mbsr_frame turn = mbsr_frame_turned(NULL, axes[k], rpy[k]);
        frame = mbsr_frame_product(&frame, &turn);
    }
    return frame;
}

bool mbsri_urdf_place(mbsri_scene *s, const mbsri_element *of, const mbsri_element *e,
                      mbsr_frame *frame)
{
    double x[3] = {0.0}, rpy[3] = {0.0};
    if (e && !(mbsri_numbers(s, of, "xyz", mbsri_attribute(e, "xyz"), 3, 3, x, NULL) &&
               mbsri_numbers(s, of, "rpy", mbsri_attribute(e, "rpy"), 3, 3, rpy, NULL)))
        return false;
    *frame = rpy_frame(x, rpy);
    return true;
}
