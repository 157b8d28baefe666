/* What the library says of random trees, beside what it must say: see joint_scene.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "joint_scene.h"

static bool lists(const mbsr_direction *d, int force)
{
    bool some = false;
    for (int k = 0; k < d->forces; ++k) some = some || d->force[k] == force;
    return some;
}

/* Of each element a direction lists whether it sees it, in the largest of its rates: seen. */
static bool right_element(const mbsr_direction *d, int number, bool damps, bool springs,
                          double seen)
{
    const bool damped = d->kind == MBSR_DIRECTION_DAMPED,
               open = d->kind == MBSR_DIRECTION_UNDETERMINED,
               counts = damped ? damps : springs && !open;
    if (seen < 1e-12) return !lists(d, number);
    return seen < 1e-5 || (lists(d, number) == counts && !(damps && !damped) && !(springs && open));
}

/* Shape by shape: springs and dampers of a beam are one element, behind the others. */
static bool right_beam(const scene *s, const built *l, const mbsr_direction *d, int number,
                       const double *a, double largest)
{
    const beam *b = s->beam + number;
    const double *shape = a + scene_first_rate(l, scene_beam_of(s, number));
    double damper = 0.0, spring = 0.0;
    for (int k = 0; k < b->modes; ++k) {
        const double seen = fabs(shape[k]) / largest;
        if (b->damper[k] > 0.0) damper = fmax(damper, seen);
        if (b->spring[k] > 0.0) spring = fmax(spring, seen);
    }
    const bool damped = d->kind == MBSR_DIRECTION_DAMPED,
               open = d->kind == MBSR_DIRECTION_UNDETERMINED;
    if (!damped && damper > 1e-5) return false;
    return right_element(d, s->elements + number, damped, !damped,
                         open     ? fmax(spring, damper)
                         : damped ? damper
                                  : spring);
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
        double seen = 0.0;
        for (int n = 0; n < l->nu; ++n) seen += v->seen[k][n] * a[n] / largest;
        if (!right_element(d, k, s->element[k].damper > 0.0, s->element[k].spring > 0.0,
                           fabs(seen)))
            return false;
    }
    for (int k = 0; k < s->beams; ++k) {
        if (!right_beam(s, l, d, k, a, largest)) return false;
    }
    return (d->forces > 0) == (d->kind != MBSR_DIRECTION_UNDETERMINED);
}

static bool right_report(const scene *s, const verdict *v, const built *l)
{
    mbsr_index_report *r = NULL;
    unsigned bits = 0;
    if (mbsr_index_report_create(l->model, l->data, 0.0, l->q, l->u, &r)) return false;
    bool right = r->dynamic == v->dynamic && r->damped == v->damped && r->elastic == v->elastic &&
                 r->undetermined == v->undetermined && r->loop_supported == v->held;
    for (int k = 0; k < r->directions; ++k) {
        const mbsr_direction *d = r->direction + k;
        right = right && right_direction(s, v, l, d);
        for (int t = 0; t < d->terms; ++t)
            bits |= d->kind == MBSR_DIRECTION_UNDETERMINED ? 1u << d->term[t].body : 0u;
    }
    mbsr_index_report_destroy(l->model, r);
    return right && bits == v->undetermined_in;
}

/* All springs are at rest: a start moves nothing but what no damper sees; refused where something
 * is open. */
static bool right_start(const scene *s, const verdict *v, const built *l, const units *in)
{
    enum { MOST = COORDINATES + 2 * RATES + 6 * CLOSURES };
    double y[MOST], yp[MOST];
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

bool scene_is_wrong(int seed, const scene *s, const verdict *v, const units *in)
{
    built l = scene_build(s, in, v->rest, s->flat);
    double udot[RATES];
    const bool reported = right_report(s, v, &l), started = right_start(s, v, &l, in);
    const int forward = mbsr_forward_dynamics(l.model, l.data, 0.0, l.q, l.u, NULL, udot),
              expected = v->massive.count < l.nu ? MBSR_UNDETERMINED : MBSR_OK;
    const bool right = reported && started && forward == expected;
    if (!right)
        print_error("seed %d (%s): report %d, start %d, forward dynamics %d; expected dynamic %d "
                    "damped %d elastic %d undetermined %d in %x held %d\n%s\n",
                    seed, in->name, reported, started, forward, v->dynamic, v->damped, v->elastic,
                    v->undetermined, v->undetermined_in, v->held, mbsr_data_error(l.data)->text);
    scene_destroy(&l);
    return !right;
}
