/* Modal data as SID files: mbsr_sid_write; src/fe/sid_read.c has the relations.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "base/error.h"
#include "files/arena.h"

#include <mbsrank/sid.h>

#include <string.h>

/* With its memory. */
typedef struct full_text {
    mbsr_sid_text text;
    mbsri_arena arena;
} full_text;

typedef struct writer {
    mbsri_writer text;
    const char *indent;
    const mbsr_flex_def *d;
} writer;

static void put_text(writer *w, const char *format, ...) MBSRI_FORMAT(2, 3);
static void put_text(writer *w, const char *format, ...)
{
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    mbsri_vprint(line, sizeof line, format, arguments);
    va_end(arguments);
    mbsri_write(&w->text, line, strlen(line));
}

/* "   key   =   value" */
static void put_key(writer *w, const char *key, int value)
{
    put_text(w, "%s     %-22s=%5d\n", w->indent, key, value);
}

static void put_value(writer *w, const char *entry, double value)
{
    char number[40];
    mbsri_print(number, sizeof number, "%.16E", value);
    char *exponent = strchr(number, 'E');
    if (exponent) *exponent = 'D';
    put_text(w, "%s     %-22s=%s%s\n", w->indent, entry, value < 0.0 ? "" : " ", number);
}

static void put0(writer *w, int i, int j, double value)
{
    char entry[40];
    if (value == 0.0) return;
    mbsri_print(entry, sizeof entry, "m0(%4d,%4d)", i + 1, j + 1);
    put_value(w, entry, value);
}

static void put1(writer *w, int i, int k, int j, double value)
{
    char entry[40];
    if (value == 0.0) return;
    mbsri_print(entry, sizeof entry, "m1(%4d,%4d,%4d)", i + 1, k + 1, j + 1);
    put_value(w, entry, value);
}

static void open_matrix(writer *w, const char *name, int order, int rows, int columns)
{
    enum { FULL = 3 };
    put_text(w, "%s%s\n", w->indent, name);
    put_key(w, "order", order);
    put_key(w, "nrow", rows);
    put_key(w, "ncol", columns);
    put_key(w, "nq", w->d->modes);
    put_key(w, "nqn", 0);
    put_key(w, "structure", FULL);
}

static void close_matrix(writer *w, const char *name)
{
    put_text(w, "%send %s\n", w->indent, name);
}

/* A (rows x columns) without first derivatives. */
static void put_matrix(writer *w, const char *name, int rows, int columns, const double *A)
{
    open_matrix(w, name, 0, rows, columns);
    for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < columns; ++j) put0(w, i, j, A[(size_t)rows * (size_t)j + (size_t)i]);
    }
    close_matrix(w, name);
}

/* ---- what the matrices are ---- */

/* (E23 - E32, E31 - E13, E12 - E21), E in columns of `step` */
static double axial(const double *E, size_t step, int c)
{
    const size_t p = (size_t)(c + 1) % 3, q = (size_t)(c + 2) % 3;
    return E[step * q + p] - E[step * p + q];
}

/* Entry k of a row of Oe. */
static double oe(const double *E, size_t step, int k)
{
    static const size_t row[6] = {1, 0, 0, 0, 1, 0}, column[6] = {2, 2, 1, 1, 2, 2};
    const size_t i = row[k], j = column[k];
    return k < 3 ? -(E[step * i + i] + E[step * j + j]) : E[step * j + i] + E[step * i + j];
}

/* Entry k of xx yy zz xy xz yz of tr(A) 1 - A. */
static double inertia(const double A[9], int k)
{
    static const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
    return (k < 3 ? A[0] + A[4] + A[8] : 0.0) - A[3 * column[k] + row[k]];
}

/* P_ba: block of rows b, columns a. */
static const double *block(const mbsr_flex_def *d, int b, int a)
{
    const size_t rows = 3 * (size_t)d->modes;
    return d->P + rows * (size_t)(3 * a) + 3 * b;
}

static void put_mass(writer *w)
{
    const mbsr_flex_def *d = w->d;
    const int n = d->modes;
    open_matrix(w, "mdCM", 1, 3, 1);
    for (int c = 0; c < 3; ++c) put0(w, c, 0, d->c0[c]);
    for (int a = 0; a < n; ++a) {
        for (int c = 0; c < 3; ++c) put1(w, c, a, 0, d->Ct0[3 * a + c]);
    }
    close_matrix(w, "mdCM");
    open_matrix(w, "J", 1, 6, 1);
    for (int k = 0; k < 6; ++k) put0(w, k, 0, inertia(d->N0, k));
    for (int a = 0; a < n; ++a) {
        double E2[9];
        for (int k = 0; k < 9; ++k) E2[k] = d->P0[9 * a + k] + d->P0[9 * a + 3 * (k % 3) + k / 3];
        for (int k = 0; k < 6; ++k) put1(w, k, a, 0, inertia(E2, k));
    }
    close_matrix(w, "J");
    open_matrix(w, "Ct", 0, n, 3);
    for (int a = 0; a < n; ++a) {
        for (int c = 0; c < 3; ++c) put0(w, a, c, d->Ct0[3 * a + c]);
    }
    close_matrix(w, "Ct");
    open_matrix(w, "Cr", 1, n, 3);
    for (int a = 0; a < n; ++a) {
        for (int c = 0; c < 3; ++c) {
            put0(w, a, c, axial(d->P0 + 9 * a, 3, c));
            for (int b = 0; b < n; ++b) put1(w, a, b, c, axial(block(d, b, a), 3 * (size_t)n, c));
        }
    }
    close_matrix(w, "Cr");
    put_matrix(w, "Me", n, n, d->Mf);
}

static void put_gyroscopic(writer *w)
{
    const mbsr_flex_def *d = w->d;
    const int n = d->modes;
    open_matrix(w, "Gr", 0, 3, 3 * n);
    for (int a = 0; a < n; ++a) {
        const double *E = d->P0 + 9 * a, trace = E[0] + E[4] + E[8];
        for (int k = 0; k < 9; ++k)
            put0(w, k / 3, 3 * a + k % 3,
                 2.0 * ((k % 4 == 0 ? trace : 0.0) - E[3 * (k / 3) + k % 3]));
    }
    close_matrix(w, "Gr");
    open_matrix(w, "Ge", 0, n, 3 * n);
    for (int a = 0; a < n; ++a) {
        for (int b = 0; b < 3 * n; ++b)
            put0(w, a, b, 2.0 * axial(block(d, b / 3, a), 3 * (size_t)n, b % 3));
    }
    close_matrix(w, "Ge");
    open_matrix(w, "Oe", 1, n, 6);
    for (int a = 0; a < n; ++a) {
        for (int k = 0; k < 6; ++k) {
            put0(w, a, k, oe(d->P0 + 9 * a, 3, k));
            for (int b = 0; b < n; ++b) put1(w, a, b, k, oe(block(d, b, a), 3 * (size_t)n, k));
        }
    }
    close_matrix(w, "Oe");
}

/* d(exp([psi]x) R) / ds = [psi]x R */
static double turned_column(const double psi[3], const double *column, int i)
{
    const int p = (i + 1) % 3, q = (i + 2) % 3;
    return psi[p] * column[q] - psi[q] * column[p];
}

static void put_node(writer *w, int k)
{
    const mbsr_flex_marker *marker = w->d->marker + k;
    const int n = w->d->modes;
    put_text(w, "                new node                        =%5d\n", k + 1);
    put_text(w, "                     rframe                     =    body ref\n");
    w->indent = "                     ";
    open_matrix(w, "origin", 1, 3, 1);
    for (int i = 0; i < 3; ++i) put0(w, i, 0, marker->frame.x[i]);
    for (int a = 0; a < n; ++a) {
        for (int i = 0; i < 3; ++i) put1(w, i, a, 0, marker->Phi[3 * a + i]);
    }
    close_matrix(w, "origin");
    put_matrix(w, "phi", 3, n, marker->Phi);
    put_matrix(w, "psi", 3, n, marker->Psi);
    open_matrix(w, "AP", 1, 3, 3);
    for (int l = 0; l < 9; ++l) put0(w, l % 3, l / 3, marker->frame.R[l]);
    for (int a = 0; a < n; ++a) {
        for (int l = 0; l < 9; ++l)
            put1(w, l % 3, a, l / 3,
                 turned_column(marker->Psi + 3 * a, marker->frame.R + 3 * (l / 3), l % 3));
    }
    close_matrix(w, "AP");
    put_text(w, "                end node\n");
}

static void put_file(writer *w, const char *name)
{
    const mbsr_flex_def *d = w->d;
    put_text(w, "%5d%5d : nodes, modes; without geometric stiffening\n part\n", d->markers,
             d->modes);
    put_text(w, "      new modal                                 = ");
    for (int k = 0; k < 80 && name[k] && name[k] != '\n' && name[k] != '\r'; ++k)
        mbsri_write(&w->text, name + k, 1);
    put_text(w, "\n           refmod\n");
    w->indent = "           ";
    put_value(w, "mass", d->mass);
    put_key(w, "nelastq", d->modes);
    for (int a = 0; a < d->modes; ++a) {
        const double M = d->Mf[a * (d->modes + 1)];
        put_text(w, "                ielastq (%4d)         = mode %d%s\n", a + 1, a + 1,
                 M > 0.0 ? "" : ", massless");
    }
    put_text(w, "           end refmod\n           frame\n");
    for (int k = 0; k < d->markers; ++k) put_node(w, k);
    put_text(w, "           end frame\n");
    w->indent = "           ";
    put_mass(w);
    put_gyroscopic(w);
    open_matrix(w, "ksigma", 0, d->modes, 1);
    close_matrix(w, "ksigma");
    put_matrix(w, "Ke", d->modes, d->modes, d->K);
    put_matrix(w, "De", d->modes, d->modes, d->D);
    put_text(w, "      end modal\n end part\n");
}

int mbsr_sid_write(const mbsr_flex *flex, const char *name, const mbsr_allocator *allocator,
                   mbsr_sid_text **text, mbsr_error *error)
{
    const mbsr_allocator standard = {.allocate = NULL};
    mbsr_flex_def d;
    if (text) *text = NULL;
    if (!flex || !text)
        return mbsri_fail_plain(error, MBSR_ERR_NULL, "mbsr_sid_write: %s is NULL",
                                !flex ? "flex" : "text");
    if (!allocator) allocator = &standard;
    if (!allocator->allocate != !allocator->release)
        return mbsri_fail_plain(error, MBSR_ERR_VALUE,
                                "mbsr_sid_write: allocator has one of its two functions only");
    (void)mbsr_flex_definition(flex, &d);
    if (d.dependent > 0)
        return mbsri_fail_plain(
            error, MBSR_ERR_VALUE,
            "mbsr_sid_write: the data have %d dependent shapes; geometric stiffening is "
            "not written",
            d.dependent);
    mbsri_arena arena;
    mbsri_arena_open(&arena, allocator);
    writer w = {.d = &d};
    put_file(&w, name ? name : "body");
    const size_t size = w.text.used;
    full_text *full = mbsri_arena_take(&arena, sizeof *full);
    char *memory = mbsri_arena_take(&arena, size + 1);
    if (!memory) {
        mbsri_arena_close(&arena);
        return mbsri_fail_plain(error, MBSR_ERR_NO_MEMORY,
                                "mbsr_sid_write: no memory for %zu bytes", size);
    }
    w = (writer){.text = {.text = memory, .size = size + 1}, .d = &d};
    put_file(&w, name ? name : "body");
    full->text = (mbsr_sid_text){.text = memory, .size = size};
    full->arena = arena;
    *text = &full->text;
    return MBSR_OK;
}

void mbsr_sid_text_destroy(mbsr_sid_text *text)
{
    if (!text) return;
    mbsri_arena arena = ((full_text *)(void *)text)->arena;
    mbsri_arena_close(&arena);
}
