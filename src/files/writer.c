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
