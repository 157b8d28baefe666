/* Sizes typical of a tree: see measure.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * They are made of constants of the model, so that steps do not depend on how far it has travelled:
 *
 *   length     the geometric mean of the bodies' radii of gyration about their origins; where all
 *              masses stand in origins, that of the arms of joints at q = 0, where nothing turns
 *              that of the ways between origins, or of points that force elements act at
 *   frequency  of a pendulum of that length under the model's gravity; without, of its masses at
 *              its springs and dampers
 *   span       of a coordinate whose kind is not known: what turns its body by 1 rad or moves it by
 *              the length at q = 0, by the column of J; modes have theirs from their data */
#include "assembly/measure.h"

#include "algebra/dense.h"
#include "algebra/numbers.h"
#include "assembly/rate.h"
#include "assembly/survey.h"
#include "base/memory.h"
#include "flexible/axial.h"
#include "flexible/data.h"
#include "forces/gravity.h"
#include "forces/springs.h"
#include "model/query.h"
#include "recursion/inertia.h"
#include "recursion/pose.h"
#include "recursion/spans.h"

#include <math.h>
#include <string.h>

/* Mass of a body, and its largest radius of gyration about the origin. */
static double radius(const mbsri_body *b, double *mass)
{
    double p[MBSR_POSE_SIZE] = {0.0}, M[36], moment = 0.0;
    *mass = 0.0;
    if (b->joint.space == MBSR_SPACE_GENERAL || b->inertia.kind == MBSR_INERTIA_FUNCTION)
        return 0.0;
    if (b->inertia.kind == MBSR_INERTIA_FLEXIBLE) {
        const mbsr_flex *flex = b->inertia.flex;
        *mass = flex->mass;
        for (int k = 0; k < 9; k += 4) moment = fmax(moment, mbsri_trace3(flex->N0) - flex->N0[k]);
        return *mass > 0.0 ? sqrt(moment / *mass) : 0.0;
    }
    if (b->joint.space == MBSR_SPACE_FLEXIBLE) return 0.0;
    if (b->joint.space == MBSR_SPACE_SPATIAL) p[0] = p[4] = p[8] = 1.0;
    mbsri_inertia_mass(b, p, M);
    for (int k = 0; k < b->d; ++k) {
        const double entry = M[k * (b->d + 1)];
        if (mbsri_is_angle(b->joint.space, k))
            moment = fmax(moment, entry);
        else
            *mass = fmax(*mass, entry);
    }
    return *mass > 0.0 ? sqrt(moment / *mass) : 0.0;
}

/* The geometric mean of those of x (count) that are not zero but for rounding; 0: none. */
static double mean(size_t count, const double *x)
{
    double largest = 0.0, sum = 0.0;
    int found = 0;
    for (size_t k = 0; k < count; ++k) largest = fmax(largest, x[k]);
    for (size_t k = 0; k < count; ++k) {
        if (!(x[k] > 1e-9 * largest)) continue;
        sum += log(x[k]);
        ++found;
    }
    return found > 0 ? exp(sum / found) : 0.0;
}

double mbsri_force_length(const mbsr_force_def *def)
{
    static const char *const lengths[] = {" (point", " (centre", " (frame A, x", " (frame B, x"};
    double largest = 0.0;
    for (int k = 0; k < MBSR_FORCE_PARAMS && def->table->parameter; ++k) {
        const char *name = def->table->parameter(k);
        for (size_t l = 0; l < sizeof lengths / sizeof *lengths; ++l) {
            if (strncmp(name, lengths[l], strlen(lengths[l])) == 0)
                largest = fmax(largest, fabs(def->param[k]));
        }
    }
    return largest;
}

/* The largest rest, limit or reference of a stock element along what slides; 0: it has none. */
static double length_along(const mbsr_model *m, const mbsri_force *force)
{
    static const char *const ways[] = {" (rest)", " (lower)", " (upper)", " (reference)",
                                       " (free_length)"};
    const mbsr_force_def *def = &force->def;
    double largest = 0.0;
    for (int k = 0; k < MBSR_FORCE_PARAMS && def->table->parameter; ++k) {
        const char *name = def->table->parameter(k);
        for (size_t l = 0; l < sizeof ways / sizeof *ways; ++l) {
            const double way = fabs(def->param[k]);
            if (strcmp(name, ways[l]) == 0 && isfinite(way) && !mbsri_is_of_turn(m, force, 1, 0))
                largest = fmax(largest, way);
        }
    }
    return largest;
}

/* Levers of all joints (bodies) at q = 0; where there is none, as nothing turns, the ways. */
static bool find_levers(const mbsr_model *m, double *lever)
{
    mbsr_data *d;
    if (mbsr_data_create(m, &d, NULL)) return false;
    const bool placed = mbsri_survey_zero(m, d);
    for (int i = 1; i <= m->bodies; ++i)
        lever[i - 1] = placed ? mbsri_lever_of(m->body + i, d->H + m->body[i].dp) : 0.0;
    if (placed && mbsri_largest(m->bodies, lever) == 0.0) {
        for (int i = 1; i <= m->bodies; ++i) lever[i - 1] = mbsri_way_of(d, m->body + i);
    }
    mbsr_data_destroy(d);
    return true;
}

static bool find_length(mbsr_model *m)
{
    const mbsri_force *force = m->forces.data;
    const size_t bodies = (size_t)m->bodies, forces = m->forces.count;
    double mass, *x = mbsri_allocate(&m->allocator, (bodies + forces + 1) * sizeof *x);
    if (!x) return false;
    m->typical.mass = 0.0;
    for (size_t k = 0; k < bodies; ++k, m->typical.mass += mass)
        x[k] = radius(m->body + k + 1, &mass);
    m->typical.length = mean(bodies, x);
    bool found = true;
    if (m->typical.length == 0.0 && bodies <= MBSRI_MOST_SURVEYED) {
        found = find_levers(m, x);
        m->typical.length = found ? mean(bodies, x) : 0.0;
    }
    for (size_t k = 0; k < forces; ++k) x[k] = mbsri_force_length(&force[k].def);
    if (m->typical.length == 0.0) m->typical.length = mean(forces, x);
    for (size_t k = 0; k < forces; ++k) x[k] = length_along(m, force + k);
    if (m->typical.length == 0.0) m->typical.length = mean(forces, x);
    mbsri_release(&m->allocator, x);
    return found;
}

static void find_frequency(mbsr_model *m)
{
    static const double pi = 3.14159265358979323846;
    const mbsri_force *force = m->forces.data;
    double g[3] = {0.0, 0.0, 0.0};
    for (size_t k = 0; k < m->forces.count; ++k) {
        if (!mbsri_is_gravity(&force[k].def)) continue;
        for (int l = 0; l < 3; ++l) g[l] += force[k].def.param[l];
    }
    const double size = sqrt(mbsri_dot(3, g, g));
    m->typical.frequency =
        m->typical.length > 0.0 ? sqrt(size / m->typical.length) / (2.0 * pi) : 0.0;
    if (m->typical.frequency == 0.0) m->typical.frequency = mbsri_elements_rate(m);
}

/* For springs with a law by function, whose derivatives are differences. */
static void tell_springs(mbsr_model *m)
{
    mbsri_force *force = m->forces.data;
    for (size_t k = 0; k < m->forces.count; ++k)
        mbsri_spring_set_rate(&force[k].def, m->typical.length * m->typical.frequency);
}

/* Whether the library does not know what all coordinates of a joint measure. */
static bool unknown(const mbsri_body *b)
{
    bool some = false;
    for (int k = 0; k < b->n; ++k)
        some = some || mbsri_coordinate_kind(b, true, k) == MBSR_COORDINATE_OTHER;
    return some;
}

/* What turns the body of a joint by 1 or moves it by the length. */
static double reach(const mbsr_model *m, const mbsri_body *b, const double *column)
{
    const mbsri_spans spans = mbsri_spans_of(m, NULL);
    double size = 0.0;
    for (int c = 0; c < b->d; ++c)
        size = fmax(size, fabs(column[c]) / mbsri_pose_span(&spans, b, c));
    return size > 0.0 && isfinite(1.0 / size) ? 1.0 / size : 1.0;
}

static bool find_coordinate_spans(mbsr_model *m)
{
    bool some = false;
    for (int i = 1; i <= m->bodies && !some; ++i) some = unknown(m->body + i);
    if (!some || m->bodies > MBSRI_MOST_SURVEYED) return true;
    const size_t count = (size_t)m->nq + (size_t)m->nu;
    double *span = mbsri_allocate(&m->allocator, count * sizeof *span);
    mbsr_data *d;
    if (!span || mbsr_data_create(m, &d, NULL)) {
        mbsri_release(&m->allocator, span);
        return false;
    }
    for (size_t k = 0; k < count; ++k) span[k] = 1.0;
    const bool placed = mbsri_survey_zero(m, d);
    for (int i = 1; i <= m->bodies && placed; ++i) {
        const mbsri_body *b = m->body + i;
        for (int k = 0; k < b->n; ++k) {
            const double now = reach(m, b, d->J + b->dn + (size_t)(k * b->d));
            span[m->nq + b->u + k] = now;
            if (b->nq == b->n) span[b->q + k] = now;
        }
    }
    mbsr_data_destroy(d);
    m->typical.span = span;
    return true;
}

bool mbsri_measure(mbsr_model *m)
{
    if (!find_length(m)) return false;
    find_frequency(m);
    tell_springs(m);
    return find_coordinate_spans(m);
}
