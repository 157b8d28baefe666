/* Functions of the component contact that hand on whether they succeeded, by rooms: see faults.h.
 * SPDX-License-Identifier: BSD-3-Clause */

/* contact/ */
STATUS(mbsr_contact_report)
STATUS(mbsr_contacts_add)
STATUS(mbsr_contacts_add_file)
STATUS(mbsr_contacts_create)
STATUS(mbsr_contacts_definition)
STATUS(mbsr_contacts_exclude)
STATUS(mbsr_contacts_force)
STATUS(mbsr_contacts_join)
STATUS(mbsr_contacts_pair)
STATUS(mbsri_contact_fail)
STATUS(mbsri_core_make)
STATUS(mbsri_field_check)
STATUS(mbsri_field_feet)
STATUS(mbsri_field_samples)
STATUS(mbsri_near_find)
STATUS(mbsri_touches)
