/* Mass, centre of mass and momentum of the whole tree.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "algebra/space3.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "model/query.h"
#include "recursion/not_finite.h"

#include <mbsrank/dynamics.h>

/* What one body adds, with vectors in space; what lies in the plane stands at z = 0. */
typedef struct share {
    double mass, r[3], first[3]; /* kg, m, and the first moment about r in kg m */
    double momentum[6];          /* angular about r, linear */
} share;

static void share_of_body(const mbsri_body *b, const mbsr_data *d, share *s)
{
    const double *p = d->p + b->p, *M = d->M + b->dd;
    double P[MBSR_MAX_D];
    *s = (share){.mass = 0.0};
    mbsri_zero((size_t)b->d, P);
    mbsri_ax(b->d, b->d, 1.0, M, d->V + b->v, P);
    if (b->joint.space == MBSR_SPACE_FLEXIBLE) {
        s->mass = M[3 * (b->d + 1)];
        s->first[0] = M[4 * b->d + 2];
        s->first[1] = M[5 * b->d];
        s->first[2] = M[3 * b->d + 1];
        mbsri_copy(3, p + MBSR_POSE_X, s->r);
        mbsri_copy(6, P, s->momentum);
        return;
    }
    if (b->joint.space == MBSR_SPACE_SPATIAL) {
        s->mass = (M[21] + M[28] + M[35]) / 3.0;
        s->first[0] = 0.5 * (M[26] - M[31]);
        s->first[1] = 0.5 * (M[30] - M[20]);
        s->first[2] = 0.5 * (M[19] - M[24]);
        mbsri_copy(3, p + MBSR_POSE_X, s->r);
        mbsri_copy(6, P, s->momentum);
        return;
    }
    s->mass = 0.5 * (M[0] + M[b->d + 1]);
    mbsri_copy(2, p, s->r);
    mbsri_copy(2, P, s->momentum + 3);
    if (b->joint.space == MBSR_SPACE_PLANAR) {
        s->first[0] = M[7];
        s->first[1] = -M[6];
        s->momentum[2] = P[2];
    }
}

int mbsr_tree_momentum(const mbsr_model *model, mbsr_data *data, const double about[3],
                       double *mass, double centre[3], double momentum[6])
{
    static const double origin[3] = {0.0, 0.0, 0.0};
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = mbsri_enter(m, d, true, MBSRI_STAGE_VELOCITIES, "mbsr_tree_momentum");
    if (status) return status;
    if (!about) about = origin;
    status = mbsri_check_input(d, 3, about, "mbsr_tree_momentum", "about");
    if (status) return status;
    double total = 0.0, first[3] = {0.0}, sum[6] = {0.0};
    for (int i = 1; i <= m->bodies; ++i) {
        const mbsri_body *b = m->body + i;
        if (mbsri_largest(b->d * b->d, d->M + b->dd) == 0.0) continue;
        if (b->joint.space == MBSR_SPACE_GENERAL) {
            char label[MBSRI_LABEL];
            return mbsri_fail(&d->error, MBSR_ERR_SPACE, b->id, MBSR_NONE,
                              "mbsr_tree_momentum: %s has inertia in GENERAL space, whose "
                              "coordinates have no known direction",
                              mbsri_body_label(m, i, label));
        }
        share s;
        share_of_body(b, d, &s);
        double arm[3];
        for (int k = 0; k < 3; ++k) {
            arm[k] = s.r[k] - about[k];
            first[k] += s.mass * s.r[k] + s.first[k];
        }
        mbsri_add_cross3(arm, s.momentum + 3, sum);
        for (int k = 0; k < 6; ++k) sum[k] += s.momentum[k];
        total += s.mass;
    }
    for (int k = 0; k < 3; ++k) first[k] = total > 0.0 ? first[k] / total : 0.0;
    status = mbsri_check_result(m, d, 1, &total, "mbsr_tree_momentum");
    if (!status && centre) status = mbsri_check_result(m, d, 3, first, "mbsr_tree_momentum");
    if (!status && momentum) status = mbsri_check_result(m, d, 6, sum, "mbsr_tree_momentum");
    if (status) return status;
    if (mass) *mass = total;
    if (centre) mbsri_copy(3, first, centre);
    if (momentum) mbsri_copy(6, sum, momentum);
    return MBSR_OK;
}
