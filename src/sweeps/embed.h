/* Bodies and joints as the vectorised sweeps take them: everything in space, joints as chains of
 * steps. What lies in the plane moves at z = 0 and turns about z.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_EMBED_H
#define MBSRI_EMBED_H

#include "joints/chain.h"
#include "recursion/data.h"

/* Room for the parameters of a joint in the plane as a chain: frames A and B, three steps. */
enum { MBSRI_EMBED_PARAMS = MBSRI_AXES + 3 * MBSRI_AXIS_SIZE };

/* Whether body i of the model (of `bodies`) can be taken so: a stock joint, none of whose
 * coordinates is held, and a rigid inertia. A POINT has no axes that could turn with a PLANAR
 * predecessor, so that nothing may stand on it there. */
bool mbsri_embeds(const mbsr_model *m, int bodies, int i);

/* Whether its inertia is that of a rigid body. */
bool mbsri_embeds_inertia(const mbsri_body *b);

/* Its joint as a chain, whose parameters stand in `param` or in the model; its inertia. `length`:
 * typical of the tree. */
mbsri_joint mbsri_embedded_joint(const mbsri_body *b, double param[MBSRI_EMBED_PARAMS]);
mbsr_inertia mbsri_embedded_inertia(const mbsri_body *b, double length);

/* The angle of a PLANAR body less its predecessor's: a constant, and the coordinate of its joint
 * that counts, in the order of the sweeps; MBSRI_ANGLE_HELD: none, MBSRI_ANGLE_DRIVEN. */
enum { MBSRI_ANGLE_HELD = -1, MBSRI_ANGLE_DRIVEN = -2 };
void mbsri_embedded_angle(const mbsri_body *b, double *angle, int *coordinate);

/* The value of a driven angle at time t. */
double mbsri_driven_angle(const mbsri_joint *joint, double t);

/* Axes and origin of a body in this pose; not for GENERAL space. */
void mbsri_embedded_pose(mbsr_space space, const double *p, double R[9], double r[3]);

/* The root at the data's time: axes, place, velocity and acceleration (angular first). */
int mbsri_embedded_root(const mbsr_model *m, mbsr_data *d, double R[9], double r[3], double V[6],
                        double A[6]);

/* V, or anything else of three or two numbers of a body in the plane (linear, then angular), as six
 * of a body in space (angular first), and back. */
void mbsri_lift(int d, const double *x, double lifted[6]);
void mbsri_lower(int d, const double lifted[6], double *x);

#endif
