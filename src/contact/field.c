/* Height fields: see field.h.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Over a cell the surface is that of 4 x 4 control points with the weights of the uniform cubic
 * B-spline, c = h - (second difference of h) / 6 along x and y. Beyond the border samples go on as
 * a parabola. */
#include "contact/field.h"

#include "algebra/space3.h"
#include "contact/error.h"
#include "contact/round.h"

#include <string.h>

enum { FEET = 64 };

/* A point of the surface: height and derivatives, first along x; how much it counts. */
typedef struct spot {
    double x, y, h, d[2], dd[3], ddd[4];
    double share, by[2];
    int cell[2]; /* between -1 and the number of samples less one */
} spot;

/* ---- the spline ---- */

/* Weights of four control points l, w[l], and three derivatives by x. */
static void spline_weights(double f, double cell, double w[4][4])
{
    const double g = 1.0 - f, by = 1.0 / cell, second = by * by, third = second * by;
    w[0][0] = g * g * g / 6.0, w[3][0] = f * f * f / 6.0;
    w[1][0] = 2.0 / 3.0 - f * f * (1.0 - 0.5 * f), w[2][0] = 2.0 / 3.0 - g * g * (1.0 - 0.5 * g);
    w[0][1] = -0.5 * g * g * by, w[3][1] = 0.5 * f * f * by;
    w[1][1] = 0.5 * f * (3.0 * f - 4.0) * by, w[2][1] = -0.5 * g * (3.0 * g - 4.0) * by;
    w[0][2] = g * second, w[3][2] = f * second;
    w[1][2] = (3.0 * f - 2.0) * second, w[2][2] = (3.0 * g - 2.0) * second;
    w[0][3] = -third, w[1][3] = 3.0 * third, w[2][3] = -3.0 * third, w[3][3] = third;
}

/* 1 within the border, 0 from a cell beyond on, and the derivative by the place in cells. */
static double share_of(double u, int samples, double *slope)
{
    const double beyond = u < 0.0 ? -u : u - (samples - 1);
    const double x = beyond > 1.0 ? 1.0 : beyond > 0.0 ? beyond : 0.0;
    *slope = (u < 0.0 ? 6.0 : -6.0) * x * (1.0 - x);
    return (1.0 - x) * (1.0 - x) * (1.0 + 2.0 * x);
}

/* Place of x along one direction in cells. */
static double in_cells(const mbsri_field *f, int along, double x)
{
    return (x + f->half[along]) / f->cell[along];
}

static int cell_of(double u, int samples)
{
    return u >= samples - 1 ? samples - 1 : u > -1.0 ? (int)floor(u) : -1;
}

static void look_at(const mbsri_field *f, double x, double y, spot *s)
{
    const double at[2] = {in_cells(f, 0, x), in_cells(f, 1, y)};
    const int samples[2] = {f->nx, f->ny};
    double w[2][4][4], share[2], slope[2];
    double h = 0.0, d[2] = {0.0}, dd[3] = {0.0}, ddd[4] = {0.0};
    for (int k = 0; k < 2; ++k) {
        s->cell[k] = cell_of(at[k], samples[k]);
        spline_weights(at[k] - s->cell[k], f->cell[k], w[k]);
        share[k] = share_of(at[k], samples[k], slope + k);
        slope[k] /= f->cell[k];
    }
    for (int j = 0; j < 4; ++j) {
        const double *row =
            f->control + (ptrdiff_t)(s->cell[1] + 1 + j) * (f->nx + 4) + s->cell[0] + 1;
        const double *v = w[1][j], (*u)[4] = (const double(*)[4])w[0];
        double along[4];
        for (int k = 0; k < 4; ++k)
            along[k] = row[0] * u[0][k] + row[1] * u[1][k] + row[2] * u[2][k] + row[3] * u[3][k];
        h += v[0] * along[0];
        d[0] += v[0] * along[1], d[1] += v[1] * along[0];
        dd[0] += v[0] * along[2], dd[1] += v[1] * along[1], dd[2] += v[2] * along[0];
        ddd[0] += v[0] * along[3], ddd[1] += v[1] * along[2];
        ddd[2] += v[2] * along[1], ddd[3] += v[3] * along[0];
    }
    s->x = x, s->y = y, s->h = h;
    memcpy(s->d, d, sizeof d);
    memcpy(s->dd, dd, sizeof dd);
    memcpy(s->ddd, ddd, sizeof ddd);
    s->share = share[0] * share[1];
    s->by[0] = slope[0] * share[1];
    s->by[1] = share[0] * slope[1];
}

/* ---- ranges in a cell ---- */

typedef struct range {
    double low, high;
} range;

static void widen_range(range *r, double x)
{
    r->low = x < r->low ? x : r->low;
    r->high = x > r->high ? x : r->high;
}

static range range_product(range a, range b)
{
    range r = {a.low * b.low, a.low * b.low};
    widen_range(&r, a.low * b.high);
    widen_range(&r, a.high * b.low);
    widen_range(&r, a.high * b.high);
    return r;
}

static double most_of(range r)
{
    return r.high > -r.low ? r.high : -r.low;
}

/* Of a cell: heights, slopes and their derivatives lie between those of the control points and
 * their differences. */
typedef struct cell_ranges {
    range h, d[2], dd[3];
} cell_ranges;

static void take_differences(const mbsri_field *f, const double *at, int right, int up,
                             cell_ranges *r)
{
    const ptrdiff_t row = f->nx + 4;
    const double *const cell = f->cell;
    widen_range(&r->h, at[0]);
    if (right > 0) widen_range(r->d, (at[1] - at[0]) / cell[0]);
    if (up > 0) widen_range(r->d + 1, (at[row] - at[0]) / cell[1]);
    if (right > 1) widen_range(r->dd, (at[2] - 2.0 * at[1] + at[0]) / (cell[0] * cell[0]));
    if (right > 0 && up > 0)
        widen_range(r->dd + 1, (at[row + 1] - at[row] - at[1] + at[0]) / (cell[0] * cell[1]));
    if (up > 1) widen_range(r->dd + 2, (at[2 * row] - 2.0 * at[row] + at[0]) / (cell[1] * cell[1]));
}

static cell_ranges ranges_of(const mbsri_field *f, int i, int j)
{
    const range none = {INFINITY, -INFINITY};
    cell_ranges r = {none, {none, none}, {none, none, none}};
    const double *first = f->control + (ptrdiff_t)(j + 1) * (f->nx + 4) + i + 1;
    for (int y = 0; y < 4; ++y, first += f->nx + 4) {
        for (int x = 0; x < 4; ++x) take_differences(f, first + x, 3 - x, 3 - y, &r);
    }
    return r;
}

/* ---- making ---- */

/* Number i of a line of samples that goes on as a parabola, or straight where there are two. */
static double go_on(const double *h, ptrdiff_t stride, int count, int i)
{
    if (i >= 0 && i < count) return h[i * stride];
    const bool end = i >= count;
    const double *from = h + (end ? (count - 1) * stride : 0);
    const ptrdiff_t inward = end ? -stride : stride;
    const double beyond = end ? i - count + 1 : -i, a = from[0], b = from[inward],
                 second = count > 2 ? a - 2.0 * b + from[2 * inward] : 0.0;
    return a + beyond * (a - b) + 0.5 * beyond * (beyond + 1.0) * second;
}

/* The control points i of a line, -2 .. count + 1. */
static double control_of(const double *h, ptrdiff_t stride, int count, int i)
{
    const double at = go_on(h, stride, count, i);
    return at - (go_on(h, stride, count, i - 1) - 2.0 * at + go_on(h, stride, count, i + 1)) / 6.0;
}

/* Along x into `line`, (nx + 4) x ny, then along y. */
static void find_control(mbsri_field *f, const double *h, double *line)
{
    const int wide = f->nx + 4;
    for (int j = 0; j < f->ny; ++j) {
        for (int i = 0; i < wide; ++i)
            line[(ptrdiff_t)j * wide + i] = control_of(h + (ptrdiff_t)j * f->nx, 1, f->nx, i - 2);
    }
    for (int i = 0; i < wide; ++i) {
        for (int j = 0; j < f->ny + 4; ++j)
            f->control[(ptrdiff_t)j * wide + i] = control_of(line + i, wide, f->ny, j - 2);
    }
}

static void find_heights(mbsri_field *f, mbsri_shape *s)
{
    double top = -INFINITY;
    for (int j = 0; j <= f->ny; ++j) {
        for (int i = 0; i <= f->nx; ++i) {
            const cell_ranges r = ranges_of(f, i - 1, j - 1);
            const ptrdiff_t at = (ptrdiff_t)j * (f->nx + 1) + i;
            f->high[at] = r.h.high;
            f->steep[at] = hypot(most_of(r.d[0]), most_of(r.d[1]));
            top = fmax(top, r.h.high);
        }
    }
    s->middle[2] = top;
    for (int k = 0; k < 2; ++k) s->extent[k] = f->half[k] + f->cell[k];
}

/* A sample sticks out of the middle of its neighbours; wholly from a hundredth of the smaller cell
 * on. */
static void find_sticking(mbsri_field *f)
{
    const double least = 0.01 * fmin(f->cell[0], f->cell[1]);
    for (int j = 0; j < f->ny; ++j) {
        for (int i = 0; i < f->nx; ++i) {
            spot s;
            look_at(f, i * f->cell[0] - f->half[0], j * f->cell[1] - f->half[1], &s);
            const double out = -0.25 * (s.dd[0] * f->cell[0] * f->cell[0] +
                                        s.dd[2] * f->cell[1] * f->cell[1]),
                         x = fmin(1.0, fmax(0.0, out / least));
            f->sticks[(ptrdiff_t)j * f->nx + i] = x > 1e-4 ? x * x * (3.0 - 2.0 * x) : 0.0;
        }
    }
}

int mbsri_field_check(const mbsr_shape *from, char text[MBSR_TEXT_SIZE], size_t *bytes)
{
    *bytes = 0;
    if (from->rows < 2 || from->columns < 2 || from->rows > 1 << 13 || from->columns > 1 << 13) {
        mbsri_contact_print(text, MBSR_TEXT_SIZE,
                            "rows is %d, columns is %d, must be between 2 and 8192", from->rows,
                            from->columns);
        return MBSR_ERR_VALUE;
    }
    if (!from->height) {
        mbsri_contact_print(text, MBSR_TEXT_SIZE, "height is NULL");
        return MBSR_ERR_NULL;
    }
    for (int k = 0; k < from->rows * from->columns; ++k) {
        if (fabs(from->height[k]) < 1e100) continue;
        mbsri_contact_print(text, MBSR_TEXT_SIZE, "height[%d] is %g", k, from->height[k]);
        return MBSR_ERR_VALUE;
    }
    const size_t nx = (size_t)from->columns, ny = (size_t)from->rows;
    *bytes = sizeof(mbsri_field) +
             ((nx + 4) * (2 * ny + 4) + 2 * (nx + 1) * (ny + 1) + nx * ny) * sizeof(double);
    return MBSR_OK;
}

void mbsri_field_make(const mbsr_shape *from, void *memory, mbsri_shape *shape)
{
    const size_t nx = (size_t)from->columns, ny = (size_t)from->rows;
    mbsri_field *f = memory;
    f->nx = from->columns, f->ny = from->rows;
    for (int k = 0; k < 2; ++k) {
        f->half[k] = from->size[k];
        f->cell[k] = 2.0 * from->size[k] / ((k ? f->ny : f->nx) - 1);
    }
    f->control = (double *)(void *)(f + 1);
    f->high = f->control + (nx + 4) * (ny + 4);
    f->steep = f->high + (nx + 1) * (ny + 1);
    f->sticks = f->steep + (nx + 1) * (ny + 1);
    find_control(f, from->height, f->sticks + nx * ny);
    find_heights(f, shape);
    find_sticking(f);
    shape->field = f;
}

/* ---- what is near ---- */

/* A box along the world's axes, in the field's frame. */
static void box_in_field(const mbsri_placed *field, const mbsri_placed *s, double middle[3],
                         double reach[3])
{
    double arm[3];
    for (int k = 0; k < 3; ++k) arm[k] = 0.5 * (s->low[k] + s->high[k]) - field->x[k];
    mbsri_unrotate3(field->R, arm, middle);
    for (int k = 0; k < 3; ++k) {
        reach[k] = 0.0;
        for (int l = 0; l < 3; ++l)
            reach[k] += fabs(field->R[3 * k + l]) * 0.5 * (s->high[l] - s->low[l]);
    }
}

/* Cells from `first` to `last` under it; false: there are none. */
static bool cells_under(const mbsri_field *f, const double middle[3], const double reach[3],
                        int first[2], int last[2])
{
    bool some = true;
    for (int k = 0; k < 2; ++k) {
        const int samples = k ? f->ny : f->nx;
        const double from = in_cells(f, k, middle[k] - reach[k]),
                     to = in_cells(f, k, middle[k] + reach[k]);
        some = some && to >= -1.0 && from <= samples;
        first[k] = cell_of(from, samples), last[k] = cell_of(to, samples);
    }
    return some;
}

static double high_of(const mbsri_field *f, int i, int j)
{
    return f->high[(ptrdiff_t)(j + 1) * (f->nx + 1) + i + 1];
}

/* The steepest slope in cells. */
static double steepest(const mbsri_field *f, const int first[2], const int last[2])
{
    double most = 0.0;
    for (int j = first[1]; j <= last[1]; ++j) {
        for (int i = first[0]; i <= last[0]; ++i) {
            const double here = f->steep[(ptrdiff_t)(j + 1) * (f->nx + 1) + i + 1];
            most = here > most ? here : most;
        }
    }
    return most;
}

bool mbsri_field_reached(const mbsri_placed *field, const mbsri_placed *s)
{
    const mbsri_field *f = field->shape->field;
    double middle[3], reach[3];
    int first[2], last[2];
    box_in_field(field, s, middle, reach);
    const double low = middle[2] - reach[2] - field->shape->margin;
    if (low > field->shape->middle[2] || !cells_under(f, middle, reach, first, last)) return false;
    for (int j = first[1]; j <= last[1]; ++j) {
        for (int i = first[0]; i <= last[0]; ++i)
            if (high_of(f, i, j) >= low) return true;
    }
    return false;
}

int mbsri_field_samples(const mbsri_placed *field, const mbsri_placed *s, mbsri_sample_fn sample,
                        const void *user)
{
    const mbsri_field *f = field->shape->field;
    double middle[3], reach[3];
    int first[2], last[2], status = 0;
    box_in_field(field, s, middle, reach);
    if (!cells_under(f, middle, reach, first, last)) return 0;
    for (int j = first[1] < 0 ? 0 : first[1]; j <= last[1] && j < f->ny; ++j) {
        for (int i = first[0] < 0 ? 0 : first[0]; i <= last[0] && i < f->nx && !status; ++i) {
            const double weight = f->sticks[(ptrdiff_t)j * f->nx + i];
            spot at;
            double x[3];
            if (!(weight > 0.0)) continue;
            look_at(f, i * f->cell[0] - f->half[0], j * f->cell[1] - f->half[1], &at);
            if (at.h < middle[2] - reach[2]) continue;
            const double local[3] = {at.x, at.y, at.h};
            mbsri_rotate3(field->R, local, x);
            mbsri_add3(1.0, field->x, x);
            status = sample(user, x, weight);
        }
    }
    return status;
}

/* ---- where the distance is least ---- */

/* What is over the field, in its frame. */
typedef struct probe {
    const mbsri_field *f;
    double x[3], R[9];
    const double *half; /* of an ellipsoid; NULL: a point */
    double reach;
} probe;

/* A place of the surface, the unit normal there, the point over it, and the equations
 * (S - p) . S_i = 0 with their derivatives. */
typedef struct foot {
    spot s;
    double n[3], p[3], w[3], F[2], H[2][2], G[3];
} foot;

/* Derivatives of the normal by x and y. */
static void curve_field(const spot *s, const double n[3], double by[2][3])
{
    const double size = sqrt(1.0 + s->d[0] * s->d[0] + s->d[1] * s->d[1]);
    for (int k = 0; k < 2; ++k) {
        const double m[3] = {-s->dd[k], -s->dd[k + 1], 0.0}, along = mbsri_dot3(n, m);
        for (int l = 0; l < 3; ++l) by[k][l] = (m[l] - along * n[l]) / size;
    }
}

static void try_foot(const probe *q, double x, double y, foot *t)
{
    look_at(q->f, x, y, &t->s);
    const double *d = t->s.d, *dd = t->s.dd, up[3] = {-d[0], -d[1], 1.0};
    double K[9];
    (void)mbsri_direction3(up, t->n);
    memcpy(t->p, q->x, sizeof t->p);
    if (q->half) {
        double at[3];
        mbsri_support_ellipsoid(q->half, q->R, t->n, at, K);
        mbsri_add3(-1.0, at, t->p);
    }
    t->w[0] = x - t->p[0], t->w[1] = y - t->p[1], t->w[2] = t->s.h - t->p[2];
    for (int k = 0; k < 2; ++k) t->F[k] = t->w[k] + t->w[2] * d[k];
    t->G[0] = 1.0 + d[0] * d[0], t->G[1] = d[0] * d[1], t->G[2] = 1.0 + d[1] * d[1];
    for (int k = 0; k < 2; ++k) {
        for (int l = 0; l < 2; ++l) t->H[k][l] = t->G[k + l] + t->w[2] * dd[k + l];
    }
    if (!q->half) return;
    double by[2][3], moved[3];
    curve_field(&t->s, t->n, by);
    for (int l = 0; l < 2; ++l) {
        mbsri_rotate3(K, by[l], moved);
        for (int k = 0; k < 2; ++k) t->H[k][l] += moved[k] + moved[2] * d[k];
    }
}

static bool is_least(const foot *t)
{
    return t->H[0][0] + t->H[1][1] > 0.0 && t->H[0][0] * t->H[1][1] - t->H[0][1] * t->H[1][0] > 0.0;
}

/* Where feet are looked for. */
typedef struct bounds {
    double low[2], high[2];
} bounds;

/* A cell and a part of one around it. */
static bounds around_cell(const mbsri_field *f, int i, int j, double off)
{
    bounds b;
    for (int k = 0; k < 2; ++k) {
        const double from = (k ? j : i) * f->cell[k] - f->half[k];
        b.low[k] = from - off * f->cell[k];
        b.high[k] = from + (1.0 + off) * f->cell[k];
    }
    return b;
}

/* Whether a step leads out over the bound that it starts from. */
static bool leads_out(const foot *t, const bounds *b, int k, double step)
{
    const double at = k ? t->s.y : t->s.x;
    return step < 0.0 ? at <= b->low[k] : step > 0.0 && at >= b->high[k];
}

/* Newton's step, or where the distance is not convex that of a plane; within a cell, and along a
 * bound that it would lead out of. Its size in cells; INFINITY: it ends at a bound. */
static double step_from(const foot *t, const bounds *within, const double cell[2], double step[2])
{
    const bool least = is_least(t);
    const double a = least ? t->H[0][0] : t->G[0], b = least ? t->H[0][1] : t->G[1],
                 c = least ? t->H[1][0] : t->G[1], d = least ? t->H[1][1] : t->G[2],
                 det = a * d - b * c;
    step[0] = -(d * t->F[0] - b * t->F[1]) / det;
    step[1] = -(a * t->F[1] - c * t->F[0]) / det;
    const bool out[2] = {leads_out(t, within, 0, step[0]), leads_out(t, within, 1, step[1])};
    if (out[0]) step[0] = 0.0, step[1] = -t->F[1] / d;
    if (out[1]) step[1] = 0.0, step[0] = out[0] ? 0.0 : -t->F[0] / a;
    const double size = fmax(fabs(step[0]) / cell[0], fabs(step[1]) / cell[1]);
    if ((out[0] && leads_out(t, within, 1, step[1])) ||
        (out[1] && leads_out(t, within, 0, step[0])) || ((out[0] || out[1]) && size < 1e-7))
        return INFINITY;
    for (int k = 0; k < 2 && size > 1.0; ++k) step[k] /= size;
    return size;
}

/* From a part of a cell to where the distance is least, within bounds; false: there is no such
 * place, or it is not found. */
static bool find_foot(const probe *q, const bounds *within, const double part[2], foot *t)
{
    const mbsri_field *f = q->f;
    bool close = false;
    double start[2];
    for (int k = 0; k < 2; ++k)
        start[k] = within->low[k] + part[k] * (within->high[k] - within->low[k]);
    try_foot(q, start[0], start[1], t);
    for (int round = 0; round < 50; ++round) {
        double step[2], factor = 1.0;
        const double size = step_from(t, within, f->cell, step), before = mbsri_dot3(t->w, t->w);
        const foot from = *t;
        bool down = false;
        if (!(size < INFINITY)) return false;
        for (int k = 0; k < 12 && !down; ++k, factor *= 0.5) {
            double at[2] = {from.s.x + factor * step[0], from.s.y + factor * step[1]};
            for (int l = 0; l < 2; ++l) at[l] = fmin(within->high[l], fmax(within->low[l], at[l]));
            try_foot(q, at[0], at[1], t);
            down = q->half || size < 1e-6 || mbsri_dot3(t->w, t->w) < before;
        }
        if (close || !down) return close && is_least(t) && t->s.share > 0.0;
        close = size < 1e-7;
    }
    return false;
}

/* ---- points ---- */

/* l1 l2 / (l1 + l2), l = 1 - s k of both curvatures k: 1/2 of a plane, zero where a least distance
 * ends. Its derivatives by s, x and y. */
static double spread_of(const spot *t, double s, double by[3])
{
    const double hx = t->d[0], hy = t->d[1], xx = t->dd[0], xy = t->dd[1], yy = t->dd[2],
                 W = 1.0 + hx * hx + hy * hy, root = sqrt(W);
    const double sum = (1.0 + hy * hy) * xx - 2.0 * hx * hy * xy + (1.0 + hx * hx) * yy,
                 product = xx * yy - xy * xy, A = sum / (W * root), B = product / (W * W),
                 D = 1.0 - s * A + s * s * B, T = 2.0 - s * A;
    double dD = 2.0 * s * B - A, dT = -A;
    by[0] = (dD * T - D * dT) / (T * T);
    for (int k = 0; k < 2; ++k) {
        const double dx = t->dd[k], dy = t->dd[k + 1], dxx = t->ddd[k], dxy = t->ddd[k + 1],
                     dyy = t->ddd[k + 2], dW = 2.0 * (hx * dx + hy * dy),
                     dsum = 2.0 * hy * dy * xx + (1.0 + hy * hy) * dxx -
                            2.0 * (dx * hy * xy + hx * dy * xy + hx * hy * dxy) +
                            2.0 * hx * dx * yy + (1.0 + hx * hx) * dyy,
                     dproduct = dxx * yy + xx * dyy - 2.0 * xy * dxy;
        dT = -s * (dsum - 1.5 * sum * dW / W) / (W * root);
        dD = dT + s * s * (dproduct - 2.0 * product * dW / W) / (W * W);
        by[1 + k] = (dD * T - D * dT) / (T * T);
    }
    return D / T;
}

/* The weight, and how it changes with the distance and with the place in the field's frame. */
static double weigh(const foot *t, bool point, double s, double *by_s, double by[3])
{
    double slope[3] = {0.0, 0.0, 0.0}, weight = 1.0, change = 0.0;
    if (point) {
        const double x = 4.0 * spread_of(&t->s, s, slope);
        if (x < 1.0) {
            weight = x > 0.0 ? x * x * (3.0 - 2.0 * x) : 0.0;
            change = x > 0.0 ? 24.0 * x * (1.0 - x) : 0.0;
        }
    }
    *by_s = t->s.share * change * slope[0];
    for (int k = 0; k < 2; ++k) by[k] = t->s.share * change * slope[1 + k] + weight * t->s.by[k];
    by[2] = 0.0;
    return weight * t->s.share;
}

static void fill_touch(const probe *q, const mbsri_placed *a, const mbsri_placed *b, const foot *t,
                       mbsri_touch *to)
{
    double bent[2][3], across[2][3], by[3];
    *to = (mbsri_touch){.features = MBSRI_POINT_SURFACE};
    const double down[3] = {-t->w[0], -t->w[1], -t->w[2]}, at[3] = {t->s.x, t->s.y, t->s.h};
    to->s = mbsri_dot3(t->n, down);
    to->weight = weigh(t, !q->half, to->s, &to->by_distance, by);
    mbsri_rotate3(b->R, t->n, to->n);
    mbsri_rotate3(b->R, t->p, to->pa);
    mbsri_rotate3(b->R, at, to->pb);
    mbsri_rotate3(b->R, by, to->by_place);
    mbsri_add3(1.0, b->x, to->pa);
    mbsri_add3(1.0, b->x, to->pb);
    curve_field(&t->s, t->n, bent);
    for (int k = 0; k < 2; ++k) mbsri_rotate3(b->R, bent[k], across[k]);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j)
            to->Rb[3 * j + i] = across[0][i] * b->R[j] + across[1][i] * b->R[3 + j];
    }
    if (!q->half) {
        to->ra = a->shape->core.radius;
        return;
    }
    to->features = MBSRI_ELLIPSOID_SURFACE;
    memcpy(to->half, q->half, sizeof to->half);
    memcpy(to->Ra, a->R, sizeof to->Ra);
}

/* Whether a cell is too far. */
static bool is_beyond(const probe *q, int i, int j)
{
    const mbsri_field *f = q->f;
    double square = 0.0;
    for (int k = 0; k < 2; ++k) {
        const double from = (k ? j : i) * f->cell[k] - f->half[k],
                     off = fmax(0.0, fmax(from - q->x[k], q->x[k] - from - f->cell[k]));
        square += off * off;
    }
    const double above = fmax(0.0, q->x[2] - high_of(f, i, j));
    return square + above * above > q->reach * q->reach;
}

static bool is_new(const mbsri_field *f, const foot *t, double (*known)[2], int count)
{
    bool fresh = true;
    for (int k = 0; k < count && fresh; ++k)
        fresh = fabs(t->s.x - known[k][0]) > 1e-6 * f->cell[0] ||
                fabs(t->s.y - known[k][1]) > 1e-6 * f->cell[1];
    return fresh;
}

/* ---- cells without a foot ---- */

/* Whether F has no zero in a cell: it is F of the middle and, at most, what H makes of the way from
 * there. `single`: H is positive all over the cell, which has one foot at most. */
static bool is_without(const probe *q, int i, int j, bool *single)
{
    const mbsri_field *f = q->f;
    const cell_ranges r = ranges_of(f, i, j);
    foot t;
    try_foot(q, (i + 0.5) * f->cell[0] - f->half[0], (j + 0.5) * f->cell[1] - f->half[1], &t);
    double most = 0.0, least = INFINITY, bend = 0.0, turn = 0.0;
    for (int k = 0; k < 3 && q->half; ++k)
        most = fmax(most, q->half[k]), least = fmin(least, q->half[k]);
    if (q->half) bend = most * most / least; /* the largest radius of curvature */
    for (int k = 0; k < 2; ++k)              /* of the normal, from the middle on */
        turn +=
            0.5 * (r.d[k].high - r.d[k].low) + fabs(0.5 * (r.d[k].high + r.d[k].low) - t.s.d[k]);
    const double off = fmin(bend * turn, 2.0 * most);
    const range above = {r.h.low - t.p[2] - off, r.h.high - t.p[2] + off};
    range curve[3];
    for (int k = 0; k < 3; ++k) curve[k] = range_product(above, r.dd[k]);
    const double across = most_of(curve[1]), a = 1.0 + curve[0].low, b = 1.0 + curve[2].low;
    *single = !q->half && a > 0.0 && b > 0.0 && a * b > across * across;
    for (int k = 0; k < 2; ++k) {
        double change = 0.0;
        for (int l = 0; l < 2; ++l) {
            const double normal = most_of(r.dd[l]) + most_of(r.dd[l + 1]),
                         H = (k == l) + most_of(r.d[k]) * most_of(r.d[l]) + most_of(curve[k + l]) +
                             bend * normal * (1.0 + most_of(r.d[k]));
            change += 0.5 * H * f->cell[l];
        }
        if (fabs(t.F[k]) > 1.001 * change) return true;
    }
    return false;
}

static bool is_in_cell(const mbsri_field *f, const double at[2], int i, int j)
{
    return cell_of(in_cells(f, 0, at[0]), f->nx) == i && cell_of(in_cells(f, 1, at[1]), f->ny) == j;
}

/* What is found so far, and to whom it goes. */
typedef struct search {
    probe q;
    const mbsri_placed *a, *b;
    mbsri_found_fn found;
    const void *user;
    double known[FEET][2];
    int count;
} search;

/* From places of one cell and a third of one around it; from one where there is one foot at most.
 */
static int search_cell(search *w, int i, int j)
{
    static const double part[5][2] = {
        {0.5, 0.5}, {0.32, 0.32}, {0.68, 0.32}, {0.32, 0.68}, {0.68, 0.68}};
    int status = 0;
    bool single, known = false;
    if (is_beyond(&w->q, i, j) || is_without(&w->q, i, j, &single)) return 0;
    for (int k = 0; k < w->count && single && !known; ++k)
        known = is_in_cell(w->q.f, w->known[k], i, j);
    const bounds within = around_cell(w->q.f, i, j, single ? 1e-6 : 1.0 / 3.0);
    for (int k = 0; k < (known ? 0 : single ? 1 : 5) && !status; ++k) {
        foot t;
        mbsri_touch touch;
        if (!find_foot(&w->q, &within, part[k], &t) || !is_new(w->q.f, &t, w->known, w->count))
            continue;
        if (w->count == FEET) return MBSR_ERR_MEMORY_SIZE;
        w->known[w->count][0] = t.s.x, w->known[w->count++][1] = t.s.y;
        fill_touch(&w->q, w->a, w->b, &t, &touch);
        status = w->found(w->user, &touch);
    }
    return status;
}

int mbsri_field_feet(const mbsri_placed *a, const mbsri_placed *b, const double *pa, double margin,
                     mbsri_found_fn found, const void *user)
{
    const mbsri_core *core = &a->shape->core;
    const bool point = a->shape->kind != MBSR_SHAPE_ELLIPSOID;
    const double arm[3] = {pa[0] - b->x[0], pa[1] - b->x[1], pa[2] - b->x[2]};
    search w = {.q = {.f = b->shape->field, .half = point ? NULL : core->half},
                .a = a,
                .b = b,
                .found = found,
                .user = user};
    int first[2], last[2], status = 0;
    w.q.reach =
        margin + (point ? core->radius : fmax(core->half[0], fmax(core->half[1], core->half[2])));
    mbsri_unrotate3(b->R, arm, w.q.x);
    for (int k = 0; k < 3; ++k) mbsri_unrotate3(b->R, a->R + 3 * k, w.q.R + 3 * k);
    spot at;
    look_at(w.q.f, w.q.x[0], w.q.x[1], &at);
    if (at.share > 0.0) w.q.reach = fmax(w.q.reach, at.h - w.q.x[2]); /* far below */
    const double reach[3] = {w.q.reach, w.q.reach, w.q.reach};
    if (!cells_under(w.q.f, w.q.x, reach, first, last)) return 0;
    const double above = w.q.x[2] - at.h; /* the surface is no nearer than by its slope */
    if (at.share > 0.0 && above > w.q.reach &&
        above > w.q.reach * hypot(1.0, steepest(w.q.f, first, last)))
        return 0;
    for (int j = first[1]; j <= last[1]; ++j) {
        for (int i = first[0]; i <= last[0] && !status; ++i) status = search_cell(&w, i, j);
    }
    return status;
}
