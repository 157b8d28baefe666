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
    const mbsri_sweep_own *own = run->tree->own + i;
    mbsr_data *d = run->data;
    double *pose = d->p + body->p, *arm = run->load[i].arm, R[9], r[3], V[6];
    for (int k = 0; k < 9; ++k) R[k] = s->R[k / 3 * 4 + k % 3];
    mbsri_rotate3(R, own->x, arm);
    memcpy(V, s->omega, 3 * sizeof *V);
    mbsri_cross3(s->omega, arm, V + 3);
    for (int k = 0; k < 3; ++k) {
        r[k] = run->load[i].r[k] + arm[k];
        V[3 + k] += s->v[k];
    }
    mbsri_lower(body->d, V, d->V + body->v);
    if (body->joint.space == MBSR_SPACE_SPATIAL) {
        mbsri_multiply3(R, own->R, pose + MBSR_POSE_R);
        memcpy(pose + MBSR_POSE_X, r, sizeof r);
    } else {
        memcpy(pose, r, 2 * sizeof r[0]);
        if (body->joint.space == MBSR_SPACE_PLANAR) pose[2] = run->load[i].r[3];
    }
    mbsri_zero((size_t)body->d, d->f + body->v);
    if (run->tree->masses) mbsri_inertia_mass(body, pose, d->M + body->dd);
}

/* The angle of a PLANAR body, behind its origin. */
static double angle_of(const mbsri_sweep_run *run, int i, double pred)
{
    const mbsri_body *body = run->model->body + i;
    const mbsri_sweep_own *own = run->tree->own + i;
    if (body->joint.space != MBSR_SPACE_PLANAR) return 0.0;
    if (own->coordinate >= 0) return pred + own->angle + run->q[own->coordinate];
    if (own->coordinate == MBSRI_ANGLE_HELD) return pred + own->angle;
    return pred + own->angle + mbsri_driven_angle(&body->joint, run->data->t);
}

/* Origins, and the bodies on which elements act. */
static void show_all(const mbsri_sweep_run *run)
{
    const mbsri_sweeps *tree = run->tree;
    const mbsr_model *m = run->model;
    mbsri_sweep_load *load = run->load;
    const double *p = run->data->p;
    memset(load, 0, sizeof *load);
    if (m->root.space == MBSR_SPACE_SPATIAL) memcpy(load->r, p + MBSR_POSE_X, 3 * sizeof *p);
    if (m->root.space == MBSR_SPACE_PLANAR || m->root.space == MBSR_SPACE_POINT)
        memcpy(load->r, p, 2 * sizeof *p);
    if (m->root.space == MBSR_SPACE_PLANAR) load->r[3] = p[2];
    for (int i = 1; i <= tree->bodies; ++i) {
        const double *from = load[tree->body[i].parent].r, *rho = run->state[i].rho;
        for (int k = 0; k < 3; ++k) load[i].r[k] = from[k] + rho[k];
        if (tree->body[i].flags & MBSRI_PLANE) load[i].r[3] = angle_of(run, i, from[3]);
        if (tree->body[i].flags & MBSRI_LOADED) show(run, i);
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
    const int status = mbsri_body_elements(m, d);
    for (int i = 1; i <= tree->bodies; ++i) {
        if (!(tree->body[i].flags & MBSRI_LOADED)) continue;
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
