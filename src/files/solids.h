/* Inertias as files give them.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FILES_SOLIDS_H
#define MBSRI_FILES_SOLIDS_H

#include "files/scene.h"

/* Mass and tensor (xx, yy, zz, xy, xz, yz) about the centre of mass, which is the origin of
 * `frame`, along its axes. Tensors that no distribution of mass has stay what they are, negative
 * moments among them. */
mbsr_inertia mbsri_solid(mbsri_arena *arena, double mass, const mbsr_frame *frame,
                         const double tensor[6]);

/* The same as a file states it for element e: a finding where no body has such a tensor, refused
 * where the mass is negative. */
bool mbsri_stated_solid(mbsri_scene *s, const mbsri_element *e, double mass,
                        const mbsr_frame *frame, const double tensor[6], mbsr_inertia *inertia);

/* Mass, centre and tensor about it along the body's axes of a rigid body, of such a tensor too.
 * False: it is another inertia; one that is not given counts as zero. */
bool mbsri_solid_of(const mbsr_inertia *inertia, double *mass, double centre[3], double tensor[6]);

/* The eigenvalues of such a tensor, descending, and their directions as columns of a rotation, the
 * one that MuJoCo finds. Products of inertia are zero where they are at most `small` times the
 * largest moment: MuJoCo's number for meshes, else that of rounding. The result is the largest
 * product that stays, by that moment. */
#define MBSRI_NO_PRODUCT 3e-17
#define MBSRI_NO_PRODUCT_OF_MESHES 1e-7
double mbsri_principal(const double tensor[6], double small, double moments[3], double axes[9]);

/* A finding where MuJoCo drops products of inertia, by the largest moment, that are larger than
 * MBSRI_DROPPED. */
#define MBSRI_DROPPED 1e-9
void mbsri_find_products(mbsri_scene *s, const mbsri_element *e, double dropped);

/* The same eigenvalues, ascending. */
void mbsri_moments(const double tensor[6], double moments[3]);

/* Volume in m^3 and tensor for density 1 of a shape, about its centre; false: it has none. */
bool mbsri_shape_solid(mbsr_shape_kind kind, const double size[3], double *volume,
                       double tensor[6]);

#endif
