/* What a reduction says of itself: see report.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fe/report.h"

#include "algebra/dense.h"
#include "base/error.h"
#include "fe/lapack.h"

#include <math.h>

/* With its memory. */
typedef struct full_report {
    mbsr_fe_report report;
    mbsri_arena arena;
} full_report;

/* ---- numbers ---- */

/* Effective masses of the modes and what none of them moves: (B_a,i)^2 / M_a of B_ii. */
static void see_modes(const mbsri_fe_basis *basis, const double *D, const double *B,
                      mbsr_fe_mode *mode, double lost[6])
{
    const size_t size = 6 + (size_t)basis->count;
    double moved[6] = {0.0};
    for (int a = 0; a < basis->count; ++a) {
        const double mu = basis->mu[a], omega = mu > 0.0 ? 1.0 / sqrt(mu) : 0.0;
        const bool massless = basis->massless[a] != 0;
        mode[a] = (mbsr_fe_mode){.omega = omega, .massless = massless};
        if (massless) continue;
        mode[a].damping = 0.5 * D[a * (basis->count + 1)] / omega;
        for (int c = 0; c < 6; ++c) {
            const double share = B[size * (size_t)(6 + a) + (size_t)c];
            mode[a].effective[c] = share * share;
            moved[c] += share * share;
        }
    }
    for (size_t c = 0; c < 6; ++c) {
        const double whole = B[(size + 1) * c];
        lost[c] = whole > 0.0 ? fmin(fmax(1.0 - moved[c] / whole, 0.0), 1.0) : 0.0;
    }
}

/* Rows of modes with mass, and the rigid ones, of M(0) and B: the lowest eigenvalue of M(0) scaled
 * to unit diagonal, and the largest difference so scaled. A: size x size of M(0), of which the
 * picked part is left. */
static bool compare_mass_matrices(const mbsri_fe_basis *basis, double *A, const double *B,
                                  double *work, mbsr_fe_report *r)
{
    const int size = 6 + basis->count;
    double *w = work, *rest = work + size, *S = rest + mbsri_fe_eigen_work(size);
    int kept = 0;
    int *row = (int *)(S + (size_t)size * (size_t)size);
    r->difference = 0.0;
    for (int k = 0; k < size; ++k) {
        if ((k < 6 || !basis->massless[k - 6]) && A[k * (size + 1)] > 0.0) row[kept++] = k;
    }
    for (int j = 0; j < kept; ++j) {
        for (int k = 0; k < kept; ++k) {
            const int at = size * row[j] + row[k];
            const double scale = sqrt(A[row[j] * (size + 1)]) * sqrt(A[row[k] * (size + 1)]);
            S[j * kept + k] = A[at] / scale;
            r->difference = fmax(r->difference, fabs(A[at] - B[at]) / scale);
        }
    }
    r->definite = 0.0;
    if (kept == 0) return true;
    if (mbsri_fe_eigen(kept, S, w, rest) != 0) return false;
    r->definite = w[0];
    return true;
}

/* ---- text ---- */

static void put_line(mbsri_writer *w, const char *format, ...) MBSRI_FORMAT(2, 3);
static void put_line(mbsri_writer *w, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const size_t room = w->used < w->size ? w->size - w->used : 0;
    char nothing[1];
    w->used += (size_t)mbsri_vprint(room > 0 ? w->text + w->used : nothing, room > 0 ? room : 1,
                                    format, arguments);
    va_end(arguments);
}

static void put_shares(mbsri_writer *w, const double *share, const double *whole)
{
    static const int order[6] = {3, 4, 5, 0, 1, 2};
    for (int k = 0; k < 6; ++k) {
        const int c = order[k];
        const double all = whole ? whole[c] : 1.0;
        put_line(w, " %7.4f", all > 0.0 ? share[c] / all : 0.0);
    }
    put_line(w, "\n");
}

static void write_table(const mbsr_fe_report *r, mbsri_writer *w)
{
    const double pi = 3.14159265358979323846;
    const double whole[6] = {r->J[0], r->J[4], r->J[8], r->mass, r->mass, r->mass};
    put_line(w, "%d dofs, %d nodes; factor by %s: %.4g entries, %d solves\n", r->dofs, r->nodes,
             r->solver == MBSR_FE_SPARSE ? "CHOLMOD" : "LAPACK", r->entries, r->solves);
    put_line(w, "mass %.7g kg, moments of inertia about the root %.5g, %.5g, %.5g kg m^2\n",
             r->mass, r->J[0], r->J[4], r->J[8]);
    put_line(w, "%d normal modes; %d unit loads with static modes, %d of them dependent\n",
             r->normal, r->loads, r->dependent);
    put_line(
        w, "                                       part of the mass moved along, inertia about\n");
    put_line(w,
             "mode  omega rad/s         Hz  damping        x       y       z       x       y       "
             "z\n");
    for (int a = 0; a < r->modes; ++a) {
        const mbsr_fe_mode *mode = r->mode + a;
        put_line(w, "%4d %12.6g %10.5g", a, mode->omega, mode->omega / (2.0 * pi));
        if (mode->massless) {
            put_line(w, "  massless\n");
        } else {
            put_line(w, " %8.4g ", mode->damping);
            put_shares(w, mode->effective, whole);
        }
    }
    put_line(w, "lost, moved by no mode with mass:     ");
    put_shares(w, r->lost, NULL);
    put_line(w,
             "rigid motions cost %.2g; lowest eigenvalue of M(0) %.3g; off the matrices by %.2g\n",
             r->rigid, r->definite, r->difference);
}

/* The table, in memory of the report. */
static bool make_text(full_report *full)
{
    mbsri_writer count = {.text = NULL, .size = 0};
    write_table(&full->report, &count);
    mbsri_writer w = {.size = count.used + 1};
    w.text = mbsri_arena_take(&full->arena, w.size);
    if (!w.text) return false;
    write_table(&full->report, &w);
    full->report.text = w.text;
    return true;
}

/* ---- both ---- */

static int fill_report(full_report *full, const mbsri_fe_statics *s, const mbsri_fe_modes *modes,
                       const mbsri_fe_basis *basis, const mbsr_flex *flex, const double *B)
{
    mbsr_fe_report *r = &full->report;
    mbsr_flex_def data;
    const int size = 6 + basis->count;
    const size_t all = (size_t)size, count = (size_t)basis->count,
                 doubles = all + mbsri_fe_eigen_work(size) + 3 * all * all + all;
    double *omega = mbsri_arena_take(&full->arena, (size_t)modes->count * sizeof *omega),
           *work = mbsri_arena_take(s->body->arena, doubles * sizeof *work);
    mbsr_fe_mode *mode = mbsri_arena_take(&full->arena, count * sizeof *mode);
    if (!omega || !work || !mode) return MBSR_ERR_NO_MEMORY;
    double *A = work, *at_rest = A + all * all, *rest = at_rest + all;
    if (mbsr_flex_definition(flex, &data) || mbsr_flex_mass_matrix(flex, at_rest, A))
        return MBSR_ERR_NUMERICS;
    mbsri_copy((size_t)modes->count, modes->omega, omega);
    *r = (mbsr_fe_report){.dofs = s->body->n,
                          .nodes = s->body->nodes,
                          .solver = s->solver,
                          .entries = mbsri_factor_entries(s->factor),
                          .solves = s->solves,
                          .normal = modes->count,
                          .omega = omega,
                          .loads = basis->loads,
                          .dependent = basis->dependent,
                          .modes = basis->count,
                          .mode = mode,
                          .mass = data.mass,
                          .rigid = s->body->rigid};
    mbsri_copy(3, data.c0, r->c0);
    for (size_t k = 0; k < 9; ++k) r->J[k] = A[all * (k / 3) + k % 3];
    see_modes(basis, data.D, B, mode, r->lost);
    if (!compare_mass_matrices(basis, A, B, rest, r)) return MBSR_ERR_NUMERICS;
    return make_text(full) ? MBSR_OK : MBSR_ERR_NO_MEMORY;
}

int mbsri_fe_make_report(const mbsri_fe_statics *s, const mbsri_fe_modes *modes,
                         const mbsri_fe_basis *basis, const mbsr_flex *flex, const double *B,
                         mbsr_fe_report **report)
{
    mbsri_arena arena;
    mbsri_arena_open(&arena, &s->body->def->allocator);
    full_report *full = mbsri_arena_take(&arena, sizeof *full);
    int status = MBSR_ERR_NO_MEMORY;
    if (full) {
        full->arena = arena;
        status = fill_report(full, s, modes, basis, flex, B);
        if (!status)
            *report = &full->report;
        else
            mbsr_fe_report_destroy(&full->report);
    }
    return status ? mbsri_fail_plain(s->body->error, status,
                                     "mbsr_fe_reduce: no report can be made: %s",
                                     mbsr_status_text(status))
                  : MBSR_OK;
}

void mbsr_fe_report_destroy(mbsr_fe_report *report)
{
    if (!report) return;
    mbsri_arena arena = ((full_report *)(void *)report)->arena;
    mbsri_arena_close(&arena);
}
