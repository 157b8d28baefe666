/* Inertias as files give them: see solids.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/solids.h"
#include "algebra/space3.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* A rotation in the plane of axes p and q that makes A[p][q] zero, as columns of R; A = R^T A R. */
static void rotate(double A[3][3], double R[9], int p, int q)
{
    const double theta = (A[q][q] - A[p][p]) / (2.0 * A[p][q]),
                 tangent = (theta < 0.0 ? -1.0 : 1.0) / (fabs(theta) + sqrt(theta * theta + 1.0)),
                 c = 1.0 / sqrt(tangent * tangent + 1.0), s = tangent * c;
    for (int k = 0; k < 3; ++k) {
        const double x = A[k][p], y = A[k][q];
        A[k][p] = c * x - s * y, A[k][q] = s * x + c * y;
    }
    for (int k = 0; k < 3; ++k) {
        const double x = A[p][k], y = A[q][k], u = R[3 * p + k], v = R[3 * q + k];
        A[p][k] = c * x - s * y, A[q][k] = s * x + c * y;
        R[3 * p + k] = c * u - s * v, R[3 * q + k] = s * u + c * v;
    }
}

static const int beside[3][2] = {{1, 2}, {0, 2}, {0, 1}};

static int largest_product(double A[3][3])
{
    int largest = 0;
    for (int k = 1; k < 3; ++k)
        if (fabs(A[beside[k][0]][beside[k][1]]) > fabs(A[beside[largest][0]][beside[largest][1]]))
            largest = k;
    return largest;
}

double mbsri_principal(const double t[6], double small, double moments[3], double axes[9])
{
    double A[3][3] = {{t[0], t[3], t[4]}, {t[3], t[1], t[5]}, {t[4], t[5], t[2]}}, left = 0.0;
    const mbsr_frame identity = mbsr_frame_identity();
    memcpy(axes, identity.R, sizeof identity.R);
    for (int turn = 0; turn < 90; ++turn) { /* Jacobi: the largest product becomes zero */
        const double size = fmax(fabs(A[0][0]), fmax(fabs(A[1][1]), fabs(A[2][2])));
        const int k = largest_product(A);
        left = fabs(A[beside[k][0]][beside[k][1]]);
        if (left <= small * size) {
            left = size > 0.0 ? left / size : 0.0;
            break;
        }
        rotate(A, axes, beside[k][0], beside[k][1]);
    }
    for (int k = 0; k < 3; ++k) moments[k] = A[k][k];
    for (int k = 0; k < 3; ++k) { /* in order, by quarter turns */
        const int i = k % 2;
        if (!(moments[i] + 1e-12 * fabs(moments[i]) < moments[i + 1])) continue;
        const double larger = moments[i + 1];
        moments[i + 1] = moments[i], moments[i] = larger;
        for (int l = 0; l < 3; ++l) {
            const double first = axes[3 * i + l];
            axes[3 * i + l] = axes[3 * i + 3 + l], axes[3 * i + 3 + l] = -first;
        }
    }
    return left;
}

void mbsri_moments(const double tensor[6], double moments[3])
{
    double axes[9];
    mbsri_principal(tensor, MBSRI_NO_PRODUCT, moments, axes);
    for (int k = 0; k < 2; ++k) { /* equal ones may stand in any order there */
        for (int l = 0; l < 2 - k; ++l) {
            const double first = moments[l];
            if (first > moments[l + 1]) moments[l] = moments[l + 1], moments[l + 1] = first;
        }
    }
}

/* ---- tensors with negative moments, which no constructor takes ---- */

typedef struct raw {
    double mass, com[3], tensor[9]; /* about the origin, in the body */
} raw;

/* y (3 x 3) = R x R^T, columns */
static void rotated_tensor(const double R[9], const double x[9], double y[9])
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            double sum = 0.0;
            for (int k = 0; k < 3; ++k) {
                for (int l = 0; l < 3; ++l) sum += R[3 * k + i] * x[3 * l + k] * R[3 * l + j];
            }
            y[3 * j + i] = sum;
        }
    }
}

static int raw_inertia(void *user, double t, const double *p, const double *V, double *M, double *h)
{
    const raw *b = user;
    double I[9], s[3], L[3], spin[3];
    (void)t;
    rotated_tensor(p + MBSR_POSE_R, b->tensor, I);
    for (int k = 0; k < 3; ++k) {
        s[k] = 0.0;
        for (int l = 0; l < 3; ++l) s[k] += b->mass * p[MBSR_POSE_R + 3 * l + k] * b->com[l];
    }
    const double S[9] = {0.0, s[2], -s[1], -s[2], 0.0, s[0], s[1], -s[0], 0.0};
    for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) {
            M[6 * c + r] = I[3 * c + r];
            M[6 * (3 + c) + r] = S[3 * c + r];
            M[6 * c + 3 + r] = -S[3 * c + r];
        }
        M[6 * (3 + c) + 3 + c] = b->mass;
    }
    for (int k = 0; k < 3; ++k) L[k] = I[k] * V[0] + I[3 + k] * V[1] + I[6 + k] * V[2];
    mbsri_cross3(V, L, h);
    mbsri_cross3(V, s, spin);
    mbsri_cross3(V, spin, h + 3);
    return 0;
}

static mbsr_inertia raw_of(mbsri_arena *arena, double mass, const mbsr_frame *frame,
                           const double t[6])
{
    raw *b = mbsri_arena_take(arena, sizeof *b);
    const double own[9] = {t[0], t[3], t[4], t[3], t[1], t[5], t[4], t[5], t[2]};
    if (!b) return mbsr_inertia_zero();
    b->mass = mass;
    memcpy(b->com, frame->x, sizeof b->com);
    rotated_tensor(frame->R, own, b->tensor);
    const double square = b->com[0] * b->com[0] + b->com[1] * b->com[1] + b->com[2] * b->com[2];
    for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r)
            b->tensor[3 * c + r] += mass * ((r == c ? square : 0.0) - b->com[r] * b->com[c]);
    }
    return mbsr_inertia_function(raw_inertia, b);
}

mbsr_inertia mbsri_solid(mbsri_arena *arena, double mass, const mbsr_frame *frame,
                         const double tensor[6])
{
    double moments[3];
    mbsri_moments(tensor, moments);
    if (moments[0] < -1e-6 * fabs(moments[2]) || moments[2] < 0.0)
        return raw_of(arena, mass, frame, tensor);
    const bool diagonal = tensor[3] == 0.0 && tensor[4] == 0.0 && tensor[5] == 0.0;
    mbsr_inertia inertia = mbsr_inertia_rigid_unchecked(mass, NULL, tensor);
    if (diagonal) inertia.lost = 0.0;
    return mbsr_inertia_in_frame(frame, inertia);
}

bool mbsri_stated_solid(mbsri_scene *s, const mbsri_element *e, double mass,
                        const mbsr_frame *frame, const double tensor[6], mbsr_inertia *inertia)
{
    double moments[3];
    if (mass < 0.0) return mbsri_file_refuse(s, e, "its mass is %g", mass);
    mbsri_moments(tensor, moments);
    if (moments[0] < -1e-6 * fabs(moments[2]))
        mbsri_file_find(s, e, "a principal moment of inertia is negative; kept as it is");
    else if (moments[2] > (1.0 + 1e-6) * (moments[0] + moments[1]))
        mbsri_file_find(s, e,
                        "no body has these moments of inertia (one is larger than the sum of the "
                        "others); kept as they are");
    *inertia = mbsri_solid(s->arena, mass, frame, tensor);
    return true;
}

void mbsri_find_products(mbsri_scene *s, const mbsri_element *e, double dropped)
{
    if (dropped > MBSRI_DROPPED)
        mbsri_file_find(
            s, e, "products of inertia that MuJoCo drops are kept: %.0e of the largest moment",
            dropped);
}

bool mbsri_solid_of(const mbsr_inertia *inertia, double *mass, double centre[3], double tensor[6])
{
    static const int place[6] = {0, 4, 8, 3, 6, 7};
    const raw *b = inertia->user;
    *mass = inertia->mass;
    memcpy(centre, inertia->com, 3 * sizeof *centre);
    memcpy(tensor, inertia->tensor, 6 * sizeof *tensor);
    if (inertia->kind != MBSR_INERTIA_FUNCTION || inertia->function != raw_inertia)
        return inertia->kind == MBSR_INERTIA_NOT_GIVEN || inertia->kind == MBSR_INERTIA_SPATIAL ||
               inertia->kind == MBSR_INERTIA_PARTICLE ||
               (inertia->kind == MBSR_INERTIA_MATRIX && !inertia->matrix); /* zero, stated */
    *mass = b->mass;
    memcpy(centre, b->com, 3 * sizeof *centre);
    double square = 0.0;
    for (int k = 0; k < 3; ++k) square += centre[k] * centre[k];
    for (int k = 0; k < 6; ++k) {
        const int i = place[k] % 3, j = place[k] / 3;
        tensor[k] = b->tensor[place[k]] - *mass * ((i == j ? square : 0.0) - centre[i] * centre[j]);
    }
    return true;
}

bool mbsri_shape_solid(mbsr_shape_kind kind, const double size[3], double *volume, double tensor[6])
{
    const double r = size[0], h = size[1];
    memset(tensor, 0, 6 * sizeof *tensor);
    switch (kind) {
    case MBSR_SHAPE_BOX:
    case MBSR_SHAPE_ELLIPSOID: {
        const bool box = kind == MBSR_SHAPE_BOX;
        *volume = (box ? 8.0 : 4.0 / 3.0 * pi) * size[0] * size[1] * size[2];
        for (int k = 0; k < 3; ++k) {
            const double a = size[(k + 1) % 3], b = size[(k + 2) % 3];
            tensor[k] = *volume * (a * a + b * b) / (box ? 3.0 : 5.0);
        }
        return true;
    }
    case MBSR_SHAPE_SPHERE:
        *volume = 4.0 / 3.0 * pi * r * r * r;
        tensor[0] = tensor[1] = tensor[2] = 0.4 * *volume * r * r;
        return true;
    case MBSR_SHAPE_CYLINDER:
        *volume = 2.0 * pi * r * r * h;
        tensor[0] = tensor[1] = *volume * (3.0 * r * r + 4.0 * h * h) / 12.0;
        tensor[2] = 0.5 * *volume * r * r;
        return true;
    case MBSR_SHAPE_CAPSULE: {
        const double tube = 2.0 * pi * r * r * h, ball = 4.0 / 3.0 * pi * r * r * r;
        *volume = tube + ball;
        /* the half balls' centres of mass are 3/8 r beyond the ends */
        tensor[0] = tensor[1] =
            tube * (3.0 * r * r + 4.0 * h * h) / 12.0 + ball * (0.4 * r * r + h * h + 0.75 * h * r);
        tensor[2] = 0.5 * tube * r * r + 0.4 * ball * r * r;
        return true;
    }
    case MBSR_SHAPE_PLANE:
    case MBSR_SHAPE_HEIGHTS:
    case MBSR_SHAPE_MESH: break;
    }
    *volume = 0.0;
    return false;
}
