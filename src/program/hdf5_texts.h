/* HDF5: texts, and why something went wrong.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_HDF5_TEXTS_H
#define MBSRANK_HDF5_TEXTS_H

#include <hdf5.h>

enum { HDF5_REASON = 160 };

/* The type of a text of any length in UTF-8; to be closed. */
static inline hid_t hdf5_text_type(void)
{
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

/* Why the last call has failed, in HDF5's own words. */
void hdf5_reason(char to[HDF5_REASON]);

#endif
