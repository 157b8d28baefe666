/* Masses and moments of inertia that count as zero, and back.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "model/neglect.h"

#include "base/error.h"
#include "base/memory.h"
#include "model/check.h"
#include "model/entry.h"
#include "model/query.h"

enum { PARTS = MBSR_MASS_AND_MOMENT };

static int refuse_neglect(mbsr_model *m, int status, int body, const char *function,
                          const char *text)
{
    char label[MBSRI_LABEL];
    const mbsri_body_entry *entry = (const mbsri_body_entry *)m->entries.data + body;
    mbsri_label(label, "body", body, (const char *)m->stored.names.data + entry->name);
    return mbsri_fail(&m->error, status, body, MBSR_NONE, "%s: %s: %s", label, function, text);
}

int mbsri_inertia_parts(const mbsr_inertia *inertia)
{
    int parts = 0;
    switch (inertia->kind) {
    case MBSR_INERTIA_PARTICLE: return inertia->mass > 0.0 ? MBSR_MASS : 0;
    case MBSR_INERTIA_PLANAR:
        return (inertia->mass > 0.0 ? MBSR_MASS : 0) | (inertia->moment > 0.0 ? MBSR_MOMENT : 0);
    case MBSR_INERTIA_SPATIAL:
        for (int k = 0; k < 6; ++k)
            if (inertia->tensor[k] != 0.0) parts = MBSR_MOMENT;
        return parts | (inertia->mass > 0.0 ? MBSR_MASS : 0);
    case MBSR_INERTIA_MATRIX: return inertia->matrix ? PARTS : 0;
    case MBSR_INERTIA_FUNCTION: return PARTS;
    case MBSR_INERTIA_FLEXIBLE: /* which modes have mass is for the modal data to say */
    case MBSR_INERTIA_INVALID:
    case MBSR_INERTIA_NOT_GIVEN: break;
    }
    return 0;
}

mbsr_inertia mbsri_inertia_without(const mbsr_inertia *inertia, int parts)
{
    mbsr_inertia left = *inertia;
    if ((mbsri_inertia_parts(inertia) & ~parts) == 0) return mbsr_inertia_zero();
    if (parts & MBSR_MASS) left.mass = 0.0;
    if (parts & MBSR_MOMENT) {
        left.moment = left.lost = 0.0;
        for (int k = 0; k < 6; ++k) left.tensor[k] = left.tensor_rest[k] = 0.0;
    }
    return left;
}

/* Puts the inertia given back, and the last record in the place of this one. */
static void restore(mbsr_model *m, mbsri_body_entry *entry)
{
    mbsri_neglected *record = m->given.inertias.data, *own = record + entry->neglected - 1;
    const mbsri_neglected *last = record + --m->given.inertias.count;
    entry->inertia = own->given;
    entry->regular = own->regular;
    if (own != last) {
        ((mbsri_body_entry *)m->entries.data)[last->body].neglected = entry->neglected;
        *own = *last;
    }
    entry->neglected = 0;
}

/* Whether the body has all of these parts. */
static int check_parts(mbsr_model *m, const mbsr_inertia *given, int body, int parts,
                       const char *function)
{
    const int has = mbsri_inertia_parts(given);
    const bool whole = given->kind == MBSR_INERTIA_MATRIX || given->kind == MBSR_INERTIA_FUNCTION;
    if (parts < 1 || parts > PARTS)
        return refuse_neglect(m, MBSR_ERR_VALUE, body, function,
                              "parts must be MBSR_MASS, MBSR_MOMENT or both");
    if (given->kind == MBSR_INERTIA_FLEXIBLE)
        return refuse_neglect(m, MBSR_ERR_VALUE, body, function,
                              "the masses of a flexible body are those of its modal data");
    if (has == 0)
        return refuse_neglect(m, MBSR_ERR_VALUE, body, function, "the body has no inertia");
    if (whole && parts != PARTS)
        return refuse_neglect(
            m, MBSR_ERR_VALUE, body, function,
            "an inertia by matrix or function has no parts, only MBSR_MASS_AND_MOMENT");
    if ((has & parts) == 0)
        return refuse_neglect(m, MBSR_ERR_VALUE, body, function,
                              parts == MBSR_MASS ? "the body has no mass"
                                                 : "the body has no moment");
    return MBSR_OK;
}

int mbsr_model_neglect(mbsr_model *model, int body, int parts)
{
    static const char function[] = "mbsr_model_neglect";
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    int status;
    mbsri_body_entry *entry = mbsri_find_entry(m, body, function, &status);
    if (!entry) return status;
    const bool before = entry->neglected > 0;
    const mbsr_inertia given =
        before ? ((mbsri_neglected *)m->given.inertias.data)[entry->neglected - 1].given
               : entry->inertia;
    status = check_parts(m, &given, body, parts, function);
    if (status) return status;
    if (!mbsri_reserve(&m->allocator, &m->given.inertias, 1, sizeof(mbsri_neglected)))
        return refuse_neglect(m, MBSR_ERR_NO_MEMORY, body, function, "no memory");
    if (before) restore(m, entry);
    ((mbsri_neglected *)m->given.inertias.data)[m->given.inertias.count++] =
        (mbsri_neglected){.body = body,
                          .parts = parts & mbsri_inertia_parts(&given),
                          .given = given,
                          .matrix = entry->matrix,
                          .regular = entry->regular};
    entry->neglected = (int)m->given.inertias.count;
    entry->inertia = mbsri_inertia_without(&given, parts);
    /* what was added to M (mbsr_model_regularise) may be regular by itself; this is no loss but
     * time */
    entry->regular = false;
    return MBSR_OK;
}

int mbsr_model_restore(mbsr_model *model, int body)
{
    mbsr_model *m = model;
    if (!m) return MBSR_ERR_NULL;
    int status;
    mbsri_body_entry *entry = mbsri_find_entry(m, body, "mbsr_model_restore", &status);
    if (entry && entry->neglected > 0) restore(m, entry);
    return status;
}

int mbsr_body_neglected(const mbsr_model *model, int body)
{
    if (!model || !model->finished) return -1;
    const int i = mbsri_index(model, body);
    if (i <= 0) return -1;
    const int place = model->body[i].mass.neglected;
    return place > 0 ? ((const mbsri_neglected *)model->given.inertias.data)[place - 1].parts : 0;
}
