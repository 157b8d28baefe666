/* Functions of the component fe that hand on whether they succeeded, by rooms: see faults.h.
 * SPDX-License-Identifier: BSD-3-Clause */

/* CHOLMOD/ */
SUCCESS(cholmod_allocate_sparse)
SUCCESS(cholmod_analyze)
SUCCESS(cholmod_factorize)
SUCCESS(cholmod_solve)

/* fe/ */
SUCCESS(mbsri_factor_solve)
STATUS(mbsri_fe_body_make)
SUCCESS(mbsri_fe_deflect)
STATUS(mbsri_fe_eigen)
STATUS(mbsri_fe_find_modes)
STATUS(mbsri_fe_gram)
STATUS(mbsri_fe_make_basis)
STATUS(mbsri_fe_make_data)
STATUS(mbsri_fe_make_report)
STATUS(mbsri_fe_statics_make)
STATUS(mbsri_refuse_line)
STATUS(mbsri_sid_fit)
STATUS(mbsri_sid_parse)
STATUS(mbsri_sparse_build)
