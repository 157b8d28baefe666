/* Joint coordinates that are locked, and what refers to them: see locked.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "model/locked.h"

#include "base/error.h"
#include "closures/coupling.h"
#include "forces/drive.h"

#include <math.h>

static const mbsri_body_entry *given_entry(const mbsr_model *m, int id)
{
    return (const mbsri_body_entry *)m->entries.data + id;
}

const double *mbsri_locked_values(const mbsr_model *m, int id)
{
    const bool known = id >= 0 && (size_t)id < m->entries.count;
    if (!known || given_entry(m, id)->locks == 0) return NULL;
    return (const double *)m->stored.matrices.data + given_entry(m, id)->locked_at;
}

static bool is_locked(const mbsr_model *m, int id, int coordinate)
{
    const double *locked_at = mbsri_locked_values(m, id);
    return locked_at && coordinate >= 0 && coordinate < given_entry(m, id)->joint.n &&
           !isnan(locked_at[coordinate]);
}

/* Place of a coordinate that is not locked, counted as given, among those that are left. What the
 * joint does not have stays as it is, to be refused. */
static int place_left(const mbsr_model *m, int id, int coordinate)
{
    const double *locked_at = mbsri_locked_values(m, id);
    int place = 0;
    if (!locked_at || coordinate < 0 || coordinate >= given_entry(m, id)->joint.n)
        return coordinate;
    for (int k = 0; k < coordinate; ++k) place += isnan(locked_at[k]);
    return place;
}

bool mbsri_force_rests(const mbsr_model *m, const mbsr_force_def *def, const int *body)
{
    const int count = mbsri_force_coordinates(def);
    bool rests = count > 0, drops = false;
    for (int k = 0; k < count; ++k) {
        const bool locked = is_locked(m, body[k], def->option[k]);
        rests = rests && locked;
        drops = drops || (locked && given_entry(m, body[k])->drops_locked);
    }
    return rests || drops;
}

void mbsri_force_hold(const mbsr_model *m, mbsri_force *force, const int *body)
{
    mbsr_force_def *def = &force->def;
    const int count = mbsri_force_coordinates(def);
    for (int k = 0; k < MBSR_FORCE_OPTIONS; ++k) force->given[k] = def->option[k];
    for (int k = 0; k < count && !force->resting; ++k) {
        const int given = def->option[k];
        if (is_locked(m, body[k], given))
            mbsri_gear_hold(def, k, mbsri_locked_values(m, body[k])[given]);
        else
            def->option[k] = place_left(m, body[k], given);
    }
}

void mbsri_force_as_given(const mbsri_force *force, mbsr_force_def *def)
{
    *def = force->def;
    if (mbsri_force_coordinates(def) == 0) return;
    mbsri_gear_release(def);
    for (int k = 0; k < mbsri_force_coordinates(def); ++k) def->option[k] = force->given[k];
}

int mbsri_resting_energy(const mbsr_model *m, const mbsri_force *force, double *energy)
{
    const mbsr_force_def *def = &force->def;
    const int *on = m->stored.list_index + force->list;
    mbsr_force_body body[2] = {{0}};
    *energy = 0.0;
    for (int k = 0; k < def->bodies; ++k) {
        const int id = m->body[on[k]].id;
        if (given_entry(m, id)->drops_locked) return MBSR_OK;
        body[k].id = id;
        body[k].q = mbsri_locked_values(m, id);
    }
    const mbsr_force_args args = {.force = def, .bodies = def->bodies, .body = body};
    return def->table->energy ? def->table->energy(&args, energy) : MBSR_OK;
}

/* ---- couplings ---- */

bool mbsri_term_is_held(const mbsr_model *m, const mbsr_closure_def *def, int k)
{
    return mbsri_is_linear_coupling(def) && is_locked(m, def->body[k], def->option[k]);
}

const mbsr_closure_def *mbsri_closure_as_given(const mbsr_model *m, const mbsri_closure *closure)
{
    if (closure->given == 0) return &closure->def;
    return (const mbsr_closure_def *)m->given.closures.data + (closure->given - 1);
}

/* Takes the terms that are locked out of def; whether one of them is dropped, how many there are,
 * and how large g may be by rounding of what they add. */
typedef struct taken {
    int terms;
    bool drops;
    double size;
} taken;

static taken take_terms(const mbsr_model *m, mbsr_closure_def *def)
{
    taken t = {0, false, fabs(mbsri_coupling_rest(def))};
    for (int k = def->bodies - 1; k >= 0; --k) {
        const int id = def->body[k], coordinate = def->option[k];
        if (!mbsri_term_is_held(m, def, k)) {
            def->option[k] = place_left(m, id, coordinate);
            continue;
        }
        t.drops = t.drops || given_entry(m, id)->drops_locked;
        t.size += mbsri_coupling_hold(def, k, mbsri_locked_values(m, id)[coordinate]);
        ++t.terms;
    }
    return t;
}

int mbsri_coupling_left(mbsr_model *m, mbsri_closure *closure, char text[MBSR_TEXT_SIZE])
{
    static const double rounding = 1e-12;
    bool any = false;
    for (int k = 0; k < closure->def.bodies && mbsri_is_linear_coupling(&closure->def); ++k)
        any = any || mbsri_locked_values(m, closure->def.body[k]);
    if (!any) return MBSR_OK;
    if (!mbsri_reserve(&m->allocator, &m->given.closures, 1, sizeof closure->def)) {
        mbsri_print(text, MBSR_TEXT_SIZE, "no memory");
        return MBSR_ERR_NO_MEMORY;
    }
    ((mbsr_closure_def *)m->given.closures.data)[m->given.closures.count++] = closure->def;
    closure->given = (int)m->given.closures.count;
    mbsr_closure_def *def = &closure->def;
    const taken t = take_terms(m, def);
    const double g = mbsri_coupling_rest(def);
    if (t.drops) def->bodies = 0;
    if (t.drops || def->bodies > 0) return MBSR_OK;
    if (mbsri_coupling_moves(def)) {
        mbsri_print(text, MBSR_TEXT_SIZE, "moves with time, but all its coordinates are locked");
        return MBSR_ERR_VALUE;
    }
    if (def->stiffness[0] > 0.0 || fabs(g) <= rounding * t.size) return MBSR_OK;
    mbsri_print(text, MBSR_TEXT_SIZE, "all its coordinates are locked, and the row is %g there", g);
    return MBSR_ERR_VALUE;
}
