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

#include <string.h>

/* Pose and velocity of the body's own frame; no force yet. */
static void show(const mbsri_sweep_run *run, int i)
{
    const mbsri_body *body = run->model->body + i;
    const mbsri_sweep_state *s = run->state + i;
    const mbsri_sweep_joint *own = run->tree->own + i;
    mbsr_data *d = run->data;
    double *pose = d->p + body->p, *V = d->V + body->v, *arm = run->load[i].arm, R[9];
    for (int k = 0; k < 9; ++k) R[k] = s->R[k / 3 * 4 + k % 3];
    mbsri_multiply3(R, own->R, pose + MBSR_POSE_R);
    mbsri_rotate3(R, own->x, arm);
    memcpy(V, s->omega, 3 * sizeof *V);
    mbsri_cross3(s->omega, arm, V + 3);
    for (int k = 0; k < 3; ++k) {
        pose[MBSR_POSE_X + k] = run->load[i].r[k] + arm[k];
        V[3 + k] += s->v[k];
    }
    mbsri_zero(6, d->f + body->v);
    if (run->tree->masses) mbsri_inertia_mass(body, pose, d->M + body->dd);
}

int mbsri_sweeps_loads(const mbsri_sweep_run *run)
{
    const mbsri_sweeps *tree = run->tree;
    const mbsr_model *m = run->model;
    mbsr_data *d = run->data;
    mbsri_sweep_load *load = run->load;
    memset(load, 0, sizeof *load);
    if (m->root.space == MBSR_SPACE_SPATIAL)
        memcpy(load->r, d->p + MBSR_POSE_X, 3 * sizeof *load->r);
    mbsri_zero((size_t)m->root.d, d->f);
    for (int i = 1; i <= tree->bodies; ++i) {
        const double *from = load[tree->body[i].parent].r, *rho = run->state[i].rho;
        for (int k = 0; k < 3; ++k) load[i].r[k] = from[k] + rho[k];
        if (tree->body[i].flags & MBSRI_LOADED) show(run, i);
    }
    const int status = mbsri_body_elements(m, d);
    for (int i = 1; i <= tree->bodies; ++i) {
        if (!(tree->body[i].flags & MBSRI_LOADED)) continue;
        const mbsri_body *body = m->body + i;
        const double *f = d->f + body->v;
        memset(load[i].L, 0, sizeof load[i].L);
        memset(load[i].p, 0, sizeof load[i].p);
        mbsri_cross3(load[i].arm, f + 3, load[i].L);
        mbsri_add3(1.0, f, load[i].L);
        memcpy(load[i].p, f + 3, 3 * sizeof *f);
    }
    return status;
}
