/* What single force elements do at a state, and switching them off.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "base/error.h"
#include "dynamics/entry.h"
#include "forces/contact.h"
#include "forces/gravity.h"
#include "model/query.h"
#include "recursion/elements.h"
#include "recursion/not_finite.h"

#include <mbsrank/dynamics.h>

static int no_place(mbsr_data *d, const mbsri_force *force, int place)
{
    return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, force->id,
                      "mbsr_force_load: place is %d; force %d (%s) acts on %d bodies", place,
                      force->id, force->def.table->name, force->def.bodies);
}

int mbsr_force_load(const mbsr_model *model, mbsr_data *data, int force, int place, double *f,
                    double *tau)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    int status = mbsri_enter(m, d, true, MBSRI_STAGE_VELOCITIES, "mbsr_force_load");
    if (status) return status;
    const mbsri_force *element = mbsri_find_force(m, d, force, "mbsr_force_load");
    if (!element) return MBSR_ERR_ID;
    const bool every = (element->def.table->flags & MBSR_FORCE_EVERY_BODY) != 0;
    const int most = every ? m->bodies : element->def.bodies;
    if (place < 0 || place >= most) return no_place(d, element, place);
    const int i = every ? m->index[place] : m->stored.list_index[element->list + (size_t)place];
    const mbsri_body *b = m->body + i;
    /* behind what mbsri_force_on takes of the scratch */
    double *own_f = d->scratch + m->most.d + m->most.n, *own_tau = own_f + m->most.d;
    mbsri_zero((size_t)(m->most.d + m->most.n), own_f);
    status = mbsri_force_on(m, d, element, every ? i : place, own_f, own_tau);
    if (!status) status = mbsri_check_result(m, d, (size_t)b->d, own_f, "mbsr_force_load");
    if (!status) status = mbsri_check_result(m, d, (size_t)b->n, own_tau, "mbsr_force_load");
    if (status) return status;
    if (f) mbsri_copy((size_t)b->d, own_f, f);
    if (tau) mbsri_copy((size_t)b->n, own_tau, tau);
    return MBSR_OK;
}

int mbsr_contact_at(const mbsr_model *model, mbsr_data *data, int force, mbsr_contact_state *state)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    const int status = mbsri_enter(m, d, state, MBSRI_STAGE_VELOCITIES, "mbsr_contact_at");
    if (status) return status;
    const mbsri_force *element = mbsri_find_force(m, d, force, "mbsr_contact_at");
    if (!element) return MBSR_ERR_ID;
    if (!mbsri_is_contact(&element->def)) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, force,
                          "mbsr_contact_at: force %d (%s) is no contact", force,
                          element->def.table->name);
    }
    *state = (mbsr_contact_state){0};
    if (mbsri_force_off(m, d, element)) return MBSR_OK;
    const mbsr_force_args args = mbsri_force_args(d, element, mbsri_force_bodies(m, d, element, 0));
    mbsri_contact_at(&args, state);
    return mbsri_check_result(m, d, sizeof *state / sizeof(double), (const double *)state,
                              "mbsr_contact_at");
}

int mbsr_force_inspect(const mbsr_model *model, mbsr_data *data, int force,
                       int (*look)(const mbsr_force_args *args, void *user), void *user)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    const int status = mbsri_enter(m, d, look, MBSRI_STAGE_VELOCITIES, "mbsr_force_inspect");
    if (status) return status;
    const mbsri_force *element = mbsri_find_force(m, d, force, "mbsr_force_inspect");
    if (!element) return MBSR_ERR_ID;
    if (element->def.table->flags & MBSR_FORCE_EVERY_BODY) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, force,
                          "mbsr_force_inspect: force %d (%s) acts on every body", force,
                          element->def.table->name);
    }
    const mbsr_force_args args = mbsri_force_args(d, element, mbsri_force_bodies(m, d, element, 0));
    const int answer = look(&args, user);
    return answer ? mbsri_force_failed(m, d, element, answer, "mbsr_force_inspect: look") : MBSR_OK;
}

int mbsr_force_switch(const mbsr_model *model, mbsr_data *data, int force, int on)
{
    const mbsr_model *m = model;
    mbsr_data *d = data;
    const int status = mbsri_enter(m, d, true, MBSRI_STAGE_NONE, "mbsr_force_switch");
    if (status) return status;
    const mbsri_force *element = mbsri_find_force(m, d, force, "mbsr_force_switch");
    if (!element) return MBSR_ERR_ID;
    if (on != 0 && on != 1) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, force,
                          "mbsr_force_switch: on is %d, must be 0 or 1", on);
    }
    if (mbsri_is_gravity(&element->def)) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, force,
                          "mbsr_force_switch: force %d is gravity, which is always on", force);
    }
    if (element->closure != MBSR_NONE) {
        return mbsri_fail(&d->error, MBSR_ERR_VALUE, MBSR_NONE, force,
                          "mbsr_force_switch: force %d is closure %d, which is always on", force,
                          element->closure);
    }
    d->element.off[element - (const mbsri_force *)m->forces.data] = on == 0;
    if (d->stage > MBSRI_STAGE_VELOCITIES) d->stage = MBSRI_STAGE_VELOCITIES;
    d->accelerated = false;
    return MBSR_OK;
}
