/* Limits and dry friction of joints as force elements.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A stop returns like a damped oscillator of the mass M that the coordinate moves as drawn, all
 * others held, with the time constant T and the ratio of damping z of the file (solreflimit,
 * solimplimit: k = 1 / (T z)^2 / d, with d the largest impedance; else T = 0.02 s, z = 1), and
 * yields to the weight W of what it carries by no more than a hundredth of the range w:
 *
 *   K = max(M k, 100 W / w),   D = 2 z sqrt(K M)
 *
 * A coordinate that moves no mass counts with the least mass of those of its kind that do, else
 * with 1 kg or 1 kg m^2. Dry friction is smooth below a thousandth of the range (a turn or a metre
 * where there is none) per second. */
#include "files/build_parts.h"
#include "files/weights.h"

#include <math.h>

/* The least mass that a joint of that kind moves. */
static double least_mass(const mbsri_scene *s, const mbsri_weight *weight,
                         mbsr_file_joint_kind kind)
{
    const mbsri_scene_joint *j = mbsri_scene_joints(s);
    double least = INFINITY;
    for (int k = 0; k < s->joints.count; ++k)
        if (j[k].joint.kind == kind && weight[k].mass > 0.0) least = fmin(least, weight[k].mass);
    return isfinite(least) ? least : 1.0;
}

static double width_of(const mbsr_file_joint *j)
{
    const double width = j->limited ? j->range[1] - j->range[0] : 0.0;
    return width > 0.0 ? width : j->kind == MBSR_FILE_HINGE ? 2.0 * 3.14159265358979323846 : 1.0;
}

static void set_stop(const mbsri_scene *s, mbsri_scene_joint *j, mbsri_weight w)
{
    const double *g = s->gravity, *ref = j->limit_reference, d = j->limit_impedance,
                 pull = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]),
                 least = 100.0 * w.load * pull / width_of(&j->joint);
    const bool timed = ref[0] > 0.0; /* else stiffness and damping, negative */
    const double k = timed ? 1.0 / (ref[0] * ref[0] * ref[1] * ref[1] * d) : -ref[0] / d,
                 ratio = timed ? ref[1] : 0.5 * -ref[1] / sqrt(-ref[0]);
    j->joint.stop_stiffness = fmax(w.mass * k, least);
    j->joint.stop_damping = 2.0 * ratio * sqrt(j->joint.stop_stiffness * w.mass);
}

/* The numbers of the rule, or of the options where these have some. */
bool mbsri_scene_limits(mbsri_scene *s)
{
    const mbsr_file_opt *opt = s->opt;
    const mbsri_weight *weight = opt->limits && s->joints.count > 0 ? mbsri_scene_weights(s) : NULL;
    if (opt->limits && s->joints.count > 0 && !weight) return false;
    for (int k = 0; k < s->joints.count; ++k) {
        mbsri_scene_joint *j = mbsri_scene_joints(s) + k;
        mbsr_file_joint *of = &j->joint;
        if (!mbsri_has_axis(of)) {
            if ((opt->limits && s->with_limits && of->limited) ||
                (opt->friction && s->with_friction && of->friction > 0.0))
                mbsri_file_find(s, j->element, "its limits and dry friction are left out");
            continue;
        }
        const bool stops = of->limited && of->range[0] < of->range[1] && s->with_limits,
                   rubs = of->friction > 0.0 && s->with_friction;
        mbsri_weight w = weight ? weight[k] : (mbsri_weight){0.0, 0.0};
        if (weight && !(w.mass > 0.0)) w.mass = least_mass(s, weight, of->kind);
        if (stops && opt->stop_stiffness > 0.0)
            of->stop_stiffness = opt->stop_stiffness, of->stop_damping = opt->stop_damping;
        else if (stops && opt->limits)
            set_stop(s, j, w);
        if (rubs)
            of->slip = opt->slip > 0.0 ? opt->slip : opt->friction ? 1e-3 * width_of(of) : 0.0;
    }
    return true;
}
