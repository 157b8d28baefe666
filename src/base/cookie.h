/* What the default functions write into a definition; a definition without it was not initialised.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MBSRI_COOKIE_H
#define MBSRI_COOKIE_H

enum { MBSRI_COOKIE = 0x6d627372 };

#endif
