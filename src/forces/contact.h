/* What a contact does at a state.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_CONTACT_H
#define MBSRI_CONTACT_H

#include <mbsrank/dynamics.h>

#include <stdbool.h>

bool mbsri_is_contact(const mbsr_force_def *def);

/* Fills *state, which arrives as zero. */
void mbsri_contact_at(const mbsr_force_args *args, mbsr_contact_state *state);

#endif
