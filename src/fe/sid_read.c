/* Modal data of SID files: mbsr_sid_read.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *   c0 = mdCM.m0,  Ct0 = Ct.m0,  Mf = Me,  K = Ke,  D = De,  N0 = tr(J) / 2 1 - J
 *   P0_a + P0_a^T = tr(J1) / 2 1 - J1,  J1 = d J / d q_a,      axial(P0_a) = Cr.m0
 *   axial(P_ba) = d Cr_a / d q_b,      symmetric part of P_ba:  d Oe_a / d q_b
 *   row a of Oe = -(Eyy + Ezz), -(Exx + Ezz), -(Exx + Eyy), Exy + Eyx, Eyz + Ezy, Exz + Ezx
 *       of E_a = int rho Phi_a^T
 *
 * Gr and Ge follow from these and are not looked at. */
#include "algebra/dense.h"
#include "base/error.h"
#include "fe/lapack.h"
#include "fe/sid.h"

#include <math.h>
#include <string.h>

enum { COOKIE = 0x6d627369 };

mbsr_sid_opt mbsr_default_sid_opt(void)
{
    return (mbsr_sid_opt){.cookie = COOKIE};
}

/* With its memory. */
typedef struct full_report {
    mbsr_sid_report report;
    mbsri_arena arena;
} full_report;

typedef struct reader {
    mbsri_arena *arena;
    mbsri_lines lines;
    const mbsr_sid_opt *opt;
    mbsri_sid sid;
    mbsri_sid_integrals s;
    mbsr_sid_report report;
    mbsr_error *error;
} reader;

/* ---- integrals ---- */

/* xx yy zz xy xz yz, in the columns of a matrix of `rows` rows. */
static void tensor(const double v[6], double A[9])
{
    static const int at[9] = {0, 3, 4, 3, 1, 5, 4, 5, 2};
    for (int k = 0; k < 9; ++k) A[k] = v[at[k]];
}

/* E of its symmetric part S2 = E + E^T and a = axial(E); column-major. */
static void matrix_of_parts(const double S2[9], const double a[3], double E[9])
{
    for (int k = 0; k < 9; ++k) E[k] = 0.5 * S2[k];
    for (int c = 0; c < 3; ++c) {
        const int p = (c + 1) % 3, q = (c + 2) % 3; /* a_c = E_pq - E_qp */
        E[3 * q + p] += 0.5 * a[c];
        E[3 * p + q] -= 0.5 * a[c];
    }
}

/* tr / 2 1 - A: from a tensor of inertia the second moments. */
static void moments(double A[9])
{
    const double half = 0.5 * (A[0] + A[4] + A[8]);
    for (int k = 0; k < 9; ++k) A[k] = (k % 4 == 0 ? half : 0.0) - A[k];
}

static void first_order(reader *r)
{
    const mbsri_sid *sid = &r->sid;
    const int n = r->s.n;
    mbsri_copy(3, sid->mdCM.m0, r->s.c0);
    tensor(sid->J.m0, r->s.N0);
    moments(r->s.N0);
    for (int a = 0; a < n; ++a) {
        static const double zero[6] = {0.0};
        double S2[9], axial[3];
        for (int c = 0; c < 3; ++c) {
            r->s.Ct0[3 * a + c] = sid->Ct.m0[n * c + a];
            axial[c] = sid->Cr.m0[n * c + a];
        }
        tensor(sid->J.m1 ? sid->J.m1 + 6 * a : zero, S2);
        moments(S2);
        matrix_of_parts(S2, axial, r->s.P0 + 9 * a);
    }
}

/* Symmetric part, times two, of a row of Oe. */
static void from_oe(const double v[6], double S2[9])
{
    const double half = 0.5 * (v[0] + v[1] + v[2]); /* -(Exx + Eyy + Ezz) */
    const double diagonal[3] = {2.0 * (v[0] - half), 2.0 * (v[1] - half), 2.0 * (v[2] - half)};
    for (int c = 0; c < 3; ++c) S2[4 * c] = diagonal[c];
    S2[1] = S2[3] = v[3];
    S2[5] = S2[7] = v[4];
    S2[2] = S2[6] = v[5];
}

/* Row a of the derivative of A (n x columns) by mode b. */
static void row_of(const mbsri_taylor *A, int n, int a, int b, double *v)
{
    for (int c = 0; c < A->columns; ++c)
        v[c] =
            A->m1 ? A->m1[(size_t)n * (size_t)A->columns * (size_t)b + (size_t)(n * c + a)] : 0.0;
}

static void second_order(reader *r)
{
    const mbsri_sid *sid = &r->sid;
    const int n = r->s.n, rows = 3 * n;
    r->report.no_second_order = !sid->Oe.there || !sid->Oe.m1;
    for (int a = 0; a < n; ++a) {
        for (int b = 0; b < n; ++b) {
            const double Mf = r->s.Mf[n * b + a],
                         size = sqrt(fabs(r->s.Mf[a * (n + 1)])) * sqrt(fabs(r->s.Mf[b * (n + 1)]));
            double S2[9], axial[3], E[9], one[6], two[6], x[3], y[3];
            row_of(&sid->Cr, n, a, b, x);
            row_of(&sid->Cr, n, b, a, y);
            for (int c = 0; c < 3; ++c) {
                axial[c] = 0.5 * (x[c] - y[c]);
                r->report.stiffening |=
                    size > 0.0 && fabs(x[c] + y[c]) > 1e-6 * size * sqrt(r->s.mass);
            }
            if (r->report.no_second_order) {
                for (int k = 0; k < 9; ++k) S2[k] = k % 4 == 0 ? Mf * 2.0 / 3.0 : 0.0;
            } else {
                row_of(&sid->Oe, n, a, b, one);
                row_of(&sid->Oe, n, b, a, two);
                for (int c = 0; c < 6; ++c) {
                    if (size > 0.0)
                        r->report.asymmetry =
                            fmax(r->report.asymmetry, fabs(one[c] - two[c]) / size);
                    one[c] = 0.5 * (one[c] + two[c]);
                }
                from_oe(one, S2);
            }
            matrix_of_parts(S2, axial, E); /* P_ba: block of rows b, columns a */
            for (int k = 0; k < 9; ++k)
                r->s.P[(size_t)rows * (size_t)(3 * a + k / 3) + (size_t)(3 * b + k % 3)] = E[k];
        }
    }
}

static bool fill_integrals(reader *r)
{
    mbsri_sid_integrals *s = &r->s;
    const size_t n = (size_t)r->sid.modes;
    s->n = r->sid.modes;
    s->mass = r->sid.mass;
    s->Ct0 = mbsri_arena_take(r->arena, 3 * n * sizeof *s->Ct0);
    s->P0 = mbsri_arena_take(r->arena, 9 * n * sizeof *s->P0);
    s->P = mbsri_arena_take(r->arena, 9 * n * n * sizeof *s->P);
    s->Mf = r->sid.Me.m0;
    if (!s->Ct0 || !s->P0 || !s->P) return false;
    first_order(r);
    second_order(r);
    return true;
}

/* ---- what the file is worth ---- */

/* Lowest eigenvalue of M(0) = [J, [c]x, Cr^T; ., m 1, Ct^T; ., ., Me], scaled to unit diagonal. */
static int see_definiteness(reader *r)
{
    const mbsri_sid *sid = &r->sid;
    const int n = r->s.n, size = 6 + n;
    const double *c = sid->mdCM.m0;
    const double skew[9] = {0.0, c[2], -c[1], -c[2], 0.0, c[0], c[1], -c[0], 0.0};
    double *M = mbsri_arena_take(r->arena, (size_t)size * (size_t)size * sizeof *M),
           *w = mbsri_arena_take(r->arena, 2 * (size_t)size * sizeof *w),
           *work = mbsri_arena_take(r->arena, mbsri_fe_eigen_work(size) * sizeof *work), J[9];
    if (!M || !w || !work) return MBSR_ERR_NO_MEMORY;
    tensor(sid->J.m0, J);
    for (int k = 0; k < 9; ++k) {
        M[size * (k / 3) + k % 3] = J[k];
        M[size * (3 + k / 3) + k % 3] = M[size * (k % 3) + 3 + k / 3] = skew[k];
        M[size * (3 + k / 3) + 3 + k % 3] = k % 4 == 0 ? r->s.mass : 0.0;
    }
    for (int a = 0; a < n; ++a) {
        for (int k = 0; k < 3; ++k) {
            M[size * (6 + a) + k] = M[size * k + 6 + a] = sid->Cr.m0[n * k + a];
            M[size * (6 + a) + 3 + k] = M[size * (3 + k) + 6 + a] = sid->Ct.m0[n * k + a];
        }
        for (int b = 0; b < n; ++b) M[size * (6 + a) + 6 + b] = sid->Me.m0[n * a + b];
    }
    for (int k = 0; k < size; ++k) {
        const double d = fabs(M[k * (size + 1)]);
        w[size + k] = d > 0.0 ? 1.0 / sqrt(d) : 1.0;
    }
    for (int k = 0; k < size * size; ++k) M[k] *= w[size + k / size] * w[size + k % size];
    for (int k = 0; k < size * size; ++k) {
        if (!isfinite(M[k]))
            return mbsri_fail_plain(r->error, MBSR_ERR_VALUE,
                                    "mbsr_sid_read: numbers of M(0) overflow when scaled");
    }
    if (mbsri_fe_eigen(size, M, w, work) != 0)
        return mbsri_fail_plain(r->error, MBSR_ERR_NUMERICS,
                                "mbsr_sid_read: the eigenvalues of M(0) did not converge");
    r->report.definite = w[0];
    return MBSR_OK;
}

static void see_relations(reader *r)
{
    const mbsri_sid *sid = &r->sid;
    const int n = r->s.n, rows = 3 * n;
    r->report.modes = n;
    r->report.markers = sid->nodes.count;
    r->report.stiffening |= sid->Ct.more;
    for (int a = 0; a < n; ++a) {
        const double *P = r->s.P + (size_t)rows * (size_t)(3 * a) + 3 * a,
                     Mf = r->s.Mf[a * (n + 1)];
        if (!(Mf > 0.0)) continue;
        const double share = (P[0] + P[rows + 1] + P[2 * rows + 2]) / Mf;
        const bool first = r->report.trace[1] == 0.0;
        r->report.trace[0] = first ? share : fmin(r->report.trace[0], share);
        r->report.trace[1] = first ? share : fmax(r->report.trace[1], share);
        for (int c = 0; c < 3 && sid->mdCM.m1; ++c)
            r->report.mdCM =
                fmax(r->report.mdCM,
                     fabs(sid->mdCM.m1[3 * a + c] - r->s.Ct0[3 * a + c]) / sqrt(r->s.mass * Mf));
    }
    for (int k = 0; k < sid->nodes.count; ++k) {
        const mbsri_sid_node *node = (const mbsri_sid_node *)sid->nodes.items + k;
        r->report.stiffening |= node->phi.more || node->psi.more;
    }
}

/* Masses that are not negative, symmetric modal ones; rounding is taken out of these. */
static int check_masses(const reader *r)
{
    const int n = r->s.n;
    double *Mf = r->s.Mf;
    if (!(r->s.mass > 0.0))
        return mbsri_fail_plain(r->error, MBSR_ERR_VALUE, "mbsr_sid_read: the mass is %g",
                                r->s.mass);
    for (int a = 0; a < n; ++a) {
        for (int b = 0; b < a; ++b) {
            const double one = Mf[n * b + a], two = Mf[n * a + b],
                         size = sqrt(fabs(Mf[a * (n + 1)])) * sqrt(fabs(Mf[b * (n + 1)]));
            if (fabs(one - two) > 1e-9 * (fabs(one) + fabs(two) + size))
                return mbsri_fail_plain(
                    r->error, MBSR_ERR_VALUE,
                    "mbsr_sid_read: Me is not symmetric: (%d,%d) is %.10g, (%d,%d) is "
                    "%.10g",
                    a + 1, b + 1, one, b + 1, a + 1, two);
            Mf[n * b + a] = Mf[n * a + b] = 0.5 * (one + two);
        }
        if (Mf[a * (n + 1)] < 0.0)
            return mbsri_fail_plain(r->error, MBSR_ERR_VALUE,
                                    "mbsr_sid_read: the modal mass Me(%d,%d) is %g", a + 1, a + 1,
                                    Mf[a * (n + 1)]);
    }
    return MBSR_OK;
}

/* ---- results ---- */

static int create_flex(reader *r, mbsr_flex **flex)
{
    const mbsri_sid *sid = &r->sid;
    mbsr_flex_def def = mbsr_default_flex_def();
    mbsr_flex_marker *marker =
        mbsri_arena_take(r->arena, (size_t)sid->nodes.count * sizeof *marker);
    if (!marker) return MBSR_ERR_NO_MEMORY;
    for (int k = 0; k < sid->nodes.count; ++k) {
        const mbsri_sid_node *node = (const mbsri_sid_node *)sid->nodes.items + k;
        marker[k] = (mbsr_flex_marker){
            .frame = mbsr_frame_at(node->origin.m0[0], node->origin.m0[1], node->origin.m0[2]),
            .Phi = node->phi.m0,
            .Psi = node->psi.there ? node->psi.m0 : NULL};
        if (node->AP.there) mbsri_copy(9, node->AP.m0, marker[k].frame.R);
    }
    def.modes = r->s.n;
    def.mass = r->s.mass;
    mbsri_copy(3, r->s.c0, def.c0);
    mbsri_copy(9, r->s.N0, def.N0);
    def.Ct0 = r->s.Ct0, def.P0 = r->s.P0, def.P = r->s.P, def.Mf = r->s.Mf;
    def.K = sid->Ke.m0, def.D = sid->De.there ? sid->De.m0 : NULL;
    def.markers = sid->nodes.count, def.marker = marker;
    def.allocator = r->opt->allocator;
    return mbsr_flex_create(&def, flex, r->error);
}

enum { SENTENCES = 1024 };

static void write_text(const mbsr_sid_report *r, char *text)
{
    mbsri_print(
        text, SENTENCES,
        "%d modes, %d nodes. M(0), scaled to unit diagonal, has the lowest eigenvalue %.3g%s. "
        "tr P / Me is %.3g to %.3g; Oe.m1 is symmetric to %.2g, mdCM.m1 is Ct to %.2g.%s%s\n",
        r->modes, r->markers, r->definite, r->definite < -1e-9 ? ": INDEFINITE" : "", r->trace[0],
        r->trace[1], r->asymmetry, r->mdCM,
        r->no_second_order ? " Oe.m1 is not there: P was taken alike along all axes." : "",
        r->stiffening ? " Terms of geometric stiffening were left out." : "");
    const size_t used = strlen(text);
    if (fmin(fmin(r->keep_coupling, r->keep_strain), r->keep_rest) < 1.0 || r->changed_P > 1e-9)
        mbsri_print(
            text + used, SENTENCES - used,
            "CHANGED: modes keep at least %.3g of Ct and Cr, %.3g of what else J.m1 says, %.3g "
            "of what else Oe.m1 and Cr.m1 say; P changed by up to %.3g of modal masses.\n",
            r->keep_coupling, r->keep_strain, r->keep_rest, r->changed_P);
}

static int make_report(const reader *r, mbsr_sid_report **report)
{
    mbsri_arena arena;
    mbsri_arena_open(&arena, &r->opt->allocator);
    full_report *full = mbsri_arena_take(&arena, sizeof *full);
    if (!full) return MBSR_ERR_NO_MEMORY;
    full->report = r->report;
    const size_t n = (size_t)r->s.n, nodes = (size_t)r->sid.nodes.count;
    int *node = mbsri_arena_take(&arena, nodes * sizeof *node);
    const char **name = mbsri_arena_take(&arena, n * sizeof *name);
    char *text = mbsri_arena_take(&arena, SENTENCES);
    for (size_t k = 0; k < nodes && node; ++k)
        node[k] = ((const mbsri_sid_node *)r->sid.nodes.items)[k].id;
    for (size_t k = 0; k < n && name; ++k)
        name[k] = mbsri_arena_text(&arena, r->sid.name[k], strlen(r->sid.name[k]));
    if (arena.failed) {
        mbsri_arena_close(&arena);
        return MBSR_ERR_NO_MEMORY;
    }
    write_text(&full->report, text);
    full->report.node = node;
    full->report.name = name;
    full->report.text = text;
    full->arena = arena;
    *report = &full->report;
    return MBSR_OK;
}

static int read_sid(reader *r, mbsr_flex **flex, mbsr_sid_report **report)
{
    int status = mbsri_sid_parse(r->arena, &r->lines, &r->sid);
    if (!status && !fill_integrals(r)) status = MBSR_ERR_NO_MEMORY;
    if (!status) status = check_masses(r);
    if (!status) status = see_definiteness(r);
    if (status) return status;
    see_relations(r);
    status = mbsri_sid_fit(r->arena, r->opt->change, &r->s, &r->report, r->error);
    if (!status) status = create_flex(r, flex);
    return status || !report ? status : make_report(r, report);
}

static int check_sid_arguments(const char *text, const mbsr_sid_opt *opt, mbsr_flex **flex,
                               mbsr_error *error)
{
    if (!text || !flex)
        return mbsri_fail_plain(error, MBSR_ERR_NULL, "mbsr_sid_read: %s is NULL",
                                !text ? "text" : "flex");
    if (opt->cookie != COOKIE)
        return mbsri_fail_plain(error, MBSR_ERR_NO_DEFAULT,
                                "mbsr_sid_read: the options were not made by mbsr_default_sid_opt");
    if (opt->change < MBSR_SID_NOTHING || opt->change > MBSR_SID_COUPLING)
        return mbsri_fail_plain(error, MBSR_ERR_VALUE,
                                "mbsr_sid_read: opt.change is %d, none of mbsr_sid_change",
                                (int)opt->change);
    if (!opt->allocator.allocate != !opt->allocator.release)
        return mbsri_fail_plain(error, MBSR_ERR_VALUE,
                                "mbsr_sid_read: opt.allocator has one of its two functions only");
    return MBSR_OK;
}

int mbsr_sid_read(const char *text, size_t size, const char *name, const mbsr_sid_opt *opt,
                  mbsr_flex **flex, mbsr_sid_report **report, mbsr_error *error)
{
    const mbsr_sid_opt standard = mbsr_default_sid_opt();
    if (flex) *flex = NULL;
    if (report) *report = NULL;
    if (!opt) opt = &standard;
    int status = check_sid_arguments(text, opt, flex, error);
    if (status) return status;
    mbsri_arena arena;
    mbsri_arena_open(&arena, &opt->allocator);
    reader r = {.arena = &arena,
                .lines = {.text = text,
                          .end = text + size,
                          .word = text,
                          .stop = text,
                          .file = name ? name : "SID",
                          .error = error},
                .opt = opt,
                .error = error};
    status = read_sid(&r, flex, report);
    mbsri_arena_close(&arena);
    if (!status) return MBSR_OK;
    mbsr_flex_destroy(*flex);
    *flex = NULL;
    return status == MBSR_ERR_NO_MEMORY
               ? mbsri_fail_plain(error, status, "mbsr_sid_read: no memory for the file")
               : status;
}

void mbsr_sid_report_destroy(mbsr_sid_report *report)
{
    if (!report) return;
    mbsri_arena arena = ((full_report *)(void *)report)->arena;
    mbsri_arena_close(&arena);
}
