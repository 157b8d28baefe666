/* Users' joints in the vectorised sweeps: see users_joint.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/users_joint.h"

#include "algebra/space3.h"
#include "recursion/kinematics.h"
#include "recursion/rates.h"
#include "sweeps/show.h"

#include <string.h>

/* From the predecessor's origin in the sweeps to that of body i; false: H is no translation. */
static bool find_arm(const mbsri_sweep_run *run, const mbsri_body *b, double rho[3])
{
    const mbsr_data *d = run->data;
    const double *arm = run->load[b->parent].arm;
    if (b->pred.d == 0) { /* the root at rest */
        memcpy(rho, d->p + b->p + MBSR_POSE_X, 3 * sizeof *rho);
        return true;
    }
    const bool rigid = mbsri_is_translation(d->H + b->dp, rho);
    for (int k = 0; k < 3; ++k) rho[k] += arm[k];
    return rigid;
}

int mbsri_users_move(const mbsri_sweep_run *run, int i)
{
    const mbsr_model *m = run->model;
    const mbsri_body *b = m->body + i;
    mbsr_data *d = run->data;
    mbsri_sweep_state *s = run->state + i;
    mbsri_sweep_multi *multi = run->multi + run->tree->body[i].multi;
    const double *pose = d->p + b->p, *V = d->V + b->v, *kII = d->kII + b->v,
                 *omega = run->state[b->parent].omega;
    const int parent = b->parent, shown = MBSRI_BLOCK | MBSRI_USERS;
    if (parent > 0 && !(run->tree->body[parent].flags & shown)) mbsri_sweeps_show(run, parent);
    int status = mbsri_place_joint(m, d, i);
    if (!status) status = mbsri_move_joint(m, d, i);
    if (status) return status;
    memset(s, 0, sizeof *s);
    memset(run->load[i].arm, 0, sizeof run->load[i].arm);
    if (!find_arm(run, b, s->rho)) return MBSRI_NOT_SERVED;
    for (int k = 0; k < 9; ++k) s->R[k / 3 * 4 + k % 3] = pose[MBSR_POSE_R + k];
    mbsri_spread_out(b->n, -1.0, d->J + b->dn, multi->S);
    mbsri_spread_out(1, -1.0, d->kI + b->v, &multi->drive);
    /* c = -kII + omega_pi x (omega_pi x (the predecessor's own origin)) */
    double swing[3];
    mbsri_cross3(omega, run->load[parent].arm, swing);
    mbsri_cross3(omega, swing, s->A_v);
    for (int k = 0; k < 3; ++k) {
        s->omega[k] = V[k];
        s->v[k] = V[3 + k];
        s->A_w[k] = -kII[k];
        s->A_v[k] -= kII[3 + k];
    }
    return MBSR_OK;
}

int mbsri_users_rates(const mbsri_sweep_run *run)
{
    const mbsr_model *m = run->model;
    int status = MBSR_OK;
    for (int i = 1; i <= run->tree->bodies && !status; ++i) {
        const mbsri_sweep_body *b = run->tree->body + i;
        if (!(b->flags & MBSRI_USERS)) continue;
        status = mbsri_joint_rates_of(m, run->data, i);
        mbsri_spread_out(b->n, -1.0, run->data->Jdot + m->body[i].dn, run->multi[b->multi].Sdot);
    }
    return status;
}
