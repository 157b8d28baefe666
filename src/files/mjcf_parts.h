/* What the parts of the reader of MJCF share.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_MJCF_PARTS_H
#define MBSRI_FILES_MJCF_PARTS_H

#include "files/looks.h"
#include "files/mesh.h"
#include "files/names.h"
#include "files/scene.h"

/* A class of defaults. */
typedef struct mbsri_class {
    const char *name; /* of the main one NULL */
    const struct mbsri_class *parent;
    struct mbsri_class *next; /* of all classes */
    mbsri_list elements;      /* const mbsri_element *: <default>, several perhaps */
} mbsri_class;

typedef enum mbsri_from_shapes {
    MBSRI_SHAPES_NEVER,
    MBSRI_SHAPES_ALWAYS,
    MBSRI_SHAPES_AUTO
} mbsri_from_shapes;

/* Where elements stand. */
typedef struct mbsri_mjcf_at {
    int body;                /* index; -1: the world */
    const mbsr_frame *frame; /* of <frame> elements around, in the body */
    const char *childclass;
} mbsri_mjcf_at;

/* What shapes give a body whose inertia they make. */
typedef struct mbsri_mjcf_solids {
    mbsr_inertia inertia;
    bool some;
    int heavy;        /* how many have mass */
    mbsr_frame frame; /* principal axes of the last of these, at its centre */
} mbsri_mjcf_solids;

/* A <mesh>; what is below `measured` holds once it is measured. */
typedef struct mbsri_mjcf_mesh {
    const mbsri_element *element;
    const char *file; /* NULL: none */
    mbsri_mesh_place place;
    mbsri_mesh_inertia kind;
    bool hull;              /* its convex hull is meant */
    int triangles;          /* of one without file, once it is drawn */
    const double *triangle; /* 9 numbers each; NULL: not drawn so far */
    bool measured;
    const char *wrong; /* why it cannot be; NULL: it is */
    int reason;        /* of load */
    mbsri_mesh_solid solid;
    mbsr_frame principal;              /* at the centre */
    double box[3], lower[3], upper[3]; /* half edges of the inertia box; around it */
} mbsri_mjcf_mesh;

/* What a model says of how it is read; each of those that are attached has its own. */
typedef struct mbsri_compiler {
    bool radian, autolimits;
    bool align;       /* free bodies that carry none have their frames along their principal axes */
    char sequence[4]; /* of Euler angles */
    mbsri_from_shapes from_shapes;
    double groups[2];   /* of shapes that count for inertias */
    const char *home;   /* folder of its file, seen from that of the file itself, with its slash */
    const char *folder; /* of meshes; NULL: none */
    bool strip;         /* names of files go without their folders */
    bool exact;         /* meshes count as the solids that they enclose, where they do not say */
    bool fit_around;    /* shapes are fitted to the box around a mesh */
} mbsri_compiler;

typedef struct mbsri_mjcf {
    mbsri_scene *s;
    const char *home; /* folder of the file, with its slash */
    const mbsri_element *root;
    mbsri_list compilers; /* mbsri_compiler, by number of the model */
    int copied;           /* elements so far */
    double total;         /* mass of all bodies, > 0: theirs are scaled to it */
    mbsri_class *classes; /* the last one made */
    bool free_controls;   /* controls are not clamped to their ranges */
    bool without_flex;    /* soft bodies were left out */
    double timestep;      /* of the file; no time constant is below two of them */
    bool unsafe;          /* time constants are as they are */
    const char *idle;     /* groups of actuators that are switched off, NULL: none */
    mbsri_list meshes;    /* mbsri_mjcf_mesh */
    mbsri_looks materials, textures;
    mbsri_names bodies, joints, sites, mesh_names;
} mbsri_mjcf;

/* An element with its class, from which it has what it does not say itself. */
typedef struct mbsri_mjcf_part {
    const mbsri_element *e;
    const char *kind; /* its name among the defaults; NULL: it has none */
    const mbsri_class *class;
    const char *const
        *alike; /* kinds whose defaults count, too, NULL behind the last; NULL: none */
} mbsri_mjcf_part;

/* The class of that name, NULL for the main one, made where there is none; NULL: no memory. */
mbsri_class *mbsri_mjcf_class_of(mbsri_mjcf *m, const char *name, const mbsri_class *parent);

/* A class that says nothing. */
#define MBSRI_PLAIN_CLASS "(plain)"

/* childclass: of the bodies around it; NULL: none. False: there is no such class. */
bool mbsri_mjcf_node(mbsri_mjcf *m, const mbsri_element *e, const char *kind,
                     const char *childclass, mbsri_mjcf_part *node);

/* NULL: nobody says so. */
const char *mbsri_mjcf_get(const mbsri_mjcf_part *node, const char *attribute);
bool mbsri_mjcf_numbers(mbsri_mjcf *m, const mbsri_mjcf_part *node, const char *attribute,
                        int least, int most, double *to, int *count);
bool mbsri_mjcf_number(mbsri_mjcf *m, const mbsri_mjcf_part *node, const char *attribute,
                       double *to);

/* The numbers k, a, b of a spring or damper with the force k x + a x^2 + b x^3, of a damper a x
 * |x|: a finding where they are more than the one, or for springs than k and `cubic` (NULL: not
 * taken). */
bool mbsri_mjcf_law(mbsri_mjcf *m, const mbsri_mjcf_part *node, const char *attribute,
                    double *linear, double *cubic);

/* Whether an attribute that is on, off or (`automatic`) missing or "auto". */
bool mbsri_mjcf_switch(const mbsri_mjcf_part *node, const char *attribute, bool automatic);

/* A range, and whether it holds: as its switch says, else where it is not zero. */
bool mbsri_mjcf_range(mbsri_mjcf *m, const mbsri_mjcf_part *node, const char *attribute,
                      const char *limited, double range[2], bool *holds);

/* pos and the orientation in all its spellings. */
bool mbsri_mjcf_frame(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_frame *frame);

/* z along a direction by the shortest turn. */
mbsr_frame mbsri_mjcf_along(const double x[3], const double z[3]);

/* A <geom>; sum: what it gives its body, NULL: nothing. */
bool mbsri_mjcf_add_shape(mbsri_mjcf *m, const mbsri_element *e, const mbsri_mjcf_at *at,
                          mbsri_mjcf_solids *sum);

/* Coefficients and solref of contacts where nobody says so; what condim leaves of coefficients. */
/* solref or solreflimit: time constant and ratio, or -stiffness and -damping; 0.02 s and 1 where it
 * is neither, as MuJoCo has it. */
bool mbsri_mjcf_reference(mbsri_mjcf *m, const mbsri_mjcf_part *node, const char *attribute,
                          double to[2]);

void mbsri_mjcf_plain_law(double friction[3], double settle[2]);
void mbsri_mjcf_rub(double kinds, double friction[3]);

/* Its name, "" without. */
const char *mbsri_mjcf_name(const mbsri_element *e);

/* ---- meshes ---- */

/* The name of a file without folder and ending; NULL: no memory. */
const char *mbsri_mjcf_stem(mbsri_arena *arena, const char *file);

bool mbsri_mjcf_add_mesh(mbsri_mjcf *m, const mbsri_element *e);

/* NULL: there is none of that name, which may be NULL. */
mbsri_mjcf_mesh *mbsri_mjcf_find_mesh(const mbsri_mjcf *m, const char *name);

/* What it encloses; NULL, or why that is not known. */
const char *mbsri_mjcf_measure(mbsri_mjcf *m, mbsri_mjcf_mesh *mesh);

/* Size and frame of a shape that has a mesh; *known false: it cannot be fitted, as a finding says.
 */
bool mbsri_mjcf_mesh_shape(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_shape *shape,
                           bool *known);

/* The file of an asset, with the folders of its model and of assets; NULL: it has none. */
const char *mbsri_mjcf_asset_path(const mbsri_mjcf *m, const mbsri_element *e);

/* Size and samples of a shape that is a height field; *known false: its file is not read, as a
 * finding says. */
bool mbsri_mjcf_field_shape(mbsri_mjcf *m, const mbsri_mjcf_part *node, mbsr_file_shape *shape,
                            bool *known);

/* ---- what a file means, before it is read ---- */

/* One more model, in a folder seen from that of the file, with the options that hold where it says
 * nothing. */
bool mbsri_mjcf_add_compiler(mbsri_mjcf *m, const char *home, int *number);
bool mbsri_mjcf_read_compiler(mbsri_mjcf *m, const mbsri_element *e);

/* The options that hold for an element. */
static inline mbsri_compiler *mbsri_mjcf_compiler(const mbsri_mjcf *m, const mbsri_element *e)
{
    return (mbsri_compiler *)m->compilers.items + e->model;
}

/* Writes composites out as bodies. */
bool mbsri_mjcf_composites(mbsri_mjcf *m, mbsri_element *root);

/* Writes replicas out. */
bool mbsri_mjcf_replicate(mbsri_mjcf *m, mbsri_element *root);

/* All of it, for the model of a tree and those that it attaches: what it includes, its compiler's
 * options, composites, attached models, replicas. */
bool mbsri_mjcf_expand(mbsri_mjcf *m, mbsri_element *root);

/* A finding for each section and attribute that nobody reads and that may matter. */
void mbsri_mjcf_find_words(mbsri_mjcf *m, const mbsri_element *root);

/* The parts of a file. */
bool mbsri_mjcf_world(mbsri_mjcf *m, const mbsri_element *world);
bool mbsri_mjcf_scale(mbsri_mjcf *m, const mbsri_element *root); /* masses, to their total */
bool mbsri_mjcf_contacts(mbsri_mjcf *m, const mbsri_element *list);
bool mbsri_mjcf_equalities(mbsri_mjcf *m, const mbsri_element *list);
bool mbsri_mjcf_tendons(mbsri_mjcf *m, const mbsri_element *list);
bool mbsri_mjcf_sensors(mbsri_mjcf *m, const mbsri_element *list);
bool mbsri_mjcf_actuators(mbsri_mjcf *m, const mbsri_element *list);

#endif
