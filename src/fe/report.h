/* What a reduction says of itself.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_FE_REPORT_H
#define MBSRI_FE_REPORT_H

#include "fe/basis.h"

/* B: mbsri_fe_make_data. */
int mbsri_fe_make_report(const mbsri_fe_statics *statics, const mbsri_fe_modes *modes,
                         const mbsri_fe_basis *basis, const mbsr_flex *flex, const double *B,
                         mbsr_fe_report **report);

#endif
