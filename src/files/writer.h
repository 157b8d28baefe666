/* Writing a model as MJCF: what the parts of the writer share.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_WRITER_H
#define MBSRI_FILES_WRITER_H

#include "files/names.h"
#include "files/path.h"
#include "files/write_text.h"

#include <mbsrank/files.h>

#include <stdbool.h>

/* What is written; first its public part. */
typedef struct mbsri_file_written {
    mbsr_written written;
    mbsri_arena arena;
} mbsri_file_written;

/* A joint of the file to be: by the place of its first rate in u. */
typedef struct mbsri_written_joint {
    const char *name; /* NULL: no joint begins with this rate */
    mbsr_file_joint_kind kind;
    int body, coordinate;              /* as in mbsr_file_joint */
    const mbsr_file_joint *of;         /* what was read; NULL: nothing */
    double axis[3], anchor[3];         /* in the body as drawn */
    double stiffness, damping, moment; /* of its springs; moment: sum of stiffness times rest */
} mbsri_written_joint;

/* A spring along points, with the sites that it needs. */
typedef struct mbsri_written_spring {
    const char *name, *site[MBSRI_PATH_MOST];
    bool there[MBSRI_PATH_MOST]; /* the site is one of the file */
    int count, body[MBSRI_PATH_MOST];
    double point[MBSRI_PATH_MOST][3], stiffness, damping, rest[2];
} mbsri_written_spring;

typedef struct mbsri_file_writer {
    mbsri_arena *arena;
    const mbsr_model *model;
    const mbsr_file *file; /* NULL: none */
    const mbsr_write_opt *opt;
    mbsri_text text;
    mbsri_list findings;
    char message[MBSR_TEXT_SIZE]; /* why it cannot be written; "": it can */
    int bodies, nu;
    const char **body; /* names, by id */
    mbsr_body_def *def;
    mbsr_joint_chain *chain;
    mbsr_frame *frame, *world;  /* as drawn: in the parent, in the world */
    mbsri_written_joint *joint; /* nu */
    int *joint_at;              /* by body: its first rate */
    int reached;                /* of the joints written so far the last rate, and one */
    int *before;                /* the body whose joints stand before its own, MBSR_NONE */
    bool *joined;               /* its joints stand in its successor, and it is not written */
    double gravity[3];
    double *lift;       /* by body: what carries a part of its weight, N */
    mbsri_list springs; /* mbsri_written_spring */
    mbsri_names shapes, sites;
    const void *place;   /* what stands on bodies: mbsri_write_find_places */
    const int *place_at; /* by body and one, the ground first: its first one */
} mbsri_file_writer;

/* Lists what MJCF cannot say of an element: such as ("body 'a'", "..."). */
void mbsri_write_find(mbsri_file_writer *w, const char *element, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* A text of the arena by a format; "" without memory. */
const char *mbsri_write_print(mbsri_file_writer *w, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The name of a site on a body: of one that the file has there, *there, or else one that begins
 * like `base` and that no site of the file has. */
const char *mbsri_write_site_name(mbsri_file_writer *w, int body, const mbsr_frame *frame,
                                  const char *base, bool *there);

/* Likewise of end k of closure `id`, a ball. */
const char *mbsri_write_end_name(mbsri_file_writer *w, const mbsr_closure_def *def, int id, int k,
                                 bool *there);

/* pos and quat of a frame, left out where they are zero and 1. */
void mbsri_write_frame(mbsri_file_writer *w, const mbsr_frame *frame);

/* What force elements there are: springs of joints, gravity, springs between points. */
void mbsri_write_collect(mbsri_file_writer *w);

/* What stands on which body: shapes, and sites of the file and of what needs them. False without
 * memory. */
bool mbsri_write_find_places(mbsri_file_writer *w);

/* All of that on one body, or on the ground. */
void mbsri_write_places(mbsri_file_writer *w, int body);

/* Meshes and fields of heights of shapes. */
void mbsri_write_assets(mbsri_file_writer *w);

/* Bodies with their joints, inertias, shapes and sites. */
void mbsri_write_bodies(mbsri_file_writer *w);

/* The joint of a coordinate; NULL: it is none that a joint begins with. */
const mbsri_written_joint *mbsri_written_joint_of(const mbsri_file_writer *w, int body,
                                                  int coordinate);

/* Whether it is a joint with one axis; j may be NULL. All coordinates of a coupling. */
bool mbsri_written_has_axis(const mbsri_written_joint *j);
bool mbsri_written_has_axes(const mbsri_file_writer *w, const mbsr_closure_def *def);

/* Whether it is a pin whose points are apart as drawn. */
bool mbsri_written_is_open(const mbsri_file_writer *w, const mbsr_closure_def *def);

/* Begins a section with its first element. */
void mbsri_write_section(mbsri_file_writer *w, bool *open, const char *name);

/* How a shape touches, as attributes of its element; bodies that never touch, and pairs. */
void mbsri_set_contact(mbsri_file_writer *w, const mbsr_file_shape *s);
void mbsri_write_contacts(mbsri_file_writer *w);

void mbsri_write_equalities(mbsri_file_writer *w);
void mbsri_write_keys(mbsri_file_writer *w);

/* Equalities, tendons, actuators and keys. */
void mbsri_write_rest(mbsri_file_writer *w);

#endif
