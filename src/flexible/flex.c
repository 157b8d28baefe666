/* Making modal data and giving them back: see data.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "algebra/dense.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"
#include "flexible/check.h"
#include "flexible/unit_masses.h"

#include <math.h>

mbsr_flex_def mbsr_default_flex_def(void)
{
    return (mbsr_flex_def){.cookie = MBSRI_COOKIE};
}

#define REFUSE(status, ...) mbsri_fail(error, status, MBSR_NONE, MBSR_NONE, __VA_ARGS__)

static int check_flex(const mbsr_flex_def *def, mbsr_error *error)
{
    if (def->cookie != MBSRI_COOKIE)
        return REFUSE(MBSR_ERR_NO_DEFAULT,
                      "mbsr_flex_create: def was not made by mbsr_default_flex_def");
    if (def->modes < 0 || def->modes > MBSR_MAX_MODES)
        return REFUSE(MBSR_ERR_VALUE, "mbsr_flex_create: modes is %d, must be 0 .. %d", def->modes,
                      MBSR_MAX_MODES);
    if (def->dependent < 0 || def->dependent > MBSR_MAX_MODES - def->modes ||
        def->modes * def->dependent > MBSR_MAX_DEPENDENCES)
        return REFUSE(
            MBSR_ERR_VALUE,
            "mbsr_flex_create: dependent is %d, must be 0 .. %d beside %d modes and times "
            "these at most %d",
            def->dependent, MBSR_MAX_MODES - def->modes, def->modes, MBSR_MAX_DEPENDENCES);
    if (def->dependent > 0 && !def->Y)
        return REFUSE(MBSR_ERR_NULL,
                      "mbsr_flex_create: Y is NULL, but there are %d dependent shapes",
                      def->dependent);
    if (def->markers < 1)
        return REFUSE(MBSR_ERR_VALUE,
                      "mbsr_flex_create: markers is %d; a body needs one to be held at",
                      def->markers);
    if (!def->marker) return REFUSE(MBSR_ERR_NULL, "mbsr_flex_create: marker is NULL");
    if (def->modes > 0 && !def->K)
        return REFUSE(MBSR_ERR_NULL, "mbsr_flex_create: K is NULL, but there are %d modes",
                      def->modes);
    if (!def->allocator.allocate != !def->allocator.release)
        return REFUSE(MBSR_ERR_VALUE,
                      "mbsr_flex_create: allocator has one of its two functions only");
    return MBSR_OK;
}

/* Places the arrays at `memory` (NULL: none yet); the doubles they take. */
static size_t lay_out_flex(mbsr_flex *f, double *memory)
{
    const size_t n = (size_t)f->n, r = (size_t)f->r, m = n + r,
                 length[] = {3 * m, 9 * m, 9 * m * m, m * m, n * n, n * n, n * n * r, n * n, n, n};
    double **const array[] = {&f->Ct0, &f->P0, &f->P,    &f->Mf,    &f->K,
                              &f->D,   &f->Y,  &f->root, &f->moves, &f->turns};
    size_t used = 0;
    for (size_t k = 0; k < sizeof length / sizeof *length; ++k) {
        *array[k] = memory ? memory + used : NULL;
        used += length[k];
    }
    for (int k = 0; k < f->markers && memory; ++k) {
        f->marker[k].Phi = memory + used + 6 * m * (size_t)k;
        f->marker[k].Psi = f->marker[k].Phi + 3 * m;
    }
    return used + 6 * m * (size_t)f->markers;
}

/* to (count) = from, zero for NULL. */
static void copy_or_zero(size_t count, const double *from, double *to)
{
    if (from)
        mbsri_copy(count, from, to);
    else
        mbsri_zero(count, to);
}

/* Mf_ab = tr P_ab */
static void add_traces(mbsr_flex *f)
{
    const int n = f->m;
    for (int b = 0; b < n; ++b) {
        for (int a = 0; a < n; ++a) {
            const double *P = f->P + (size_t)(3 * n) * (size_t)(3 * b) + 3 * (size_t)a;
            f->Mf[(size_t)b * (size_t)n + (size_t)a] = P[0] + P[3 * n + 1] + P[6 * n + 2];
        }
    }
}

static void copy_data(const mbsr_flex_def *def, mbsr_flex *f)
{
    const size_t n = (size_t)f->n, m = (size_t)f->m;
    f->mass = def->mass;
    mbsri_copy(3, def->c0, f->c0);
    mbsri_copy(9, def->N0, f->N0);
    copy_or_zero(3 * m, def->Ct0, f->Ct0);
    copy_or_zero(9 * m, def->P0, f->P0);
    copy_or_zero(9 * m * m, def->P, f->P);
    copy_or_zero(m * m, def->Mf, f->Mf);
    if (!def->Mf) add_traces(f);
    copy_or_zero(n * n, def->K, f->K);
    copy_or_zero(n * n, def->D, f->D);
    copy_or_zero(n * n * (size_t)f->r, def->Y, f->Y);
    for (int k = 0; k < f->markers; ++k) {
        f->marker[k].frame = def->marker[k].frame;
        copy_or_zero(3 * m, def->marker[k].Phi, (double *)f->marker[k].Phi);
        copy_or_zero(3 * m, def->marker[k].Psi, (double *)f->marker[k].Psi);
        f->rests[k] = true;
        for (size_t l = 0; l < 3 * m; ++l) {
            if (f->marker[k].Phi[l] != 0.0 || f->marker[k].Psi[l] != 0.0) f->rests[k] = false;
        }
    }
}

/* What modes alone do, at s = 0. */
static void find_reach(mbsr_flex *f)
{
    for (int k = 0; k < f->n; ++k) {
        f->moves[k] = f->mass > 0.0 ? sqrt(fmax(0.0, f->Mf[k * (f->m + 1)]) / f->mass) : 0.0;
        f->turns[k] = 0.0;
        for (int i = 0; i < f->markers; ++i) {
            const double *x = f->marker[i].Phi + (size_t)3 * (size_t)k,
                         *turn = f->marker[i].Psi + (size_t)3 * (size_t)k;
            f->moves[k] = fmax(f->moves[k], sqrt(mbsri_dot(3, x, x)));
            f->turns[k] = fmax(f->turns[k], sqrt(mbsri_dot(3, turn, turn)));
        }
    }
}

double mbsr_flex_span(const mbsr_flex *flex, int mode, double length)
{
    if (!flex || mode < 0 || mode >= flex->n || !(length > 0.0)) return 1.0;
    const double span = 1.0 / fmax(flex->moves[mode] / length, flex->turns[mode]);
    return span > 0.0 && isfinite(span) ? span : 1.0;
}

int mbsr_flex_create(const mbsr_flex_def *def, mbsr_flex **flex, mbsr_error *error)
{
    if (flex) *flex = NULL;
    if (!def || !flex)
        return REFUSE(MBSR_ERR_NULL, "mbsr_flex_create: %s is NULL", !def ? "def" : "flex");
    int status = check_flex(def, error);
    if (status) return status;
    mbsr_flex sizes = {.n = def->modes,
                       .r = def->dependent,
                       .m = def->modes + def->dependent,
                       .markers = def->markers};
    const size_t markers = (size_t)def->markers,
                 heads = sizeof sizes + markers * sizeof *sizes.marker,
                 numbers = lay_out_flex(&sizes, NULL);
    mbsr_flex *f = mbsri_allocate(&def->allocator,
                                  heads + numbers * sizeof(double) + markers * sizeof *f->rests);
    if (!f)
        return REFUSE(MBSR_ERR_NO_MEMORY, "mbsr_flex_create: no memory for %d modes", def->modes);
    *f = sizes;
    f->allocator = def->allocator;
    f->marker = (mbsr_flex_marker *)(f + 1);
    lay_out_flex(f, (double *)(f->marker + f->markers));
    f->rests = (bool *)((double *)(f->marker + f->markers) + numbers);
    copy_data(def, f);
    status = mbsri_flex_check(f, error);
    if (status) {
        mbsr_flex_destroy(f);
        return status;
    }
    mbsri_symmetrise(3 * f->m, f->P); /* to the last digit: mass.c relies on that */
    mbsri_symmetrise(f->m, f->Mf);
    mbsri_flex_find_root(f);
    find_reach(f);
    *flex = f;
    return MBSR_OK;
}

void mbsr_flex_destroy(mbsr_flex *flex)
{
    if (!flex) return;
    const mbsr_allocator allocator = flex->allocator;
    mbsri_release(&allocator, flex);
}

int mbsr_flex_definition(const mbsr_flex *flex, mbsr_flex_def *data)
{
    const mbsr_flex *f = flex;
    if (!f || !data) return MBSR_ERR_NULL;
    *data = (mbsr_flex_def){.cookie = MBSRI_COOKIE,
                            .modes = f->n,
                            .dependent = f->r,
                            .mass = f->mass,
                            .Ct0 = f->Ct0,
                            .P0 = f->P0,
                            .P = f->P,
                            .Mf = f->Mf,
                            .Y = f->r > 0 ? f->Y : NULL,
                            .K = f->K,
                            .D = f->D,
                            .markers = f->markers,
                            .marker = f->marker,
                            .allocator = f->allocator};
    mbsri_copy(3, f->c0, data->c0);
    mbsri_copy(9, f->N0, data->N0);
    return MBSR_OK;
}
