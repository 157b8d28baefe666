/* Functions of the component study that hand on whether they succeeded, and what journals ask of
 * the system: see faults.h.
 * SPDX-License-Identifier: BSD-3-Clause */

/* study/ */
STATUS(mbsr_fit_create)
STATUS(mbsr_journal_add)
CLOSES(mbsr_journal_close, -41)
STATUS(mbsr_journal_get)
STATUS(mbsr_journal_open)
STATUS(mbsr_study_read)
STATUS(mbsr_study_values)
SUCCESS(mbsri_study_prepare)

/* system/ */
SYSTEM(fsync, -1)
SYSTEM(ftruncate, -1)
SYSTEM(ftruncate64, -1)
SYSTEM(lseek, -1)
SYSTEM(lseek64, -1)
SYSTEM(mkdir, -1)
SYSTEM(open, -1)
SYSTEM(open64, -1)
SYSTEM(opendir, 0)
SYSTEM(pread, -1)
SYSTEM(pread64, -1)
SYSTEM(readdir, 0)
SYSTEM(readdir64, 0)
SYSTEM(write, -1)
