/* Bodies as elements of MJCF, each within its predecessor.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "files/solids.h"
#include "files/writer.h"
#include "files/xml.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static bool differs(const mbsr_frame *frame)
{
    const mbsr_frame unit = mbsr_frame_identity();
    double most = 0.0;
    for (int k = 0; k < 9; ++k) most = fmax(most, fabs(frame->R[k] - unit.R[k]));
    return most > 1e-15;
}

/* ---- inertias ---- */

/* What MuJoCo refuses, or changes. */
static void find_weight(mbsri_file_writer *w, int k, const char *element, double mass,
                        const double tensor[6])
{
    double moments[3];
    mbsri_moments(tensor, moments);
    if (w->def[k].joint.n > 0 && !(mass > 0.0))
        mbsri_write_find(w, element, "it has no mass: MuJoCo refuses the file");
    else if (w->def[k].joint.n > 0 && !(moments[0] > 0.0))
        mbsri_write_find(w, element,
                         "it has no moment of inertia about some axis: MuJoCo refuses the file");
    else if (moments[2] > (1.0 + 1e-6) * (moments[0] + moments[1]))
        mbsri_write_find(w, element,
                         "one moment of inertia is above the sum of the others: MuJoCo refuses the "
                         "file");
}

static void write_inertia(mbsri_file_writer *w, int k, const char *element)
{
    double mass, centre[3], I[6];
    const mbsr_inertia *inertia = &w->def[k].inertia;
    if (!mbsri_solid_of(inertia, &mass, centre, I)) {
        mbsri_write_find(w, element, "its inertia is no rigid body's: it is left out");
        return;
    }
    find_weight(w, k, element, mass, I);
    if (inertia->kind == MBSR_INERTIA_NOT_GIVEN) return;
    const bool diagonal = !(fabs(I[3]) > 0.0) && !(fabs(I[4]) > 0.0) && !(fabs(I[5]) > 0.0);
    mbsri_begin(&w->text, "inertial");
    mbsri_set_numbers(&w->text, "pos", 3, centre);
    mbsri_set_number(&w->text, "mass", mass);
    mbsri_set_numbers(&w->text, diagonal ? "diaginertia" : "fullinertia", diagonal ? 3 : 6, I);
    mbsri_end(&w->text);
}

/* ---- joints ---- */

static void find_joint(mbsri_file_writer *w, const mbsri_written_joint *j, const char *what)
{
    char element[120];
    snprintf(element, sizeof element, "joint '%.80s'", j->name);
    mbsri_write_find(w, element, "%s", what);
}

static void set_passive(mbsri_file_writer *w, const mbsri_written_joint *j)
{
    mbsri_text *t = &w->text;
    const double armature = mbsr_body_armature(w->model, j->body)[j->coordinate],
                 rest = fabs(j->stiffness) > 0.0 ? j->moment / j->stiffness : 0.0;
    if (fabs(j->stiffness) > 0.0) mbsri_set_number(t, "stiffness", j->stiffness);
    if (fabs(rest) > 0.0) mbsri_set_number(t, "springref", rest);
    if (fabs(j->damping) > 0.0) mbsri_set_number(t, "damping", j->damping);
    if (armature > 0.0) mbsri_set_number(t, "armature", armature);
    if (!j->of) return;
    if (j->of->friction > 0.0) mbsri_set_number(t, "frictionloss", j->of->friction);
    if (j->of->limited) {
        mbsri_set_text(t, "limited", "true");
        mbsri_set_numbers(t, "range", 2, j->of->range);
    }
}

static void write_joint(mbsri_file_writer *w, const mbsri_written_joint *j)
{
    static const char *const types[] = {"", "hinge", "slide", "ball", "free"};
    mbsri_text *t = &w->text;
    mbsri_begin(t, "joint");
    mbsri_set_text(t, "name", j->name);
    mbsri_set_text(t, "type", types[j->kind]);
    if (j->kind == MBSR_FILE_HINGE || j->kind == MBSR_FILE_SLIDE)
        mbsri_set_numbers(t, "axis", 3, j->axis);
    if (j->kind == MBSR_FILE_HINGE || j->kind == MBSR_FILE_BALL)
        mbsri_set_numbers(t, "pos", 3, j->anchor);
    if (j->of && fabs(j->of->ref) > 0.0) mbsri_set_number(t, "ref", j->of->ref);
    set_passive(w, j);
    mbsri_end(t);
}

static void write_own_joints(mbsri_file_writer *w, int k)
{
    const mbsr_joint_chain *c = w->chain + k;
    const mbsri_written_joint *j = w->joint + w->joint_at[k];
    const bool is_free = c->quaternion && c->axes > 0;
    const double *B = c->B.x;
    if (is_free && (differs(&c->A) || differs(&c->B) || fabs(c->A.x[0]) + fabs(c->A.x[1]) > 0.0 ||
                    fabs(c->A.x[2]) + fabs(B[0]) + fabs(B[1]) + fabs(B[2]) > 0.0))
        find_joint(w, j, "its coordinates are those of the body in the world");
    if (c->quaternion && !is_free && differs(&c->B))
        find_joint(w, j, "its quaternion is told along the body's axes");
    if (c->quaternion || c->axes > 0) {
        if (w->joint_at[k] < w->reached)
            find_joint(w, j, "its coordinates come later in the text than in the model");
        w->reached = w->joint_at[k] + 1;
    }
    for (int l = 0; l < (c->quaternion ? 1 : c->axes); ++l) write_joint(w, j + l);
}

/* Those of bodies in between first, outermost before. */
static void write_joints(mbsri_file_writer *w, int k)
{
    int chain[MBSRI_XML_DEPTH], count = 0;
    for (int at = k; at != MBSR_NONE && count < MBSRI_XML_DEPTH; at = w->before[at])
        chain[count++] = at;
    while (count > 0) write_own_joints(w, chain[--count]);
}

/* ---- bodies ---- */

/* The part of its weight that is carried, where it is one. */
static void write_lift(mbsri_file_writer *w, int k, const char *element)
{
    double mass, centre[3], tensor[6], along = 0.0, weight = 0.0, off = 0.0, size = 0.0;
    const double *F = w->lift + 3 * k, *g = w->gravity;
    (void)mbsri_solid_of(&w->def[k].inertia, &mass, centre, tensor);
    for (int l = 0; l < 3; ++l) {
        along -= F[l] * g[l] * mass;
        weight += mass * mass * g[l] * g[l];
        size += fabs(F[l]);
    }
    if (!(size > 0.0)) return;
    const double part = weight > 0.0 ? along / weight : 0.0;
    for (int l = 0; l < 3; ++l) off += fabs(F[l] + part * mass * g[l]);
    if (off <= 1e-12 * size)
        mbsri_set_number(&w->text, "gravcomp", part);
    else
        mbsri_write_find(w, element, "a force on it is left out: it is not against its weight");
}

static void begin_body(mbsri_file_writer *w, int k)
{
    char element[120];
    snprintf(element, sizeof element, "body '%.80s'", w->body[k]);
    mbsri_begin(&w->text, "body");
    mbsri_set_text(&w->text, "name", w->body[k]);
    mbsri_write_frame(w, w->frame + k);
    write_lift(w, k, element);
    mbsri_into(&w->text);
    if (mbsr_body_regularisation(w->model, k))
        mbsri_write_find(w, element, "what was added to its mass matrix is left out");
    write_inertia(w, k, element);
    write_joints(w, k);
    mbsri_write_places(w, k);
}

/* First child and next sibling of each body, in ascending order; [0] and on: of the world, then of
 * body 0. */
static bool link_children(mbsri_file_writer *w, int **first, int **next)
{
    const size_t size = ((size_t)w->bodies + 1) * sizeof **first;
    *first = mbsri_arena_take(w->arena, size);
    *next = mbsri_arena_take(w->arena, size);
    if (!*first || !*next) return false;
    for (int k = 0; k <= w->bodies; ++k) (*first)[k] = -1;
    for (int k = w->bodies - 1; k >= 0; --k) {
        const int on = w->def[k].parent + 1;
        if (w->joined[k]) continue;
        (*next)[k] = (*first)[on];
        (*first)[on] = k;
    }
    return true;
}

void mbsri_write_bodies(mbsri_file_writer *w)
{
    int *first, *next;
    if (!link_children(w, &first, &next) || !mbsri_write_find_places(w)) return;
    mbsri_write_assets(w);
    mbsri_begin(&w->text, "worldbody");
    mbsri_into(&w->text);
    mbsri_write_places(w, MBSR_GROUND);
    for (int k = first[0]; k >= 0;) {
        begin_body(w, k);
        int on = first[k + 1];
        while (on < 0 && k >= 0) {
            mbsri_out(&w->text, "body");
            on = next[k];
            k = w->def[k].parent;
        }
        k = on;
    }
    mbsri_out(&w->text, "worldbody");
}
