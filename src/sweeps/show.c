/* Where bodies of the sweeps are and how they move, as the stages tell it.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/show.h"

#include "algebra/space3.h"

#include <string.h>

void mbsri_sweeps_show(const mbsri_sweep_run *run, int i)
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
}

double mbsri_sweeps_angle(const mbsri_sweep_run *run, int i, double pred)
{
    const mbsri_body *body = run->model->body + i;
    const mbsri_sweep_own *own = run->tree->own + i;
    if (body->joint.space != MBSR_SPACE_PLANAR) return 0.0;
    if (own->coordinate == MBSRI_ANGLE_HELD) return pred + own->angle;
    return pred + own->angle + mbsri_driven_angle(&body->joint, run->data->t);
}

void mbsri_sweeps_place_root(const mbsri_sweep_run *run)
{
    const mbsr_space space = run->model->root.space;
    const double *p = run->data->p;
    double R[9];
    memset(run->load, 0, sizeof *run->load);
    mbsri_embedded_pose(space, p, R, run->load->r);
    if (space == MBSR_SPACE_PLANAR) run->load->r[3] = p[2];
}
