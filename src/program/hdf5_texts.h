/* HDF5: attributes, names, and why something went wrong.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_HDF5_TEXTS_H
#define MBSRANK_HDF5_TEXTS_H

#include <hdf5.h>
#include <stdbool.h>

enum { HDF5_REASON = 160 };

/* The type of a text of any length in UTF-8; to be closed. */
static inline hid_t hdf5_text_type(void)
{
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

/* An attribute; false: it could not be written. */
bool hdf5_put(hid_t of, const char *name, hid_t stored, hid_t given, const void *value);
bool hdf5_put_text(hid_t of, const char *name, const char *text);

/* A text of an attribute, to be freed; NULL: there is none of that name. */
char *hdf5_get_text(hid_t of, const char *name);
bool hdf5_get_int(hid_t of, const char *name, int *value);

/* The name of set k in a file or group, where '/' would be a group and no name is there twice. */
enum { HDF5_LINK = 256 };
void hdf5_link(hid_t file, int k, const char *name, char to[HDF5_LINK]);

/* Why the last call has failed, in HDF5's own words. */
void hdf5_reason(char to[HDF5_REASON]);

#endif
