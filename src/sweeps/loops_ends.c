/* What loops read of bodies and joints in the vectorised sweeps: see loops.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "sweeps/loops.h"

#include "algebra/space3.h"
#include "recursion/rounding.h"

#include <math.h>
#include <string.h>

/* What a closure reads at one of its bodies. */
typedef struct end_view {
    const mbsri_sweep_loop_end *of;
    const double *C, *arm; /* its columns; from the point of the sweeps to the body's own origin */
    double known[3];       /* acceleration of that origin at u' = 0 */
} end_view;

static inline end_view view_end(const mbsri_loop_run *w, int at, int i)
{
    const mbsri_sweep_run *run = w->run;
    const mbsri_sweep_state *s = run->state + i;
    end_view e = {.of = w->loops->end + at, .arm = run->load[i].arm};
    double swing[3];
    e.C = run->data->closure_C + e.of->C;
    if (w->motor) return e;
    mbsri_cross3(s->omega, e.arm, swing);
    mbsri_cross3(s->omega, swing, e.known);
    mbsri_add3(1.0, run->tree->gravity, e.known);
    return e;
}

/* Row k over the motion of the body's own origin. */
static inline void read_row(const end_view *e, int k, double row[6])
{
    const double *C = e->C + k;
    const int of = e->of->rows;
    if (e->of->d == 6) {
        for (int j = 0; j < 6; ++j) row[j] = C[j * of];
        return;
    }
    row[0] = row[1] = row[5] = 0.0;
    row[2] = e->of->d == 3 ? C[2 * of] : 0.0;
    row[3] = C[0];
    row[4] = C[of];
}

/* Q of row k about the point of the sweeps, and the lengths in it. */
static void place_row(mbsri_loop_run *w, const end_view *e, int k, const double row[6], double *Q,
                      double *lengths)
{
    const double turn = mbsri_norm3(row), move = mbsri_norm3(row + 3), *arm = e->arm;
    const double all = turn + w->lever * move, lever = mbsri_norm3(arm) * move;
    const bool six = e->of->d == 6, three = e->of->d == 3;
    memcpy(Q, row, 3 * sizeof *Q);
    mbsri_add_cross3(arm, row + 3, Q);
    memcpy(Q + 4, row + 3, 3 * sizeof *Q);
    Q[3] = Q[7] = lengths[3] = lengths[7] = 0.0;
    for (int j = 0; j < 2; ++j) {
        lengths[j] = six ? all + lever : 0.0;
        lengths[4 + j] = move;
    }
    lengths[2] = (six || three ? all : 0.0) + lever;
    lengths[6] = six ? move : 0.0;
    w->s[e->of->row + k] -= mbsri_dot3(row + 3, e->known);
    mbsri_share(turn, move, w->run->model->typical.length, w->share + e->of->row + k);
}

static void open_end(mbsri_loop_run *w, int at, int i)
{
    const end_view e = view_end(w, at, i);
    int count = 0;
    for (unsigned rigid = e.of->rigid; rigid; rigid &= rigid - 1) ++count;
    mbsri_open_part *part = w->part + w->parts++;
    *part = (mbsri_open_part){i, count, w->top};
    w->top += mbsri_open_size((size_t)count);
    const mbsri_open open = mbsri_open_at(part);
    for (int k = 0; k < 2 * count * count; ++k) open.F[k] = 0.0;
    for (int k = 0, to = 0; k < e.of->rows; ++k) {
        double row[6];
        if (!(e.of->rigid >> k & 1)) continue;
        read_row(&e, k, row);
        place_row(w, &e, k, row, open.Q + 8 * to, open.lengths + 8 * to);
        open.id[to++] = e.of->row + k;
    }
}

void mbsri_open_loops_end(mbsri_loop_run *w, int i)
{
    for (int at = w->loops->first_end[i]; at >= 0; at = w->loops->end[at].next) {
        if (!w->loops->end[at].coupling) open_end(w, at, i);
    }
}

static bool is_open(const mbsri_open_part *part, int id)
{
    const mbsri_open open = mbsri_open_at(part);
    for (int k = 0; k < open.count; ++k) {
        if (open.id[k] == id) return true;
    }
    return false;
}

void mbsri_open_loops_couple(mbsri_loop_run *w, int i)
{
    for (int at = w->loops->first_end[i]; at >= 0; at = w->loops->end[at].next) {
        const mbsri_sweep_loop_end *end = w->loops->end + at;
        if (!end->coupling) continue;
        if (w->parts == 0 || w->part[w->parts - 1].body != i)
            w->part[w->parts++] = (mbsri_open_part){i, 0, w->top};
        for (int k = 0; k < end->rows; ++k) {
            const bool fresh =
                end->rigid >> k & 1 && !is_open(w->part + w->parts - 1, end->row + k);
            if (fresh) (void)mbsri_open_loops_append(w, end->row + k);
        }
    }
}

void mbsri_open_loops_read_joint(mbsri_loop_run *w, int i, const mbsri_open *open, double *X,
                                 double *sizes)
{
    const mbsri_body *b = w->run->model->body + i;
    for (int k = 0; k < open->count; ++k) w->slot[open->id[k]] = k;
    for (int at = w->loops->first_end[i]; at >= 0; at = w->loops->end[at].next) {
        const mbsri_sweep_loop_end *e = w->loops->end + at;
        const double *C = w->run->data->closure_C + e->C + (size_t)(e->d * e->rows);
        for (int j = 0; j < e->n; ++j, C += e->rows) {
            for (int k = 0; k < e->rows; ++k) {
                const int column = w->slot[e->row + k];
                if (column < 0) continue;
                mbsri_share_of_joint(w->run->model, b, j, C[k], w->share + e->row + k);
                X[column * e->n + j] += C[k];
                sizes[column * e->n + j] += fabs(C[k]);
            }
        }
    }
    for (int k = 0; k < open->count; ++k) w->slot[open->id[k]] = -1;
}

static void read_body(mbsri_loop_run *w, int at, int i)
{
    const mbsri_sweep_state *s = w->run->state + i;
    const end_view e = view_end(w, at, i);
    double A[3];
    mbsri_cross3(s->A_w, e.arm, A);
    mbsri_add3(1.0, s->A_v, A);
    mbsri_add3(1.0, e.known, A);
    for (int k = 0; k < e.of->rows; ++k) {
        double row[6];
        if (!(e.of->rigid >> k & 1)) continue;
        read_row(&e, k, row);
        w->rest[e.of->row + k] += mbsri_dot3(row, s->A_w) + mbsri_dot3(row + 3, A);
    }
}

static void read_rates(mbsri_loop_run *w, const mbsri_sweep_loop_end *end, int i)
{
    const double *udot = w->run->out + w->run->tree->body[i].u,
                 *C = w->run->data->closure_C + end->C + (size_t)(end->d * end->rows);
    for (int j = 0; j < end->n; ++j, C += end->rows) {
        for (int k = 0; k < end->rows; ++k) {
            if (end->rigid >> k & 1) w->rest[end->row + k] += C[k] * udot[j];
        }
    }
}

void mbsri_open_loops_read(mbsri_loop_run *w, int i)
{
    for (int at = w->loops->first_end[i]; at >= 0; at = w->loops->end[at].next) {
        const mbsri_sweep_loop_end *end = w->loops->end + at;
        if (!end->coupling) read_body(w, at, i);
        if (end->n > 0) read_rates(w, end, i);
    }
}
