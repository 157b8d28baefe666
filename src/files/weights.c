/* What joints carry: see weights.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A body with all that hangs on it has m, f = integral of x, S = integral of x x^T about the origin
 * of its frame; in the frame (R, p) on its parent
 *
 *   f' = R f + m p,   S' = R S R^T + R f p^T + p (R f)^T + m p p^T
 *
 * A slide carries m; a hinge along the unit vector a through the anchor c carries tr S_c - a^T S_c
 * a, where S_c is S about c. */
#include "files/weights.h"

#include "files/solids.h"

#include <math.h>

typedef struct load {
    double mass, first[3], second[3][3];
} load;

/* The load about -x, of which this is one about the origin. */
static load shifted_load(const load *l, const double x[3])
{
    load to = {.mass = l->mass};
    for (int i = 0; i < 3; ++i) {
        to.first[i] = l->first[i] + l->mass * x[i];
        for (int j = 0; j < 3; ++j)
            to.second[i][j] =
                l->second[i][j] + l->first[i] * x[j] + x[i] * l->first[j] + l->mass * x[i] * x[j];
    }
    return to;
}

static load rotated_load(const load *l, const double R[9])
{
    load to = {.mass = l->mass};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) to.first[i] += R[3 * k + i] * l->first[k];
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                for (int n = 0; n < 3; ++n)
                    to.second[i][j] += R[3 * k + i] * l->second[k][n] * R[3 * n + j];
    }
    return to;
}

static void add_load_to(load *to, const load *more)
{
    to->mass += more->mass;
    for (int i = 0; i < 3; ++i) to->first[i] += more->first[i];
    for (int i = 0; i < 9; ++i) to->second[i / 3][i % 3] += more->second[i / 3][i % 3];
}

/* Of one body; nothing where it is no rigid one. */
static load load_of(const mbsr_inertia *inertia)
{
    static const int place[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
    double centre[3], I[6];
    load l = {.mass = 0.0};
    if (!mbsri_solid_of(inertia, &l.mass, centre, I)) return (load){.mass = 0.0};
    const double half = 0.5 * (I[0] + I[1] + I[2]);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) l.second[i][j] = (i == j ? half : 0.0) - I[place[i][j]];
    return shifted_load(&l, centre);
}

static mbsri_weight carried(const load *l, const mbsri_scene_joint *j)
{
    if (j->joint.kind == MBSR_FILE_SLIDE) return (mbsri_weight){l->mass + j->armature, l->mass};
    if (j->joint.kind != MBSR_FILE_HINGE) return (mbsri_weight){0.0, 0.0};
    const double back[3] = {-j->anchor[0], -j->anchor[1], -j->anchor[2]}, *a = j->axis;
    const load about = shifted_load(l, back);
    double moment = j->armature, along = 0.0, square = 0.0;
    for (int i = 0; i < 3; ++i) {
        moment += about.second[i][i];
        for (int k = 0; k < 3; ++k) moment -= a[i] * about.second[i][k] * a[k];
        along += a[i] * about.first[i];
        square += about.first[i] * about.first[i];
    }
    return (mbsri_weight){moment, sqrt(fmax(0.0, square - along * along))};
}

const mbsri_weight *mbsri_scene_weights(const mbsri_scene *s)
{
    const mbsri_scene_body *b = mbsri_scene_bodies(s);
    mbsri_weight *weight =
        mbsri_arena_take(s->arena, ((size_t)s->joints.count + 1) * sizeof *weight);
    load *loads = mbsri_arena_take(s->arena, ((size_t)s->bodies.count + 1) * sizeof *loads);
    if (!weight || !loads) return NULL;
    for (int k = s->bodies.count - 1; k >= 0; --k) {
        const load own = load_of(&b[k].inertia);
        add_load_to(loads + k, &own);
        for (int l = b[k].first; l < b[k].first + b[k].joints; ++l)
            weight[l] = carried(loads + k, mbsri_scene_joints(s) + l);
        if (b[k].parent < 0) continue;
        load moved = rotated_load(loads + k, b[k].frame.R);
        moved = shifted_load(&moved, b[k].frame.x);
        add_load_to(loads + b[k].parent, &moved);
    }
    return weight;
}
