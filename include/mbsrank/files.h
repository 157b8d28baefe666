/* Models from files: URDF, also by xacro, MJCF and SDF (component files).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A reader takes a text and makes a model that is not finished yet, so that the caller can add to
 * it, and what a model has no room for: names of joints, sites and actuators, start states, shapes
 * to draw. What the library cannot represent is listed, finding by finding, with what is done
 * instead; zero mass stays zero. docs/files.md says what maps to what. */
#ifndef MBSRANK_FILES_H
#define MBSRANK_FILES_H

#include <mbsrank/closure.h>
#include <mbsrank/dynamics.h>
#include <mbsrank/model.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Formats of files. */
typedef enum mbsr_file_format {
    MBSR_FILE_ANY = 0,  /* by the element that the file begins with */
    MBSR_FILE_URDF = 1, /* <robot> */
    MBSR_FILE_MJCF = 2, /* <mujoco> */
    MBSR_FILE_SDF = 3   /* <sdf> */
} mbsr_file_format;

/* Another file that is needed: an include, a mesh. Sets *text to its contents (*size bytes), which
 * stay valid until the reader returns. `path` is as in the file, folders of the file put before it.
 * Returns 0; where there is none, errno if that says why, whose text the error or finding has,
 * else 1. */
typedef int (*mbsr_file_load_fn)(void *user, const char *path, const char **text, size_t *size);

/* Where the meshes of package://NAME/... are, and what $(find NAME) of xacro is. */
typedef struct mbsr_file_package {
    const char *name, *folder;
} mbsr_file_package;

/* The value of $(arg NAME) in a file of xacro. */
typedef struct mbsr_xacro_argument {
    const char *name, *value;
} mbsr_xacro_argument;

/* How a file of xacro is expanded. */
typedef struct mbsr_xacro_opt {
    int arguments;                       /* others have their defaults in the file */
    const mbsr_xacro_argument *argument; /* may be NULL for none */
    int outside; /* 1: includes from any folder; 0 (default): from the model's folder and those
                    below, and from packages, by the paths alone */
} mbsr_xacro_opt;

typedef struct mbsr_file_opt {
    int cookie; /* set by mbsr_default_file_opt */
    mbsr_file_format format;
    int strict;        /* 1: findings make the reader refuse the file; default 0 */
    int floating;      /* URDF, 1: the root link is free; 0 (default): it is fixed */
    double gravity[3]; /* URDF and models of SDF have none: m/s^2, default (0, 0, -9.81) */
    int closures;  /* 1 (default): mimicking joints and equalities become closures; 0: left out */
    int actuators; /* 1 (default): actuators become force elements; 0: left out */
    int passive;   /* 1 (default): springs and dampers of joints and tendons; 0: left out */
    int limits; /* 1: limits of joints become stops, stiff by the masses that they carry; default 0
                 */
    int friction; /* 1: dry friction of joints, smooth below a rate by their ranges; default 0 */
    double stop_stiffness; /* > 0: limits become stops of this one, N/m or N m/rad; default 0 */
    double stop_damping;   /* N s/m or N m s/rad */
    double slip;           /* > 0: dry friction, smooth below this rate, m/s or rad/s; default 0 */
    int hull_corners; /* > 0: meshes for contact are loaded and get convex hulls of at most so many
                         corners, 4 or more; default 0 */
    mbsr_file_load_fn load; /* NULL: files with includes are refused, meshes are findings */
    void *user;             /* for load */
    int packages; /* meshes of package://NAME/PATH and model://NAME/PATH get the path FOLDER/PATH */
    const mbsr_file_package *package; /* may be NULL for none; other packages stay as in the file */
    mbsr_xacro_opt xacro;
    mbsr_model_def model; /* of the model made: root, tolerance, allocator */
} mbsr_file_opt;

MBSR_API mbsr_file_opt mbsr_default_file_opt(void);

/* Something in the file that the model does not have, and what is done instead. */
typedef struct mbsr_finding {
    const char *file;
    int line;
    const char *element; /* such as "joint 'elbow'" */
    const char *text;
} mbsr_finding;

/* Kinds of joints of a file. */
typedef enum mbsr_file_joint_kind {
    MBSR_FILE_FIXED,
    MBSR_FILE_HINGE,
    MBSR_FILE_SLIDE,
    MBSR_FILE_BALL,
    MBSR_FILE_FREE
} mbsr_file_joint_kind;

/* A joint of the file: one or more coordinates of a body's joint. Coordinates of hinges and slides
 * are the file's own, `ref` included. */
typedef struct mbsr_file_joint {
    const char *name; /* "" without */
    mbsr_file_joint_kind kind;
    int body;        /* id of the body whose joint it is part of */
    int coordinate;  /* its first among the rates of that joint */
    int position;    /* its first among the coordinates of that joint */
    int limited;     /* whether it has a range */
    double range[2]; /* rad or m */
    double ref;      /* where the body stands as drawn in the file */
    double friction; /* dry friction, N m or N */
    mbsr_frame from; /* of a free joint: where its coordinates count from, in the world, or in the
                        moving body below; else the identity */
    double stop_stiffness, stop_damping; /* of its stops in the model; 0: there are none */
    double slip; /* below this rate its dry friction is smooth; 0: it is not in the model */
} mbsr_file_joint;

/* A point with axes on a body. */
typedef struct mbsr_file_site {
    const char *name;
    int body; /* id, or MBSR_GROUND */
    mbsr_frame frame;
} mbsr_file_site;

/* A sum of factor times coordinate of joints with one axis, given by their numbers. */
typedef struct mbsr_file_sum {
    int count;
    const int *joint;
    const double *factor;
} mbsr_file_sum;

/* An actuator: at control w it exerts on its joint coordinate, or on all of a fixed tendon,
 *
 *   gear F,   F = gain w + bias[0] + bias[1] l + bias[2] l',     l = gear q
 *
 * with w and F no further than their ranges where these are limited; on a site F along its gear
 * there, with l = 0. w stands in `control` of mbsr_file and may be changed by the caller, between
 * calls. */
typedef struct mbsr_file_actuator {
    const char *name;
    int force; /* id of the force element, or MBSR_NONE */
    double gear, gain, bias[3];
    int limited;
    double range[2]; /* of w */
    int force_limited;
    double force_range[2]; /* of F */
    mbsr_file_sum sum;     /* l = gear times this; of one on a site empty */
} mbsr_file_actuator;

/* What a sensor of a file measures. */
typedef enum mbsr_file_sensor_kind {
    MBSR_SENSOR_POSITION,  /* q of a joint with one axis, or a length of joints or sites */
    MBSR_SENSOR_RATE,      /* its rate */
    MBSR_SENSOR_BALL,      /* the quaternion of a ball */
    MBSR_SENSOR_BALL_RATE, /* its angular velocity along the axes of its body, rad/s */
    MBSR_SENSOR_POINT,     /* where its frame is, m */
    MBSR_SENSOR_AXIS_X,    /* the x axis of its frame; y and z follow */
    MBSR_SENSOR_AXIS_Y,
    MBSR_SENSOR_AXIS_Z,
    MBSR_SENSOR_TURN,            /* how its frame is turned: a quaternion */
    MBSR_SENSOR_VELOCITY,        /* of the origin of its frame, m/s */
    MBSR_SENSOR_SPIN,            /* angular velocity, rad/s */
    MBSR_SENSOR_ACCELERATION,    /* of that origin, less gravity, m/s^2 */
    MBSR_SENSOR_SPIN_RATE,       /* angular acceleration, rad/s^2 */
    MBSR_SENSOR_FORCE,           /* what the joint of its body exerts on it, N */
    MBSR_SENSOR_TORQUE,          /* and about the origin of its frame, N m */
    MBSR_SENSOR_DRIVE,           /* F of an actuator */
    MBSR_SENSOR_JOINT_DRIVE,     /* what all actuators exert on a joint, N or N m */
    MBSR_SENSOR_CENTRE,          /* of mass of its body with all on it, m */
    MBSR_SENSOR_CENTRE_VELOCITY, /* of that, m/s */
    MBSR_SENSOR_MOMENTUM,        /* their angular momentum about it, kg m^2/s */
    MBSR_SENSOR_TIME,
    MBSR_SENSOR_POTENTIAL, /* energy, J */
    MBSR_SENSOR_KINETIC
} mbsr_file_sensor_kind;

/* A sensor of the file that a state gives. Its frame is seen from the world along the world's axes,
 * with `own_axes` along its own, or as seen from a moving frame (`relative`). */
typedef struct mbsr_file_sensor {
    const char *name;
    mbsr_file_sensor_kind kind;
    int size;         /* how many numbers it has: 1, 3 or 4 */
    int joint;        /* number of its joint, -1: none */
    int actuator;     /* of its actuator, -1: none */
    int body;         /* id, or MBSR_GROUND */
    mbsr_frame frame; /* in the body */
    int own_axes;
    int relative;
    int from_body; /* id, or MBSR_GROUND */
    mbsr_frame from;
    mbsr_file_sum sum; /* of a length */
    int sites;         /* of a length: of the path along that many */
    const int *site;   /* their numbers */
    double
        cutoff; /* > 0: numbers are kept within -cutoff and cutoff, but for quaternions and axes */
    double gravity[3]; /* that the file has, m/s^2 */
} mbsr_file_sensor;

/* A named state: q and u of the model, w of the actuators. */
typedef struct mbsr_file_key {
    const char *name;
    double time;
    const double *q, *u, *control;
} mbsr_file_key;

/* Something to draw or to touch with; no part of the model, but mbsr_contacts_add_file (contact.h)
 * makes it one. */
typedef struct mbsr_file_shape {
    const char *name;
    int body; /* id, or MBSR_GROUND */
    mbsr_shape_kind kind;
    mbsr_frame frame; /* in the body */
    double size[3];   /* m */
    double colour[4]; /* red, green, blue, opacity, 0 .. 1 */
    int coloured;     /* 0: the file says no colour, and `colour` is a grey */
    int visual;       /* 0: not for showing, but for contact */
    int contact;      /* 0: for showing alone */
    /* What it touches, as in contact.h: contype and conaffinity; else 1 and 1. */
    unsigned groups, mask;
    /* Coefficients of sliding, of turning about the normal (m), of rolling (m); what the file
     * leaves out is 1, 0, 0, and what MJCF has counts by condim. */
    double friction[3];
    double settle[2];       /* solref: s and the ratio of damping, or negative: -stiffness and
                               -damping of 1 kg; else 0.02 and 1 */
    double margin;          /* of MJCF, m: forces begin that far before a surface */
    const char *mesh;       /* path, of a mesh; else NULL */
    int triangles;          /* of a mesh that the file gives by numbers: so many, with mesh NULL */
    const double *triangle; /* 9 numbers each: three corners */
    /* The convex hull of a mesh for contact, scaled, in the frame of the shape; 0: there is none.
     */
    int hull_corners, hull_sides;
    const double *hull_corner; /* 3 each, m */
    const int *hull_side;      /* 3 corners each, counter-clockwise from outside */
    /* Of a height field, as in contact.h; the triangles are those of its cells, for drawings. */
    int rows, columns;
    const double *height;
} mbsr_file_shape;

/* Two shapes that touch by numbers of their own, as <pair> of MJCF has them; see mbsr_file_shape.
 */
typedef struct mbsr_file_pair {
    int shape[2]; /* their numbers */
    double friction[3];
    double settle[2];
    double margin;
} mbsr_file_pair;

/* What was read. Arrays belong to it; ids are those of the model. */
typedef struct mbsr_file {
    mbsr_model *model; /* not finished; the caller's own with mbsr_file_take_model, else destroyed
                          with the file */
    mbsr_file_format format;
    const char *name; /* of the model, "" without */
    int bodies;
    const char *const *body_name; /* by id, as in the file; a body without one is "" */
    int joints;
    const mbsr_file_joint *joint; /* in the order of their coordinates */
    int nq, nu;                   /* coordinates of the model as read */
    const double *q0;             /* nq: as drawn in the file */
    int sites;
    const mbsr_file_site *site;
    int actuators;
    const mbsr_file_actuator *actuator;
    double *control; /* actuators: w, 0 at first */
    int keys;
    const mbsr_file_key *key;
    int sensors;
    const mbsr_file_sensor *sensor;
    int shapes;
    const mbsr_file_shape *shape;
    int excluded; /* bodies whose shapes never touch, by <exclude> of MJCF: two ids each */
    const int *exclude;
    int pairs;
    const mbsr_file_pair *pair;
    int findings;
    const mbsr_finding *finding;
} mbsr_file;

/* Reads a text of `size` bytes (no NUL is needed); `name` is that of the file, for messages and as
 * the folder of other files (NULL: none). opt == NULL: mbsr_default_file_opt(). On failure *file is
 * NULL and the text of *error (may be NULL) names file, line and element. Numbers do not depend on
 * the locale. A file whose root declares the prefix xacro, or whose name ends in .xacro, is
 * expanded first: lines are those of the file, or of an included one, that elements come from.
 * Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE (of opt), MBSR_ERR_FILE (the
 * text is not one that can be read, or with `strict` has findings), MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_file_read(const char *text, size_t size, const char *name,
                            const mbsr_file_opt *opt, mbsr_file **file, mbsr_error *error);

/* Frees what was read, and the model unless it was taken; NULL is allowed. Force elements of
 * actuators and tendons use the file: it must outlive all evaluations of the model. */
MBSR_API void mbsr_file_destroy(mbsr_file *file);

/* The model, which is the caller's from now on (mbsr_model_destroy); NULL if it was taken before.
 */
MBSR_API mbsr_model *mbsr_file_take_model(mbsr_file *file);

/* The number of the joint, site, actuator, sensor, key of that name; -1: there is none. */
MBSR_API int mbsr_file_find_joint(const mbsr_file *file, const char *name);
MBSR_API int mbsr_file_find_site(const mbsr_file *file, const char *name);
MBSR_API int mbsr_file_find_actuator(const mbsr_file *file, const char *name);
MBSR_API int mbsr_file_find_sensor(const mbsr_file *file, const char *name);
MBSR_API int mbsr_file_find_key(const mbsr_file *file, const char *name);

/* The numbers of a sensor at time t and q (nq), u (nu), at which the data are: at
 * mbsr_stage_accelerations for accelerations, forces and torques, else at mbsr_stage_velocities.
 * `model` has the bodies and coordinates of the file. Joint reactions hold what springs, drives and
 * loops exert there. MBSR_ERR_NULL, MBSR_ERR_ID (there is no such sensor), MBSR_NOT_FINITE,
 * statuses of what is asked of the data. */
MBSR_API int mbsr_file_sense(const mbsr_file *file, int sensor, const mbsr_model *model,
                             mbsr_data *data, double t, const double *q, const double *u,
                             double value[4]);

/* Between the coordinates of MuJoCo, joint by joint in the order of `joint`, and those of the model
 * as read (nq and nu of either): a free joint there has q = (x, y, z, quaternion) in the world, v =
 * (velocity of the origin along the world's axes, angular velocity along the body's), a ball the
 * angular velocity along the body's axes; on a body that moves that body stands for the world.
 * `inverse` = 0: from qpos, qvel to q, u; 1: the other way. qvel and u may be NULL. No output may
 * overlap an input. MBSR_ERR_NULL; MBSR_NOT_FINITE; MBSR_ERR_VALUE: a quaternion of length zero. */
MBSR_API int mbsr_file_mujoco_state(const mbsr_file *file, int inverse, const double *position,
                                    const double *velocity, double *q, double *u);

/* ---- elements that files need and force.h and closure.h do not have ----
 *
 * Their tables by number, 0, 1, ..., for whoever takes a model apart (mbsr_force_definition); NULL
 * behind the last. The `user` of an element that is an actuator points to its control, and is NULL
 * for others. */
MBSR_API const mbsr_force_table *mbsr_file_force_table(int k);
MBSR_API const mbsr_closure_table *mbsr_file_closure_table(int k);

/* ---- meshes ---- */

/* A triangle: three corners of three coordinates. */
typedef void (*mbsr_triangle_fn)(void *user, const double corner[9]);

/* The triangles of a mesh (`size` bytes) in the order of the file, with its coordinates, not
 * scaled. What it is is told by its contents: STL with numbers or as bytes, else OBJ, whose faces
 * may have more corners and become fans, and whose points, if it has no faces, stand for their
 * convex hull; and MSH of MuJoCo by the ending .msh of `name` (may be NULL). Coordinates are
 * rounded to 32 bits. On failure no triangle is given, and the text of *error (may be NULL) says of
 * mesh `name` why. Status: MBSR_OK, MBSR_ERR_NULL, MBSR_ERR_FILE (it cannot be read, has no
 * triangles, or a number that is not finite), MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_mesh_triangles(const char *text, size_t size, const char *name,
                                 mbsr_triangle_fn take, void *user, mbsr_error *error);

/* ---- writing ---- */

typedef struct mbsr_write_opt {
    int cookie; /* set by mbsr_default_write_opt */
    int strict; /* 1: findings make the writer refuse; default 0 */
    const char
        *mesh_folder; /* where names of meshes begin; NULL (default): where the text will be */
    /* Whether there is a mesh of that name; NULL (default): there is. Those that are not are left
     * out. */
    int (*has_mesh)(void *user, const char *path);
    void *user;
    mbsr_allocator
        allocator; /* of what is written; default: malloc and free (both functions NULL) */
} mbsr_write_opt;

MBSR_API mbsr_write_opt mbsr_default_write_opt(void);

/* A model as text. */
typedef struct mbsr_written {
    const char *text; /* `size` bytes and a NUL */
    size_t size;
    int findings; /* what MJCF cannot say, or MuJoCo does not take, such as bodies without mass;
                     with file "" and line 0 */
    const mbsr_finding *finding;
} mbsr_written;

/* A finished model as a text of MJCF. `file` (NULL: none): what it was read from, of any format,
 * for names, refs, limits, sites, actuators, keys and shapes; the model must have its bodies and
 * coordinates. Bodies are written depth first, in the order of ids; where coordinates stand in
 * another order then, a finding says so. Read again the text gives a model with the same
 * accelerations, up to rounding, but for what is in findings: mostly left out. Bodies without mass
 * are written without; MuJoCo refuses such files. docs/files.md has the table. On failure *written
 * is NULL and the text of *error (may be NULL) names the body. Status: MBSR_OK, MBSR_ERR_NULL,
 * MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE (of opt), MBSR_ERR_UNFINISHED, MBSR_ERR_MISMATCH (`file` is
 * another one), MBSR_ERR_SPACE (a joint or a body that MJCF does not have, or too many
 * predecessors), MBSR_ERR_FILE (with `strict` there are findings), MBSR_ERR_NO_MEMORY. */
MBSR_API int mbsr_file_write_mjcf(const mbsr_model *model, const mbsr_file *file,
                                  const mbsr_write_opt *opt, mbsr_written **written,
                                  mbsr_error *error);

/* The text of a file of xacro without xacro: elements with their attributes, without comments and
 * what is between elements. Arguments and statuses are those of mbsr_file_read; of the options
 * those count that are about packages, other files and xacro, and `strict`, which refuses on
 * findings of the expansion. On failure *written is NULL. */
MBSR_API int mbsr_file_expand_xacro(const char *text, size_t size, const char *name,
                                    const mbsr_file_opt *opt, mbsr_written **written,
                                    mbsr_error *error);

/* NULL is allowed. */
MBSR_API void mbsr_written_destroy(mbsr_written *written);

#ifdef __cplusplus
}
#endif

#endif
