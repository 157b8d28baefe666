/* The directions of a report in joint rates, with the elements that determine them, and as text.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "massless/report_parts.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "massless/null_loops.h"
#include "massless/scales.h"
#include "model/query.h"
#include "recursion/closures.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Joint rates of found direction l, after list_forces, those below 1e-6 of the largest left out
 * unless elements see no others, a velocity compared with an angular rate times the typical length;
 * the largest number made 1. Returns how many there are; writes them where term is not NULL. */
static int list_terms(mbsri_report *r, int l, mbsr_direction_term *term)
{
    const mbsr_model *m = r->w.m;
    mbsri_null_mix(&r->w, MBSRI_NULL_RATES, r->weights + (size_t)l * (size_t)r->w.k, r->u, r->size);
    double largest = 0.0;
    for (int k = 0; k < m->nu; ++k) {
        if (fabs(r->u[k]) > fabs(largest)) largest = r->u[k];
    }
    int count = 0;
    for (int id = 0; id < m->bodies; ++id) {
        const mbsri_body *b = m->body + m->index[id];
        for (int k = 0; k < b->n; ++k) {
            const double x = r->u[b->u + k];
            const bool small = fabs(x) / r->w.scale.span[b->u + k] < r->least;
            if (x == 0.0 || (small && x != largest)) continue;
            if (term) term[count] = (mbsr_direction_term){id, k, x / largest};
            ++count;
        }
    }
    return count;
}

/* Ids of the elements that determine found direction l, their number in *count; written where force
 * is not NULL. */
static int list_forces(mbsri_report *r, int l, int *force, int *count)
{
    const mbsr_model *m = r->w.m;
    const mbsri_force *element = m->forces.data;
    mbsri_report_combine(r, r->weights + (size_t)l * (size_t)r->w.k);
    const int status = mbsri_report_see(r, r->kind[l], count);
    for (size_t k = 0; k < m->forces.count && force && !status; ++k) {
        if (r->determining[k]) *force++ = element[k].id;
    }
    return status;
}

/* Ids of the closures that determine found direction l, after list_forces; written where closure is
 * not NULL. */
static int list_closures(mbsri_report *r, int l, int *closure)
{
    const mbsr_model *m = r->w.m;
    const mbsri_closure *first = mbsri_all_closures(m);
    int count = 0;
    if (r->kind[l] == MBSR_DIRECTION_UNDETERMINED) return 0;
    for (int id = 0; id < (int)m->closures.count; ++id) {
        if (!mbsri_null_closure_resists(&r->w, first + id, r->twist, r->u,
                                        r->kind[l] == MBSR_DIRECTION_DAMPED))
            continue;
        if (closure) closure[count] = id;
        ++count;
    }
    return count;
}

/* Appends to a text of `size` bytes, or with text == NULL only counts. */
static void append(char *text, size_t size, size_t *used, const char *format, const char *string,
                   double number)
{
    char piece[MBSRI_LABEL + 64];
    const int length = mbsri_print(piece, sizeof piece, format, string, number);
    if (length < 0) return;
    if (text && *used + (size_t)length < size) memcpy(text + *used, piece, (size_t)length + 1);
    *used += (size_t)length;
}

/* "bodies 'a', 'b': 1 u('a') - 0.5 u('b'): ..." */
static void describe(const mbsr_model *m, const mbsr_direction *direction, char *text, size_t size,
                     size_t *used)
{
    enum { SHOWN = 6 };
    char label[MBSRI_LABEL];
    const int shown = direction->terms < SHOWN ? direction->terms : SHOWN;
    append(text, size, used, *used > 0 ? "\n%s" : "%s", "", 0.0);
    for (int k = 0; k < shown; ++k) {
        const mbsr_direction_term *term = direction->term + k;
        if (k > 0 && term->body == term[-1].body) continue; /* each body once */
        append(text, size, used, k > 0 ? ", %s" : "%s",
               mbsri_body_label(m, m->index[term->body], label), 0.0);
    }
    append(text, size, used, direction->terms > SHOWN ? "%s and others: " : "%s: ", "", 0.0);
    for (int k = 0; k < shown; ++k) {
        const mbsr_direction_term *term = direction->term + k;
        char name[MBSRI_LABEL];
        snprintf(name, sizeof name, "u%d of body %d", term->coordinate, term->body);
        append(text, size, used, k > 0 ? "%s%+.3g " : "%s%.3g ", k > 0 ? " " : "", term->weight);
        append(text, size, used, "%s", name, 0.0);
    }
    append(text, size, used,
           direction->terms == 1 ? "%s moves no mass, and no force resists it: "
                                 : "%s together move no mass, and no force resists them: ",
           "", 0.0);
    const char *advice = "";
    for (int k = 0; k < direction->terms && !*advice; ++k)
        advice = mbsri_mass_advice(m, m->index[direction->term[k].body]);
    append(text, size, used, "give it inertia%s, a spring or a damper, or lock it", advice, 0.0);
}

/* Terms of all directions, and forces and closures: how many. */
static int count_all(mbsri_report *r, size_t *terms, size_t *forces)
{
    *terms = *forces = 0;
    for (int l = 0; l < r->found; ++l) {
        int count;
        const int status = list_forces(r, l, NULL, &count);
        if (status) return status;
        *forces += (size_t)(count + list_closures(r, l, NULL));
        *terms += (size_t)list_terms(r, l, NULL);
    }
    return MBSR_OK;
}

/* The directions in their order, with their terms, forces and text. */
static int write_directions(mbsri_report *r, mbsr_direction *direction, mbsr_direction_term *term,
                            int *force, char *line, size_t text)
{
    static const mbsr_direction_kind order[] = {MBSR_DIRECTION_UNDETERMINED, MBSR_DIRECTION_ELASTIC,
                                                MBSR_DIRECTION_DAMPED};
    size_t used = 0;
    line[0] = '\0';
    for (int pass = 0; pass < 3; ++pass) {
        for (int l = 0; l < r->found; ++l) {
            if (r->kind[l] != order[pass]) continue;
            *direction = (mbsr_direction){r->kind[l], 0, term, 0, force, 0, NULL};
            const int status = list_forces(r, l, force, &direction->forces);
            if (status) return status;
            force += direction->forces;
            direction->closures = list_closures(r, l, force);
            direction->closure = force;
            force += direction->closures;
            direction->terms = list_terms(r, l, term);
            term += direction->terms;
            if (pass == 0) describe(r->w.m, direction, line, text, &used);
            ++direction;
        }
    }
    return MBSR_OK;
}

/* Everything in one block: report, directions, terms, forces, text. */
int mbsri_report_write(mbsri_report *r, mbsr_index_report result, mbsr_index_report **report)
{
    const mbsr_model *m = r->w.m;
    size_t terms, forces;
    int status = count_all(r, &terms, &forces);
    if (status) return status;
    /* a line of text names at most six bodies twice */
    const size_t text = (size_t)result.undetermined * (size_t)(8 * MBSRI_LABEL + 512) + 1;
    const size_t first = sizeof result + (size_t)r->found * sizeof(mbsr_direction);
    mbsr_index_report *made = mbsri_allocate(
        &m->allocator, first + terms * sizeof(mbsr_direction_term) + forces * sizeof(int) + text);
    if (!made) {
        return mbsri_fail(&r->w.d->error, MBSR_ERR_NO_MEMORY, MBSR_NONE, MBSR_NONE,
                          "%s: no memory for %d directions", r->w.function, r->found);
    }
    mbsr_direction *direction = (mbsr_direction *)(void *)(made + 1);
    mbsr_direction_term *term = (mbsr_direction_term *)(void *)(direction + r->found);
    int *force = (int *)(void *)(term + terms);
    char *line = (char *)(force + forces);
    result.direction = direction;
    result.text = line;
    *made = result;
    status = write_directions(r, direction, term, force, line, text);
    if (status) {
        mbsri_release(&m->allocator, made);
        return status;
    }
    *report = made;
    return MBSR_OK;
}
