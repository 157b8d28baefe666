/* Closures whose forces turn with one of their two bodies: see closure_turn.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "newton/slopes/closure_turn.h"

#include "algebra/dense.h"
#include "recursion/closures.h"

#include <math.h>

enum { ROWS = MBSR_CLOSURE_ROWS };

static size_t entries(const mbsri_closure *c)
{
    return (size_t)c->rows * (size_t)c->columns;
}

size_t mbsri_closure_turn_size(const mbsri_closure *c)
{
    return 4 * entries(c) + (size_t)(c->columns + c->rows);
}

mbsri_closure_turn mbsri_closure_turn_at(const mbsri_closure *c, double *memory)
{
    const size_t size = entries(c);
    return (mbsri_closure_turn){memory,
                                memory + size,
                                memory + 2 * size,
                                memory + 3 * size,
                                memory + 4 * size,
                                memory + 4 * size + c->columns};
}

bool mbsri_closure_may_turn(const mbsri_closure *c)
{
    return c->bodies == 2 && c->body[0] > 0 && c->body[1] > 0 && c->rows == c->position_rows &&
           c->rows <= c->column[1] && c->column[0] == 0 && !mbsri_reads_joints(c);
}

/* C_a C_a^T = R^T R, R with the inverses of its diagonal; false: the rows are not clearly
 * independent there. */
static bool factor_rows(const mbsri_closure *c, const double *C, double R[ROWS][ROWS])
{
    const int rows = c->rows, first = c->column[1];
    for (int i = 0; i < rows; ++i) {
        for (int j = i; j < rows; ++j) {
            double sum = 0.0;
            for (int k = 0; k < first; ++k) sum += C[k * rows + i] * C[k * rows + j];
            const double size = sum;
            for (int k = 0; k < i; ++k) sum -= R[k][i] * R[k][j];
            if (j == i && !(sum > 1e-6 * size)) return false;
            R[i][j] = j == i ? 1.0 / sqrt(sum) : R[i][i] * sum;
        }
    }
    return true;
}

/* x (rows) with C_a^T x = s (numbers of a, `stride` apart); what is left in *error. */
static void fit(const mbsri_closure *c, const double *C, double R[ROWS][ROWS], const double *s,
                int stride, double *x, double *error)
{
    const int rows = c->rows, first = c->column[1];
    bool any = false;
    for (int k = 0; k < first; ++k) any = any || s[k * stride] != 0.0;
    mbsri_zero((size_t)rows, x);
    for (int i = 0; i < rows && any; ++i) {
        double sum = 0.0;
        for (int k = 0; k < first; ++k) sum += C[k * rows + i] * s[k * stride];
        for (int k = 0; k < i; ++k) sum -= R[k][i] * x[k];
        x[i] = R[i][i] * sum;
    }
    for (int i = rows - 1; i >= 0 && any; --i) {
        for (int k = i + 1; k < rows; ++k) x[i] -= R[i][k] * x[k];
        x[i] *= R[i][i];
    }
    for (int k = 0; k < first && any; ++k) {
        const double left = fabs(s[k * stride] - mbsri_dot(rows, C + k * rows, x));
        *error = left > *error ? left : *error;
    }
}

bool mbsri_closure_turns(const mbsri_closure *c, const double *C, const double *S,
                         const mbsri_closure_turn *out)
{
    const int rows = c->rows, columns = c->columns, first = c->column[1];
    double R[ROWS][ROWS], largest = 0.0, error = 0.0;
    for (int k = 0; k < columns * columns; ++k) largest = fmax(largest, fabs(S[k]));
    if (!factor_rows(c, C, R)) return false;
    for (int j = first; j < columns; ++j) {
        fit(c, C, R, S + j * columns, 1, out->L + j * rows, &error);
        fit(c, C, R, S + j, columns, out->Y + j * rows, &error);
    }
    return error <= 1e-10 * largest;
}

void mbsri_closure_turn_over(const mbsri_closure *c, double factor, const double *C,
                             const mbsri_closure_turn *out, double *S, double *slope)
{
    const int rows = c->rows, columns = c->columns, first = c->column[1];
    mbsri_copy(entries(c), C, out->acts);
    mbsri_copy(entries(c), C, out->holds);
    for (int k = 0; k < rows; ++k) {
        const double compliance =
            mbsri_is_stiff(c, k) ? 1.0 / (c->def.stiffness[k] + factor * c->def.damping[k]) : 0.0;
        for (int j = first; j < columns; ++j) {
            const int at = j * rows + k;
            out->acts[at] -= compliance * out->Y[at];
            out->holds[at] -= compliance * out->L[at];
            slope[at] -= factor * compliance * out->L[at];
        }
    }
    /* C_b^T L + Y (C_b - K L) */
    for (int j = first; j < columns; ++j) {
        const double *L = out->L + j * rows, *holds = out->holds + j * rows;
        for (int i = first; i < columns; ++i)
            S[j * columns + i] -=
                mbsri_dot(rows, C + i * rows, L) + mbsri_dot(rows, out->Y + i * rows, holds);
    }
}
