/* A slider with a spring as an FMU: what any importer of FMI 3.0 loads.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A mass hangs from a spring with a damper, and a force that the importer gives pulls at it. The
 * program writes slider.fmu; docs/fmu.md says what to do with it. */
#include "build.h"

#include <mbsrank/fmu.h>
#include <mbsrank/simulation.h>

int main(void)
{
    const double z[3] = {0.0, 0.0, 1.0};
    double pull = 0.0; /* N, becomes an input */
    mbsr_simulation s = mbsr_simulation_begin(NULL);
    const int mass = mbsr_simulation_add_body(
        &s, "mass", MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, z), mbsr_inertia_particle(2.0));
    mbsr_force_def spring = mbsr_force_joint_spring(mass, 0, 50.0, 1.0, 0.0);
    mbsr_force_def hand = mbsr_force_joint_applied(mass, mbsr_stored_force, &pull);
    spring.name = "spring", hand.name = "hand";
    mbsr_simulation_add_force(&s, mbsr_force_gravity(0.0, 0.0, -9.81));
    mbsr_simulation_add_force(&s, spring);
    mbsr_simulation_add_force(&s, hand);
    check(s.status, &s.error);
    check(mbsr_model_finish(s.model), mbsr_model_error(s.model));

    mbsr_fmu *fmu;
    mbsr_error error;
    mbsr_fmu_opt opt = mbsr_default_fmu_opt();
    opt.name = "slider";
    check(mbsr_fmu_export(s.model, &opt, &fmu, &error), &error);
    FILE *to = fopen("slider.fmu", "wb");
    if (!to || fwrite(fmu->data, 1, fmu->size, to) != fmu->size || fclose(to)) return 1;
    printf("slider.fmu: %.1f MB, %s, with the input inputs.hand and the output joints.mass.q\n",
           1e-6 * (double)fmu->size,
           fmu->kinds & MBSR_FMU_MODEL_EXCHANGE ? "co-simulation and model exchange"
                                                : "co-simulation");
    mbsr_fmu_destroy(fmu);
    mbsr_simulation_end(&s);
    return 0;
}
