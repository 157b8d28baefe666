/* Inertia of bodies in space: constructors, and mass matrices in a pose.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "inertias/rigid.h"

#include "algebra/dense.h"
#include "algebra/frames.h"
#include "algebra/space3.h"
#include "inertias/exact.h"

#include <string.h>

static const double pi = 3.14159265358979323846;
static const double origin[3] = {0.0, 0.0, 0.0};

/* ---- tensors as six entries ---- */

static void tensor_of(const double tensor[6], double I[9])
{
    I[0] = tensor[MBSR_XX], I[4] = tensor[MBSR_YY], I[8] = tensor[MBSR_ZZ];
    I[1] = I[3] = tensor[MBSR_XY];
    I[2] = I[6] = tensor[MBSR_XZ];
    I[5] = I[7] = tensor[MBSR_YZ];
}

static void tensor_entries(const double I[9], double tensor[6])
{
    tensor[MBSR_XX] = I[0], tensor[MBSR_YY] = I[4], tensor[MBSR_ZZ] = I[8];
    tensor[MBSR_XY] = 0.5 * (I[1] + I[3]);
    tensor[MBSR_XZ] = 0.5 * (I[2] + I[6]);
    tensor[MBSR_YZ] = 0.5 * (I[5] + I[7]);
}

/* B = R A R^T; B is not A */
static void rotate_tensor(const double R[9], const double A[9], double B[9])
{
    double RA[9];
    mbsri_multiply3(R, A, RA);
    mbsri_multiply_transposed3(RA, R, B);
}

/* I += mass (|c|^2 - c c^T): a tensor about the centre of mass, moved by c */
static void add_parallel_axes(double mass, const double c[3], double I[9])
{
    const double square = mbsri_dot3(c, c);
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) I[3 * j + k] += mass * ((j == k ? square : 0.0) - c[j] * c[k]);
    }
}

/* ---- constructors ---- */

static mbsr_inertia invalid(void)
{
    return (mbsr_inertia){.kind = MBSR_INERTIA_INVALID};
}

mbsr_inertia mbsr_inertia_rigid(double mass, const double com[3], const double tensor[6])
{
    mbsr_inertia inertia = {.kind = MBSR_INERTIA_SPATIAL, .mass = mass};
    if (!tensor) return invalid();
    if (com) memcpy(inertia.com, com, sizeof inertia.com);
    memcpy(inertia.tensor, tensor, sizeof inertia.tensor);
    const mbsri_exact exact = mbsri_exact_of(&inertia);
    mbsri_exact_settle(&exact, &inertia);
    return inertia;
}

mbsr_inertia mbsr_inertia_rigid_unchecked(double mass, const double com[3], const double tensor[6])
{
    mbsr_inertia inertia = mbsr_inertia_rigid(mass, com, tensor);
    inertia.unchecked = 1;
    return inertia;
}

mbsr_inertia mbsr_inertia_rigid_about(double mass, const double com[3], const mbsr_frame *frame,
                                      const double tensor[6])
{
    double I[9], turned[9], arm[3], result[6];
    const mbsr_frame body = mbsr_frame_identity();
    if (!frame) frame = &body;
    if (!tensor || !(mbsri_frame_defect(frame->R) < 1e-6)) return invalid();
    if (!com) com = origin;
    tensor_of(tensor, I);
    rotate_tensor(frame->R, I, turned);
    for (int k = 0; k < 3; ++k) arm[k] = com[k] - frame->x[k];
    add_parallel_axes(-mass, arm, turned);
    tensor_entries(turned, result);
    mbsr_inertia inertia = mbsr_inertia_rigid(mass, com, result), given = inertia;
    memcpy(given.tensor, tensor, sizeof given.tensor);
    given.exact = 0;
    mbsri_exact exact = mbsri_exact_of(&given);
    mbsri_two apart[3];
    for (int k = 0; k < 3; ++k) apart[k] = mbsri_two_sum(com[k], -frame->x[k]);
    mbsri_exact_turn(frame->R, exact.tensor);
    mbsri_exact_parallel_axes(-mass, apart, exact.tensor);
    if (mbsri_dot3(arm, arm) > 0.0) exact.lost = tensor[0] + tensor[1] + tensor[2];
    mbsri_exact_settle(&exact, &inertia);
    return inertia;
}

mbsr_inertia mbsr_inertia_point_mass(double mass, const double at[3])
{
    const double none[6] = {0.0};
    return mbsr_inertia_rigid(mass, at, none);
}

mbsr_inertia mbsr_inertia_rod(double mass, const double a[3], const double b[3])
{
    double middle[3], half[3], I[9] = {0.0}, tensor[6];
    if (!a) a = origin;
    if (!b) b = origin;
    for (int k = 0; k < 3; ++k) {
        middle[k] = 0.5 * (a[k] + b[k]);
        half[k] = 0.5 * (b[k] - a[k]);
    }
    add_parallel_axes(mass / 3.0, half, I);
    tensor_entries(I, tensor);
    mbsr_inertia rod = mbsr_inertia_rigid(mass, middle, tensor);
    mbsri_exact exact = {.mass = mass};
    mbsri_two reach[3];
    for (int k = 0; k < 3; ++k) {
        reach[k] = mbsri_two_scale(mbsri_two_sum(b[k], -a[k]), 0.5);
        exact.com[k] = mbsri_two_scale(mbsri_two_sum(a[k], b[k]), 0.5);
    }
    mbsri_exact_parallel_axes(mass / 3.0, reach, exact.tensor);
    mbsri_exact_settle(&exact, &rod);
    return rod;
}

/* About the origin with these principal moments, and the second moments P that they are sums of. */
static mbsr_inertia principal(double mass, double xx, double yy, double zz, const double P[3])
{
    const double tensor[6] = {xx, yy, zz, 0.0, 0.0, 0.0};
    mbsr_inertia inertia = mbsr_inertia_rigid(mass, origin, tensor);
    const mbsri_exact exact = {.mass = mass,
                               .tensor = {mbsri_two_sum(P[1], P[2]), mbsri_two_sum(P[2], P[0]),
                                          mbsri_two_sum(P[0], P[1])}};
    mbsri_exact_settle(&exact, &inertia);
    return inertia;
}

mbsr_inertia mbsr_inertia_box(double density, const double edges[3])
{
    if (!edges) return invalid();
    const double a = edges[0], b = edges[1], c = edges[2], mass = density * a * b * c;
    if (a < 0.0 || b < 0.0 || c < 0.0) return invalid();
    const double share = mass / 12.0, P[3] = {share * a * a, share * b * b, share * c * c};
    return principal(mass, mass * (b * b + c * c) / 12.0, mass * (a * a + c * c) / 12.0,
                     mass * (a * a + b * b) / 12.0, P);
}

mbsr_inertia mbsr_inertia_sphere(double density, double radius)
{
    const double mass = density * 4.0 / 3.0 * pi * radius * radius * radius;
    const double moment = 0.4 * mass * radius * radius,
                 P[3] = {0.5 * moment, 0.5 * moment, 0.5 * moment};
    return radius < 0.0 ? invalid() : principal(mass, moment, moment, moment, P);
}

mbsr_inertia mbsr_inertia_cylinder(double density, double radius, double length)
{
    const double square = radius * radius, mass = density * pi * square * length;
    const double across = mass * (length * length / 12.0 + square / 4.0);
    const double P[3] = {0.25 * mass * square, 0.25 * mass * square, mass * length * length / 12.0};
    if (radius < 0.0 || length < 0.0) return invalid();
    return principal(mass, across, across, 0.5 * mass * square, P);
}

mbsr_inertia mbsr_inertia_capsule(double density, double radius, double length)
{
    const double square = radius * radius, body = density * pi * square * length,
                 ends = density * 4.0 / 3.0 * pi * radius * square;
    const double across = body * (length * length / 12.0 + square / 4.0) +
                          ends * (0.4 * square + length * length / 4.0 + 0.375 * length * radius);
    const double side = square * (0.25 * body + 0.2 * ends),
                 P[3] = {side, side,
                         body * length * length / 12.0 +
                             ends *
                                 (0.2 * square + length * length / 4.0 + 0.375 * length * radius)};
    if (radius < 0.0 || length < 0.0) return invalid();
    return principal(body + ends, across, across, square * (0.5 * body + 0.4 * ends), P);
}

/* A particle or zero as a rigid body; others as they are. */
static mbsr_inertia as_rigid(const mbsr_inertia *inertia)
{
    if (inertia->kind == MBSR_INERTIA_PARTICLE)
        return mbsr_inertia_point_mass(inertia->mass, origin);
    if (inertia->kind == MBSR_INERTIA_MATRIX && !inertia->matrix && inertia->d == 0)
        return mbsr_inertia_point_mass(0.0, origin);
    return *inertia;
}

mbsr_inertia mbsr_inertia_in_frame(const mbsr_frame *frame, mbsr_inertia inertia)
{
    mbsr_inertia moved = as_rigid(&inertia);
    double I[9], turned[9];
    const mbsr_frame body = mbsr_frame_identity();
    if (!frame) frame = &body;
    if (moved.kind != MBSR_INERTIA_SPATIAL || !(mbsri_frame_defect(frame->R) < 1e-6))
        return invalid();
    mbsri_exact exact = mbsri_exact_of(&moved);
    mbsri_exact_rotate(frame->R, exact.com, exact.com);
    for (int k = 0; k < 3; ++k)
        exact.com[k] = mbsri_two_add(exact.com[k], mbsri_two_of(frame->x[k]));
    mbsri_exact_turn(frame->R, exact.tensor);
    mbsri_rotate3(frame->R, moved.com, moved.com);
    mbsri_add3(1.0, frame->x, moved.com);
    tensor_of(moved.tensor, I);
    rotate_tensor(frame->R, I, turned);
    tensor_entries(turned, moved.tensor);
    mbsri_exact_settle(&exact, &moved);
    return moved;
}

/* Both together: about the common centre of mass c, of which mass c = sum of mass c of the parts.
 */
static mbsri_exact exact_sum(double mass, const mbsr_inertia part[2])
{
    mbsri_exact sum = {.mass = mass};
    const mbsri_exact each[2] = {mbsri_exact_of(part), mbsri_exact_of(part + 1)};
    for (int k = 0; k < 3 && mass != 0.0; ++k) {
        sum.com[k] = mbsri_two_divide(mbsri_two_add(mbsri_two_scale(each[0].com[k], each[0].mass),
                                                    mbsri_two_scale(each[1].com[k], each[1].mass)),
                                      mbsri_two_of(mass));
    }
    for (int l = 0; l < 2; ++l) {
        mbsri_two arm[3], I[6];
        memcpy(I, each[l].tensor, sizeof I);
        for (int k = 0; k < 3; ++k) arm[k] = mbsri_two_subtract(each[l].com[k], sum.com[k]);
        mbsri_exact_parallel_axes(each[l].mass, arm, I);
        for (int k = 0; k < 6; ++k) sum.tensor[k] = mbsri_two_add(sum.tensor[k], I[k]);
        sum.lost += each[l].lost;
    }
    return sum;
}

mbsr_inertia mbsr_inertia_sum(mbsr_inertia a, mbsr_inertia b)
{
    const mbsr_inertia part[2] = {as_rigid(&a), as_rigid(&b)};
    if (part[0].kind != MBSR_INERTIA_SPATIAL || part[1].kind != MBSR_INERTIA_SPATIAL)
        return invalid();
    const double mass = part[0].mass + part[1].mass;
    double com[3] = {0.0, 0.0, 0.0}, I[9], total[9] = {0.0}, tensor[6];
    for (int l = 0; l < 2 && mass != 0.0; ++l) mbsri_add3(part[l].mass / mass, part[l].com, com);
    for (int l = 0; l < 2; ++l) {
        double arm[3];
        tensor_of(part[l].tensor, I);
        for (int k = 0; k < 3; ++k) arm[k] = part[l].com[k] - com[k];
        add_parallel_axes(part[l].mass, arm, I);
        for (int k = 0; k < 9; ++k) total[k] += I[k];
    }
    tensor_entries(total, tensor);
    mbsr_inertia sum = mbsr_inertia_rigid(mass, com, tensor);
    sum.unchecked = part[0].unchecked != 0 || part[1].unchecked != 0;
    const mbsri_exact exact = exact_sum(mass, part);
    mbsri_exact_settle(&exact, &sum);
    return sum;
}

/* ---- in a pose ---- */

/* M += the block B (3 x 3) at rows `row`, columns `column`. */
static void add_3x3(const double B[9], int row, int column, double *M)
{
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) M[6 * (column + j) + row + k] += B[3 * j + k];
    }
}

/* M (6 x 6) of mass, first moment and moments about the origin. */
static void fill_mass(double mass, const double first[3], const double I[9], double *M)
{
    double C[9];
    mbsri_cross_matrix3(first, C);
    for (int j = 0; j < 3; ++j) {
        double *turn = M + 6 * j, *move = turn + 18;
        for (int k = 0; k < 3; ++k) {
            turn[k] = I[3 * j + k];
            turn[3 + k] = -C[3 * j + k];
            move[k] = C[3 * j + k];
            move[3 + k] = j == k ? mass : 0.0;
        }
    }
}

void mbsri_rigid_mass(const mbsr_inertia *inertia, const double R[9], double *M)
{
    double c[3], body[9], I[9];
    mbsri_rotate3(R, inertia->com, c);
    tensor_of(inertia->tensor, body);
    rotate_tensor(R, body, I);
    add_parallel_axes(inertia->mass, c, I);
    for (int k = 0; k < 3; ++k) c[k] *= inertia->mass;
    fill_mass(inertia->mass, c, I, M);
}

void mbsri_rigid_times(const mbsr_inertia *inertia, const double R[9], double factor,
                       const double x[6], double y[6])
{
    const mbsri_exact e = mbsri_exact_of(inertia);
    double c[3], turn_rate[3], spin[3], own[3], p[3];
    mbsri_rotate3(R, inertia->com, c);
    mbsri_unrotate3(R, x, turn_rate);
    for (int j = 0; j < 3; ++j) {
        mbsri_two sum = {0.0, 0.0};
        for (int k = 0; k < 3; ++k)
            sum = mbsri_two_add(sum,
                                mbsri_two_scale(e.tensor[mbsri_tensor_place(j, k)], turn_rate[k]));
        spin[j] = mbsri_two_value(sum);
    }
    mbsri_rotate3(R, spin, own);
    /* of the centre of mass */
    mbsri_cross3(x, c, p);
    for (int k = 0; k < 3; ++k) p[k] = inertia->mass * (p[k] + x[3 + k]);
    mbsri_add_cross3(c, p, own);
    for (int k = 0; k < 3; ++k) {
        y[k] += factor * own[k];
        y[3 + k] += factor * p[k];
    }
}

void mbsri_rigid_gyration(const double *M, const double V[6], double h[6])
{
    const double first[3] = {M[6 * 4 + 2], M[6 * 5], M[6 * 3 + 1]};
    double spin[3], sweep[3];
    for (int k = 0; k < 3; ++k) spin[k] = M[k] * V[0] + M[6 + k] * V[1] + M[12 + k] * V[2];
    mbsri_cross3(V, spin, h);
    mbsri_cross3(V, first, sweep);
    mbsri_cross3(V, sweep, h + 3);
}

void mbsri_rotated_mass(const double *A, const double R[9], double *M)
{
    for (int block = 0; block < 4; ++block) {
        const int row = 3 * (block & 1), column = 3 * (block >> 1);
        double B[9], turned[9];
        for (int j = 0; j < 3; ++j) {
            for (int k = 0; k < 3; ++k) B[3 * j + k] = A[6 * (column + j) + row + k];
        }
        rotate_tensor(R, B, turned);
        add_3x3(turned, row, column, M);
    }
}

void mbsri_rotated_gyration(const double *M, const double V[6], double h[6])
{
    double P[6] = {0.0}, sweep[6] = {0.0};
    mbsri_ax(6, 6, 1.0, M, V, P);
    mbsri_add_cross3(V, P, h);
    mbsri_add_cross3(V + 3, P + 3, h);
    mbsri_add_cross3(V, P + 3, h + 3);
    mbsri_cross3(V, V + 3, sweep + 3);
    mbsri_ax(6, 6, -1.0, M, sweep, h);
}

void mbsri_rotated_mass_rate(const double *M, const double omega[3], double *Mdot)
{
    double T[36];
    for (int j = 0; j < 6; ++j) {
        mbsri_cross3(omega, M + 6 * j, T + 6 * j);
        mbsri_cross3(omega, M + 6 * j + 3, T + 6 * j + 3);
    }
    for (int j = 0; j < 6; ++j) {
        for (int k = 0; k < 6; ++k) Mdot[6 * j + k] = T[6 * j + k] + T[6 * k + j];
    }
}
