/* Ranks of velocities: see span.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "span.h"

double test_span_beside(const test_span *p, double *row)
{
    double square = 0.0;
    for (int turn = 0; turn < 2; ++turn) {
        for (int l = 0; l < p->count; ++l) {
            double share = 0.0;
            for (int k = 0; k < p->n; ++k) share += row[k] * p->v[l][k];
            for (int k = 0; k < p->n; ++k) row[k] -= share * p->v[l][k];
        }
    }
    for (int k = 0; k < p->n; ++k) square += row[k] * row[k];
    return sqrt(square);
}

void test_span_widen(test_span *p, int count, double rows[][TEST_SPAN_MOST])
{
    for (;;) {
        double largest = 0.0;
        int most = -1;
        for (int r = 0; r < count; ++r) {
            const double length = test_span_beside(p, rows[r]);
            if (length > largest) largest = length, most = r;
        }
        p->doubtful = p->doubtful || (largest > 1e-12 && largest < p->clear);
        if (largest < 1e-9) return;
        for (int k = 0; k < p->n; ++k) p->v[p->count][k] = rows[most][k] / largest;
        p->length[p->count++] = largest;
    }
}
