/* Random trees of joints of all kinds: ball, universal, free and planar joints beside hinges,
 * slides and screws, armature, masses down to 1e-10 of others, points, rods and discs on, beside or
 * far from axes; or of hinges, slides and free bodies in the plane. Flexible beams and closures may
 * be added to those in space.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_JOINT_SCENE_H
#define TEST_JOINT_SCENE_H

#include "span.h"
#include "units.h"

enum {
    BODIES = 7,
    RATES = TEST_SPAN_MOST, /* 6 BODIES */
    POINTS = 3,
    ELEMENTS = 10,
    BEAMS = 2,
    MODES = 3, /* of a beam */
    CLOSURES = 2,
    COORDINATES = 7 * BODIES + BEAMS * MODES
};

typedef enum kind { HINGE, SLIDE, SCREW, CYLINDER, UNIVERSAL, IN_PLANE, BALL, FREE, JOINTS } kind;

/* Points that stand for the mass: one, the two ends of a rod, three of a disc. */
typedef struct body {
    kind joint;
    int parent, points;
    double axis[3], other[3], at[3], mass, point[POINTS][3], armature;
} body;

typedef enum law { ON_RATE, ON_ROTATION, BETWEEN, LAWS } law;

typedef struct element {
    law law;
    int a, b, coordinate;
    double spring, damper, point_a[3], point_b[3];
} element;

/* A beam along x of its parent, mounted there by its end, with shapes e_dir (x / length)^power and
 * a point mass at the other end, where a marker is. Its ids are those of scene_beam_of. */
typedef struct beam {
    int parent, modes, dir[MODES];
    bool massless[MODES];
    double length, density, tip, power[MODES], spring[MODES], damper[MODES];
} beam;

/* Along `rows` of the axes x, y, z, from the first on, a point of a stays where one of b (-1: the
 * ground) is. */
typedef struct closing {
    int a, b, rows;
    double point_a[3], point_b[3];
} closing;

typedef struct scene {
    test_rng rng;
    int bodies, elements, beams, closures;
    beam beam[BEAMS];
    closing closing[CLOSURES];
    body body[BODIES];
    element element[ELEMENTS];
    double q[7 * BODIES]; /* SI; beams are straight */
    bool flat;            /* joints, points and motions in the plane z = 0 */
} scene;

int scene_rates_of(kind joint);

/* Ids of the flexible body of a beam and, the next one, of the marker at its end, on which elements
 * act and closures hold as on other bodies. */
static inline int scene_beam_of(const scene *s, int number)
{
    return s->bodies + 2 * number;
}

/* flat: in the plane. */
scene scene_draw(int seed, bool flat);

/* Adds beams with an element at each, as far as there is room; closures, closed where the scene
 * stands. */
void scene_add_beams(scene *s);
void scene_add_closures(scene *s);

/* The library's model. */
typedef struct built {
    mbsr_model *model;
    mbsr_data *data;
    int nq, nu;
    int body_of[RATES];
    double unit[RATES], q[COORDINATES], u[RATES]; /* of the rates: length or 1 */
    mbsr_flex *flex[BEAMS];
} built;

/* rest: lengths of the springs between points, in metres; NULL: no elements yet. flat: of bodies in
 * the plane. */
built scene_build(const scene *s, const units *in, const double *rest, bool flat);
void scene_destroy(built *l);

/* Of body i, in the model. */
int scene_first_rate(const built *l, int i);

/* A point of body i (-1: the ground) in the world; and what a spring between points measures. */
void scene_find_point(const built *l, int i, const double in_body[3], double x[3]);

/* row (nu) += sign (along . velocity of a point of body i). */
void scene_add_velocity(const built *l, int i, const double in_body[3], const double along[3],
                        double sign, double *row);
double scene_distance(const built *l, const element *e, double length, double along[3]);

/* What must be said of it, by ranks of velocities, told by the Jacobians of the bodies in space:
 * those of closures, of points with mass and of rates with armature, then of what dampers see, then
 * of what springs see. */
typedef struct verdict {
    int dynamic, damped, elastic, undetermined, held;
    unsigned undetermined_in;
    bool settled;
    test_span massive; /* with the rows of closures */
    double seen[ELEMENTS][RATES], rest[ELEMENTS];
} verdict;

verdict scene_judge(const scene *s);

/* Whether the index report, the start or forward dynamics say something else of the scene; prints
 * what. */
bool scene_is_wrong(int seed, const scene *s, const verdict *v, const units *in);

#endif
