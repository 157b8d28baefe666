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

/* Weights of four control points, and three derivatives by x. */
static void spline_weights(double f, double cell, double w[4][4])
{
    const double g = 1.0 - f,
                 value[4][4] = {{g * g * g / 6.0, (3.0 * f * f * f - 6.0 * f * f + 4.0) / 6.0,
                                 (3.0 * g * g * g - 6.0 * g * g + 4.0) / 6.0, f * f * f / 6.0},
                                {-0.5 * g * g, 0.5 * f * (3.0 * f - 4.0),
                                 -0.5 * g * (3.0 * g - 4.0), 0.5 * f * f},
                                {g, 3.0 * f - 2.0, 3.0 * g - 2.0, f},
                                {-1.0, 3.0, -3.0, 1.0}};
    double factor = 1.0;
    for (int k = 0; k < 4; ++k) {
        for (int l = 0; l < 4; ++l) w[k][l] = value[k][l] * factor;
        factor /= cell;
    }
}

/* 1 within the border, 0 from a cell beyond on, and the derivative by the place in cells. */
static double share_of(double u, int samples, double *slope)
{
    const double beyond = fmax(-u, u - (samples - 1)), x = fmin(1.0, fmax(0.0, beyond));
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
    return (int)floor(fmin(samples - 1.0, fmax(-1.0, u)));
}

static void look_at(const mbsri_field *f, double x, double y, spot *s)
{
    const double at[2] = {in_cells(f, 0, x), in_cells(f, 1, y)};
    const int samples[2] = {f->nx, f->ny};
    double w[2][4][4], sum[10] = {0.0}, share[2], slope[2];
    for (int k = 0; k < 2; ++k) {
        s->cell[k] = cell_of(at[k], samples[k]);
        spline_weights(at[k] - s->cell[k], f->cell[k], w[k]);
        share[k] = share_of(at[k], samples[k], slope + k);
        slope[k] /= f->cell[k];
    }
    for (int j = 0; j < 4; ++j) {
        const double *row =
            f->control + (ptrdiff_t)(s->cell[1] + 1 + j) * (f->nx + 4) + s->cell[0] + 1;
        double along[4];
        for (int k = 0; k < 4; ++k)
            along[k] = w[0][k][0] * row[0] + w[0][k][1] * row[1] + w[0][k][2] * row[2] +
                       w[0][k][3] * row[3];
        static const int dx[10] = {0, 1, 0, 2, 1, 0, 3, 2, 1, 0},
                         dy[10] = {0, 0, 1, 0, 1, 2, 0, 1, 2, 3};
        for (int k = 0; k < 10; ++k) sum[k] += w[1][dy[k]][j] * along[dx[k]];
    }
    s->x = x, s->y = y, s->h = sum[0];
    memcpy(s->d, sum + 1, sizeof s->d);
    memcpy(s->dd, sum + 3, sizeof s->dd);
    memcpy(s->ddd, sum + 6, sizeof s->ddd);
    s->share = share[0] * share[1];
    s->by[0] = slope[0] * share[1];
    s->by[1] = share[0] * slope[1];
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
            double most = -INFINITY;
            for (int k = 0; k < 16; ++k)
                most = fmax(most, f->control[(ptrdiff_t)(j + k / 4) * (f->nx + 4) + i + k % 4]);
            f->high[(ptrdiff_t)j * (f->nx + 1) + i] = most;
            top = fmax(top, most);
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
             ((nx + 4) * (2 * ny + 4) + (nx + 1) * (ny + 1) + nx * ny) * sizeof(double);
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
    f->sticks = f->high + (nx + 1) * (ny + 1);
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

/* Newton's step, or where the distance is not convex that of a plane; within a cell. */
static double step_from(const foot *t, const double cell[2], double step[2])
{
    const bool least = is_least(t);
    const double a = least ? t->H[0][0] : t->G[0], b = least ? t->H[0][1] : t->G[1],
                 c = least ? t->H[1][0] : t->G[1], d = least ? t->H[1][1] : t->G[2],
                 det = a * d - b * c;
    step[0] = -(d * t->F[0] - b * t->F[1]) / det;
    step[1] = -(a * t->F[1] - c * t->F[0]) / det;
    const double size = fmax(fabs(step[0]) / cell[0], fabs(step[1]) / cell[1]);
    for (int k = 0; k < 2 && size > 1.0; ++k) step[k] /= size;
    return size;
}

/* A place within a third of a cell of one. */
static void stay_near(const mbsri_field *f, int i, int j, double at[2])
{
    for (int k = 0; k < 2; ++k) {
        const double from = (k ? j : i) * f->cell[k] - f->half[k], off = f->cell[k] / 3.0;
        at[k] = fmin(from + f->cell[k] + off, fmax(from - off, at[k]));
    }
}

/* From a part of a cell to where the distance is least, in or near that cell; false: there is no
 * such place, or it is not found. */
static bool find_foot(const probe *q, int i, int j, const double part[2], foot *t)
{
    const mbsri_field *f = q->f;
    bool close = false;
    try_foot(q, (i + part[0]) * f->cell[0] - f->half[0], (j + part[1]) * f->cell[1] - f->half[1],
             t);
    for (int round = 0; round < 50; ++round) {
        double step[2], factor = 1.0;
        const double size = step_from(t, f->cell, step), before = mbsri_dot3(t->w, t->w);
        const foot from = *t;
        bool down = false;
        if (!(size < INFINITY)) return false;
        for (int k = 0; k < 12 && !down; ++k, factor *= 0.5) {
            double at[2] = {from.s.x + factor * step[0], from.s.y + factor * step[1]};
            stay_near(f, i, j, at);
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

/* What is found so far, and to whom it goes. */
typedef struct search {
    probe q;
    const mbsri_placed *a, *b;
    mbsri_found_fn found;
    const void *user;
    double known[FEET][2];
    int count;
} search;

/* From places of one cell. */
static int search_cell(search *w, int i, int j)
{
    static const double part[5][2] = {{0.5, 0.5}, {0.2, 0.2}, {0.8, 0.2}, {0.2, 0.8}, {0.8, 0.8}};
    int status = 0;
    if (is_beyond(&w->q, i, j)) return 0;
    for (int k = 0; k < 5 && !status; ++k) {
        foot t;
        mbsri_touch touch;
        if (!find_foot(&w->q, i, j, part[k], &t) || !is_new(w->q.f, &t, w->known, w->count))
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
    for (int j = first[1]; j <= last[1]; ++j) {
        for (int i = first[0]; i <= last[0] && !status; ++i) status = search_cell(&w, i, j);
    }
    return status;
}
