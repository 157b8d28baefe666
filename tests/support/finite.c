/* No number that is not finite with MBSR_OK.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "finite.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 4096 };

static const double evils[] = {NAN,   INFINITY, -INFINITY, 1e200,  -1e200,
                               1e154, -3e160,   1e308,     -1e308, DBL_MAX};
enum { EVILS = sizeof evils / sizeof evils[0] };

typedef struct result {
    int status;
    double out[FINITE_OUTPUTS][MOST];
} result;

void finite_give(finite_subject *s, finite_input input, int n, const double *x)
{
    s->in[input] = malloc(sizeof(double) * (size_t)(n > 0 ? n : 1));
    assert_non_null(s->in[input]);
    if (n > 0) memcpy(s->in[input], x, sizeof(double) * (size_t)n);
    s->length[input] = n;
}

void finite_free(finite_subject *s)
{
    for (int k = 0; k < FINITE_INPUTS; ++k) free(s->in[k]);
    assert_int_equal(s->complaints, 0);
}

static int length_of(const finite_subject *s, const finite_row *row, int output)
{
    const int n = row->length ? row->length(s, output) : 0;
    assert_true(n <= MOST);
    return n;
}

/* Where no good call wrote, the results are those of NaN. */
static void call(finite_subject *s, const finite_row *row, result *r)
{
    for (int o = 0; o < FINITE_OUTPUTS; ++o) {
        if (s->out[o]) s->out[o] = r->out[o];
        for (int k = 0; k < length_of(s, row, o); ++k) r->out[o][k] = NAN;
    }
    if (row->prepare) (void)row->prepare(s);
    r->status = row->run(s);
}

/* The first of a function is enough. */
static void complain(finite_subject *s, const finite_row *row, const char *where, double evil,
                     const char *what, const char *text)
{
    if (s->complained == row->function) return;
    s->complained = row->function;
    ++s->complaints;
    print_error("%s, %s, %s = %g: %s\n    \"%s\"\n", row->function, s->name, where, evil, what,
                text ? text : "");
}

static bool names_something(const char *text)
{
    static const char *const words[] = {"mbsr_", "body ", "root", "force ", "closure ", "state "};
    for (size_t k = 0; k < sizeof words / sizeof words[0]; ++k) {
        if (strstr(text, words[k])) return true;
    }
    return false;
}

/* A refusal that says what of, or finite numbers. */
static void check(finite_subject *s, const finite_row *row, const result *r, const char *where,
                  double evil)
{
    if (r->status != MBSR_OK) {
        if (s->error ? !s->object : !s->data) return; /* what carries the text is NULL */
        const mbsr_error *error = s->error ? s->error(s) : mbsr_data_error(s->data);
        if (error->status != r->status)
            complain(s, row, where, evil, mbsr_status_name(r->status), error->text);
        if (!names_something(error->text))
            complain(s, row, where, evil, "the text names nothing", error->text);
        return;
    }
    for (int o = 0; o < FINITE_OUTPUTS; ++o) {
        for (int k = 0; s->out[o] && k < length_of(s, row, o); ++k) {
            if (!isfinite(r->out[o][k]))
                complain(s, row, where, evil, "MBSR_OK with a number that is not finite", NULL);
        }
    }
}

/* A good call gives the same bits as before. */
static void good_again(finite_subject *s, const finite_row *row, const result *good,
                       const char *where, double evil)
{
    static result again;
    call(s, row, &again);
    if (again.status != good->status)
        complain(s, row, where, evil, "another status of a good call afterwards", NULL);
    for (int o = 0; o < FINITE_OUTPUTS && good->status == MBSR_OK; ++o) {
        const size_t size = sizeof(double) * (size_t)length_of(s, row, o);
        if (memcmp(again.out[o], good->out[o], size) != 0)
            complain(s, row, where, evil, "other numbers of a good call afterwards", NULL);
    }
}

static void spoil(finite_subject *s, const finite_row *row, finite_input input, const result *good)
{
    static const char *const names[] = {"t",    "c", "q",  "u", "tau",
                                        "udot", "y", "yp", "r", "another input"};
    static result r;
    const int n = s->length[input];
    double held[MOST];
    memcpy(held, s->in[input], sizeof(double) * (size_t)n);
    for (int k = 0; k <= n; ++k) { /* k = n: all of them */
        if (k == n && n < 2) break;
        for (int e = 0; e < EVILS; ++e) {
            for (int l = 0; l < n; ++l) {
                if (k == l || k == n) s->in[input][l] = evils[e];
            }
            call(s, row, &r);
            check(s, row, &r, names[input], evils[e]);
            memcpy(s->in[input], held, sizeof(double) * (size_t)n);
        }
        good_again(s, row, good, names[input], evils[0]);
    }
}

/* An input, an output or an object that is NULL. */
static void without(finite_subject *s, const finite_row *row, void *pointer, const result *good,
                    const char *where)
{
    static result r;
    void *held, *const none = NULL;
    if (row->prepare) (void)row->prepare(s);
    for (int o = 0; o < FINITE_OUTPUTS; ++o) {
        if (s->out[o]) s->out[o] = r.out[o];
        for (int k = 0; k < length_of(s, row, o); ++k) r.out[o][k] = NAN;
    }
    memcpy(&held, pointer, sizeof held);
    memcpy(pointer, &none, sizeof held);
    r.status = row->run(s);
    check(s, row, &r, where, 0.0);
    memcpy(pointer, &held, sizeof held);
    good_again(s, row, good, where, 0.0);
}

static void without_each(finite_subject *s, const finite_row *row, const result *good)
{
    for (int k = FINITE_Q; k < FINITE_INPUTS; ++k) {
        if (!(row->in & 1u << k)) continue;
        without(s, row, (s->in + k), good, "an input that is NULL");
    }
    for (int o = 0; o < FINITE_OUTPUTS; ++o) {
        if (s->out[o]) without(s, row, (s->out + o), good, "an output that is NULL");
    }
    if (row->objects & FINITE_MODEL) without(s, row, &s->model, good, "a model that is NULL");
    if (row->objects & FINITE_DATA) without(s, row, &s->data, good, "a data that is NULL");
    if (row->objects & FINITE_OBJECT) without(s, row, &s->object, good, "an object that is NULL");
}

int finite_try(finite_subject *s, const finite_row *row)
{
    static result good;
    if (!row->run) return 0;
    for (int o = 0; o < FINITE_OUTPUTS; ++o)
        s->out[o] = length_of(s, row, o) > 0 ? good.out[o] : NULL;
    call(s, row, &good);
    check(s, row, &good, "good inputs", 0.0);
    for (int k = 0; k < FINITE_INPUTS; ++k) {
        if ((row->state | row->in) & 1u << k) spoil(s, row, (finite_input)k, &good);
    }
    without_each(s, row, &good);
    return good.status == MBSR_OK;
}
