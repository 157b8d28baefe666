/* Inertias of points, of bodies in the plane, by matrix and by function.
 * SPDX-License-Identifier: BSD-3-Clause */
#include <mbsrank/flex.h>

mbsr_inertia mbsr_inertia_zero(void)
{
    return (mbsr_inertia){.kind = MBSR_INERTIA_MATRIX};
}

mbsr_inertia mbsr_inertia_particle(double mass)
{
    return (mbsr_inertia){.kind = MBSR_INERTIA_PARTICLE, .mass = mass};
}

mbsr_inertia mbsr_inertia_planar(double mass, const double com[2], double moment)
{
    mbsr_inertia inertia = {.kind = MBSR_INERTIA_PLANAR, .mass = mass, .moment = moment};
    for (int k = 0; k < 2; ++k) inertia.com[k] = com ? com[k] : 0.0;
    return inertia;
}

mbsr_inertia mbsr_inertia_matrix(int d, const double *matrix)
{
    return (mbsr_inertia){.kind = MBSR_INERTIA_MATRIX, .d = d, .matrix = matrix};
}

mbsr_inertia mbsr_inertia_function(mbsr_inertia_fn function, void *user)
{
    return (mbsr_inertia){.kind = MBSR_INERTIA_FUNCTION, .function = function, .user = user};
}

mbsr_inertia mbsr_inertia_flexible(const mbsr_flex *flex)
{
    return (mbsr_inertia){.kind = MBSR_INERTIA_FLEXIBLE, .flex = flex};
}
