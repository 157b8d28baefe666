/* Closures and springs of mechanisms of everything at once: see medley_parts.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "medley_parts.h"

#include "expect.h"
#include "own_closure.h"

#include <string.h>

/* ---- a closure that reads joint coordinates alone: sin q_a + param1 q_b = param0 ---- */

static int wavy_gap(const mbsr_closure_args *args, double *g)
{
    g[0] = sin(args->body[0].q[0]) + args->closure->param[1] * args->body[1].q[0] -
           args->closure->param[0];
    return 0;
}

static int wavy_jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    out->matrix[out->column[0] + args->body[0].d] = cos(args->body[0].q[0]);
    out->matrix[out->column[1] + args->body[1].d] = args->closure->param[1];
    return 0;
}

static const mbsr_closure_table wavy[] = {
    {.version = MBSR_CLOSURE_TABLE_VERSION,
     .name = "wavy",
     .flags = MBSR_CLOSURE_JOINTS | MBSR_CLOSURE_COORDINATES | MBSR_CLOSURE_PLAIN |
              MBSR_CLOSURE_RELATIVE,
     .position = wavy_gap,
     .jacobian = wavy_jacobian},
    {.version = MBSR_CLOSURE_TABLE_VERSION,
     .name = "wavy bare",
     .flags = MBSR_CLOSURE_JOINTS | MBSR_CLOSURE_COORDINATES | MBSR_CLOSURE_PLAIN,
     .position = wavy_gap},
    {.version = MBSR_CLOSURE_TABLE_VERSION,
     .name = "wavy joints",
     .flags = MBSR_CLOSURE_JOINTS | MBSR_CLOSURE_PLAIN,
     .position = wavy_gap,
     .jacobian = wavy_jacobian}};

/* ---- closures ---- */

enum {
    BALL,
    ROWS,
    DISTANCE,
    WELD,
    BODY_ROWS,
    COUPLING,
    ROLLING_BALL,
    ROLLING_DISC,
    OWN,
    WAVY,
    KINDS
};

/* So many bodies before one, -1: the ground. */
int medley_before(const medley *s, int body, int steps)
{
    for (int k = 0; k < steps && body >= 0; ++k) body = s->body[body].parent;
    return body;
}

static bool find_joints(const medley *s, int count, int *body, int *coordinate, test_rng *rng)
{
    for (int k = 0; k < count; ++k) {
        bool found = false;
        for (int tries = 0; tries < 60 && !found; ++tries) {
            body[k] = test_integer(rng, 0, s->bodies - 1);
            if (s->c.local && k > 0) body[k] = medley_before(s, body[0], k);
            if (body[k] < 0) continue;
            const medley_body *b = s->body + body[k];
            found = b->plain && b->n > 0;
            for (int l = 0; l < k; ++l) found = found && body[l] != body[k];
            if (found) coordinate[k] = test_integer(rng, 0, b->n - 1);
        }
        if (!found) return false;
    }
    return true;
}

static mbsr_closure_def coupling(const medley *s, test_rng *rng, bool *made)
{
    int body[4], coordinate[4];
    double coefficient[4], sum = 0.0;
    const int count = test_integer(rng, 1, 4);
    test_fill(rng, 4, coefficient);
    *made = find_joints(s, count, body, coordinate, rng);
    for (int k = 0; k < count && *made; ++k)
        sum += coefficient[k] * s->q[s->body[body[k]].u + coordinate[k]];
    mbsr_closure_def def = mbsr_closure_coupling(count, body, coordinate, coefficient, sum);
    if (s->c.moving && medley_share(rng) < 0.5) def.motion = medley_follow_one;
    return def;
}

static mbsr_closure_def wavy_closure(const medley *s, test_rng *rng, bool *made)
{
    int body[2] = {0, 1}, none[2];
    *made = find_joints(s, 2, body, none, rng);
    mbsr_closure_def def = mbsr_closure_custom(wavy + test_integer(rng, 0, 2), 2, body, 1, 1, NULL);
    def.param[1] = 0.6;
    if (*made) def.param[0] = sin(s->q[s->body[body[0]].u]) + 0.6 * s->q[s->body[body[1]].u];
    return def;
}

bool medley_is_flat(const medley *s, int a, int b)
{
    return s->body[a].space != MBSR_SPACE_SPATIAL &&
           (b < 0 || s->body[b].space != MBSR_SPACE_SPATIAL);
}

static mbsr_closure_def closure(const medley *s, int kind, test_rng *rng, bool *made)
{
    double p[3], x[6], y[3];
    test_fill(rng, 3, p);
    test_fill(rng, 6, x);
    test_fill(rng, 3, y);
    int a = test_integer(rng, 0, s->bodies - 1);
    if (medley_share(rng) < 0.2) a = medley_share(rng) < 0.5 ? 0 : s->bodies - 1;
    int b = medley_share(rng) < 0.6 ? test_integer(rng, a > 5 ? a - 6 : -1, s->bodies - 1)
                                    : test_integer(rng, -1, s->bodies - 1);
    if (s->c.local) b = medley_before(s, a, test_integer(rng, 1, 3));
    if (a == b) b = -1;
    const bool flat = medley_is_flat(s, a, b),
               point = s->body[a].space == MBSR_SPACE_POINT ||
                       (b >= 0 && s->body[b].space == MBSR_SPACE_POINT);
    const int other = b < 0 ? MBSR_GROUND : b;
    if (flat || s->body[a].space != MBSR_SPACE_SPATIAL) p[2] = 0.0;
    if (s->body[a].space == MBSR_SPACE_POINT) p[0] = p[1] = 0.0;
    if (flat) x[2] = x[5] = 0.0;
    const mbsr_frame of_a = medley_frame(s, a), at = mbsr_frame_at(p[0], p[1], p[2]),
                     world = mbsr_frame_product(&of_a, &at), there = medley_seen_from(s, b, &world);
    *made = b < 0 || s->body[b].space != MBSR_SPACE_POINT || kind == DISTANCE || kind >= COUPLING;
    if (!*made) return mbsr_default_closure_def(); /* its only point is its origin */
    switch (kind) {
    case BALL: return mbsr_closure_ball(a, p, other, there.x);
    case ROWS: return mbsr_closure_rows(a, p, other, there.x, flat || s->c.local ? 1 : 2, x);
    case BODY_ROWS:
        *made = !point;
        return mbsr_closure_body_rows(a, p, other, there.x, flat || s->c.local ? 1 : 2, x);
    case WELD: return mbsr_closure_weld(a, &at, other, &there);
    case DISTANCE: {
        double length = 0.0;
        const mbsr_frame of_b = medley_frame(s, b);
        for (int k = 0; k < 3; ++k) length += (world.x[k] - of_b.x[k]) * (world.x[k] - of_b.x[k]);
        *made = length > 1e-3;
        return mbsr_closure_distance(a, p, other, NULL, *made ? sqrt(length) : 1.0);
    }
    case ROLLING_BALL: {
        *made = !flat && !point;
        mbsr_frame plane = mbsr_frame_along(world.x, y);
        for (int k = 0; k < 3; ++k) plane.x[k] -= 0.3 * plane.R[6 + k];
        plane = medley_seen_from(s, b, &plane);
        return mbsr_closure_rolling_ball(a, p, 0.3, other, &plane);
    }
    case ROLLING_DISC: {
        *made = !flat && !point && s->body[a].space == MBSR_SPACE_SPATIAL &&
                (b < 0 || s->body[b].space == MBSR_SPACE_SPATIAL);
        const mbsr_frame lean = mbsr_frame_rotated((double[3]){-0.4, 0.0, 0.0},
                                                   (double[3]){0.0, 1.0, 0.0}, 1.1),
                         plane = mbsr_frame_product(&world, &lean),
                         on_b = medley_seen_from(s, b, &plane);
        return mbsr_closure_rolling_disc(a, &at, 0.4, other, &on_b);
    }
    case OWN: {
        *made = b >= 0 && s->body[a].space == MBSR_SPACE_SPATIAL &&
                s->body[b].space == MBSR_SPACE_SPATIAL;
        mbsr_closure_def def = mbsr_closure_custom(test_own_closure + test_integer(rng, 0, 1), 2,
                                                   (int[2]){a, b < 0 ? 0 : b}, 1, 1, NULL);
        for (int k = 0; k < 3 && *made; ++k) def.param[0] += of_a.x[k] * s->body[b].at.x[k];
        return def;
    }
    case WAVY: return wavy_closure(s, rng, made);
    default: return coupling(s, rng, made);
    }
}

static int held_of(const medley *s, const mbsr_closure_def *def, int kind)
{
    const bool flat = medley_is_flat(s, def->body[0], def->bodies > 1 ? def->body[1] : MBSR_GROUND);
    switch (kind) {
    case BALL: return flat ? 2 : 3;
    case ROWS:
    case BODY_ROWS: return flat || s->c.local ? 1 : 2;
    case WELD: return flat ? 2 : 6;
    case DISTANCE:
    case COUPLING: return 1;
    default: return 0;
    }
}

/* Springs along some rows, or by a compliance matrix of any rank. */
static void stiffen(const medley *s, mbsr_closure_def *def, int kind, test_rng *rng)
{
    static const double sizes[] = {20.0, 3e3, 1e6, 1e10};
    static double A[9];
    const int held = held_of(s, def, kind), size = test_integer(rng, 0, 3);
    const double k = sizes[size] * (1.0 + 0.3 * test_uniform(rng));
    const bool all = medley_share(rng) < 0.5;
    if (kind == BALL && held == 3 && medley_share(rng) < 0.25) {
        double x[9];
        const int rank = test_integer(rng, 1, 3);
        test_fill(rng, 9, x);
        for (int l = 0; l < 9; ++l) {
            A[l] = 0.0;
            for (int r = 0; r < rank; ++r) A[l] += x[3 * r + l / 3] * x[3 * r + l % 3] / k;
        }
        def->compliant = 3;
        def->compliance = A;
        return;
    }
    for (int l = 0; l < held && (all || l < 1); ++l) {
        def->stiffness[l] = k;
        def->damping[l] = medley_share(rng) < 0.7 ? 0.003 * k : 0.0;
    }
    def->settled = medley_share(rng) < 0.7;
}

/* One that fits; none where none of some does. */
static void add_closure(medley *s, test_rng *rng)
{
    bool made = false;
    for (int tries = 0; tries < 20 && !made; ++tries) {
        const int few[5] = {ROWS, DISTANCE, BODY_ROWS, COUPLING, WAVY};
        const int kind =
            s->c.local ? few[test_integer(rng, 0, 4)] : test_integer(rng, 0, KINDS - 1);
        mbsr_closure_def def = closure(s, kind, rng, &made);
        if (!made) continue;
        if (s->c.moving && medley_share(rng) < 0.3) {
            if (kind == BALL || kind == ROWS || kind == BODY_ROWS) def.motion = medley_follow;
            if (kind == DISTANCE && s->lengths < MEDLEY_LENGTHS) {
                s->length[s->lengths] = def.param[6];
                def.motion = medley_follow_one;
                def.user = s->length + s->lengths++;
            }
        }
        if (medley_share(rng) < s->c.stiff) stiffen(s, &def, kind, rng);
        made =
            mbsr_model_add_closure(s->m, &def, NULL) == MBSR_OK; /* or it refuses its stiffness */
        if (!made) continue;
        if (medley_share(rng) < s->c.twice)
            assert_ok(mbsr_model_add_closure(s->m, &def, NULL), mbsr_model_error(s->m));
    }
}

void medley_add_cuts(medley *s)
{
    for (int k = 0; k < s->bodies; ++k) {
        const medley_body *b = s->body + k;
        if (b->cut == MBSR_NONE) continue;
        const bool flat = medley_is_flat(s, k, b->cut);
        if (b->cut >= 0 && s->body[b->cut].space == MBSR_SPACE_POINT) continue;
        if (!flat && b->space != MBSR_SPACE_SPATIAL) continue;
        const mbsr_frame there = medley_seen_from(s, b->cut, &b->at);
        const mbsr_closure_def weld =
            mbsr_closure_weld(k, NULL, b->cut < 0 ? MBSR_GROUND : b->cut, &there);
        assert_ok(mbsr_model_add_closure(s->m, &weld, NULL), mbsr_model_error(s->m));
    }
}

void medley_add_springs(medley *s, test_rng *rng)
{
    for (int k = 0; k < s->c.springs; ++k) {
        double p[3], r[3];
        test_fill(rng, 3, p);
        test_fill(rng, 3, r);
        const int a = test_integer(rng, 0, s->bodies - 1);
        int b = s->c.local ? medley_before(s, a, test_integer(rng, 1, 3))
                           : test_integer(rng, -1, s->bodies - 1);
        if (a == b) b = -1;
        const int other = b < 0 ? MBSR_GROUND : b;
        const double springs[6] = {3.0, 4.0, 5.0, 20.0, 30.0, 40.0},
                     dampers[6] = {0.3, 0.4, 0.5, 2.0, 3.0, 4.0},
                     K[9] = {20.0, 0.0, 0.0, 0.0, 30.0, 0.0, 0.0, 0.0, 3.0},
                     D[9] = {2.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.3};
        const mbsr_frame at = mbsr_frame_at(0.3, -0.2, 0.1);
        const mbsr_planar_frame flat = {0.3, -0.2, 0.4}, none = {0.0, 0.0, 0.0};
        const bool space = s->body[a].space == MBSR_SPACE_SPATIAL &&
                           (b < 0 || s->body[b].space == MBSR_SPACE_SPATIAL);
        const bool plane = s->body[a].space == MBSR_SPACE_PLANAR &&
                           (b < 0 || s->body[b].space == MBSR_SPACE_PLANAR);
        mbsr_force_def def;
        if (medley_share(rng) < 0.5 && space)
            def = mbsr_force_bushing(a, &at, other, NULL, springs, dampers);
        else if (medley_share(rng) < 0.5 && plane)
            def = mbsr_force_planar_bushing(a, flat, other, none, K, D);
        else if (space)
            def = mbsr_force_point_spring(a, p, other, r, 4.0, 0.5, 0.4);
        else
            continue;
        if (medley_share(rng) < s->c.stiff)
            def.as_closure = medley_share(rng) < 0.5 ? MBSR_SPRING_SETTLED : MBSR_SPRING_LOOSE;
        assert_ok(mbsr_model_add_force(s->m, &def, NULL), mbsr_model_error(s->m));
    }
}

void medley_add_closures(medley *s, test_rng *rng)
{
    for (int k = 0; k < s->c.closures; ++k) add_closure(s, rng);
}
