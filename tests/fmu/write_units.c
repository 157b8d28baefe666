/* Writes the FMUs that the importer in Python tests: write_units FOLDER.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "units.h"

#include <stdio.h>

static const struct {
    const char *name;
    void (*make)(unit_model *m);
} units[] = {{"arm", make_arm},         {"linkage", make_linkage}, {"beam", make_beam},
             {"vehicle", make_vehicle}, {"body", make_body},       {"wheel", make_wheel},
             {"flyer", make_flyer},     {"balls", make_balls},     {"heap", make_heap}};

/* With sources; fixed_step 0: stepped by the error. */
static int write_sources(const char *name, void (*make)(unit_model *m), int version,
                         double fixed_step, const char *folder)
{
    unit_model m;
    char path[4096];
    mbsr_fmu_opt opt = mbsr_default_fmu_opt();
    opt.version = version;
    opt.name = name;
    opt.fixed_step = fixed_step;
    opt.sources = 1;
    make(&m);
    snprintf(path, sizeof path, "%s/%s_sources%d.fmu", folder, name, version);
    const int status = write_unit(&m, &opt, path);
    free_model(&m);
    return status != 0;
}

int main(int argc, char **argv)
{
    int failures = argc != 2;
    for (size_t k = 0; k < sizeof units / sizeof *units && argc == 2; ++k) {
        for (int version = 2; version <= 3; ++version) {
            unit_model m;
            char path[4096];
            mbsr_fmu_opt opt = mbsr_default_fmu_opt();
            opt.version = version;
            opt.name = units[k].name;
            opt.rtol = opt.atol = 1e-8;
            units[k].make(&m);
            snprintf(path, sizeof path, "%s/%s%d.fmu", argv[1], units[k].name, version);
            failures += write_unit(&m, &opt, path) != 0;
            free_model(&m);
        }
    }
    for (int version = 2; version <= 3 && argc == 2; ++version) {
        failures += write_sources("arm", make_arm, version, 0.0, argv[1]);
        failures += write_sources("beam", make_beam, version, 1e-3, argv[1]);
        failures += write_sources("heap", make_heap, version, 1e-3, argv[1]);
    }
    return failures ? 1 : 0;
}
