/* Random trees of turned frames: see turned.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "turned.h"

#include <math.h>
#include <string.h>

void dsyev_(const char *jobz, const char *uplo, const int *n, double *a, const int *lda, double *w,
            double *work, const int *lwork, int *info, size_t jobz_length, size_t uplo_length);

void turned_begin(turned *s, uint64_t seed, const units *of)
{
    *s = (turned){.of = of, .rng = test_seed(seed)};
    assert_ok(mbsr_model_create(NULL, &s->m, NULL), NULL);
}

void turned_about(double R[9], int axis, double angle)
{
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    const double c = cos(angle), s = sin(angle);
    for (int k = 0; k < 3; ++k) {
        const double x = R[3 * i + k], y = R[3 * j + k];
        R[3 * i + k] = c * x + s * y;
        R[3 * j + k] = c * y - s * x;
    }
}

mbsr_frame turned_frame(turned *s)
{
    const double half = 0.5 * s->of->length, right = 2.0 * atan(1.0);
    mbsr_frame f = mbsr_frame_identity();
    for (int k = 2; k >= 0; --k) f.x[k] = half * test_integer(&s->rng, 0, 2);
    const int turns = test_integer(&s->rng, 0, 2);
    for (int k = 0; k < turns; ++k) {
        const int axis = test_integer(&s->rng, 0, 2), kind = test_integer(&s->rng, 0, 5);
        const double angle = kind < 4    ? right * test_integer(&s->rng, 0, 3)
                             : kind == 4 ? 0.5 * right * test_integer(&s->rng, 0, 7)
                                         : 3.0 * test_uniform(&s->rng);
        turned_about(f.R, axis, angle);
    }
    return f;
}

static void add_coordinates(turned *s, int count, bool turns)
{
    for (int k = 0; k < count; ++k) {
        const double size = turns ? 1.0 : s->of->length;
        s->turns[s->nu++] = turns;
        s->q[s->nq++] =
            test_integer(&s->rng, 0, 1) ? 0.0 : 0.25 * size * test_integer(&s->rng, -4, 4);
    }
}

static void add_quaternion(turned *s)
{
    static const double some[][4] = {{1.0}, {0.6, 0.0, 0.8}, {0.0, 1.0}, {0.5, 0.5, -0.5, 0.5}};
    memcpy(s->q + s->nq, some[test_integer(&s->rng, 0, 3)], sizeof some[0]);
    s->nq += 4;
    for (int k = 0; k < 3; ++k) s->turns[s->nu++] = true;
}

static mbsr_joint joint(turned *s, int kind)
{
    static const double axes[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    const mbsr_frame f = turned_frame(s);
    const int a = test_integer(&s->rng, 0, 2), b = (a + test_integer(&s->rng, 1, 2)) % 3;
    switch (kind) {
    case 0: add_coordinates(s, 1, true); return mbsr_joint_revolute(&f, NULL, axes[a]);
    case 1: add_coordinates(s, 1, false); return mbsr_joint_prismatic(&f, NULL, axes[a]);
    case 2: add_coordinates(s, 2, true); return mbsr_joint_universal(&f, NULL, axes[a], axes[b]);
    case 3:
        add_coordinates(s, 1, true), add_coordinates(s, 1, false);
        return mbsr_joint_cylindrical(&f, NULL, axes[a]);
    case 4: add_coordinates(s, 3, false); return mbsr_joint_translational(&f, NULL);
    case 5: add_quaternion(s); return mbsr_joint_spherical(&f, NULL);
    case 6:
        add_coordinates(s, 2, false), add_coordinates(s, 1, true);
        return mbsr_joint_in_plane(&f, NULL);
    default: add_quaternion(s), add_coordinates(s, 3, false); return mbsr_joint_free(&f, NULL);
    }
}

void turned_add(turned *s, int parent, int kind, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    const int i = s->bodies++, q = s->nq;
    s->parent[i] = parent;
    s->first[i] = s->nu;
    body.parent = parent;
    body.joint = joint(s, kind);
    body.inertia = inertia;
    s->n[i] = s->nu - s->first[i];
    s->plain[i] = s->nq - q == s->n[i];
    assert_ok(mbsr_model_add_body(s->m, &body, NULL), mbsr_model_error(s->m));
}

void turned_force(turned *s, mbsr_force_def force)
{
    assert_ok(mbsr_model_add_force(s->m, &force, NULL), mbsr_model_error(s->m));
}

mbsr_inertia turned_rigid(turned *s)
{
    const double L = s->of->length, m = 2.0 * s->of->mass, com[3] = {0.1 * L, 0.2 * L, -0.1 * L},
                 tensor[6] = {m * L * L, 1.5 * m * L * L, 2.0 * m * L * L};
    return mbsr_inertia_rigid(m, com, tensor);
}

void turned_finish(turned *s)
{
    assert_ok(mbsr_model_finish(s->m), mbsr_model_error(s->m));
    assert_ok(mbsr_data_create(s->m, &s->d, NULL), NULL);
}

void turned_free(turned *s)
{
    mbsr_data_destroy(s->d);
    mbsr_model_destroy(s->m);
}

int turned_null(int n, const double *A, double *vectors)
{
    double w[TURNED_MOST], work[4 * TURNED_MOST];
    const int size = 4 * TURNED_MOST;
    int info, null = 0;
    if (n == 0) return 0;
    memcpy(vectors, A, (size_t)(n * n) * sizeof *A);
    dsyev_("V", "U", &n, vectors, &n, w, work, &size, &info, 1, 1);
    assert_int_equal(info, 0);
    for (int k = 0; k < n; ++k) {
        if (fabs(w[k]) > 1e-13 && w[k] < 1e-7) return -1;
        null += w[k] < 1e-7;
    }
    return null;
}
