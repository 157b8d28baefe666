/* Flexible bodies in SID_FEM files, Wallrapp's Standard Input Data, read and written (component
 * fe).
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A SID file holds Taylor expansions in the modal coordinates: of mass moments (mdCM, J, Ct, Cr,
 * Me), of gyroscopic terms (Gr, Ge, Oe), stiffness and damping (Ke, De), and of the pose of nodes.
 * They overdetermine the integrals of mbsr_flex_def, and files of several programs contradict
 * themselves: no distribution of mass has these numbers, and M(s) has directions of negative mass.
 * docs/flexible.md says what is taken from where. */
#ifndef MBSRANK_SID_H
#define MBSRANK_SID_H

#include <mbsrank/flex.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What may be changed where the numbers of a file are those of no body. */
typedef enum mbsr_sid_change {
    MBSR_SID_NOTHING = 0,      /* default: such files are refused */
    MBSR_SID_SECOND_ORDER = 1, /* what M(0) knows nothing of: J.m1 and all of P */
    MBSR_SID_COUPLING = 2 /* also Ct and Cr, by which modes and rigid motions are coupled. Mass,
                             centre, tensor of inertia, modal masses and stiffness always stay as in
                             the file. */
} mbsr_sid_change;

typedef struct mbsr_sid_opt {
    int cookie; /* set by mbsr_default_sid_opt */
    mbsr_sid_change change;
    mbsr_allocator allocator; /* default: malloc and free */
} mbsr_sid_opt;

MBSR_API mbsr_sid_opt mbsr_default_sid_opt(void);

/* What was read, and what it is worth. Sizes of P are beside the modal masses, sqrt(Mf_aa Mf_bb).
 */
typedef struct mbsr_sid_report {
    int modes, markers;
    const int *node;         /* ids of the nodes, by marker */
    const char *const *name; /* of the modes, ielastq */
    double definite;         /* lowest eigenvalue of M(0) scaled to unit diagonal, as in the file */
    double trace[2];  /* least and largest tr P_aa / Mf_aa as in the file, which should be 1, less
                        inertia of rotations */
    double asymmetry; /* of Oe.m1, which should be symmetric in its modes */
    double mdCM;      /* largest difference of mdCM.m1 and Ct, beside mass^1/2 Mf_aa^1/2 */
    int no_second_order; /* Oe.m1 is not in the file: P_ab = Mf_ab / 3 1 + its skew part was assumed
                          */
    int stiffening;      /* terms of geometric stiffening are in the file, and were left out */
    double keep_coupling; /* parts that modes keep at least, 0 .. 1, 1: nothing was changed: of Ct
                             and Cr, ... */
    double keep_strain;   /* ... of what else J.m1 says, ... */
    double keep_rest;     /* ... and of what else Oe.m1 and Cr.m1 say */
    double changed_P;     /* largest change of P */
    const char *text;     /* all this in sentences */
} mbsr_sid_report;

/* Reads the text of a file (size bytes; name for error texts, NULL: "SID"). Markers are the nodes
 * in their order.
 *
 * On success *flex is released by mbsr_flex_destroy, *report (NULL: not wanted) by
 * mbsr_sid_report_destroy. On failure both are NULL and the reason, with the line, in *error (may
 * be NULL): MBSR_ERR_NULL, MBSR_ERR_NO_DEFAULT, MBSR_ERR_VALUE (of opt; data that are refused, with
 * the eigenvalue and the option that would change them), MBSR_ERR_NO_MEMORY, MBSR_ERR_NUMERICS,
 * MBSR_ERR_FILE (what cannot be read; ksigma that is not zero). opt NULL: defaults. */
MBSR_API int mbsr_sid_read(const char *text, size_t size, const char *name, const mbsr_sid_opt *opt,
                           mbsr_flex **flex, mbsr_sid_report **report, mbsr_error *error);
MBSR_API void mbsr_sid_report_destroy(mbsr_sid_report *report); /* NULL is allowed */

/* A text with NUL behind it. */
typedef struct mbsr_sid_text {
    const char *text;
    size_t size; /* bytes, without the NUL */
} mbsr_sid_text;

/* Writes modal data without geometric stiffening as a SID file: nodes 1, 2, ... are the markers.
 * Read again it is the same to rounding. name: of the body; NULL: none. *text is released by
 * mbsr_sid_text_destroy, and NULL on failure: MBSR_ERR_NULL, MBSR_ERR_VALUE (allocator; dependent
 * shapes), MBSR_ERR_NO_MEMORY. allocator NULL: malloc and free. */
MBSR_API int mbsr_sid_write(const mbsr_flex *flex, const char *name,
                            const mbsr_allocator *allocator, mbsr_sid_text **text,
                            mbsr_error *error);
MBSR_API void mbsr_sid_text_destroy(mbsr_sid_text *text); /* NULL is allowed */

#ifdef __cplusplus
}
#endif

#endif
