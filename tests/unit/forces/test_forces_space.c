/* Relations that every force element between two bodies obeys, in all spaces: balance of power,
 * action and reaction, choice of the world's frame and of units, planar bodies as bodies in space.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "parts.h"

/* ---- the elements under test, with random parameters ----------------------------------------- */

enum {
    LINEAR,
    CUBIC,
    TAUT,
    SLACK,
    BY_FUNCTION,
    BUSHING,
    CONTACT,
    TYRE,         /* contact with creep */
    RUBBING,      /* friction at a point, */
    SURFACE,      /* along a surface */
    WHEEL,        /* or along an axle */
    BALL_BEARING, /* friction against any turning */
    BEARING,      /* or about an axis */
    PLANE_BUSHING,
    ELEMENTS
};

/* The units of one description in those of another. */
typedef struct units {
    double length, force, time;
} units;

static const units si = {1.0, 1.0, 1.0};

/* 5 x^2 and 0.3 v, in units */
static int quadratic(void *user, double x, double v, double *force, double *energy, double *power)
{
    const units *s = user;
    const double length = x / s->length, rate = v * s->time / s->length;
    assert_close(*force, 0.0, 0.0);
    if (energy) assert_close(v, 0.0, 0.0);
    *force = (5.0 * length * length + 0.3 * rate) * s->force;
    if (energy) *energy = 5.0 / 3.0 * length * length * length * s->force * s->length;
    if (power) *power = 0.3 * rate * rate * s->force * s->length / s->time;
    return 0;
}

static void fill(test_rng *rng, int n, double scale, double *x)
{
    test_fill(rng, n, x);
    for (int k = 0; k < n; ++k) x[k] *= scale;
}

static double positive(test_rng *rng)
{
    return 1.5 + test_uniform(rng);
}

static mbsr_force_def bushing(test_rng *rng, int damped, const units *s, int a, int b)
{
    double quaternion[2][4], x[2][3], stiffness[6], damping[6];
    for (int k = 0; k < 2; ++k) {
        test_fill(rng, 4, quaternion[k]);
        fill(rng, 3, s->length, x[k]);
    }
    for (int k = 0; k < 6; ++k) {
        const double arm = k < 3 ? s->length : 1.0 / s->length;
        stiffness[k] = 3.0 * positive(rng) * s->force * arm;
        damping[k] = positive(rng) * s->force * s->time * arm * damped;
    }
    const mbsr_frame A = mbsr_frame_quaternion(x[0], quaternion[0]),
                     B = mbsr_frame_quaternion(x[1], quaternion[1]);
    return mbsr_force_bushing(a, &A, b, &B, stiffness, damping);
}

/* Pressed in wherever the bodies are, being so large. */
static mbsr_force_def contact(test_rng *rng, int damped, double creep, const units *s, int a, int b,
                              int origin_a, int origin_b)
{
    mbsr_contact c = {.radius = 8.0 * s->length,
                      .exponent = 1.5,
                      .stiffness = 4.0 * s->force / pow(s->length, 1.5),
                      .damping = 0.2 * damped * s->time / s->length,
                      .friction = 0.7 * damped,
                      .slip = 0.3 * s->length / s->time,
                      .creep = creep};
    fill(rng, 3, origin_a ? 0.0 : s->length, c.centre);
    fill(rng, 3, origin_b ? 0.0 : s->length, c.point);
    fill(rng, 3, 0.2, c.normal);
    return mbsr_force_contact(a, b, &c);
}

static mbsr_force_def rubbing(test_rng *rng, int kind, int damped, const units *s, int a, int b,
                              int origin_a)
{
    double point[3];
    mbsr_friction law = {.coefficient = 0.7 * damped,
                         .viscous = 0.4 * damped * s->force * s->time / s->length,
                         .slip = 0.3 * s->length / s->time,
                         .creep = kind == WHEEL ? 0.6 : 0.0,
                         .load = positive(rng) * s->force};
    fill(rng, 3, origin_a ? 0.0 : s->length, point);
    if (kind != RUBBING) fill(rng, 3, 5.0, kind == SURFACE ? law.normal : law.axle);
    return mbsr_force_point_friction(a, point, b, &law);
}

static mbsr_force_def bearing(test_rng *rng, int kind, int damped, const units *s, int a, int b)
{
    const double torque = s->force * s->length;
    mbsr_bearing law = {.torque = 1.3 * damped * torque,
                        .viscous = 0.4 * damped * torque * s->time,
                        .slip = 0.3 / s->time};
    if (kind == BEARING) fill(rng, 3, 5.0, law.axis);
    return mbsr_force_bearing_friction(a, b, &law);
}

/* Stiffness and damping with all their entries. */
static mbsr_force_def plane_bushing(test_rng *rng, int damped, const units *s, int a, int b)
{
    const double scale[3] = {1.0, 1.0, s->length};
    double place[3], matrix[2][9];
    fill(rng, 3, s->length, place);
    const mbsr_planar_frame A = {place[0], place[1], 0.4}, B = {place[2], 0.2 * s->length, -2.0};
    for (int m = 0; m < 2; ++m) {
        const double unit = s->force / s->length * (m ? damped * s->time : 3.0);
        for (int k = 0; k < 3; ++k) {
            for (int l = 0; l <= k; ++l) {
                const double entry = k == l ? positive(rng) : 0.4 * test_uniform(rng);
                matrix[m][3 * k + l] = matrix[m][3 * l + k] = entry * unit * scale[k] * scale[l];
            }
        }
    }
    return mbsr_force_planar_bushing(a, A, b, B, matrix[0], matrix[1]);
}

/* Points are the origin where `origin` says so. */
static mbsr_force_def element(int kind, uint64_t seed, int damped, const units *s, int a, int b,
                              const int origin[2])
{
    test_rng rng = test_seed(seed);
    double point[2][3];
    if (kind == BUSHING) return bushing(&rng, damped, s, a, b);
    if (kind == CONTACT || kind == TYRE)
        return contact(&rng, damped, kind == TYRE ? 0.4 : 0.0, s, a, b, origin[0], origin[1]);
    if (kind == RUBBING || kind == SURFACE || kind == WHEEL)
        return rubbing(&rng, kind, damped, s, a, b, origin[0]);
    if (kind == BEARING || kind == BALL_BEARING) return bearing(&rng, kind, damped, s, a, b);
    if (kind == PLANE_BUSHING) return plane_bushing(&rng, damped, s, a, b);
    for (int k = 0; k < 2; ++k) fill(&rng, 3, origin[k] ? 0.0 : s->length, point[k]);
    mbsr_spring spring = {.stiffness = 7.0 * positive(&rng) * s->force / s->length,
                          .cubic = 2.0 * s->force / pow(s->length, 3.0),
                          .damping = 1.5 * damped * s->force * s->time / s->length,
                          .free_length = kind == SLACK ? 50.0 * s->length : 0.02 * s->length,
                          .one_sided = kind == TAUT || kind == SLACK};
    if (kind == LINEAR) {
        return mbsr_force_point_spring(a, point[0], b, point[1], spring.stiffness, spring.damping,
                                       3.0 * s->length);
    }
    if (kind == BY_FUNCTION) {
        spring.function = quadratic;
        spring.user = (void *)(uintptr_t)s;
    }
    return mbsr_force_spring(a, point[0], b, point[1], &spring);
}

/* ---- the bodies they join -------------------------------------------------------------------- */

typedef struct pair {
    mbsr_space space[2];
    int ground; /* which of the two, -1: none; FIXED: at rest, else a moving root */
} pair;

static const pair pairs[] = {
    {{MBSR_SPACE_SPATIAL, MBSR_SPACE_SPATIAL}, -1}, {{MBSR_SPACE_SPATIAL, MBSR_SPACE_FIXED}, 1},
    {{MBSR_SPACE_SPATIAL, MBSR_SPACE_SPATIAL}, 1},  {{MBSR_SPACE_SPATIAL, MBSR_SPACE_PLANAR}, 1},
    {{MBSR_SPACE_SPATIAL, MBSR_SPACE_POINT}, 1},    {{MBSR_SPACE_FIXED, MBSR_SPACE_SPATIAL}, 0},
    {{MBSR_SPACE_SPATIAL, MBSR_SPACE_PLANAR}, -1},  {{MBSR_SPACE_POINT, MBSR_SPACE_SPATIAL}, -1},
    {{MBSR_SPACE_PLANAR, MBSR_SPACE_PLANAR}, -1},   {{MBSR_SPACE_PLANAR, MBSR_SPACE_POINT}, -1},
    {{MBSR_SPACE_POINT, MBSR_SPACE_POINT}, -1},     {{MBSR_SPACE_PLANAR, MBSR_SPACE_FIXED}, 1},
    {{MBSR_SPACE_POINT, MBSR_SPACE_SPATIAL}, 1},    {{MBSR_SPACE_PLANAR, MBSR_SPACE_PLANAR}, 1},
};
enum { PAIRS = sizeof pairs / sizeof pairs[0] };

/* What the element's check should say to the pair. */
static int verdict(int kind, const pair *w)
{
    if ((kind == CONTACT || kind == TYRE) && w->ground == 0) return MBSR_ERR_ID;
    for (int k = 0; k < 2; ++k) {
        const mbsr_space space = w->space[k];
        if (kind == BUSHING && w->ground != k && space != MBSR_SPACE_SPATIAL) return MBSR_ERR_SPACE;
        if ((kind == BEARING || kind == BALL_BEARING) && space == MBSR_SPACE_POINT)
            return MBSR_ERR_SPACE;
        if (kind == PLANE_BUSHING && space != MBSR_SPACE_PLANAR && space != MBSR_SPACE_FIXED)
            return MBSR_ERR_SPACE;
    }
    return MBSR_OK;
}

static int admissible(int kind, const pair *w)
{
    return verdict(kind, w) == MBSR_OK;
}

typedef struct joined {
    mbsr_force_def def;
    test_part part[2];
} joined;

/* Element and bodies in the state number `round`; `s`: in other units. */
static joined join(int kind, const pair *w, int round, int damped, const units *s)
{
    test_rng rng = test_seed((uint64_t)(1000 * round + 10 * kind + 1));
    joined j;
    int origin[2];
    for (int k = 0; k < 2; ++k) {
        j.part[k] = test_part_random(w->space[k], &rng);
        origin[k] = w->space[k] == MBSR_SPACE_POINT;
        const int spatial = w->space[k] == MBSR_SPACE_SPATIAL;
        for (int c = 0; c < 3; ++c) {
            if (spatial || c < 2) j.part[k].p[spatial ? 9 + c : c] *= s->length;
            j.part[k].V[c] *= (spatial || c == 2 ? 1.0 : s->length) / s->time;
            j.part[k].V[3 + c] *= s->length / s->time;
        }
    }
    j.def = element(kind, (uint64_t)(77 * round + kind + 1), damped, s,
                    w->ground == 0 ? MBSR_GROUND : 0, w->ground == 1 ? MBSR_GROUND : 1, origin);
    return j;
}

static int checked(const joined *j)
{
    mbsr_force_body body[2];
    char text[MBSR_TEXT_SIZE] = "";
    for (int k = 0; k < 2; ++k) {
        body[k] = (mbsr_force_body){.id = j->def.body[k],
                                    .space = j->part[k].space,
                                    .d = j->part[k].d,
                                    .np = j->part[k].np};
    }
    const mbsr_force_args args = {.force = &j->def, .bodies = 2, .body = body};
    return j->def.table->check(&args, text);
}

/* ---- relations ------------------------------------------------------------------------------- */

static void elements_accept_the_spaces_they_work_in(void **state)
{
    (void)state;
    int accepted = 0;
    for (int kind = 0; kind < ELEMENTS; ++kind) {
        for (int w = 0; w < PAIRS; ++w) {
            const joined j = join(kind, pairs + w, 0, 1, &si);
            assert_int_equal(checked(&j), verdict(kind, pairs + w));
            accepted += admissible(kind, pairs + w);
        }
    }
    assert_int_equal(accepted, 5 * PAIRS + 6 + 2 * (PAIRS - 1) + 3 * PAIRS + 2 * 9 + 3);
}

static void power_is_what_leaves_the_energy_and_what_becomes_heat(void **state)
{
    (void)state;
    for (int kind = 0; kind < ELEMENTS; ++kind) {
        for (int w = 0; w < PAIRS; ++w) {
            if (!admissible(kind, pairs + w)) continue;
            double most = 0.0, heat = 0.0;
            for (int round = 0; round < 20; ++round) {
                joined j = join(kind, pairs + w, round, 1, &si);
                heat = fmax(heat, test_balance(&j.def, j.part, 2));
                most = fmax(most, fmax(test_largest(6, j.part[0].f), test_largest(6, j.part[1].f)));
            }
            if (kind == SLACK) {
                assert_close(most, 0.0, 0.0);
                assert_close(heat, 0.0, 0.0);
            } else {
                assert_less(0.1, most);
                assert_less(1e-3, heat);
            }
        }
    }
}

/* Without damping forces do not depend on velocities, and by the balance of power for any velocity
 * they are the gradient of the energy. */
static void elastic_forces_depend_on_the_pose_alone(void **state)
{
    (void)state;
    for (int kind = 0; kind < ELEMENTS; ++kind) {
        for (int w = 0; w < PAIRS; ++w) {
            if (!admissible(kind, pairs + w) || kind == BY_FUNCTION) continue;
            for (int round = 0; round < 5; ++round) {
                joined j = join(kind, pairs + w, round, 0, &si), rest = j;
                assert_close(test_balance(&j.def, j.part, 2), 0.0, 0.0);
                for (int k = 0; k < 2; ++k) memset(rest.part[k].V, 0, sizeof rest.part[k].V);
                assert_int_equal(test_ask(&j.def, rest.part, 2, TEST_FORCES, NULL), 0);
                for (int k = 0; k < 2; ++k) {
                    for (int c = 0; c < 6; ++c)
                        assert_close(j.part[k].f[c], rest.part[k].f[c],
                                     1e-13 * (1.0 + fabs(rest.part[k].f[c])));
                }
            }
        }
    }
}

/* Force and moment about the world's origin of what is in f. */
static void totals(const test_part *part, double force[3], double moment[3])
{
    const int spatial = part->space == MBSR_SPACE_SPATIAL;
    const double *f = part->f + (spatial ? 3 : 0), *x = part->p + (spatial ? 9 : 0);
    const double r[3] = {x[0], x[1], spatial ? x[2] : 0.0},
                 F[3] = {f[0], f[1], spatial ? f[2] : 0.0};
    for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        force[k] += F[k];
        moment[k] += r[a] * F[b] - r[b] * F[a] + (spatial ? part->f[k] : 0.0);
    }
    if (part->space == MBSR_SPACE_PLANAR) moment[2] += part->f[2];
}

/* Of forces on bodies in the plane only what lies in it is there. */
static void action_equals_reaction(void **state)
{
    (void)state;
    for (int kind = 0; kind < ELEMENTS; ++kind) {
        for (int w = 0; w < PAIRS; ++w) {
            const pair *p = pairs + w;
            if (!admissible(kind, p) || p->space[0] == MBSR_SPACE_FIXED ||
                p->space[1] == MBSR_SPACE_FIXED)
                continue;
            const int planar =
                p->space[0] != MBSR_SPACE_SPATIAL || p->space[1] != MBSR_SPACE_SPATIAL;
            /* a POINT drops the moment of what does not act at its origin */
            const int dropped = kind >= BUSHING && (p->space[0] == MBSR_SPACE_POINT ||
                                                    p->space[1] == MBSR_SPACE_POINT);
            for (int round = 0; round < 10; ++round) {
                joined j = join(kind, p, round, 1, &si);
                double force[3] = {0}, moment[3] = {0};
                assert_int_equal(test_ask(&j.def, j.part, 2, TEST_FORCES, NULL), 0);
                for (int k = 0; k < 2; ++k) totals(j.part + k, force, moment);
                const double size = 1.0 + test_largest(6, j.part[0].f);
                for (int k = 0; k < 3; ++k) {
                    if (!planar || k < 2) assert_close(force[k], 0.0, 1e-13 * size);
                    if ((!planar || k == 2) && !dropped) assert_close(moment[k], 0.0, 1e-13 * size);
                }
            }
        }
    }
}

/* The same bodies seen from a frame that is turned and shifted. */
static void nothing_depends_on_the_frame_of_the_world(void **state)
{
    (void)state;
    test_rng rng = test_seed(5);
    for (int kind = 0; kind < ELEMENTS; ++kind) {
        for (int round = 0; round < 5; ++round) {
            const pair *p = pairs + (round % 2 ? 0 : 2);
            if (!admissible(kind, p)) continue; /* in the plane alone */
            joined j = join(kind, p, round, 1, &si), seen = j;
            double quaternion[4], x[3];
            test_fill(&rng, 4, quaternion);
            test_fill(&rng, 3, x);
            const mbsr_frame Q = mbsr_frame_quaternion(x, quaternion);
            for (int k = 0; k < 2; ++k) {
                mbsr_frame body = {.x = {0}};
                memcpy(body.R, j.part[k].p, sizeof body.R);
                memcpy(body.x, j.part[k].p + 9, sizeof body.x);
                body = mbsr_frame_product(&Q, &body);
                memcpy(seen.part[k].p, body.R, sizeof body.R);
                memcpy(seen.part[k].p + 9, body.x, sizeof body.x);
                for (int c = 0; c < 6; ++c) {
                    double sum = 0.0;
                    for (int l = 0; l < 3; ++l)
                        sum += Q.R[3 * l + c % 3] * j.part[k].V[c / 3 * 3 + l];
                    seen.part[k].V[c] = sum;
                }
            }
            for (int ask = TEST_ENERGY; ask <= TEST_DISSIPATION; ++ask) {
                const double value = test_value(&j.def, j.part, 2, (test_question)ask);
                assert_close(test_value(&j.def, seen.part, 2, (test_question)ask), value,
                             1e-12 * (1.0 + value));
            }
            assert_int_equal(test_ask(&j.def, j.part, 2, TEST_FORCES, NULL), 0);
            assert_int_equal(test_ask(&j.def, seen.part, 2, TEST_FORCES, NULL), 0);
            for (int k = 0; k < 2; ++k) {
                for (int c = 0; c < 6; ++c) {
                    double sum = 0.0;
                    for (int l = 0; l < 3; ++l)
                        sum += Q.R[3 * l + c % 3] * j.part[k].f[c / 3 * 3 + l];
                    assert_close(seen.part[k].f[c], sum,
                                 1e-12 * (1.0 + test_largest(6, j.part[k].f)));
                }
            }
        }
    }
}

static void nothing_depends_on_units(void **state)
{
    (void)state;
    static const units small = {1e-6, 1e3, 1e-4}, large = {1e5, 1e-4, 1e7};
    for (int kind = 0; kind < ELEMENTS; ++kind) {
        for (int w = 0; w < PAIRS; ++w) {
            if (!admissible(kind, pairs + w)) continue;
            for (int round = 0; round < 6; ++round) {
                const units *s = round % 2 ? &small : &large;
                joined j = join(kind, pairs + w, round, 1, &si),
                       other = join(kind, pairs + w, round, 1, s);
                const double work = s->force * s->length;
                const double E = test_value(&j.def, j.part, 2, TEST_ENERGY),
                             P = test_value(&j.def, j.part, 2, TEST_DISSIPATION);
                assert_close(test_value(&other.def, other.part, 2, TEST_ENERGY) / work, E,
                             1e-12 * (1.0 + E));
                assert_close(test_value(&other.def, other.part, 2, TEST_DISSIPATION) / work *
                                 s->time,
                             P, 1e-12 * (1.0 + P));
                assert_int_equal(test_ask(&j.def, j.part, 2, TEST_FORCES, NULL), 0);
                assert_int_equal(test_ask(&other.def, other.part, 2, TEST_FORCES, NULL), 0);
                for (int k = 0; k < 2; ++k) {
                    const test_part *part = j.part + k;
                    for (int c = 0; c < part->d; ++c) {
                        const int angular = part->space == MBSR_SPACE_SPATIAL ? c < 3 : c == 2;
                        assert_close(other.part[k].f[c] / (angular ? work : s->force), part->f[c],
                                     1e-11 * (1.0 + test_largest(6, part->f)));
                    }
                }
            }
        }
    }
}

/* ---- the plane in space ---------------------------------------------------------------------- */

/* A body in the plane as one in space: (x, y, angle) -> turned about z. */
static test_part lifted(const test_part *flat)
{
    static const double z[3] = {0, 0, 1};
    if (flat->space == MBSR_SPACE_FIXED || flat->space == MBSR_SPACE_SPATIAL) return *flat;
    const int turns = flat->space == MBSR_SPACE_PLANAR;
    test_part part = test_part_make(MBSR_SPACE_SPATIAL);
    const mbsr_frame at = mbsr_frame_rotated(NULL, z, turns ? flat->p[2] : 0.0);
    memcpy(part.p, at.R, sizeof at.R);
    memcpy(part.p + 9, flat->p, 2 * sizeof(double));
    part.V[2] = turns ? flat->V[2] : 0.0;
    memcpy(part.V + 3, flat->V, 2 * sizeof(double));
    return part;
}

static void bodies_in_the_plane_feel_what_bodies_in_space_feel_there(void **state)
{
    (void)state;
    for (int kind = 0; kind < ELEMENTS; ++kind) {
        for (int w = 0; w < PAIRS; ++w) {
            if (!admissible(kind, pairs + w) || kind == PLANE_BUSHING) continue;
            for (int round = 0; round < 5; ++round) {
                joined j = join(kind, pairs + w, round, 1, &si);
                test_part space[2] = {lifted(j.part), lifted(j.part + 1)};
                assert_int_equal(test_ask(&j.def, j.part, 2, TEST_FORCES, NULL), 0);
                assert_int_equal(test_ask(&j.def, space, 2, TEST_FORCES, NULL), 0);
                for (int k = 0; k < 2; ++k) {
                    const test_part *part = j.part + k;
                    const double tolerance = 1e-12 * (1.0 + test_largest(6, space[k].f));
                    if (part->space == MBSR_SPACE_FIXED || part->space == MBSR_SPACE_SPATIAL)
                        continue;
                    assert_close(part->f[0], space[k].f[3], tolerance);
                    assert_close(part->f[1], space[k].f[4], tolerance);
                    if (part->space == MBSR_SPACE_PLANAR)
                        assert_close(part->f[2], space[k].f[2], tolerance);
                }
                assert_close(test_value(&j.def, j.part, 2, TEST_ENERGY),
                             test_value(&j.def, space, 2, TEST_ENERGY), 1e-11);
                assert_close(test_value(&j.def, j.part, 2, TEST_DISSIPATION),
                             test_value(&j.def, space, 2, TEST_DISSIPATION), 1e-11);
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_accept_the_spaces_they_work_in),
        cmocka_unit_test(power_is_what_leaves_the_energy_and_what_becomes_heat),
        cmocka_unit_test(elastic_forces_depend_on_the_pose_alone),
        cmocka_unit_test(action_equals_reaction),
        cmocka_unit_test(nothing_depends_on_the_frame_of_the_world),
        cmocka_unit_test(nothing_depends_on_units),
        cmocka_unit_test(bodies_in_the_plane_feel_what_bodies_in_space_feel_there),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
