/* The mass matrix of a body in a pose, its rate and its gyroscopic force.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "recursion/inertia.h"

#include "algebra/dense.h"
#include "flexible/mass.h"
#include "inertias/exact.h"
#include "inertias/rigid.h"

#include <math.h>

/* First moment of a planar body about its origin, m R(angle) com. */
static void first_moment(const mbsr_inertia *inertia, double angle, double c[2])
{
    const double cosine = cos(angle), sine = sin(angle);
    c[0] = inertia->mass * (cosine * inertia->com[0] - sine * inertia->com[1]);
    c[1] = inertia->mass * (sine * inertia->com[0] + cosine * inertia->com[1]);
}

/* Which constant matrices of a body in space turn with it. */
static bool is_spatial(const mbsri_body *b)
{
    return b->joint.space == MBSR_SPACE_SPATIAL;
}

/* M += the regularisation. */
static void add_regularisation(const mbsri_body *b, const double *p, double *M)
{
    if (!b->mass.added) return;
    if (is_spatial(b)) {
        mbsri_rotated_mass(b->mass.added, p + MBSR_POSE_R, M);
        return;
    }
    for (int k = 0; k < b->d * b->d; ++k) M[k] += b->mass.added[k];
}

void mbsri_inertia_mass(const mbsri_body *b, const double *p, double *M)
{
    const mbsr_inertia *inertia = &b->inertia;
    const int d = b->d;
    if (inertia->kind != MBSR_INERTIA_FLEXIBLE) mbsri_zero((size_t)d * (size_t)d, M);
    switch (inertia->kind) {
    case MBSR_INERTIA_PARTICLE:
        if (is_spatial(b))
            M[21] = M[28] = M[35] = inertia->mass;
        else
            M[0] = M[d + 1] = inertia->mass;
        break;
    case MBSR_INERTIA_PLANAR: {
        /* columns x, y, angle:  m I and the first moment turned by 90 degrees; moment about the
         * origin */
        double c[2];
        first_moment(inertia, p[2], c);
        M[0] = M[4] = inertia->mass;
        M[2] = M[6] = -c[1];
        M[5] = M[7] = c[0];
        M[8] = inertia->moment + inertia->mass * (inertia->com[0] * inertia->com[0] +
                                                  inertia->com[1] * inertia->com[1]);
        break;
    }
    case MBSR_INERTIA_MATRIX:
        if (!inertia->matrix) break;
        if (is_spatial(b))
            mbsri_rotated_mass(inertia->matrix, p + MBSR_POSE_R, M);
        else
            mbsri_copy((size_t)d * (size_t)d, inertia->matrix, M);
        break;
    case MBSR_INERTIA_SPATIAL: mbsri_rigid_mass(inertia, p + MBSR_POSE_R, M); break;
    case MBSR_INERTIA_FLEXIBLE:
        mbsri_flex_mass(inertia->flex, p + MBSR_POSE_R, p + MBSR_POSE_SIZE, M);
        break;
    case MBSR_INERTIA_INVALID:
    case MBSR_INERTIA_NOT_GIVEN:
    case MBSR_INERTIA_FUNCTION: break;
    }
    add_regularisation(b, p, M);
}

void mbsri_inertia_times(const mbsri_body *b, const double *p, const double *M, double factor,
                         const double *x, double *y)
{
    if (b->inertia.kind == MBSR_INERTIA_SPATIAL && !b->mass.added && is_spatial(b))
        mbsri_rigid_times(&b->inertia, p + MBSR_POSE_R, factor, x, y);
    else
        mbsri_ax(b->d, b->d, factor, M, x, y);
}

/* M of a body in the plane, from the first moment as it was turned. */
static void exact_planar(const mbsr_inertia *inertia, double angle, mbsri_two *M)
{
    const double cosine = cos(angle), sine = sin(angle), m = inertia->mass,
                 x = cosine * inertia->com[0] - sine * inertia->com[1],
                 y = sine * inertia->com[0] + cosine * inertia->com[1];
    const mbsri_two cx = mbsri_two_product(m, x), cy = mbsri_two_product(m, y);
    M[0] = M[4] = mbsri_two_of(m);
    M[2] = M[6] = mbsri_two_negative(cy);
    M[5] = M[7] = cx;
    M[8] = mbsri_two_add(mbsri_two_of(inertia->moment),
                         mbsri_two_add(mbsri_two_scale(cx, x), mbsri_two_scale(cy, y)));
}

/* Rows of a matrix given by its entries that have others than the diagonal are rounded. */
static void unsure_rows(int d, const double *M, double *unsure)
{
    for (int k = 0; k < d; ++k) {
        bool alone = true;
        for (int j = 0; j < d; ++j) alone = alone && (j == k || M[j * d + k] == 0.0);
        if (!alone) unsure[k] = fabs(M[k * (d + 1)]);
    }
}

void mbsri_inertia_exact(const mbsri_body *b, const double *p, const double *M, mbsri_two *exact,
                         double *unsure)
{
    const mbsr_inertia *inertia = &b->inertia;
    const int d = b->d;
    const bool particle = inertia->kind == MBSR_INERTIA_PARTICLE,
               none = inertia->kind == MBSR_INERTIA_NOT_GIVEN,
               planar = inertia->kind == MBSR_INERTIA_PLANAR,
               rigid = inertia->kind == MBSR_INERTIA_SPATIAL;
    for (int k = 0; k < d * d; ++k) exact[k] = mbsri_two_of(M[k]);
    mbsri_zero((size_t)d, unsure);
    if (!b->mass.added && (particle || none)) return;
    if (!b->mass.added && planar) {
        exact_planar(inertia, p[2], exact);
        return;
    }
    if (!b->mass.added && rigid) {
        mbsri_exact_mass(inertia, p + MBSR_POSE_R, exact);
        const double lost = mbsri_exact_of(inertia).lost;
        for (int k = 0; k < 3; ++k) unsure[k] = lost;
        return;
    }
    const bool flexible = b->joint.space == MBSR_SPACE_FLEXIBLE;
    if (!is_spatial(b) && !flexible) {
        unsure_rows(d, M, unsure);
        return;
    }
    for (int k = 0; k < d; ++k) unsure[k] = fabs(M[k * (d + 1)]);
    unsure[0] = unsure[1] = unsure[2] = unsure[0] + unsure[1] + unsure[2];
}

void mbsri_inertia_mass_rate(const mbsri_body *b, const double *p, const double *V, const double *M,
                             double *Mdot)
{
    if (is_spatial(b)) {
        mbsri_rotated_mass_rate(M, V, Mdot);
        return;
    }
    if (b->inertia.kind == MBSR_INERTIA_FLEXIBLE) {
        mbsri_flex_mass_rate(b->inertia.flex, p + MBSR_POSE_R, p + MBSR_POSE_SIZE, V, M, Mdot);
        return;
    }
    mbsri_zero((size_t)b->d * (size_t)b->d, Mdot);
    if (b->inertia.kind != MBSR_INERTIA_PLANAR) return;
    /* the first moment c turns: c' = omega (-c_y, c_x) */
    double c[2];
    first_moment(&b->inertia, p[2], c);
    Mdot[2] = Mdot[6] = -V[2] * c[0];
    Mdot[5] = Mdot[7] = -V[2] * c[1];
}

/* Gyroscopic force of a body in space; its M turns with it, whatever it is made of. */
static void spatial_gyration(const mbsri_body *b, const double *M, const double *V, double *h)
{
    const mbsr_inertia *inertia = &b->inertia;
    const bool matrix = inertia->kind == MBSR_INERTIA_MATRIX && inertia->matrix;
    if (b->mass.added || matrix)
        mbsri_rotated_gyration(M, V, h);
    else if (inertia->kind == MBSR_INERTIA_SPATIAL)
        mbsri_rigid_gyration(M, V, h);
}

/* M and h of an inertia by function, and what a regularisation adds. */
static int by_function(const mbsri_body *b, double t, const double *p, const double *V, double *M,
                       double *h)
{
    const mbsr_inertia *inertia = &b->inertia;
    mbsri_zero((size_t)b->d * (size_t)b->d, M);
    const int status = inertia->function(inertia->user, t, p, V, M, h);
    add_regularisation(b, p, M);
    if (!status && b->mass.added && is_spatial(b)) {
        double added[36] = {0.0};
        mbsri_rotated_mass(b->mass.added, p + MBSR_POSE_R, added);
        mbsri_rotated_gyration(added, V, h);
    }
    return status;
}

int mbsri_inertia_velocity(const mbsri_body *b, double t, const double *p, const double *V,
                           double *M, double *h)
{
    const mbsr_inertia *inertia = &b->inertia;
    mbsri_zero((size_t)b->d, h);
    if (inertia->kind == MBSR_INERTIA_FUNCTION) return by_function(b, t, p, V, M, h);
    if (is_spatial(b)) spatial_gyration(b, M, V, h);
    if (inertia->kind == MBSR_INERTIA_FLEXIBLE)
        mbsri_flex_gyration(inertia->flex, p + MBSR_POSE_R, p + MBSR_POSE_SIZE, V, M, h);
    if (inertia->kind == MBSR_INERTIA_PLANAR) {
        double c[2] = {M[5], -M[2]};
        if (b->mass.added) first_moment(inertia, p[2], c);
        h[0] = -V[2] * V[2] * c[0];
        h[1] = -V[2] * V[2] * c[1];
    }
    return MBSR_OK;
}
