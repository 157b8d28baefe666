/* Loops in space cut at each of their joints: the same motion, in about as many steps.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops_run.h"

#include <stdbool.h>
#include <string.h>

/* A ring of links, all along the axes of the root and with their origins at `at` while q = 0; link 0 is
 * the ground. Joint k stands at `at[k]`, between link k - 1 and link k (the last, behind the last link,
 * leads to the ground): revolute about `axis`, or spherical where that is zero. */
typedef struct ring {
    int links;
    double at[7][3], axis[7][3], mass, thickness;
} ring;

static bool spherical(const ring *w, int k)
{
    return test_largest(3, w->axis[k]) == 0.0;
}

static mbsr_frame place(const ring *w, int link, int joint)
{
    const double none[3] = {0.0, 0.0, 0.0}, *from = link == 0 ? none : w->at[link];
    return mbsr_frame_at(w->at[joint][0] - from[0], w->at[joint][1] - from[1],
                         w->at[joint][2] - from[2]);
}

static mbsr_joint joint_of(const ring *w, int k, const mbsr_frame *A, const mbsr_frame *B)
{
    return spherical(w, k) ? mbsr_joint_spherical(A, B) : mbsr_joint_revolute(A, B, w->axis[k]);
}

/* A square rod from its joint to the next. */
static mbsr_inertia rod(const ring *w, int link)
{
    double com[3], tensor[6] = {0.0}, along[3], square = 0.0;
    for (int j = 0; j < 3; ++j) {
        along[j] = w->at[link + 1][j] - w->at[link][j];
        com[j] = 0.5 * along[j];
        square += along[j] * along[j];
    }
    const double thick = w->thickness * w->thickness, slender = w->mass * square / 12.0;
    for (int j = 0; j < 3; ++j)
        tensor[j] = w->mass * thick / 12.0 + slender - slender * along[j] * along[j] / square +
                    w->mass * thick / 12.0 * along[j] * along[j] / square;
    for (int j = 0; j < 3; ++j) {
        const int a = j == 2 ? 1 : 0, b = j == 0 ? 1 : 2; /* xy, xz, yz */
        tensor[3 + j] = (w->mass * thick / 12.0 - slender) * along[a] * along[b] / square;
    }
    return mbsr_inertia_rigid(w->mass, com, tensor);
}

/* Cut at joint `cut`, 1 .. links + 1; ids of the links to `id`. */
static void build(loops *s, const ring *w, int cut, int *id)
{
    id[0] = id[w->links + 1] = MBSR_GROUND;
    loops_begin(s, NULL);
    for (int k = 1; k <= w->links; ++k) {
        const int link = k < cut ? k : w->links + cut - k, joint = k < cut ? link : link + 1,
                  parent = k < cut ? link - 1 : (link + 1) % (w->links + 1);
        const mbsr_frame A = place(w, parent, joint), B = place(w, link, joint);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = id[parent];
        body.joint = joint_of(w, joint, &A, &B);
        body.inertia = rod(w, link);
        assert_ok(mbsr_model_add_body(s->m, &body, id + link), mbsr_model_error(s->m));
    }
    const int before = cut - 1, behind = cut % (w->links + 1);
    const mbsr_frame A = place(w, before, cut), B = place(w, behind, cut);
    if (spherical(w, cut)) {
        mbsr_closure_def ball = mbsr_closure_ball(id[before], A.x, id[behind], B.x);
        ball.name = "cut";
        assert_ok(mbsr_model_add_closure(s->m, &ball, NULL), mbsr_model_error(s->m));
    } else {
        const mbsr_joint hinge = mbsr_joint_revolute(&A, NULL, w->axis[cut]);
        assert_ok(
            mbsr_model_add_loop_joint(s->m, "cut", id[before], &hinge, id[behind], &B, NULL, NULL),
            mbsr_model_error(s->m));
    }
    loops_finish(s);
    for (int k = 1; k <= w->links; ++k) {
        int q, nq;
        assert_ok(mbsr_body_coordinates(s->m, id[k], &q, &nq, NULL, NULL), NULL);
        if (nq == 4) s->q[q] = 1.0;
    }
}

/* The motion of link `seen` from rest, to t; steps differ by a factor of at most `most`. */
static void compare(const ring *w, int seen, double t, double lost, double most)
{
    static const double tolerance[] = {1e-4, 1e-6, 1e-8};
    double truth[3] = {0.0};
    long first = 0;
    for (int cut = 1; cut <= w->links + 1; ++cut) {
        long steps = 0;
        for (int l = 2; l >= 0; --l) {
            loops s;
            int id[8];
            double pose[MBSR_POSE_SIZE];
            build(&s, w, cut, id);
            const loops_result r = loops_run(&s, tolerance[l], t);
            assert_int_equal(r.status, MBSR_OK);
            assert_ok(mbsr_body_pose(s.m, s.d, id[seen], pose), mbsr_data_error(s.d));
            if (cut == 1 && l == 2) memcpy(truth, pose + MBSR_POSE_X, sizeof truth);
            for (int j = 0; j < 3; ++j)
                assert_close(pose[MBSR_POSE_X + j], truth[j], lost * tolerance[l]);
            assert_less(fabs(r.energy), lost * tolerance[l] * 10.0);
            steps += r.steps;
            loops_free(&s);
        }
        if (cut == 1) first = steps;
        assert_less((double)steps, most * (double)first);
        assert_less((double)first, most * (double)steps);
    }
}

/* Bricard's linkage, of which one row is redundant in every position. */
static void bricard(void **state)
{
    (void)state;
    const ring w = {
        .links = 5,
        .at = {{0.0}, {0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}},
        .axis = {{0.0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}},
        .mass = 1.0,
        .thickness = 0.1};
    compare(&w, 3, 2.0, 1e3, 1.3);
}

/* Crank and rocker on skew axes, between them a rod with a ball joint at each end, which spins about
 * itself as nothing holds it. Cut where the rod hangs on the crank, the momenta of both have larger high
 * derivatives, and the driver takes half as many steps again as where it hangs on the rocker, which swings. */
static void rssr(void **state)
{
    (void)state;
    const ring w = {.links = 3,
                    .at = {{0.0}, {0, 0, 0}, {0.3, 0.1, 0}, {1.1, 0.6, 0.5}, {1.2, -0.1, 0.2}},
                    .axis = {{0.0}, {0, 0, 1}, {0.0}, {0.0}, {0.6, 0, 0.8}},
                    .mass = 2.0,
                    .thickness = 0.1};
    compare(&w, 3, 2.0, 1e3, 1.6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bricard),
        cmocka_unit_test(rssr),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
