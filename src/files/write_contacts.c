/* Writing MJCF: how shapes touch: see writer.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * What stands as MJCF has it by itself is not written. */
#include "files/writer.h"

#include <math.h>

/* Coefficients as far as condim counts them. */
static void set_friction(mbsri_text *t, const double friction[3], bool pair)
{
    const int count = friction[2] > 0.0 ? 3 : friction[1] > 0.0 ? 2 : friction[0] > 0.0 ? 1 : 0;
    static const char *const kinds[] = {"1", "3", "4", "6"};
    const double own[5] = {friction[0], friction[0], friction[1], friction[2], friction[2]};
    if (count != 1) mbsri_set_text(t, "condim", kinds[count]);
    if (count == 0 || (count == 1 && friction[0] == 1.0)) return;
    if (pair)
        mbsri_set_numbers(t, "friction", count == 1 ? 2 : count == 2 ? 3 : 5, own);
    else
        mbsri_set_numbers(t, "friction", count, friction);
}

static void set_law(mbsri_text *t, const double friction[3], const double settle[2], double margin,
                    bool pair)
{
    set_friction(t, friction, pair);
    if (settle[0] != 0.02 || settle[1] != 1.0) mbsri_set_numbers(t, "solref", 2, settle);
    if (margin > 0.0) mbsri_set_numbers(t, "margin", 1, &margin);
}

void mbsri_set_contact(mbsri_file_writer *w, const mbsr_file_shape *s)
{
    mbsri_text *t = &w->text;
    const unsigned groups = s->contact ? s->groups : 0, mask = s->contact ? s->mask : 0;
    if (groups != 1) mbsri_set_text(t, "contype", mbsri_write_print(w, "%u", groups));
    if (mask != 1) mbsri_set_text(t, "conaffinity", mbsri_write_print(w, "%u", mask));
    if (s->contact) set_law(t, s->friction, s->settle, s->margin, false);
}

static const char *name_of_body(const mbsri_file_writer *w, int body)
{
    return body == MBSR_GROUND ? "world" : w->joined[body] ? NULL : w->body[body];
}

static void write_exclude(mbsri_file_writer *w, bool *open, const int *body)
{
    const char *a = name_of_body(w, body[0]), *b = name_of_body(w, body[1]);
    if (!a || !b) return; /* bodies between joints of one body have no shapes */
    mbsri_write_section(w, open, "contact");
    mbsri_begin(&w->text, "exclude");
    mbsri_set_text(&w->text, "body1", a);
    mbsri_set_text(&w->text, "body2", b);
    mbsri_end(&w->text);
}

static void write_pair(mbsri_file_writer *w, bool *open, const mbsr_file_pair *pair)
{
    const char *a = w->file->shape[pair->shape[0]].name, *b = w->file->shape[pair->shape[1]].name;
    if (mbsri_names_find(&w->shapes, a) < 0 || mbsri_names_find(&w->shapes, b) < 0) {
        mbsri_write_find(w, "pair", "it is left out with shape '%.40s' or '%.40s'", a, b);
        return;
    }
    mbsri_write_section(w, open, "contact");
    mbsri_begin(&w->text, "pair");
    mbsri_set_text(&w->text, "geom1", a);
    mbsri_set_text(&w->text, "geom2", b);
    set_law(&w->text, pair->friction, pair->settle, pair->margin, true);
    mbsri_end(&w->text);
}

void mbsri_write_contacts(mbsri_file_writer *w)
{
    bool open = false;
    for (int k = 0; w->file && k < w->file->excluded; ++k)
        write_exclude(w, &open, w->file->exclude + 2 * (ptrdiff_t)k);
    for (int k = 0; w->file && k < w->file->pairs; ++k) write_pair(w, &open, w->file->pair + k);
    if (open) mbsri_out(&w->text, "contact");
}
