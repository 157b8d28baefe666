/* What report, start, forward dynamics and Newton's matrix say of directions without mass, of trees
 * and closed models whose bodies stand on axes, in lines and in each other's planes, in four
 * systems of units: they never contradict each other, every damped direction has an element, and
 * none lies in the span of the others.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "any_model.h"
#include "duration.h"
#include "expect.h"

#include <mbsrank/mbsrank.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* ---- verdicts ---- */

typedef struct verdict {
    int report, forward, start, newton; /* statuses */
    int dynamic, damped, elastic, undetermined, held;
} verdict;

/* What a start finds, as in SI. */
typedef struct motion {
    double u[ANY_MOST], udot[ANY_MOST];
} motion;

/* The rank of rows (count x n), which get lost. */
static int rank_of(int count, int n, double *A)
{
    int rank = 0;
    for (; rank < count; ++rank) {
        int row = -1, column = 0;
        double largest = 1e-7;
        for (int k = rank * n; k < count * n; ++k) {
            if (fabs(A[k]) > largest) largest = fabs(A[k]), row = k / n, column = k % n;
        }
        if (row < 0) break;
        for (int j = 0; j < n; ++j) {
            const double entry = A[row * n + j];
            A[row * n + j] = A[rank * n + j];
            A[rank * n + j] = entry;
        }
        for (int i = rank + 1; i < count; ++i) {
            const double part = A[i * n + column] / A[rank * n + column];
            for (int j = 0; j < n; ++j) A[i * n + j] -= part * A[rank * n + j];
        }
    }
    return rank;
}

static void check_directions(const any_model *s, const mbsr_index_report *report)
{
    double rates[ANY_MOST * ANY_MOST] = {0.0};
    for (int k = 0; k < report->directions; ++k) {
        const mbsr_direction *direction = report->direction + k;
        double *row = rates + k * s->nu;
        for (int l = 0; l < direction->terms; ++l) {
            const mbsr_direction_term *term = direction->term + l;
            const int at = s->first[term->body] + term->coordinate;
            row[at] = term->weight / (s->turns[at] ? 1.0 : s->of->length);
        }
        const double largest = test_largest(s->nu, row);
        for (int l = 0; l < s->nu; ++l) row[l] /= largest;
        if (direction->kind == MBSR_DIRECTION_DAMPED)
            assert_true(direction->forces + direction->closures > 0);
    }
    assert_int_equal(rank_of(report->directions, s->nu, rates), report->directions);
}

/* The largest difference of x and y beside the largest of these and `least`. */
static double apart(int n, const double *x, const double *y, double least)
{
    double most = 0.0;
    for (int k = 0; k < n; ++k) most = fmax(most, fabs(x[k] - y[k]));
    return most / fmax(least, fmax(test_largest(n, x), test_largest(n, y)));
}

/* Accelerations from velocities alone are those of the start. */
static void check_dynamics(const any_model *s, mbsr_data *d, const double *y, const double *yp,
                           double most)
{
    const double *u = y + s->nq + s->nu, *udot = yp + s->nq + s->nu,
                 second = s->of->time * s->of->time;
    mbsr_completion *completion;
    double found[ANY_MOST], apace[ANY_MOST];
    assert_ok(mbsr_completion_create(s->m, NULL, &completion, NULL), NULL);
    assert_ok(mbsr_completion_dynamics(completion, d, 0.0, y, u, NULL, found, NULL),
              mbsr_completion_error(completion));
    for (int k = 0; k < s->nu; ++k) {
        const double unit = (s->turns[k] ? 1.0 : s->of->length) / second;
        found[k] /= unit, apace[k] = udot[k] / unit;
    }
    assert_less(apart(s->nu, found, apace, 1.0), most);
    mbsr_completion_destroy(completion);
}

/* A start from where one has led leads nowhere else. */
static void check_again(const any_model *s, mbsr_data *d, const double *y)
{
    double again[4 * ANY_MOST], rate[4 * ANY_MOST], before[ANY_MOST], after[ANY_MOST];
    memcpy(again, y, sizeof again);
    assert_ok(mbsr_dae_consistent(s->m, d, MBSR_DAE_MOMENTUM, 0.0, again, rate, NULL, NULL),
              mbsr_data_error(d));
    for (int k = 0; k < s->nu; ++k) {
        const double unit = (s->turns[k] ? 1.0 : s->of->length) / s->of->time;
        before[k] = y[s->nq + s->nu + k] / unit, after[k] = again[s->nq + s->nu + k] / unit;
    }
    assert_less(apart(s->nu, before, after, 1.0), 1e-9);
}

static void note_motion(const any_model *s, const double *y, const double *yp, motion *found)
{
    for (int k = 0; k < s->nu; ++k) {
        const double unit = (s->turns[k] ? 1.0 : s->of->length) / s->of->time;
        found->u[k] = y[s->nq + s->nu + k] / unit;
        found->udot[k] = yp[s->nq + s->nu + k] * s->of->time / unit;
    }
}

static verdict report_at(const any_model *s, mbsr_data *d, const double *q, const double *u)
{
    mbsr_index_report *report;
    verdict v = {.report = mbsr_index_report_create(s->m, d, 0.0, q, u, &report)};
    if (v.report) return v;
    check_directions(s, report);
    v.dynamic = report->dynamic, v.held = report->loop_supported;
    v.damped = report->damped, v.elastic = report->elastic;
    v.undetermined = report->undetermined;
    mbsr_index_report_destroy(s->m, report);
    return v;
}

static verdict judge(const any_model *s, motion *found)
{
    mbsr_data *d;
    mbsr_newton *newton;
    double u[ANY_MOST] = {0.0}, udot[ANY_MOST], y[4 * ANY_MOST] = {0.0}, yp[4 * ANY_MOST];
    assert_true(s->nq <= ANY_MOST && mbsr_dae_size(s->m, MBSR_DAE_MOMENTUM) <= 4 * ANY_MOST);
    assert_ok(mbsr_data_create(s->m, &d, NULL), NULL);
    verdict v = report_at(s, d, s->q, u);
    v.forward = mbsr_forward_dynamics(s->m, d, 0.0, s->q, u, NULL, udot);
    assert_ok(mbsr_dae_pack(s->m, d, MBSR_DAE_MOMENTUM, 0.0, s->q, u, y), mbsr_data_error(d));
    v.start = mbsr_dae_consistent(s->m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
    if (!v.start) {
        assert_ok(mbsr_newton_create(s->m, MBSR_DAE_MOMENTUM, NULL, &newton, NULL), NULL);
        v.newton = mbsr_newton_factor(newton, d, 0.0, y, yp, 1e3 / s->of->time);
        mbsr_newton_destroy(newton);
        note_motion(s, y, yp, found);
        if (v.dynamic > 0 && v.elastic == 0 && v.newton == MBSR_OK)
            check_dynamics(s, d, y, yp, 1e-6);
        if (!v.report && v.elastic == 0) check_again(s, d, y);
    }
    mbsr_data_destroy(d);
    return v;
}

/* A start that moves to where springs are at rest may find there what their tension held. */
static void check(const verdict *v)
{
    const int directions = v->damped + v->elastic + v->undetermined;
    assert_int_not_equal(v->report, MBSR_INDEFINITE_MASS);
    assert_int_not_equal(v->forward, MBSR_INDEFINITE_MASS);
    assert_int_not_equal(v->start, MBSR_INDEFINITE_MASS);
    if (v->report) return;
    assert_int_equal(v->forward == MBSR_UNDETERMINED, directions > 0);
    if (v->undetermined > 0) assert_int_not_equal(v->start, MBSR_OK);
    if (v->undetermined + v->elastic == 0) assert_int_not_equal(v->start, MBSR_UNDETERMINED);
    if (v->undetermined == 0) assert_int_not_equal(v->newton, MBSR_SINGULAR_BLOCK);
}

/* The verdict in SI, once it is checked and found the same in all systems of units; false: there is
 * no such model. */
static bool find_verdict(uint64_t seed, verdict *first)
{
    bool made = false;
    motion one, other;
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        any_model s;
        if (!any_model_make(&s, seed, systems + k, false)) break;
        verdict v = judge(&s, k == 0 ? &one : &other);
        check(&v);
        v.start = v.start != MBSR_OK; /* what a refused one calls its reason may differ */
        if (k == 0) *first = v;
        assert_memory_equal(&v, first, sizeof v);
        if (k > 0 && v.start == 0 && v.elastic == 0 && v.dynamic > 0) {
            assert_less(apart(s.nu, one.u, other.u, 1.0), 1e-8);
            assert_less(apart(s.nu, one.udot, other.udot, 1.0), 1e-6);
        }
        mbsr_model_destroy(s.m);
        made = true;
    }
    return made;
}

static void verdicts_agree(void **state)
{
    (void)state;
    const int seeds = test_long() ? 150 : test_seeds_short(15, 40);
    int models = 0, singular = 0, open = 0;
    for (uint64_t seed = 1; seed <= (uint64_t)seeds; ++seed) {
        verdict v;
        if (!find_verdict(seed, &v)) continue;
        ++models;
        singular += v.forward == MBSR_UNDETERMINED;
        open += v.undetermined > 0;
    }
    assert_true(models > seeds / 2 && singular > seeds / 4 && open > seeds / 10);
}

/* Where few are asked for, every other one. */
static void check_seeds(size_t count, const uint64_t *seed)
{
    for (size_t k = 0; k < count; k += (size_t)test_seeds(2, 1)) {
        verdict v;
        assert_true(find_verdict(seed[k], &v));
    }
}

/* A row reads bodies along an axis, of whose other components rounding is left. */
static void rows_that_see_traces(void **state)
{
    (void)state;
    static const uint64_t seed[] = {193, 2761, 90971, 100701};
    check_seeds(4, seed);
}

/* Weights on bodies without mass have no part in directions that turn these about them. */
static void weights_that_do_not_move(void **state)
{
    (void)state;
    static const uint64_t seed[] = {222, 223};
    check_seeds(2, seed);
}

/* Particles at origins have no radius that the size of the model could be told from. */
static void masses_without_radius(void **state)
{
    (void)state;
    static const uint64_t seed[] = {315, 367, 3103};
    check_seeds(3, seed);
}

/* Rows hold all that there is, and the accelerations that are solved for are rounding of forces. */
static void nothing_left_to_move(void **state)
{
    (void)state;
    static const uint64_t seed[] = {1249, 9799};
    check_seeds(2, seed);
}

/* Forces of loops that are nothing but rounding; rows that hold turning and sliding. */
static void loops_without_load(void **state)
{
    (void)state;
    static const uint64_t seed[] = {1855, 53747, 91565, 300077, 301359, 302009, 19071};
    check_seeds(test_long() ? 7 : 6, seed);
}

/* What loop forces leave of a balance is a moment in the one system and a larger number in another.
 */
static void balances_of_moments(void **state)
{
    (void)state;
    static const uint64_t seed[] = {301015, 301085, 301355};
    check_seeds(3, seed);
}

/* What nothing determines at the state given and springs do elsewhere; velocities of 1e32 rad/s at
 * which nothing but rounding balances. */
static void balances_out_of_reach(void **state)
{
    (void)state;
    static const uint64_t seed[] = {310100, 311328};
    check_seeds(test_long() ? 2 : 1, seed);
}

/* Models without any mass, whose loops are closed by rates of both kinds; ways to a balance that
 * are crawled, on which rounding decides where they lead. */
static void balances_by_the_same_way(void **state)
{
    (void)state;
    static const uint64_t seed[] = {320581, 331969, 311047};
    check_seeds(test_long() ? 3 : 1, seed);
}

/* Dampers that settle faster than the matrices' c: impulses and accelerations to 1e-9 all the same.
 */
static void fast_dampers_beside_loops(void **state)
{
    (void)state;
    static const uint64_t seed[] = {311357, 331485};
    check_seeds(2, seed);
}

/* ---- rich models ---- */

/* A start, what report and Newton's matrix say of where it leads, and that the report says so
 * whether rows have been left out before or not. */
static void find_start(const any_model *s, mbsr_data *d, verdict *v)
{
    mbsr_data *fresh;
    mbsr_newton *newton;
    double y[6 * ANY_MOST] = {0.0}, yp[6 * ANY_MOST], still[ANY_MOST] = {0.0};
    assert_ok(mbsr_dae_pack(s->m, d, MBSR_DAE_MOMENTUM, 0.0, s->q, still, y), mbsr_data_error(d));
    v->start = mbsr_dae_consistent(s->m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
    if (v->start) return;
    const double *u = y + s->nq + s->nu;
    assert_ok(mbsr_data_create(s->m, &fresh, NULL), NULL);
    const verdict here = report_at(s, d, y, u), anew = report_at(s, fresh, y, u);
    assert_memory_equal(&here, &anew, sizeof here);
    assert_int_equal(here.undetermined, 0);
    assert_ok(mbsr_newton_create(s->m, MBSR_DAE_MOMENTUM, NULL, &newton, NULL), NULL);
    v->newton = mbsr_newton_factor(newton, d, 0.0, y, yp, 1e3 / s->of->time);
    mbsr_newton_destroy(newton);
    mbsr_data_destroy(fresh);
}

/* Starts of models that are elastic take long where there is no state of balance. */
static bool check_rich(uint64_t seed, bool elastic)
{
    bool made = false;
    verdict first = {0};
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        any_model s;
        mbsr_data *d;
        double still[ANY_MOST] = {0.0}, udot[ANY_MOST];
        if (!any_model_make(&s, seed, systems + k, true)) break;
        assert_true(s.nq <= ANY_MOST && mbsr_dae_size(s.m, MBSR_DAE_MOMENTUM) <= 6 * ANY_MOST);
        assert_ok(mbsr_data_create(s.m, &d, NULL), NULL);
        verdict v = report_at(&s, d, s.q, still);
        v.forward = mbsr_forward_dynamics(s.m, d, 0.0, s.q, still, NULL, udot);
        v.start = MBSR_NO_CONVERGENCE; /* if it is not asked for */
        if (v.elastic == 0 || elastic) find_start(&s, d, &v);
        check(&v);
        v.start = v.start != MBSR_OK;
        if (k == 0) first = v;
        assert_memory_equal(&v, &first, sizeof v);
        mbsr_data_destroy(d);
        mbsr_model_destroy(s.m);
        made = true;
    }
    return made;
}

static void check_rich_seeds(size_t count, const uint64_t *seed)
{
    for (size_t k = 0; k < count; k += (size_t)test_seeds(2, 1))
        assert_true(check_rich(seed[k], true));
}

static void rich_verdicts_agree(void **state)
{
    (void)state;
    int models = 0;
    const int seeds = test_long() ? 40 : test_seeds_short(5, 10);
    for (uint64_t seed = 1; seed <= (uint64_t)seeds; ++seed) models += check_rich(seed, false);
    assert_true(models > seeds / 2);
}

/* Rigid rows that depend on each other beside springs that bear no part of what they share. */
static void springs_beside_redundant_rows(void **state)
{
    (void)state;
    static const uint64_t seed[] = {44961, 56989, 45295, 49563, 58845};
    check_rich_seeds(test_long() ? 5 : 3, seed);
}

/* Stops that let go where what they push balances; directions that nothing determines at the state
 * given, or at all that it leads to alone; balances at 1e51 rad/s. */
static void stops_that_let_go(void **state)
{
    (void)state;
    static const uint64_t seed[] = {410032, 430151, 430410, 410142, 431149,
                                    431451, 431012, 410268, 420088};
    check_rich_seeds(test_long() ? 9 : 6, seed);
}

/* Masses that lose rank where loops close: beside that position rows are met once accelerations are
 * refined. */
static void masses_at_the_closed_position(void **state)
{
    (void)state;
    check_seeds(1, (const uint64_t[]){301485});
    assert_true(check_rich(720233, true));
}

/* Friction that slips at three joints and resists one direction so little that it is nearly all of
 * those that take a single damper each. */
static void directions_that_look_alike(void **state)
{
    (void)state;
    assert_true(check_rich(430942, true));
}

/* What rounding alone holds, or nothing at the forces that act, has no accelerations either. */
static void completions_of_undetermined_models(void **state)
{
    (void)state;
    static const struct {
        uint64_t seed;
        bool rich;
    } model[] = {{991376, false}, {991238, false}, {991338, true}, {991710, true}, {992197, true}};
    static const double still[ANY_MOST] = {0.0};
    for (size_t k = 0; k < sizeof model / sizeof model[0]; ++k) {
        for (size_t l = 0; l < sizeof systems / sizeof systems[0]; ++l) {
            any_model s;
            mbsr_data *d;
            mbsr_completion *completion;
            double udot[ANY_MOST];
            assert_true(any_model_make(&s, model[k].seed, systems + l, model[k].rich));
            assert_ok(mbsr_data_create(s.m, &d, NULL), NULL);
            assert_ok(mbsr_completion_create(s.m, NULL, &completion, NULL), NULL);
            const int status =
                mbsr_completion_dynamics(completion, d, 0.0, s.q, still, NULL, udot, NULL);
            assert_true(status == MBSR_UNDETERMINED || status == MBSR_NO_CONVERGENCE);
            mbsr_completion_destroy(completion);
            mbsr_data_destroy(d);
            mbsr_model_destroy(s.m);
        }
    }
}

/* Joints all of whose directions move mass are to stay where they are. */
static int start_with_kept(const any_model *s)
{
    mbsr_data *d;
    const double none[ANY_MOST] = {0.0};
    int keep[ANY_MOST] = {0};
    mbsr_consistent_opt opt = mbsr_default_consistent_opt();
    double y[6 * ANY_MOST], yp[6 * ANY_MOST];
    opt.keep_position = keep;
    assert_ok(mbsr_data_create(s->m, &d, NULL), NULL);
    assert_ok(mbsr_stage_positions(s->m, d, 0.0, s->q), mbsr_data_error(d));
    assert_ok(mbsr_stage_velocities(s->m, d, none), mbsr_data_error(d));
    assert_ok(mbsr_stage_forces(s->m, d, NULL), mbsr_data_error(d));
    assert_ok(mbsr_stage_backward(s->m, d), mbsr_data_error(d));
    for (int i = 0; i < s->bodies; ++i) {
        mbsr_rank_info info;
        assert_ok(mbsr_body_rank(s->m, d, i, &info), mbsr_data_error(d));
        for (int k = 0; k < s->n[i] && info.rank == s->n[i]; ++k) keep[s->first[i] + k] = 1;
    }
    assert_ok(mbsr_dae_pack(s->m, d, MBSR_DAE_MOMENTUM, 0.0, s->q, none, y), mbsr_data_error(d));
    const int status = mbsr_dae_consistent(s->m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, &opt, NULL);
    mbsr_data_destroy(d);
    return status;
}

static void places_that_are_kept(void **state)
{
    (void)state;
    static const uint64_t seed[] = {123, 243, 276};
    for (size_t k = 0; k < sizeof seed / sizeof seed[0]; ++k) {
        for (size_t l = 0; l < sizeof systems / sizeof systems[0]; ++l) {
            any_model s;
            assert_true(any_model_make(&s, seed[k], systems + l, false));
            assert_int_equal(start_with_kept(&s), MBSR_OK);
            mbsr_model_destroy(s.m);
        }
    }
}

/* Balances at rest, whose velocities are rounding of differences of forces. */
static void balances_at_rest(void **state)
{
    (void)state;
    static const uint64_t seed[] = {431374, 431092};
    check_seeds(2, (const uint64_t[]){331507, 811819});
    check_rich_seeds(2, seed);
}

/* Rows left to others where some directions move no mass: u' of the completion, which solutions at
 * finite c had wrong by 3e-6. */
static void rows_left_to_others(void **state)
{
    (void)state;
    check_seeds(1, (const uint64_t[]){610485});
}

/* Loops hardly hold what moves no mass: rounding of loop forces would be accelerations, wrong by
 * 3e-4. */
static void directions_hardly_held(void **state)
{
    (void)state;
    check_seeds(2, (const uint64_t[]){810551, 815191});
}

/* What nothing determines at the state given, but traces of rounding in rows, in springs' balance
 * with weights, or in one matrix of many. */
static void traces_that_determine_nothing(void **state)
{
    (void)state;
    check_seeds(test_long() ? 3 : 2, (const uint64_t[]){813029, 813532, 815161});
}

/* Friction that slips and cannot bear what it would have to: no velocity balances it, also where
 * joints of which some directions move mass are pushed in other units of time. */
static void friction_that_is_not_enough(void **state)
{
    (void)state;
    check_rich_seeds(2, (const uint64_t[]){720283, 430617});
}

/* Loops hold all that moves no mass; motions are rounding, and so is whether they grow. */
static void loops_that_hold_everything(void **state)
{
    (void)state;
    check_seeds(1, (const uint64_t[]){520663});
}

/* Loop forces of a trillionth of what acts, or nothing, as rounding has it. */
static void loop_forces_that_are_traces(void **state)
{
    (void)state;
    check_seeds(2, (const uint64_t[]){811077, 812253});
    assert_true(check_rich(720331, true));
}

/* Cranks at dead centre, rows that depend on others at one position alone, and rows of which
 * rounding is all there is: Newton's matrix is singular in all units, and starts go without them.
 */
static void positions_that_are_singular(void **state)
{
    (void)state;
    static const uint64_t seed[] = {620753, 812343, 820913, 822429, 823661,
                                    900015, 900483, 910285, 910967, 915009};
    check_seeds(10, seed);
    assert_true(check_rich(510033, true));
    assert_true(check_rich(530043, true));
    assert_true(check_rich(850357, true));
}

/* What masses leave of a row is far smaller than what bodies without mass read beside it, and
 * nothing cancels in it: far out too Newton's matrix is regular. */
static void masses_far_out(void **state)
{
    (void)state;
    check_seeds(1, (const uint64_t[]){821113});
    assert_true(check_rich(720361, true));
}

/* Newton's method stops where springs lose their stiffness: what follows their slope comes to rest,
 * or finds that nothing is balanced there, in all units. */
static void balances_down_the_slope(void **state)
{
    (void)state;
    static const uint64_t seed[] = {310900, 845000, 842266, 621158, 876115, 881832};
    check_seeds(test_long() ? 6 : 3, seed);
    assert_true(check_rich(720398, true));
    assert_true(check_rich(861754, true));
}

/* Directions that nothing holds but loop forces, by the way these turn: a start knows them from the
 * beginning. */
static void held_by_loop_forces_alone(void **state)
{
    (void)state;
    static const uint64_t seed[] = {620203, 826473, 828317, 826755, 842245};
    check_seeds(test_long() ? 5 : 4, seed);
    if (test_long()) assert_true(check_rich(520001, true));
}

/* Forces of rows that depend on each other hold nothing, and what springs come to hold where they
 * settle is undetermined at the state given. */
static void held_by_nothing(void **state)
{
    (void)state;
    static const uint64_t seed[] = {894061};
    check_seeds(1, seed);
    assert_true(check_rich(886155, true));
}

/* Stiff rows that depend on others, all of which share what bodies without mass exert: the same
 * start in all units. */
static void stiff_rows_that_share(void **state)
{
    (void)state;
    motion found[sizeof systems / sizeof systems[0]];
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        any_model s;
        mbsr_data *d;
        double still[ANY_MOST] = {0.0}, y[6 * ANY_MOST] = {0.0}, yp[6 * ANY_MOST];
        assert_true(any_model_make(&s, 850463, systems + k, true));
        assert_true(mbsr_dae_size(s.m, MBSR_DAE_MOMENTUM) <= 6 * ANY_MOST);
        assert_ok(mbsr_data_create(s.m, &d, NULL), NULL);
        assert_ok(mbsr_dae_pack(s.m, d, MBSR_DAE_MOMENTUM, 0.0, s.q, still, y), NULL);
        assert_ok(mbsr_dae_consistent(s.m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(d));
        note_motion(&s, y, yp, found + k);
        assert_less(apart(s.nu, found[k].u, found[0].u, 1.0), 1e-8);
        assert_less(apart(s.nu, found[k].udot, found[0].udot, 1.0), 1e-6);
        mbsr_data_destroy(d);
        mbsr_model_destroy(s.m);
    }
}

/* Rows whose ranks fronts have no digits for: matrices tell them, the same in all units. */
static void ranks_that_fronts_lose(void **state)
{
    (void)state;
    check_seeds(1, (const uint64_t[]){200085});
    int first[2] = {0, 0};
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        any_model s;
        mbsr_data *d;
        mbsr_closure_report report;
        int redundant[ANY_MOST * 6], unique[ANY_MOST * 6], dropped = 0, alone = 0;
        assert_true(any_model_make(&s, 200085, systems + k, false));
        assert_ok(mbsr_data_create(s.m, &d, NULL), NULL);
        assert_ok(mbsr_closures_report(s.m, d, 0.0, s.q, &report, redundant, unique),
                  mbsr_data_error(d));
        for (int j = 0; j < mbsr_model_rows(s.m); ++j) {
            dropped += redundant[j];
            alone += unique[j];
            assert_false(redundant[j] && unique[j]);
        }
        assert_int_equal(report.nearby + dropped, mbsr_model_rows(s.m));
        if (k == 0) first[0] = dropped, first[1] = alone;
        assert_int_equal(dropped, first[0]);
        assert_int_equal(alone, first[1]);
        mbsr_data_destroy(d);
        mbsr_model_destroy(s.m);
    }
}

/* Ranks at the state that the states around it do not have: nothing goes on from there, and a start
 * refuses it as the report does. */
static void ranks_of_one_state_alone(void **state)
{
    (void)state;
    static const uint64_t seed[] = {200002, 200564, 201388};
    for (size_t k = 0; k < 3 * sizeof systems / sizeof systems[0]; ++k) {
        any_model s;
        mbsr_data *d;
        double still[ANY_MOST] = {0.0}, y[6 * ANY_MOST], yp[6 * ANY_MOST];
        assert_true(any_model_make(&s, seed[k % 3], systems + k / 3, true));
        assert_true(mbsr_dae_size(s.m, MBSR_DAE_MOMENTUM) <= 6 * ANY_MOST);
        assert_ok(mbsr_data_create(s.m, &d, NULL), NULL);
        assert_int_equal(report_at(&s, d, s.q, still).report, MBSR_RANK_CHANGED);
        assert_ok(mbsr_dae_pack(s.m, d, MBSR_DAE_MOMENTUM, 0.0, s.q, still, y), NULL);
        assert_int_equal(mbsr_dae_consistent(s.m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                         MBSR_RANK_CHANGED);
        mbsr_data_destroy(d);
        mbsr_model_destroy(s.m);
    }
}

static void add_behind(any_model *s, mbsr_joint joint, mbsr_inertia inertia)
{
    mbsr_body_def body = mbsr_default_body_def();
    body.parent = s->bodies++ - 1;
    body.joint = joint;
    body.inertia = inertia;
    assert_ok(mbsr_model_add_body(s->m, &body, NULL), mbsr_model_error(s->m));
}

/* One point mass, 1e-5 beside an axis and as close to what the joints before leave free: it moves
 * in three directions, of twelve, however rounding has grown on the way. */
static void a_mass_close_to_axes(void **state)
{
    (void)state;
    static const double slant[3] = {0.6, 0.8, 0.0}, upright[3] = {0.0, 0.0, 1.0};
    for (size_t k = 0; k < sizeof systems / sizeof systems[0]; ++k) {
        const double L = systems[k].length, point[3] = {1e-5 * L, 0.0, 0.7 * L},
                     q[13] = {L,
                              0.2,
                              0.4,
                              0.4,
                              0.8,
                              0.0,
                              -0.4 * L,
                              0.7 * L,
                              0.0,
                              -0.4 * L,
                              2.060753653048625,
                              0.0,
                              1.5707963267948966},
                     u[12] = {0.0};
        const mbsr_frame first = mbsr_frame_at(0.0, -L, 0.75 * L),
                         last = mbsr_frame_at(0.75 * L, -0.4 * L, 0.7 * L);
        mbsr_frame second = mbsr_frame_identity(), third = mbsr_frame_at(0.5 * L, -L, -L);
        assert_ok(mbsr_quaternion_rotation((double[4]){11.0, 1.0, 0.0, 0.0}, second.R), NULL);
        assert_ok(mbsr_quaternion_rotation((double[4]){5.0, 0.0, 1.0, 0.0}, third.R), NULL);
        any_model s = {.of = systems + k};
        mbsr_data *d;
        mbsr_index_report *report;
        assert_ok(mbsr_model_create(NULL, &s.m, NULL), NULL);
        const mbsr_inertia none = mbsr_inertia_zero();
        add_behind(&s, mbsr_joint_prismatic(&first, NULL, slant), none);
        add_behind(&s, mbsr_joint_free(&second, NULL), none);
        add_behind(&s, mbsr_joint_in_plane(&third, NULL), none);
        add_behind(&s, mbsr_joint_universal(&last, NULL, slant, upright),
                   mbsr_inertia_point_mass(0.154 * systems[k].mass, point));
        assert_ok(mbsr_model_finish(s.m), mbsr_model_error(s.m));
        assert_ok(mbsr_data_create(s.m, &d, NULL), NULL);
        assert_ok(mbsr_index_report_create(s.m, d, 0.0, q, u, &report), mbsr_data_error(d));
        assert_int_equal(report->dynamic, 3);
        assert_int_equal(report->undetermined, 9);
        mbsr_index_report_destroy(s.m, report);
        mbsr_data_destroy(d);
        mbsr_model_destroy(s.m);
    }
}

/* A particle between two distances along one line, on its way across it: nothing else tells a
 * time, and rows ask for accelerations to either side. */
static void accelerations_that_contradict(void **state)
{
    (void)state;
    static const units beside[] = {{"m, kg, ms", 1, 1, 1e3}, {"m, kg, us", 1, 1, 1e6}};
    const size_t others = sizeof beside / sizeof beside[0];
    for (size_t k = 0; k < others + sizeof systems / sizeof systems[0]; ++k) {
        const units *of = k < others ? beside + k : systems + (k - others);
        const double L = of->length, far[3] = {3.0 * L, 0.0, 0.0}, q[3] = {L},
                     u[3] = {0.0, 0.1 * L / of->time};
        double udot[3], y[32] = {0.0}, yp[32];
        any_model s = {.of = of};
        mbsr_data *d;
        assert_ok(mbsr_model_create(NULL, &s.m, NULL), NULL);
        add_behind(&s, mbsr_joint_translational(NULL, NULL), mbsr_inertia_particle(2.0 * of->mass));
        const mbsr_closure_def near = mbsr_closure_distance(0, NULL, MBSR_GROUND, NULL, L),
                               other = mbsr_closure_distance(0, NULL, MBSR_GROUND, far, 2.0 * L);
        assert_ok(mbsr_model_add_closure(s.m, &near, NULL), mbsr_model_error(s.m));
        assert_ok(mbsr_model_add_closure(s.m, &other, NULL), mbsr_model_error(s.m));
        assert_ok(mbsr_model_finish(s.m), mbsr_model_error(s.m));
        assert_ok(mbsr_data_create(s.m, &d, NULL), NULL);
        assert_int_equal(mbsr_forward_dynamics(s.m, d, 0.0, q, u, NULL, udot), MBSR_LOOP_OPEN);
        assert_true(mbsr_dae_size(s.m, MBSR_DAE_MOMENTUM) <= 32);
        assert_ok(mbsr_dae_pack(s.m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), NULL);
        assert_int_equal(mbsr_dae_consistent(s.m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                         MBSR_LOOP_OPEN);
        assert_ok(mbsr_forward_dynamics(s.m, d, 0.0, q, (double[3]){0.0}, NULL, udot),
                  mbsr_data_error(d));
        assert_true(udot[0] == 0.0 && udot[1] == 0.0 && udot[2] == 0.0);
        mbsr_data_destroy(d);
        mbsr_model_destroy(s.m);
    }
}

/* Springs settle at once, beside dampers whose forces change: the accelerations of both are those
 * of the completion, whose c is another. */
static void springs_beside_dampers(void **state)
{
    (void)state;
    static const uint64_t seed[] = {890550, 890794, 895899};
    for (size_t k = 0; k < sizeof seed / sizeof seed[0]; ++k) {
        any_model s;
        mbsr_data *d;
        double still[ANY_MOST] = {0.0}, y[4 * ANY_MOST] = {0.0}, yp[4 * ANY_MOST];
        assert_true(any_model_make(&s, seed[k], systems, false));
        assert_ok(mbsr_data_create(s.m, &d, NULL), NULL);
        assert_ok(mbsr_dae_pack(s.m, d, MBSR_DAE_MOMENTUM, 0.0, s.q, still, y), NULL);
        assert_ok(mbsr_dae_consistent(s.m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL),
                  mbsr_data_error(d));
        check_dynamics(&s, d, y, yp, 3e-8);
        mbsr_data_destroy(d);
        mbsr_model_destroy(s.m);
    }
}

/* Velocities that at one c get no better by rounding, and at another do. */
static void rounding_at_one_c(void **state)
{
    (void)state;
    static const uint64_t seed[] = {890114};
    check_seeds(1, seed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(verdicts_agree),
                                       cmocka_unit_test(rounding_at_one_c),
                                       cmocka_unit_test(accelerations_that_contradict),
                                       cmocka_unit_test(springs_beside_dampers),
                                       cmocka_unit_test(rows_that_see_traces),
                                       cmocka_unit_test(weights_that_do_not_move),
                                       cmocka_unit_test(masses_without_radius),
                                       cmocka_unit_test(nothing_left_to_move),
                                       cmocka_unit_test(loops_without_load),
                                       cmocka_unit_test(balances_of_moments),
                                       cmocka_unit_test(balances_by_the_same_way),
                                       cmocka_unit_test(balances_down_the_slope),
                                       cmocka_unit_test(held_by_loop_forces_alone),
                                       cmocka_unit_test(held_by_nothing),
                                       cmocka_unit_test(a_mass_close_to_axes),
                                       cmocka_unit_test(fast_dampers_beside_loops),
                                       cmocka_unit_test(balances_at_rest),
                                       cmocka_unit_test(places_that_are_kept),
                                       cmocka_unit_test(rows_left_to_others),
                                       cmocka_unit_test(directions_hardly_held),
                                       cmocka_unit_test(traces_that_determine_nothing),
                                       cmocka_unit_test(friction_that_is_not_enough),
                                       cmocka_unit_test(loops_that_hold_everything),
                                       cmocka_unit_test(stiff_rows_that_share),
                                       cmocka_unit_test(positions_that_are_singular),
                                       cmocka_unit_test(masses_far_out),
                                       cmocka_unit_test(ranks_that_fronts_lose),
                                       cmocka_unit_test(loop_forces_that_are_traces),
                                       cmocka_unit_test(balances_out_of_reach),
                                       cmocka_unit_test(stops_that_let_go),
                                       cmocka_unit_test(completions_of_undetermined_models),
                                       cmocka_unit_test(masses_at_the_closed_position),
                                       cmocka_unit_test(directions_that_look_alike),
                                       cmocka_unit_test(rich_verdicts_agree),
                                       cmocka_unit_test(springs_beside_redundant_rows),
                                       cmocka_unit_test(ranks_of_one_state_alone)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
