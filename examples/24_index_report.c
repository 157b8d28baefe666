/* The index report: which directions have no inertia, what determines them, and what to do about
 * those that nothing determines.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A lever and a slider without mass, and a load of 1 kg, on one line. Forces come one by one: a
 * damper on the lever, a spring between slider and load, a damper there. Before the first nothing
 * holds the two; the report says so in words, and mbsr_dae_consistent would refuse. A spring makes
 * a direction elastic, index 2: its position follows from the balance of forces. A damper makes
 * it an equation of first order, index 1. */
#include <mbsrank/index.h>
#include <mbsrank/mbsrank.h>

#include "build.h"

#include <string.h>

enum { BODIES = 3, FORCES = 3 };
static const char *const body_name[BODIES] = {"lever", "slider", "load"};
static const char *const force_name[FORCES] = {"damper of the lever", "spring of the slider",
                                               "damper of the slider"};

/* Prints the report with the first `forces` of the force elements; returns the index. */
static int report(int forces)
{
    const mbsr_force_def force[FORCES] = {mbsr_force_axis_spring(0, MBSR_GROUND, 0, 0.0, 3.0, 0.0),
                                          mbsr_force_axis_spring(1, 2, 0, 50.0, 0.0, 0.0),
                                          mbsr_force_axis_spring(1, 2, 0, 0.0, 2.0, 0.0)};
    const char *const kind[] = {"", "damped", "elastic", "undetermined"};
    const double q[BODIES] = {0.0, 0.1, 0.1}, u[BODIES] = {0.0};
    mbsr_model *m = new_model();
    mbsr_data *d;
    mbsr_error error;
    mbsr_index_report *found;
    for (int i = 0; i < BODIES; ++i)
        add_body(m, body_name[i], MBSR_GROUND,
                 mbsr_joint_point((mbsr_planar_frame){0}, MBSR_X, 0, NULL, NULL),
                 i < 2 ? mbsr_inertia_zero() : mbsr_inertia_particle(1.0));
    for (int k = 0; k < forces; ++k) add_force(m, force[k]);
    check(mbsr_model_finish(m), mbsr_model_error(m));
    check(mbsr_data_create(m, &d, &error), &error);
    check(mbsr_index_report_create(m, d, 0.0, q, u, &found), mbsr_data_error(d));
    printf("%d force elements: index %d, %d with mass\n", forces, found->index, found->dynamic);
    for (int k = 0; k < found->directions; ++k) {
        const mbsr_direction *a = &found->direction[k];
        printf("    %-12s ", kind[a->kind]);
        for (int l = 0; l < a->terms; ++l)
            printf(" %+g u%d of %s", a->term[l].weight, a->term[l].coordinate,
                   mbsr_body_name(m, a->term[l].body));
        for (int l = 0; l < a->forces; ++l) printf(", by the %s", force_name[a->force[l]]);
        printf("\n");
    }
    printf("%s%s", found->text, strlen(found->text) > 0 ? "\n" : "");
    const int index = found->index;
    mbsr_index_report_destroy(m, found);
    mbsr_data_destroy(d);
    mbsr_model_destroy(m);
    return index;
}

int main(void)
{
    const int expected[FORCES + 1] = {-1, -1, 2, 1};
    int wrong = 0;
    for (int forces = 0; forces <= FORCES; ++forces) wrong += report(forces) != expected[forces];
    return wrong;
}
