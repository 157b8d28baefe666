/* The model that is reduced: see body.h.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "fe/body.h"

#include "algebra/dense.h"
#include "fe/error.h"

#include <math.h>
#include <stdlib.h>

/* Id of the node at a place. */
static int fe_id(const mbsri_fe_body *body, int node)
{
    return body->def->id ? body->def->id[node] : node;
}

const char *mbsri_fe_label(const mbsri_fe_body *body, int dof, char *buffer)
{
    snprintf(buffer, MBSRI_FE_LABEL, "dof %d (node %d, direction %d)", dof,
             fe_id(body, body->node[dof]), body->direction[dof]);
    return buffer;
}

static int no_memory_for_body(const mbsri_fe_body *body)
{
    return mbsri_fe_fail(body->error, MBSR_ERR_NO_MEMORY,
                         "mbsr_fe_reduce: no memory for %d nodes and %d dofs", body->nodes,
                         body->n);
}

/* ---- nodes ---- */

typedef struct place {
    int id, at;
} place;

static int by_id(const void *a, const void *b)
{
    const place *p = a, *q = b;
    return p->id != q->id ? (p->id > q->id) - (p->id < q->id) : (p->at > q->at) - (p->at < q->at);
}

/* Place of a node in def->x; -1: there is none of this id. */
static int find_node(const mbsri_fe_body *body, const place *sorted, int id)
{
    if (!sorted) return id >= 0 && id < body->nodes ? id : -1;
    int low = 0, high = body->nodes - 1;
    while (low <= high) {
        const int middle = low + (high - low) / 2;
        if (sorted[middle].id == id) return sorted[middle].at;
        if (sorted[middle].id < id)
            low = middle + 1;
        else
            high = middle - 1;
    }
    return -1;
}

static int check_nodes(mbsri_fe_body *body, place **sorted)
{
    const mbsr_fe_def *def = body->def;
    *sorted = NULL;
    for (int k = 0; k < body->nodes; ++k) {
        const double *x = def->x + 3 * (size_t)k;
        if (!isfinite(x[0]) || !isfinite(x[1]) || !isfinite(x[2]))
            return MBSRI_FE_REFUSE("node %d is at (%g, %g, %g)", fe_id(body, k), x[0], x[1], x[2]);
    }
    if (!def->id) return MBSR_OK;
    *sorted = mbsri_arena_take(body->arena, (size_t)body->nodes * sizeof **sorted);
    if (!*sorted) return no_memory_for_body(body);
    for (int k = 0; k < body->nodes; ++k) (*sorted)[k] = (place){def->id[k], k};
    qsort(*sorted, (size_t)body->nodes, sizeof **sorted, by_id);
    for (int k = 1; k < body->nodes; ++k) {
        if ((*sorted)[k].id == (*sorted)[k - 1].id)
            return MBSRI_FE_REFUSE("node %d is there twice, as node[%d] and node[%d]",
                                   (*sorted)[k].id, (*sorted)[k - 1].at, (*sorted)[k].at);
    }
    return MBSR_OK;
}

/* ---- dofs ---- */

static int name_dofs(mbsri_fe_body *body, const place *sorted)
{
    const mbsr_fe_def *def = body->def;
    const int each = body->n / body->nodes;
    if (!def->dof_node && (body->n % body->nodes != 0 || (each != 3 && each != 6)))
        return MBSRI_FE_REFUSE(
            "K has %d rows for %d nodes, neither 3 nor 6 a node; say in dof_node "
            "and dof_direction what they are",
            body->n, body->nodes);
    for (int k = 0; k < body->n; ++k) {
        body->node[k] = def->dof_node ? find_node(body, sorted, def->dof_node[k]) : k / each;
        body->direction[k] = def->dof_node ? def->dof_direction[k] : k % each;
        if (body->node[k] < 0)
            return MBSRI_FE_REFUSE("dof_node[%d] is %d, and there is no such node", k,
                                   def->dof_node[k]);
        if (body->direction[k] < 0 || body->direction[k] > 5)
            return MBSRI_FE_REFUSE("dof_direction[%d] is %d, must be 0 .. 5", k,
                                   body->direction[k]);
    }
    return MBSR_OK;
}

/* Each node has its three displacements once, and three rotations or none. */
static int map_dofs(mbsri_fe_body *body)
{
    for (size_t k = 0; k < 6 * (size_t)body->nodes; ++k) body->dof[k] = -1;
    for (int k = 0; k < body->n; ++k) {
        int *at = body->dof + 6 * (size_t)body->node[k] + body->direction[k];
        if (*at >= 0)
            return MBSRI_FE_REFUSE("dofs %d and %d are both direction %d of node %d", *at, k,
                                   body->direction[k], fe_id(body, body->node[k]));
        *at = k;
    }
    for (int k = 0; k < body->nodes; ++k) {
        const int *at = body->dof + 6 * (size_t)k;
        for (int half = 0; half < 6; half += 3) {
            int count = 0, missing = half;
            for (int c = half; c < half + 3; ++c) {
                count += at[c] >= 0;
                if (at[c] < 0) missing = c;
            }
            if (count == 3 || (count == 0 && (half == 3 || at[3] < 0))) continue;
            return MBSRI_FE_REFUSE("node %d has no dof of direction %d, but others; K is wanted "
                                   "of the free body, without dofs that are held",
                                   fe_id(body, k), missing);
        }
    }
    return MBSR_OK;
}

/* ---- markers ---- */

/* S (3 x 3, symmetric) <- S^-1; false: it has none. */
static bool invert_3x3(double S[9])
{
    double C[9];
    for (int j = 0; j < 3; ++j) {
        const int k = (j + 1) % 3, l = (j + 2) % 3;
        for (int i = 0; i < 3; ++i) {
            const int m = (i + 1) % 3, o = (i + 2) % 3;
            C[3 * j + i] = S[3 * k + m] * S[3 * l + o] - S[3 * k + o] * S[3 * l + m];
        }
    }
    const double determinant = S[0] * C[0] + S[1] * C[1] + S[2] * C[2],
                 size = (S[0] + S[4] + S[8]) / 3.0;
    if (!(determinant > 1e-12 * size * size * size)) return false;
    for (int k = 0; k < 9; ++k) S[k] = C[k] / determinant;
    return true;
}

static const char *name_of_marker(const mbsri_fe_body *body, int marker)
{
    const char *name = body->def->marker[marker].name;
    return name ? name : "";
}

/* Nodes of a marker and their mean; x still in the coordinates of the caller. */
static int see_marker(mbsri_fe_body *body, const place *sorted, int k)
{
    const mbsr_fe_marker *given = body->def->marker + k;
    mbsri_fe_marker *marker = body->marker + k;
    if (given->nodes < 1 || !given->node)
        return MBSRI_FE_REFUSE("marker[%d] '%s' has %d nodes", k, name_of_marker(body, k),
                               given->node ? given->nodes : 0);
    marker->nodes = given->nodes;
    marker->node = mbsri_arena_take(body->arena, (size_t)given->nodes * sizeof *marker->node);
    if (!marker->node) return no_memory_for_body(body);
    for (int l = 0; l < given->nodes; ++l) {
        const int at = marker->node[l] = find_node(body, sorted, given->node[l]);
        if (at < 0 || body->dof[6 * (size_t)at] < 0)
            return MBSRI_FE_REFUSE("marker[%d] '%s' names node %d, which %s", k,
                                   name_of_marker(body, k), given->node[l],
                                   at < 0 ? "is not there" : "has no dofs");
        for (int c = 0; c < 3; ++c)
            marker->x[c] += body->def->x[3 * (size_t)at + (size_t)c] / given->nodes;
    }
    marker->turns = given->nodes > 1 || body->dof[6 * (size_t)marker->node[0] + 3] >= 0;
    if (k == 0 && !marker->turns)
        return MBSRI_FE_REFUSE("marker[0] '%s', the root, is one node without rotations; take the "
                               "average of three or more nodes around it",
                               name_of_marker(body, k));
    return MBSR_OK;
}

static int measure_set(mbsri_fe_body *body, int k)
{
    mbsri_fe_marker *marker = body->marker + k;
    if (marker->nodes == 1) return MBSR_OK;
    for (int l = 0; l < marker->nodes; ++l) {
        const double *x = body->x + 3 * (size_t)marker->node[l];
        const double d[3] = {x[0] - marker->x[0], x[1] - marker->x[1], x[2] - marker->x[2]};
        const double square = mbsri_dot(3, d, d);
        for (int a = 0; a < 3; ++a) {
            marker->S[4 * a] += square;
            for (int b = 0; b < 3; ++b) marker->S[3 * a + b] -= d[a] * d[b];
        }
    }
    if (invert_3x3(marker->S)) return MBSR_OK;
    return MBSRI_FE_REFUSE("the %d nodes of marker[%d] '%s' lie on a line, so that its rotation is "
                           "not determined; add a node beside it",
                           marker->nodes, k, name_of_marker(body, k));
}

static int see_markers(mbsri_fe_body *body, const place *sorted)
{
    int status = MBSR_OK;
    for (int k = 0; k < body->markers && !status; ++k) status = see_marker(body, sorted, k);
    if (status) return status;
    double root[3];
    mbsri_copy(3, body->marker[0].x, root);
    for (int k = 0; k < body->nodes; ++k) {
        for (int c = 0; c < 3; ++c)
            body->x[3 * (size_t)k + (size_t)c] = body->def->x[3 * (size_t)k + (size_t)c] - root[c];
    }
    for (int k = 0; k < body->markers && !status; ++k) {
        for (int c = 0; c < 3; ++c) body->marker[k].x[c] -= root[c];
        status = measure_set(body, k);
    }
    return status;
}

/* a x b */
static void cross_product(const double a[3], const double b[3], double c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* S v, S 3 x 3 symmetric */
static void multiply_3x3(const double S[9], const double v[3], double w[3])
{
    for (int c = 0; c < 3; ++c) w[c] = mbsri_dot(3, S + 3 * c, v);
}

void mbsri_fe_motion(const mbsri_fe_body *body, int k, const double *u, double motion[6])
{
    const mbsri_fe_marker *marker = body->marker + k;
    double sum[3] = {0.0, 0.0, 0.0};
    mbsri_zero(6, motion);
    for (int l = 0; l < marker->nodes; ++l) {
        const int *dof = body->dof + 6 * (size_t)marker->node[l];
        const double *x = body->x + 3 * (size_t)marker->node[l];
        const double d[3] = {x[0] - marker->x[0], x[1] - marker->x[1], x[2] - marker->x[2]};
        const double move[3] = {u[dof[0]], u[dof[1]], u[dof[2]]};
        double moment[3];
        cross_product(d, move, moment);
        for (int c = 0; c < 3; ++c) {
            motion[3 + c] += move[c] / marker->nodes;
            sum[c] += moment[c];
            if (marker->nodes == 1 && marker->turns) motion[c] = u[dof[3 + c]];
        }
    }
    if (marker->nodes > 1) multiply_3x3(marker->S, sum, motion);
}

void mbsri_fe_load(const mbsri_fe_body *body, int k, const double load[6], double *f)
{
    const mbsri_fe_marker *marker = body->marker + k;
    double w[3];
    multiply_3x3(marker->S, load, w);
    for (int l = 0; l < marker->nodes; ++l) {
        const int *dof = body->dof + 6 * (size_t)marker->node[l];
        const double *x = body->x + 3 * (size_t)marker->node[l];
        const double d[3] = {x[0] - marker->x[0], x[1] - marker->x[1], x[2] - marker->x[2]};
        double force[3] = {0.0, 0.0, 0.0};
        if (marker->nodes > 1) cross_product(w, d, force);
        for (int c = 0; c < 3; ++c) {
            f[dof[c]] += load[3 + c] / marker->nodes + force[c];
            if (marker->nodes == 1 && marker->turns) f[dof[3 + c]] += load[c];
        }
    }
}

/* ---- rigid motions ---- */

static void fill_rigid(mbsri_fe_body *body)
{
    const size_t n = (size_t)body->n;
    for (int k = 0; k < body->n; ++k) {
        const double *x = body->x + 3 * (size_t)body->node[k];
        const int c = body->direction[k];
        for (int a = 0; a < 3; ++a) {
            const double axis[3] = {a == 0, a == 1, a == 2};
            double move[3];
            cross_product(axis, x, move);
            body->T[n * (size_t)a + (size_t)k] = c < 3 ? move[c] : axis[c - 3];
            body->T[n * (size_t)(3 + a) + (size_t)k] = c < 3 ? axis[c] : 0.0;
        }
    }
}

/* A rigid motion costs no force: beside |A| |T|. */
static int check_free(mbsri_fe_body *body, const char *name, const mbsri_sparse *A, double *largest)
{
    static const char *const motion[6] = {"rotation about x",    "rotation about y",
                                          "rotation about z",    "translation along x",
                                          "translation along y", "translation along z"};
    const size_t n = (size_t)body->n;
    double *f = mbsri_arena_take(body->arena, n * sizeof *f),
           *size = mbsri_arena_take(body->arena, n * sizeof *size);
    if (!size) return no_memory_for_body(body);
    *largest = 0.0;
    for (int c = 0; c < 6; ++c) {
        const double *t = body->T + n * (size_t)c;
        double most = 0.0;
        int worst = 0;
        mbsri_sparse_multiply(A, 1, t, f);
        mbsri_sparse_multiply_sizes(A, t, size);
        for (int k = 0; k < body->n; ++k) {
            most = fmax(most, size[k]);
            if (fabs(f[k]) > fabs(f[worst])) worst = k;
        }
        if (most > 0.0) *largest = fmax(*largest, fabs(f[worst]) / most);
        char label[MBSRI_FE_LABEL];
        if (fabs(f[worst]) > body->def->rigid * most)
            return MBSRI_FE_REFUSE("%s is grounded: a rigid %s gives a force at %s, %.2g of the "
                                   "largest of |%s| |u|, more than def.rigid, %.2g; supports and "
                                   "springs to ground do not belong into it",
                                   name, motion[c], mbsri_fe_label(body, worst, label),
                                   fabs(f[worst]) / most, name, body->def->rigid);
    }
    return MBSR_OK;
}

static int build_matrices(mbsri_fe_body *body)
{
    const mbsr_fe_def *def = body->def;
    const mbsr_fe_matrix *given[3] = {&def->K, &def->M, &def->D};
    mbsri_sparse *const A[3] = {&body->K, &body->M, &body->D};
    static const char *const name[3] = {"K", "M", "D"};
    for (int k = 0; k < 3; ++k) {
        if (k == 2 && given[k]->rows == 0) continue;
        const int status = mbsri_sparse_build(body->arena, name[k], given[k], A[k], body->error);
        if (status) return status;
        if (A[k]->n != body->K.n)
            return MBSRI_FE_REFUSE("K has %d rows, %s %d", body->K.n, name[k], A[k]->n);
    }
    body->n = body->K.n;
    return MBSR_OK;
}

int mbsri_fe_body_make(mbsri_fe_body *body)
{
    place *sorted;
    double ignored;
    body->nodes = body->def->nodes;
    body->markers = body->def->markers;
    int status = build_matrices(body);
    if (status) return status;
    const size_t n = (size_t)body->n, nodes = (size_t)body->nodes;
    body->node = mbsri_arena_take(body->arena, n * sizeof *body->node);
    body->direction = mbsri_arena_take(body->arena, n * sizeof *body->direction);
    body->dof = mbsri_arena_take(body->arena, 6 * nodes * sizeof *body->dof);
    body->x = mbsri_arena_take(body->arena, 3 * nodes * sizeof *body->x);
    body->T = mbsri_arena_take(body->arena, 6 * n * sizeof *body->T);
    body->marker = mbsri_arena_take(body->arena, (size_t)body->markers * sizeof *body->marker);
    if (!body->marker) return no_memory_for_body(body);
    status = check_nodes(body, &sorted);
    if (!status) status = name_dofs(body, sorted);
    if (!status) status = map_dofs(body);
    if (!status) status = see_markers(body, sorted);
    if (status) return status;
    fill_rigid(body);
    status = check_free(body, "K", &body->K, &body->rigid);
    if (!status && body->D.n > 0) status = check_free(body, "D", &body->D, &ignored);
    return status;
}
