/* Weld, ball or pin, and rows along directions of the root or of a body.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * P and Q are the points of a and b (arms s_P, s_Q from the origins of their bodies), d = r_P -
 * r_Q, e a direction that turns with the root, or with body b (angular velocity w_0), phi the
 * rotation vector of E = R_a R_b^T in the world. Rows, their rates, and the derivatives of these
 * where all accelerations are zero:
 *
 *   e . d - s(t)     e . (v_P - v_Q) + (e x d) . w_0 - s'
 *                    e . (w_a x (w_a x s_P) - w_b x (w_b x s_Q))
 *                      + 2 (w_0 x e) . d' + (w_0 x (w_0 x e)) . d - s''
 *   e . phi          e . (w_a - w_b)                       (w_0 x e) . (w_a - w_b)
 *
 * The rate of phi is w_a - w_b where phi = 0, and the gradient of |phi|^2 is the same with it
 * everywhere. A stiff row, whose phi need not be zero, has the exact rate
 *
 *   e . phi' + (e x phi) . w_0,    phi' = L w_a - L^T w_b,    L = 1 - phi x / 2 + c phi x (phi x),
 *   c = (1 - x cot x) / theta^2,  x = theta / 2,  theta = |phi|
 *
 * Where rows along axes of the root have a gap, what they exert on two bodies that move does not
 * add up to nothing: stiff ones lie along the axes of body b, where it does. */
#include "closures/rows.h"
#include "closures/stock.h"

#include "algebra/dense.h"
#include "algebra/frames.h"
#include "algebra/space3.h"
#include "forces/rotation.h"

enum { WELD, BALL, ROWS };                          /* option[0] */
enum { TURNS_WITH_B = 2 };                          /* option: rows given turn with body b */
enum { FRAME_A = 0, FRAME_B = 12, DIRECTION = 24 }; /* places in param */

/* The rows at one state. */
typedef struct pair {
    mbsri_end a, b, root;  /* root: what the directions turn with */
    int with;              /* its place among the bodies, -1: at rest */
    double s_P[3], s_Q[3]; /* arms */
    double d[3], phi[3];
    int turns, rows; /* the first `turns` rows are those of phi, but in the
                                            plane, where the turn comes last */
    double direction[MBSR_CLOSURE_ROWS][3];
    bool turn[MBSR_CLOSURE_ROWS];
} pair;

static bool has_turn(const mbsr_closure_args *args)
{
    return args->closure->option[0] == WELD && args->body[0].space != MBSR_SPACE_POINT &&
           args->body[1].space != MBSR_SPACE_POINT;
}

static int count(const mbsr_closure_args *args, int *rows, int *position_rows)
{
    const bool flat = mbsri_flat(args);
    const int places = flat ? 2 : 3, turns = has_turn(args) ? flat ? 1 : 3 : 0;
    *rows = *position_rows =
        args->closure->option[0] == ROWS ? args->closure->option[1] : places + turns;
    return MBSR_OK;
}

/* Row k: along unit vector `axis` of the root, or the direction given. */
static void set_row(const mbsr_closure_args *args, pair *w, int axis, bool turn)
{
    double along[3] = {0.0, 0.0, 0.0};
    if (args->closure->option[0] == ROWS)
        mbsri_copy(3, args->closure->param + DIRECTION + 3 * axis, along);
    else
        along[axis] = 1.0;
    mbsri_rotate3(w->root.R, along, w->direction[w->rows]);
    w->turn[w->rows++] = turn;
}

static void set_rows(const mbsr_closure_args *args, pair *w)
{
    const bool flat = mbsri_flat(args), turns = has_turn(args);
    w->rows = 0;
    if (args->closure->option[0] == ROWS) {
        for (int k = 0; k < args->closure->option[1]; ++k) set_row(args, w, k, false);
        return;
    }
    for (int k = 0; k < 3 && turns && !flat; ++k) set_row(args, w, k, true);
    for (int k = 0; k < (flat ? 2 : 3); ++k) set_row(args, w, k, false);
    if (turns && flat) set_row(args, w, 2, true);
}

/* phi: the rotation vector of R_a F_a (R_b F_b)^T. */
static void relative_turn(const mbsr_closure_args *args, pair *w)
{
    double A[9], B[9], E[9], quaternion[4];
    mbsri_multiply3(w->a.R, args->closure->param + FRAME_A + 3, A);
    mbsri_multiply3(w->b.R, args->closure->param + FRAME_B + 3, B);
    mbsri_multiply_transposed3(A, B, E);
    mbsr_rotation_quaternion(E, quaternion);
    const double sine = mbsri_norm3(quaternion + 1);
    const double factor = sine > 0.0 ? 2.0 * atan2(sine, quaternion[0]) / sine : 2.0;
    for (int k = 0; k < 3; ++k) w->phi[k] = factor * quaternion[1 + k];
}

static void prepare_pair(const mbsr_closure_args *args, pair *w)
{
    static const mbsr_force_body at_rest = {.space = MBSR_SPACE_FIXED};
    w->a = mbsri_end_of(args->body);
    w->b = mbsri_end_of(args->body + 1);
    w->with = args->closure->option[TURNS_WITH_B] ? 1 : args->bodies > 2 ? 2 : -1;
    w->root = mbsri_end_of(w->with < 0 ? &at_rest : args->body + w->with);
    mbsri_rotate3(w->a.R, args->closure->param + FRAME_A, w->s_P);
    mbsri_rotate3(w->b.R, args->closure->param + FRAME_B, w->s_Q);
    for (int k = 0; k < 3; ++k) w->d[k] = w->a.r[k] + w->s_P[k] - w->b.r[k] - w->s_Q[k];
    mbsri_zero(3, w->phi);
    if (has_turn(args)) relative_turn(args, w);
    set_rows(args, w);
}

static int position(const mbsr_closure_args *args, double *g)
{
    pair w;
    double s[MBSR_CLOSURE_ROWS], ignored[2][MBSR_CLOSURE_ROWS];
    const int status = mbsri_closure_motion(args, s, ignored[0], ignored[1]);
    if (status) return status;
    prepare_pair(args, &w);
    for (int k = 0; k < w.rows; ++k)
        g[k] = mbsri_dot3(w.direction[k], w.turn[k] ? w.phi : w.d) - s[k];
    return MBSR_OK;
}

/* e^T L and e^T L^T (see above). */
static void turn_rates(const double phi[3], const double e[3], double by_a[3], double by_b[3])
{
    double once[3], twice[3];
    const double c = mbsri_turn_factor(mbsri_dot3(phi, phi), NULL);
    mbsri_cross3(phi, e, once);
    mbsri_cross3(phi, once, twice);
    for (int k = 0; k < 3; ++k) {
        by_a[k] = e[k] + 0.5 * once[k] + c * twice[k];
        by_b[k] = e[k] - 0.5 * once[k] + c * twice[k];
    }
}

/* Whether phi need not be zero: rows with stiffness may be combinations of these. */
static bool any_stiff(const mbsr_closure_args *args)
{
    for (int k = 0; k < MBSR_CLOSURE_ROWS; ++k) {
        if (args->closure->stiffness[k] > 0.0) return true;
    }
    return false;
}

static void add_turn_row(const mbsr_closure_args *args, const pair *w, int k,
                         const mbsr_closure_jacobian *out)
{
    static const double zero[3] = {0.0, 0.0, 0.0};
    double by_a[3], by_b[3];
    mbsri_copy(3, w->direction[k], by_a);
    mbsri_copy(3, w->direction[k], by_b);
    if (any_stiff(args)) turn_rates(w->phi, w->direction[k], by_a, by_b);
    for (int j = 0; j < 3; ++j) by_b[j] = -by_b[j];
    mbsri_end_add(args, 0, by_a, zero, k, out);
    mbsri_end_add(args, 1, by_b, zero, k, out);
    if (w->with < 0 || !any_stiff(args)) return;
    double lever[3];
    mbsri_cross3(w->direction[k], w->phi, lever);
    mbsri_end_add(args, w->with, lever, zero, k, out);
}

static void add_place(const mbsr_closure_args *args, const pair *w, int k,
                      const mbsr_closure_jacobian *out)
{
    static const double zero[3] = {0.0, 0.0, 0.0};
    const double *e = w->direction[k];
    double moment[3], back[3];
    mbsri_cross3(w->s_P, e, moment);
    mbsri_end_add(args, 0, moment, e, k, out);
    mbsri_cross3(e, w->s_Q, moment);
    for (int j = 0; j < 3; ++j) back[j] = -e[j];
    mbsri_end_add(args, 1, moment, back, k, out);
    if (w->with < 0) return;
    mbsri_cross3(e, w->d, moment);
    mbsri_end_add(args, w->with, moment, zero, k, out);
}

static int jacobian(const mbsr_closure_args *args, const mbsr_closure_jacobian *out)
{
    pair w;
    prepare_pair(args, &w);
    for (int k = 0; k < w.rows; ++k) {
        if (w.turn[k])
            add_turn_row(args, &w, k, out);
        else
            add_place(args, &w, k, out);
    }
    return MBSR_OK;
}

/* ---- derivatives for Newton systems ---- */

/* How a turn of one body changes the rows at one state, or, where `shifts`, a shift. */
typedef struct change {
    int k, at; /* the body, and its column */
    bool shifts;
    double turn[3], shift[3];
    double arm_P[3], arm_Q[3], v_P[3], v_Q[3], d[3]; /* changes */
    double along[3];                                 /* turn of the directions */
} change;

static void displace_pair(const mbsr_closure_args *args, const pair *w, change *c)
{
    static const double none[3] = {0.0, 0.0, 0.0};
    const bool first = c->k == 0, second = c->k == 1;
    for (int j = 0; j < 3 && c->shifts; ++j)
        c->d[j] = first ? c->shift[j] : second ? -c->shift[j] : 0.0;
    if (c->shifts) return;
    mbsri_cross3(first ? c->turn : none, w->s_P, c->arm_P);
    mbsri_cross3(second ? c->turn : none, w->s_Q, c->arm_Q);
    mbsri_cross3(w->a.w, c->arm_P, c->v_P);
    mbsri_cross3(w->b.w, c->arm_Q, c->v_Q);
    mbsri_copy(3, args->closure->option[TURNS_WITH_B] && second ? c->turn : none, c->along);
    for (int j = 0; j < 3; ++j) c->d[j] = c->arm_P[j] - c->arm_Q[j];
}

/* Of rows e . d: the sum F of their forces, and d'. */
typedef struct sums {
    double F[3], v[3];
} sums;

static sums sums_of(const pair *w, const double *lambda)
{
    sums s = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    double v_Q[3];
    mbsri_end_velocity(&w->a, w->s_P, s.v);
    mbsri_end_velocity(&w->b, w->s_Q, v_Q);
    mbsri_add3(-1.0, v_Q, s.v);
    for (int i = 0; i < w->rows; ++i) {
        if (!w->turn[i]) mbsri_add3(lambda[i], w->direction[i], s.F);
    }
    return s;
}

/* By a shift levers alone change, of what the directions turn with. */
static void place_shifted(const mbsr_closure_args *args, const pair *w, const sums *s,
                          const change *c, const mbsr_closure_tangent *out)
{
    static const double zero[3] = {0.0, 0.0, 0.0};
    double lever[3], moment[3];
    if (w->with < 0) return;
    for (int i = 0; i < w->rows; ++i) {
        if (w->turn[i]) continue;
        mbsri_cross3(w->direction[i], c->d, lever);
        out->rate[(ptrdiff_t)c->at * out->rows + i] += mbsri_dot3(lever, w->root.w);
    }
    mbsri_cross3(s->F, c->d, moment);
    mbsri_end_load(args, w->with, moment, zero, c->at, out);
}

/* Rows e . d: with the sum F of their forces, on a (s_P x F, F), on b the opposite at Q, and F x d
 * on what the directions turn with. */
static void place_turned(const mbsr_closure_args *args, const pair *w, const sums *s,
                         const change *c, const mbsr_closure_tangent *out)
{
    static const double zero[3] = {0.0, 0.0, 0.0};
    const double *F = s->F;
    double dF[3], back[3], moment[3], dv[3];
    for (int j = 0; j < 3; ++j) dv[j] = c->v_P[j] - c->v_Q[j];
    for (int i = 0; i < w->rows; ++i) {
        if (w->turn[i]) continue;
        const double *e = w->direction[i];
        double de[3], lever[3];
        mbsri_cross3(c->along, e, de);
        mbsri_cross3(de, w->d, lever);
        mbsri_add_cross3(e, c->d, lever);
        out->rate[(ptrdiff_t)c->at * out->rows + i] +=
            mbsri_dot3(de, s->v) + mbsri_dot3(e, dv) + mbsri_dot3(lever, w->root.w);
    }
    mbsri_cross3(c->along, F, dF);
    mbsri_cross3(c->arm_P, F, moment);
    mbsri_add_cross3(w->s_P, dF, moment);
    mbsri_end_load(args, 0, moment, dF, c->at, out);
    for (int j = 0; j < 3; ++j) back[j] = -dF[j];
    mbsri_cross3(F, c->arm_Q, moment);
    mbsri_add_cross3(dF, w->s_Q, moment);
    mbsri_end_load(args, 1, moment, back, c->at, out);
    if (w->with < 0) return;
    mbsri_cross3(dF, w->d, moment);
    mbsri_add_cross3(F, c->d, moment);
    mbsri_end_load(args, w->with, moment, zero, c->at, out);
}

/* Of what a row e . phi of a closure with stiff rows reads of the bodies' angular velocities: e^T L
 * by w_a, -e^T L^T by w_b, e x phi by w_0. */
typedef struct reading {
    double by_a[3], by_b[3], by_root[3];
} reading;

/* Its change with a change of phi and a turn of the directions. */
static reading reading_change(const pair *w, const double e[3], const double dphi[3],
                              const double along[3])
{
    reading r;
    double once[3], twice[3], d_once[3], d_twice[3], de[3], turned_a[3], turned_b[3], slope;
    const double f = mbsri_turn_factor(mbsri_dot3(w->phi, w->phi), &slope),
                 df = 2.0 * slope * mbsri_dot3(w->phi, dphi);
    mbsri_cross3(w->phi, e, once);
    mbsri_cross3(w->phi, once, twice);
    mbsri_cross3(dphi, e, d_once);
    mbsri_cross3(dphi, once, d_twice);
    mbsri_add_cross3(w->phi, d_once, d_twice);
    mbsri_cross3(along, e, de);
    turn_rates(w->phi, de, turned_a, turned_b);
    for (int j = 0; j < 3; ++j) {
        const double even = f * d_twice[j] + df * twice[j];
        r.by_a[j] = 0.5 * d_once[j] + even + turned_a[j];
        r.by_b[j] = 0.5 * d_once[j] - even - turned_b[j];
    }
    mbsri_cross3(e, dphi, r.by_root);
    mbsri_add_cross3(de, w->phi, r.by_root);
    return r;
}

static double read_turns(const pair *w, const reading *r)
{
    return mbsri_dot3(r->by_a, w->a.w) + mbsri_dot3(r->by_b, w->b.w) +
           mbsri_dot3(r->by_root, w->root.w);
}

/* phi' where the bodies turn with these angular velocities, a or b NULL for none. */
static void turn_between(const pair *w, const double *a, const double *b, double dphi[3])
{
    double other[3], back[3] = {0.0, 0.0, 0.0};
    mbsri_zero(3, dphi);
    /* L = L(-phi)^T, so that L w is what turn_rates gives for b */
    if (a) turn_rates(w->phi, a, other, dphi);
    if (b) turn_rates(w->phi, b, back, other);
    mbsri_add3(-1.0, back, dphi);
}

/* Rows e . phi of closures with stiff rows. */
static void turn_tangent(const mbsr_closure_args *args, const pair *w, const double *lambda,
                         const change *c, const mbsr_closure_tangent *out)
{
    static const double zero[3] = {0.0, 0.0, 0.0};
    double dphi[3];
    turn_between(w, c->k == 0 ? c->turn : NULL, c->k == 1 ? c->turn : NULL, dphi);
    for (int i = 0; i < w->rows; ++i) {
        if (!w->turn[i]) continue;
        reading r = reading_change(w, w->direction[i], dphi, c->along);
        out->rate[(ptrdiff_t)c->at * out->rows + i] += read_turns(w, &r);
        for (int j = 0; j < 3; ++j)
            r.by_a[j] *= lambda[i], r.by_b[j] *= lambda[i], r.by_root[j] *= lambda[i];
        mbsri_end_load(args, 0, r.by_a, zero, c->at, out);
        mbsri_end_load(args, 1, r.by_b, zero, c->at, out);
        if (w->with >= 0) mbsri_end_load(args, w->with, r.by_root, zero, c->at, out);
    }
}

static int tangent(const mbsr_closure_args *args, const double *lambda,
                   const mbsr_closure_tangent *out)
{
    pair w;
    change c;
    const bool turns = has_turn(args) && any_stiff(args);
    prepare_pair(args, &w);
    const sums s = sums_of(&w, lambda);
    for (c.k = 0; c.k < 2; ++c.k) {
        for (int r = 0; out->column[c.k] >= 0 && mbsri_end_shift(args, c.k, r, c.turn, c.shift);
             ++r) {
            c.at = out->column[c.k] + r;
            c.shifts = mbsri_dot3(c.turn, c.turn) == 0.0;
            displace_pair(args, &w, &c);
            if (c.shifts)
                place_shifted(args, &w, &s, &c, out);
            else
                place_turned(args, &w, &s, &c, out);
            if (turns && !c.shifts) turn_tangent(args, &w, lambda, &c, out);
        }
    }
    return MBSR_OK;
}

static int drift(const mbsr_closure_args *args, double *gt)
{
    double ignored[2][MBSR_CLOSURE_ROWS], sdot[MBSR_CLOSURE_ROWS];
    int rows, position_rows;
    const int status = mbsri_closure_motion(args, ignored[0], sdot, ignored[1]);
    count(args, &rows, &position_rows);
    for (int k = 0; k < rows; ++k) gt[k] = -sdot[k];
    return status;
}

static int bias(const mbsr_closure_args *args, double *out)
{
    pair w;
    double ignored[2][MBSR_CLOSURE_ROWS], sddot[MBSR_CLOSURE_ROWS];
    const int status = mbsri_closure_motion(args, ignored[0], ignored[1], sddot);
    if (status) return status;
    prepare_pair(args, &w);
    double a_P[3], a_Q[3], v_P[3], v_Q[3], once[3], twice[3], turn[3];
    const bool exact = any_stiff(args);
    if (exact) turn_between(&w, w.a.w, w.b.w, turn);
    mbsri_end_centripetal(&w.a, w.s_P, a_P);
    mbsri_end_centripetal(&w.b, w.s_Q, a_Q);
    mbsri_end_velocity(&w.a, w.s_P, v_P);
    mbsri_end_velocity(&w.b, w.s_Q, v_Q);
    for (int k = 0; k < w.rows; ++k) {
        const double *e = w.direction[k];
        mbsri_cross3(w.root.w, e, once);
        mbsri_cross3(w.root.w, once, twice);
        if (w.turn[k] && exact) {
            const reading r = reading_change(&w, e, turn, w.root.w);
            out[k] += read_turns(&w, &r);
        }
        for (int j = 0; j < 3 && !(w.turn[k] && exact); ++j) {
            out[k] += w.turn[k] ? once[j] * (w.a.w[j] - w.b.w[j])
                                : e[j] * (a_P[j] - a_Q[j]) + 2.0 * once[j] * (v_P[j] - v_Q[j]) +
                                      twice[j] * w.d[j];
        }
        out[k] -= sddot[k];
    }
    return MBSR_OK;
}

static const char *row(const mbsr_closure_args *args, int k)
{
    static const char *const place[] = {"x", "y", "z"},
                             *const turn[] = {"turn about x", "turn about y", "turn about z"},
                             *const given[] = {"direction 0", "direction 1", "direction 2"};
    if (args->closure->option[0] == ROWS) return given[k];
    if (mbsri_flat(args)) return k < 2 ? place[k] : turn[2];
    return !has_turn(args) ? place[k] : k < 3 ? turn[k] : place[k - 3];
}

static int check_fields(const mbsr_closure_def *def, char text[MBSR_TEXT_SIZE])
{
    const int kind = def->option[0], directions = def->option[1];
    if (kind < WELD || kind > ROWS)
        return mbsri_refuse(text, MBSR_ERR_VALUE, "option[0] is %d, no kind of closure", kind);
    int status = mbsri_check_frame(def, FRAME_A, "frame_a", text);
    if (!status) status = mbsri_check_frame(def, FRAME_B, "frame_b", text);
    if (status) return status;
    if (kind == WELD && def->motion)
        return mbsri_refuse(text, MBSR_ERR_VALUE,
                            "a weld cannot follow a motion; use a loop joint with a driven "
                            "coordinate");
    if (kind != ROWS) return MBSR_OK;
    if (directions < 1 || directions > 3)
        return mbsri_refuse(text, MBSR_ERR_VALUE, "count is %d, must be 1 .. 3", directions);
    for (int k = 0; k < directions; ++k) {
        const double *e = def->param + DIRECTION + 3 * k;
        if (!(fabs(mbsri_norm3(e) - 1.0) < 1e-6))
            return mbsri_refuse(text, MBSR_ERR_VALUE, "direction %d has length zero", k);
    }
    return MBSR_OK;
}

/* Whether the directions given span as many dimensions. */
static bool independent(const mbsr_closure_def *def, bool flat)
{
    const double *e = def->param + DIRECTION;
    double normal[3];
    const int n = def->option[1];
    if (n > (flat ? 2 : 3)) return false;
    if (flat) {
        for (int k = 0; k < n; ++k) {
            if (hypot(e[3 * k], e[3 * k + 1]) < 1e-6) return false;
        }
        return n < 2 || fabs(e[0] * e[4] - e[1] * e[3]) > 1e-6;
    }
    if (n < 2) return true;
    mbsri_cross3(e, e + 3, normal);
    return n == 2 ? mbsri_norm3(normal) > 1e-6 : fabs(mbsri_dot3(normal, e + 6)) > 1e-6;
}

static int check(const mbsr_closure_args *args, char text[MBSR_TEXT_SIZE])
{
    const int status = mbsri_check_pair(args, text);
    if (status || args->closure->option[0] != ROWS) return status;
    if (independent(args->closure, mbsri_flat(args))) return MBSR_OK;
    return mbsri_refuse(text, MBSR_ERR_VALUE, "the directions are not independent%s",
                        mbsri_flat(args) ? " in the plane" : "");
}

/* along axes of the root, so that the columns of a body depend on that body alone */
enum {
    FIXED = MBSR_CLOSURE_ROOT | MBSR_CLOSURE_RELATIVE | MBSR_CLOSURE_OWN,
    CLOSED = FIXED | MBSR_CLOSURE_BALANCED,
    TURNING = MBSR_CLOSURE_RELATIVE | MBSR_CLOSURE_BALANCED /* with body b */
};

/* clang-format off */
#define TABLE(kind, promises) {                                                                    \
    .version = MBSR_CLOSURE_TABLE_VERSION, .flags = (promises), .name = (kind),                    \
    .position = position, .jacobian = jacobian, .tangent = tangent, .drift = drift, .bias = bias,  \
    .count = count, .check = check, .check_fields = check_fields, .row = row,                      \
    .point = mbsri_point_of_first}
/* clang-format on */
static const mbsr_closure_table tables[] = {TABLE("weld", CLOSED), TABLE("ball", CLOSED),
                                            TABLE("rows", FIXED)};
static const mbsr_closure_table turning[] = {TABLE("weld", TURNING), TABLE("ball", TURNING),
                                             TABLE("rows", TURNING)};

mbsr_closure_def mbsr_closure_weld(int a, const mbsr_frame *frame_a, int b,
                                   const mbsr_frame *frame_b)
{
    mbsr_closure_def def = mbsri_stock_closure(tables + WELD, a, b);
    def.option[0] = WELD;
    mbsri_store_frame(frame_a, def.param + FRAME_A);
    mbsri_store_frame(frame_b, def.param + FRAME_B);
    return def;
}

mbsr_closure_def mbsr_closure_ball(int a, const double point_a[3], int b, const double point_b[3])
{
    mbsr_closure_def def = mbsr_closure_weld(a, NULL, b, NULL);
    def.table = tables + BALL;
    def.option[0] = BALL;
    if (point_a) mbsri_copy(3, point_a, def.param + FRAME_A);
    if (point_b) mbsri_copy(3, point_b, def.param + FRAME_B);
    return def;
}

mbsr_closure_def mbsr_closure_rows(int a, const double point_a[3], int b, const double point_b[3],
                                   int count_given, const double *direction)
{
    mbsr_closure_def def = mbsr_closure_ball(a, point_a, b, point_b);
    def.table = tables + ROWS;
    def.option[0] = ROWS;
    def.option[1] = count_given;
    for (int k = 0; k < count_given && k < 3 && direction; ++k)
        mbsri_direction3(direction + 3 * k, def.param + DIRECTION + 3 * k);
    return def;
}

mbsr_closure_def mbsr_closure_body_rows(int a, const double point_a[3], int b,
                                        const double point_b[3], int count_given,
                                        const double *direction)
{
    mbsr_closure_def def = mbsr_closure_rows(a, point_a, b, point_b, count_given, direction);
    def.table = turning + ROWS;
    def.option[TURNS_WITH_B] = 1;
    return def;
}

void mbsri_stiff_axes(mbsr_closure_def *def)
{
    const bool grounded = def->body[0] == MBSR_GROUND || def->body[1] == MBSR_GROUND;
    if ((def->table != tables + WELD && def->table != tables + BALL) || grounded || def->motion)
        return;
    for (int k = 0; k < MBSR_CLOSURE_ROWS; ++k) {
        if (def->stiffness[k] == 0.0) continue;
        def->table = turning + (def->table - tables);
        def->option[TURNS_WITH_B] = 1;
        return;
    }
}
