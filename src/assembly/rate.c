/* A rate typical of a tree without gravity: see rate.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * With k and d the geometric means of stiffness and damping of the elements, about an axis or at
 * the length of the model, and J = mass length^2:
 *
 *   sqrt(k / J) / (2 pi)   or   d / J   or, without mass, k / d
 *
 * Springs that are closures do not count: no motion is as fast as they are. */
#include "assembly/rate.h"

#include "model/query.h"
#include "recursion/pose.h"

#include <math.h>
#include <string.h>

/* Numbers of an element's parameters of one name: one, or one for each of three, six or nine
 * entries. */
typedef struct entries {
    int first, count; /* place, how many */
} entries;

static entries find_entries(const mbsr_force_def *def, const char *name)
{
    entries found = {0, 0};
    for (int k = 0; k < MBSR_FORCE_PARAMS && def->table->parameter; ++k) {
        if (strncmp(def->table->parameter(k), name, strlen(name)) != 0) continue;
        if (found.count++ == 0) found.first = k;
    }
    return found;
}

bool mbsri_is_of_turn(const mbsr_model *m, const mbsri_force *force, int count, int k)
{
    const mbsr_force_def *def = &force->def;
    const mbsri_body *b = m->body + m->stored.list_index[force->list];
    if (count == 3) return true;
    if (count == 6) return k < 3;
    if (count == 9) return k == 8;
    if (def->table->flags & MBSR_FORCE_JOINT_ONLY)
        return mbsri_coordinate_kind(b, true, def->option[0]) == MBSR_COORDINATE_ROTATION;
    return find_entries(def, " (rest").count > 0 && mbsri_is_angle(b->joint.space, def->option[0]);
}

/* The geometric mean of parameters of one name, as those of a turn; 0: there are none. */
static double mean_of(const mbsr_model *m, const char *name, const char *drive)
{
    const mbsri_force *force = m->forces.data;
    double sum = 0.0;
    int found = 0;
    for (size_t l = 0; l < m->forces.count; ++l, ++force) {
        entries e = find_entries(&force->def, name);
        if (e.count == 0) e = find_entries(&force->def, drive);
        if (force->closure != MBSR_NONE || force->resting) continue;
        for (int k = 0; k < e.count; ++k) {
            const double value = force->def.param[e.first + k];
            if (!(value > 0.0) || (e.count == 9 && k % 4 != 0)) continue;
            sum += log(value) +
                   (mbsri_is_of_turn(m, force, e.count, k) ? 0.0 : 2.0 * log(m->typical.length));
            ++found;
        }
    }
    return found > 0 ? exp(sum / found) : 0.0;
}

/* Of all elements. */
static double stiffness_of(const mbsr_model *m)
{
    return mean_of(m, " (stiffness", " (kp");
}

static double damping_of(const mbsr_model *m)
{
    return mean_of(m, " (damping", " (kd");
}

double mbsri_elements_rate(const mbsr_model *m)
{
    static const double pi = 3.14159265358979323846;
    const double inertia = m->typical.mass * m->typical.length * m->typical.length;
    if (!(m->typical.length > 0.0)) return 0.0;
    const double stiffness = stiffness_of(m), damping = damping_of(m);
    if (inertia > 0.0 && stiffness > 0.0) return sqrt(stiffness / inertia) / (2.0 * pi);
    if (inertia > 0.0) return damping / inertia;
    return damping > 0.0 ? stiffness / damping : 0.0;
}

double mbsri_elements_inertia(const mbsr_model *m)
{
    const double rate = m->typical.frequency > 0.0 ? m->typical.frequency : 1.0;
    if (!(m->typical.length > 0.0)) return 0.0;
    return fmax(stiffness_of(m) / (rate * rate), damping_of(m) / rate);
}
