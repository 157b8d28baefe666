/* The index report and the start on generated models whose verdicts follow from reasoning, in four
 * systems of units: networks of springs and dampers between bodies that move along or about one
 * axis (carts, beads, drive trains), chains of links with masses at some tips, gimbals.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "expect.h"
#include "units.h"

#include <stdbool.h>

enum { MOST = 10, EDGES = 30 };

/* What a model must be said to have. undetermined_in: bit 1 << id of bodies that undetermined
 * directions concern. */
typedef struct verdict {
    int dynamic, damped, elastic, undetermined;
    unsigned undetermined_in;
} verdict;

typedef struct scene {
    const units *in;
    test_rng rng;
    mbsr_model *model;
    mbsr_data *data;
    double q[2 * MOST], u[2 * MOST];
    double force;  /* size of the forces of springs and dampers */
    bool friction; /* which may hold less than the load */
} scene;

static const mbsr_planar_frame origin = {0};

static double decades(scene *s, double most)
{
    return pow(10.0, most * test_uniform(&s->rng));
}

static bool chance(scene *s, double share)
{
    return test_uniform(&s->rng) < 2.0 * share - 1.0;
}

static double stiffness(const scene *s)
{
    return s->in->mass / (s->in->time * s->in->time);
}

static double damping(const scene *s)
{
    return s->in->mass / s->in->time;
}

static void add(scene *s, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(s->model, &body, NULL), mbsr_model_error(s->model));
}

static void force(scene *s, mbsr_force_def def)
{
    assert_ok(mbsr_model_add_force(s->model, &def, NULL), mbsr_model_error(s->model));
}

/* ---- networks ---- */

typedef struct network {
    int nodes, edges;
    int parent[MOST];
    bool massive[MOST];
    int a[EDGES], b[EDGES]; /* b: GROUND or a node */
    bool spring[EDGES], damper[EDGES];
} network;

typedef enum realisation {
    ABSOLUTE,
    RELATIVE,
    PLANE_SHAFTS,
    SPACE_SHAFTS,
    BEADS,
    NETWORKS
} realisation;

static network draw_network(scene *s, realisation kind)
{
    network n = {.nodes = test_integer(&s->rng, 2, MOST)};
    for (int i = 0; i < n.nodes; ++i) {
        n.parent[i] = test_integer(&s->rng, -1, i - 1);
        if (chance(s, 0.5)) n.parent[i] = i - 1;
        n.massive[i] = chance(s, 0.4);
    }
    const int extra = kind == SPACE_SHAFTS ? 0 : n.nodes / 2;
    for (int k = 0; k < n.nodes + extra; ++k) {
        const int a = k < n.nodes ? k : test_integer(&s->rng, 0, n.nodes - 1);
        const int b = k < n.nodes ? n.parent[k] : test_integer(&s->rng, -1, n.nodes - 1);
        const bool spring = chance(s, 0.5), damper = chance(s, 0.4);
        if (a == b || (!spring && !damper)) continue;
        n.a[n.edges] = a;
        n.b[n.edges] = b;
        n.spring[n.edges] = spring;
        n.damper[n.edges++] = damper;
    }
    return n;
}

static int root_of(const int *group, int i)
{
    while (group[i] != i) i = group[i];
    return i;
}

/* Joins the groups of nodes tied by dampers (or springs); group MOST is what stands still: the
 * ground and, as far as massless directions go, the masses. */
static void join(const network *n, const bool *tied, int *group)
{
    for (int k = 0; k < n->edges; ++k) {
        if (!tied[k]) continue;
        const int b = n->b[k] < 0 ? MOST : n->b[k];
        const int low = root_of(group, n->a[k]), high = root_of(group, b);
        if (low == high) continue;
        if (low > high)
            group[high] = low;
        else
            group[low] = high;
    }
}

static int count_groups(const network *n, const int *group)
{
    int count = 0;
    for (int i = 0; i < n->nodes; ++i) count += root_of(group, i) == i;
    return count;
}

/* Directions move massless nodes alone. Dampers leave those free that move all nodes they tie
 * together; of these, springs leave those that move all they tie together. */
static verdict judge_network(const network *n, realisation kind)
{
    int group[MOST + 1], free = 0;
    verdict v = {0};
    for (int i = 0; i <= MOST; ++i) group[i] = i;
    for (int i = 0; i < n->nodes; ++i) {
        if (n->massive[i]) group[i] = MOST;
        v.dynamic += n->massive[i];
        free += !n->massive[i];
    }
    join(n, n->damper, group);
    const int clusters = count_groups(n, group);
    join(n, n->spring, group);
    v.undetermined = count_groups(n, group);
    v.elastic = clusters - v.undetermined;
    v.damped = free - clusters;
    for (int i = 0; i < n->nodes; ++i) {
        const bool relative = kind != ABSOLUTE;
        const int own = root_of(group, i),
                  below = relative && n->parent[i] >= 0 ? root_of(group, n->parent[i]) : MOST;
        if (own != below) v.undetermined_in |= 1u << i;
    }
    return v;
}

/* The joint and inertia of a node. */
static void add_node(scene *s, const network *n, int i, realisation kind)
{
    const double L = s->in->length, m = s->in->mass * decades(s, 2.0);
    const int parent = kind == ABSOLUTE ? MBSR_GROUND : n->parent[i];
    const mbsr_inertia none = mbsr_inertia_zero();
    if (kind == PLANE_SHAFTS) {
        add(s, parent, mbsr_joint_planar_revolute(origin, origin),
            n->massive[i] ? mbsr_inertia_planar(m, NULL, m * L * L) : none);
    } else if (kind == SPACE_SHAFTS) {
        const double moments[6] = {m * L * L, m * L * L, m * L * L, 0, 0, 0};
        const mbsr_inertia light =
            chance(s, 0.5) ? none
                           : mbsr_inertia_rod(m, (double[3]){0, 0, 0}, (double[3]){0, 0, 0.7 * L});
        add(s, parent, mbsr_joint_revolute(NULL, NULL, (double[3]){0, 0, 1}),
            n->massive[i] ? mbsr_inertia_rigid(m, NULL, moments) : light);
    } else {
        add(s, parent,
            kind == BEADS ? mbsr_joint_point_free()
                          : mbsr_joint_point(origin, MBSR_X, 0, NULL, NULL),
            n->massive[i] ? mbsr_inertia_particle(m) : none);
    }
}

/* An edge between nodes along an axis; neighbours in the tree by their joint where they are. */
static void add_edge(scene *s, const network *n, int k, realisation kind, int axis)
{
    const bool turning = kind == PLANE_SHAFTS || kind == SPACE_SHAFTS;
    const double length = turning ? 1.0 : s->in->length,
                 arm = turning ? s->in->length * s->in->length : 1.0,
                 rest = 0.2 * length * test_uniform(&s->rng),
                 c = n->spring[k] ? arm * stiffness(s) * decades(s, 3.0) : 0.0,
                 d = n->damper[k] ? arm * damping(s) * decades(s, 3.0) : 0.0;
    const bool joint = kind == SPACE_SHAFTS ||
                       (kind != ABSOLUTE && n->parent[n->a[k]] == n->b[k] && chance(s, 0.7));
    s->force += c * length + d * length / s->in->time;
    if (joint && d > 0.0 && chance(s, 0.2)) {
        const double speed = length / s->in->time;
        force(s, mbsr_force_joint_friction(n->a[k], axis, d * speed, speed * decades(s, 1.0)));
        if (c > 0.0) force(s, mbsr_force_joint_spring(n->a[k], axis, c, 0.0, rest));
        s->friction = true;
    } else if (joint) {
        force(s, mbsr_force_joint_spring(n->a[k], axis, c, d, rest));
    } else {
        force(s, mbsr_force_axis_spring(n->a[k], n->b[k] < 0 ? MBSR_GROUND : n->b[k],
                                        turning ? 2 : axis, c, d, rest));
    }
}

static verdict make_network(scene *s, realisation kind)
{
    network n = draw_network(s, kind);
    const bool turning = kind == PLANE_SHAFTS || kind == SPACE_SHAFTS;
    const int axes = kind == BEADS ? 2 : 1;
    for (int i = 0; i < n.nodes; ++i) add_node(s, &n, i, kind);
    verdict all = {0};
    for (int axis = 0; axis < axes; ++axis) {
        if (axis > 0) { /* other springs between the same nodes */
            for (int k = 0; k < n.edges; ++k)
                n.spring[k] = chance(s, 0.5), n.damper[k] = chance(s, 0.4);
        }
        for (int k = 0; k < n.edges; ++k) add_edge(s, &n, k, kind, axis);
        const verdict v = judge_network(&n, kind);
        all.dynamic += v.dynamic;
        all.damped += v.damped;
        all.elastic += v.elastic;
        all.undetermined += v.undetermined;
        all.undetermined_in |= v.undetermined_in;
    }
    for (int k = 0; k < axes * n.nodes; ++k) {
        const double length = turning ? 1.0 : s->in->length;
        s->q[k] = length * test_uniform(&s->rng);
        s->u[k] = length / s->in->time * test_uniform(&s->rng);
    }
    return all;
}

/* ---- chains of links ---- */

/* Links in the plane from hinge to hinge, masses at the tips of some; dampers and relaxed springs
 * on some angles, from ground. A mass holds two directions of the links between it and the mass
 * before (one, if there is only one link), where they are not in line. On the others of these links
 * each damper takes one direction, then each spring on a link without damper. */
static verdict make_links(scene *s)
{
    const double L = s->in->length;
    const int links = test_integer(&s->rng, 2, MOST);
    double angle = 0.0;
    verdict v = {0};
    bool loose[MOST + 1] = {false};
    for (int first = 0, i = 0, dampers = 0, springs = 0; i < links; ++i) {
        const double length = L * decades(s, 0.3);
        const bool mass = chance(s, 0.4), damper = chance(s, 0.4), spring = chance(s, 0.4);
        static double before;
        const mbsr_planar_frame at = {i > 0 ? before : 0.0, 0.0, 0.0};
        before = length;
        add(s, i - 1, mbsr_joint_planar_revolute(at, origin),
            mass ? mbsr_inertia_planar(s->in->mass * decades(s, 1.0), (double[2]){length, 0}, 0.0)
                 : mbsr_inertia_zero());
        s->q[i] = (0.4 + 0.8 * fabs(test_uniform(&s->rng))) * (chance(s, 0.5) ? 1.0 : -1.0);
        s->u[i] = 0.0;
        angle += s->q[i];
        if (damper)
            force(s, mbsr_force_axis_spring(i, MBSR_GROUND, 2, 0.0,
                                            L * L * damping(s) * decades(s, 2.0), 0.0));
        if (spring)
            force(s, mbsr_force_axis_spring(i, MBSR_GROUND, 2,
                                            L * L * stiffness(s) * decades(s, 2.0), 0.0, angle));
        dampers += damper;
        springs += spring && !damper;
        loose[i] = !damper && !spring;
        if (!mass && i + 1 < links) continue;
        const int count = i + 1 - first,
                  held = !mass       ? 0
                         : count < 2 ? count
                                     : 2,
                  free = count - held, damped = dampers < free ? dampers : free,
                  elastic = springs < free - damped ? springs : free - damped;
        v.dynamic += held;
        v.damped += damped;
        v.elastic += elastic;
        v.undetermined += free - damped - elastic;
        for (int k = first; k <= i && free == damped + elastic; ++k) loose[k] = false;
        first = i + 1;
        dampers = springs = 0;
    }
    for (int i = 0; i < links; ++i) {
        if (loose[i] || (i > 0 && loose[i - 1])) v.undetermined_in |= 1u << i;
    }
    return v;
}

/* ---- gimbals ---- */

/* Rings without mass about x, y and z; in them nothing, a rod through the centre, which may spin
 * about itself, or a solid. Springs are relaxed. */
static verdict make_gimbal(scene *s)
{
    const double L = s->in->length, m = s->in->mass * decades(s, 1.0), J = m * L * L;
    const int content = test_integer(&s->rng, 0, 2);
    const double end[3] = {0.6 * L, 0.5 * L, -0.7 * L}, start[3] = {-0.6 * L, -0.5 * L, 0.7 * L};
    bool damper[3], spring[3];
    int dampers = 0, springs = 0;
    verdict v = {0};
    for (int i = 0; i < 3; ++i) {
        const double axis[3] = {i == 0, i == 1, i == 2};
        add(s, i - 1, mbsr_joint_revolute(NULL, NULL, axis),
            i < 2 || content == 0 ? mbsr_inertia_zero()
            : content == 1        ? mbsr_inertia_rod(m, start, end)
                                  : mbsr_inertia_rigid(m, NULL, (double[6]){J, 1.2 * J, 0.9 * J}));
        s->q[i] = 0.3 + 0.8 * fabs(test_uniform(&s->rng));
        s->u[i] = 0.0;
        damper[i] = chance(s, 0.3);
        spring[i] = chance(s, 0.3);
        dampers += damper[i];
        springs += spring[i] && !damper[i];
        if (damper[i] || spring[i])
            force(s, mbsr_force_joint_spring(
                         i, 0, spring[i] ? L * L * stiffness(s) * decades(s, 2.0) : 0.0,
                         damper[i] ? L * L * damping(s) * decades(s, 2.0) : 0.0, s->q[i]));
    }
    const int free = content == 0 ? 3 : content == 1 ? 1 : 0;
    v.dynamic = 3 - free;
    v.damped = dampers < free ? dampers : free;
    v.elastic = springs < free - v.damped ? springs : free - v.damped;
    v.undetermined = free - v.damped - v.elastic;
    for (int i = 0; i < 3 && v.undetermined > 0; ++i) {
        if (content == 1 || (!damper[i] && !spring[i])) v.undetermined_in |= 1u << i;
    }
    return v;
}

/* ---- the comparison ---- */

static unsigned bodies_in(const mbsr_index_report *report, mbsr_direction_kind kind)
{
    unsigned bits = 0;
    for (int l = 0; l < report->directions; ++l) {
        const mbsr_direction *direction = report->direction + l;
        if (direction->kind != kind) continue;
        for (int k = 0; k < direction->terms; ++k) bits |= 1u << direction->term[k].body;
    }
    return bits;
}

/* Every direction has terms, and force elements just where it is determined. */
static bool well_formed(const mbsr_index_report *report)
{
    bool fine = true;
    for (int l = 0; l < report->directions; ++l) {
        const mbsr_direction *direction = report->direction + l;
        fine = fine && direction->terms > 0 &&
               (direction->forces > 0) == (direction->kind != MBSR_DIRECTION_UNDETERMINED);
    }
    return fine;
}

static bool same(const verdict *v, const mbsr_index_report *r)
{
    const int index = v->undetermined > 0 ? -1 : v->elastic > 0 ? 2 : v->damped > 0 ? 1 : 0;
    return r->dynamic == v->dynamic && r->damped == v->damped && r->elastic == v->elastic &&
           r->undetermined == v->undetermined && r->index == index && well_formed(r) &&
           bodies_in(r, MBSR_DIRECTION_UNDETERMINED) == v->undetermined_in;
}

/* Sizes of positions and velocities, 1 or more of those given. */
static double far_off(const scene *s, const double *y)
{
    const int n = mbsr_model_nu(s->model);
    double q = 0.0, u = 0.0, far_q = 0.0, far_u = 0.0;
    for (int k = 0; k < n; ++k) {
        q = fmax(q, fabs(s->q[k]));
        u = fmax(u, fabs(s->u[k]));
        far_q = fmax(far_q, fabs(y[k]));
        far_u = fmax(far_u, fabs(y[2 * n + k]));
    }
    return fmax(1.0, fmax(far_q / q, far_u / u));
}

/* A start succeeds just where all is determined; where friction may hold less than the load it is
 * told from that. Another start from there finds the forces balanced. */
static bool starts(scene *s, const verdict *v)
{
    double y[8 * MOST], yp[8 * MOST];
    mbsr_consistent_info info;
    assert_ok(mbsr_dae_pack(s->model, s->data, MBSR_DAE_MOMENTUM, 0.0, s->q, s->u, y),
              mbsr_data_error(s->data));
    int status = mbsr_dae_consistent(s->model, s->data, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &info);
    if (v->undetermined > 0) return status == MBSR_UNDETERMINED;
    if (s->friction && status == MBSR_NO_CONVERGENCE) return true;
    if (status) {
        print_error("%s\n", mbsr_data_error(s->data)->text);
        return false;
    }
    status = mbsr_dae_consistent(s->model, s->data, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, &info);
    const double size = s->force * far_off(s, y);
    if (!status && info.force_defect <= 1e-7 * size) return true;
    print_error("again: status %d, force %g beside %g\n", status, info.force_defect, size);
    return false;
}

enum { LINKS = NETWORKS, GIMBALS, FAMILIES };

/* One model in one system; 1 if the report or the start is wrong. */
static int wrong(int family, int seed, const units *in)
{
    scene s = {.in = in, .rng = test_seed((uint64_t)(1000 * family + seed))};
    mbsr_index_report *report;
    assert_int_equal(mbsr_model_create(NULL, &s.model, NULL), MBSR_OK);
    const verdict v = family == LINKS     ? make_links(&s)
                      : family == GIMBALS ? make_gimbal(&s)
                                          : make_network(&s, (realisation)family);
    assert_ok(mbsr_model_finish(s.model), mbsr_model_error(s.model));
    assert_int_equal(mbsr_data_create(s.model, &s.data, NULL), MBSR_OK);
    assert_ok(mbsr_index_report_create(s.model, s.data, 0.0, s.q, s.u, &report),
              mbsr_data_error(s.data));
    const bool right = same(&v, report);
    if (!right) {
        print_error("family %d, seed %d (%s): dynamic %d damped %d elastic %d undetermined %d in "
                    "%x, expected %d %d %d %d in %x\n%s\n",
                    family, seed, in->name, report->dynamic, report->damped, report->elastic,
                    report->undetermined, bodies_in(report, MBSR_DIRECTION_UNDETERMINED), v.dynamic,
                    v.damped, v.elastic, v.undetermined, v.undetermined_in, report->text);
    }
    const bool started = family >= NETWORKS || starts(&s, &v);
    if (!started) print_error("family %d, seed %d (%s): start\n", family, seed, in->name);
    mbsr_index_report_destroy(s.model, report);
    mbsr_data_destroy(s.data);
    mbsr_model_destroy(s.model);
    return !right || !started;
}

static void verdicts_and_starts_are_those_of_reasoning(void **state)
{
    (void)state;
    int count = 0;
    for (int family = 0; family < FAMILIES; ++family) {
        for (int seed = 0; seed < (test_long() ? 75 : test_seeds(6, 18)); ++seed) {
            for (size_t l = 0; l < sizeof systems / sizeof systems[0]; ++l)
                count += wrong(family, seed, systems + l);
        }
    }
    assert_int_equal(count, 0);
}

/* Accelerations of a start, over the unit of length in which it is computed. */
static void accelerate(realisation kind, int seed, double length, double *udot)
{
    const units in = {"some length, kg, s", length, 1.0, 1.0};
    scene s = {.in = &in, .rng = test_seed((uint64_t)(1000 * (int)kind + seed))};
    double y[4 * MOST], yp[4 * MOST];
    assert_int_equal(mbsr_model_create(NULL, &s.model, NULL), MBSR_OK);
    assert_int_equal(make_network(&s, kind).undetermined, 0);
    assert_ok(mbsr_model_finish(s.model), mbsr_model_error(s.model));
    assert_int_equal(mbsr_data_create(s.model, &s.data, NULL), MBSR_OK);
    assert_true(mbsr_dae_size(s.model, MBSR_DAE_MOMENTUM) <= 4 * MOST);
    assert_ok(mbsr_dae_pack(s.model, s.data, MBSR_DAE_MOMENTUM, 0.0, s.q, s.u, y),
              mbsr_data_error(s.data));
    assert_ok(mbsr_dae_consistent(s.model, s.data, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
              mbsr_data_error(s.data));
    const int nu = mbsr_model_nu(s.model);
    for (int k = 0; k < nu; ++k) udot[k] = yp[2 * nu + k] / length;
    for (int k = nu; k < MOST; ++k) udot[k] = 0.0;
    mbsr_data_destroy(s.data);
    mbsr_model_destroy(s.model);
}

/* Springs and dampers of very different sizes along one line: the equations are linear, so that
 * motions are as large as the unit of length is small. */
static void lengths_do_not_matter(void **state)
{
    (void)state;
    static const struct {
        realisation kind;
        int seed;
    } draw[] = {{ABSOLUTE, 158}, {RELATIVE, 14}, {RELATIVE, 993}};
    static const double length[] = {1e-2, 3.162277, 78.0, 100.0};
    for (size_t l = 0; l < sizeof draw / sizeof draw[0]; ++l) {
        double expected[MOST], udot[MOST], largest = 0.0;
        accelerate(draw[l].kind, draw[l].seed, 1.0, expected);
        for (int k = 0; k < MOST; ++k) largest = fmax(largest, fabs(expected[k]));
        for (size_t j = 0; j < sizeof length / sizeof length[0]; ++j) {
            accelerate(draw[l].kind, draw[l].seed, length[j], udot);
            for (int k = 0; k < MOST; ++k) assert_close(udot[k], expected[k], 1e-6 * largest);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(verdicts_and_starts_are_those_of_reasoning),
        cmocka_unit_test(lengths_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
