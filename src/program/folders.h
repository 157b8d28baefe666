/* Which files a model may name.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRANK_PROGRAM_FOLDERS_H
#define MBSRANK_PROGRAM_FOLDERS_H

#include "program/program.h"

/* Whether the file is there, is one and no device, and is in the folder of the model, in `meshes`
 * beside that folder, or in a folder of the options; else errno says what it is: EPERM where it is
 * elsewhere. */
bool may_read(const program_options *o, const char *path);

#endif
