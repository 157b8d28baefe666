/* Bushing between two frames in the plane.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * Along the axes of A: e = (x, y, angle) of B relative to A, e' its rate as seen from A. Force and
 * moment on B, the force at B's origin: -(K e + D e') */
#include "algebra/space3.h"
#include "forces/marker.h"
#include "forces/slopes.h"
#include "forces/springs.h"
#include "forces/stock.h"

#include <math.h>
#include <string.h>

enum { FRAME_A, FRAME_B = 3, STIFFNESS = 6, DAMPING = STIFFNESS + 9 };

typedef struct bushing {
    mbsri_marker at;           /* A's origin on body a */
    mbsri_marker a, b;         /* the points of both bodies where B's origin is */
    double axes[9];            /* A's, in the world */
    double e[3], rate[3];      /* along them */
    double apart[3], drift[3]; /* x, y of e and rate along the world's axes, 0 */
    double load[3];            /* K e + D e' */
} bushing;

static double frame_angle(const mbsr_force_body *body, const double *frame)
{
    return (body->space == MBSR_SPACE_PLANAR ? body->p[2] : 0.0) + frame[2];
}

/* The marker at the origin of the frame that stands at `frame` in the parameters. */
static void origin_of(const mbsr_force_body *body, const double *frame, mbsri_marker *marker)
{
    const double in_body[3] = {frame[0], frame[1], 0.0};
    mbsri_marker_on(body, in_body, marker);
}

static void relative_planar_pose(const mbsr_force_args *args, bushing *w)
{
    const mbsr_force_body *a = args->body, *b = args->body + 1;
    const double *param = args->force->param, angle = frame_angle(a, param + FRAME_A);
    double spin[2][3], y[3];
    memset(w, 0, sizeof *w);
    w->axes[0] = w->axes[4] = cos(angle);
    w->axes[1] = sin(angle);
    w->axes[3] = -w->axes[1];
    w->axes[8] = 1.0;
    origin_of(a, param + FRAME_A, &w->at);
    origin_of(b, param + FRAME_B, &w->b);
    mbsri_marker_at(a, w->b.x, &w->a);
    mbsri_body_spin(a, spin[0]);
    mbsri_body_spin(b, spin[1]);
    for (int k = 0; k < 2; ++k) {
        w->apart[k] = w->b.x[k] - w->at.x[k];
        w->drift[k] = w->b.v[k] - w->a.v[k];
    }
    mbsri_unrotate3(w->axes, w->apart, w->e);
    mbsri_unrotate3(w->axes, w->drift, w->rate);
    w->e[2] = frame_angle(b, param + FRAME_B) - angle;
    w->rate[2] = spin[1][2] - spin[0][2];
    mbsri_rotate3(param + STIFFNESS, w->e, w->load);
    mbsri_rotate3(param + DAMPING, w->rate, y);
    mbsri_add3(1.0, y, w->load);
}

/* Force and moment on a, the opposite of those on b, along the world's axes. */
static void split(const bushing *w, double force[3], double moment[3])
{
    const double along[3] = {w->load[0], w->load[1], 0.0};
    mbsri_rotate3(w->axes, along, force);
    moment[0] = moment[1] = 0.0;
    moment[2] = w->load[2];
}

static int evaluate(const mbsr_force_args *args)
{
    double force[3], moment[3];
    bushing w;
    relative_planar_pose(args, &w);
    split(&w, force, moment);
    mbsri_push(args->body, &w.a, 1.0, force, moment);
    mbsri_push(args->body + 1, &w.b, -1.0, force, moment);
    return MBSR_OK;
}

/* Derivatives: those of e and e' as seen from A, a vector x in the world changing by dx - phi_a x x
 * there, with the angle and its rate in the third place. */
static int derivatives(const mbsr_force_args *args, const mbsr_force_derivatives *out)
{
    const mbsri_columns c = mbsri_make_columns(args, out);
    const double *param = args->force->param;
    mbsri_vector arm_a[MBSRI_MAX_COLUMNS], arm_b[MBSRI_MAX_COLUMNS], de[MBSRI_MAX_COLUMNS],
        drate[MBSRI_MAX_COLUMNS], dforce[MBSRI_MAX_COLUMNS], dmoment[MBSRI_MAX_COLUMNS];
    double force[3], moment[3], dload[3], y[3];
    bushing w;
    relative_planar_pose(args, &w);
    split(&w, force, moment);
    memset(arm_b, 0, sizeof arm_b);
    memset(drate, 0, sizeof drate);
    memset(dforce, 0, sizeof dforce);
    memset(dmoment, 0, sizeof dmoment);
    mbsri_add_turn(&c, 1, MBSRI_POSE, 1.0, w.b.arm, arm_b);
    memcpy(arm_a, arm_b, sizeof arm_a);
    mbsri_add_shift(&c, 1, MBSRI_POSE, 1.0, arm_a);
    memcpy(de, arm_a, sizeof de);
    mbsri_add_shift(&c, 0, MBSRI_POSE, -1.0, arm_a);
    mbsri_add_shift(&c, 0, MBSRI_POSE, -1.0, de);
    mbsri_add_turn(&c, 0, MBSRI_POSE, -1.0, w.at.arm, de);
    mbsri_add_turn(&c, 0, MBSRI_POSE, -1.0, w.apart, de);
    mbsri_add_velocity(&c, 1, 1.0, w.b.arm, arm_b, drate);
    mbsri_add_velocity(&c, 0, -1.0, w.a.arm, arm_a, drate);
    mbsri_add_turn(&c, 0, MBSRI_POSE, -1.0, w.drift, drate);
    mbsri_add_spin(&c, 1, MBSRI_POSE, 1.0, de);
    mbsri_add_spin(&c, 0, MBSRI_POSE, -1.0, de);
    mbsri_add_spin(&c, 1, MBSRI_RATE, 1.0, drate);
    mbsri_add_spin(&c, 0, MBSRI_RATE, -1.0, drate);
    for (int l = 0; l < c.count; ++l) {
        mbsri_unrotate3(w.axes, de[l].x, y);
        mbsri_rotate3(param + STIFFNESS, y, dload);
        mbsri_unrotate3(w.axes, drate[l].x, y);
        mbsri_rotate3(param + DAMPING, y, y);
        mbsri_add3(1.0, y, dload);
        dmoment[l].x[2] = dload[2];
        dload[2] = 0.0;
        mbsri_rotate3(w.axes, dload, dforce[l].x);
    }
    mbsri_add_turn(&c, 0, MBSRI_POSE, 1.0, force, dforce);
    mbsri_push_slopes(&c, 0, 1.0, w.a.arm, force, arm_a, dforce, dmoment);
    mbsri_push_slopes(&c, 1, -1.0, w.b.arm, force, arm_b, dforce, dmoment);
    return MBSR_OK;
}

/* ---- energies and the rest ---- */

/* x^T A x */
static double quadratic(const double A[9], const double x[3])
{
    double y[3];
    mbsri_rotate3(A, x, y);
    return mbsri_dot3(x, y);
}

static int energy(const mbsr_force_args *args, double *energy_out)
{
    bushing w;
    relative_planar_pose(args, &w);
    *energy_out += 0.5 * quadratic(args->force->param + STIFFNESS, w.e);
    return MBSR_OK;
}

static int dissipation(const mbsr_force_args *args, double *power)
{
    bushing w;
    relative_planar_pose(args, &w);
    *power += quadratic(args->force->param + DAMPING, w.rate);
    return MBSR_OK;
}

static int check(const mbsr_force_args *args, char text[MBSR_TEXT_SIZE])
{
    for (int k = 0; k < 2; ++k) {
        const mbsr_force_body *body = args->body + k;
        if (body->space == MBSR_SPACE_PLANAR || body->space == MBSR_SPACE_FIXED) continue;
        return mbsri_refuse(text, MBSR_ERR_SPACE, "body %d is not in PLANAR space", body->id);
    }
    return mbsri_check_ends(args, text);
}

/* Refuses a matrix that is not symmetric or not positive semi-definite: scaled to unit diagonal,
 * all its principal minors are at least -1e-12. */
static int check_planar_matrix(const mbsr_force_def *def, int first, const char *name,
                               char text[MBSR_TEXT_SIZE])
{
    const double *A = def->param + first;
    double S[9] = {0.0};
    for (int k = 0; k < 3; ++k) {
        if (A[4 * k] < 0.0) {
            return mbsri_refuse(text, MBSR_ERR_VALUE, "%s(%d,%d) is %g, negative", name, k, k,
                                A[4 * k]);
        }
        for (int l = 0; l < 3; ++l) {
            const double scale = sqrt(A[4 * k]) * sqrt(fabs(A[4 * l]));
            const double x = A[3 * l + k], y = A[3 * k + l];
            if (fabs(x - y) > 1e-12 * (fabs(x) + fabs(y))) {
                return mbsri_refuse(text, MBSR_ERR_VALUE,
                                    "%s is not symmetric: (%d,%d) is %g, (%d,%d) is %g", name, k, l,
                                    x, l, k, y);
            }
            S[3 * l + k] = x == 0.0 ? 0.0 : x / scale;
        }
    }
    const double xy = S[3], xa = S[6], ya = S[7], least = -1e-12;
    const double full =
        S[0] * (S[4] * S[8] - ya * ya) - xy * (xy * S[8] - ya * xa) + xa * (xy * ya - S[4] * xa);
    if (S[0] * S[4] - xy * xy >= least && S[0] * S[8] - xa * xa >= least &&
        S[4] * S[8] - ya * ya >= least && full >= least)
        return MBSR_OK;
    return mbsri_refuse(text, MBSR_ERR_VALUE, "%s is not positive semi-definite", name);
}

static int check_fields(const mbsr_force_def *def, char text[MBSR_TEXT_SIZE])
{
    int status = mbsri_check_shape(def, 2, 0, text);
    if (!status) status = check_planar_matrix(def, STIFFNESS, "stiffness", text);
    return status ? status : check_planar_matrix(def, DAMPING, "damping", text);
}

static const char *parameter(int k)
{
    static const char *const names[] = {
        " (A.x)",          " (A.y)",          " (A.angle)",      " (B.x)",
        " (B.y)",          " (B.angle)",      " (stiffness[0])", " (stiffness[1])",
        " (stiffness[2])", " (stiffness[3])", " (stiffness[4])", " (stiffness[5])",
        " (stiffness[6])", " (stiffness[7])", " (stiffness[8])", " (damping[0])",
        " (damping[1])",   " (damping[2])",   " (damping[3])",   " (damping[4])",
        " (damping[5])",   " (damping[6])",   " (damping[7])",   " (damping[8])"};
    return MBSRI_PARAMETER(names, k);
}

static const mbsr_force_table planar_table = {
    .version = MBSR_FORCE_TABLE_VERSION,
    .flags = MBSR_FORCE_NO_MASS | MBSR_FORCE_NO_JOINT,
    .name = "planar bushing",
    .evaluate = evaluate,
    .energy = energy,
    .dissipation = dissipation,
    .check = check,
    .check_fields = check_fields,
    .parameter = parameter,
    .derivatives = derivatives,
};

mbsr_force_def mbsr_force_planar_bushing(int a, mbsr_planar_frame A, int b, mbsr_planar_frame B,
                                         const double stiffness[9], const double damping[9])
{
    mbsr_force_def def = mbsri_stock_force(&planar_table, 2, a, b);
    const double frames[6] = {A.x, A.y, A.angle, B.x, B.y, B.angle};
    memcpy(def.param + FRAME_A, frames, sizeof frames);
    if (stiffness) memcpy(def.param + STIFFNESS, stiffness, 9 * sizeof *stiffness);
    if (damping) memcpy(def.param + DAMPING, damping, 9 * sizeof *damping);
    return def;
}

bool mbsri_read_planar_bushing(const mbsr_force_def *def, mbsri_spring *spring)
{
    if (def->table != &planar_table) return false;
    spring->kind = MBSRI_PLANAR_BUSHING;
    memcpy(spring->a, def->param + FRAME_A, 3 * sizeof *spring->a);
    memcpy(spring->b, def->param + FRAME_B, 3 * sizeof *spring->b);
    memcpy(spring->stiffness, def->param + STIFFNESS, 9 * sizeof *spring->stiffness);
    memcpy(spring->damping, def->param + DAMPING, 9 * sizeof *spring->damping);
    return true;
}

_Static_assert(DAMPING + 9 <= MBSR_FORCE_PARAMS, "too many parameters");
