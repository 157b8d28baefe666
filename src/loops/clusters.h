/* Ranks of closures cluster by cluster: in O(bodies) where loops are local.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * A row reads the joints between the bodies of its closure and the body where these meet. Closures
 * that share a joint belong to one cluster; rows of different clusters have no joint rate in
 * common, and are independent of each other. */
#ifndef MBSRI_LOOPS_CLUSTERS_H
#define MBSRI_LOOPS_CLUSTERS_H

#include "loops/ranks.h"

/* As mbsri_ranks_here, at the positions of the data, with squared distances below `dependent` taken
 * for zero. Memory from the model's allocator. *served is false where a cluster has more than 400
 * joint rates or rows: then nothing was found. */
int mbsri_ranks_by_clusters(const mbsr_model *m, mbsr_data *d, double dependent, bool *dropped,
                            mbsri_ranks *found, bool *served);

#endif
