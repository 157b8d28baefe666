/* What mechanisms are made of.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef PARTS_H
#define PARTS_H

#include "mechanisms.h"

mbsr_planar_frame part_along(double x);

int part_body(mbsr_model *m, const char *name, int parent, mbsr_joint joint, mbsr_inertia inertia);
void part_force(mbsr_model *m, mbsr_force_def def);

/* Weight along -y. */
void part_fall(mbsr_model *m);

/* A uniform rod along x from its origin, in the plane; in space, of 2 cm. */
mbsr_inertia part_rod(double mass, double length);
mbsr_inertia part_bar(double mass, double length);

/* The first rows of a closure with the stiffness and damping of the ties. */
void part_close(mbsr_model *m, const mechanism_ties *ties, mbsr_closure_def def, int rows);

/* A stiff element: a force, or as it is a stiff closure; nothing where the ties are rigid. */
void part_tie(mbsr_model *m, const mechanism_ties *ties, mbsr_force_def def);

/* A pin in the plane, at x = at_a of a and at_b of b. */
void part_pin(mbsr_model *m, const mechanism_ties *ties, int a, double at_a, int b, double at_b);

#endif
