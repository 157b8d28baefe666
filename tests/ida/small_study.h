/* What a report on small masses predicts against what two runs of the driver show.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SMALL_STUDY_H
#define TEST_SMALL_STUDY_H

#include "duration.h"
#include "expect.h"

#include <mbsrank/ida.h>

#include <math.h>
#include <stdlib.h>

enum { STUDY_MOST = 24, STUDY_POINTS = 200 };

typedef struct study {
    const mbsr_model *model;
    mbsr_small_masses_opt opt;
    mbsr_ida_opt ida;    /* tolerances for the steps */
    double fine;         /* these times as small for the errors ... */
    double least;        /* ... or, where that does not tell, down to so much */
    const double *q, *u; /* the start */
    double tolerance;    /* of one coordinate, where all have the same */
    double predicted, smooth_predicted, amplitude, saved; /* results: predictions, */
    double own, smooth_own;                               /* errors of the runs themselves */
    double measured, smooth; /* errors from the start given, and from the smooth start, */
    long full_steps, steps, smooth_steps;
    mbsr_small_verdict verdict; /* of the first mass */
} study;

typedef struct study_path {
    double q[STUDY_POINTS + 1][STUDY_MOST];
    long steps;
} study_path;

static inline study study_of(const mbsr_model *m, double duration, double time_scale)
{
    study s = {.model = m, .opt = mbsr_default_small_masses_opt(), .ida = mbsr_default_ida_opt()};
    s.opt.duration = duration;
    s.opt.time_scale = time_scale;
    s.fine = 1e-2;
    s.least = test_long() ? 1e-4 : s.fine;
    s.tolerance = s.opt.tolerance;
    return s;
}

/* Positions at times that are dense near the start; 0, or the status of a start that is refused. */
static inline int study_run(const study *s, const mbsr_model *m, const double *q, const double *u,
                            double factor, study_path *path)
{
    mbsr_data *d = NULL;
    mbsr_ida *ida = NULL;
    mbsr_error error = {0};
    const int nq = mbsr_model_nq(m), size = mbsr_dae_size(m, MBSR_DAE_MOMENTUM);
    double y[3 * STUDY_MOST], yp[3 * STUDY_MOST];
    assert_in_range(nq, 1, STUDY_MOST);
    assert_in_range(size, 1, 3 * STUDY_MOST);
    assert_ok(mbsr_data_create(m, &d, NULL), NULL);
    assert_ok(mbsr_dae_pack(m, d, MBSR_DAE_MOMENTUM, 0.0, q, u, y), mbsr_data_error(d));
    int status = mbsr_dae_consistent(m, d, MBSR_DAE_MOMENTUM, 0.0, y, yp, NULL, NULL);
    mbsr_ida_opt opt = s->ida;
    double *const tolerance[] = {&opt.rtol,        &opt.atol,          &opt.atol_angle,
                                 &opt.atol_length, &opt.atol_velocity, &opt.atol_angular_velocity};
    for (size_t k = 0; k < sizeof tolerance / sizeof tolerance[0]; ++k) *tolerance[k] *= factor;
    opt.max_steps = 10000000;
    if (!status) {
        assert_ok(mbsr_ida_create(m, d, &opt, &ida, &error), &error);
        assert_ok(mbsr_ida_start(ida, 0.0, y, yp), mbsr_ida_error(ida));
    }
    for (int k = 0; k <= STUDY_POINTS && !status; ++k) {
        const double t = s->opt.duration * pow((double)k / STUDY_POINTS, 3.0);
        assert_ok(mbsr_ida_advance(ida, t, NULL, y, NULL), mbsr_ida_error(ida));
        for (int l = 0; l < nq; ++l) path->q[k][l] = y[l];
    }
    mbsr_ida_stats stats = {0};
    if (!status) assert_ok(mbsr_ida_get_stats(ida, &stats), NULL);
    path->steps = stats.steps;
    mbsr_ida_destroy(ida);
    mbsr_data_destroy(d);
    return status;
}

static inline double study_allowed(const study *s, int l)
{
    return s->opt.tolerance_each ? s->opt.tolerance_each[l] : s->opt.tolerance;
}

/* Largest difference in tolerances of the coordinates. */
static inline double study_difference(const study *s, const study_path *a, const study_path *b)
{
    double most = 0.0;
    for (int k = 0; k <= STUDY_POINTS; ++k)
        for (int l = 0; l < mbsr_model_nq(s->model); ++l)
            most = fmax(most, fabs(a->q[k][l] - b->q[k][l]) / study_allowed(s, l));
    return most;
}

/* Positions of the model with all masses and without, from one start. */
typedef struct study_pair {
    study_path full, reduced;
} study_pair;

/* What of the difference of two runs is their own error: by how much it differs from that of a pair
 * that is coarser. Errors that both runs of a pair have alike do not count. */
static inline double study_own(const study *s, const study_pair *a, const study_pair *b)
{
    double most = 0.0;
    for (int k = 0; k <= STUDY_POINTS; ++k)
        for (int l = 0; l < mbsr_model_nq(s->model); ++l)
            most = fmax(most, fabs((a->full.q[k][l] - a->reduced.q[k][l]) -
                                   (b->full.q[k][l] - b->reduced.q[k][l])) /
                                  study_allowed(s, l));
    return most;
}

static inline mbsr_small_masses *study_begin(const study *s, const double *q, const double *u)
{
    mbsr_small_masses *small = NULL;
    mbsr_error error = {0};
    assert_ok(mbsr_small_masses_create(s->model, &s->opt, &small, &error), &error);
    assert_ok(mbsr_small_masses_start(small, 0.0, q, u), mbsr_small_masses_error(small));
    return small;
}

/* Gathers the report along a run of the reduced model. */
static inline mbsr_small_masses_report study_follow(const study *s, mbsr_small_masses *small,
                                                    long *steps)
{
    mbsr_small_masses_report report;
    mbsr_ida_stats stats;
    mbsr_error error = {0};
    assert_ok(mbsr_small_masses_run(small, &s->ida, s->opt.duration, &stats, &error), &error);
    assert_ok(mbsr_small_masses_get_report(small, &report), mbsr_small_masses_error(small));
    assert_true(report.factorisations <= 5);
    if (steps) *steps = stats.steps;
    return report;
}

static inline double study_amplitude(const mbsr_small_masses_report *report)
{
    double most = 0.0;
    for (int k = 0; k < report->masses; ++k) most = fmax(most, report->mass[k].amplitude);
    return most;
}

/* What is predicted from the start q, u. Returns the object, which has followed the run. */
static inline mbsr_small_masses *study_predict(study *s)
{
    mbsr_small_masses *small = study_begin(s, s->q, s->u);
    const mbsr_small_masses_report report = study_follow(s, small, &s->steps);
    s->predicted = report.share;
    s->amplitude = study_amplitude(&report);
    s->saved = report.steps;
    s->verdict = report.mass[0].verdict;
    return small;
}

/* The pair of runs from q, u and from the start of the reduced model near it. */
static inline void study_both(const study *s, const mbsr_small_masses *small, const double *q,
                              const double *u, double fine, study_pair *pair)
{
    const mbsr_model *m = mbsr_small_masses_reduced(small);
    double t, y[3 * STUDY_MOST], yp[3 * STUDY_MOST];
    assert_ok(mbsr_small_masses_state(small, &t, y, yp), NULL);
    assert_ok(study_run(s, s->model, q, u, fine, &pair->full), NULL);
    assert_ok(study_run(s, m, y, y + mbsr_model_nq(m) + mbsr_model_nu(m), fine, &pair->reduced),
              NULL);
}

/* The error of a zero by two runs, and what of it is their own: tolerances that are 100 times as
 * tight until that is below `enough`, or s->least is reached. */
static inline double study_measure(study *s, const mbsr_small_masses *small, const double *q,
                                   const double *u, double enough)
{
    static study_pair pair[2];
    double fine = 10.0 * s->fine;
    int last = 0;
    study_both(s, small, q, u, fine, pair);
    for (double by = 0.1;; by = 0.01) {
        fine *= by;
        last = 1 - last;
        study_both(s, small, q, u, fine, pair + last);
        s->own = study_own(s, pair, pair + 1);
        if (s->own <= enough || fine < 1.001 * s->least) break;
    }
    return study_difference(s, &pair[last].full, &pair[last].reduced);
}

/* Steps from the start given, errors from there and from the smooth start. */
static inline void study_whole(study *s)
{
    static study_path path;
    double q[STUDY_MOST], u[STUDY_MOST];
    mbsr_small_masses *small = study_predict(s);
    s->measured = study_measure(s, small, s->q, s->u, 0.3 * fmax(s->predicted, s->amplitude));
    assert_ok(study_run(s, s->model, s->q, s->u, 1.0, &path), NULL);
    s->full_steps = path.steps;
    assert_ok(mbsr_small_masses_smooth(small, 2, q, u), mbsr_small_masses_error(small));
    mbsr_small_masses_destroy(small);

    small = study_begin(s, q, u);
    s->smooth_predicted = study_follow(s, small, NULL).share;
    const double own = s->own;
    s->smooth = study_measure(s, small, q, u, 0.3 * s->smooth_predicted);
    s->smooth_own = s->own;
    s->own = own;
    mbsr_small_masses_destroy(small);
}

/* Errors within a factor 3; prints a row of the table in the documents. */
static inline void study_check_errors(const char *name, double mass, study *s)
{
    study_whole(s);
    const double all = fmax(s->predicted, s->amplitude);
    print_message("%-26s %7.0e  smooth %9.2e (predicted %9.2e, runs %7.0e)  given %9.2e (%9.2e, "
                  "%9.2e)  steps %6ld (%6.0f)  %s\n",
                  name, mass, s->smooth * s->tolerance, s->smooth_predicted * s->tolerance,
                  s->smooth_own * s->tolerance, s->measured * s->tolerance,
                  s->predicted * s->tolerance, s->amplitude * s->tolerance, s->full_steps,
                  (double)s->steps + s->saved, mbsr_small_verdict_text(s->verdict));
    assert_less(s->smooth - s->smooth_own, 3.0 * s->smooth_predicted);
    assert_less(s->smooth_predicted, 3.0 * (s->smooth + s->smooth_own));
    assert_less(s->measured - s->own, 3.0 * all);
    assert_less(all, 3.0 * (s->measured + s->own));
}

/* The same, and steps within a factor 2. */
static inline void study_check(const char *name, double mass, study *s)
{
    study_check_errors(name, mass, s);
    const double steps = (double)s->steps + s->saved;
    assert_less((double)s->full_steps, 2.0 * steps);
    assert_less(steps, 2.0 * (double)s->full_steps);
}

#endif
