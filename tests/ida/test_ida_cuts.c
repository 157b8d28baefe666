/* Loops in space cut at each of their joints: the same motion, in about as many steps.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "loops_run.h"

#include <stdbool.h>
#include <string.h>

/* A ring of links, all along the axes of the root and with their origins at `at` while q = 0; link
 * 0 is the ground. Joint k stands at `at[k]`, between link k - 1 and link k (the last, behind the
 * last link, leads to the ground): revolute about `axis`, or spherical where that is zero. */
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

/* Bennett's linkage, which moves although it has three rows too many. */
static void bennett(void **state)
{
    (void)state;
    const ring w = {.links = 3,
                    .at = {{0.0},
                           {0.45359612142557731, 0.89120736006143542, 0},
                           {0.31817129541419165, 0.34198096970568825, -0.20002621987275174},
                           {-0.6000000000000002, 0, 0},
                           {0, 0, 0}},
                    .axis = {{0.0},
                             {0.74992513493894164, -0.38168797500102275, 0.54030230586813977},
                             {0.33337703312125272, -0.39412236120301475, 0.85646209384130456},
                             {0, 0.50488259088473786, 0.8631880266903118},
                             {0, 0, 1}},
                    .mass = 1.0,
                    .thickness = 0.1};
    compare(&w, 2, 1.5, 1e3, 1.2);
}

/* Crank and rocker on skew axes, between them a rod with a ball joint at each end, which spins
 * about itself as nothing holds it: an old Newton matrix is wrong there first (src/ida/renewal.c).
 */
static void rssr(void **state)
{
    (void)state;
    const ring w = {.links = 3,
                    .at = {{0.0}, {0, 0, 0}, {0.3, 0.1, 0}, {1.1, 0.6, 0.5}, {1.2, -0.1, 0.2}},
                    .axis = {{0.0}, {0, 0, 1}, {0.0}, {0.0}, {0.6, 0, 0.8}},
                    .mass = 2.0,
                    .thickness = 0.1};
    compare(&w, 3, 2.0, 1e3, 1.3);
}

/* ---- several loops ---- */

enum { WEB_LINKS = 7, WEB_JOINTS = 8, WEB_CUTS = 4 };

/* Links along the axes of the root while q = 0, each a rod between two points; link 0 is the
 * ground. Joints stand between two of them: revolute about `axis`, spherical where that is zero.
 * `cut`: joints, so that the others make a tree. */
typedef struct web {
    int links, joints, cuts, loops;
    double from[WEB_LINKS][3], to[WEB_LINKS][3], mass[WEB_LINKS];
    struct {
        int a, b;
        double at[3], axis[3];
    } joint[WEB_JOINTS];
    int cut[WEB_CUTS][3]; /* ways to cut, `loops` joints each */
    double tie_from[3],
        tie_to[3]; /* of a massless rod from the ground to link `tied`, if that is not 0 */
    int tied;
    double spring_from[3], spring_to[3]; /* on the ground, on link `sprung`, if that is not 0 */
    int sprung;
} web;

static mbsr_frame seen(const web *w, int link, const double *at)
{
    const double *o = w->from[link];
    return link == 0 ? mbsr_frame_at(at[0], at[1], at[2])
                     : mbsr_frame_at(at[0] - o[0], at[1] - o[1], at[2] - o[2]);
}

static mbsr_joint web_joint(const web *w, int k, const mbsr_frame *A, const mbsr_frame *B)
{
    const double *axis = w->joint[k].axis;
    return test_largest(3, axis) > 0.0 ? mbsr_joint_revolute(A, B, axis)
                                       : mbsr_joint_spherical(A, B);
}

static mbsr_inertia web_rod(const web *w, int link)
{
    const ring one = {.at = {{0.0},
                             {w->from[link][0], w->from[link][1], w->from[link][2]},
                             {w->to[link][0], w->to[link][1], w->to[link][2]}},
                      .mass = w->mass[link],
                      .thickness = 0.1};
    return w->mass[link] > 0.0 ? rod(&one, 1) : mbsr_inertia_zero();
}

static bool is_cut(const web *w, int way, int k)
{
    bool cut = false;
    for (int l = 0; l < w->loops; ++l) cut = cut || w->cut[way][l] == k;
    return cut;
}

/* The joint of a link on one that is there already; false where there is none. */
static bool hang(loops *s, const web *w, int way, int *id, int link)
{
    for (int k = 0; k < w->joints; ++k) {
        const int a = w->joint[k].a, b = w->joint[k].b, other = a == link ? b : a;
        if (is_cut(w, way, k) || (a != link && b != link) || id[other] < MBSR_GROUND) continue;
        const mbsr_frame A = seen(w, other, w->joint[k].at), B = seen(w, link, w->joint[k].at);
        mbsr_body_def body = mbsr_default_body_def();
        body.parent = id[other];
        body.joint = web_joint(w, k, &A, &B);
        body.inertia = web_rod(w, link);
        assert_ok(mbsr_model_add_body(s->m, &body, id + link), mbsr_model_error(s->m));
        return true;
    }
    return false;
}

static void close_cuts(loops *s, const web *w, int way, const int *id)
{
    for (int l = 0; l < w->loops; ++l) {
        const int k = w->cut[way][l], a = w->joint[k].a, b = w->joint[k].b;
        const mbsr_frame A = seen(w, a, w->joint[k].at), B = seen(w, b, w->joint[k].at);
        const mbsr_joint joint = web_joint(w, k, &A, NULL);
        const mbsr_closure_def ball = mbsr_closure_ball(id[a], A.x, id[b], B.x);
        const int status =
            test_largest(3, w->joint[k].axis) > 0.0
                ? mbsr_model_add_loop_joint(s->m, "cut", id[a], &joint, id[b], &B, NULL, NULL)
                : mbsr_model_add_closure(s->m, &ball, NULL);
        assert_ok(status, mbsr_model_error(s->m));
    }
}

static void build_web(loops *s, const web *w, int way, int *id)
{
    int there = 0;
    loops_begin(s, NULL);
    id[0] = MBSR_GROUND;
    for (int link = 1; link <= w->links; ++link) id[link] = MBSR_GROUND - 1;
    while (there < w->links) {
        const int before = there;
        for (int link = 1; link <= w->links; ++link)
            there += id[link] < MBSR_GROUND && hang(s, w, way, id, link);
        assert_true(there > before);
    }
    close_cuts(s, w, way, id);
    const mbsr_frame tie = seen(w, w->tied, w->tie_to), spring = seen(w, w->sprung, w->spring_to);
    double length = 0.0;
    for (int k = 0; k < 3; ++k)
        length += (w->tie_to[k] - w->tie_from[k]) * (w->tie_to[k] - w->tie_from[k]);
    const mbsr_closure_def rod_of =
        mbsr_closure_distance(MBSR_GROUND, w->tie_from, id[w->tied], tie.x, sqrt(length));
    const mbsr_force_def force = mbsr_force_point_spring(MBSR_GROUND, w->spring_from, id[w->sprung],
                                                         spring.x, 2e4, 800.0, 0.5);
    if (w->tied) assert_ok(mbsr_model_add_closure(s->m, &rod_of, NULL), mbsr_model_error(s->m));
    if (w->sprung) assert_ok(mbsr_model_add_force(s->m, &force, NULL), mbsr_model_error(s->m));
    loops_finish(s);
    for (int link = 1; link <= w->links; ++link) {
        int q, nq;
        assert_ok(mbsr_body_coordinates(s->m, id[link], &q, &nq, NULL, NULL), NULL);
        if (nq == 4) s->q[q] = 1.0;
    }
}

static void compare_webs(const web *w, int link, double t, double lost, double most)
{
    static const double tolerance[] = {1e-4, 1e-6, 1e-8};
    double truth[3] = {0.0};
    long least = 0, largest = 0;
    for (int way = 0; way < w->cuts; ++way) {
        long steps = 0;
        for (int l = 2; l >= 0; --l) {
            loops s;
            int id[WEB_LINKS];
            double pose[MBSR_POSE_SIZE];
            build_web(&s, w, way, id);
            const loops_result r = loops_run(&s, tolerance[l], t);
            assert_int_equal(r.status, MBSR_OK);
            assert_ok(mbsr_body_pose(s.m, s.d, id[link], pose), mbsr_data_error(s.d));
            if (way == 0 && l == 2) memcpy(truth, pose + MBSR_POSE_X, sizeof truth);
            for (int j = 0; j < 3; ++j)
                assert_close(pose[MBSR_POSE_X + j], truth[j], lost * tolerance[l]);
            steps += r.steps;
            loops_free(&s);
        }
        least = way == 0 || steps < least ? steps : least;
        largest = steps > largest ? steps : largest;
    }
    assert_less((double)largest, most * (double)least);
}

/* A planar four-bar in space: three of its rows are redundant. */
static void four_bar(void **state)
{
    (void)state;
    const web w = {.links = 3,
                   .joints = 4,
                   .cuts = 4,
                   .loops = 1,
                   .from = {{0.0}, {0, 0, 0}, {0.3, 0.2, 0}, {1.2, 0, 0}},
                   .to = {{0.0}, {0.3, 0.2, 0}, {1.3, 0.8, 0}, {1.3, 0.8, 0}},
                   .mass = {0, 1, 2.5, 2},
                   .joint = {{0, 1, {0, 0, 0}, {0, 0, 1}},
                             {1, 2, {0.3, 0.2, 0}, {0, 0, 1}},
                             {2, 3, {1.3, 0.8, 0}, {0, 0, 1}},
                             {3, 0, {1.2, 0, 0}, {0, 0, 1}}},
                   .cut = {{0}, {1}, {2}, {3}}};
    compare_webs(&w, 2, 2.0, 1e3, 1.25);
}

/* Watt's six-bar linkage: two loops that share crank and coupler. */
static void six_bar(void **state)
{
    (void)state;
    const web w = {
        .links = 5,
        .joints = 7,
        .cuts = 4,
        .loops = 2,
        .from = {{0.0}, {0, 0, 0}, {0.3, 0.2, 0}, {1.2, 0, 0}, {0.9, 1.0, 0}, {2.0, 0, 0}},
        .to = {{0.0}, {0.3, 0.2, 0}, {0.9, 1.0, 0}, {1.1, 0.7, 0}, {1.9, 0.9, 0}, {1.9, 0.9, 0}},
        .mass = {0, 1, 2.5, 2, 1.5, 1},
        .joint = {{0, 1, {0, 0, 0}, {0, 0, 1}},
                  {1, 2, {0.3, 0.2, 0}, {0, 0, 1}},
                  {2, 3, {1.1, 0.7, 0}, {0, 0, 1}},
                  {3, 0, {1.2, 0, 0}, {0, 0, 1}},
                  {2, 4, {0.9, 1.0, 0}, {0, 0, 1}},
                  {4, 5, {1.9, 0.9, 0}, {0, 0, 1}},
                  {5, 0, {2.0, 0, 0}, {0, 0, 1}}},
        .cut = {{2, 5}, {3, 6}, {0, 5}, {1, 4}}};
    compare_webs(&w, 4, 1.0, 1e2, 1.3);
}

/* A double wishbone: two arms on the car, between them the knuckle on ball joints, a massless rod
 * to the rack, a spring on the lower arm. */
static void double_wishbone(void **state)
{
    (void)state;
    const web w = {.links = 3,
                   .joints = 4,
                   .cuts = 4,
                   .loops = 1,
                   .from = {{0.0}, {0, 0, 0}, {0, 0.25, 0.05}, {0, 0, 0.4}},
                   .to = {{0.0}, {0, 0, 0.4}, {0, 0.25, 0.32}, {0, 0.25, 0.32}},
                   .mass = {0, 4, 2.5, 12},
                   .joint = {{0, 1, {0, 0, 0}, {1, 0, 0.05}},
                             {1, 3, {0, 0, 0.4}, {0.0}},
                             {3, 2, {0, 0.25, 0.32}, {0.0}},
                             {2, 0, {0, 0.25, 0.05}, {1, 0, -0.04}}},
                   .cut = {{0}, {1}, {2}, {3}},
                   .tied = 3,
                   .tie_from = {0.12, 0.1, 0.05},
                   .tie_to = {0.12, 0.1, 0.38},
                   .sprung = 1,
                   .spring_from = {0, 0.45, 0.2},
                   .spring_to = {0, 0, 0.28}};
    compare_webs(&w, 3, 1.0, 1.0, 1.3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bricard),  cmocka_unit_test(bennett), cmocka_unit_test(rssr),
        cmocka_unit_test(four_bar), cmocka_unit_test(six_bar), cmocka_unit_test(double_wishbone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
