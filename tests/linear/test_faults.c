/* Every allocation of calls that make something fails in turn, and every function of the caller's:
 * it is said, and nothing is lost.
 * SPDX-License-Identifier: BSD-3-Clause
 *
 * The linker puts the functions below in the place of malloc, calloc and realloc (--wrap). */
#include "build.h"

#include <mbsrank/linear.h>

#include <stdbool.h>
#include <stdlib.h>

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void __real_free(void *memory);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void __wrap_free(void *memory);

static long calls, live, fail_at;

static bool fails(void)
{
    return ++calls == fail_at;
}

static void *given(void *memory)
{
    live += memory != NULL;
    return memory;
}

void *__wrap_malloc(size_t size)
{
    return fails() ? NULL : given(__real_malloc(size));
}

void *__wrap_calloc(size_t count, size_t size)
{
    return fails() ? NULL : given(__real_calloc(count, size));
}

void *__wrap_realloc(void *memory, size_t size)
{
    if (fails()) return NULL;
    return memory ? __real_realloc(memory, size) : given(__real_realloc(memory, size));
}

void __wrap_free(void *memory)
{
    live -= memory != NULL;
    __real_free(memory);
}

/* ---- functions of the caller's: the k-th call says `with`, and those behind it, too ---- */

static long asked, says_at, all_asked;
static int with;

static int says(void)
{
    return ++asked >= says_at && says_at > 0 ? with : 0;
}

static int law(void *user, double x, double v, double *force, double *energy, double *power)
{
    (void)user;
    *force = 5.0 * (x - 0.4) + 0.1 * v;
    if (energy) *energy = 2.5 * (x - 0.4) * (x - 0.4);
    if (power) *power = 0.1 * v * v;
    return says();
}

static int stay(void *user, double t, double *s, double *sdot, double *sddot)
{
    (void)user, (void)t;
    for (int k = 0; k < 2; ++k) s[k] = sdot[k] = sddot[k] = 0.0;
    return says();
}

static const mbsr_spring own = {.function = law};

enum { RATES = 5 };

typedef struct scene {
    mbsr_model *model;
    mbsr_data *data;
    mbsr_parameters *list;
    double q[RATES], u[RATES], more[4 * RATES * RATES];
} scene;

typedef int (*action)(scene *s, mbsr_error *error);

static int rests(scene *s, mbsr_error *error)
{
    return mbsr_equilibrium(s->model, s->data, 0.0, s->q, NULL, s->more, NULL, NULL, error);
}

static int is_linear(scene *s, mbsr_error *error)
{
    mbsr_linear *l;
    mbsr_mode mode[2 * RATES];
    int count;
    int status = mbsr_linear_create(s->model, s->data, 0.0, s->q, NULL, NULL, &l, error);
    if (!status) status = mbsr_linear_modes(l, mode, &count);
    if (!status) status = mbsr_linear_shape(l, 0, s->more, s->more + RATES);
    if (!status) status = mbsr_linear_response(l, 1.0, s->more, s->more + RATES);
    mbsr_linear_destroy(l);
    return status;
}

static int has_modes(scene *s, mbsr_error *error)
{
    mbsr_mode mode;
    mbsr_near_opt opt = mbsr_default_near_opt();
    int found;
    opt.count = 1;
    return mbsr_modes_near(s->model, s->data, 0.0, s->q, &opt, &mode, &found, NULL, NULL, error);
}

static int takes_part(scene *s, mbsr_error *error)
{
    const mbsr_mode mode = {.frequency = 1.0};
    return mbsr_mode_participation(s->model, s->data, 0.0, s->q, &mode, s->u, s->u, s->more,
                                   s->more + RATES, s->more + 2 * RATES, error);
}

static int is_trimmed(scene *s, mbsr_error *error)
{
    const int which = mbsr_parameters_find(s->list, "forces.force0.free_length");
    mbsr_trim_opt opt = mbsr_default_trim_opt();
    double value;
    opt.held = 1;
    opt.hold = (const int[]){0};
    return mbsr_trim(s->list, 0.0, s->q, 1, &which, &opt, s->more, &value, NULL, error);
}

static int has_derivatives(scene *s, mbsr_error *error)
{
    const int which = mbsr_parameters_find(s->list, "forces.force0.stiffness");
    mbsr_derivatives *by;
    int status = mbsr_derivatives_create(s->model, &by, error);
    if (!status) status = mbsr_derivatives_parameters(by, s->list, 1, &which);
    mbsr_derivatives_destroy(by);
    return status;
}

static int has_derivatives_in_batches(scene *s, mbsr_error *error)
{
    mbsr_derivatives_batch *batch;
    const int status = mbsr_derivatives_batch_create(s->model, NULL, &batch, error);
    mbsr_derivatives_batch_destroy(batch);
    return status;
}

static int has_parameters(scene *s, mbsr_error *error)
{
    mbsr_parameters *list;
    mbsr_data *data = NULL;
    const int which = 0;
    const double value = 1.5;
    int status = mbsr_parameters_create(s->model, &list, error);
    if (!status) status = mbsr_parameters_data(list, 1, &which, &value, &data, error);
    mbsr_data_destroy(data);
    mbsr_parameters_destroy(list);
    return status;
}

static int has_closed_loops(scene *s, mbsr_error *error)
{
    mbsr_closure_report report;
    (void)error;
    int status = mbsr_closures_report(s->model, s->data, 0.0, s->q, &report, NULL, NULL);
    if (!status) status = mbsr_assemble(s->model, s->data, 0.0, s->q, NULL, s->more, NULL);
    return status;
}

static int is_an_equation(scene *s, mbsr_error *error)
{
    mbsr_ode *ode;
    (void)error;
    const int status = mbsr_ode_create(s->model, s->data, 0.0, s->q, s->u, &ode);
    mbsr_ode_destroy(ode);
    return status;
}

/* Counts the allocations of a call that succeeds, then lets each of them fail. */
static void let_each_fail(scene *s, const char *name, action act)
{
    mbsr_error error = {0};
    const long before = calls, kept = live;
    fail_at = 0;
    assert_ok(act(s, &error), error.status ? &error : mbsr_data_error(s->data));
    const long count = calls - before;
    assert_int_equal(live, kept);
    assert_in_range(count, 1, 2000);
    for (long k = 1; k <= count; ++k) {
        fail_at = calls + k;
        const int status = act(s, &error);
        if (status != MBSR_ERR_NO_MEMORY)
            fail_msg("%s: allocation %ld of %ld fails: %s", name, k, count,
                     mbsr_status_name(status));
        assert_true(calls >= fail_at);
        assert_int_equal(live, kept);
    }
    fail_at = 0;
    asked = 0;
    assert_ok(act(s, &error), &error);
    assert_int_equal(live, kept);
    const long last = asked;
    all_asked += last;
    for (long k = 1; k <= last; k += 1 + k / 8) {
        with = k % 2 ? 41 : -41;
        asked = 0, says_at = k;
        const int status = act(s, &error);
        if (status != with)
            fail_msg("%s: call %ld of %ld says %d: %s (%d): %s", name, k, last, with,
                     mbsr_status_name(status), status, error.text);
        assert_int_equal(live, kept);
    }
    says_at = 0;
    assert_ok(act(s, &error), &error);
}

static mbsr_joint hinge(double x)
{
    return mbsr_joint_planar_revolute((mbsr_planar_frame){.x = x}, (mbsr_planar_frame){0});
}

static void ready(scene *s)
{
    mbsr_error error;
    s->data = finish(s->model);
    assert_ok(mbsr_parameters_create(s->model, &s->list, &error), &error);
}

static void done(scene *s)
{
    mbsr_parameters_destroy(s->list);
    free_both(s->model, s->data);
    assert_int_equal(live, 0);
}

/* A four-bar linkage on a spring. */
static void a_linkage(void **state)
{
    static const double end[3] = {1.0, 0, 0}, tip[3] = {0.9, 0, 0}, middle[2] = {0.45, 0.0};
    static const struct {
        const char *name;
        action act;
    } acts[] = {{"rests", rests},
                {"is_linear", is_linear},
                {"is_trimmed", is_trimmed},
                {"has_derivatives", has_derivatives},
                {"has_parameters", has_parameters},
                {"has_closed_loops", has_closed_loops},
                {"has_derivatives_in_batches", has_derivatives_in_batches}};
    (void)state;
    scene s = {.model = empty(), .q = {1.5, -1.2, 1.9}};
    add_body(s.model, MBSR_GROUND, "crank", hinge(0.0), mbsr_inertia_planar(1.0, middle, 0.1));
    add_body(s.model, 0, "coupler", hinge(0.8), mbsr_inertia_planar(1.5, middle, 0.1));
    add_body(s.model, MBSR_GROUND, "follower", hinge(1.2), mbsr_inertia_planar(2.0, middle, 0.1));
    add_force(s.model, mbsr_force_point_spring(MBSR_GROUND, NULL, 2, tip, 60.0, 2.0, 1.0));
    add_force(s.model, mbsr_force_gravity(0, -9.81, 0));
    add_force(s.model, mbsr_force_spring(MBSR_GROUND, NULL, 1, tip, &own));
    mbsr_closure_def pin = mbsr_closure_ball(1, end, 2, tip);
    pin.motion = stay;
    assert_ok(mbsr_model_add_closure(s.model, &pin, NULL), mbsr_model_error(s.model));
    ready(&s);
    for (size_t k = 0; k < sizeof acts / sizeof *acts; ++k)
        let_each_fail(&s, acts[k].name, acts[k].act);
    assert_true(all_asked > 250);
    done(&s);
}

/* Particles and nodes without mass on springs. */
static void a_string(void **state)
{
    static const struct {
        const char *name;
        action act;
    } acts[] = {{"rests", rests},
                {"has_modes", has_modes},
                {"takes_part", takes_part},
                {"is_an_equation", is_an_equation},
                {"has_derivatives", has_derivatives}};
    static const double wall[3] = {5.0, 0, 0};
    (void)state;
    scene s = {.model = empty(), .u = {0.1, 0.2, 0.3, 0.4, 0.5}};
    add_string(s.model, RATES, 0.7, 120.0);
    for (int k = 0; k < RATES; k += 2)
        add_force(s.model, mbsr_force_joint_spring(k, 0, 0.0, 1.0, 0.0));
    add_force(s.model, mbsr_force_spring(RATES - 1, NULL, MBSR_GROUND, wall, &own));
    ready(&s);
    for (size_t k = 0; k < sizeof acts / sizeof *acts; ++k)
        let_each_fail(&s, acts[k].name, acts[k].act);
    done(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_linkage),
        cmocka_unit_test(a_string),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
