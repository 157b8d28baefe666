/* One mechanism told in several ways: several axes in one body or with bodies without mass between
 * them, frames elsewhere on the bodies, axes more that are locked, bodies that hang on their joint
 * or fly and are welded to it, springs as forces or as closures, in other units. Starts, counts of
 * the index report and accelerations are the same.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "turned.h"

#include <math.h>
#include <string.h>

enum { PARTS = 4, AXES = 3, MOST = 24, NUMBERS = 128 };
enum { SPLIT = 1, MOVED = 2, LOCKED = 4, CUT = 8, LOOSE = 16 };

typedef struct axis {
    bool slides;
    double along[3];
} axis;

/* On `parent`, in SI; coordinates from `first` on. */
typedef struct part {
    int parent, axes, first, mass;
    axis axis[AXES];
    mbsr_frame A;
} part;

typedef struct mechanism {
    turned draw;                  /* its random numbers */
    int parts, coordinates, a, b; /* ends of a bushing and of a loop, which begin at one place */
    bool weight, loop;
    part part[PARTS];
    mbsr_frame A, B;
    double q[MOST], u[MOST], k[MOST], d[MOST], stiffness[6], damping[6], length;
} mechanism;

static mbsr_frame product(mbsr_frame a, mbsr_frame b)
{
    return mbsr_frame_product(&a, &b);
}

static mbsr_frame inverse(mbsr_frame a)
{
    return mbsr_frame_inverse(&a);
}

static mbsr_frame moved_by(const axis *a, double q)
{
    mbsr_frame f = mbsr_frame_rotated(NULL, a->along, a->slides ? 0.0 : q);
    for (int k = 0; k < 3 && a->slides; ++k) f.x[k] = a->along[k] * q;
    return f;
}

static mbsr_frame place_of(const mechanism *s, int i)
{
    if (i < 0) return mbsr_frame_identity();
    mbsr_frame f = product(place_of(s, s->part[i].parent), s->part[i].A);
    for (int k = 0; k < s->part[i].axes; ++k)
        f = product(f, moved_by(s->part[i].axis + k, s->q[s->part[i].first + k]));
    return f;
}

/* ---- random mechanisms ---- */

/* A hinge or a slide, two hinges, a hinge that slides, three slides, or two with a hinge. */
static void make_axes(test_rng *rng, part *p)
{
    static const int count[] = {1, 1, 2, 2, 3, 3};
    const int kind = test_integer(rng, 0, 5), along = test_integer(rng, 0, 2);
    p->axes = count[kind];
    for (int k = 0; k < p->axes; ++k) {
        p->axis[k].slides = kind == 1 || kind == 4 || (kind == 3 && k == 1) || (kind == 5 && k < 2);
        p->axis[k].along[kind == 3 ? along : (along + k) % 3] = 1.0;
    }
}

static double some_slope(test_rng *rng)
{
    return test_integer(rng, 0, 1) ? 0.0 : 1.0 + test_integer(rng, 0, 4);
}

static void make(mechanism *s, uint64_t seed)
{
    *s = (mechanism){.draw = {.of = systems, .rng = test_seed(seed)}};
    test_rng *rng = &s->draw.rng;
    const bool moves = test_integer(rng, 0, 2) > 0;
    s->parts = test_integer(rng, 1, PARTS);
    for (int i = 0; i < s->parts; ++i) {
        part *p = s->part + i;
        p->parent = test_integer(rng, 0, 1) ? i - 1 : test_integer(rng, -1, i - 1);
        p->A = turned_frame(&s->draw);
        p->first = s->coordinates;
        p->mass = test_integer(rng, 0, 7);
        make_axes(rng, p);
        for (int k = 0; k < p->axes; ++k) {
            const int at = s->coordinates++;
            s->q[at] = test_integer(rng, 0, 1) ? 0.0 : 0.25 * test_integer(rng, -4, 4);
            s->u[at] = moves ? test_uniform(rng) : 0.0;
            s->k[at] = some_slope(rng), s->d[at] = some_slope(rng);
        }
    }
    s->a = test_integer(rng, -1, s->parts - 1), s->b = test_integer(rng, -1, s->parts - 1);
    s->weight = test_integer(rng, 0, 1);
    s->loop = s->a != s->b && test_integer(rng, 0, 2) == 0;
    s->length = 0.5 * test_integer(rng, 0, 2); /* 0: a ball */
    for (int k = 0; k < 6; ++k) s->stiffness[k] = some_slope(rng), s->damping[k] = some_slope(rng);
    const mbsr_frame f = turned_frame(&s->draw);
    s->A = product(inverse(place_of(s, s->a)), f);
    s->B = product(inverse(place_of(s, s->b)), f);
}

/* ---- told ---- */

typedef struct model {
    const mechanism *of;
    const units *in;
    turned draw;
    int ways, body[PARTS], cut[PARTS], owner[MOST], place[MOST], at_q[MOST], at_u[MOST];
    mbsr_frame seat[PARTS], end[PARTS]; /* frames of a part in its body, in the one that is cut */
    mbsr_model *m;
    mbsr_data *d;
    int nq, nu;
} model;

static bool chosen(model *t, int way)
{
    return (t->ways & way) && test_integer(&t->draw.rng, 0, 1);
}

static mbsr_frame in_units(const model *t, mbsr_frame f)
{
    for (int k = 0; k < 3; ++k) f.x[k] *= t->in->length;
    return f;
}

static int add_body(model *t, int parent, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    int id;
    body.parent = parent;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(t->m, &body, &id), mbsr_model_error(t->m));
    return id;
}

static mbsr_inertia inertia_of(model *t, int kind, mbsr_frame seat)
{
    const double L = t->in->length, m = 2.0 * t->in->mass, end[3] = {0.0, 0.0, L},
                 middle[3] = {0.0, 0.0, 0.5 * L};
    const mbsr_frame at = in_units(t, seat);
    t->draw.of = t->in;
    switch (kind) {
    case 0: return mbsr_inertia_in_frame(&at, mbsr_inertia_particle(m));
    case 1: return mbsr_inertia_in_frame(&at, mbsr_inertia_point_mass(m, middle));
    case 2: return mbsr_inertia_in_frame(&at, mbsr_inertia_rod(m, NULL, end));
    case 3: return mbsr_inertia_in_frame(&at, turned_rigid(&t->draw));
    default: return mbsr_inertia_zero();
    }
}

static mbsr_frame some_seat(model *t)
{
    t->draw.of = systems;
    return chosen(t, MOVED) ? turned_frame(&t->draw) : mbsr_frame_identity();
}

/* Axes from `first` on of a part on A of `parent`, some with one more in front that is locked. */
static int add_axes(model *t, int parent, mbsr_frame A, const part *p, int first, int count,
                    int mass, mbsr_frame *seat)
{
    mbsr_axis axes[AXES + 1] = {{.kind = MBSR_AXIS_ROTATION}};
    const axis *own = p->axis + first;
    const int more = chosen(t, LOCKED);
    axis extra = {.slides = !own->slides};
    extra.along[test_integer(&t->draw.rng, 0, 2)] = 1.0;
    const double value = 0.25 * test_integer(&t->draw.rng, -3, 3);
    if (more) A = product(A, inverse(moved_by(&extra, value)));
    for (int k = 0; k < count + more; ++k) {
        const axis *a = k < more ? &extra : own + k - more;
        axes[k].kind = a->slides ? MBSR_AXIS_TRANSLATION : MBSR_AXIS_ROTATION;
        memcpy(axes[k].direction, a->along, sizeof a->along);
    }
    *seat = some_seat(t);
    const mbsr_frame from = in_units(t, A), to = in_units(t, *seat);
    const int id =
        add_body(t, parent, mbsr_joint_compound(&from, &to, count + more, axes, NULL, NULL),
                 inertia_of(t, mass, *seat));
    if (more)
        assert_ok(mbsr_model_lock(t->m, id, 0, value * (extra.slides ? t->in->length : 1.0)),
                  mbsr_model_error(t->m));
    for (int k = 0; k < count; ++k) {
        t->owner[p->first + first + k] = id;
        t->place[p->first + first + k] = k + more;
        t->at_q[p->first + first + k] = k; /* within the joint, for now */
    }
    return id;
}

static void tell_part(model *t, int i)
{
    const part *p = t->of->part + i;
    const bool flies = chosen(t, CUT);
    int body = p->parent < 0 ? MBSR_GROUND : t->body[p->parent], done = 0;
    mbsr_frame A = p->parent < 0 ? p->A : product(t->seat[p->parent], p->A);
    while (done < p->axes) {
        const int left = p->axes - done,
                  count = t->ways & SPLIT ? test_integer(&t->draw.rng, 1, left) : left;
        const bool last = done + count == p->axes;
        body = add_axes(t, body, A, p, done, count, last && !flies ? p->mass : -1, t->end + i);
        A = t->end[i];
        done += count;
    }
    t->body[i] = t->cut[i] = body;
    t->seat[i] = t->end[i];
    if (!flies) return;
    t->seat[i] = some_seat(t);
    const mbsr_frame to = in_units(t, t->seat[i]);
    t->body[i] =
        add_body(t, MBSR_GROUND, mbsr_joint_free(NULL, &to), inertia_of(t, p->mass, t->seat[i]));
}

static void add_closure(model *t, mbsr_closure_def closure)
{
    assert_ok(mbsr_model_add_closure(t->m, &closure, NULL), mbsr_model_error(t->m));
}

static void add_force(model *t, mbsr_force_def force)
{
    assert_ok(mbsr_model_add_force(t->m, &force, NULL), mbsr_model_error(t->m));
}

/* The frame of a bushing and of a loop on body a or b. */
static mbsr_frame frame_on(const model *t, int i, mbsr_frame f)
{
    return in_units(t, i < 0 ? f : product(t->seat[i], f));
}

static void tell_elements(model *t)
{
    const mechanism *s = t->of;
    const double L = t->in->length, T = t->in->time, k = t->in->mass / (T * T), g = L / (T * T);
    double stiffness[6], damping[6];
    for (int i = 0; i < s->parts; ++i) {
        const mbsr_frame a = in_units(t, t->end[i]), b = in_units(t, t->seat[i]);
        if (t->cut[i] != t->body[i])
            add_closure(t, mbsr_closure_weld(t->cut[i], &a, t->body[i], &b));
        for (int l = 0; l < s->part[i].axes; ++l) {
            const int at = s->part[i].first + l;
            const bool slides = s->part[i].axis[l].slides;
            const double unit = slides ? k : k * L * L;
            mbsr_force_def spring =
                mbsr_force_joint_spring(t->owner[at], t->place[at], s->k[at] * unit,
                                        s->d[at] * unit * T, s->q[at] * (slides ? L : 1.0));
            if (s->k[at] > 0.0 && chosen(t, LOOSE)) spring.as_closure = MBSR_SPRING_LOOSE;
            if (s->k[at] + s->d[at] > 0.0) add_force(t, spring);
        }
    }
    for (int l = 0; l < 6; ++l) {
        stiffness[l] = s->stiffness[l] * k * (l < 3 ? L * L : 1.0);
        damping[l] = s->damping[l] * k * T * (l < 3 ? L * L : 1.0);
    }
    const int a = s->a < 0 ? MBSR_GROUND : t->body[s->a],
              b = s->b < 0 ? MBSR_GROUND : t->body[s->b];
    const mbsr_frame A = frame_on(t, s->a, s->A), B = frame_on(t, s->b, s->B),
                     far = mbsr_frame_at(s->length, 0.0, 0.0),
                     beside = frame_on(t, s->b, product(s->B, far));
    if (s->loop && s->length > 0.0)
        add_closure(t, mbsr_closure_distance(a, A.x, b, beside.x, s->length * L));
    else if (s->loop)
        add_closure(t, mbsr_closure_ball(a, A.x, b, B.x));
    else if (a != b)
        add_force(t, mbsr_force_bushing(a, &A, b, &B, stiffness, damping));
    if (s->weight) add_force(t, mbsr_force_gravity(1.3 * g, 2.1 * g, -9.81 * g));
}

static double unit_of(const model *t, int at)
{
    for (int i = 0; i < t->of->parts; ++i) {
        const part *p = t->of->part + i;
        if (at >= p->first && at < p->first + p->axes)
            return p->axis[at - p->first].slides ? t->in->length : 1.0;
    }
    return 1.0;
}

static void tell(model *t, const mechanism *s, const units *in, int ways, uint64_t seed)
{
    *t = (model){.of = s, .in = in, .ways = ways, .draw = {.rng = test_seed(seed)}};
    assert_ok(mbsr_model_create(NULL, &t->m, NULL), NULL);
    for (int i = 0; i < s->parts; ++i) tell_part(t, i);
    tell_elements(t);
    assert_ok(mbsr_model_finish(t->m), mbsr_model_error(t->m));
    assert_ok(mbsr_data_create(t->m, &t->d, NULL), NULL);
    t->nq = mbsr_model_nq(t->m), t->nu = mbsr_model_nu(t->m);
    for (int c = 0; c < s->coordinates; ++c) {
        int q, u;
        assert_ok(mbsr_body_coordinates(t->m, t->owner[c], &q, NULL, &u, NULL), NULL);
        t->at_u[c] = u + t->at_q[c], t->at_q[c] += q;
    }
}

/* ---- what is said ---- */

/* In SI: q, u and u' after the start, those that completion finds, and what the report counts. */
typedef struct said {
    int status, report, completion, damped, elastic, undetermined;
    double twist[PARTS][6]; /* of the frames of parts, in the state given */
    double q[MOST], u[MOST], udot[MOST], completed[MOST];
} said;

/* w <- the quaternion of R: of 4 w w^T the column that is largest. */
static void quaternion_of(const double *R, double *w)
{
    const double A[4][4] = {{1.0 + R[0] + R[4] + R[8], R[5] - R[7], R[6] - R[2], R[1] - R[3]},
                            {R[5] - R[7], 1.0 + R[0] - R[4] - R[8], R[1] + R[3], R[2] + R[6]},
                            {R[6] - R[2], R[1] + R[3], 1.0 - R[0] + R[4] - R[8], R[5] + R[7]},
                            {R[1] - R[3], R[2] + R[6], R[5] + R[7], 1.0 - R[0] - R[4] + R[8]}};
    int most = 0;
    for (int k = 1; k < 4; ++k) most = A[k][k] > A[most][most] ? k : most;
    for (int k = 0; k < 4; ++k) w[k] = A[most][k] / (2.0 * sqrt(A[most][most]));
}

/* Coordinates as they are told; what flies moves as its cut body. */
static void state_of(const model *t, const said *first, double *q, double *u)
{
    for (int k = 0; k < t->nq; ++k) q[k] = k < t->nu ? u[k] = 0.0 : 0.0;
    for (int c = 0; c < t->of->coordinates; ++c) {
        q[t->at_q[c]] = t->of->q[c] * unit_of(t, c);
        u[t->at_u[c]] = t->of->u[c] * unit_of(t, c) / t->in->time;
    }
    for (int i = 0; i < t->of->parts; ++i) {
        if (t->cut[i] == t->body[i]) continue;
        int at, rate;
        assert_ok(mbsr_body_coordinates(t->m, t->body[i], &at, NULL, &rate, NULL), NULL);
        const mbsr_frame f = in_units(t, place_of(t->of, i));
        quaternion_of(f.R, q + at);
        memcpy(q + at + 4, f.x, sizeof f.x);
        for (int k = 0; k < 6; ++k)
            u[rate + k] = first->twist[i][k] * (k < 3 ? 1.0 : t->in->length) / t->in->time;
    }
}

/* `first`: what another telling says, for what flies here; NULL: nothing does. */
static void ask(const model *t, const said *first, said *x)
{
    double q[NUMBERS], u[NUMBERS], y[4 * NUMBERS], yp[4 * NUMBERS], udot[NUMBERS];
    const double T = t->in->time;
    mbsr_index_report *report = NULL;
    mbsr_completion *completion;
    *x = (said){0};
    state_of(t, first, q, u);
    assert_ok(mbsr_stage_positions(t->m, t->d, 0.0, q), mbsr_data_error(t->d));
    assert_ok(mbsr_stage_velocities(t->m, t->d, u), mbsr_data_error(t->d));
    for (int i = 0; i < t->of->parts && !first; ++i)
        assert_ok(mbsr_body_twist(t->m, t->d, t->body[i], x->twist[i]), mbsr_data_error(t->d));
    assert_ok(mbsr_dae_pack(t->m, t->d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(t->d));
    x->status = mbsr_dae_consistent(t->m, t->d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
    if (x->status) return;
    memcpy(q, y, (size_t)t->nq * sizeof *q);
    memcpy(u, y + t->nq + t->nu, (size_t)t->nu * sizeof *u);
    x->report = mbsr_index_report_create(t->m, t->d, 0.0, q, u, &report);
    if (report) {
        x->damped = report->damped, x->elastic = report->elastic;
        x->undetermined = report->undetermined;
    }
    mbsr_index_report_destroy(t->m, report);
    assert_ok(mbsr_completion_create(t->m, NULL, &completion, NULL), NULL);
    x->completion = mbsr_completion_dynamics(completion, t->d, 0.0, q, u, NULL, udot, NULL);
    mbsr_completion_destroy(completion);
    for (int c = 0; c < t->of->coordinates; ++c) {
        const double unit = unit_of(t, c);
        x->q[c] = q[t->at_q[c]] / unit;
        x->u[c] = u[t->at_u[c]] / unit * T;
        x->udot[c] = yp[t->nq + t->nu + t->at_u[c]] / unit * T * T;
        x->completed[c] = x->completion ? 0.0 : udot[t->at_u[c]] / unit * T * T;
    }
}

static double distance(int n, const double *a, const double *b)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) most = fmax(most, fabs(a[k] - b[k]));
    return most / (1.0 + test_largest(n, a));
}

/* Whether two say different things; refusals are no answer. */
static bool differ(const mechanism *s, const said *a, const said *b)
{
    const int n = s->coordinates;
    const bool counted = !a->report && !b->report, completed = !a->completion && !b->completion;
    if (a->status || b->status) return false;
    return (counted && (a->damped != b->damped || a->elastic != b->elastic ||
                        a->undetermined != b->undetermined)) ||
           !(distance(n, a->q, b->q) < 1e-6) || !(distance(n, a->u, b->u) < 1e-5) ||
           !(distance(n, a->udot, b->udot) < 1e-4) ||
           (completed && !(distance(n, a->completed, b->completed) < 1e-4));
}

/* How many tellings say something else than the plain one; those that are refused are counted. */
static int check(uint64_t seed, int ways, int *told, int *refused)
{
    enum { TELLINGS = 3 };
    mechanism s;
    model t;
    said first, other;
    int wrong = 0;
    make(&s, seed);
    tell(&t, &s, systems, 0, seed);
    ask(&t, NULL, &first);
    mbsr_data_destroy(t.d), mbsr_model_destroy(t.m);
    for (int k = 0; k < TELLINGS && !first.status; ++k) {
        tell(&t, &s, systems + (seed + (uint64_t)k) % 4, ways, 8 * seed + (uint64_t)k);
        ask(&t, &first, &other);
        const bool off = differ(&s, &first, &other);
        if (off)
            print_error("seed %d, telling %d, %s: u' off by %.1e, completed by %.1e, report %d %d "
                        "%d, of %d %d %d\n",
                        (int)seed, k, t.in->name, distance(s.coordinates, first.udot, other.udot),
                        distance(s.coordinates, first.completed, other.completed), other.damped,
                        other.elastic, other.undetermined, first.damped, first.elastic,
                        first.undetermined);
        wrong += off;
        ++*told;
        *refused += other.status != 0;
        mbsr_data_destroy(t.d), mbsr_model_destroy(t.m);
    }
    return wrong;
}

static void what_is_told_twice_is_the_same(void **state)
{
    (void)state;
    enum { FIRST = 10 };
    const int seeds = test_long() ? 590 : test_seeds_short(10, 50);
    int wrong = 0, told = 0, refused = 0;
    for (int seed = FIRST; seed < FIRST + seeds; ++seed) {
        wrong += check((uint64_t)seed, SPLIT | MOVED | LOCKED, &told, &refused);
        wrong += check((uint64_t)seed, SPLIT | MOVED | LOCKED | CUT | LOOSE, &told, &refused);
    }
    assert_int_equal(wrong, 0);
    assert_true(told > 2 * seeds && 20 * refused < told);
}

/* Points on axes but for rounding of frames; D of several rates in one of which there is nothing
 * but rounding; loop forces and springs as closures where elastic directions are. */
static void tellings_that_were_wrong(void **state)
{
    (void)state;
    static const struct {
        uint64_t seed;
        int ways;
    } given[] = {{53, 7}, {112, 7}, {393, 7}, {122, 15}, {199, 15}, {1271, 8}, {90, 31}, {438, 31}};
    int wrong = 0, told = 0, refused = 0;
    for (size_t k = 0; k < sizeof given / sizeof given[0]; ++k)
        wrong += check(given[k].seed, given[k].ways, &told, &refused);
    assert_int_equal(wrong, 0);
    assert_int_equal(refused, 0);
}

/* A mass that falls on two equal springs in series, without mass between, as forces or closures. */
static void springs_in_series_share(void **state)
{
    (void)state;
    static const double along[3] = {0.0, 0.0, 1.0};
    for (int how = 0; how < 16; ++how) {
        const units *of = systems + how / 4;
        const double T = of->time, k = 3.0 * of->mass / (T * T), g = 9.81 * of->length / (T * T);
        double q[2] = {0.0}, u[2] = {0.0}, y[16], yp[16], udot[2], lambda[2];
        model t = {.in = of};
        mbsr_completion *completion;
        assert_ok(mbsr_model_create(NULL, &t.m, NULL), NULL);
        add_body(&t, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, along), mbsr_inertia_zero());
        add_body(&t, 0, mbsr_joint_prismatic(NULL, NULL, along), mbsr_inertia_particle(of->mass));
        for (int i = 0; i < 2; ++i) {
            mbsr_force_def spring = mbsr_force_joint_spring(i, 0, k, 0.0, 0.0);
            if (how >> i & 1) spring.as_closure = MBSR_SPRING_LOOSE;
            add_force(&t, spring);
        }
        add_force(&t, mbsr_force_gravity(0.0, 0.0, -g));
        assert_ok(mbsr_model_finish(t.m), mbsr_model_error(t.m));
        assert_ok(mbsr_data_create(t.m, &t.d, NULL), NULL);
        assert_ok(mbsr_dae_pack(t.m, t.d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(t.d));
        assert_ok(mbsr_dae_consistent(t.m, t.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(t.d));
        assert_ok(mbsr_completion_create(t.m, NULL, &completion, NULL), NULL);
        assert_ok(mbsr_completion_dynamics(completion, t.d, 0.0, q, u, NULL, udot, lambda),
                  mbsr_completion_error(completion));
        for (int i = 0; i < 2; ++i) {
            assert_close(yp[4 + i], -0.5 * g, 1e-6 * g);
            assert_close(udot[i], -0.5 * g, 1e-6 * g);
        }
        mbsr_completion_destroy(completion);
        mbsr_data_destroy(t.d), mbsr_model_destroy(t.m);
    }
}

/* A slide that a ball joint holds, with a spring as closure on it: what it is held by are the rows
 * of the joint, in whatever unit the spring's row counts. */
static void springs_do_not_hold_for_joints(void **state)
{
    (void)state;
    static const double along[3] = {0.0, 1.0, 0.0};
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        const units *of = systems + k;
        const double L = of->length, T = of->time, point[3] = {L, 0.0, L};
        double q[1] = {0.0}, u[1] = {0.7 * L / T}, y[16], yp[16];
        model t = {.in = of};
        assert_ok(mbsr_model_create(NULL, &t.m, NULL), NULL);
        add_body(&t, MBSR_GROUND, mbsr_joint_prismatic(NULL, NULL, along),
                 mbsr_inertia_point_mass(of->mass, point));
        add_closure(&t, mbsr_closure_ball(0, point, MBSR_GROUND, point));
        mbsr_force_def spring = mbsr_force_joint_spring(0, 0, of->mass / (T * T), 0.0, 0.0);
        spring.as_closure = MBSR_SPRING_LOOSE;
        add_force(&t, spring);
        assert_ok(mbsr_model_finish(t.m), mbsr_model_error(t.m));
        assert_ok(mbsr_data_create(t.m, &t.d, NULL), NULL);
        assert_ok(mbsr_dae_pack(t.m, t.d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(t.d));
        assert_ok(mbsr_dae_consistent(t.m, t.d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(t.d));
        assert_close(y[2], 0.0, 1e-12 * L / T);
        mbsr_data_destroy(t.d), mbsr_model_destroy(t.m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_told_twice_is_the_same),
                                       cmocka_unit_test(tellings_that_were_wrong),
                                       cmocka_unit_test(springs_in_series_share),
                                       cmocka_unit_test(springs_do_not_hold_for_joints)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
