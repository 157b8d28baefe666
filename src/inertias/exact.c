/* Inertia tensors in twofold precision: see exact.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "inertias/exact.h"

#include "algebra/space3.h"

#include <math.h>

/* What a tensor given by its entries may be wrong by, in units of the machine precision: nothing
 * where it is diagonal, since each moment is what somebody stated. */
static double unsure(const double tensor[6])
{
    const bool diagonal =
        tensor[MBSR_XY] == 0.0 && tensor[MBSR_XZ] == 0.0 && tensor[MBSR_YZ] == 0.0;
    return diagonal ? 0.0 : fabs(tensor[MBSR_XX]) + fabs(tensor[MBSR_YY]) + fabs(tensor[MBSR_ZZ]);
}

mbsri_exact mbsri_exact_of(const mbsr_inertia *inertia)
{
    const bool exact = inertia->exact != 0;
    mbsri_exact e = {.mass = inertia->mass,
                     .lost = exact ? inertia->lost : unsure(inertia->tensor)};
    for (int k = 0; k < 3; ++k)
        e.com[k] = mbsri_two_sum(inertia->com[k], exact ? inertia->com_rest[k] : 0.0);
    for (int k = 0; k < 6; ++k)
        e.tensor[k] = mbsri_two_sum(inertia->tensor[k], exact ? inertia->tensor_rest[k] : 0.0);
    return e;
}

/* a - b, rounded; 0 where that is no number. */
static double rounding_of(mbsri_two a, double b)
{
    const double left = (a.hi - b) + a.lo;
    return isfinite(left) ? left : 0.0;
}

void mbsri_exact_settle(const mbsri_exact *exact, mbsr_inertia *inertia)
{
    inertia->exact = 1;
    inertia->lost = exact->lost;
    for (int k = 0; k < 3; ++k) inertia->com_rest[k] = rounding_of(exact->com[k], inertia->com[k]);
    for (int k = 0; k < 6; ++k)
        inertia->tensor_rest[k] = rounding_of(exact->tensor[k], inertia->tensor[k]);
}

void mbsri_exact_rotate(const double R[9], const mbsri_two x[3], mbsri_two y[3])
{
    mbsri_two turned[3] = {{0.0, 0.0}};
    mbsri_two a[9];
    for (int k = 0; k < 9; ++k) a[k] = mbsri_two_scale(x[k / 3], R[k]);
    for (int k = 0; k < 9; ++k) turned[k % 3] = mbsri_two_add(turned[k % 3], a[k]);
    for (int k = 0; k < 3; ++k) y[k] = turned[k];
}

/* trace / divisor 1 - A: from I to P with 2, back with 1. */
static void tensor_to_second_moment(double divisor, mbsri_two A[6])
{
    const mbsri_two sum = mbsri_two_add(mbsri_two_add(A[MBSR_XX], A[MBSR_YY]), A[MBSR_ZZ]),
                    part = {sum.hi / divisor, sum.lo / divisor};
    for (int k = 0; k < 6; ++k) A[k] = mbsri_two_negative(A[k]);
    for (int k = 0; k < 3; ++k)
        A[mbsri_tensor_place(k, k)] = mbsri_two_add(A[mbsri_tensor_place(k, k)], part);
}

void mbsri_exact_turn(const double R[9], mbsri_two tensor[6])
{
    mbsri_two RP[3][3]; /* columns */
    tensor_to_second_moment(2.0, tensor);
    for (int j = 0; j < 3; ++j) {
        const mbsri_two column[3] = {tensor[mbsri_tensor_place(0, j)],
                                     tensor[mbsri_tensor_place(1, j)],
                                     tensor[mbsri_tensor_place(2, j)]};
        mbsri_exact_rotate(R, column, RP[j]);
    }
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k <= j; ++k) {
            mbsri_two sum = {0.0, 0.0};
            for (int l = 0; l < 3; ++l)
                sum = mbsri_two_add(sum, mbsri_two_scale(RP[l][j], R[3 * l + k]));
            tensor[mbsri_tensor_place(j, k)] = sum;
        }
    }
    tensor_to_second_moment(1.0, tensor);
}

void mbsri_exact_parallel_axes(double mass, const mbsri_two c[3], mbsri_two tensor[6])
{
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k <= j; ++k) {
            const mbsri_two moment = mbsri_two_scale(mbsri_two_times(c[j], c[k]), mass);
            mbsri_two *const to = tensor + mbsri_tensor_place(j, k);
            if (j != k) {
                *to = mbsri_two_subtract(*to, moment);
                continue;
            }
            for (int l = 0; l < 3; ++l) {
                mbsri_two *const other = tensor + mbsri_tensor_place(l, l);
                if (l != j) *other = mbsri_two_add(*other, moment);
            }
        }
    }
}

/* The axis v of the smallest moment, where that is much below the others: what I v = 0 would make
 * it. */
static void least_axis(const mbsri_two tensor[6], double v[3])
{
    double I[9], most = 0.0;
    for (int k = 0; k < 9; ++k) I[k] = mbsri_two_value(tensor[mbsri_tensor_place(k / 3, k % 3)]);
    for (int k = 0; k < 3; ++k) v[k] = 0.0;
    for (int k = 0; k < 3; ++k) {
        double across[3];
        mbsri_cross3(I + 3 * ((k + 1) % 3), I + 3 * ((k + 2) % 3), across);
        const double size = mbsri_norm3(across);
        if (size <= most) continue;
        most = size;
        for (int l = 0; l < 3; ++l) v[l] = across[l] / size;
    }
}

bool mbsri_exact_hides_moment(const mbsr_inertia *inertia)
{
    static const double digits = 1e-6;
    mbsri_exact e = mbsri_exact_of(inertia);
    mbsri_two moment = {0.0, 0.0};
    double v[3], size = 0.0;
    mbsri_exact_parallel_axes(e.mass, e.com, e.tensor);
    least_axis(e.tensor, v);
    for (int k = 0; k < 9; ++k) {
        const mbsri_two entry = e.tensor[mbsri_tensor_place(k / 3, k % 3)];
        const mbsri_two part = mbsri_two_scale(mbsri_two_scale(entry, v[k / 3]), v[k % 3]);
        moment = mbsri_two_add(moment, part);
        size += fabs(part.hi);
    }
    return moment.hi < digits * size;
}

void mbsri_exact_mass(const mbsr_inertia *inertia, const double R[9], mbsri_two M[36])
{
    mbsri_exact e = mbsri_exact_of(inertia);
    mbsri_exact_turn(R, e.tensor);
    mbsri_exact_rotate(R, e.com, e.com);
    mbsri_exact_parallel_axes(e.mass, e.com, e.tensor);
    for (int k = 0; k < 36; ++k) M[k] = (mbsri_two){0.0, 0.0};
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) M[6 * j + k] = e.tensor[mbsri_tensor_place(j, k)];
        M[7 * (3 + j)].hi = e.mass;
    }
    /* [m c]x at rows of the moments, columns of the linear part, and its transpose */
    for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        const mbsri_two first = mbsri_two_scale(e.com[k], e.mass);
        M[6 * (3 + a) + b] = M[6 * b + 3 + a] = first;
        M[6 * (3 + b) + a] = M[6 * a + 3 + b] = mbsri_two_negative(first);
    }
}
