/* Models whose FMUs are tested.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_FMU_UNITS_H
#define TEST_FMU_UNITS_H

#include <mbsrank/contact.h>
#include <mbsrank/fmu.h>
#include <mbsrank/simulation.h>

/* What a model uses besides itself. */
typedef struct unit_model {
    mbsr_simulation s; /* not started */
    mbsr_flex *flex;
    mbsr_contacts *contacts;
    double held[4];
    mbsr_fmu_motion motion;
} unit_model;

/* An arm of two links under gravity: a spring and a stop at the first hinge, a damper at the second
 * and a motor there whose torque is an input; a massless link with a damper at its end. */
void make_arm(unit_model *m);

/* A four-bar, closed by a ball with a stiff row, one rod of which is driven by a table. */
void make_linkage(unit_model *m);

/* A beam with massless modes on a hinge, a force at its tip that is an input. */
void make_beam(unit_model *m);

/* A body that flies with a second on a ball joint, a spring between them; a wrench on the second
 * is an input. */
void make_flyer(unit_model *m);

/* Two pendulums on a bead without mass, side by side until a torque from a table parts them at 0.5
 * s: the bead has one massless direction, then none. */
void make_twins(unit_model *m);

/* A quarter of a vehicle: body and wheel with spring, damper and tyre; and its halves: the body
 * under a force that is an input, the wheel below a carrier whose motion is one. */
void make_vehicle(unit_model *m);
void make_body(unit_model *m);
void make_wheel(unit_model *m);

/* A ball that is pressed into the floor, turns and slides there, below a second one on a slider. */
void make_balls(unit_model *m);

/* Shapes of every kind that fall on a floor with a hill; a leg of one of them ends in a foot
 * without mass. Pairs have a law of their own, or never touch. */
void make_heap(unit_model *m);

/* A slider of a microgram, with friction, on a spring across that is 2 um long. */
void make_mite(unit_model *m);

void free_model(unit_model *m);

/* Finishes the model and exports it; writes the archive to `path`. 0, or a status. */
int write_unit(unit_model *m, const mbsr_fmu_opt *opt, const char *path);

/* Unpacks an archive whose files are stored into a folder that is there. 0, or -1. */
int unpack(const mbsr_fmu *fmu, const char *folder);

/* Makes damaged resources fit to be read: their checksum, and the token that belongs to them. */
void stamp(unsigned char *data, size_t size, char token[33]);

#endif
