/* Candidates: masses that are named, neglected already, or small beside their neighbours'.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "small/candidates.h"

#include "base/error.h"
#include "base/memory.h"
#include "model/neglect.h"
#include "model/query.h"
#include "recursion/pose.h"

#include <stdlib.h>

/* The inertia of a body before anything was neglected. */
static const mbsr_inertia *given(const mbsr_model *m, int i)
{
    const mbsri_body *b = m->body + i;
    if (b->mass.neglected == 0) return &b->inertia;
    return &((const mbsri_neglected *)m->given.inertias.data)[b->mass.neglected - 1].given;
}

/* Of a matrix: the mean of what translations have, and what rotations have over that square. */
static double size_of_matrix(const mbsr_model *m, int i, const mbsr_inertia *inertia, double square)
{
    const mbsri_body *b = m->body + i;
    const double *matrix = b->inertia.matrix;
    double masses = 0.0, moments = 0.0;
    int ways = 0;
    if (inertia->kind != MBSR_INERTIA_MATRIX || !inertia->matrix) return 0.0;
    if (b->mass.neglected > 0)
        matrix = (const double *)m->stored.matrices.data +
                 ((const mbsri_neglected *)m->given.inertias.data)[b->mass.neglected - 1].matrix;
    for (int k = 0; k < b->d; ++k) {
        const bool turns = mbsri_is_angle(b->joint.space, k);
        *(turns ? &moments : &masses) += matrix[k * (b->d + 1)];
        ways += !turns;
    }
    return masses / ways + moments / square;
}

/* Mass, and moment of inertia over the square of the typical length. */
static double size_of(const mbsr_model *m, int i)
{
    const mbsr_inertia *inertia = given(m, i);
    const double length = m->typical.length > 0.0 ? m->typical.length : 1.0,
                 square = length * length;
    switch (inertia->kind) {
    case MBSR_INERTIA_PARTICLE: return inertia->mass;
    case MBSR_INERTIA_PLANAR: return inertia->mass + inertia->moment / square;
    case MBSR_INERTIA_SPATIAL:
        return inertia->mass +
               (inertia->tensor[MBSR_XX] + inertia->tensor[MBSR_YY] + inertia->tensor[MBSR_ZZ]) /
                   square;
    default: return size_of_matrix(m, i, inertia, square);
    }
}

static bool raise(double *most, double value)
{
    if (!(value > *most)) return false;
    *most = value;
    return true;
}

/* What two neighbours i and j have beside each other: their masses and, past one that is light
 * beside its own neighbours, the largest of these. */
static bool meet(double ratio, const double *size, double *most, int i, int j)
{
    bool raised = raise(most + i, size[j]);
    if (size[j] <= ratio * most[j]) raised = raise(most + i, most[j]) || raised;
    return raised;
}

static bool meet_both(double ratio, const double *size, double *most, int i, int j)
{
    const bool raised = meet(ratio, size, most, i, j);
    return meet(ratio, size, most, j, i) || raised;
}

/* All neighbours once, those in the tree in both directions. */
static bool pass(const mbsr_model *m, double ratio, const double *size, double *most)
{
    const mbsri_force *force = m->forces.data;
    bool raised = false;
    for (int turn = 0; turn < 2; ++turn) {
        for (int k = 1; k <= m->bodies; ++k) {
            const int i = turn ? m->bodies + 1 - k : k;
            int pred = m->body[i].parent;
            while (pred > 0 && size[pred] == 0.0) pred = m->body[pred].parent;
            if (pred > 0) raised = meet_both(ratio, size, most, i, pred) || raised;
        }
    }
    for (size_t k = 0; k < m->forces.count; ++k) {
        const int *list = m->stored.list_index + force[k].list;
        for (int a = 0; a < force[k].def.bodies; ++a) {
            for (int b = 0; b < a; ++b) {
                if (list[a] > 0 && list[b] > 0)
                    raised = meet_both(ratio, size, most, list[a], list[b]) || raised;
            }
        }
    }
    return raised;
}

/* The largest neighbour of each body: the nearest predecessor with mass, successors, and bodies of
 * the same force elements; past bodies that are light themselves, so that of several in a row all
 * are. size, most: N + 1. */
static void compare(const mbsr_model *m, double ratio, double *size, double *most)
{
    size[0] = 0.0;
    for (int i = 0; i <= m->bodies; ++i) most[i] = 0.0;
    for (int i = 1; i <= m->bodies; ++i) size[i] = size_of(m, i);
    while (pass(m, ratio, size, most)) continue;
}

static void add(mbsr_small_masses *s, int i, int parts, double ratio)
{
    const mbsr_model *m = s->given;
    s->candidate[s->candidates++] =
        (mbsri_candidate){.body = m->body[i].id, .i = i, .parts = parts, .ratio = ratio};
}

static bool is_candidate(const mbsr_small_masses *s, int i)
{
    for (int k = 0; k < s->candidates; ++k)
        if (s->candidate[k].i == i) return true;
    return false;
}

static int by_ratio(const void *a, const void *b)
{
    const mbsri_candidate *x = a, *y = b;
    if (x->ratio != y->ratio) return x->ratio < y->ratio ? -1 : 1;
    return x->i - y->i;
}

/* Named ones, which must have the parts; status. */
static int take_named(mbsr_small_masses *s, const double *size, const double *most)
{
    const mbsr_model *m = s->given;
    for (int k = 0; k < s->opt.parts; ++k) {
        const mbsr_small_part *part = s->opt.part + k;
        char label[MBSRI_LABEL];
        if (part->body < 0 || part->body >= m->bodies)
            return mbsri_fail(
                &s->error, MBSR_ERR_ID, MBSR_NONE, MBSR_NONE,
                "mbsr_small_masses_create: part[%d].body is %d, there is no such body", k,
                part->body);
        const int i = m->index[part->body], has = mbsri_inertia_parts(given(m, i));
        const bool whole =
            given(m, i)->kind == MBSR_INERTIA_MATRIX || given(m, i)->kind == MBSR_INERTIA_FUNCTION;
        if (part->parts < 1 || part->parts > MBSR_MASS_AND_MOMENT || (has & part->parts) == 0 ||
            (whole && part->parts != MBSR_MASS_AND_MOMENT) || is_candidate(s, i))
            return mbsri_fail(&s->error, MBSR_ERR_VALUE, part->body, MBSR_NONE,
                              "mbsr_small_masses_create: %s: part[%d].parts is %d: the body has no "
                              "such part of an inertia, or has been named before",
                              mbsri_body_label(m, i, label), k, part->parts);
        add(s, i, part->parts & has, most[i] > 0.0 ? size[i] / most[i] : 0.0);
    }
    return MBSR_OK;
}

static void take_found(mbsr_small_masses *s, const double *size, const double *most)
{
    const mbsr_model *m = s->given;
    const int first = s->candidates;
    for (int i = 1; i <= m->bodies; ++i) {
        const int parts = mbsri_inertia_parts(given(m, i));
        if (m->body[i].mass.neglected == 0 && parts && size[i] > 0.0 &&
            size[i] <= s->opt.ratio * most[i])
            add(s, i, parts, size[i] / most[i]);
    }
    qsort(s->candidate + first, (size_t)(s->candidates - first), sizeof *s->candidate, by_ratio);
    if (s->candidates - first > s->opt.most) s->candidates = first + s->opt.most;
}

int mbsri_small_candidates(mbsr_small_masses *s)
{
    const mbsr_model *m = s->given;
    const size_t N = (size_t)m->bodies + 1;
    s->candidate = mbsri_allocate(&s->allocator, (N + (size_t)s->opt.parts) * sizeof *s->candidate);
    double *size = mbsri_allocate(&s->allocator, 2 * N * sizeof *size);
    int status = MBSR_OK;
    if (s->candidate && size) {
        compare(m, s->opt.ratio, size, size + N);
        if (s->opt.part) status = take_named(s, size, size + N);
        for (int i = 1; i <= m->bodies && !status; ++i) {
            const int parts = mbsr_body_neglected(m, m->body[i].id);
            if (parts > 0 && !is_candidate(s, i))
                add(s, i, parts, size[N + (size_t)i] > 0.0 ? size[i] / size[N + (size_t)i] : 0.0);
        }
        if (!status && !s->opt.part) take_found(s, size, size + N);
        for (int k = 0; k < s->candidates; ++k)
            s->candidate[k].left =
                mbsri_inertia_without(given(m, s->candidate[k].i), s->candidate[k].parts);
    } else {
        status = mbsri_fail(&s->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                            "mbsr_small_masses_create: no memory for %d bodies", m->bodies);
    }
    mbsri_release(&s->allocator, size);
    return status;
}

/* A body's joint rates become directions of a candidate. */
static void take_joint(mbsr_small_masses *s, int i, int candidate, int *pushes, int *directions)
{
    const mbsri_body *b = s->given->body + i;
    for (int k = 0; k < b->n; ++k) {
        if (s->direction)
            s->direction[*directions] =
                (mbsr_small_direction){.body = b->id, .coordinate = k, .mass = candidate};
        ++*directions;
    }
    if (b->n == 0) return;
    if (s->pushed)
        s->pushed[*pushes] = (mbsri_pushed){.i = i, .candidate = candidate, .push = {.n = b->n}};
    ++*pushes;
}

/* Whether nothing at the body has inertia of its own. */
static bool is_dummy(const mbsr_model *m, int i)
{
    const mbsri_body *b = m->body + i;
    bool armature = false;
    for (int k = 0; k < b->n; ++k) armature = armature || b->mass.armature[k] > 0.0;
    return !armature && !b->mass.added && mbsri_inertia_parts(given(m, i)) == 0;
}

/* The candidate's own joint, and those of bodies without inertia that carry it. */
void mbsri_small_directions(mbsr_small_masses *s, int *pushes, int *directions)
{
    const mbsr_model *m = s->given;
    *pushes = *directions = 0;
    for (int k = 0; k < s->candidates; ++k) {
        int i = s->candidate[k].i;
        take_joint(s, i, k, pushes, directions);
        for (i = m->body[i].parent; i > 0 && !is_candidate(s, i) && is_dummy(m, i);
             i = m->body[i].parent)
            take_joint(s, i, k, pushes, directions);
    }
}
