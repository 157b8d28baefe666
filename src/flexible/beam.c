/* Modal data of a beam: see flex.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Mass off the axis, at +-sqrt(2) radius, a quarter at each of four points of the section, gives
 * the section its moments; so all integrals are those of one field over one mass. */
#include "flexible/beam_modes.h"
#include "flexible/beam_shortening.h"

#include "algebra/dense.h"
#include "algebra/space3.h"
#include "base/cookie.h"
#include "base/error.h"
#include "base/memory.h"

#include <math.h>

mbsr_beam_def mbsr_default_beam_def(void)
{
    return (mbsr_beam_def){
        .cookie = MBSRI_COOKIE, .elements = 15, .modes = 4, .frequency = INFINITY};
}

enum { POINTS = MBSRI_BEAM_POINTS, MOST_ELEMENTS = 40 };

#define REFUSE(status, ...) mbsri_fail(error, status, MBSR_NONE, MBSR_NONE, __VA_ARGS__)

/* ---- what is given ---- */

static int check_section(const mbsr_beam_def *def, mbsr_error *error)
{
    const struct {
        const char *name;
        double value;
    } field[] = {
        {"length", def->length},     {"density", def->density},   {"EA", def->EA},
        {"EI_y", def->EI_y},         {"EI_z", def->EI_z},         {"GJ", def->GJ},
        {"radius_y", def->radius_y}, {"radius_z", def->radius_z}, {"tip_mass", def->tip_mass},
        {"damping", def->damping}};
    for (size_t k = 0; k < sizeof field / sizeof *field; ++k) {
        if (field[k].value >= 0.0 && isfinite(field[k].value) && (k > 0 || field[k].value > 0.0))
            continue;
        return REFUSE(MBSR_ERR_VALUE, "mbsr_flex_beam: %s is %g, must be finite and %s",
                      field[k].name, field[k].value, k == 0 ? "positive" : "not negative");
    }
    if (def->stiffening != 0 && def->stiffening != 1)
        return REFUSE(MBSR_ERR_VALUE, "mbsr_flex_beam: stiffening is %d, must be 0 or 1",
                      def->stiffening);
    if (!(def->frequency >= 0.0) || !(def->cutoff >= 0.0))
        return REFUSE(MBSR_ERR_VALUE,
                      "mbsr_flex_beam: frequency is %g, cutoff %g; neither may be negative",
                      def->frequency, def->cutoff);
    return MBSR_OK;
}

static int check_beam(const mbsr_beam_def *def, mbsr_error *error)
{
    if (def->cookie != MBSRI_COOKIE)
        return REFUSE(MBSR_ERR_NO_DEFAULT,
                      "mbsr_flex_beam: def was not made by mbsr_default_beam_def");
    if (def->elements < 1 || def->elements > MOST_ELEMENTS)
        return REFUSE(MBSR_ERR_VALUE, "mbsr_flex_beam: elements is %d, must be 1 .. %d",
                      def->elements, MOST_ELEMENTS);
    if (def->modes < 0 || def->loaded < 0 || def->loaded > def->elements ||
        def->modes + MBSRI_BEAM_NODE * def->loaded > MBSR_MAX_MODES)
        return REFUSE(MBSR_ERR_VALUE,
                      "mbsr_flex_beam: modes is %d, loaded is %d; neither may be negative, and six "
                      "modes for each loaded node with them at most %d",
                      def->modes, def->loaded, MBSR_MAX_MODES);
    if (def->loaded > 0 && !def->node)
        return REFUSE(MBSR_ERR_NULL, "mbsr_flex_beam: node is NULL, but loaded is %d", def->loaded);
    for (int k = 0; k < def->loaded; ++k) {
        if (def->node[k] < 1 || def->node[k] > def->elements)
            return REFUSE(MBSR_ERR_VALUE, "mbsr_flex_beam: node[%d] is %d, must be 1 .. %d", k,
                          def->node[k], def->elements);
    }
    if (!def->allocator.allocate != !def->allocator.release)
        return REFUSE(MBSR_ERR_VALUE,
                      "mbsr_flex_beam: allocator has one of its two functions only");
    return check_section(def, error);
}

/* ---- elements ---- */

/* Where in the section's plane the mass is, in radii, and how much of it. */
static int section(const mbsr_beam_def *def, double offset[4][3])
{
    const double y = sqrt(2.0) * def->radius_y, z = sqrt(2.0) * def->radius_z;
    const double at[4][2] = {{y, 0.0}, {-y, 0.0}, {0.0, z}, {0.0, -z}};
    const int points = y == 0.0 && z == 0.0 ? 1 : 4;
    for (int k = 0; k < points; ++k) {
        offset[k][0] = 0.0;
        offset[k][1] = at[k][0], offset[k][2] = at[k][1];
    }
    return points;
}

/* A point of quadrature in element e: weight (m), x (m), and displacement and rotation there in
 * terms of the 12 dofs of the element. */
typedef struct beam_point {
    double weight, x;
    double shift[3][12], turn[3][12];
} beam_point;

static void point_of(const mbsr_beam_def *def, int e, int k, beam_point *point)
{
    const double h = def->length / def->elements;
    double weight, N[4], slope[4];
    const double z = mbsri_gauss(k, &weight);
    *point = (beam_point){.weight = weight * h, .x = h * (e + z)};
    mbsri_hermite(z, h, 0, N);
    mbsri_hermite(z, h, 1, slope);
    point->shift[0][0] = point->turn[0][3] = 1.0 - z;
    point->shift[0][6] = point->turn[0][9] = z;
    for (int l = 0; l < 4; ++l) {
        point->shift[1][mbsri_bends_z[l]] = N[l];
        point->turn[2][mbsri_bends_z[l]] = slope[l];
        point->shift[2][mbsri_bends_y[l]] = mbsri_bends_y_sign[l] * N[l];
        point->turn[1][mbsri_bends_y[l]] = -mbsri_bends_y_sign[l] * slope[l];
    }
}

/* Place of a dof among the free ones; -1: it is none. */
static int index_of_dof(const mbsri_beam *b, int dof)
{
    for (int k = 0; k < b->free; ++k) {
        if (b->dof[k] == dof) return k;
    }
    return -1;
}

/* A += factor x x^T, x over the dofs of element e. */
static void add_square(const mbsri_beam *b, int e, double factor, const double x[12], double *A)
{
    int at[12];
    for (int k = 0; k < 12; ++k)
        at[k] = x[k] != 0.0 ? index_of_dof(b, MBSRI_BEAM_NODE * e + k) : -1;
    for (int j = 0; j < 12; ++j) {
        for (int k = 0; k < 12 && at[j] >= 0; ++k) {
            if (at[k] >= 0) A[at[j] * b->free + at[k]] += factor * x[j] * x[k];
        }
    }
}

/* Displacement at a point off the axis: shift + turn x offset. */
static void displacement_at(const beam_point *point, const double offset[3], double N[3][12])
{
    for (int c = 0; c < 12; ++c) {
        const double turn[3] = {point->turn[0][c], point->turn[1][c], point->turn[2][c]};
        double x[3];
        mbsri_cross3(turn, offset, x);
        for (int k = 0; k < 3; ++k) N[k][c] = point->shift[k][c] + x[k];
    }
}

static void add_point(mbsri_beam *b, int e, int k)
{
    const mbsr_beam_def *def = b->def;
    const double h = def->length / def->elements;
    double weight, curvature[4], y[12] = {0.0}, z[12] = {0.0}, offset[4][3], N[3][12];
    const double stretch[12] = {[0] = -1.0 / h, [6] = 1.0 / h},
                 twist[12] = {[3] = -1.0 / h, [9] = 1.0 / h};
    beam_point point;
    mbsri_hermite(mbsri_gauss(k, &weight), h, 2, curvature);
    point_of(def, e, k, &point);
    for (int l = 0; l < 4; ++l) {
        z[mbsri_bends_z[l]] = curvature[l];
        y[mbsri_bends_y[l]] = mbsri_bends_y_sign[l] * curvature[l];
    }
    add_square(b, e, point.weight * def->EA, stretch, b->K);
    add_square(b, e, point.weight * def->GJ, twist, b->K);
    add_square(b, e, point.weight * def->EI_z, z, b->K);
    add_square(b, e, point.weight * def->EI_y, y, b->K);
    const int points = section(def, offset);
    for (int l = 0; l < points; ++l) {
        displacement_at(&point, offset[l], N);
        for (int r = 0; r < 3; ++r)
            add_square(b, e, point.weight * def->density / points, N[r], b->M);
    }
}

static void assemble(mbsri_beam *b)
{
    const mbsr_beam_def *def = b->def;
    const double stiffness[6] = {def->EA, def->EI_z, def->EI_y, def->GJ, def->EI_y, def->EI_z};
    b->free = 0;
    for (int k = MBSRI_BEAM_NODE; k < b->dofs; ++k) {
        if (stiffness[k % MBSRI_BEAM_NODE] > 0.0) b->dof[b->free++] = k;
    }
    mbsri_zero((size_t)b->free * (size_t)b->free, b->K);
    mbsri_zero((size_t)b->free * (size_t)b->free, b->M);
    for (int e = 0; e < def->elements; ++e) {
        for (int k = 0; k < POINTS; ++k) add_point(b, e, k);
    }
    for (int k = 0; k < 3; ++k) {
        const int at = index_of_dof(b, b->dofs - MBSRI_BEAM_NODE + k);
        if (at >= 0) b->M[at * (b->free + 1)] += def->tip_mass;
    }
}

/* ---- modal data ---- */

typedef struct sums {
    mbsr_flex_def def;
    int shapes;                         /* modes and shortening */
    double *Ct0, *P0, *P, *K, *D, *Phi; /* Phi: 3 shapes at a point, 0 of massless modes */
    double *at_nodes;                   /* 6 shapes each */
    mbsr_flex_marker *marker;
    mbsri_beam_shortening by;
} sums;

/* Adds mass m at x, where the modes displace by s->Phi. */
static void add_beam_mass(double m, const double x[3], sums *s)
{
    const int rows = 3 * s->shapes;
    s->def.mass += m;
    for (int j = 0; j < 3; ++j) {
        s->def.c0[j] += m * x[j];
        for (int k = 0; k < 3; ++k) s->def.N0[3 * j + k] += m * x[j] * x[k];
    }
    for (int j = 0; j < rows; ++j) {
        const double share = m * s->Phi[j];
        s->Ct0[j] += share;
        for (int k = 0; k < 3; ++k) s->P0[3 * j + k] += share * x[k];
        for (int k = 0; k < rows; ++k)
            s->P[(size_t)j * (size_t)rows + (size_t)k] += share * s->Phi[k];
    }
}

/* Phi of all shapes that have mass at sample j of element e, N times its dofs. */
static void place_shapes(const mbsri_beam *b, int e, int j, double N[3][12], sums *s)
{
    for (int k = 0; k < s->by.count; ++k)
        s->Phi[3 * (b->modes + k)] = s->by.at[s->by.samples * k + MBSRI_BEAM_SAMPLES * e + j];
    for (int a = 0; a < b->modes; ++a) {
        const double *mode = b->mode + (size_t)b->dofs * (size_t)a + MBSRI_BEAM_NODE * e;
        for (int r = 0; r < 3; ++r)
            s->Phi[3 * a + r] = b->flexibility[a] > 0.0 ? mbsri_dot(12, N[r], mode) : 0.0;
    }
}

static void integrate(const mbsri_beam *b, sums *s)
{
    const mbsr_beam_def *def = b->def;
    double offset[4][3], N[3][12] = {{[6] = 1.0}, {[7] = 1.0}, {[8] = 1.0}};
    const int points = section(def, offset);
    const double end[3] = {def->length, 0.0, 0.0};
    place_shapes(b, def->elements - 1, POINTS, N, s);
    add_beam_mass(def->tip_mass, end, s);
    for (int e = 0; e < def->elements; ++e) {
        for (int k = 0; k < POINTS; ++k) {
            beam_point point;
            point_of(def, e, k, &point);
            for (int l = 0; l < points; ++l) {
                const double x[3] = {point.x, offset[l][1], offset[l][2]};
                displacement_at(&point, offset[l], N);
                place_shapes(b, e, k, N, s);
                add_beam_mass(point.weight * def->density / points, x, s);
            }
        }
    }
}

/* Modes with mass get M = 1, K = omega^2; the others stay at K = 1, without mass. */
static void scale_modes(mbsri_beam *b)
{
    const double cutoff = b->def->cutoff;
    for (int a = 0; a < b->modes; ++a) {
        double *mu = b->flexibility + a;
        if (a >= b->normal && (*mu * cutoff * cutoff < 1.0 || cutoff == 0.0)) *mu = 0.0;
        const double scale = *mu > 0.0 ? 1.0 / sqrt(*mu) : 1.0;
        double *mode = b->mode + (size_t)b->dofs * (size_t)a;
        for (int k = 0; k < b->dofs; ++k) mode[k] *= scale;
    }
}

static void fill_stiffness(const mbsri_beam *b, sums *s)
{
    double highest = isfinite(b->def->cutoff) ? b->def->cutoff : 0.0;
    for (int a = 0; a < b->modes; ++a) {
        if (b->flexibility[a] > 0.0) highest = fmax(highest, 1.0 / sqrt(b->flexibility[a]));
    }
    for (int a = 0; a < b->modes; ++a) {
        const double mu = b->flexibility[a], zeta = b->def->damping;
        const int at = a * (b->modes + 1);
        s->K[at] = mu > 0.0 ? 1.0 / mu : 1.0;
        s->D[at] = mu > 0.0 ? 2.0 * zeta / sqrt(mu) : highest > 0.0 ? 2.0 * zeta / highest : zeta;
    }
}

static void fill_markers(const mbsri_beam *b, sums *s)
{
    const int n = b->modes;
    const mbsri_beam_shortening *by = &s->by;
    for (int k = 0; k <= b->def->elements; ++k) {
        double *Phi = s->at_nodes + 6 * (size_t)s->shapes * (size_t)k, *Psi = Phi + 3 * s->shapes;
        for (int l = 0; l < by->count && k > 0; ++l)
            Phi[3 * (n + l)] = by->at[by->samples * l + MBSRI_BEAM_SAMPLES * k - 1];
        for (int a = 0; a < n; ++a) {
            const double *node =
                b->mode + (size_t)b->dofs * (size_t)a + MBSRI_BEAM_NODE * (size_t)k;
            mbsri_copy(3, node, Phi + 3 * a);
            mbsri_copy(3, node + 3, Psi + 3 * a);
        }
        s->marker[k] = (mbsr_flex_marker){
            .frame = mbsr_frame_at(b->def->length * k / b->def->elements, 0.0, 0.0),
            .Phi = Phi,
            .Psi = Psi};
    }
}

/* Places arrays one after the other; NULL: only counts. */
static double *next_numbers(double *memory, size_t *used, size_t count)
{
    double *here = memory ? memory + *used : NULL;
    *used += count;
    return here;
}

static size_t lay_out_modes(mbsri_beam *b, double *memory)
{
    const size_t dofs = (size_t)b->dofs, n = (size_t)b->most;
    size_t used = 0;
    b->K = next_numbers(memory, &used, dofs * dofs);
    b->M = next_numbers(memory, &used, dofs * dofs);
    b->mode = next_numbers(memory, &used, dofs * n);
    b->flexibility = next_numbers(memory, &used, n);
    b->work =
        next_numbers(memory, &used, mbsri_beam_work(b->dofs, MBSRI_BEAM_NODE * b->def->loaded));
    return used;
}

static size_t lay_out_sums(const mbsri_beam *b, sums *s, double *memory)
{
    const size_t n = (size_t)b->modes, m = (size_t)s->shapes,
                 nodes = (size_t)b->dofs / MBSRI_BEAM_NODE;
    size_t used = 0;
    s->Ct0 = next_numbers(memory, &used, 3 * m);
    s->P0 = next_numbers(memory, &used, 9 * m);
    s->P = next_numbers(memory, &used, 9 * m * m);
    s->K = next_numbers(memory, &used, n * n);
    s->D = next_numbers(memory, &used, n * n);
    s->by.Y = next_numbers(memory, &used, n * n * (m - n));
    s->Phi = next_numbers(memory, &used, 3 * m);
    s->at_nodes = next_numbers(memory, &used, 6 * m * nodes);
    s->marker = (mbsr_flex_marker *)next_numbers(
        memory, &used, (nodes * sizeof *s->marker + sizeof *memory - 1) / sizeof *memory);
    if (memory) mbsri_zero(used, memory);
    return used;
}

#define NO_MEMORY(b)                                                                               \
    REFUSE(MBSR_ERR_NO_MEMORY, "mbsr_flex_beam: no memory for %d elements", (b)->def->elements)

/* The data of the modes and of the shortening; memory: of mbsri_beam_shorten. */
static int create_beam_data(const mbsri_beam *b, const double *memory, sums *s, mbsr_flex **flex,
                            mbsr_error *error)
{
    s->shapes = b->modes + s->by.count;
    if (s->shapes > MBSR_MAX_MODES || b->modes * s->by.count > MBSR_MAX_DEPENDENCES)
        return REFUSE(MBSR_ERR_VALUE,
                      "mbsr_flex_beam: stiffening takes %d dependent shapes for %d modes; both "
                      "together may be %d, their product %d: take fewer modes",
                      s->by.count, b->modes, MBSR_MAX_MODES, MBSR_MAX_DEPENDENCES);
    double *sums_at =
        mbsri_allocate(&b->def->allocator, lay_out_sums(b, s, NULL) * sizeof *sums_at);
    if (!sums_at) return NO_MEMORY(b);
    lay_out_sums(b, s, sums_at);
    if (memory) mbsri_beam_dependences(b, memory, &s->by);
    s->def = mbsr_default_flex_def();
    s->def.modes = b->modes, s->def.dependent = s->by.count;
    integrate(b, s);
    fill_stiffness(b, s);
    fill_markers(b, s);
    s->def.Ct0 = s->Ct0, s->def.P0 = s->P0, s->def.P = s->P, s->def.Y = s->by.Y;
    s->def.K = s->K, s->def.D = s->D;
    s->def.markers = b->def->elements + 1, s->def.marker = s->marker;
    s->def.allocator = b->def->allocator;
    const int status = mbsr_flex_create(&s->def, flex, error);
    mbsri_release(&b->def->allocator, sums_at);
    return status;
}

static int create_stiffening(const mbsri_beam *b, sums *s, mbsr_flex **flex, mbsr_error *error)
{
    double *memory =
        mbsri_allocate(&b->def->allocator, mbsri_beam_shortening_size(b) * sizeof *memory);
    if (!memory) return NO_MEMORY(b);
    int status = mbsri_beam_shorten(b, memory, &s->by);
    if (status)
        REFUSE(status, "mbsr_flex_beam: the shapes of its shortening did not converge");
    else
        status = create_beam_data(b, memory, s, flex, error);
    mbsri_release(&b->def->allocator, memory);
    return status;
}

static int make_beam(mbsri_beam *b, mbsr_flex **flex, mbsr_error *error)
{
    sums s = {.shapes = 0};
    assemble(b);
    const int status = mbsri_beam_find_modes(b);
    if (status)
        return REFUSE(status,
                      "mbsr_flex_beam: the %s of the beam; are its stiffnesses and its length "
                      "in one system of units?",
                      status == MBSR_ERR_VALUE ? "stiffness matrix is not positive definite"
                                               : "frequencies did not converge");
    scale_modes(b);
    return b->def->stiffening ? create_stiffening(b, &s, flex, error)
                              : create_beam_data(b, NULL, &s, flex, error);
}

int mbsr_flex_beam(const mbsr_beam_def *def, mbsr_flex **flex, mbsr_error *error)
{
    if (flex) *flex = NULL;
    if (!def || !flex)
        return REFUSE(MBSR_ERR_NULL, "mbsr_flex_beam: %s is NULL", !def ? "def" : "flex");
    int status = check_beam(def, error);
    if (status) return status;
    int dof[MBSRI_BEAM_NODE * (MOST_ELEMENTS + 1)];
    mbsri_beam b = {.def = def,
                    .dofs = MBSRI_BEAM_NODE * (def->elements + 1),
                    .dof = dof,
                    .most = def->modes + MBSRI_BEAM_NODE * def->loaded};
    double *memory = mbsri_allocate(&def->allocator, lay_out_modes(&b, NULL) * sizeof *memory);
    if (!memory) return NO_MEMORY(&b);
    lay_out_modes(&b, memory);
    status = make_beam(&b, flex, error);
    mbsri_release(&def->allocator, memory);
    return status;
}
