/* What the parts of the writer share: see writer.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/writer.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const char *mbsri_write_print(mbsri_file_writer *w, const char *format, ...)
{
    char text[MBSR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    const char *kept = mbsri_arena_text(w->arena, text, strlen(text));
    return kept ? kept : "";
}

void mbsri_write_find(mbsri_file_writer *w, const char *element, const char *format, ...)
{
    char text[MBSR_TEXT_SIZE];
    mbsr_finding *f = mbsri_list_add(w->arena, &w->findings, sizeof *f);
    if (!f) return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    *f = (mbsr_finding){.file = "",
                        .element = mbsri_arena_text(w->arena, element, strlen(element)),
                        .text = mbsri_arena_text(w->arena, text, strlen(text))};
}

void mbsri_write_frame(mbsri_file_writer *w, const mbsr_frame *frame)
{
    static const double unit[9] = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    double quaternion[4];
    bool turned = false;
    for (int k = 0; k < 9; ++k) turned = turned || fabs(frame->R[k] - unit[k]) > 0.0;
    mbsri_set_numbers(&w->text, "pos", 3, frame->x);
    if (!turned) return;
    mbsr_rotation_quaternion(frame->R, quaternion);
    mbsri_set_numbers(&w->text, "quat", 4, quaternion);
}

/* How many sites of the file have a name. */
static int count_sites(const mbsri_file_writer *w, const char *name)
{
    int count = 0;
    for (int k = 0; w->file && k < w->file->sites; ++k)
        count += strcmp(w->file->site[k].name, name) == 0;
    return count;
}

static bool are_alike(const mbsr_frame *a, const mbsr_frame *b)
{
    double size = 0.0, turn = 0.0, way = 0.0;
    for (int k = 0; k < 9; ++k) turn = fmax(turn, fabs(a->R[k] - b->R[k]));
    for (int k = 0; k < 3; ++k) {
        size = fmax(size, fmax(fabs(a->x[k]), fabs(b->x[k])));
        way = fmax(way, fabs(a->x[k] - b->x[k]));
    }
    return turn <= 1e-14 && way <= 1e-15 * size;
}

const char *mbsri_write_site_name(mbsri_file_writer *w, int body, const mbsr_frame *frame,
                                  const char *base, bool *there)
{
    *there = false;
    for (int k = 0; w->file && k < w->file->sites; ++k) {
        const mbsr_file_site *site = w->file->site + k;
        if (site->body != body || !*site->name || !are_alike(&site->frame, frame)) continue;
        *there = count_sites(w, site->name) == 1;
        if (*there) return site->name;
    }
    while (*base && count_sites(w, base) > 0) base = mbsri_write_print(w, "%s_", base);
    return base;
}

const char *mbsri_write_end_name(mbsri_file_writer *w, const mbsr_closure_def *def, int id, int k,
                                 bool *there)
{
    const double *x = def->param + 12 * k;
    const mbsr_frame frame = mbsr_frame_at(x[0], x[1], x[2]);
    const char *base = mbsri_write_print(w, "closure_%d_%c", id, 'a' + k);
    return mbsri_write_site_name(w, def->body[k], &frame, base, there);
}

void mbsri_write_section(mbsri_file_writer *w, bool *open, const char *name)
{
    if (*open) return;
    *open = true;
    mbsri_begin(&w->text, name);
    mbsri_into(&w->text);
}

const mbsri_written_joint *mbsri_written_joint_of(const mbsri_file_writer *w, int body,
                                                  int coordinate)
{
    const mbsri_written_joint *j = w->joint + w->joint_at[body] + coordinate;
    return j->name ? j : NULL;
}

bool mbsri_written_has_axis(const mbsri_written_joint *j)
{
    return j && (j->kind == MBSR_FILE_HINGE || j->kind == MBSR_FILE_SLIDE);
}

bool mbsri_written_has_axes(const mbsri_file_writer *w, const mbsr_closure_def *def)
{
    for (int k = 0; k < def->bodies; ++k)
        if (!mbsri_written_has_axis(mbsri_written_joint_of(w, def->body[k], def->option[k])))
            return false;
    return true;
}
