/* Functions of the component linear that hand on whether they succeeded, by rooms: see faults.h.
 * SPDX-License-Identifier: BSD-3-Clause */

/* LAPACK/ */
INFO(dgecon_, i)
INFO(dgees_, o)
INFO(dgeev_, n)
INFO(dgesvd_, n)
INFO(dgetrf_, f)
INFO(dtrevc_, n)
INFO(dtrexc_, j)
INFO(zgesv_, h)

/* linear/ */
STATUS(mbsri_coordinates_find)
STATUS(mbsri_krylov_begin)
STATUS(mbsri_krylov_grow)
SUCCESS(mbsri_krylov_sort)
SUCCESS(mbsri_krylov_vectors)
STATUS(mbsri_motion_enter)
STATUS(mbsri_pencil_assemble)
STATUS(mbsri_pencil_start)
STATUS(mbsri_sample_force)
STATUS(mbsri_signals_check)
STATUS(mbsri_signals_enter)
