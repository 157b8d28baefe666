/* The test of joints by differences: it passes what is right and finds what is wrong, and where.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "counting.h"
#include "expect.h"
#include "samples.h"
#include "tree.h"

#include <mbsrank/verify.h>

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

/* ---- a joint with a state to test it in ---------------------------------------------------- */

typedef struct subject {
    const char *name;
    mbsr_joint joint;
    mbsr_joint_test at;
    double q[12], u[12], p_pred[12], V_pred[12];
} subject;

static int drive(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user;
    for (int k = 0; k < 2; ++k) {
        s[k] = 0.3 * sin(1.3 * t + k);
        sdot[k] = 0.39 * cos(1.3 * t + k);
        sddot[k] = -0.507 * sin(1.3 * t + k);
    }
    return 0;
}

/* A random state of motion on a predecessor in `space`. */
static void set_state(subject *s, mbsr_space space, test_rng *rng)
{
    s->at = mbsr_default_joint_test();
    s->at.pred_space = space;
    s->at.t = 0.4;
    s->at.q = s->q;
    s->at.u = s->u;
    s->at.p_pred = s->p_pred;
    s->at.V_pred = s->V_pred;
    test_fill(rng, 12, s->q);
    test_fill(rng, 12, s->u);
    test_fill(rng, 12, s->p_pred);
    test_fill(rng, 12, s->V_pred);
    if (space == MBSR_SPACE_SPATIAL) {
        const mbsr_frame frame = test_frame(rng, 1.0);
        memcpy(s->p_pred + MBSR_POSE_R, frame.R, sizeof frame.R);
    }
}

static double *field_of(mbsr_joint_errors *errors, int k)
{
    double *const fields[] = {&errors->position,  &errors->H,       &errors->J,
                              &errors->kI,        &errors->kII,     &errors->Kdot,
                              &errors->Hdot,      &errors->Jdot,    &errors->coordinate_rates,
                              &errors->normalise, &errors->tangent, &errors->rate_tangent};
    return fields[k];
}

enum { POSITION, H, J, KI, KII, KDOT, HDOT, JDOT, RATES, NORMALISE, TANGENT, RATE_TANGENT, FIELDS };
static const char *const field_name[] = {
    "position",         "H",         "J",       "kI",          "kII", "Kdot", "Hdot", "Jdot",
    "coordinate_rates", "normalise", "tangent", "rate_tangent"};

/* ---- all stock joints are right ------------------------------------------------------------- */

static void verify_all_right(const mbsr_joint *joint, mbsr_space space, test_rng *rng)
{
    subject s = {.joint = *joint};
    set_state(&s, space, rng);
    mbsr_joint_errors errors;
    mbsr_error error = {0};
    assert_ok(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error);
    if (!(errors.largest < 1e-8)) {
        print_error("%s on %d: %s: %.3g\n", joint->table->name, (int)space, errors.text,
                    errors.largest);
        fail();
    }
    /* and each field was tested where there is something to test */
    const bool quaternion = joint->nq != joint->n, moves = space != MBSR_SPACE_FIXED;
    const bool there[] = {joint->space == MBSR_SPACE_SPATIAL,
                          moves,
                          joint->n > 0,
                          true,
                          true,
                          false,
                          moves,
                          joint->n > 0,
                          quaternion,
                          quaternion,
                          joint->n > 0 || moves,
                          joint->n > 0 || moves};
    for (int k = 0; k < FIELDS; ++k) {
        if ((*field_of(&errors, k) < 0.0) == there[k])
            print_error("%s on %d: %s\n", joint->table->name, (int)space, field_name[k]);
        assert_int_equal(!(*field_of(&errors, k) < 0.0), there[k]);
    }
}

static void planar_joints_pass(void **state)
{
    (void)state;
    test_rng rng = test_seed(1);
    const mbsr_space spaces[] = {MBSR_SPACE_FIXED, MBSR_SPACE_POINT, MBSR_SPACE_PLANAR};
    for (int s = 0; s < 3; ++s) {
        for (int free = 0; free < 8; ++free) {
            for (int driven = 0; driven < 8; ++driven) {
                if (free & driven || driven == 7) continue;
                const mbsr_planar_frame A = {0.4, -0.3, 1.1}, B = {-0.2, 0.5, 0.7};
                const mbsr_joint joint = mbsr_joint_planar(A, B, free, driven, drive, NULL);
                verify_all_right(&joint, spaces[s], &rng);
                if ((free | driven) & MBSR_ANGLE) continue;
                const mbsr_joint point = mbsr_joint_point(A, free, driven, drive, NULL);
                verify_all_right(&point, spaces[s], &rng);
            }
        }
    }
}

static void joints_in_space_pass(void **state)
{
    (void)state;
    test_rng rng = test_seed(2);
    const mbsr_space spaces[] = {MBSR_SPACE_FIXED, MBSR_SPACE_POINT, MBSR_SPACE_PLANAR,
                                 MBSR_SPACE_SPATIAL};
    for (int s = 0; s < 4; ++s) {
        for (int k = 0; k < SAMPLE_JOINTS; ++k) {
            const mbsr_joint joint = sample_make(k, &rng).joint;
            verify_all_right(&joint, spaces[s], &rng);
        }
    }
}

/* ---- joints that are wrong ------------------------------------------------------------------ */

/* One entry of what one function writes is changed by a factor, or by a shift where it is zero. */
typedef struct fault {
    int field; /* which: K is KDOT with of_K set */
    bool of_K; /* the entry is one of K */
    int entry; /* of the matrix or vector */
    double factor;
} fault;

static fault broken;
static const mbsr_joint_table *original;

static void spoil(int field, bool of_K, double *x)
{
    if (!x || broken.field != field || broken.of_K != of_K || !(broken.factor < 2.0)) return;
    x[broken.entry] *= broken.factor;
}

static int wrong_position(const mbsr_joint_args *args, double *p)
{
    const int status = original->position(args, p);
    spoil(POSITION, false, p);
    return status;
}

static int wrong_jacobians(const mbsr_joint_args *args, double *K, double *Hm, double *Jm,
                           double *kI)
{
    const int status = original->jacobians(args, K, Hm, Jm, kI);
    spoil(KDOT, true, K);
    spoil(H, false, Hm);
    spoil(J, false, Jm);
    spoil(KI, false, kI);
    return status;
}

static int wrong_bias(const mbsr_joint_args *args, double *kII)
{
    const int status = original->bias(args, kII);
    spoil(KII, false, kII);
    return status;
}

static int wrong_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    const int status = original->rates(args, Kdot, Hdot, Jdot);
    spoil(KDOT, false, Kdot);
    spoil(HDOT, false, Hdot);
    spoil(JDOT, false, Jdot);
    return status;
}

static mbsr_joint_table wrong_table(const mbsr_joint *joint)
{
    mbsr_joint_table table = *joint->table;
    original = joint->table;
    table.position = wrong_position;
    table.jacobians = wrong_jacobians;
    table.bias = wrong_bias;
    table.rates = wrong_rates;
    table.tangent = NULL; /* which would not fit what is wrong */
    table.rate_tangent = NULL;
    return table;
}

/* The largest entry of what field `field` is about, in the right joint. */
static int largest_entry(const subject *s, int field, bool of_K, const mbsr_joint_args *args,
                         double *value)
{
    static double K[144], M1[144], M2[144], v[144];
    const int d = s->joint.d;
    double *x = field == H || field == HDOT ? M1 : field == J || field == JDOT ? M2 : v;
    int count = field == H || field == HDOT   ? d * args->pred_d
                : field == J || field == JDOT ? d * s->joint.n
                                              : d;
    memset(K, 0, sizeof K), memset(M1, 0, sizeof M1);
    memset(M2, 0, sizeof M2), memset(v, 0, sizeof v);
    const bool unit = (original->flags & MBSR_JOINT_UNIT_K) != 0;
    for (int k = 0; k < d && of_K; ++k) K[k * d + k] = 1.0;
    if (field == KDOT) x = K, count = unit ? 0 : d * d;
    if (field == KII)
        original->bias(args, v);
    else if (field >= KDOT && !of_K)
        original->rates(args, unit ? NULL : K, M1, M2);
    else
        original->jacobians(args, unit ? NULL : K, M1, M2, v);
    int entry = 0;
    for (int k = 0; k < count; ++k) {
        if (fabs(x[k]) > fabs(x[entry])) entry = k;
    }
    *value = count > 0 ? x[entry] : 0.0;
    return entry;
}

/* Everything a function of the right joint may read. */
static mbsr_joint_args right_args(const subject *s, double p[12], double V[12])
{
    static double Hm[144], Jm[144], kI[12], K[144];
    const mbsr_joint *joint = &s->joint;
    const int d = joint->d;
    static const int space_d[] = {0, 2, 2, 3, 6};
    mbsr_joint_args args = {
        .param = joint->param,
        .option = joint->option,
        .motion = joint->motion,
        .user = joint->user,
        .d = d,
        .np = joint->np,
        .n = joint->n,
        .nq = joint->nq,
        .t = s->at.t,
        .q = s->q,
        .pred_space = s->at.pred_space,
        .pred_d = s->at.pred_space == MBSR_SPACE_GENERAL ? s->at.pred_d : space_d[s->at.pred_space],
        .p_pred = s->p_pred};
    memset(Hm, 0, sizeof Hm), memset(Jm, 0, sizeof Jm);
    memset(kI, 0, sizeof kI), memset(K, 0, sizeof K);
    original->position(&args, p);
    args.p = p;
    original->jacobians(&args, original->flags & MBSR_JOINT_UNIT_K ? NULL : K, Hm, Jm, kI);
    /* a velocity to call with; that it does not fit K does no harm here */
    for (int k = 0; k < d; ++k) {
        V[k] = -kI[k];
        for (int c = 0; c < args.pred_d; ++c) V[k] -= Hm[c * d + k] * s->V_pred[c];
        for (int c = 0; c < args.n; ++c) V[k] -= Jm[c * d + k] * s->u[c];
    }
    args.u = s->u;
    args.V_pred = s->V_pred;
    args.V = V;
    return args;
}

/* The joint with a fault: exactly the fields of the mask are raised. */
static void expect_fields(const subject *s, const mbsr_joint_table *table, unsigned mask,
                          double least, const char *what)
{
    mbsr_joint joint = s->joint;
    joint.table = table;
    mbsr_joint_errors errors;
    mbsr_error error = {0};
    assert_ok(mbsr_joint_verify(&joint, &s->at, &errors, &error), &error);
    for (int k = 0; k < FIELDS; ++k) {
        const double value = *field_of(&errors, k);
        const bool raised = value >= 0.0 && !(value < 1e-8), wanted = (mask >> k & 1) != 0;
        if (raised == wanted && (!wanted || value >= least)) continue;
        print_error("%s with a fault in %s: %s is %.3g (%s)\n", s->name, what, field_name[k], value,
                    errors.text);
        fail();
    }
    double largest = 0.0;
    for (int k = 0; k < FIELDS; ++k) largest = fmax(largest, *field_of(&errors, k));
    assert_close(errors.largest, largest, 0.0);
}

static void find_faults(const subject *s)
{
    static const double factors[] = {-1.0, 0.0, 1.001}; /* sign, term left out, wrong constant */
    const mbsr_joint_table table = wrong_table(&s->joint);
    double p[12], V[12], value;
    const mbsr_joint_args args = right_args(s, p, V);
    broken = (fault){.factor = INFINITY};
    expect_fields(s, &table, 0, 0.0, "nothing");
    for (int field = H; field <= JDOT; ++field) {
        const int entry = largest_entry(s, field, false, &args, &value);
        if (fabs(value) < 1e-3) continue;
        for (int k = 0; k < 3; ++k) {
            broken = (fault){.field = field, .entry = entry, .factor = factors[k]};
            expect_fields(s, &table, 1u << field, 1e-6, field_name[field]);
        }
    }
    broken = (fault){.factor = INFINITY};
}

static void set_general(subject *s, test_joint *data, test_rng *rng)
{
    *data = (test_joint){.d = 3, .d_pred = 2, .n = 2, .a = 0.3};
    test_fill(rng, 9, data->K0);
    for (int k = 0; k < 9; ++k) data->K0[k] = 0.2 * data->K0[k] + (k % 4 == 0 ? 1.5 : 0.0);
    test_fill(rng, 9, data->H0);
    test_fill(rng, 6, data->J0);
    test_fill(rng, TEST_MAX_D, data->h);
    test_fill(rng, TEST_MAX_D, data->w);
    test_fill(rng, TEST_MAX_D, data->g);
    test_fill(rng, TEST_MAX_D, data->v);
    test_fill(rng, TEST_MAX_D, data->c);
    s->name = "general";
    s->joint = mbsr_joint_custom(&test_joint_table, 3, 2, data);
    set_state(s, MBSR_SPACE_GENERAL, rng);
    s->at.pred_d = s->at.pred_np = 2;
}

static void each_fault_is_found_in_its_field(void **state)
{
    (void)state;
    test_rng rng = test_seed(3);
    for (int k = 0; k < SAMPLE_JOINTS; ++k) {
        subject s = {.joint = sample_make(k, &rng).joint};
        s.name = s.joint.table->name;
        set_state(&s, MBSR_SPACE_SPATIAL, &rng);
        find_faults(&s);
        set_state(&s, MBSR_SPACE_PLANAR, &rng);
        find_faults(&s);
    }
    const mbsr_planar_frame A = {0.4, -0.3, 1.1}, B = {-0.2, 0.5, 0.7};
    subject s = {.name = "planar",
                 .joint = mbsr_joint_planar(A, B, MBSR_X | MBSR_ANGLE, MBSR_Y, drive, NULL)};
    set_state(&s, MBSR_SPACE_PLANAR, &rng);
    find_faults(&s);
    test_joint data;
    set_general(&s, &data, &rng);
    find_faults(&s);
}

static void a_wrong_K_shows_in_all_that_it_multiplies(void **state)
{
    (void)state;
    test_rng rng = test_seed(4);
    test_joint data;
    subject s;
    set_general(&s, &data, &rng);
    const mbsr_joint_table table = wrong_table(&s.joint);
    const unsigned mask = 1u << H | 1u << J | 1u << KI | 1u << KII;
    /* an entry off the diagonal, which is constant */
    broken = (fault){.field = KDOT, .of_K = true, .entry = 1, .factor = -1.0};
    expect_fields(&s, &table, mask | 1u << HDOT | 1u << JDOT, 1e-4, "K");
    broken = (fault){.factor = INFINITY};
}

/* ---- poses, coordinates --------------------------------------------------------------------- */

static double G_factor, G_square;

static int wrong_coordinate_rates(const mbsr_joint_args *args, double *qdot)
{
    const int status = original->coordinate_rates(args, qdot);
    for (int k = 0; k < args->nq; ++k) qdot[k] *= G_factor + G_square * args->u[0];
    return status;
}

static int wrong_normalise(const mbsr_joint_args *args, double *q)
{
    (void)args;
    q[0] = -q[0];
    return 0;
}

static int shorten(const mbsr_joint_args *args, double *q)
{
    (void)args;
    for (int k = 0; k < 4; ++k) q[k] *= 0.25;
    return 0;
}

static int scaled_pose(const mbsr_joint_args *args, double *p)
{
    const int status = original->position(args, p);
    for (int k = 0; k < 3; ++k) p[k] *= 1.001;
    return status;
}

static int mirrored_pose(const mbsr_joint_args *args, double *p)
{
    const int status = original->position(args, p);
    for (int k = 0; k < 9; ++k) p[k] = -p[k];
    return status;
}

static void wrong_coordinates_and_poses_are_found(void **state)
{
    (void)state;
    test_rng rng = test_seed(5);
    subject s = {.name = "free", .joint = sample_make(9, &rng).joint};
    set_state(&s, MBSR_SPACE_SPATIAL, &rng);
    mbsr_joint_table table = *s.joint.table;
    original = s.joint.table;
    table.tangent = NULL;
    table.rate_tangent = NULL;
    const unsigned moved = 1u << J | 1u << KII | 1u << HDOT | 1u << JDOT;
    table.coordinate_rates = wrong_coordinate_rates;
    G_factor = 1.01, G_square = 0.0;
    expect_fields(&s, &table, moved, 1e-4, "G");
    G_factor = 1.0, G_square = 0.1;
    expect_fields(&s, &table, moved | 1u << RATES, 1e-4, "G not linear");
    table = *original;
    table.normalise = shorten;
    expect_fields(&s, &table, 0, 0.0, "nothing");
    table.normalise = wrong_normalise;
    expect_fields(&s, &table, 1u << NORMALISE, 1e-2, "normalise");

    mbsr_joint_errors errors;
    mbsr_joint joint = s.joint;
    joint.table = &table;
    table = *original;
    table.position = scaled_pose;
    assert_int_equal(mbsr_joint_verify(&joint, &s.at, &errors, NULL), MBSR_OK);
    assert_less(1e-3, errors.position);
    table.position = mirrored_pose;
    assert_int_equal(mbsr_joint_verify(&joint, &s.at, &errors, NULL), MBSR_OK);
    assert_true(errors.position == 2.0 && errors.largest == 2.0);
    assert_contains(errors.text, "position|R");
}

static int no_bias(const mbsr_joint_args *args, double *kII)
{
    (void)args, (void)kII;
    return 0;
}

/* p = exp(q), u = p': a G that bends. */
static int bent_position(const mbsr_joint_args *args, double *p)
{
    p[0] = exp(args->q[0]);
    return 0;
}

static int bent_jacobians(const mbsr_joint_args *args, double *K, double *Hm, double *Jm,
                          double *kI)
{
    (void)args, (void)K, (void)Hm, (void)kI;
    Jm[0] = -1.0;
    return 0;
}

static int bent_coordinate_rates(const mbsr_joint_args *args, double *qdot)
{
    qdot[0] = exp(-args->q[0]) * args->u[0];
    return 0;
}

static int wrongly_bent(const mbsr_joint_args *args, double *qdot)
{
    qdot[0] = exp(-1.001 * args->q[0]) * args->u[0];
    return 0;
}

static int expected_K; /* whether K is to be there */

static int strict_jacobians(const mbsr_joint_args *args, double *K, double *Hm, double *Jm,
                            double *kI)
{
    if (args->u || args->V || args->V_pred) return 98;
    return (K != NULL) != expected_K ? 99 : bent_jacobians(args, K, Hm, Jm, kI);
}

static int strict_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    (void)Hdot, (void)Jdot;
    return !args->u || !args->V || (Kdot != NULL) != expected_K ? 99 : 0;
}

static int strict_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                          double *dK, double *dH, double *dJ, double *dkI)
{
    (void)dH, (void)dJ, (void)dkI;
    if (args->u || args->V || args->V_pred || !args->p) return 97;
    if (by->u || by->V || by->V_pred || by->p || !by->q) return 98;
    if ((dK != NULL) != expected_K) return 99;
    dp[0] = exp(args->q[0]) * by->q[0];
    return 0;
}

static int strict_rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by,
                               double *dkII, double *dKdot, double *dHdot, double *dJdot,
                               double *dqdot)
{
    (void)dkII, (void)dHdot, (void)dJdot;
    if (!args->u || !args->V || !args->p) return 97;
    if (!by->u || !by->V || !by->p || !by->q) return 98;
    if ((dKdot != NULL) != expected_K || !dqdot) return 99;
    dqdot[0] = exp(-args->q[0]) * (by->u[0] - by->q[0] * args->u[0]);
    return 0;
}

static void functions_are_called_as_the_library_calls_them(void **state)
{
    (void)state;
    mbsr_joint_table table = {.version = MBSR_JOINT_TABLE_VERSION,
                              .name = "strict",
                              .position = bent_position,
                              .jacobians = strict_jacobians,
                              .bias = no_bias,
                              .rates = strict_rates,
                              .coordinate_rates = bent_coordinate_rates,
                              .tangent = strict_tangent,
                              .rate_tangent = strict_rate_tangent};
    test_rng rng = test_seed(12);
    subject s = {.name = "strict", .joint = mbsr_joint_custom(&table, 1, 1, NULL)};
    set_state(&s, MBSR_SPACE_FIXED, &rng);
    mbsr_joint_errors errors;
    mbsr_error error = {0};
    for (expected_K = 0; expected_K < 2; ++expected_K) {
        table.flags = expected_K ? 0u : MBSR_JOINT_UNIT_K;
        assert_ok(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error);
        assert_less(errors.largest, 1e-8);
        assert_int_equal(errors.Kdot < 0.0, !expected_K);
    }
}

static void coordinates_that_bend_are_followed(void **state)
{
    (void)state;
    mbsr_joint_table table = {.version = MBSR_JOINT_TABLE_VERSION,
                              .name = "bent",
                              .position = bent_position,
                              .jacobians = bent_jacobians,
                              .bias = no_bias,
                              .coordinate_rates = bent_coordinate_rates};
    test_rng rng = test_seed(11);
    subject s = {.name = "bent", .joint = mbsr_joint_custom(&table, 1, 1, NULL)};
    set_state(&s, MBSR_SPACE_FIXED, &rng);
    s.q[0] = 0.7, s.u[0] = -1.7;
    expect_fields(&s, &table, 0, 0.0, "nothing");
    table.coordinate_rates = wrongly_bent;
    expect_fields(&s, &table, 1u << J | 1u << KII, 1e-5, "G");
}

static void the_text_names_entry_and_values(void **state)
{
    (void)state;
    test_rng rng = test_seed(6);
    const double axis[3] = {0.0, 0.0, 1.0};
    subject s = {.name = "revolute", .joint = mbsr_joint_revolute(NULL, NULL, axis)};
    set_state(&s, MBSR_SPACE_SPATIAL, &rng);
    mbsr_joint_table table = wrong_table(&s.joint);
    const mbsr_frame unit = mbsr_frame_identity();
    memcpy(s.p_pred, unit.R, sizeof unit.R);
    broken = (fault){.field = J, .entry = 2, .factor = 0.0};
    s.joint.table = &table;
    mbsr_joint_errors errors;
    assert_int_equal(mbsr_joint_verify(&s.joint, &s.at, &errors, NULL), MBSR_OK);
    assert_contains(errors.text, "J(2,0) is |by differences -1");
    broken = (fault){.factor = INFINITY};
}

/* A V that is not p': H, J, kI cannot be told, kII and the rates are compared through (8). */
static void without_V_from_the_pose_kII_and_the_rates_remain(void **state)
{
    (void)state;
    test_rng rng = test_seed(7);
    test_joint data;
    subject s;
    set_general(&s, &data, &rng);
    s.at.V_is_not_rate = 1;
    const mbsr_joint_table table = wrong_table(&s.joint);
    mbsr_joint_errors errors;
    mbsr_error error = {0};
    assert_refused(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error, MBSR_ERR_SPACE,
                   MBSR_NONE, MBSR_NONE, "V_pred must be zero");
    memset(s.V_pred, 0, sizeof s.V_pred);
    assert_ok(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error);
    assert_true((errors.H < 0.0) && (errors.J < 0.0) && (errors.kI < 0.0));
    assert_true(errors.kII < 1e-8 && errors.Kdot < 1e-8 && errors.Hdot < 1e-8 &&
                errors.Jdot < 1e-8);
    double p[12], V[12], value;
    const mbsr_joint_args args = right_args(&s, p, V);
    const int fields[] = {KII, KDOT, JDOT};
    for (int k = 0; k < 3; ++k) {
        broken = (fault){.field = fields[k],
                         .entry = largest_entry(&s, fields[k], false, &args, &value),
                         .factor = -1.0};
        expect_fields(&s, &table, 1u << fields[k], 1e-5, field_name[fields[k]]);
    }
    broken = (fault){.factor = INFINITY};
    /* a body whose V is p' on a predecessor with more numbers than velocities: all but H */
    set_state(&s, MBSR_SPACE_GENERAL, &rng);
    s.at.pred_d = 2, s.at.pred_np = 4;
    memset(s.V_pred, 0, sizeof s.V_pred);
    assert_ok(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error);
    assert_true((errors.H < 0.0) && errors.largest < 1e-8);
    assert_true(errors.J < 1e-8 && errors.kI < 1e-8 && errors.Hdot < 1e-8);
    /* on a predecessor whose V is known */
    data.d_pred = 3;
    set_state(&s, MBSR_SPACE_PLANAR, &rng);
    s.at.V_is_not_rate = 1;
    assert_ok(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error);
    assert_true((errors.H < 0.0) && errors.kII < 1e-8 && errors.Hdot < 1e-8);
}

/* p = q, K = (1 1; 1 1) */
static int singular_position(const mbsr_joint_args *args, double *p)
{
    p[0] = args->q[0], p[1] = args->q[1];
    return 0;
}

static int singular_jacobians(const mbsr_joint_args *args, double *K, double *Hm, double *Jm,
                              double *kI)
{
    (void)args, (void)Hm, (void)kI;
    for (int k = 0; k < 4; ++k) K[k] = 1.0;
    Jm[0] = Jm[3] = -1.0;
    return 0;
}

static int empty_jacobians(const mbsr_joint_args *args, double *K, double *Hm, double *Jm,
                           double *kI)
{
    (void)args, (void)Hm, (void)kI;
    K[3] = 0.0;
    Jm[0] = -1.0;
    return 0;
}

static void a_singular_K_is_refused_where_it_is_needed(void **state)
{
    (void)state;
    static const mbsr_joint_table table = {.version = MBSR_JOINT_TABLE_VERSION,
                                           .name = "folded",
                                           .position = singular_position,
                                           .jacobians = singular_jacobians,
                                           .bias = no_bias};
    test_rng rng = test_seed(10);
    subject s = {.joint = mbsr_joint_custom(&table, 2, 2, NULL)};
    set_state(&s, MBSR_SPACE_FIXED, &rng);
    mbsr_joint_errors errors;
    mbsr_error error = {0};
    assert_ok(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error);
    assert_less(0.1, errors.J);
    s.at.V_is_not_rate = 1;
    assert_refused(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error, MBSR_SINGULAR_K,
                   MBSR_NONE, MBSR_NONE, "joint 'folded'|K is singular");
    /* nothing at all in a row: p[1] is free to be anything, and the numbers are numbers */
    mbsr_joint_table empty = table;
    empty.jacobians = empty_jacobians;
    s.at.V_is_not_rate = 0;
    s.joint.table = &empty;
    assert_ok(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error);
    assert_close(errors.J, 0.0, 1e-9);
    assert_close(errors.kII, 0.0, 1e-9);
}

/* ---- derivatives ---------------------------------------------------------------------------- */

/* One array of what tangent or rate_tangent writes is multiplied by a factor. */
enum { OF_P, OF_K, OF_H, OF_J, OF_KI, OF_KII, OF_KDOT, OF_HDOT, OF_JDOT, OF_QDOT, OF_ALL };
static const char *const written_name[] = {"p",   "K",    "H",    "J",    "kI",
                                           "kII", "Kdot", "Hdot", "Jdot", "qdot"};

static struct {
    int what;
    double factor, largest; /* of the right entries, that were seen */
} slip;

static void slip_in(int what, int count, double *x)
{
    if (slip.what != what || !x) return;
    slip.largest = fmax(slip.largest, test_largest(count, x));
    for (int k = 0; k < count; ++k) x[k] *= slip.factor;
}

static int slipping_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                            double *dK, double *dH, double *dJ, double *dkI)
{
    const int status = original->tangent(args, by, dp, dK, dH, dJ, dkI), d = args->d;
    slip_in(OF_P, args->np, dp);
    slip_in(OF_K, d * d, dK);
    slip_in(OF_H, d * args->pred_d, dH);
    slip_in(OF_J, d * args->n, dJ);
    slip_in(OF_KI, d, dkI);
    return status;
}

static int slipping_rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by,
                                 double *dkII, double *dKdot, double *dHdot, double *dJdot,
                                 double *dqdot)
{
    const int status = original->rate_tangent(args, by, dkII, dKdot, dHdot, dJdot, dqdot),
              d = args->d;
    slip_in(OF_KII, d, dkII);
    slip_in(OF_KDOT, d * d, dKdot);
    slip_in(OF_HDOT, d * args->pred_d, dHdot);
    slip_in(OF_JDOT, d * args->n, dJdot);
    slip_in(OF_QDOT, args->nq, dqdot);
    return status;
}

/* Each array, if there is something in it, with a wrong sign, left out, and with a wrong constant;
 * returns the set of those in which there is something. */
static unsigned find_slips(const subject *s)
{
    static const double factors[] = {-1.0, 0.0, 1.001};
    unsigned seen = 0;
    original = s->joint.table;
    mbsr_joint_table table = *original;
    table.tangent = slipping_tangent;
    table.rate_tangent = slipping_rate_tangent;
    for (slip.what = 0; slip.what < OF_ALL; ++slip.what) {
        slip.largest = 0.0, slip.factor = 1.0;
        expect_fields(s, &table, 0, 0.0, "nothing");
        if (!(slip.largest > 1e-3)) continue;
        seen |= 1u << slip.what;
        for (int k = 0; k < 3; ++k) {
            slip.factor = factors[k];
            const unsigned field = slip.what < OF_KII ? TANGENT : RATE_TANGENT;
            expect_fields(s, &table, 1u << field, 1e-7, written_name[slip.what]);
        }
    }
    return seen;
}

static double dot(int n, const double *x, const double *y)
{
    double sum = 0.0;
    for (int k = 0; k < n; ++k) sum += x[k] * y[k];
    return sum;
}

/* The derivatives of test_joint_table (tree.c), whose K is not the unit matrix. K dp = -(H dp_pred
 * + J dq) is solved line by line, again and again. */
static int bent_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                        double *dK, double *dH, double *dJ, double *dkI)
{
    const test_joint *j = args->user;
    const int d = j->d;
    const double y = dot(j->d_pred, j->w, args->p_pred), dy = dot(j->d_pred, j->w, by->p_pred),
                 z = dot(j->n, j->v, args->q), dz = dot(j->n, j->v, by->q);
    (void)dkI;
    for (int l = 0; l < 60 * d; ++l) {
        const int r = l % d;
        double sum = j->a * (cos(y) * dy * j->h[r] + cos(z) * dz * j->g[r]);
        for (int c = 0; c < j->d_pred; ++c) sum += j->H0[c * d + r] * by->p_pred[c];
        for (int c = 0; c < j->n; ++c) sum += j->J0[c * d + r] * by->q[c];
        for (int c = 0; c < d; ++c) sum += c == r ? 0.0 : j->K0[c * d + r] * dp[c];
        dp[r] = -sum / (j->K0[r * d + r] + j->a * cos(args->p[r]));
    }
    for (int r = 0; r < d; ++r) {
        dK[r * d + r] = -j->a * sin(args->p[r]) * dp[r];
        for (int c = 0; c < j->d_pred; ++c) dH[c * d + r] = -j->a * sin(y) * dy * j->h[r] * j->w[c];
        for (int c = 0; c < j->n; ++c) dJ[c * d + r] = -j->a * sin(z) * dz * j->g[r] * j->v[c];
    }
    return 0;
}

static int bent_rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dkII,
                             double *dKdot, double *dHdot, double *dJdot, double *dqdot)
{
    const test_joint *j = args->user;
    const int d = j->d, m = j->d_pred, n = j->n;
    const double *p = args->p, *V = args->V;
    const double y = dot(m, j->w, args->p_pred), dy = dot(m, j->w, by->p_pred),
                 z = dot(n, j->v, args->q), dz = dot(n, j->v, by->q),
                 w = dot(m, j->w, args->V_pred), dw = dot(m, j->w, by->V_pred),
                 v = dot(n, j->v, args->u), dv = dot(n, j->v, by->u);
    const double pred = cos(y) * dy * w + sin(y) * dw, own = cos(z) * dz * v + sin(z) * dv;
    if (dqdot) return 99;
    for (int r = 0; r < d; ++r) {
        const double rate = cos(p[r]) * by->p[r] * V[r] + sin(p[r]) * by->V[r];
        dkII[r] = -j->a * ((rate + sin(p[r]) * by->V[r]) * V[r] +
                           j->h[r] * (pred + sin(y) * dw) * w + j->g[r] * (own + sin(z) * dv) * v);
        dKdot[r * d + r] = -j->a * rate;
        for (int c = 0; c < m; ++c) dHdot[c * d + r] = -j->a * pred * j->h[r] * j->w[c];
        for (int c = 0; c < n; ++c) dJdot[c * d + r] = -j->a * own * j->g[r] * j->v[c];
    }
    return 0;
}

static mbsr_joint_table general_table(void)
{
    mbsr_joint_table table = test_joint_table;
    table.tangent = bent_tangent;
    table.rate_tangent = bent_rate_tangent;
    return table;
}

static void each_wrong_derivative_is_found(void **state)
{
    (void)state;
    test_rng rng = test_seed(13);
    unsigned seen = 0;
    for (int k = 0; k < SAMPLE_JOINTS; ++k) {
        subject s = {.joint = sample_make(k, &rng).joint};
        s.name = s.joint.table->name;
        for (int l = 0; l < 2; ++l) {
            set_state(&s, l ? MBSR_SPACE_PLANAR : MBSR_SPACE_SPATIAL, &rng);
            seen |= find_slips(&s);
        }
    }
    assert_int_equal(seen, 1u << OF_P | 1u << OF_H | 1u << OF_J | 1u << OF_KI | 1u << OF_KII |
                               1u << OF_HDOT | 1u << OF_JDOT | 1u << OF_QDOT);
    const mbsr_planar_frame A = {0.4, -0.3, 1.1}, B = {-0.2, 0.5, 0.7};
    subject s = {.name = "planar",
                 .joint = mbsr_joint_planar(A, B, MBSR_X | MBSR_ANGLE, MBSR_Y, drive, NULL)};
    set_state(&s, MBSR_SPACE_PLANAR, &rng);
    seen = find_slips(&s);
    assert_int_equal(seen, 1u << OF_P | 1u << OF_H | 1u << OF_J | 1u << OF_KI | 1u << OF_KII |
                               1u << OF_HDOT | 1u << OF_JDOT);
    test_joint data;
    const mbsr_joint_table table = general_table();
    set_general(&s, &data, &rng);
    s.joint.table = &table;
    assert_int_equal(find_slips(&s), 1u << OF_P | 1u << OF_K | 1u << OF_H | 1u << OF_J |
                                         1u << OF_KII | 1u << OF_KDOT | 1u << OF_HDOT |
                                         1u << OF_JDOT);
    /* the same where V is not p' */
    s.at.V_is_not_rate = 1;
    memset(s.V_pred, 0, sizeof s.V_pred);
    find_slips(&s);
}

/* One entry is wrong along one direction only. */
static int wrong_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                         double *dK, double *dH, double *dJ, double *dkI)
{
    const int status = original->tangent(args, by, dp, dK, dH, dJ, dkI);
    dJ[4] += by->q[0] / args->q[0];
    return status;
}

/* Errors of a thousandth beside numbers in other units: q' of a small quaternion beside that of
 * lengths, R beside r. */
static int wrong_in_turning(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dkII,
                            double *dKdot, double *dHdot, double *dJdot, double *dqdot)
{
    const int status = original->rate_tangent(args, by, dkII, dKdot, dHdot, dJdot, dqdot);
    for (int k = 0; k < 4; ++k) dqdot[k] *= 1.001;
    return status;
}

static int wrong_in_R(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                      double *dK, double *dH, double *dJ, double *dkI)
{
    const int status = original->tangent(args, by, dp, dK, dH, dJ, dkI);
    for (int k = 0; k < MBSR_POSE_X; ++k) dp[k] *= 1.001;
    return status;
}

/* A quaternion need not have length 1; one of the directions of q then leads nowhere, and q' has
 * nothing in it along (1, 0, 0, 0). */
static void quaternions_of_any_length_are_tested(void **state)
{
    (void)state;
    static const double lengths[] = {1e-6, 1e-2, 1e2, 1e6};
    test_rng rng = test_seed(14);
    for (int k = 8; k < 10; ++k) {
        subject s = {.joint = sample_make(k, &rng).joint};
        s.name = s.joint.table->name;
        original = s.joint.table;
        for (int l = 0; l < 8; ++l) {
            set_state(&s, MBSR_SPACE_SPATIAL, &rng);
            for (int c = 0; c < 4; ++c) s.q[c] = c && l > 3 ? 0.0 : s.q[c] * lengths[l % 4];
            mbsr_joint_table table = *original;
            expect_fields(&s, &table, 0, 0.0, "nothing");
            table.tangent = wrong_tangent;
            expect_fields(&s, &table, 1u << TANGENT, 1e-6, "J");
            table = *original;
            table.rate_tangent = wrong_in_turning;
            expect_fields(&s, &table, 1u << RATE_TANGENT, 1e-4, "q'");
        }
    }
}

/* p = 1e4 (cos q, sin q), V = q' */
static int round_position(const mbsr_joint_args *args, double *p)
{
    p[0] = 1e4 * cos(args->q[0]), p[1] = 1e4 * sin(args->q[0]);
    return 0;
}

static int round_jacobians(const mbsr_joint_args *args, double *K, double *Hm, double *Jm,
                           double *kI)
{
    (void)args, (void)K, (void)Hm, (void)kI;
    Jm[0] = -1.0;
    return 0;
}

static int round_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                         double *dK, double *dH, double *dJ, double *dkI)
{
    (void)dK, (void)dH, (void)dJ, (void)dkI;
    dp[0] = -1e4 * sin(args->q[0]) * by->q[0], dp[1] = 1e4 * cos(args->q[0]) * by->q[0];
    return 0;
}

static void a_pose_in_large_numbers_passes(void **state)
{
    (void)state;
    static const mbsr_joint_table table = {.version = MBSR_JOINT_TABLE_VERSION,
                                           .flags = MBSR_JOINT_UNIT_K,
                                           .name = "round",
                                           .position = round_position,
                                           .jacobians = round_jacobians,
                                           .bias = no_bias,
                                           .tangent = round_tangent};
    test_rng rng = test_seed(17);
    subject s = {.name = "round", .joint = mbsr_joint_custom(&table, 1, 1, NULL)};
    s.joint.np = 2;
    set_state(&s, MBSR_SPACE_FIXED, &rng);
    expect_fields(&s, &table, 0, 0.0, "nothing");
    mbsr_joint_errors errors;
    assert_int_equal(mbsr_joint_verify(&s.joint, &s.at, &errors, NULL), MBSR_OK);
    assert_true(!(errors.tangent < 0.0));
    original = &table;
    mbsr_joint_table wrong = table;
    wrong.tangent = slipping_tangent;
    slip.what = OF_P, slip.factor = 1.001;
    expect_fields(&s, &wrong, 1u << TANGENT, 1e-4, "p");
}

static void units_do_not_hide_wrong_derivatives(void **state)
{
    (void)state;
    test_rng rng = test_seed(16);
    const mbsr_frame A = test_frame(&rng, 1e3), B = test_frame(&rng, 1e3);
    const double axis[3] = {0.0, 0.6, 0.8};
    subject s = {.name = "revolute", .joint = mbsr_joint_revolute(&A, &B, axis)};
    set_state(&s, MBSR_SPACE_SPATIAL, &rng);
    for (int k = 0; k < 3; ++k) s.p_pred[MBSR_POSE_X + k] *= 1e3, s.V_pred[3 + k] *= 1e3;
    original = s.joint.table;
    mbsr_joint_table table = *original;
    expect_fields(&s, &table, 0, 0.0, "nothing");
    table.tangent = wrong_in_R;
    expect_fields(&s, &table, 1u << TANGENT, 1e-4, "R");
    s.at.pred_space = MBSR_SPACE_FIXED;
    expect_fields(&s, &table, 1u << TANGENT, 1e-4, "R");
    /* k in a unit of its own */
    test_joint data;
    set_general(&s, &data, &rng);
    data.a *= 1e6;
    for (int k = 0; k < 9; ++k) data.K0[k] *= 1e6, data.H0[k] *= 1e6, data.J0[k] *= 1e6;
    for (int k = 0; k < 3; ++k) data.c[k] *= 1e6;
    table = general_table();
    s.joint.table = &table;
    find_slips(&s);
}

static int wrong_along_V_pred(const mbsr_joint_args *args, const mbsr_joint_change *by,
                              double *dkII, double *dKdot, double *dHdot, double *dJdot,
                              double *dqdot)
{
    const int status = original->rate_tangent(args, by, dkII, dKdot, dHdot, dJdot, dqdot);
    dkII[3] += by->V_pred[5];
    return status;
}

static int wrong_along_u(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dkII,
                         double *dKdot, double *dHdot, double *dJdot, double *dqdot)
{
    const int status = original->rate_tangent(args, by, dkII, dKdot, dHdot, dJdot, dqdot);
    dJdot[1] += by->u[0];
    return status;
}

static int wrong_pose_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                              double *dK, double *dH, double *dJ, double *dkI)
{
    const int status = original->tangent(args, by, dp, dK, dH, dJ, dkI);
    dp[MBSR_POSE_X + 1] += by->p_pred[MBSR_POSE_X + 2];
    return status;
}

/* Right along each direction, but not linear. */
static int curved_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                          double *dK, double *dH, double *dJ, double *dkI)
{
    const int status = original->tangent(args, by, dp, dK, dH, dJ, dkI);
    dH[3] += by->q[0] * by->p_pred[MBSR_POSE_X];
    return status;
}

static void the_text_names_direction_and_entry_of_a_wrong_derivative(void **state)
{
    (void)state;
    test_rng rng = test_seed(15);
    subject s = {.joint = sample_make(1, &rng).joint};
    set_state(&s, MBSR_SPACE_SPATIAL, &rng);
    original = s.joint.table;
    const struct {
        int (*tangent)(const mbsr_joint_args *, const mbsr_joint_change *, double *, double *,
                       double *, double *, double *);
        int (*rate_tangent)(const mbsr_joint_args *, const mbsr_joint_change *, double *, double *,
                            double *, double *, double *);
        int field;
        const char *words;
    } list[] = {
        {wrong_tangent, NULL, TANGENT, "tangent along q(0): J(4,0) is |, by differences "},
        {wrong_pose_tangent, NULL, TANGENT,
         "tangent along the predecessor's pose(5): p(10) is 1,|"},
        {curved_tangent, NULL, TANGENT, "tangent along all at once: H(3,0) is "},
        {NULL, wrong_along_V_pred, RATE_TANGENT, "rate_tangent along V_pred(5): kII(3,0) is "},
        {NULL, wrong_along_u, RATE_TANGENT, "rate_tangent along u(0): Jdot(1,0) is "},
    };
    for (size_t k = 0; k < sizeof list / sizeof list[0]; ++k) {
        mbsr_joint_table table = *original;
        table.tangent = list[k].tangent, table.rate_tangent = list[k].rate_tangent;
        expect_fields(&s, &table, 1u << list[k].field, 1e-4, list[k].words);
        mbsr_joint joint = s.joint;
        joint.table = &table;
        mbsr_joint_errors errors;
        assert_int_equal(mbsr_joint_verify(&joint, &s.at, &errors, NULL), MBSR_OK);
        assert_contains(errors.text, list[k].words);
        assert_true((errors.tangent < 0.0) == !list[k].tangent);
        assert_true((errors.rate_tangent < 0.0) == !list[k].rate_tangent);
    }
    /* kII alone where there are no rates to differ */
    mbsr_joint_table table = *original;
    table.rates = NULL;
    expect_fields(&s, &table, 0, 0.0, "nothing");
    table.rate_tangent = wrong_along_u;
    expect_fields(&s, &table, 0, 0.0, "nothing");
    table.rate_tangent = wrong_along_V_pred;
    expect_fields(&s, &table, 1u << RATE_TANGENT, 1e-4, "kII");
}

/* ---- refusals ------------------------------------------------------------------------------- */

static int answer, writes_nan; /* of the function number `which`, in its call number `at` */
static int which, at, calls;

static int reply(int function, double *x)
{
    if (function != which || ++calls != at) return 0;
    if (writes_nan && x) x[0] = NAN;
    return answer;
}

static int say_position(const mbsr_joint_args *args, double *p)
{
    const int status = original->position(args, p);
    return status ? status : reply(0, p);
}

static int say_jacobians(const mbsr_joint_args *args, double *K, double *Hm, double *Jm, double *kI)
{
    const int status = original->jacobians(args, K, Hm, Jm, kI);
    return status ? status : reply(1, kI);
}

static int say_bias(const mbsr_joint_args *args, double *kII)
{
    const int status = original->bias(args, kII);
    return status ? status : reply(2, kII);
}

static int say_rates(const mbsr_joint_args *args, double *Kdot, double *Hdot, double *Jdot)
{
    const int status = original->rates(args, Kdot, Hdot, Jdot);
    return status ? status : reply(3, Jdot);
}

static int say_coordinate_rates(const mbsr_joint_args *args, double *qdot)
{
    const int status = original->coordinate_rates(args, qdot);
    return status ? status : reply(4, qdot);
}

static int say_normalise(const mbsr_joint_args *args, double *q)
{
    const int status = original->normalise(args, q);
    return status ? status : reply(5, q);
}

static int say_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dp,
                       double *dK, double *dH, double *dJ, double *dkI)
{
    const int status = original->tangent(args, by, dp, dK, dH, dJ, dkI);
    return status ? status : reply(6, dkI);
}

static int say_rate_tangent(const mbsr_joint_args *args, const mbsr_joint_change *by, double *dkII,
                            double *dKdot, double *dHdot, double *dJdot, double *dqdot)
{
    const int status = original->rate_tangent(args, by, dkII, dKdot, dHdot, dJdot, dqdot);
    return status ? status : reply(7, dqdot);
}

static void what_a_function_returns_is_passed_on(void **state)
{
    (void)state;
    static const char *const names[] = {"position",         "jacobians", "bias",    "rates",
                                        "coordinate_rates", "normalise", "tangent", "rate_tangent"};
    test_rng rng = test_seed(8);
    subject s = {.joint = sample_make(9, &rng).joint};
    set_state(&s, MBSR_SPACE_SPATIAL, &rng);
    original = s.joint.table;
    mbsr_joint_table table = *s.joint.table;
    table.position = say_position, table.jacobians = say_jacobians, table.bias = say_bias;
    table.rates = say_rates, table.coordinate_rates = say_coordinate_rates;
    table.normalise = say_normalise;
    table.tangent = say_tangent, table.rate_tangent = say_rate_tangent;
    s.joint.table = &table;
    mbsr_joint_errors errors;
    mbsr_error error = {0};
    for (which = 0; which < 8; ++which) {
        char words[80];
        calls = 0, at = -1;
        assert_ok(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error);
        const int last = calls;
        for (int k = 0; k < 2; ++k) {
            at = k ? last : 1;
            calls = 0, answer = 17, writes_nan = 0;
            snprintf(words, sizeof words, "joint 'free'|%s returned 17", names[which]);
            assert_refused(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error, 17,
                           MBSR_NONE, MBSR_NONE, words);
            calls = 0, answer = 0, writes_nan = 1;
            snprintf(words, sizeof words, "joint 'free'|what %s wrote is not finite", names[which]);
            assert_refused(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error,
                           MBSR_NOT_FINITE, MBSR_NONE, MBSR_NONE, words);
        }
    }
}

static void wrong_calls_are_refused(void **state)
{
    (void)state;
    test_rng rng = test_seed(9);
    const double axis[3] = {0.0, 0.6, 0.8}, none[3] = {0.0, 0.0, 0.0};
    const subject good = {.joint = mbsr_joint_revolute(NULL, NULL, axis)};
    mbsr_joint_errors errors;
    mbsr_error error = {0};
    subject s = good;
    set_state(&s, MBSR_SPACE_SPATIAL, &rng);
    assert_int_equal(mbsr_joint_verify(NULL, &s.at, &errors, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_joint_verify(&s.joint, NULL, &errors, NULL), MBSR_ERR_NULL);
    assert_int_equal(mbsr_joint_verify(&s.joint, &s.at, NULL, NULL), MBSR_ERR_NULL);
    mbsr_joint_test raw = {.q = s.q, .u = s.u, .step = 0.001};
    assert_int_equal(mbsr_joint_verify(&s.joint, &raw, &errors, NULL), MBSR_ERR_NO_DEFAULT);
#define REFUSES(status, words)                                                                     \
    assert_refused(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error, (status),          \
                   MBSR_NONE, MBSR_NONE, "mbsr_joint_verify|" words);                              \
    s.joint = good.joint;                                                                          \
    set_state(&s, MBSR_SPACE_SPATIAL, &rng)
    s.at.q = NULL;
    REFUSES(MBSR_ERR_NULL, "q is NULL");
    s.at.V_pred = NULL;
    REFUSES(MBSR_ERR_NULL, "V_pred is NULL");
    s.u[0] = NAN;
    REFUSES(MBSR_ERR_VALUE, "u is not finite");
    s.p_pred[11] = INFINITY;
    REFUSES(MBSR_ERR_VALUE, "p_pred is not finite");
    s.at.step = 0.0;
    REFUSES(MBSR_ERR_VALUE, "step is 0");
    s.at.step = NAN;
    REFUSES(MBSR_ERR_VALUE, "step is nan");
    s.at.t = INFINITY;
    REFUSES(MBSR_ERR_VALUE, "t is inf");
    s.at.pred_space = (mbsr_space)9;
    REFUSES(MBSR_ERR_VALUE, "pred_space = 9");
    s.at.pred_space = MBSR_SPACE_GENERAL;
    REFUSES(MBSR_ERR_VALUE, "pred_d = 0");
    s.at.pred_space = MBSR_SPACE_GENERAL;
    s.at.pred_d = s.at.pred_np = 6;
    REFUSES(MBSR_ERR_SPACE, "joint 'revolute'|GENERAL");
    s.joint = mbsr_joint_revolute(NULL, NULL, none);
    REFUSES(MBSR_ERR_VALUE, "joint 'revolute'|axis 0|length 0");
    s.joint.table = NULL;
    REFUSES(MBSR_ERR_VALUE, "table is NULL");
    s.joint.d = 5;
    REFUSES(MBSR_ERR_VALUE, "joint 'revolute'|d = 5");
#undef REFUSES
    /* memory */
    test_counting counting = {.fail_at = 1};
    s.at.allocator = test_counting_allocator(&counting);
    assert_refused(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error, MBSR_ERR_NO_MEMORY,
                   MBSR_NONE, MBSR_NONE, "memory");
    counting.fail_at = 0;
    assert_ok(mbsr_joint_verify(&s.joint, &s.at, &errors, &error), &error);
    assert_int_equal(counting.live, 0);
    assert_int_equal(counting.calls, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planar_joints_pass),
        cmocka_unit_test(joints_in_space_pass),
        cmocka_unit_test(each_fault_is_found_in_its_field),
        cmocka_unit_test(a_wrong_K_shows_in_all_that_it_multiplies),
        cmocka_unit_test(wrong_coordinates_and_poses_are_found),
        cmocka_unit_test(each_wrong_derivative_is_found),
        cmocka_unit_test(quaternions_of_any_length_are_tested),
        cmocka_unit_test(a_pose_in_large_numbers_passes),
        cmocka_unit_test(units_do_not_hide_wrong_derivatives),
        cmocka_unit_test(the_text_names_direction_and_entry_of_a_wrong_derivative),
        cmocka_unit_test(functions_are_called_as_the_library_calls_them),
        cmocka_unit_test(coordinates_that_bend_are_followed),
        cmocka_unit_test(the_text_names_entry_and_values),
        cmocka_unit_test(without_V_from_the_pose_kII_and_the_rates_remain),
        cmocka_unit_test(a_singular_K_is_refused_where_it_is_needed),
        cmocka_unit_test(what_a_function_returns_is_passed_on),
        cmocka_unit_test(wrong_calls_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
