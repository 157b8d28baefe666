/* Stock springs as closures with stiff rows: see springs.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A spring with the energy k g^2 / 2 and the damping d is the stiff row g: the force element exerts
 * C^T lambda with lambda = -(k g + d g'), and so does the row (forms/loops.c). */
#include "closures/springs.h"

#include "closures/rows.h"
#include "closures/stock.h"

#include "algebra/principal.h"

static bool read_spring(const mbsr_force_def *force, mbsri_spring *spring)
{
    *spring = (mbsri_spring){0};
    return mbsri_read_point_spring(force, spring) || mbsri_read_axis_spring(force, spring) ||
           mbsri_read_bushing(force, spring) || mbsri_read_planar_bushing(force, spring) ||
           mbsri_read_joint_spring(force, spring) || mbsri_read_gear(force, spring);
}

/* Numbers of stiffness that stand for themselves. */
static int entries(const mbsri_spring *spring)
{
    return spring->kind == MBSRI_BUSHING ? 6 : spring->kind == MBSRI_PLANAR_BUSHING ? 0 : 1;
}

static int check_matrices(const mbsri_spring *spring, char text[MBSR_TEXT_SIZE])
{
    mbsri_principal rows;
    switch (mbsri_principal_stiffness(3, spring->stiffness, spring->damping, &rows)) {
    case MBSRI_PRINCIPAL_GOOD:
        if (rows.rows > 0) return MBSR_OK;
        return mbsri_refuse(text, MBSR_ERR_VALUE, "as_closure: it has no stiffness");
    case MBSRI_PRINCIPAL_LOOSE:
        return mbsri_refuse(text, MBSR_ERR_VALUE,
                            "as_closure: its damping acts where it has no stiffness; add that "
                            "as an element of its own");
    case MBSRI_PRINCIPAL_SKEW:
        return mbsri_refuse(text, MBSR_ERR_VALUE,
                            "as_closure: stiffness and damping have principal directions that "
                            "are too near to each other");
    default:
        return mbsri_refuse(text, MBSR_ERR_VALUE,
                            "as_closure: stiffness or damping is not positive semi-definite");
    }
}

int mbsri_spring_check(const mbsr_force_def *force, char text[MBSR_TEXT_SIZE])
{
    mbsri_spring spring;
    if (force->as_closure == 0) return MBSR_OK;
    if (force->as_closure != MBSR_SPRING_SETTLED && force->as_closure != MBSR_SPRING_LOOSE)
        return mbsri_refuse(text, MBSR_ERR_VALUE,
                            "as_closure is %d, neither 0, MBSR_SPRING_SETTLED nor "
                            "MBSR_SPRING_LOOSE",
                            force->as_closure);
    if (!read_spring(force, &spring))
        return mbsri_refuse(text, MBSR_ERR_VALUE,
                            "as_closure is set, but this is no spring that can be a closure");
    if (spring.beyond)
        return mbsri_refuse(text, MBSR_ERR_VALUE, "as_closure needs a linear spring, but %s",
                            spring.beyond);
    if (spring.kind == MBSRI_PLANAR_BUSHING) return check_matrices(&spring, text);
    bool any = false;
    for (int k = 0; k < entries(&spring); ++k) {
        any = any || spring.stiffness[k] > 0.0;
        if (spring.damping[k] > 0.0 && !(spring.stiffness[k] > 0.0))
            return mbsri_refuse(text, MBSR_ERR_VALUE,
                                "as_closure: damping[%d] is %g without stiffness; add it as an "
                                "element of its own",
                                k, spring.damping[k]);
    }
    return any ? MBSR_OK : mbsri_refuse(text, MBSR_ERR_VALUE, "as_closure: it has no stiffness");
}

/* Of zero length at rest and without damping: components of the vector between the points, which
 * need no direction; points in the plane that lie off it at different heights always have one. */
static mbsr_closure_def point_spring(const mbsri_spring *s, const int body[2], bool flat)
{
    if (s->rest > 0.0 || s->damping[0] > 0.0 || (flat && s->a[2] != s->b[2])) {
        mbsr_closure_def def = mbsri_closure_length(body[0], s->a, body[1], s->b, s->rest);
        def.stiffness[0] = s->stiffness[0];
        def.damping[0] = s->damping[0];
        return def;
    }
    mbsr_closure_def def = mbsr_closure_ball(body[0], s->a, body[1], s->b);
    for (int k = 0; k < (flat ? 2 : 3); ++k) def.stiffness[k] = s->stiffness[0];
    return def;
}

static mbsr_closure_def bushing(const mbsri_spring *s, const int body[2])
{
    int entry[6], rows = 0;
    for (int k = 0; k < 6; ++k) {
        if (s->stiffness[k] > 0.0) entry[rows++] = k;
    }
    mbsr_closure_def def = mbsri_closure_bushing(body[0], s->a, body[1], s->b, rows, entry);
    for (int k = 0; k < rows; ++k) {
        def.stiffness[k] = s->stiffness[entry[k]];
        def.damping[k] = s->damping[entry[k]];
    }
    return def;
}

static mbsr_closure_def planar_bushing(const mbsri_spring *s, const int body[2])
{
    mbsri_principal p;
    mbsri_principal_stiffness(3, s->stiffness, s->damping, &p);
    mbsr_closure_def def = mbsri_closure_planar_bushing(body[0], s->a, body[1], s->b, p.rows, p.T);
    for (int k = 0; k < p.rows; ++k) {
        def.stiffness[k] = p.stiffness[k];
        def.damping[k] = p.damping[k];
    }
    return def;
}

static mbsr_closure_def coordinates(const mbsri_spring *s, const int body[2])
{
    const double lever[2] = {1.0, -s->ratio};
    const int terms = s->kind == MBSRI_GEAR ? 2 : 1;
    mbsr_closure_def def = mbsr_closure_coupling(terms, body, s->coordinate, lever, s->rest);
    def.stiffness[0] = s->stiffness[0];
    def.damping[0] = s->damping[0];
    return def;
}

mbsr_closure_def mbsri_spring_closure(const mbsr_force_def *force, const int body[2],
                                      const mbsr_space space[2])
{
    mbsri_spring s;
    mbsr_closure_def def = mbsr_default_closure_def();
    if (!read_spring(force, &s)) return def;
    switch (s.kind) {
    case MBSRI_POINT_SPRING:
        def = point_spring(&s, body,
                           space[0] != MBSR_SPACE_SPATIAL && space[1] != MBSR_SPACE_SPATIAL);
        break;
    case MBSRI_AXIS_SPRING:
        def = mbsri_closure_axis(body[0], body[1], s.coordinate[0], s.rest);
        def.stiffness[0] = s.stiffness[0];
        def.damping[0] = s.damping[0];
        break;
    case MBSRI_BUSHING: def = bushing(&s, body); break;
    case MBSRI_PLANAR_BUSHING: def = planar_bushing(&s, body); break;
    default: def = coordinates(&s, body); break;
    }
    def.settled = force->as_closure == MBSR_SPRING_SETTLED;
    return def;
}
