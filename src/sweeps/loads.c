/* Force elements that act on bodies, in the vectorised sweeps.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Elements see a body by its own frame: pose, velocity and force stand in the arrays of the stages,
 * for the bodies on which elements act. */
#include "sweeps/loads.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "recursion/elements.h"
#include "recursion/inertia.h"
#include "sweeps/block.h"
#include "sweeps/show.h"

#include <string.h>

static bool is_loaded(int flags)
{
    return flags & MBSRI_LOADED && !(flags & MBSRI_BLOCK);
}

/* Pose, velocity and mass matrix of the bodies on which elements act; no force yet. */
static void show_all(const mbsri_sweep_run *run)
{
    mbsr_data *d = run->data;
    for (int i = 1; i <= run->tree->bodies; ++i) {
        const mbsri_body *body = run->model->body + i;
        if (!is_loaded(run->tree->body[i].flags)) continue;
        mbsri_sweeps_show(run, i);
        mbsri_zero((size_t)body->d, d->f + body->v);
        if (run->tree->masses) mbsri_inertia_mass(body, d->p + body->p, d->M + body->dd);
    }
}

int mbsri_sweeps_loads(const mbsri_sweep_run *run)
{
    const mbsri_sweeps *tree = run->tree;
    const mbsr_model *m = run->model;
    mbsr_data *d = run->data;
    mbsri_sweep_load *load = run->load;
    show_all(run);
    mbsri_zero((size_t)m->root.d, d->f);
    int status = mbsri_block_forces(run);
    if (!status) status = mbsri_body_elements(m, d);
    for (int i = 1; i <= tree->bodies; ++i) {
        if (!is_loaded(tree->body[i].flags)) continue;
        const mbsri_body *body = m->body + i;
        double f[6];
        mbsri_lift(body->d, d->f + body->v, f);
        memset(load[i].L, 0, sizeof load[i].L);
        memset(load[i].p, 0, sizeof load[i].p);
        mbsri_cross3(load[i].arm, f + 3, load[i].L);
        mbsri_add3(1.0, f, load[i].L);
        memcpy(load[i].p, f + 3, 3 * sizeof *f);
    }
    return status;
}
