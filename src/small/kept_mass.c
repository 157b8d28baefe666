/* Candidates that keep their mass: see kept_mass.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * An undetermined direction of the reduced model leaves all its masses at rest; in the full one it
 * moves those that were made zero. Which of them tells the energy V^T M V, however far the joints
 * that move are from the body. */
#include "small/kept_mass.h"

#include "algebra/dense.h"
#include "recursion/data.h"
#include "small/twins.h"

/* V of the candidates in the full model at the rates u (nu): `before` into velocity of each, else
 * less that into rest. */
static int find_motions(mbsr_small_masses *s, const double *u, bool before)
{
    const mbsri_twin *twin = &s->full;
    const int status = mbsr_stage_velocities(twin->model, twin->data, u);
    for (int k = 0; k < s->candidates && !status; ++k) {
        mbsri_candidate *c = s->candidate + k;
        const mbsri_body *b = twin->model->body + c->i;
        for (int r = 0; r < b->d; ++r) {
            const double V = twin->data->V[b->v + (size_t)r];
            *(before ? c->velocity + r : c->rest + r) = before ? V : V - c->velocity[r];
        }
    }
    return mbsri_small_failed(s, status, mbsr_data_error(twin->data));
}

/* Whether a motion V (rest) of the candidate moves its mass: more than the rates that reports leave
 * out do. */
static bool moves_mass(const mbsr_small_masses *s, const mbsri_candidate *c)
{
    const mbsri_body *b = s->full.model->body + c->i;
    const double *M = s->full.data->M + b->dd, *V = c->rest;
    double energy = 0.0, size = 0.0;
    for (int k = 0; k < b->d; ++k) {
        size += V[k] * M[k * (b->d + 1)] * V[k];
        for (int l = 0; l < b->d; ++l) energy += V[k] * M[l * b->d + k] * V[l];
    }
    return energy > 1e-8 * size;
}

int mbsri_small_keep_mass(mbsr_small_masses *s, double t, const mbsr_index_report *report,
                          int *count)
{
    const mbsri_twin *twin = &s->full;
    const mbsr_model *m = twin->model;
    double *u = s->work.u;
    *count = 0;
    int status = mbsr_stage_positions(m, twin->data, t, s->start.q);
    mbsri_zero((size_t)m->nu, u);
    status = status ? mbsri_small_failed(s, status, mbsr_data_error(twin->data))
                    : find_motions(s, u, true);
    for (int k = 0; k < report->undetermined && !status; ++k) {
        const mbsr_direction *direction = report->direction + k;
        mbsri_zero((size_t)m->nu, u);
        for (int j = 0; j < direction->terms; ++j) {
            const mbsr_direction_term *term = direction->term + j;
            u[m->body[m->index[term->body]].u + term->coordinate] = term->weight;
        }
        status = find_motions(s, u, false);
        for (int l = 0; l < s->candidates && !status; ++l) {
            mbsri_candidate *c = s->candidate + l;
            if (c->keeps_mass || !moves_mass(s, c)) continue;
            c->keeps_mass = true;
            ++*count;
        }
    }
    return status;
}
