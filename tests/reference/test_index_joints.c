/* The index report, forward dynamics and the start on random trees of joints of all kinds (joint_scene.h), in
 * space and in the plane, in four systems of units. What they must say follows from ranks of velocities.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "duration.h"
#include "joint_scene.h"

static bool lists(const mbsr_direction *d, int force)
{
    bool some = false;
    for (int k = 0; k < d->forces; ++k) some = some || d->force[k] == force;
    return some;
}

/* A direction moves no mass, and no damper unless it is damped; it lists what determines it. */
static bool right_direction(const scene *s, const verdict *v, const built *l,
                            const mbsr_direction *d)
{
    double a[RATES] = {0.0}, largest = 0.0;
    for (int k = 0; k < d->terms; ++k) {
        const int at = scene_first_rate(l, d->term[k].body) + d->term[k].coordinate;
        a[at] = d->term[k].weight / l->unit[at];
        largest = fmax(largest, fabs(a[at]));
    }
    for (int r = 0; r < v->massive.count; ++r) {
        double moved = 0.0;
        for (int k = 0; k < l->nu; ++k) moved += v->massive.v[r][k] * a[k];
        if (fabs(moved) > 1e-5 * largest) return false;
    }
    for (int k = 0; k < s->elements; ++k) {
        const bool damps = s->element[k].damper > 0.0, springs = s->element[k].spring > 0.0,
                   damped = d->kind == MBSR_DIRECTION_DAMPED,
                   open = d->kind == MBSR_DIRECTION_UNDETERMINED,
                   counts = damped ? damps : springs && !open;
        double seen = 0.0;
        for (int c = 0; c < l->nu; ++c) seen += v->seen[k][c] * a[c] / largest;
        if (fabs(seen) < 1e-12 && lists(d, k)) return false;
        if (fabs(seen) < 1e-5) continue;
        if (lists(d, k) != counts || (damps && !damped) || (springs && open)) return false;
    }
    return (d->forces > 0) == (d->kind != MBSR_DIRECTION_UNDETERMINED);
}

static bool right_report(const scene *s, const verdict *v, const built *l)
{
    mbsr_index_report *r = NULL;
    unsigned bits = 0;
    if (mbsr_index_report_create(l->model, l->data, 0.0, l->q, l->u, &r)) return false;
    bool right = r->dynamic == v->dynamic && r->damped == v->damped && r->elastic == v->elastic &&
                 r->undetermined == v->undetermined;
    for (int k = 0; k < r->directions; ++k) {
        const mbsr_direction *d = r->direction + k;
        right = right && right_direction(s, v, l, d);
        for (int t = 0; t < d->terms; ++t)
            bits |= d->kind == MBSR_DIRECTION_UNDETERMINED ? 1u << d->term[t].body : 0u;
    }
    mbsr_index_report_destroy(l->model, r);
    return right && bits == v->undetermined_in;
}

/* All springs are at rest: a start moves nothing but what no damper sees; refused where something is
 * open. */
static bool right_start(const scene *s, const verdict *v, const built *l, const units *in)
{
    double y[7 * BODIES + 2 * RATES], yp[7 * BODIES + 2 * RATES];
    const mbsr_dae_form form = MBSR_DAE_MOMENTUM;
    assert_ok(mbsr_dae_pack(l->model, l->data, form, 0.0, l->q, l->u, y), mbsr_data_error(l->data));
    const int status = mbsr_dae_consistent(l->model, l->data, form, 0.0, y, yp, NULL, NULL);
    if (v->undetermined > 0) return status == MBSR_UNDETERMINED;
    bool still = status == MBSR_OK;
    for (int k = 0; k < l->nq && still; ++k)
        still = fabs(y[k] - l->q[k]) <= 1e-9 * fmax(in->length, 1.0);
    for (int k = 0; k < s->elements && still; ++k) {
        double speed = 0.0;
        for (int c = 0; c < l->nu; ++c)
            speed += v->seen[k][c] * y[l->nq + l->nu + c] / l->unit[c] * in->time;
        still = s->element[k].damper == 0.0 || fabs(speed) <= 1e-6;
    }
    return still;
}

static int wrong(int seed, const scene *s, const verdict *v, const units *in)
{
    built l = scene_build(s, in, v->rest, s->flat);
    double udot[RATES];
    const bool reported = right_report(s, v, &l), started = right_start(s, v, &l, in);
    const int forward = mbsr_forward_dynamics(l.model, l.data, 0.0, l.q, l.u, NULL, udot),
              expected = v->dynamic < l.nu ? MBSR_UNDETERMINED : MBSR_OK;
    const bool right = reported && started && forward == expected;
    if (!right)
        print_error("seed %d (%s): report %d, start %d, forward dynamics %d; expected dynamic %d "
                    "damped %d elastic %d undetermined %d in %x\n%s\n",
                    seed, in->name, reported, started, forward, v->dynamic, v->damped, v->elastic,
                    v->undetermined, v->undetermined_in, mbsr_data_error(l.data)->text);
    scene_destroy(&l);
    return !right;
}

static void try_scenes(int seeds, bool flat)
{
    int count = 0, judged = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        const scene s = scene_draw(seed, flat);
        const verdict v = scene_judge(&s);
        if (!v.settled) continue;
        ++judged;
        for (size_t l = 0; l < sizeof systems / sizeof *systems; ++l)
            count += wrong(seed, &s, &v, systems + l);
    }
    assert_true(judged > seeds / 2);
    assert_int_equal(count, 0);
}

static void verdicts_are_those_of_the_velocities(void **state)
{
    (void)state;
    try_scenes(test_long() ? 7500 : test_seeds(60, 500), false);
}

static void also_of_bodies_in_the_plane(void **state)
{
    (void)state;
    try_scenes(test_long() ? 7500 : test_seeds(60, 500), true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(verdicts_are_those_of_the_velocities),
        cmocka_unit_test(also_of_bodies_in_the_plane),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
